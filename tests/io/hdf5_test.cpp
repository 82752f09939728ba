// SPDX-License-Identifier: Apache-2.0
// Arrays and attributes come back bit for bit; failures name the file and the reason.
#include "io/hdf5.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <limits>

#include "core/error.hpp"
#include "tests/io/temporary_folder.hpp"

namespace {

using io::hdf5::Access;
using io::hdf5::File;
using test::guard_message;

template <class T>
class Hdf5Types : public testing::Test {};
using Types = testing::Types<double, float, std::int32_t, std::int64_t, std::uint8_t, std::uint32_t, std::uint64_t>;
TYPED_TEST_SUITE(Hdf5Types, Types);

TYPED_TEST(Hdf5Types, ArraysComeBack) {
  using T = TypeParam;
  const test::TemporaryFolder dir;
  const std::vector<T> a{std::numeric_limits<T>::lowest(), T(0), T(3), std::numeric_limits<T>::max()};
  File out(dir / "a.h5", Access::create);
  out.write("deep/in/a", a);
  out.write("square", a.data(), 2, 2);
  out.write("none", std::vector<T>{});
  out.write("no_rows", a.data(), 0, 3);
  out.write("packed", std::vector<T>(100000, T(7)), 4);
  out.close();
  const File in(dir / "a.h5", Access::read);
  EXPECT_EQ(in.read<T>("deep/in/a"), a);
  EXPECT_EQ(in.read<T>("square"), a);
  EXPECT_EQ(in.extent("square").columns, 2u);
  EXPECT_TRUE(in.read<T>("none").empty());
  EXPECT_EQ(in.extent("no_rows").rows, 0u);
  EXPECT_EQ(in.read<T>("packed"), std::vector<T>(100000, T(7)));
}

TEST(Hdf5, AttributesAndGroups) {
  const test::TemporaryFolder dir;
  {
    File out(dir / "a.h5", Access::create);
    out.make_group("g/h");
    out.make_group("g/b");
    out.set_attribute("g/h", "x", 0.1);
    out.set_attribute("g/h", "a", 0.3);
    out.set_attribute("g/h", "x", 0.2);
    out.set_attribute("/", "n", std::int64_t{-5});
    out.set_attribute("g", "text", std::string("\u00b5 and so on"));
    out.set_attribute("g", "empty", std::string());
    out.close();
  }
  File file(dir / "a.h5", Access::modify);
  EXPECT_EQ(file.real_attribute("g/h", "x"), 0.2);
  EXPECT_EQ(file.integer_attribute("/", "n"), -5);
  EXPECT_EQ(file.text_attribute("g", "text"), "\u00b5 and so on");
  EXPECT_EQ(file.text_attribute("g", "empty"), "");
  EXPECT_TRUE(file.has_attribute("g/h", "x"));
  EXPECT_FALSE(file.has_attribute("g/h", "y"));
  EXPECT_FALSE(file.has_attribute("nowhere", "y"));
  EXPECT_TRUE(file.has("g/h"));
  EXPECT_FALSE(file.has("g/x/y"));
  EXPECT_EQ(file.children("g"), (std::vector<std::string>{"b", "h"}));
  file.remove("g/h");
  EXPECT_FALSE(file.has("g/h"));
}

TEST(Hdf5, RewritingReplaces) {
  const test::TemporaryFolder dir;
  File file(dir / "a.h5", Access::create);
  file.write("a", std::vector<double>{1, 2});
  file.write("a", std::vector<std::int32_t>{3});
  EXPECT_EQ(file.read<std::int32_t>("a"), std::vector<std::int32_t>{3});
}

TEST(Hdf5, NoRoomIsLeftClaimed) {
  const test::TemporaryFolder dir;
  File file(dir / "a.h5", Access::create);
  file.write("a", std::vector<double>(1000));
  file.close();
  EXPECT_LT(std::filesystem::file_size(dir / "a.h5"), 8000u + 8192u);  // the array and some headers
}

TEST(Hdf5, FailuresNameFileAndReason) {
  const test::TemporaryFolder dir;
  const auto message_of = [&](auto f) { return guard_message(f); };
  EXPECT_EQ(message_of([&] { File(dir / "absent.h5", Access::read); }), dir / "absent.h5" + ": cannot be read: No such file or directory");
  EXPECT_NE(message_of([&] { File(dir / "no/folder.h5", Access::create); }).find("No such file or directory"), std::string::npos);
  EXPECT_NE(message_of([&] { File(dir.path.string(), Access::create); }).find("Is a directory"), std::string::npos);
  std::ofstream(dir / "text.h5") << "this is no HDF5";
  EXPECT_NE(message_of([&] { File(dir / "text.h5", Access::read); }).find("text.h5: cannot be read: "), std::string::npos);
  File file(dir / "a.h5", Access::create);
  file.write("a", std::vector<double>{1, 2});
  EXPECT_NE(message_of([&] { file.read<double>("b"); }).find("'b' cannot be read"), std::string::npos);
  EXPECT_NE(message_of([&] { file.read<float>("a"); }).find("another type"), std::string::npos);
  double few[1];
  EXPECT_NE(message_of([&] { file.read("a", few, 1); }).find("holds 2 values, 1 are expected"), std::string::npos);
  EXPECT_NE(message_of([&] { file.real_attribute("a", "q"); }).find("attribute 'q' of 'a'"), std::string::npos);
}

TEST(Hdf5, FullDiskIsMetBeforeTheFileIsTouched) {
  const test::TemporaryFolder dir;
  File file(dir / "a.h5", Access::create);
  file.write("a", std::vector<double>{1, 2});
  {
    const test::FileSizeLimit limit(1 << 20);
    const std::string message = guard_message([&] { file.write("big", std::vector<double>(1 << 18)); });
    EXPECT_NE(message.find("no room for 'big'"), std::string::npos) << message;
    EXPECT_NE(message.find("bytes more were needed"), std::string::npos) << message;
  }
  file.close();
  EXPECT_EQ(File(dir / "a.h5", Access::read).read<double>("a"), (std::vector<double>{1, 2}));
}

TEST(Hdf5, DeviceWithoutRoomIsReported) {
  if (access("/dev/full", W_OK) != 0) GTEST_SKIP() << "no /dev/full that may be written";
  const std::string message = guard_message([] {
    File file("/dev/full", Access::create);
    file.write("a", std::vector<double>(1000));
    file.close();
  });
  EXPECT_NE(message.find("/dev/full: "), std::string::npos) << message;
  EXPECT_NE(message.find("No space left on device"), std::string::npos) << message;
}

}  // namespace
