// SPDX-License-Identifier: Apache-2.0
// Writing while the run goes on: one task at a time on a thread of its own, on copies of what it writes. HDF5 knows no
// threads, so whoever else uses it waits for the task first.
#pragma once

#include <future>
#include <utility>

namespace app {

class Background {
 public:
  /// Runs `task` as soon as the one before is done. Throws what that one threw.
  template <class Task>
  void start(Task task) {
    wait();
    task_ = std::async(std::launch::async, std::move(task));
  }
  /// Until the last task is done. Throws what it threw, once.
  void wait() {
    if (task_.valid()) task_.get();
  }

 private:
  std::future<void> task_;
};

}  // namespace app
