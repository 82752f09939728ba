// SPDX-License-Identifier: Apache-2.0
// TOML as a small tree whose every value knows where it came from, and typed getters whose errors say file, line, key,
// value and what would be valid. toml++ itself stays inside toml_reader.cpp: it is slow to compile.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/types.hpp"
#include "core/units.hpp"

namespace io::toml_reader {

/// One value of the tree: a table (children in the order of the file), an array (items), or a scalar.
struct Node {
  enum class Kind { table, array, text, integer, real, boolean, date };
  Kind kind = Kind::table;
  std::string text;                                   ///< Kind::text; otherwise how a scalar is written
  std::int64_t integer = 0;
  double real = 0;                                    ///< Kind::real and Kind::integer
  bool boolean = false;
  struct Child;
  std::vector<Child> children;
  std::vector<Node> items;
  std::string where;                                  ///< "case.toml:12" or "--set run.end"
  int line = 0;                                       ///< 0: not from a file
  std::string source;                                 ///< materials: the publication a value was taken from

  const Node* find(std::string_view key) const;
  Node* find(std::string_view key);
  void set(const std::string& key, Node value);
  bool is_table() const { return kind == Kind::table; }
  bool is_number() const { return kind == Kind::integer || kind == Kind::real; }
  bool from_override() const { return where.starts_with("--"); }
};
struct Node::Child {
  std::string key;
  Node value;
};

/// The tree of a file, or of a text that calls itself `name`. Throws CaseError "name:line: ..." for what is no TOML.
Node parse_file(const std::string& path);
Node parse_text(const std::string& text, const std::string& name);

/// Applies "run.end=5 us" or "body.bumper.thickness=1 mm" (by name or index) to the tree; adds keys that are not there.
/// A part of the key that contains dots is put in double quotes.
void apply_override(Node& root, const std::string& assignment);

/// Throws CaseError where the text is no UTF-8.
void check_utf8(const std::string& text, const std::string& where, const std::string& key);

/// The scalar value or array that a text on the command line stands for: TOML where it is, a string where it is not.
Node parse_value(const std::string& text, const std::string& where);

/// Names of `valid` that `name` may be a misspelling of, nearest first, at most three.
std::vector<std::string> nearest(std::string_view name, const std::vector<std::string>& valid);
/// "; did you mean 'end'?" or "".
std::string did_you_mean(std::string_view name, const std::vector<std::string>& valid);
/// "a, b, c".
std::string join(const std::vector<std::string>& names);

/// Limits of a number, and how they are told.
struct Limits {
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
  bool low_open = false, high_open = false;           ///< the limit itself is not valid
};
constexpr double no_limit = std::numeric_limits<double>::infinity();
constexpr Limits any_number{};
constexpr Limits positive{0, no_limit, true, false};
constexpr Limits not_negative{0, no_limit, false, false};

/// Throws CaseError "where: key: problem".
[[noreturn]] void fail(const std::string& where, const std::string& key, const std::string& problem);

/// A table being read. The constructor refuses keys that are not in `keys`.
class Table {
 public:
  /// `path` is how the table is called in messages: "run", "body 'bumper'".
  Table(const Node& node, std::string path, std::vector<std::string> keys);

  bool has(std::string_view key) const { return node_.find(key) != nullptr; }
  const Node& require(std::string_view key) const;
  const Node* find(std::string_view key) const { return node_.find(key); }
  const std::string& path() const { return path_; }
  const std::string& where() const { return node_.where; }

  double number(std::string_view key, core::Dimension d, Limits limits) const;
  int integer(std::string_view key, int low, int high) const;
  bool boolean(std::string_view key) const;
  std::string text(std::string_view key) const;
  std::string choice(std::string_view key, const std::vector<std::string>& valid) const;
  std::vector<double> numbers(std::string_view key, std::size_t count, core::Dimension d, Limits limits) const;
  core::Vec3 vector(std::string_view key, core::Dimension d) const;
  std::vector<std::string> texts(std::string_view key) const;  ///< one string or an array of strings

  /// The same, leaving `value` as it is where the key is absent.
  void read(std::string_view key, double& value, core::Dimension d, Limits limits) const;
  void read(std::string_view key, int& value, int low, int high) const;
  void read(std::string_view key, bool& value) const;
  void read(std::string_view key, std::string& value) const;
  void read(std::string_view key, core::Vec3& value, core::Dimension d) const;

  /// Throws with this table's path and the key's own line (or the table's, where it is absent).
  [[noreturn]] void fail(std::string_view key, const std::string& problem) const;
  std::string full_key(std::string_view key) const;

 private:
  const Node& node_;
  std::string path_;
};

/// A scalar as a number of dimension d; as messages show it.
double to_number(const Node& node, const std::string& key, core::Dimension d, Limits limits);
std::string shown(const Node& node);

/// A TOML basic string with quotes and escapes; a key, quoted where it has to be.
std::string toml_string(std::string_view text);
std::string as_key(std::string_view key);

}  // namespace io::toml_reader
