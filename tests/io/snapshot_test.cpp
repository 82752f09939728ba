// SPDX-License-Identifier: Apache-2.0
// Snapshots come back as they went in, with blocks that are empty too; run.xdmf names what run.h5 holds; a resumed run
// goes on where it stands; nothing that is not finite is written.
#include "io/snapshot.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <sstream>

#include "tests/io/example_snapshots.hpp"
#include "tests/io/temporary_folder.hpp"

namespace {

using test::guard_message;

std::string text_of(const std::string& path) {
  std::ostringstream s;
  s << std::ifstream(path).rdbuf();
  return s.str();
}

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t n = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
  return n;
}

void expect_same(const io::Snapshot& a, const io::Snapshot& b) {
  EXPECT_EQ(a.time, b.time);
  EXPECT_EQ(a.step, b.step);
  EXPECT_EQ(a.node_x, b.node_x);
  EXPECT_EQ(a.node_v, b.node_v);
  EXPECT_EQ(a.element_node, b.element_node);
  EXPECT_EQ(a.particle_x, b.particle_x);
  EXPECT_EQ(a.particle_v, b.particle_v);
  EXPECT_EQ(a.scalars, b.scalars);
  for (const auto& f : a.fields) {
    if (f.element.empty() && f.particle.empty()) continue;
    const auto* g = b.find(f.name);
    ASSERT_NE(g, nullptr) << f.name;
    EXPECT_EQ(f.element, g->element);
    EXPECT_EQ(f.particle, g->particle);
  }
}

TEST(Snapshot, ComesBackAsItWentIn) {
  const test::TemporaryFolder dir;
  const std::vector<io::Snapshot> all{example::snapshot(0, 5, 0), example::snapshot(7, 3, 4), example::snapshot(9, 0, 6),
                                      example::snapshot(11, 0, 0)};
  io::SnapshotWriter writer(dir / "run");
  for (const auto& s : all) writer.append(s);
  EXPECT_EQ(io::snapshot_times(dir / "run"), (std::vector<double>{0, 7e-6, 9e-6, 11e-6}));
  for (std::size_t k = 0; k < all.size(); ++k) expect_same(all[k], io::read_snapshot(dir / "run/run.h5", static_cast<int>(k)));
  expect_same(all[3], io::read_snapshot(dir / "run"));
  expect_same(all[1], io::read_snapshot(dir / "run", -3));
  EXPECT_NE(guard_message([&] { io::read_snapshot(dir / "run", 4); }).find("no snapshot 4; it holds 4"), std::string::npos);
}

TEST(Snapshot, XdmfNamesWhatIsThere) {
  const test::TemporaryFolder dir;
  io::SnapshotWriter writer(dir / "run");
  EXPECT_EQ(count(text_of(dir / "run/run.xdmf"), "<Time"), 0u);
  writer.append(example::snapshot(0, 5, 0));
  writer.append(example::snapshot(1, 5, 2));
  const std::string xdmf = text_of(dir / "run/run.xdmf");
  EXPECT_EQ(count(xdmf, "<Time"), 2u);
  EXPECT_EQ(count(xdmf, "\"Hexahedron\""), 2u);
  EXPECT_EQ(count(xdmf, "\"Polyvertex\""), 1u);
  EXPECT_EQ(count(xdmf, "element/pressure"), 2u);
  EXPECT_FALSE(std::filesystem::exists(dir / "run/run.xdmf.tmp"));
}

TEST(Snapshot, SameStepReplaces) {
  const test::TemporaryFolder dir;
  io::SnapshotWriter writer(dir / "run");
  writer.append(example::snapshot(3, 5, 0));
  writer.append(example::snapshot(3, 2, 1));
  EXPECT_EQ(io::snapshot_times(dir / "run").size(), 1u);
  EXPECT_EQ(io::read_snapshot(dir / "run").element_node.size(), 2u);
  EXPECT_NE(guard_message([&] { writer.append(example::snapshot(2, 1, 0)); }).find("comes after"), std::string::npos);
}

