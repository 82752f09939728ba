// SPDX-License-Identifier: Apache-2.0
// Programs that this one starts and waits for: runs of a trade study, and Python for pictures.
#pragma once

#include <string>
#include <vector>

namespace app {

/// Starts words[0], a path or a name in PATH, with the other words, and waits for it. Returns its exit code, 128 and the signal's number
/// where a signal ended it, 127 where it cannot be started. SIGINT, SIGTERM and SIGHUP that arrive meanwhile are handed on to it.
int run_child(const std::vector<std::string>& words);

extern const char* const picture_program;        ///< tools/picture.py
extern const char* const trade_picture_program;  ///< tools/trade_picture.py

/// Has Python draw: one of the programs above with its arguments. Throws core::GuardError where nothing was drawn.
void draw(const char* program, const std::vector<std::string>& arguments);

}  // namespace app
