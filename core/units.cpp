// SPDX-License-Identifier: Apache-2.0
#include "core/units.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>

#include "core/error.hpp"
#include "core/types.hpp"

namespace core {
namespace {

using Powers = std::array<int, 5>;  // of m, kg, s, K, rad

struct Unit {
  double factor = 1;  // what is no power of ten
  int exp10 = 0;
  Powers powers{};
};

struct DimensionRow {
  Dimension dimension;
  const char *name, *article, *si, *example;
  Powers powers;
};

constexpr std::array<DimensionRow, 19> dimensions{{
    {Dimension::none, "pure number", "a", "", "0.5", {0, 0, 0, 0, 0}},
    {Dimension::length, "length", "a", "m", "4 mm", {1, 0, 0, 0, 0}},
    {Dimension::time, "time", "a", "s", "20 us", {0, 0, 1, 0, 0}},
    {Dimension::velocity, "velocity", "a", "m/s", "8 km/s", {1, 0, -1, 0, 0}},
    {Dimension::acceleration, "acceleration", "an", "m/s2", "9.81 m/s2", {1, 0, -2, 0, 0}},
    {Dimension::mass, "mass", "a", "kg", "94 mg", {0, 1, 0, 0, 0}},
    {Dimension::density, "density", "a", "kg/m3", "2785 kg/m3", {-3, 1, 0, 0, 0}},
    {Dimension::pressure, "pressure", "a", "Pa", "1.2 GPa", {-1, 1, -2, 0, 0}},
    {Dimension::specific_energy, "specific energy", "a", "J/kg", "2.5 MJ/kg", {2, 0, -2, 0, 0}},
    {Dimension::specific_heat, "specific heat", "a", "J/(kg K)", "875 J/(kg K)", {2, 0, -2, -1, 0}},
    {Dimension::temperature, "temperature", "a", "K", "294 K", {0, 0, 0, 1, 0}},
    {Dimension::angle, "angle", "an", "rad", "30 deg", {0, 0, 0, 0, 1}},
    {Dimension::rate, "rate", "a", "1/s", "1 1/s", {0, 0, -1, 0, 0}},
    {Dimension::angular_velocity, "angular velocity", "an", "rad/s", "100 rad/s", {0, 0, -1, 0, 1}},
    {Dimension::inverse_pressure, "reciprocal of a pressure", "the", "1/Pa", "65 1/TPa", {1, -1, 2, 0, 0}},
    {Dimension::inverse_temperature, "reciprocal of a temperature", "the", "1/K", "6.2e-4 1/K", {0, 0, 0, -1, 0}},
    {Dimension::momentum, "momentum", "a", "N s", "0.5 N s", {1, 1, -1, 0, 0}},
    {Dimension::energy, "energy", "an", "J", "2.5 kJ", {2, 1, -2, 0, 0}},
    {Dimension::surface_energy, "energy of a surface", "the", "J/m2", "8 kJ/m2", {0, 1, -2, 0, 0}},
}};

const DimensionRow& row(Dimension d) { return dimensions[static_cast<std::size_t>(d)]; }

struct NamedUnit {
  std::string_view name;
  bool takes_prefix;
  double factor;
  int exp10;
  Powers powers;
};

constexpr std::array<NamedUnit, 25> units{{
    {"m", true, 1, 0, {1, 0, 0, 0, 0}},
    {"g", true, 1, -3, {0, 1, 0, 0, 0}},
    {"s", true, 1, 0, {0, 0, 1, 0, 0}},
    {"K", true, 1, 0, {0, 0, 0, 1, 0}},
    {"rad", true, 1, 0, {0, 0, 0, 0, 1}},
    {"N", true, 1, 0, {1, 1, -2, 0, 0}},
    {"Pa", true, 1, 0, {-1, 1, -2, 0, 0}},
    {"J", true, 1, 0, {2, 1, -2, 0, 0}},
    {"Hz", true, 1, 0, {0, 0, -1, 0, 0}},
    {"bar", true, 1, 5, {-1, 1, -2, 0, 0}},
    {"min", false, 60, 0, {0, 0, 1, 0, 0}},
    {"h", false, 3600, 0, {0, 0, 1, 0, 0}},
    {"deg", false, pi / 180, 0, {0, 0, 0, 0, 1}},
    {"rpm", false, pi / 30, 0, {0, 0, -1, 0, 1}},
    {"in", false, 254, -4, {1, 0, 0, 0, 0}},
    {"ft", false, 3048, -4, {1, 0, 0, 0, 0}},
    {"mil", false, 254, -7, {1, 0, 0, 0, 0}},
    {"lb", false, 45359237, -8, {0, 1, 0, 0, 0}},
    {"psi", false, 6894.757293168361, 0, {-1, 1, -2, 0, 0}},
    {"ksi", false, 6894.757293168361, 3, {-1, 1, -2, 0, 0}},
    {"atm", false, 101325, 0, {-1, 1, -2, 0, 0}},
    {"dyn", false, 1, -5, {1, 1, -2, 0, 0}},
    {"erg", false, 1, -7, {2, 1, -2, 0, 0}},
    {"cc", false, 1, -6, {3, 0, 0, 0, 0}},
    {"cal", false, 4.184, 0, {2, 1, -2, 0, 0}},
}};

int prefix_exponent(char c) {
  switch (c) {
    case 'p': return -12;
    case 'n': return -9;
    case 'u': return -6;
    case 'm': return -3;
    case 'c': return -2;
    case 'd': return -1;
    case 'k': return 3;
    case 'M': return 6;
    case 'G': return 9;
    case 'T': return 12;
    default: return 0;
  }
}

std::string text_of(std::string_view s) { return std::string(s); }

/// Signs outside ASCII that people paste: micro, powers, dot, degree, minus, spaces that do not break.
std::string to_ascii(std::string_view text) {
  static constexpr std::array<std::array<std::string_view, 2>, 9> table{{{"\u00b5", "u"}, {"\u03bc", "u"},
      {"\u00b2", "2"}, {"\u00b3", "3"}, {"\u00b7", "*"}, {"\u00b0", "deg"}, {"\u2212", "-"}, {"\u00a0", " "},
      {"\u202f", " "}}};
  std::string result;
  while (!text.empty()) {
    bool found = false;
    for (const auto& [from, to] : table)
      if (text.starts_with(from)) {
        result += to;
        text.remove_prefix(from.size());
        found = true;
        break;
      }
    if (found) continue;
    result += text.front() == '\t' ? ' ' : text.front();
    text.remove_prefix(1);
  }
  const auto first = result.find_first_not_of(' ');
  if (first == std::string::npos) return "";
  return result.substr(first, result.find_last_not_of(' ') - first + 1);
}

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Recursive descent over "product := factor { [*|/| ] factor }", "factor := (product)|name|1, [^][-]digits".
class UnitParser {
 public:
  UnitParser(std::string_view text, Dimension expected) : text_(text), expected_(expected) {}

