// SPDX-License-Identifier: Apache-2.0
// Runs side by side: what differs in their cases, how they ended and what they took, measurements, energies.
#pragma once

#include <string>
#include <vector>

namespace app {

/// A table for people of two or more output folders, from their summary.json and case.toml. Throws core::CaseError where one of those is
/// not there or is none.
std::string compare(const std::vector<std::string>& folders);

}  // namespace app
