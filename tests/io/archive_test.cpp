// SPDX-License-Identifier: Apache-2.0
// Checkpoints: every type comes back bit for bit; a checkpoint that was not finished leaves the one before it.
#include "io/archive.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>

#include "core/error.hpp"
#include "tests/io/temporary_folder.hpp"

namespace {

using test::guard_message;

enum class Colour { red = 3, blue = 9 };

struct State {
  std::vector<double> d{0.1, -0.0, std::numeric_limits<double>::denorm_min(), 1e300};
  std::vector<float> f{0.1f};
  std::vector<std::int32_t> i{-1, 2};
  std::vector<std::int64_t> l{std::numeric_limits<std::int64_t>::min()};
  std::vector<std::uint8_t> b{0, 255};
  std::vector<std::uint32_t> u{4294967295u};
  std::vector<std::uint64_t> w{18446744073709551615ull};
  std::vector<core::Vec3> x{{1, 2, 3}, {4, 5, 6}};
  std::vector<std::array<std::int32_t, 8>> node{{0, 1, 2, 3, 4, 5, 6, 7}};
  std::vector<std::array<double, 3>> none;
  double time = 1.0 / 3.0;
  float factor = 0.1f;
  int n = -7;
  std::int64_t step = 123456789012345;
  std::size_t size = 18446744073709551615ull;
  bool yes = true;
  Colour colour = Colour::blue;
  core::Vec3 v{7, 8, 9};
  std::array<double, 6> ledger{1, 2, 3, 4, 5, 6};
  std::string text = "line\nwith \u00b5";
  std::string empty;
  std::vector<std::string> texts{"a", "", "ccc"};
};

template <class Archive, class S>
void visit(Archive& a, S& s) {
  a("d", s.d);
  a("f", s.f);
  a("i", s.i);
  a("l", s.l);
  a("b", s.b);
  a("u", s.u);
  a("w", s.w);
  a("nodes/x", s.x);
  a("nodes/node", s.node);
  a("none", s.none);
  a("time", s.time);
  a("factor", s.factor);
  a("n", s.n);
  a("step", s.step);
  a("size", s.size);
  a("yes", s.yes);
  a("colour", s.colour);
  a("v", s.v);
  a("ledger", s.ledger);
  a("text", s.text);
  a("empty", s.empty);
  a("texts", s.texts);
}

void save(const std::string& path, double time) {
  io::ArchiveWriter out(path);
  out("time", time);
  out.commit();
}

TEST(Archive, EverythingComesBackBitForBit) {
  const test::TemporaryFolder dir;
  const State s;
  io::ArchiveWriter out(dir / "c.h5");
  visit(out, s);
  out.commit();
  State r;
  r.d.clear(), r.f.clear(), r.i.clear(), r.l.clear(), r.b.clear(), r.u.clear(), r.w.clear(), r.x.clear(), r.node.clear();
  r.time = r.factor = 0;
  r.n = 0, r.step = 0, r.size = 0, r.yes = false, r.colour = Colour::red, r.v.setZero(), r.ledger = {}, r.text = "", r.texts = {};
  r.none.resize(4);
  r.empty = "full";
  const io::ArchiveReader in(dir / "c.h5");
  visit(in, r);
  ASSERT_EQ(r.d.size(), s.d.size());
  EXPECT_EQ(std::memcmp(r.d.data(), s.d.data(), s.d.size() * sizeof(double)), 0);
  EXPECT_EQ(r.f, s.f);
  EXPECT_EQ(r.i, s.i);
  EXPECT_EQ(r.l, s.l);
  EXPECT_EQ(r.b, s.b);
  EXPECT_EQ(r.u, s.u);
  EXPECT_EQ(r.w, s.w);
  EXPECT_EQ(r.x, s.x);
  EXPECT_EQ(r.node, s.node);
  EXPECT_TRUE(r.none.empty());
  EXPECT_EQ(r.time, s.time);
  EXPECT_EQ(r.factor, s.factor);
  EXPECT_EQ(r.n, s.n);
  EXPECT_EQ(r.step, s.step);
  EXPECT_EQ(r.size, s.size);
  EXPECT_EQ(r.yes, s.yes);
  EXPECT_EQ(r.colour, s.colour);
  EXPECT_EQ(r.v, s.v);
  EXPECT_EQ(r.ledger, s.ledger);
  EXPECT_EQ(r.text, s.text);
  EXPECT_EQ(r.empty, s.empty);
  EXPECT_EQ(r.texts, s.texts);
  EXPECT_TRUE(in.has("nodes/x"));
  EXPECT_FALSE(in.has("nodes/y"));
  EXPECT_EQ(in.get<double>("time"), s.time);
}

TEST(Archive, UnfinishedOneLeavesThePrevious) {
  const test::TemporaryFolder dir;
  save(dir / "c.h5", 1);
  {
    io::ArchiveWriter out(dir / "c.h5");
    out("time", 2.0);
  }
  EXPECT_EQ(io::ArchiveReader(dir / "c.h5").get<double>("time"), 1);
  EXPECT_FALSE(std::filesystem::exists(dir / "c.h5.tmp"));
}

TEST(Archive, FullDiskLeavesThePrevious) {
  const test::TemporaryFolder dir;
  save(dir / "c.h5", 1);
  {
    const test::FileSizeLimit limit(1 << 20);
    const std::string message = guard_message([&] {
      io::ArchiveWriter out(dir / "c.h5");
      out("time", 2.0);
      out("x", std::vector<core::Vec3>(100000, core::Vec3::Zero()));
      out.commit();
    });
    EXPECT_NE(message.find("c.h5.tmp: no room for 'x'"), std::string::npos) << message;
    EXPECT_NE(message.find("make room"), std::string::npos) << message;
  }
  EXPECT_EQ(io::ArchiveReader(dir / "c.h5").get<double>("time"), 1);
  EXPECT_FALSE(std::filesystem::exists(dir / "c.h5.tmp"));
}

TEST(Archive, HalfWrittenTemporaryOfAKilledRunIsNoObstacle) {
  const test::TemporaryFolder dir;
  std::ofstream(dir / "c.h5.tmp") << "half";
  save(dir / "c.h5", 3);
  EXPECT_EQ(io::ArchiveReader(dir / "c.h5").get<double>("time"), 3);
}

TEST(Archive, WhatIsNoCheckpointIsRefused) {
  const test::TemporaryFolder dir;
  {
    io::ArchiveWriter out(dir / "old.h5", 99);
    out.commit();
  }
  const std::string message = guard_message([&] { io::ArchiveReader(dir / "old.h5"); });
  EXPECT_NE(message.find("is a checkpoint of version 99, this program reads version " + std::to_string(io::checkpoint_version)), std::string::npos) << message;
  io::hdf5::File(dir / "other.h5", io::hdf5::Access::create).close();
  EXPECT_NE(guard_message([&] { io::ArchiveReader(dir / "other.h5"); }).find("is no checkpoint"), std::string::npos);
  save(dir / "c.h5", 1);
  const io::ArchiveReader in(dir / "c.h5");
  EXPECT_NE(guard_message([&] { in.get<double>("absent"); }).find("'absent' cannot be read"), std::string::npos);
  EXPECT_NE(guard_message([&] { in.get<std::vector<core::Vec3>>("time"); }).find("has 1 columns, 3 are expected"), std::string::npos);
}

}  // namespace
