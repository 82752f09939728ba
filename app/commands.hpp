// SPDX-License-Identifier: Apache-2.0
// The command line (DESIGN, section 4): arguments to calls, errors to exit codes.
#pragma once

namespace app {

/// Exit code: 0 finished, 2 usage or case error, 3 stopped by a guard, 130 interrupted.
int command_line(int argc, char** argv);

}  // namespace app
