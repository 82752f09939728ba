// SPDX-License-Identifier: Apache-2.0
#include "eos/sesame_file.hpp"

#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <set>
#include <sstream>

#include "core/error.hpp"

namespace eos {

namespace {

constexpr double Mg_per_m3 = 1e3, GPa = 1e9, MJ_per_kg = 1e6;
constexpr int words_per_line = 5, comment_line = 80;

class Reader {
 public:
  Reader(const std::string& path, int number) : path_(path), number_(number), in_(path) {
    if (!in_) throw core::CaseError(path + ": cannot be opened; a SESAME table in ASCII is expected");
  }

  SesameMaterial read() {
    SesameMaterial m;
    m.number = number_;
    Header h;
    bool found = false;
    while (next_header(h)) {
      seen_.insert(h.material);
      if (h.material != number_ || h.index) {
        pass(h);
        continue;
      }
      found = true;
      record_ = h.record;
      take(h, m);
    }
    record_ = 0;
    if (!found) fail("is not in the file; valid: " + list());
    if (m.grids.empty()) fail("has none of the records 301, 303, 304, 305, 306; one of them is needed");
    if (!(m.rho_0 > 0)) fail("has no record 201 with a positive normal density");
    return m;
  }

 private:
  struct Header {
    int material = 0, record = 0;
    long words = 0;
    int width = 15;     ///< characters a word
    bool index = false;
  };

  [[noreturn]] void fail(const std::string& what) const {
    std::string text = path_ + ":" + std::to_string(line_) + ": material " + std::to_string(number_);
    if (record_) text += ", record " + std::to_string(record_);
    throw core::CaseError(text + ": " + what);
  }

  std::string list() const {
    std::string text;
    for (const int n : seen_) text += (text.empty() ? "" : ", ") + std::to_string(n);
    return text.empty() ? "a file with SESAME records" : text;
  }

  bool next_line() {
    if (!std::getline(in_, text_)) return false;
    if (!text_.empty() && text_.back() == '\r') text_.pop_back();
    ++line_;
    return true;
  }

  std::string beginning() const {
    std::string text = text_.substr(0, 40);
    for (char& c : text)
      if (!std::isprint(static_cast<unsigned char>(c))) c = '?';
    return '"' + text + '"';
  }

  /// The number after "NAME =" in an upper-case header.
  long after(const char* name) const {
    const auto at = text_.find(name);
    const auto equals = at == std::string::npos ? at : text_.find('=', at);
    if (equals == std::string::npos) fail(std::string("the header has no ") + name + " = ...");
    return std::strtol(text_.c_str() + equals + 1, nullptr, 10);
  }

  /// The card that ends a file; files are joined as they are.
  bool ends_file() const { return std::atoi(text_.c_str()) == 2; }

  bool next_header(Header& h) {
    do {
      if (!next_line()) return false;
    } while (text_.find_first_not_of(' ') == std::string::npos || ends_file());
    if (text_.find("MATID") != std::string::npos) {
      material_ = static_cast<int>(after("MATID"));
      h = {material_, 0, after("NWDS"), 16, true};
    } else if (text_.find("TYPE") != std::string::npos) {
      h = {material_, static_cast<int>(after("TYPE")), after("NWDS"), 16, false};
    } else {
      std::istringstream s(text_);
      int file = -1;
      if (!(s >> file)) fail("not a record header: " + beginning());
      bool read = static_cast<bool>(s >> h.material >> h.record >> h.words);
      if (!read || h.record > 9999) {  // fields of 2, 6, 6, 6 characters that touch
        read = text_.size() >= 20;
        const auto field = [&](std::size_t at, std::size_t n) { return read ? std::atol(text_.substr(at, n).c_str()) : 0; };
        h.material = static_cast<int>(field(2, 6)), h.record = static_cast<int>(field(8, 6)), h.words = field(14, 6);
      }
      if (!read || h.material <= 0 || h.record <= 0)
        fail("not a record header: " + beginning() + "; valid: file number, material, record, word count, or RECORD "
             "TYPE = ... NWDS = ...");
      h.width = 15, h.index = false;
    }
    constexpr long most_words = 1000000000;
    if (h.words <= 0 || h.words > most_words)
      fail("the header counts " + std::to_string(h.words) + " words; it must be from 1 to " + std::to_string(most_words));
    return true;
  }

  static bool is_comment(const Header& h) { return h.width == 15 && h.record >= 100 && h.record < 200; }

  void pass(const Header& h) {
    const long per_line = is_comment(h) ? comment_line : words_per_line;
    for (long i = 0; i < (h.words + per_line - 1) / per_line; ++i)
      if (!next_line()) fail("the file ends within material " + std::to_string(h.material) + ", record " + std::to_string(h.record));
  }

