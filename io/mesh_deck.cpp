// SPDX-License-Identifier: Apache-2.0
#include "io/mesh_deck.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <string_view>
#include <unordered_map>

#include "core/error.hpp"

namespace io {
namespace {

using Id = std::int64_t;

struct DeckNode {
  Id id;
  core::Vec3 x;
  int line;
};

struct DeckHex {
  Id id;
  std::array<Id, 8> node;
  int line;
};

/// Column widths of a card: whole numbers and coordinates.
struct Columns {
  std::size_t integer = 8, real = 16;
};
constexpr Columns standard_columns{8, 16}, i10_columns{10, 16}, long_columns{20, 20};

enum class Section { skipped, node, solid };

std::string_view trim(std::string_view s) {
  const auto first = s.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return s.substr(first, s.find_last_not_of(" \t\r") - first + 1);
}

std::string upper(std::string_view s) {
  std::string r(s);
  std::transform(r.begin(), r.end(), r.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return r;
}

/// One deck being read: the place for messages, the section, and what has been found.
class Reader {
 public:
  Reader(std::istream& in, const std::string& name) : in_(in), name_(name) {}

  DeckMesh read(double scale) {
    while (next_line()) {
      if (line_[0] != '*') {
        read_data();
      } else if (!read_keyword()) {
        break;
      }
    }
    return compact(scale);
  }

 private:
  [[noreturn]] void fail(int line, const std::string& what) const {
    throw core::CaseError(name_ + ":" + std::to_string(line) + ": " + what);
  }

  /// The next line that is neither empty nor a comment; false at the end of the deck.
  bool next_line() {
    while (std::getline(in_, line_)) {
      ++line_number_;
      if (!line_.empty() && line_[0] != '$' && !trim(line_).empty()) return true;
    }
    return false;
  }

  /// False at *END.
  bool read_keyword() {
    const std::string whole = upper(trim(line_));
    std::string word = whole.substr(0, whole.find_first_of(" \t("));
    if (word == "*END") return false;
    if (word == "*KEYWORD") {
      if (whole.find("LONG=Y") != std::string::npos) deck_columns_ = long_columns;
      if (whole.find("I10=Y") != std::string::npos) deck_columns_ = i10_columns;
    }
    columns_ = deck_columns_;
    const std::string rest = whole.substr(std::min(whole.size(), word.size() + 1));
    const char mark = rest == "+" || rest == "-" || rest == "%" ? rest[0] : word.back();
    if (mark == '+') columns_ = long_columns;
    if (mark == '-') columns_ = standard_columns;
    if (mark == '%') columns_ = i10_columns;
    while (word.back() == '+' || word.back() == '-' || word.back() == '%') word.pop_back();

    section_ = word == "*NODE" ? Section::node : word == "*ELEMENT_SOLID" ? Section::solid : Section::skipped;
    if (section_ == Section::skipped && (word.starts_with("*ELEMENT_SOLID_") || word.starts_with("*INCLUDE")))
      fail(line_number_, "keyword " + word + " cannot be read; give one deck with *NODE and plain *ELEMENT_SOLID");
    return true;
  }

  void read_data() {
    if (section_ == Section::node) read_node();
    if (section_ == Section::solid) read_solid();
  }

  /// Field number `index` of the current line: between commas, or the columns [start, start + width).
  std::string_view field(std::size_t index, std::size_t start, std::size_t width) const {
    const std::string_view line = line_;
    if (line.find(',') == std::string_view::npos) return start < line.size() ? trim(line.substr(start, width)) : "";
    std::size_t first = 0;
    for (; index > 0; --index) {
      const auto comma = line.find(',', first);
      if (comma == std::string_view::npos) return {};
      first = comma + 1;
    }
    return trim(line.substr(first, line.find(',', first) - first));
  }

  std::string_view integer_field(std::size_t index) const {
    return field(index, index * columns_.integer, columns_.integer);
  }

  Id integer(std::size_t index, const char* what) const {
    const std::string_view text = integer_field(index);
    Id value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || value <= 0)
      fail(line_number_, std::string(what) + " is '" + std::string(text) + "' (field " + std::to_string(index + 1) +
                             "); it must be a positive whole number in columns of " + std::to_string(columns_.integer) +
                             " or between commas");
    return value;
  }

  /// A coordinate; empty means 0, as in the manual.
  double real(std::size_t index, const char* what) const {
    const std::string given(field(index, columns_.integer + (index - 1) * columns_.real, columns_.real));
    std::string text = upper(given);
    std::replace(text.begin(), text.end(), 'D', 'E');
    const char *first = text.data() + (text.starts_with('+') ? 1 : 0), *last = text.data() + text.size();
    double value = 0;
    if (first == last && text.empty()) return value;
    const auto [end, error] = std::from_chars(first, last, value);
    if (error != std::errc() || end != last || !std::isfinite(value))
      fail(line_number_, std::string(what) + " is '" + given + "' (field " + std::to_string(index + 1) +
                             "); it must be a number in columns of " + std::to_string(columns_.real) +
                             " or between commas");
    return value;
  }

  void read_node() {
    const Id id = integer(0, "node number");
    const core::Vec3 x(real(1, "x"), real(2, "y"), real(3, "z"));
    const auto [place, is_new] = node_row_.try_emplace(id, nodes_.size());
    if (!is_new)
      fail(line_number_, "node " + std::to_string(id) + " was given before, in line " +
                             std::to_string(nodes_[place->second].line) + "; node numbers must differ");
    nodes_.push_back({id, x, line_number_});
  }

  void read_solid() {
    DeckHex hex{integer(0, "element number"), {}, line_number_};
    const auto [place, is_new] = hex_line_.try_emplace(hex.id, line_number_);
    if (!is_new)
      fail(line_number_, "element " + std::to_string(hex.id) + " was given before, in line " +
                             std::to_string(place->second) + "; element numbers must differ");
    bool one_line = false;
    for (std::size_t i = 2; i < 10; ++i) one_line = one_line || !integer_field(i).empty();
    if (!one_line && (!next_line() || line_[0] == '*'))
      fail(hex.line, "element " + std::to_string(hex.id) + " has no nodes; they must follow on this line or the next");
    const std::size_t first = one_line ? 2 : 0;
    for (std::size_t a = 0; a < 8; ++a) hex.node[a] = integer(first + a, "node of a solid");
    if (!one_line) require_no_extra_nodes(hex);
    require_distinct_nodes(hex);
    hexes_.push_back(hex);
  }

  void require_no_extra_nodes(const DeckHex& hex) const {
    for (std::size_t i = 8; i < 10; ++i)
      if (const std::string_view text = integer_field(i); text.find_first_not_of('0') != std::string_view::npos)
        fail(line_number_, "element " + std::to_string(hex.id) + " has a node " + std::to_string(i + 1) + " ('" +
                               std::string(text) + "'), a ten-node tetrahedron; only 8-node hexes are read");
  }

  void require_distinct_nodes(const DeckHex& hex) const {
    for (std::size_t a = 0; a < 8; ++a)
      for (std::size_t b = a + 1; b < 8; ++b)
        if (hex.node[a] == hex.node[b])
          fail(hex.line, "element " + std::to_string(hex.id) + " has node " + std::to_string(hex.node[a]) +
                             " as its corners " + std::to_string(a + 1) + " and " + std::to_string(b + 1) +
                             " (a tetrahedron, wedge or other degenerate hex); eight different nodes are needed");
  }

  /// Nodes that are used, renumbered from 0; checks that they exist and that every hex has volume.
  DeckMesh compact(double scale) const {
    if (hexes_.empty())
      fail(line_number_, "the deck ends without a solid element; *NODE and *ELEMENT_SOLID are needed");
    constexpr std::int32_t unused = -1;
    std::vector<std::int32_t> row(nodes_.size(), unused);
    for (const DeckHex& hex : hexes_)
      for (const Id id : hex.node) row[row_of(hex, id)] = 0;
    DeckMesh mesh;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      if (row[i] == unused) continue;
      row[i] = static_cast<std::int32_t>(mesh.x.size());
      mesh.x.push_back(scale * nodes_[i].x);
    }
    for (const DeckHex& hex : hexes_) {
      auto& node = mesh.node.emplace_back();
      for (std::size_t a = 0; a < 8; ++a) node[a] = row[row_of(hex, hex.node[a])];
      require_volume(hex, mesh, node);
    }
    return mesh;
  }

