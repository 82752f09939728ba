// SPDX-License-Identifier: Apache-2.0
// The tree with its lines, overrides, and the hints for misspelt names.
#include "io/toml_reader.hpp"

#include <gtest/gtest.h>

#include "core/error.hpp"

namespace {

using namespace io::toml_reader;

const char* const text = R"(
[run]
end = "20 us"
[[body]]
name = "a"
size = [1, 2,
  3]
[[body]]
name = "b"
)";

std::string error_of_override(const std::string& assignment) {
  Node root = parse_text(text, "case.toml");
  try {
    apply_override(root, assignment);
  } catch (const core::CaseError& e) {
    return e.what();
  }
  return "accepted";
}

TEST(TomlReader, ValuesKnowTheirLine) {
  const Node root = parse_text(text, "case.toml");
  EXPECT_EQ(root.find("run")->where, "case.toml:2");
  EXPECT_EQ(root.find("run")->find("end")->where, "case.toml:3");
  EXPECT_EQ(root.find("body")->items[1].where, "case.toml:8");
  EXPECT_EQ(root.find("body")->items[0].find("size")->items[2].where, "case.toml:7");
}

TEST(TomlReader, KeysKeepTheOrderOfTheFile) {
  const Node root = parse_text("z = 1\na = 2\nm = 3\n", "x");
  ASSERT_EQ(root.children.size(), 3u);
  EXPECT_EQ(root.children[0].key + root.children[1].key + root.children[2].key, "zam");
}

TEST(TomlReader, OverrideByPathNameAndIndex) {
  Node root = parse_text(text, "case.toml");
  for (const char* assignment :
       {"run.end=5 us", "body.b.velocity=[0,0,-7000]", "body.0.diameter=3 mm", "convert.jacobian_ratio=2",
        "body.a.center=[0 mm, -1.5 mm, 2]", "body.a.size.1=7", "reference.\"a.hole_diameter\".value=\"7 mm\"", "run.bond = true"})
    apply_override(root, assignment);
  EXPECT_EQ(root.find("run")->find("end")->text, "5 us");
  EXPECT_EQ(root.find("run")->find("end")->where, "--set run.end");
  EXPECT_TRUE(root.find("run")->find("bond")->boolean);
  EXPECT_EQ(root.find("body")->items[1].find("velocity")->items[2].integer, -7000);
  EXPECT_EQ(root.find("body")->items[0].find("diameter")->text, "3 mm");
  EXPECT_EQ(root.find("body")->items[0].find("size")->items[1].integer, 7);
  EXPECT_EQ(root.find("body")->items[0].find("center")->items[1].text, "-1.5 mm");
  EXPECT_EQ(root.find("body")->items[0].find("center")->items[2].integer, 2);
  EXPECT_EQ(root.find("convert")->find("jacobian_ratio")->integer, 2);
  EXPECT_EQ(root.find("reference")->find("a.hole_diameter")->find("value")->text, "7 mm");
}

TEST(TomlReader, OverrideThatDoesNotFitIsNamed) {
  EXPECT_EQ(error_of_override("run.end"), "--set run.end: must be key=value, for example --set run.end=\"5 us\"");
  EXPECT_NE(error_of_override("body.c.diameter=1").find("--set body.c.diameter: there is no 'c'"), std::string::npos);
  EXPECT_NE(error_of_override("body.c.diameter=1").find("a, b"), std::string::npos);
  EXPECT_NE(error_of_override("body.7.diameter=1").find("there is no '7'"), std::string::npos);
  EXPECT_NE(error_of_override("wall.0.point=1").find("no [[wall]]"), std::string::npos);
  EXPECT_NE(error_of_override("run.end.x=1").find("'end' is a value"), std::string::npos);
  EXPECT_NE(error_of_override("run..x=1").find("empty"), std::string::npos);
  EXPECT_NE(error_of_override("run.end=").find("a value must follow"), std::string::npos);
  EXPECT_NE(error_of_override("=5").find("must be key=value"), std::string::npos);
}

TEST(TomlReader, NearestNames) {
  const std::vector<std::string> names{"Al2024-T351", "Al2024-T3", "Al6061-T6", "OFHC-Cu", "Be"};
  EXPECT_EQ(nearest("Al2024-T531", names).front(), "Al2024-T351");
  EXPECT_EQ(nearest("al2024", names).size(), 2u);
  EXPECT_EQ(nearest("Al6061", names).front(), "Al6061-T6");
  EXPECT_TRUE(nearest("granite", names).empty());
  EXPECT_EQ(nearest("fideltiy", {"fidelity", "end"}).front(), "fidelity");
}

TEST(TomlReader, StringsAreEscaped) {
  const std::string nasty = "a \"b\" \\ c\n\t\x01 \u00e9";
  const Node root = parse_text("k = " + toml_string(nasty) + "\n" + as_key("x.y z") + " = 1\n", "x");
  EXPECT_EQ(root.find("k")->text, nasty);
  EXPECT_NE(root.find("x.y z"), nullptr);
  EXPECT_EQ(as_key("Al2024-T351"), "Al2024-T351");
}

}  // namespace