  /// Fortran may leave the E out of an exponent of three digits.
  double word(std::string field) const {
    const auto sign = field.find_last_of("+-");
    if (sign != std::string::npos && sign > 0 && (std::isdigit(field[sign - 1]) || field[sign - 1] == '.')) field.insert(sign, "E");
    for (char& c : field)
      if (c == 'D' || c == 'd') c = 'E';
    char* end = nullptr;
    const double value = std::strtod(field.c_str(), &end);
    while (*end == ' ') ++end;
    if (end == field.c_str() || *end != 0 || !std::isfinite(value)) fail("\"" + field + "\" is no finite number; valid: 1.00000000E+00");
    return value;
  }

  std::vector<double> words(const Header& h) {
    std::vector<double> all;  // grows with what is there, not with what the header says
    int width = h.width;
    while (static_cast<long>(all.size()) < h.words) {
      if (!next_line())
        fail("the file ends after " + std::to_string(all.size()) + " of " + std::to_string(h.words) + " words");
      if (all.empty() && width == 15 && text_.size() >= 5 * 22) width = 22;
      for (int k = 0; k < words_per_line && static_cast<long>(all.size()) < h.words; ++k) {
        const auto at = static_cast<std::size_t>(k * width);
        const std::string field = at < text_.size() ? text_.substr(at, static_cast<std::size_t>(width)) : "";
        if (field.find_first_not_of(' ') == std::string::npos)
          fail("the line has " + std::to_string(k) + " words in fields of " + std::to_string(width) + "; word " +
               std::to_string(all.size() + 1) + " of " + std::to_string(h.words) + " is missing");
        all.push_back(word(field));
      }
    }
    return all;
  }

  void take(const Header& h, SesameMaterial& m) {
    switch (h.record) {
      case 201: {
        const auto w = words(h);
        if (w.size() < 3) fail("has " + std::to_string(w.size()) + " words; Z, A and the normal density are needed");
        m.Z = w[0], m.A = w[1], m.rho_0 = w[2] * Mg_per_m3;
        if (w.size() > 3) m.bulk_modulus = w[3] * GPa;
        return;
      }
      case 301: case 303: case 304: case 305: case 306:
        m.grids[h.record] = grid(words(h));
        return;
      case 401:
        m.vapour = vapour(words(h));
        return;
      default:
        pass(h);
    }
  }

  void check_rising(const std::vector<double>& a, const char* what) const {
    for (std::size_t i = 0; i < a.size(); ++i)
      if (a[i] < 0 || (i > 0 && a[i] < a[i - 1]))
        fail(std::string(what) + " number " + std::to_string(i + 1) + " is " + std::to_string(a[i]) +
             ": they must not be negative and must not fall");
  }

  SesameGrid grid(const std::vector<double>& w) const {
    const double n_r = w[0], n_t = w.size() > 1 ? w[1] : 0;
    if (!(n_r >= 1 && n_t >= 1 && n_r == std::floor(n_r) && n_t == std::floor(n_t) && n_r * n_t < 1e8))
      fail("begins with " + std::to_string(n_r) + " densities and " + std::to_string(n_t) + " temperatures; both must be whole numbers from 1");
    const auto n = static_cast<std::size_t>(n_r), k = static_cast<std::size_t>(n_t), head = 2 + n + k, cells = n * k;
    if (w.size() != head + 2 * cells && w.size() != head + 3 * cells)
      fail("has " + std::to_string(w.size()) + " words; " + std::to_string(n) + " densities and " + std::to_string(k) +
           " temperatures need " + std::to_string(head + 2 * cells) + " or, with Helmholtz energies, " + std::to_string(head + 3 * cells));
    const auto part = [&](std::size_t from, std::size_t count, double unit) {
      std::vector<double> a(w.begin() + static_cast<std::ptrdiff_t>(from), w.begin() + static_cast<std::ptrdiff_t>(from + count));
      for (double& x : a) x *= unit;
      return a;
    };
    SesameGrid g{part(2, n, Mg_per_m3), part(2 + n, k, 1), part(head, cells, GPa), part(head + cells, cells, MJ_per_kg), {}};
    if (w.size() == head + 3 * cells) g.f = part(head + 2 * cells, cells, MJ_per_kg);
    check_rising(g.rho, "density"), check_rising(g.T, "temperature");
    return g;
  }

