// SPDX-License-Identifier: Apache-2.0
#include "io/toml_reader.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "core/error.hpp"

namespace io::toml_reader {
namespace {

/// toml++'s tree to ours. `name` is the file, or with line_numbers = false the whole of `where`.
class Converter {
 public:
  Converter(std::string name, bool line_numbers) : name_(std::move(name)), line_numbers_(line_numbers) {}

  Node convert(const toml::node& from, int line) const {
    Node to;
    to.line = line_numbers_ ? line : 0;
    to.where = to.line > 0 ? fmt::format("{}:{}", name_, to.line) : name_;
    if (const auto* table = from.as_table()) {
      add_children(*table, to);
    } else if (const auto* array = from.as_array()) {
      to.kind = Node::Kind::array;
      for (const toml::node& item : *array) to.items.push_back(convert(item, line_of(item.source(), line)));
    } else {
      convert_scalar(from, to);
    }
    return to;
  }

 private:
  static int line_of(const toml::source_region& region, int otherwise) {
    return region.begin.line > 0 ? static_cast<int>(region.begin.line) : otherwise;
  }

  /// toml++ sorts by name; ours keep the order of the file.
  void add_children(const toml::table& table, Node& to) const {
    struct Child {
      toml::source_position at;
      const toml::key* key;
      const toml::node* value;
    };
    std::vector<Child> children;
    for (const auto& [key, value] : table) children.push_back({key.source().begin, &key, &value});
    std::stable_sort(children.begin(), children.end(), [](const Child& a, const Child& b) { return a.at < b.at; });
    for (const Child& c : children) {
      const int key_line = c.at.line > 0 ? static_cast<int>(c.at.line) : to.line;
      to.children.push_back({std::string(c.key->str()), convert(*c.value, key_line)});
    }
  }

  static void convert_scalar(const toml::node& from, Node& to) {
    if (const auto* text = from.as_string()) {
      to.kind = Node::Kind::text;
      to.text = text->get();
    } else if (const auto* integer = from.as_integer()) {
      to.kind = Node::Kind::integer;
      to.integer = integer->get();
      to.real = static_cast<double>(to.integer);
      to.text = std::to_string(to.integer);
    } else if (const auto* real = from.as_floating_point()) {
      to.kind = Node::Kind::real;
      to.real = real->get();
      to.text = core::exact_decimal(to.real);
    } else if (const auto* boolean = from.as_boolean()) {
      to.kind = Node::Kind::boolean;
      to.boolean = boolean->get();
      to.text = to.boolean ? "true" : "false";
    } else {
      to.kind = Node::Kind::date;
      to.text = "a date or time";
    }
  }