  Unit parse() {
    const Unit unit = product();
    if (at_ < text_.size()) stop("unexpected '" + text_of(text_.substr(at_, 1)) + "'");
    return unit;
  }

 private:
  [[noreturn]] void stop(const std::string& problem) const {
    throw CaseError(problem + " in the unit '" + text_of(text_) + "'; " + row(expected_).article + " " +
                    row(expected_).name + " is written like \"" + row(expected_).example + "\"");
  }
  void skip_spaces() {
    while (at_ < text_.size() && text_[at_] == ' ') ++at_;
  }

  Unit product() {
    Unit result = factor();
    for (;;) {
      skip_spaces();
      if (at_ == text_.size() || text_[at_] == ')') return result;
      const bool divide = text_[at_] == '/';
      if (divide || text_[at_] == '*') ++at_;
      multiply(result, factor(), divide ? -1 : 1);
    }
  }

  Unit factor() {
    skip_spaces();
    Unit result;
    if (at_ < text_.size() && text_[at_] == '(') {
      constexpr int deepest = 3;  // no unit has more; powers of powers stay small numbers
      if (++depth_ > deepest) stop("too many brackets in each other");
      ++at_;
      result = product();
      if (at_ == text_.size()) stop("')' is missing");
      ++at_;
      --depth_;
    } else if (at_ < text_.size() && text_[at_] == '1') {
      ++at_;
      skip_spaces();
      if (at_ == text_.size() || text_[at_] != '/') stop("a second number");
      return result;
    } else {
      result = named();
    }
    Unit powered;
    multiply(powered, result, power());
    return powered;
  }

  Unit named() {
    const std::size_t first = at_;
    while (at_ < text_.size() && is_letter(text_[at_])) ++at_;
    const std::string_view name = text_.substr(first, at_ - first);
    if (name.empty())
      stop(at_ == text_.size() ? std::string("something is missing at the end")
                               : "unexpected '" + text_of(text_.substr(at_, 1)) + "'");
    for (const NamedUnit& u : units)
      if (u.name == name) return {u.factor, u.exp10, u.powers};
    if (const int exponent = prefix_exponent(name.front()); exponent != 0)
      for (const NamedUnit& u : units)
        if (u.takes_prefix && u.name == name.substr(1)) return {u.factor, u.exp10 + exponent, u.powers};
    stop("unknown name '" + text_of(name) + "'");
  }

  int power() {
    const bool caret = at_ < text_.size() && text_[at_] == '^';
    std::size_t i = at_ + (caret ? 1 : 0);
    const bool minus = i < text_.size() && text_[i] == '-';
    if (minus) ++i;
    if (i == text_.size() || !is_digit(text_[i])) {
      if (caret || minus) stop("a whole number must follow '" + text_of(text_.substr(at_, 1)) + "'");
      return 1;
    }
    const int n = text_[i] - '0';
    at_ = i + 1;
    if (at_ < text_.size() && is_digit(text_[at_])) stop("a power of ten or more");
    return minus ? -n : n;
  }

  static void multiply(Unit& a, const Unit& b, int power) {
    if (b.factor != 1) a.factor *= std::pow(b.factor, power);
    a.exp10 += b.exp10 * power;
    for (std::size_t k = 0; k < a.powers.size(); ++k) a.powers[k] += b.powers[k] * power;
  }