  SesameVapour vapour(const std::vector<double>& w) const {
    const double count = w[0];
    const std::size_t n = count >= 1 && count < 1e8 ? static_cast<std::size_t>(count) : 0;
    if (n == 0 || w.size() < 1 + 6 * n) fail("has " + std::to_string(w.size()) + " words for " + std::to_string(count) + " temperatures");
    const auto column = [&](std::size_t k, double unit) {
      std::vector<double> a;
      for (std::size_t i = 1 + k * n; i < 1 + (k + 1) * n && i < w.size(); ++i) a.push_back(w[i] * unit);
      return a;
    };
    return {column(0, GPa), column(1, 1), column(2, Mg_per_m3), column(3, Mg_per_m3),
            column(4, MJ_per_kg), column(5, MJ_per_kg), column(6, MJ_per_kg), column(7, MJ_per_kg)};
  }

  std::string path_;
  int number_, material_ = 0, record_ = 0;
  std::ifstream in_;
  std::string text_;
  long line_ = 0;
  std::set<int> seen_;
};

void add_record(std::string& text, int number, int record, const std::vector<double>& words) {
  char line[128];
  std::snprintf(line, sizeof line, "%2d%6d%6d%6zu   r%9d%9d%4d", text.empty() ? 0 : 1, number, record, words.size(), 0, 0, 1);
  text += line;
  text += '\n';
  for (std::size_t i = 0; i < words.size(); ++i) {
    std::snprintf(line, sizeof line, "%15.8E", words[i]);
    text += line;
    const std::size_t k = i % words_per_line;
    if (k + 1 == words_per_line || i + 1 == words.size()) {
      text += std::string(15 * (words_per_line - k - 1), ' ');
      for (std::size_t j = 0; j < words_per_line; ++j) text += j <= k ? '1' : '0';
      text += '\n';
    }
  }
}

void append(std::vector<double>& words, const std::vector<double>& a, double unit) {
  // three digits of exponent would not fit the field
  for (const double x : a) words.push_back(std::abs(x / unit) < 1e-99 ? 0.0 : x / unit);
}

}  // namespace

SesameMaterial read_sesame(const std::string& path, int number) { return Reader(path, number).read(); }

SesameGrid total(const SesameMaterial& m, const std::string& path) {
  if (const auto found = m.grids.find(301); found != m.grids.end()) return found->second;
  const auto missing = [&](int record) {
    throw core::CaseError(path + ": material " + std::to_string(m.number) + " has no record 301 and no " + std::to_string(record) +
                          "; valid: 301, or 303 and 304, or 304, 305 and 306");
  };
  const std::vector<int> parts = m.grids.count(303) ? std::vector<int>{303, 304} : std::vector<int>{305, 304, 306};
  for (const int record : parts)
    if (!m.grids.count(record)) missing(record);
  SesameGrid sum = m.grids.at(parts[0]);
  sum.f.clear();  // the parts need not all have one
  for (std::size_t k = 1; k < parts.size(); ++k) {
    const SesameGrid& g = m.grids.at(parts[k]);
    const bool cold = g.T.size() == 1;  // a cold curve adds the same to every temperature
    if (g.rho != sum.rho || (!cold && g.T != sum.T))
      throw core::CaseError(path + ": material " + std::to_string(m.number) + ": records " + std::to_string(parts[0]) + " and " +
                            std::to_string(parts[k]) + " have different densities or temperatures; they must share them");
    for (std::size_t i = 0; i < sum.p.size(); ++i) {
      const std::size_t j = cold ? i % g.rho.size() : i;
      sum.p[i] += g.p[j], sum.e[i] += g.e[j];
    }
  }
  return sum;
}

std::string sesame_text(const SesameMaterial& m) {
  std::string text;
  add_record(text, m.number, 201, {m.Z, m.A, m.rho_0 / Mg_per_m3, m.bulk_modulus / GPa, 0});
  for (const auto& [record, g] : m.grids) {
    std::vector<double> words{static_cast<double>(g.rho.size()), static_cast<double>(g.T.size())};
    append(words, g.rho, Mg_per_m3), append(words, g.T, 1), append(words, g.p, GPa);
    append(words, g.e, MJ_per_kg), append(words, g.f, MJ_per_kg);
    add_record(text, m.number, record, words);
  }
  if (m.vapour) {
    const auto& v = *m.vapour;
    std::vector<double> words{static_cast<double>(v.T.size())};
    append(words, v.p, GPa), append(words, v.T, 1), append(words, v.rho_vapour, Mg_per_m3), append(words, v.rho_liquid, Mg_per_m3);
    append(words, v.e_vapour, MJ_per_kg), append(words, v.e_liquid, MJ_per_kg);
    append(words, v.f_vapour, MJ_per_kg), append(words, v.f_liquid, MJ_per_kg);
    add_record(text, m.number, 401, words);
  }
  return text + " 2\n";
}

}  // namespace eos
