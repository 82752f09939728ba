// SPDX-License-Identifier: Apache-2.0
// The exceptions of the project, and the exit codes they lead to.
#pragma once

#include <stdexcept>
#include <string>

namespace core {

/// Something the user gave cannot be used: file, line, key, value and what would be valid. Exit code 2.
struct CaseError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A guard stopped the run: what, where, the number and its limit, what to try. The state is saved first. Exit code 3.
struct GuardError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// There is no room for what was to be written. Whether a run can go on from what it has stored is for its end to say.
struct NoRoomError : GuardError {
  using GuardError::GuardError;
};

}  // namespace core