  std::string_view text_;
  Dimension expected_;
  std::size_t at_ = 0;
  int depth_ = 0;  ///< of brackets
};

/// Length of the decimal number that `text` begins with; 0 where there is none.
std::size_t number_length(std::string_view text) {
  std::size_t i = !text.empty() && (text[0] == '-' || text[0] == '+') ? 1 : 0;
  std::size_t digits = 0;
  const auto take_digits = [&] {
    while (i < text.size() && is_digit(text[i])) ++i, ++digits;
  };
  take_digits();
  if (i < text.size() && text[i] == '.') ++i, take_digits();
  if (digits == 0) return 0;
  if (i < text.size() && (text[i] == 'e' || text[i] == 'E')) {
    std::size_t j = i + 1;
    if (j < text.size() && (text[j] == '-' || text[j] == '+')) ++j;
    if (j < text.size() && is_digit(text[j])) {
      while (j < text.size() && is_digit(text[j])) ++j;
      i = j;
    }
  }
  return i;
}

/// The decimal number times 10^shift, rounded once. False where it is out of range.
bool scaled_decimal(std::string_view number, int shift, double& value) {
  if (number.front() == '+') number.remove_prefix(1);
  const std::size_t e = number.find_first_of("eE");
  const std::string_view mantissa = number.substr(0, e);
  long exponent = 0;
  if (e != std::string_view::npos) exponent = std::strtol(text_of(number.substr(e + 1)).c_str(), nullptr, 10);
  if (exponent > 100000 || exponent < -100000) return false;
  const std::string all = text_of(mantissa) + "e" + std::to_string(exponent + shift);
  const auto [end, error] = std::from_chars(all.data(), all.data() + all.size(), value);
  return error == std::errc() && end == all.data() + all.size();
}

bool fits(const Powers& powers, Dimension expected) {
  if (powers == row(expected).powers) return true;
  return expected == Dimension::angular_velocity && powers == row(Dimension::rate).powers;  // radians go unsaid
}

/// "a mass", or its SI units where the dimension has no name here.
std::string described(const Powers& powers) {
  for (const DimensionRow& d : dimensions)
    if (d.powers == powers) return text_of(d.article) + " " + d.name;
  static constexpr std::array<const char*, 5> names{"m", "kg", "s", "K", "rad"};
  std::string result = "in";
  for (std::size_t k = 0; k < powers.size(); ++k) {
    if (powers[k] == 0) continue;
    result += text_of(" ") + names[k];
    if (powers[k] != 1) result += "^" + std::to_string(powers[k]);
  }
  return result;
}

}  // namespace

const char* dimension_name(Dimension d) { return row(d).name; }
const char* dimension_example(Dimension d) { return row(d).example; }
const char* si_unit(Dimension d) { return row(d).si; }

double parse_quantity(std::string_view given, Dimension expected) {
  const DimensionRow& want = row(expected);
  const std::string needed = text_of(want.article) + " " + want.name;
  const std::string example = text_of("for example \"") + want.example + "\"";
  const std::string text = to_ascii(given);
  const std::size_t length = number_length(text);
  if (length == 0)
    throw CaseError("'" + text_of(given) + "' does not begin with a number; " + needed + " is needed, " + example);
  const std::string_view number = std::string_view(text).substr(0, length);
  std::string_view rest = std::string_view(text).substr(length);
  while (rest.starts_with(' ')) rest.remove_prefix(1);
  if (rest.starts_with(','))
    throw CaseError("'" + text_of(given) + "' has a comma in it; decimals are written with a point, " + example);

  if (expected == Dimension::angular_velocity && rest.find("Hz") != std::string_view::npos)
    throw CaseError("'" + text_of(given) + "' may mean turns or radians; give rpm, deg/s or rad/s, " + example);

  const Unit unit = rest.empty() ? Unit{} : UnitParser(rest, expected).parse();
  if (!rest.empty() && !fits(unit.powers, expected))
    throw CaseError("'" + text_of(given) + "' is " + described(unit.powers) + ", but " + needed + " is needed, " + example);
  double value = 0;
  if (!scaled_decimal(number, unit.exp10, value) || !std::isfinite(value * unit.factor))
    throw CaseError("'" + text_of(given) + "' is out of the range of numbers; " + needed + " is needed, " + example);
  return value * unit.factor;
}

bool parse_number(std::string_view text, double& value) {
  return !text.empty() && number_length(text) == text.size() && scaled_decimal(text, 0, value);
}

std::string exact_decimal(double value) {
  std::array<char, 40> buffer;
  char* const last = buffer.data() + buffer.size();
  const bool no_integer = value == 0 ? std::signbit(value) : std::abs(value) >= 0x1p63;
  const auto [end, error] = no_integer ? std::to_chars(buffer.data(), last, value, std::chars_format::scientific)
                                       : std::to_chars(buffer.data(), last, value);
  return error == std::errc() ? std::string(buffer.data(), end) : std::string("nan");
}

}  // namespace core