  std::string name_;
  bool line_numbers_;
};

std::string trimmed(std::string_view s) {
  while (!s.empty() && std::isspace(static_cast<unsigned char>(s.front()))) s.remove_prefix(1);
  while (!s.empty() && std::isspace(static_cast<unsigned char>(s.back()))) s.remove_suffix(1);
  return std::string(s);
}

/// Where `separator` stands outside quotes and brackets, from `first` on; npos where nowhere.
std::size_t find_outside(std::string_view s, char separator, std::size_t first, bool brackets) {
  char quote = 0;
  int depth = 0;
  for (std::size_t i = first; i < s.size(); ++i) {
    const char c = s[i];
    if (quote) {
      if (c == quote) quote = 0;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (brackets && (c == '[' || c == '{' || c == '(')) {
      ++depth;
    } else if (brackets && (c == ']' || c == '}' || c == ')')) {
      --depth;
    } else if (c == separator && depth == 0) {
      return i;
    }
  }
  return std::string_view::npos;
}

std::vector<std::string> split(std::string_view s, char separator, bool brackets) {
  std::vector<std::string> parts;
  std::size_t first = 0;
  for (;;) {
    const std::size_t end = find_outside(s, separator, first, brackets);
    parts.push_back(trimmed(s.substr(first, end == std::string_view::npos ? end : end - first)));
    if (end == std::string_view::npos) return parts;
    first = end + 1;
  }
}

std::string unquoted(const std::string& s) {
  const bool quoted_text = s.size() >= 2 && (s.front() == '"' || s.front() == '\'') && s.back() == s.front();
  return quoted_text ? s.substr(1, s.size() - 2) : s;
}

bool is_index(const std::string& s) {
  return !s.empty() && s.size() < 7 && std::all_of(s.begin(), s.end(), [](unsigned char c) { return std::isdigit(c); });
}

/// Names of the tables of an array, "0", "1" ... where they have none.
std::vector<std::string> item_names(const Node& array) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < array.items.size(); ++i) {
    const Node* name = array.items[i].find("name");
    names.push_back(name && name->kind == Node::Kind::text ? name->text : std::to_string(i));
  }
  return names;
}

/// The item of an array that a part of an override's key means, by name or by index.
Node& item_of(Node& array, const std::string& part, const std::string& where, const std::string& key) {
  const std::vector<std::string> names = item_names(array);
  for (std::size_t i = 0; i < names.size(); ++i)
    if (names[i] == part) return array.items[i];
  if (is_index(part) && std::stoul(part) < array.items.size()) return array.items[std::stoul(part)];
  fail(where, key, fmt::format("there is no '{}'{}; there {}: {}, or 0 ... {} by index", part, did_you_mean(part, names),
                               names.size() == 1 ? "is" : "are", join(names), names.size() - 1));
}

Node empty_table(const std::string& where) {
  Node n;
  n.where = where;
  return n;
}

/// Optimal string alignment distance, without regard to case.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  const auto low = [](char c) { return std::tolower(static_cast<unsigned char>(c)); };
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) d[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i)
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const bool same = low(a[i - 1]) == low(b[j - 1]);
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (same ? 0 : 1)});
      if (i > 1 && j > 1 && low(a[i - 1]) == low(b[j - 2]) && low(a[i - 2]) == low(b[j - 1]))
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  return d[a.size()][b.size()];
}

std::string lower(std::string_view s) {
  std::string r(s);
  for (char& c : r) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return r;
}

std::string told(const Limits& l, const char* unit) {
  const auto number = [&](double v) { return fmt::format("{:g}{}{}", v, *unit && v != 0 ? " " : "", v != 0 ? unit : ""); };
  const bool has_low = std::isfinite(l.low), has_high = std::isfinite(l.high);
  const std::string low = fmt::format("{} {}", l.low_open ? "greater than" : "at least", number(l.low));
  const std::string high = fmt::format("{} {}", l.high_open ? "less than" : "at most", number(l.high));
  if (has_low && has_high) return low + " and " + high;
  return has_low ? low : high;
}

std::string read_whole(const std::string& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) throw core::CaseError(path + ": is a folder, not a file");
  errno = 0;
  std::ifstream in(path, std::ios::binary);
  if (!in) throw core::CaseError(fmt::format("{}: cannot be opened: {}", path, std::strerror(errno ? errno : ENOENT)));
  std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (in.bad()) throw core::CaseError(fmt::format("{}: cannot be read: {}", path, std::strerror(errno)));
  return text;
}

}  // namespace

const Node* Node::find(std::string_view key) const {
  for (const auto& [name, child] : children)
    if (name == key) return &child;
  return nullptr;
}

Node* Node::find(std::string_view key) { return const_cast<Node*>(std::as_const(*this).find(key)); }

void Node::set(const std::string& key, Node value) {
  if (Node* old = find(key))
    *old = std::move(value);
  else
    children.push_back({key, std::move(value)});
}

Node parse_text(const std::string& text, const std::string& name) {
  try {
    const toml::table table = toml::parse(text, name);
    return Converter(name, true).convert(table, 0);
  } catch (const toml::parse_error& e) {
    throw core::CaseError(fmt::format("{}:{}: this is no valid TOML: {} (column {})", name, e.source().begin.line,
                                      e.description(), e.source().begin.column));
  }
}

