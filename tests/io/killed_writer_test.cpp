// SPDX-License-Identifier: Apache-2.0
// A run killed at any of its writes to run.h5 leaves all states that were there, and goes on. The writes of HDF5 pass
// through here and are counted: each of them is the last one of a program once.
#include <gtest/gtest.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <limits>

#include "io/snapshot.hpp"
#include "tests/io/example_snapshots.hpp"
#include "tests/io/temporary_folder.hpp"

namespace {

std::atomic<int> writes_left{std::numeric_limits<int>::max()};

ssize_t counted_write(int descriptor, const void* data, std::size_t bytes, off_t offset) {
  if (writes_left-- == 0) _exit(1);  // as by SIGKILL: nobody gets to close anything
  return syscall(SYS_pwrite64, descriptor, data, bytes, offset);
}

}  // namespace

extern "C" {
ssize_t pwrite(int descriptor, const void* data, std::size_t bytes, off_t offset) { return counted_write(descriptor, data, bytes, offset); }
ssize_t pwrite64(int descriptor, const void* data, std::size_t bytes, off_t offset) { return counted_write(descriptor, data, bytes, offset); }
}

namespace {

/// Whether the process that does it was killed at its write `n`.
bool killed_at_write(int n, const std::function<void()>& what) {
  const pid_t child = fork();
  if (child == 0) {
    writes_left = n;
    what();
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WEXITSTATUS(status) == 1;
}

std::vector<std::int64_t> steps_of(const std::string& dir) {
  std::vector<std::int64_t> steps;
  const std::size_t n = io::snapshot_times(dir).size();
  for (std::size_t k = 0; k < n; ++k) {
    const io::Snapshot s = io::read_snapshot(dir, static_cast<int>(k)), made = example::snapshot(s.step, 40, static_cast<int>(s.step));
    EXPECT_EQ(s.node_x, made.node_x);
    EXPECT_EQ(s.particle_v, made.particle_v);
    EXPECT_EQ(s.scalars, made.scalars);
    EXPECT_EQ(s.find("temperature")->particle, made.find("temperature")->particle);
    steps.push_back(s.step);
  }
  return steps;
}

void append(io::SnapshotWriter& writer, int step) { writer.append(example::snapshot(step, 40, step)); }

/// Does it to a run of the states 1 ... n killed at every write in turn; `steps` are those that it ends with when nobody
/// kills it. After each kill the run goes on at `time` and ends with them as well.
void kill_at_every_write(int n, double time, const std::function<void(io::SnapshotWriter&)>& what, const std::vector<std::int64_t>& steps) {
  const test::TemporaryFolder dir;
  {
    io::SnapshotWriter writer(dir / "run");
    for (int step = 1; step <= n; ++step) append(writer, step);
  }
  int kills = 0;
  for (bool killed = true; killed; kills += killed) {
    std::filesystem::remove_all(dir / "copy");
    std::filesystem::copy(dir / "run", dir / "copy");
    const auto go_on = [&] {
      auto writer = io::SnapshotWriter::reopen(dir / "copy", time);
      EXPECT_EQ(writer.note(), "") << "killed at write " << kills;
      what(writer);
    };
    killed = killed_at_write(kills, go_on);
    const auto there = steps_of(dir / "copy");
    for (int step = 1; step <= n && 1e-6 * step <= time; ++step)
      EXPECT_TRUE(std::ranges::count(there, step)) << "state " << step << " is lost by a kill at write " << kills;
    go_on();
    EXPECT_EQ(steps_of(dir / "copy"), steps) << "killed at write " << kills;
  }
  EXPECT_GT(kills, 5) << "hardly anything was written: no evidence";
}

TEST(KilledWriter, AppendingLosesNothing) {
  kill_at_every_write(6, 6.5e-6, [](auto& writer) { append(writer, 7), append(writer, 8); }, {1, 2, 3, 4, 5, 6, 7, 8});
}

TEST(KilledWriter, ReplacingTheLastLosesNothing) {
  kill_at_every_write(3, 1, [](auto& writer) { append(writer, 3); }, {1, 2, 3});
}

TEST(KilledWriter, DroppingLaterStatesLosesNothing) {
  kill_at_every_write(9, 4.5e-6, [](auto& writer) { append(writer, 5), append(writer, 7); }, {1, 2, 3, 4, 5, 7});
}

}  // namespace
