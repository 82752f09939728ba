// SPDX-License-Identifier: Apache-2.0
#include "app/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>

#include "app/child.hpp"
#include "app/stored_run.hpp"
#include "app/summary.hpp"
#include "core/error.hpp"
#include "core/types.hpp"
#include "io/atomic_file.hpp"

namespace app {
namespace {

namespace fs = std::filesystem;

/// As text of a page.
std::string page_text(const std::string& text) {
  std::string r;
  for (const char c : text) switch (c) {
      case '&': r += "&amp;"; break;
      case '<': r += "&lt;"; break;
      case '>': r += "&gt;"; break;
      case '"': r += "&quot;"; break;
      default: r += c;
    }
  return r;
}

/// A table of a page: the first column holds names, all others numbers.
class PageTable {
 public:
  explicit PageTable(const std::vector<std::string>& head) { add("th", head); }
  void row(const std::vector<std::string>& cells) {
    add("td", cells);
    ++rows_;
  }
  bool empty() const { return rows_ == 0; }
  std::string text() const { return "<table>\n" + text_ + "</table>\n"; }

 private:
  void add(const char* tag, const std::vector<std::string>& cells) {
    text_ += "<tr>";
    for (const auto& c : cells) text_ += fmt::format("<{0}>{1}</{0}>", tag, page_text(c));
    text_ += "</tr>\n";
  }
  std::string text_;
  int rows_ = 0;
};

std::string section(const std::string& title, const std::string& content) { return "<h2>" + page_text(title) + "</h2>\n" + content; }

std::string head_of(const StoredRun& run) {
  std::string text = fmt::format("<h1>{}</h1>\n", page_text(run.text("/title")));
  if (run.at("/completed") != true)
    text += fmt::format("<p class=\"stopped\">This run did not reach its end time: {}.</p>\n", page_text(run.text("/stop_reason")));
  const double threads = run.number("/threads");
  return text + fmt::format("<p>Mode {}, {:.0f} elements across the projectile ({}), to {:.4g} us in {:.0f} steps; {:.0f} elements as built, {:.0f} at the end, "
                            "{:.0f} particles; {:.4g} s on {:.0f} thread{}.</p>\n",
                            page_text(run.text("/mode")), run.number("/elements_across"), page_text(run.text("/fidelity")), 1e6 * run.number("/time"), run.number("/steps"),
                            run.number("/elements/initial"), run.number("/elements/alive"), run.number("/particles/final"), run.number("/wall_seconds"), threads,
                            threads == 1 ? "" : "s");
}

/// Measurements that the case has a reference for.
std::string compared(const StoredRun& run) {
  PageTable table({"measurement", "computed", "reference", "error", "source of the reference"});
  for (const auto& [key, entry] : run.summary["measurements"].items()) {
    const Cell c = cell(entry, "value"), r = cell(entry, "reference");
    if (!r.there) continue;
    const std::string error = !c.number ? (c.value == r.value ? "right" : "wrong") : r.value != 0 ? fmt::format("{:+.1f} %", 100 * relative_error(c, r)) : "";
    table.row({key, c.text, r.text, error, entry.value("source", std::string())});
  }
  return table.empty() ? "<p>The case names no reference ([reference]).</p>\n" : table.text();
}

std::string measured(const StoredRun& run) {
  PageTable table({"measurement", "computed"});
  for (const auto& [key, entry] : run.summary["measurements"].items()) table.row({key, cell(entry, "value").text});
  return table.text();
}

std::string energies(const StoredRun& run) {
  PageTable table({"energy at the end", "% of the initial kinetic energy"});
  for (const char* name : {"kinetic", "internal", "hourglass", "contact", "conversion", "eroded_kinetic", "eroded_internal"})
    table.row({name, fmt::format("{:.3f}", 100 * run.energy(name))});
  table.row({"hourglass + |contact| + conversion", fmt::format("{:.3f}", 100 * run.booked())});
  PageTable errors({"error", "relative"});
  for (const char* name : {"energy_error", "mass_error", "momentum_error", "angular_momentum_error"})
    errors.row({name, fmt::format("{:.1e}", run.number(fmt::format("/conservation/{}", name)))});
  errors.row({"crossings of a face without contact", fmt::format("{:.0f}", run.number("/contact/leaks"))});
  return table.text() + errors.text();
}

/// The heaviest of DIR/fragments.csv (app/summary.hpp).
std::string fragments(const std::string& dir) {
  constexpr std::size_t most = 12;
  struct Fragment {
    double mass, size, speed, temperature, of_projectile;
    bool lone;
  };
  std::vector<Fragment> all;
  std::ifstream file(dir + "/fragments.csv");
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream row(line);
    double m, d, x[3], v[3], temperature, fraction, points, lone;
    if (row >> m >> d >> x[0] >> x[1] >> x[2] >> v[0] >> v[1] >> v[2] >> temperature >> fraction >> points >> lone)
      all.push_back({m, d, std::hypot(v[0], v[1], v[2]), temperature, fraction, lone != 0});
  }
  if (all.empty()) return "<p>Nothing has come loose.</p>\n";
  std::stable_sort(all.begin(), all.end(), [](const Fragment& a, const Fragment& b) { return a.mass > b.mass; });
  PageTable table({"of the heaviest", "mass", "size", "speed", "temperature, K", "of the projectile, %"});
  double mass = 0;
  std::size_t lone = 0;
  for (const auto& f : all) mass += f.mass, lone += f.lone;
  for (std::size_t k = 0; k < std::min(most, all.size()); ++k)
    table.row({fmt::format("{}", k + 1), readable(all[k].mass, "kg"), readable(all[k].size, "m"), readable(all[k].speed, "m/s"), fmt::format("{:.0f}", all[k].temperature),
               fmt::format("{:.0f}", 100 * all[k].of_projectile)});
  return fmt::format("<p>{} pieces of {} together, {} of them lone points; all of them: fragments.csv.</p>\n", all.size(), readable(mass, "kg"), lone) + table.text();
}

/// A list of the texts at a path of the summary; nothing where there are none.
std::string lines(const StoredRun& run, const std::string& path) {
  std::string text;
  for (const auto& line : run.at(path))
    if (line.is_string()) text += fmt::format("<li>{}</li>\n", page_text(line.get<std::string>()));
  return text.empty() ? "" : "<ul>\n" + text + "</ul>\n";
}

std::string cost(const StoredRun& run) {
  PageTable table({"stage", "s", "%"});
  const Json stages = run.at("/work/stage_seconds");
  double all = 0;
  for (const auto& [name, seconds] : stages.items()) all += seconds.get<double>();
  for (const auto& [name, seconds] : stages.items())
    table.row({name, fmt::format("{:.2f}", seconds.get<double>()), fmt::format("{:.1f}", all > 0 ? 100 * seconds.get<double>() / all : 0.0)});
  const std::string text = fmt::format("<p>{:.4g} s on the wall, {:.4g} s of processors, {:.0f} MiB at most; {:.3g} element updates, {:.3g} pair updates.</p>\n",
                                 run.number("/wall_seconds"), run.number("/cpu_seconds"), run.number("/peak_memory_bytes") / (1 << 20),
                                 run.number("/work/element_updates"), run.number("/work/pair_updates"));
  return text + lines(run, "/not_needed") + table.text();
}

std::string page(const StoredRun& run, bool drawn) {
  static constexpr const char* style =
      "body{font-family:sans-serif;max-width:75em;margin:2em auto;padding:0 1em;color:#222}img{width:100%}"
      "table{border-collapse:collapse;margin:0.5em 0 1em}td,th{padding:0.15em 0.8em;border-bottom:1px solid #ddd;text-align:right}"
      "td:first-child,th:first-child,td:nth-child(5){text-align:left}pre{background:#f4f4f1;padding:1em;overflow:auto}.stopped{color:#b00;font-weight:bold}";
  std::string text = fmt::format("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<title>{}</title>\n<style>{}</style>\n</head>\n<body>\n",
                                 page_text(run.text("/title")), style);
  text += head_of(run);
  text += section("Against the references", compared(run));
  if (drawn) text += section("Six instants, the energy ledger, the main measurements", "<img src=\"cloud.png\" alt=\"cut along the line of flight, coloured by body\">\n");
  text += section("Energy", energies(run));
  if (drawn) text += section("Speed", "<img src=\"speed.png\" alt=\"the same instants, coloured by speed\">\n");
  text += section("All measurements", measured(run));
  text += section("Fragments", fragments(run.folder));
  text += section("Cost", cost(run));
  const std::string warnings = lines(run, "/warnings");
  text += section("Warnings", warnings.empty() ? "<p>None.</p>\n" : warnings);
  text += section("The case as it was run", "<pre>" + page_text(file_text(run.folder + "/case.toml")) + "</pre>\n");
  return text + "</body>\n</html>\n";
}

}  // namespace

std::string report(const std::string& dir) {
  const StoredRun run = read_stored_run(dir);
  for (const char* name : {"case.toml", "run.h5", "history.csv"})
    if (!fs::exists(fs::path(dir) / name)) throw core::CaseError(fmt::format("{}: holds no {}; valid: output folders of runs that have ended", dir, name));
  std::optional<core::GuardError> not_drawn;
  try {
    draw(picture_program, {dir, "--out", dir + "/cloud.png"});
    draw(picture_program, {dir, "--out", dir + "/speed.png", "--color", "speed"});
  } catch (const core::GuardError& e) {
    not_drawn = e;
  }
  const std::string path = dir + "/report.html";
  io::write_atomically(path, page(run, !not_drawn));
  if (not_drawn) throw core::GuardError(fmt::format("{} is without pictures: {}", path, not_drawn->what()));
  return path + "\n";
}

}  // namespace app