Node parse_file(const std::string& path) { return parse_text(read_whole(path), path); }

/// RFC 3629, which TOML and JSON ask for.
static bool is_utf8(std::string_view text) {
  for (std::size_t k = 0; k < text.size();) {
    const auto byte = [&](std::size_t at) { return at < text.size() ? static_cast<unsigned char>(text[at]) : 0u; };
    const unsigned first = byte(k);
    const std::size_t more = first < 0x80 ? 0 : first >= 0xC2 && first < 0xE0 ? 1 : (first & 0xF0) == 0xE0 ? 2 : first >= 0xF0 && first < 0xF5 ? 3 : 4;
    if (more == 4) return false;
    for (std::size_t n = 1; n <= more; ++n)
      if ((byte(k + n) & 0xC0) != 0x80) return false;
    const unsigned second = byte(k + 1);
    if ((first == 0xE0 && second < 0xA0) || (first == 0xED && second > 0x9F) || (first == 0xF0 && second < 0x90) || (first == 0xF4 && second > 0x8F)) return false;
    k += more + 1;
  }
  return true;
}

void check_utf8(const std::string& text, const std::string& where, const std::string& key) {
  if (!is_utf8(text)) fail(where, key, "holds bytes that are no UTF-8, and case.toml and summary.json could not");
}

Node parse_value(const std::string& text, const std::string& where) {
  check_utf8(text, where, "");
  try {
    const toml::table table = toml::parse("value = " + text + "\n");
    if (table.size() == 1) return Converter(where, false).convert(*table.get("value"), 0);
  } catch (const toml::parse_error&) {
    // no TOML value: a word, a quantity or a list of them without quotes
  }
  Node node;
  node.where = where;
  if (text.size() >= 2 && text.front() == '[' && text.back() == ']') {
    node.kind = Node::Kind::array;
    for (const std::string& part : split(std::string_view(text).substr(1, text.size() - 2), ',', true))
      node.items.push_back(parse_value(part, where));
    return node;
  }
  node.kind = Node::Kind::text;
  node.text = unquoted(text);
  return node;
}

void apply_override(Node& root, const std::string& assignment) {
  const std::size_t equals = find_outside(assignment, '=', 0, false);
  if (equals == std::string::npos || trimmed(assignment.substr(0, equals)).empty())
    throw core::CaseError(fmt::format("--set {}: must be key=value, for example --set run.end=\"5 us\"", assignment));
  const std::string key = trimmed(std::string_view(assignment).substr(0, equals));
  const std::string value = trimmed(std::string_view(assignment).substr(equals + 1));
  const std::string where = "--set " + key;
  if (value.empty()) fail(where, "", "a value must follow '='");

  std::vector<std::string> parts = split(key, '.', false);
  for (std::string& part : parts) {
    part = unquoted(part);
    if (part.empty()) fail(where, "", "a part of the key is empty");
  }
  Node* node = &root;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const bool last = k + 1 == parts.size();
    if (node->kind == Node::Kind::array && !node->items.empty()) {
      node = &item_of(*node, parts[k], where, "");
      if (last) *node = parse_value(value, where);
    } else if (!node->is_table()) {
      fail(where, "", fmt::format("'{}' is a value, not a table: it has no '{}'", parts[k - 1], parts[k]));
    } else if (last) {
      node->set(parts[k], parse_value(value, where));
    } else {
      if (!node->find(parts[k])) {
        if (k == 0 && (parts[0] == "body" || parts[0] == "wall"))
          fail(where, "", fmt::format("the case has no [[{}]]", parts[0]));
        node->set(parts[k], empty_table(where));
      }
      node = node->find(parts[k]);
    }
  }
}

