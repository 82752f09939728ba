// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>

#include "app/commands.hpp"

/// Idle threads of the OpenMP runtime spin for milliseconds by default, which makes a run on a machine that is busy with
/// something else many times slower. The runtime reads its settings when it is loaded, so the program starts itself anew
/// with a short spin, once, unless the user has chosen.
static void spin_briefly(char** argv) {
  if (std::getenv("OMP_WAIT_POLICY") || std::getenv("GOMP_SPINCOUNT")) return;
  setenv("GOMP_SPINCOUNT", "5000", 1);
  execv("/proc/self/exe", argv);  // returns only where it fails: the run goes on as it is
}

/// A closed screen's number would be given to the first file of results.
static void keep_screen_numbers() {
  for (int number = 0; number <= 2; ++number)
    if (fcntl(number, F_GETFD) < 0 && open("/dev/null", O_RDWR) != number) std::_Exit(3);
}

int main(int argc, char** argv) {
  keep_screen_numbers();
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is an error of the write, reported there
  spin_briefly(argv);
  return app::command_line(argc, argv);
}
