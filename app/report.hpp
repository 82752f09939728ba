// SPDX-License-Identifier: Apache-2.0
// What a run has found, for people: DIR/report.html and its pictures.
#pragma once

#include <string>

namespace app {

/// Draws DIR/cloud.png (six instants and the energy ledger, coloured by body) and DIR/speed.png (by speed), and writes DIR/report.html
/// with them: measurements beside their references, energy, fragments, cost, warnings, the resolved case. Returns what was written, for the
/// screen. Throws core::CaseError where DIR holds no run that has ended, and core::GuardError where nothing could be drawn; the report is then there without pictures.
std::string report(const std::string& dir);

}  // namespace app
