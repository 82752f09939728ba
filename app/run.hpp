// SPDX-License-Identifier: Apache-2.0
// The time loop with everything around the step: output, history, checkpoints, progress, and how a run ends.
#pragma once

#include <string>
#include <vector>

#include "io/case.hpp"

namespace app {

/// A run into DIR; `force` allows DIR to hold an earlier one. Returns the exit code (0 finished, 3 stopped by a guard,
/// 130 interrupted). Throws core::CaseError before anything is written.
int run(const io::Case& spec, const std::string& dir, bool force);

/// Goes on from DIR's checkpoint.
int resume(const std::string& dir);

/// Measures DIR's last stored state again and rewrites the measurements in summary.json. Returns the table.
std::string measure_again(const std::string& dir);

/// Measures every stored state of DIR into DIR/measurements.csv: time_s,key,value,unit.
void measure_series(const std::string& dir);

}  // namespace app
