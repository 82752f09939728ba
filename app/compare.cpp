// SPDX-License-Identifier: Apache-2.0
#include "app/compare.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "app/stored_run.hpp"
#include "app/text_table.hpp"
#include "core/error.hpp"
#include "io/toml_reader.hpp"

namespace app {
namespace {

using io::toml_reader::Node;

/// Every value of a case by its key, as it is written; bodies by name.
using Flat = std::map<std::string, std::string>;

std::string written(const Node& node) {
  if (node.kind != Node::Kind::array) return node.text;
  std::string text;
  for (const Node& item : node.items) text += (text.empty() ? "" : ", ") + written(item);
  return text;
}

void flatten(const Node& node, const std::string& path, Flat& flat) {
  const auto below = [&](const std::string& key) { return path.empty() ? key : path + "." + key; };
  if (node.is_table()) {
    for (const auto& [key, child] : node.children)
      if (key != "source" && key != "reference") flatten(child, below(key), flat);
  } else if (node.kind == Node::Kind::array && !node.items.empty() && node.items[0].is_table()) {
    for (std::size_t k = 0; k < node.items.size(); ++k) {
      const Node* name = node.items[k].find("name");
      flatten(node.items[k], below(name ? name->text : std::to_string(k + 1)), flat);
    }
  } else {
    flat[path] = written(node);
  }
}

struct Run : StoredRun {
  Flat spec;
};

Run read_run(const std::string& folder) {
  Run run{read_stored_run(folder), {}};
  flatten(io::toml_reader::parse_file(folder + "/case.toml"), "", run.spec);
  return run;
}

/// Lines of a title and a cell for each run, as wide as the widest of its column.
class Table {
 public:
  explicit Table(const std::vector<Run>& runs) : runs_(runs) {}

  void heading(const std::string& title) { rows_.push_back({title}); }
  void row(const std::string& title, std::vector<std::string> cells) {
    cells.insert(cells.begin(), "  " + title);
    rows_.push_back(std::move(cells));
  }
  /// f(run) for every run.
  template <class F>
  void each(const std::string& title, F&& f) {
    std::vector<std::string> cells;
    for (const Run& run : runs_) cells.push_back(f(run));
    row(title, std::move(cells));
  }
  /// A number of each summary, times `scale`; "-" where there is none.
  void number(const std::string& title, const std::string& path, const std::string& format, double scale = 1) {
    each(title, [&](const Run& run) {
      const Json j = run.at(path);
      return j.is_number() ? fmt::format(fmt::runtime(format), j.get<double>() * scale) : std::string("-");
    });
  }
  std::string text() const { return aligned(rows_); }

 private:
  const std::vector<Run>& runs_;
  std::vector<std::vector<std::string>> rows_;
};

void add_differences(const std::vector<Run>& runs, Table& table) {
  Flat keys;
  for (const Run& run : runs) keys.insert(run.spec.begin(), run.spec.end());
  table.heading("what differs in the cases");
  const auto value = [](const Run& run, const std::string& key) {
    const auto found = run.spec.find(key);
    return found == run.spec.end() ? "-" : found->second;
  };
  for (const auto& entry : keys) {
    const std::string& key = entry.first;
    if (std::any_of(runs.begin(), runs.end(), [&](const Run& run) { return value(run, key) != value(runs[0], key); }))
      table.each(key, [&](const Run& run) { return value(run, key); });
  }
}

void add_measurements(const std::vector<Run>& runs, Table& table) {
  std::vector<std::string> keys;
  for (const Run& run : runs)
    for (const auto& item : run.summary["measurements"].items())
      if (std::find(keys.begin(), keys.end(), item.key()) == keys.end()) keys.push_back(item.key());
  table.heading("measurements (against the reference in brackets, without one against the first run)");
  for (const auto& key : keys) {
    const auto entry = [&](const Run& run) { return run.measured(key); };
    Cell reference;
    for (const Run& run : runs)
      if (!reference.there) reference = cell(entry(run), "reference");
    const Cell first = cell(entry(runs[0]), "value");
    const Cell& base = reference.there ? reference : first;
    std::vector<std::string> cells;
    for (std::size_t k = 0; k < runs.size(); ++k) {
      const Cell c = cell(entry(runs[k]), "value");
      const bool told = c.number && base.number && base.value != 0 && (reference.there || k > 0);
      cells.push_back(told ? fmt::format("{} ({:+.1f} %)", c.text, 100 * relative_error(c, base)) : c.text);
    }
    if (reference.there) cells.push_back(reference.text);
    table.row(key, std::move(cells));
  }
}

void add_energies(Table& table) {
  table.heading("energy, % of the initial kinetic energy, and errors");
  for (const char* name : {"kinetic", "internal", "hourglass", "contact", "conversion", "eroded_kinetic", "eroded_internal"}) {
    table.each(name, [&](const Run& run) {
      const Json energy = run.at(fmt::format("/conservation/ledger/{}", name)), initial = run.at("/conservation/initial_kinetic");
      if (!energy.is_number() || !initial.is_number() || !(initial.get<double>() > 0)) return std::string("-");
      return fmt::format("{:.3f}", 100 * energy.get<double>() / initial.get<double>());
    });
  }
  for (const char* name : {"energy_error", "mass_error", "momentum_error", "angular_momentum_error"})
    table.number(name, fmt::format("/conservation/{}", name), "{:.1e}");
}

}  // namespace

std::string compare(const std::vector<std::string>& folders) {
  if (folders.size() < 2) throw core::CaseError(fmt::format("compare {}: valid: output folders of two or more runs", folders[0]));
  std::vector<Run> runs;
  for (const auto& folder : folders) runs.push_back(read_run(folder));
  std::vector<std::string> names;
  for (const Run& run : runs) names.push_back(run.name);
  std::sort(names.begin(), names.end());
  if (std::adjacent_find(names.begin(), names.end()) != names.end())
    for (std::size_t k = 0; k < runs.size(); ++k) runs[k].name = folders[k];

  Table table(runs);
  std::vector<std::string> heads;
  for (const Run& run : runs) heads.push_back(run.name);
  heads.push_back("reference");
  table.row("", heads);
  add_differences(runs, table);
  table.heading("runs");
  table.each("ended by", [](const Run& run) { return run.text("/stop_reason"); });
  table.number("time, us", "/time", "{:.4g}", 1e6);
  table.number("steps", "/steps", "{:.0f}");
  table.number("wall time, s", "/wall_seconds", "{:.4g}");
  table.number("processor time, s", "/cpu_seconds", "{:.4g}");
  table.number("memory, MiB", "/peak_memory_bytes", "{:.0f}", 1.0 / (1 << 20));
  for (const char* name : {"initial", "alive", "converted", "eroded"})
    table.number(fmt::format("elements, {}", name), fmt::format("/elements/{}", name), "{:.0f}");
  table.number("particles, final", "/particles/final", "{:.0f}");
  add_measurements(runs, table);
  add_energies(table);
  return table.text();
}

}  // namespace app
