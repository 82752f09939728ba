// SPDX-License-Identifier: Apache-2.0
// Writes the snapshots that paraview_check.py looks at: elements only, both, particles only, nothing, both.
#include <cstdio>
#include <exception>

#include "tests/io/example_snapshots.hpp"

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "usage: write_example_snapshots DIR\n"), 2;
  try {
    io::SnapshotWriter writer(argv[1]);
    writer.append(example::snapshot(0, 5, 0));
    writer.append(example::snapshot(10, 3, 16));
    writer.append(example::snapshot(20, 0, 40));
    writer.append(example::snapshot(30, 0, 0));
    writer.append(example::snapshot(1000000, 2, 24));
  } catch (const std::exception& e) {
    return std::fprintf(stderr, "%s\n", e.what()), 1;
  }
  return 0;
}
