// SPDX-License-Identifier: Apache-2.0
// The persistent state of a run, exactly: a run that goes on from a checkpoint gives the same bits as one that was never
// stopped. Search lists are not kept; they are made anew and hold the same pairs in the same order.
#pragma once

#include <string>

#include "app/simulation.hpp"
#include "io/archive.hpp"

namespace app {

void write_checkpoint(Simulation& s, const std::string& path);

/// The same, to be written later.
io::ArchiveCopy copy_state(Simulation& s);

/// Memory that the copy takes [bytes].
double state_bytes(Simulation& s);

/// Into a state freshly set up from the same case.
void read_checkpoint(Simulation& s, const std::string& path);

}  // namespace app