std::vector<std::string> nearest(std::string_view name, const std::vector<std::string>& valid) {
  std::vector<std::pair<std::size_t, std::string>> found;
  const std::string small = lower(name);
  for (const std::string& v : valid) {
    const std::string other = lower(v);
    const bool part = small.size() > 2 && other.size() > 2 &&
                      (other.find(small) != std::string::npos || small.find(other) != std::string::npos);
    const std::size_t distance = part ? 1 : edit_distance(small, other);
    const std::size_t limit = std::max<std::size_t>(1, (2 * std::max(small.size(), other.size())) / 5);
    if (distance <= limit) found.emplace_back(distance, v);
  }
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::string> result;
  for (const auto& [distance, v] : found)
    if (result.size() < 3 && distance <= found.front().first + 1) result.push_back(v);
  return result;
}

std::string did_you_mean(std::string_view name, const std::vector<std::string>& valid) {
  const std::vector<std::string> near = nearest(name, valid);
  return near.empty() ? std::string() : fmt::format("; did you mean '{}'?", fmt::join(near, "' or '"));
}

std::string join(const std::vector<std::string>& names) { return fmt::format("{}", fmt::join(names, ", ")); }

void fail(const std::string& where, const std::string& key, const std::string& problem) {
  // an override often names its key already
  const bool needs_key = !key.empty() && !where.starts_with("--mode") && !(where.starts_with("--set ") && where.ends_with(key));
  throw core::CaseError(needs_key ? fmt::format("{}: {}: {}", where, key, problem) : fmt::format("{}: {}", where, problem));
}

std::string shown(const Node& node) {
  switch (node.kind) {
    case Node::Kind::table: return "{...}";
    case Node::Kind::text: return toml_string(node.text);
    case Node::Kind::array: {
      std::vector<std::string> parts;
      for (const Node& item : node.items) parts.push_back(shown(item));
      return "[" + join(parts) + "]";
    }
    default: return node.text;
  }
}

double to_number(const Node& node, const std::string& key, core::Dimension d, Limits limits) {
  double value = node.real;
  if (node.kind == Node::Kind::text) {
    try {
      value = core::parse_quantity(node.text, d);
    } catch (const core::CaseError& e) {
      fail(node.where, key, e.what());
    }
  } else if (!node.is_number()) {
    fail(node.where, key, fmt::format("{} is no number; needed: {}, as a number in SI or a string with a unit, for example \"{}\"",
                                      shown(node), core::dimension_name(d), core::dimension_example(d)));
  }
  if (!std::isfinite(value)) fail(node.where, key, fmt::format("{} is not finite", shown(node)));
  const bool low = limits.low_open ? value > limits.low : value >= limits.low;
  const bool high = limits.high_open ? value < limits.high : value <= limits.high;
  if (!low || !high)
    fail(node.where, key, fmt::format("{} is out of range; must be {}", shown(node), told(limits, core::si_unit(d))));
  return value;
}

Table::Table(const Node& node, std::string path, std::vector<std::string> keys) : node_(node), path_(std::move(path)) {
  if (!node.is_table())
    toml_reader::fail(node.where, path_, fmt::format("{} is no table; must hold some of {}", shown(node), join(keys)));
  for (const auto& [name, child] : node.children) {
    if (std::find(keys.begin(), keys.end(), name) != keys.end()) continue;
    toml_reader::fail(child.where, full_key(name), fmt::format("unknown key{}{} valid here: {}", did_you_mean(name, keys),
                                                               nearest(name, keys).empty() ? ";" : "", join(keys)));
  }
}

std::string Table::full_key(std::string_view key) const {
  return path_.empty() ? std::string(key) : fmt::format("{}.{}", path_, key);
}

const Node& Table::require(std::string_view key) const {
  const Node* node = node_.find(key);
  if (!node) toml_reader::fail(node_.where, full_key(key), "is missing");
  return *node;
}

void Table::fail(std::string_view key, const std::string& problem) const {
  const Node* node = node_.find(key);
  toml_reader::fail(node ? node->where : node_.where, full_key(key), problem);
}