  std::size_t row_of(const DeckHex& hex, Id id) const {
    const auto found = node_row_.find(id);
    if (found == node_row_.end())
      fail(hex.line, "element " + std::to_string(hex.id) + " needs node " + std::to_string(id) +
                         ", which no *NODE gives; the deck has " + std::to_string(nodes_.size()) + " nodes");
    return found->second;
  }

  void require_volume(const DeckHex& hex, const DeckMesh& mesh, const std::array<std::int32_t, 8>& node) const;

  std::istream& in_;
  std::string name_, line_;
  int line_number_ = 0;
  Section section_ = Section::skipped;
  Columns deck_columns_, columns_;
  std::vector<DeckNode> nodes_;
  std::vector<DeckHex> hexes_;
  std::unordered_map<Id, std::size_t> node_row_;
  std::unordered_map<Id, int> hex_line_;
};

constexpr double corner_sign[8][3] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                                      {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};

/// Exact volume of a trilinear hex: det J is quadratic in each parent coordinate, so the 2x2x2 Gauss rule is exact.
double hex_volume(const DeckMesh& mesh, const std::array<std::int32_t, 8>& node) {
  const double g = 1 / std::sqrt(3.0);
  double volume = 0;
  for (const auto& point : corner_sign) {
    core::Mat3 j = core::Mat3::Zero();
    for (std::size_t a = 0; a < 8; ++a) {
      const double* s = corner_sign[a];
      const double p = 1 + s[0] * g * point[0], q = 1 + s[1] * g * point[1], r = 1 + s[2] * g * point[2];
      const core::Vec3 gradient(s[0] * q * r / 8, p * s[1] * r / 8, p * q * s[2] / 8);
      j += gradient * mesh.x[static_cast<std::size_t>(node[a])].transpose();
    }
    volume += j.row(0).dot(j.row(1).cross(j.row(2)));
  }
  return volume;
}

void Reader::require_volume(const DeckHex& hex, const DeckMesh& mesh, const std::array<std::int32_t, 8>& node) const {
  const double volume = hex_volume(mesh, node);
  if (volume > 0) return;
  char number[32];
  std::snprintf(number, sizeof number, "%.3e", volume);
  fail(hex.line, "element " + std::to_string(hex.id) + " has volume " + number +
                     " m3; it must be positive: nodes 1-4 go round one face counter-clockwise seen from nodes 5-8");
}

}  // namespace

DeckMesh read_mesh_deck(std::istream& in, const std::string& name, double scale) {
  if (!(scale > 0) || !std::isfinite(scale))
    throw core::CaseError(name + ": unit of length is " + std::to_string(scale) + " m; it must be positive");
  return Reader(in, name).read(scale);
}

DeckMesh read_mesh_deck(const std::string& path, double scale) {
  std::ifstream in(path);
  if (!in) throw core::CaseError(path + ": cannot be opened; an LS-DYNA keyword deck was expected there");
  return read_mesh_deck(in, path, scale);
}

}  // namespace io
