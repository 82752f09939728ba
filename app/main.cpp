// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include "app/commands.hpp"

/// Idle threads of the OpenMP runtime spin for milliseconds by default, which makes a run on a machine that is busy with
/// something else many times slower. The runtime reads its settings when it is loaded, so the program starts itself anew
/// with a short spin, once, unless the user has chosen.
static void spin_briefly(char** argv) {
  if (std::getenv("OMP_WAIT_POLICY") || std::getenv("GOMP_SPINCOUNT")) return;
  setenv("GOMP_SPINCOUNT", "5000", 1);
  execv("/proc/self/exe", argv);  // returns only where it fails: the run goes on as it is
}

/// What one step gives back the next one asks for again: up to so much of it is kept, rather than mapped and cleared anew.
static void keep_what_is_freed() {
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, 4 << 20);
  mallopt(M_TRIM_THRESHOLD, 64 << 20);
#endif
}

int main(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is an error of the write, reported there
  spin_briefly(argv);
  keep_what_is_freed();
  return app::command_line(argc, argv);
}