double Table::number(std::string_view key, core::Dimension d, Limits limits) const {
  const Node* node = node_.find(key);
  if (!node)
    fail(key, fmt::format("is missing; needed: {}, for example {} = \"{}\"", core::dimension_name(d), key,
                          core::dimension_example(d)));
  return to_number(*node, full_key(key), d, limits);
}

int Table::integer(std::string_view key, int low, int high) const {
  const Node& node = require(key);
  const bool whole = node.is_number() && node.real == std::floor(node.real);
  if (!whole) fail(key, fmt::format("{} is no whole number; must be from {} to {}", shown(node), low, high));
  if (node.real < low || node.real > high)
    fail(key, fmt::format("{} is out of range; must be from {} to {}", shown(node), low, high));
  return static_cast<int>(node.real);
}

bool Table::boolean(std::string_view key) const {
  const Node& node = require(key);
  if (node.kind != Node::Kind::boolean) fail(key, shown(node) + " is neither true nor false (without quotes)");
  return node.boolean;
}

std::string Table::text(std::string_view key) const {
  const Node& node = require(key);
  if (node.kind != Node::Kind::text) fail(key, shown(node) + " is no string; must be a text in quotes");
  return node.text;
}

std::string Table::choice(std::string_view key, const std::vector<std::string>& valid) const {
  const std::string value = text(key);
  if (std::find(valid.begin(), valid.end(), value) == valid.end()) {
    const std::string hint = did_you_mean(value, valid);
    fail(key, fmt::format("\"{}\" is not known{}{} valid: {}", value, hint, hint.empty() ? ";" : "", join(valid)));
  }
  return value;
}

std::vector<double> Table::numbers(std::string_view key, std::size_t count, core::Dimension d, Limits limits) const {
  const Node& node = require(key);
  if (node.kind != Node::Kind::array || node.items.size() != count) {
    std::vector<std::string> example(count, fmt::format("\"{}\"", core::dimension_example(d)));
    fail(key, fmt::format("{} must be a list of {}, for example [{}]", shown(node), count, join(example)));
  }
  std::vector<double> values;
  for (std::size_t k = 0; k < count; ++k)
    values.push_back(to_number(node.items[k], fmt::format("{}[{}]", full_key(key), k), d, limits));
  return values;
}

core::Vec3 Table::vector(std::string_view key, core::Dimension d) const {
  const std::vector<double> v = numbers(key, 3, d, any_number);
  return {v[0], v[1], v[2]};
}

std::vector<std::string> Table::texts(std::string_view key) const {
  const Node& node = require(key);
  if (node.kind == Node::Kind::text) return {node.text};
  if (node.kind != Node::Kind::array) fail(key, shown(node) + " must be a text in quotes or a list of them");
  std::vector<std::string> result;
  for (const Node& item : node.items) {
    if (item.kind != Node::Kind::text) fail(key, shown(item) + " in the list must be a text in quotes");
    result.push_back(item.text);
  }
  return result;
}

void Table::read(std::string_view key, double& value, core::Dimension d, Limits limits) const {
  if (has(key)) value = number(key, d, limits);
}
void Table::read(std::string_view key, int& value, int low, int high) const {
  if (has(key)) value = integer(key, low, high);
}
void Table::read(std::string_view key, bool& value) const {
  if (has(key)) value = boolean(key);
}
void Table::read(std::string_view key, std::string& value) const {
  if (has(key)) value = text(key);
}
void Table::read(std::string_view key, core::Vec3& value, core::Dimension d) const {
  if (has(key)) value = vector(key, d);
}

std::string toml_string(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\')
      result += {'\\', c};
    else if (c == '\n')
      result += "\\n";
    else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
      result += fmt::format("\\u{:04X}", static_cast<unsigned>(c));
    else
      result += c;
  }
  return result + "\"";
}

std::string as_key(std::string_view key) {
  const auto bare = [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '-'; };
  return !key.empty() && std::all_of(key.begin(), key.end(), bare) ? std::string(key) : toml_string(key);
}

}  // namespace io::toml_reader
