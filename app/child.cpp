// SPDX-License-Identifier: Apache-2.0
#include "app/child.hpp"

#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>

#include "core/error.hpp"

namespace app {

static volatile std::sig_atomic_t child_number = 0;
extern "C" void hand_on(int signal) { kill(child_number, signal); }

int run_child(const std::vector<std::string>& words) {
  std::fflush(stdout);
  std::vector<char*> argv;
  for (const auto& w : words) argv.push_back(const_cast<char*>(w.c_str()));
  argv.push_back(nullptr);

  constexpr std::array<int, 3> handed_on{SIGINT, SIGTERM, SIGHUP};
  sigset_t ours, before;
  sigemptyset(&ours);
  for (const int s : handed_on) sigaddset(&ours, s);
  sigprocmask(SIG_BLOCK, &ours, &before);  // until there is somebody to hand them on to
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setsigmask(&attributes, &before);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
  pid_t child = 0;
  const int failed = posix_spawnp(&child, argv[0], nullptr, &attributes, argv.data(), environ);
  posix_spawnattr_destroy(&attributes);
  std::array<struct sigaction, handed_on.size()> old{};
  if (failed == 0) {
    child_number = child;
    struct sigaction action {};
    action.sa_handler = hand_on;
    action.sa_flags = SA_RESTART;
    for (std::size_t k = 0; k < handed_on.size(); ++k) {
      sigaction(handed_on[k], nullptr, &old[k]);
      if (old[k].sa_handler != SIG_IGN) sigaction(handed_on[k], &action, nullptr);
    }
  }
  sigprocmask(SIG_SETMASK, &before, nullptr);
  if (failed != 0) return 127;
  int status = 0;
  siginfo_t ended;
  while (waitid(P_PID, static_cast<id_t>(child), &ended, WEXITED | WNOWAIT) != 0 && errno == EINTR) {
  }
  for (std::size_t k = 0; k < handed_on.size(); ++k) sigaction(handed_on[k], &old[k], nullptr);  // its number is still taken
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

void draw(const char* program, const std::vector<std::string>& arguments) {
  constexpr const char* of_the_system = "/usr/bin/python3";  // to which a distribution's packages belong
  std::vector<std::string> words{access(of_the_system, X_OK) == 0 ? of_the_system : "python3", "-c", program};
  words.insert(words.end(), arguments.begin(), arguments.end());
  if (const int code = run_child(words); code != 0)
    throw core::GuardError(fmt::format("nothing was drawn ({} ended with {}); pictures need Python 3 with NumPy, h5py and Matplotlib (Debian: "
                                       "apt-get install python3-numpy python3-h5py python3-matplotlib)", words[0], code));
}

}  // namespace app
