// SPDX-License-Identifier: Apache-2.0
// Files that are replaced whole, and what must not be replaced by a file.
#include "io/atomic_file.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>

#include "core/error.hpp"
#include "tests/io/temporary_folder.hpp"

namespace {

namespace fs = std::filesystem;

std::string content(const std::string& path) {
  std::ifstream in(path);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

TEST(AtomicFile, ReplacesAFileAndLeavesNothingBesideIt) {
  const test::TemporaryFolder folder;
  for (const std::string text : {"a long first text", "short"}) {
    io::write_atomically(folder / "f", text);
    EXPECT_EQ(content(folder / "f"), text);
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path), fs::directory_iterator()), 1);
}

TEST(AtomicFile, WhatWasThereStaysWhereThereIsNoRoom) {
  const test::TemporaryFolder folder;
  io::write_atomically(folder / "f", "precious");
  {
    const test::FileSizeLimit limit(1000);
    EXPECT_THROW(io::write_atomically(folder / "f", std::string(2000, 'x')), core::GuardError);
  }
  EXPECT_EQ(content(folder / "f"), "precious");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path), fs::directory_iterator()), 1);
}

TEST(AtomicFile, LinksAndPipesStayWhatTheyAre) {  // /dev/stdout is a link, /dev/null a device
  const test::TemporaryFolder folder;
  io::write_atomically(folder / "file", "old");
  fs::create_symlink(folder / "file", folder / "link");
  io::write_atomically(folder / "link", "new");
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
  EXPECT_EQ(content(folder / "file"), "new");

  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  const int reader = ::open((folder / "pipe").c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  io::write_atomically(folder / "pipe", "through");
  EXPECT_TRUE(fs::is_fifo(folder / "pipe"));
  char got[16] = {};
  EXPECT_EQ(::read(reader, got, sizeof got), 7);
  EXPECT_STREQ(got, "through");
  ::close(reader);
}

TEST(AtomicFile, PlacesThatCannotHoldAFileAreTheUsersToPutRight) {
  const test::TemporaryFolder folder;
  EXPECT_NO_THROW(io::require_place("--out", folder / "f"));
  EXPECT_NO_THROW(io::require_place("--out", "f"));
  EXPECT_THROW(io::require_place("--out", folder / "no/f"), core::CaseError);
  EXPECT_THROW(io::require_place("--out", folder.path.string()), core::CaseError);
}

}  // namespace
