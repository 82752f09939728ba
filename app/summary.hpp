// SPDX-License-Identifier: Apache-2.0
// summary.json and what is printed at the end of a run.
#pragma once

#include <string>

#include "app/simulation.hpp"
#include "measure/matter.hpp"

namespace app {

struct RunInfo {
  bool completed = false;
  std::string stop_reason;
  double wall_seconds = 0, cpu_seconds = 0;
  std::size_t elements = 0, particles = 0;  ///< alive at the end
};

/// DIR/summary.json, written to a temporary and renamed.
void write_summary(const std::string& dir, const Simulation& s, const measure::Result& result, const RunInfo& info);

/// Whether DIR/summary.json is there and of a run that reached its end time.
bool summary_is_complete(const std::string& dir);

/// Replaces the measurements in an existing summary.json.
void rewrite_measurements(const std::string& dir, const io::Case& spec, const measure::Result& result);

/// DIR/fragments.csv.
void write_fragments(const std::string& dir, const measure::Result& result);

/// A value as people write it: lengths in mm, angles in degrees, and so on; unit "bool": yes or no.
std::string readable(double value, const std::string& unit);

/// A table for people: measurements with their references, then the ledger.
std::string measurement_table(const io::Case& spec, const measure::Result& result);
std::string ledger_table(const Simulation& s);

double cpu_seconds();
double peak_memory();

}  // namespace app
