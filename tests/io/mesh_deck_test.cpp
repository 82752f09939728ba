// SPDX-License-Identifier: Apache-2.0
// LS-DYNA decks: both element forms, fixed columns and commas, and decks that must be refused with file and line.
#include "io/mesh_deck.hpp"

#include <gtest/gtest.h>

#include <sstream>
#include <string>

#include "core/error.hpp"

namespace {

// Two unit cubes on top of each other; node numbers with gaps, node 99 used by nothing.
const std::string fixed_nodes =
    "*KEYWORD\n"
    "*TITLE\n"
    "two cubes\n"
    "$ comment\n"
    "*PART\n"
    "block\n"
    "         1         1         1\n"
    "*NODE\n"
    "$    nid               x               y               z      tc      rc\n"
    "      10             0.0             0.0             0.0       0       0\n"
    "      11             1.0             0.0             0.0       0       0\n"
    "      12             1.0             1.0             0.0       0       0\n"
    "      13             0.0             1.0             0.0       0       0\n"
    "      99        7.0E+000             7.0             7.0\n"
    "      20             0.0             0.0             1.0\n"
    "      21          1.0E+0             0.0             1.0\n"
    "      22            +1.0          1.0D+0             1.0\n"
    "      23                             1.0             1.0\n"
    "      30             0.0             0.0             2.0\n"
    "      31             1.0             0.0             2.0\n"
    "      32             1.0             1.0             2.0\n"
    "      33             0.0             1.0             2.0\n";
const std::string one_line_solids =
    "*ELEMENT_SOLID\n"
    "       1       1      10      11      12      13      20      21      22      23\n"
    "       2       1      20      21      22      23      30      31      32      33\n"
    "*END\n"
    "this is not read\n";
const std::string two_line_solids =
    "*ELEMENT_SOLID (ten nodes format)\n"
    "       1       1\n"
    "      10      11      12      13      20      21      22      23       0       0\n"
    "       2       1\n"
    "$ between\n"
    "      20      21      22      23      30      31      32      33\n"
    "*END\n";

io::DeckMesh read(const std::string& text, double scale = 1.0) {
  std::istringstream in(text);
  return io::read_mesh_deck(in, "deck.k", scale);
}

/// The message of the error that the deck must give.
std::string error_of(const std::string& text, double scale = 1.0) {
  try {
    read(text, scale);
  } catch (const core::CaseError& e) {
    return e.what();
  }
  return "no error";
}

#define EXPECT_MESSAGE(text, ...)                                                         \
  do {                                                                                    \
    const std::string message = error_of(text);                                           \
    for (const char* part : {__VA_ARGS__})                                                \
      EXPECT_NE(message.find(part), std::string::npos) << part << " not in: " << message; \
  } while (false)

void expect_two_cubes(const io::DeckMesh& mesh, double scale) {
  ASSERT_EQ(mesh.x.size(), 12u);
  ASSERT_EQ(mesh.node.size(), 2u);
  EXPECT_EQ(mesh.node[0], (std::array<std::int32_t, 8>{0, 1, 2, 3, 4, 5, 6, 7}));
  EXPECT_EQ(mesh.node[1], (std::array<std::int32_t, 8>{4, 5, 6, 7, 8, 9, 10, 11}));
  const double square[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  for (std::size_t i = 0; i < 12; ++i)
    EXPECT_EQ(mesh.x[i], core::Vec3(scale * square[i % 4][0], scale * square[i % 4][1], scale * double(i / 4)));
}

TEST(MeshDeck, ReadsFixedColumnsWithElementsOnOneLine) { expect_two_cubes(read(fixed_nodes + one_line_solids), 1.0); }

TEST(MeshDeck, ReadsFixedColumnsWithElementsOnTwoLines) {
  expect_two_cubes(read(fixed_nodes + two_line_solids, 0.001), 0.001);
}

TEST(MeshDeck, ReadsElementsBeforeNodes) {
  expect_two_cubes(read(two_line_solids.substr(0, two_line_solids.size() - 5) + fixed_nodes), 1.0);
}

TEST(MeshDeck, ReadsCommasAndWindowsLineEnds) {
  expect_two_cubes(
      read("*keyword\r\n*node\r\n10,0,0,0\r\n11, 1.0, 0 ,0\r\n12,1,1,0,0,0\r\n13,,1,0\r\n"
           "20,0,0,1\r\n21,1,0,1\r\n22,1,1,1\r\n23,0,1,1\r\n30,0,0,2\r\n31,1,0,2\r\n32,1,1,2\r\n33,0,1,2\r\n"
           "*element_solid\r\n1,1,10,11,12,13,20,21,22,23\r\n2,1\r\n20,21,22,23,30,31,32,33\r\n"),
      1.0);
}

TEST(MeshDeck, ReadsAdjoiningColumnsThatFillTheirWidth) {
  std::string text = "*NODE\n*ELEMENT_SOLID\n       1       1";
  std::string nodes;
  const char* x[8] = {
      "-1.0000000000000-1.0000000000000-1.0000000000000", "+1.0000000000000-1.0000000000000-1.0000000000000",
      "+1.0000000000000+1.0000000000000-1.0000000000000", "-1.0000000000000+1.0000000000000-1.0000000000000",
      "-1.0000000000000-1.0000000000000+1.0000000000000", "+1.0000000000000-1.0000000000000+1.0000000000000",
      "+1.0000000000000+1.0000000000000+1.0000000000000", "-1.0000000000000+1.0000000000000+1.0000000000000"};
  for (int i = 0; i < 8; ++i) {
    const std::string id = "1000000" + std::to_string(i);
    text += id;
    nodes += id + x[i] + "\n";
  }
  text.insert(6, nodes);
  const io::DeckMesh mesh = read(text);
  ASSERT_EQ(mesh.x.size(), 8u);
  EXPECT_EQ(mesh.x[5], core::Vec3(1, -1, 1));
}

TEST(MeshDeck, ReadsWideColumns) {
  const auto wide = [](const std::string& s, std::size_t width) { return std::string(width - s.size(), ' ') + s; };
  const char* x[8][3] = {{"0", "0", "0"}, {"1", "0", "0"}, {"1", "1", "0"}, {"0", "1", "0"},
                         {"0", "0", "1"}, {"1", "0", "1"}, {"1", "1", "1"}, {"0", "1", "1"}};
  const auto deck = [&](const std::string& head, const std::string& mark, std::size_t integer, std::size_t real) {
    std::string nodes = head + "*NODE" + mark + "\n", solid = "*ELEMENT_SOLID" + mark + "\n";
    solid += wide("1", integer) + wide("1", integer);
    for (int i = 0; i < 8; ++i) {
      nodes +=
          wide(std::to_string(i + 1), integer) + wide(x[i][0], real) + wide(x[i][1], real) + wide(x[i][2], real) + "\n";
      solid += wide(std::to_string(i + 1), integer);
    }
    return nodes + solid + "\n";
  };
  for (const std::string& text :
       {deck("*KEYWORD LONG=Y\n", "", 20, 20), deck("", "+", 20, 20), deck("", " +", 20, 20),
        deck("*KEYWORD I10=Y\n", "", 10, 16), deck("", "%", 10, 16), deck("*KEYWORD LONG=Y\n", "-", 8, 16)}) {
    const io::DeckMesh mesh = read(text);
    ASSERT_EQ(mesh.x.size(), 8u) << text;
    EXPECT_EQ(mesh.x[6], core::Vec3(1, 1, 1)) << text;
  }
}

TEST(MeshDeck, RefusesDuplicates) {
  EXPECT_MESSAGE(fixed_nodes + "      10             0.0             0.0             0.0\n", "deck.k:23: ", "node 10",
                 "line 10");
  EXPECT_MESSAGE(fixed_nodes + one_line_solids.substr(0, 15 + 80) + "\n" + one_line_solids.substr(15, 80) + "\n",
                 "deck.k:25: ", "element 1 ", "line 24");
}

TEST(MeshDeck, RefusesMissingNodes) {
  EXPECT_MESSAGE(fixed_nodes + "*ELEMENT_SOLID\n1,1,10,11,12,13,20,21,22,77\n", "deck.k:24: ", "element 1 ", "node 77");
}

TEST(MeshDeck, RefusesTetrahedraAndWedges) {
  EXPECT_MESSAGE(fixed_nodes + "*ELEMENT_SOLID\n5,1,10,11,12,20,20,20,20,20\n", "deck.k:24: ", "element 5 ", "node 20",
                 "corners 4 and 5");
  EXPECT_MESSAGE(fixed_nodes + "*ELEMENT_SOLID\n5,1,10,11,12,13,20,20,22,22\n", "node 20", "corners 5 and 6");
  EXPECT_MESSAGE(fixed_nodes + "*ELEMENT_SOLID\n5,1\n10,11,12,13,20,21,22,23,30,31\n", "deck.k:25: ", "element 5 ",
                 "30");
}

TEST(MeshDeck, RefusesInvertedElements) {
  EXPECT_MESSAGE(fixed_nodes + "*ELEMENT_SOLID\n5,1,20,21,22,23,10,11,12,13\n", "deck.k:24: ", "element 5 ",
                 "-1.000e+00 m3");
}

TEST(MeshDeck, RefusesWhatItCannotRead) {
  EXPECT_MESSAGE("*NODE\n      1a             0.0             0.0             0.0\n", "deck.k:2: ", "'1a'");
  EXPECT_MESSAGE("*NODE\n1 0.0 0.0 0.0\n", "deck.k:2: ", "columns of 8");
  EXPECT_MESSAGE("*NODE\n1, 0.0, zero, 0.0\n", "deck.k:2: ", "y is 'zero'");
  EXPECT_MESSAGE(fixed_nodes + "*ELEMENT_SOLID\n5,1,10,11,12,13\n", "deck.k:24: ", "field 7");
  EXPECT_MESSAGE(fixed_nodes + "*ELEMENT_SOLID\n5,1\n*END\n", "deck.k:24: ", "element 5 has no nodes");
  EXPECT_MESSAGE(fixed_nodes + "*ELEMENT_SOLID_ORTHO\n", "deck.k:23: ", "*ELEMENT_SOLID_ORTHO");
  EXPECT_MESSAGE("*INCLUDE\nmesh.k\n", "deck.k:1: ", "*INCLUDE");
  EXPECT_MESSAGE(fixed_nodes, "without a solid element");
  EXPECT_NE(error_of(fixed_nodes + one_line_solids, 0.0).find("unit of length"), std::string::npos);
  EXPECT_THROW(io::read_mesh_deck("/nonexistent/deck.k", 1.0), core::CaseError);
}

}  // namespace