TEST(Snapshot, ResumedRunDropsWhatComesLater) {
  const test::TemporaryFolder dir;
  {
    io::SnapshotWriter writer(dir / "run");
    for (int k = 0; k < 5; ++k) writer.append(example::snapshot(k, 2, k));
  }
  auto writer = io::SnapshotWriter::reopen(dir / "run", 2e-6);
  EXPECT_EQ(writer.size(), 3u);
  EXPECT_TRUE(writer.note().empty());
  writer.append(example::snapshot(3, 1, 1));
  EXPECT_EQ(io::snapshot_times(dir / "run").size(), 4u);
  EXPECT_EQ(io::read_snapshot(dir / "run").element_node.size(), 1u);
  EXPECT_EQ(count(text_of(dir / "run/run.xdmf"), "<Time"), 4u);
}

TEST(Snapshot, DamagedFileIsKeptAside) {
  const test::TemporaryFolder dir;
  { io::SnapshotWriter(dir / "run").append(example::snapshot(0, 2, 2)); }
  std::filesystem::resize_file(dir / "run/run.h5", 300);
  auto writer = io::SnapshotWriter::reopen(dir / "run", 1);
  EXPECT_NE(writer.note().find("run.h5.damaged"), std::string::npos);
  EXPECT_TRUE(std::filesystem::exists(dir / "run/run.h5.damaged"));
  writer.append(example::snapshot(4, 1, 1));
  EXPECT_EQ(io::snapshot_times(dir / "run").size(), 1u);
}

TEST(Snapshot, RoomClaimedByAKilledRunDoesNoHarm) {
  const test::TemporaryFolder dir;
  { io::SnapshotWriter(dir / "run").append(example::snapshot(0, 2, 2)); }
  std::filesystem::resize_file(dir / "run/run.h5", 1000000);
  auto writer = io::SnapshotWriter::reopen(dir / "run", 1);
  EXPECT_TRUE(writer.note().empty()) << writer.note();
  writer.append(example::snapshot(1, 2, 3));
  EXPECT_EQ(io::read_snapshot(dir / "run").particle_x.size(), 3u);
}

TEST(Snapshot, WhatIsNotFiniteIsRefused) {
  const test::TemporaryFolder dir;
  io::SnapshotWriter writer(dir / "run");
  auto bad = example::snapshot(0, 5, 3);
  bad.fields[0].element[2] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(guard_message([&] { writer.append(bad); }).find("'pressure (elements)' of row 2 is nan"), std::string::npos);
  bad = example::snapshot(0, 5, 3);
  bad.particle_v[1][2] = std::numeric_limits<double>::infinity();
  EXPECT_NE(guard_message([&] { writer.append(bad); }).find("'particle_v' of row 1 is inf"), std::string::npos);
  bad = example::snapshot(0, 5, 3);
  bad.element_node[4][7] = 24;
  EXPECT_NE(guard_message([&] { writer.append(bad); }).find("element 4 has corner 24 of 24 nodes"), std::string::npos);
  bad = example::snapshot(0, 5, 3);
  bad.fields[0].particle.pop_back();
  EXPECT_NE(guard_message([&] { writer.append(bad); }).find("has 2 rows, 3 are needed"), std::string::npos);
  EXPECT_TRUE(io::snapshot_times(dir / "run").empty());
}

TEST(Snapshot, FullDiskLeavesWhatWasThere) {
  const test::TemporaryFolder dir;
  io::SnapshotWriter writer(dir / "run");
  writer.append(example::snapshot(0, 50, 50));
  {
    const test::FileSizeLimit limit(1 << 20);
    const std::string message = guard_message([&] { writer.append(example::snapshot(1, 10000, 10000)); });
    EXPECT_NE(message.find("run.h5: no room for"), std::string::npos) << message;
    EXPECT_NE(message.find("bytes more were needed"), std::string::npos) << message;
  }
  expect_same(example::snapshot(0, 50, 50), io::read_snapshot(dir / "run"));
  EXPECT_EQ(io::snapshot_times(dir / "run").size(), 1u);
  writer.append(example::snapshot(1, 10000, 10000));
  EXPECT_EQ(io::snapshot_times(dir / "run").size(), 2u);
}

}  // namespace
