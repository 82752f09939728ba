// SPDX-License-Identifier: Apache-2.0
#include "app/trade.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <optional>

#include "app/child.hpp"
#include "app/setup.hpp"
#include "app/stored_run.hpp"
#include "app/summary.hpp"
#include "app/text_table.hpp"
#include "core/error.hpp"
#include "io/atomic_file.hpp"
#include "io/case_file.hpp"

namespace app {
namespace {

namespace fs = std::filesystem;

/// One run of the study.
struct Entry {
  io::Case spec;
  std::vector<std::string> set;  ///< its overrides, the fidelity's among them
  std::string folder;
  StoredRun run{};
  double error = 0;              ///< [-]
  bool on_front = false;

  std::string name() const { return fmt::format("{}-{}", io::to_string(spec.mode), spec.elements_across); }
  bool ended() const { return run.at("/completed") == true; }
  double cost() const { return run.number("/cpu_seconds"); }
};

std::string override_of(const std::string& fidelity) {
  int across = 0;
  const auto [end, failed] = std::from_chars(fidelity.data(), fidelity.data() + fidelity.size(), across);
  if (failed == std::errc() && end == fidelity.data() + fidelity.size()) return fmt::format("run.elements_across={}", across);
  io::elements_across(fidelity);  // throws where there is none of that name
  return "run.fidelity=" + fidelity;
}

/// Every mode at every fidelity, the coarsest first; a combination that is named twice once.
std::vector<Entry> entries_of(const TradeRequest& r) {
  std::vector<Entry> entries;
  for (const auto& fidelity : r.fidelities)
    for (const auto& mode : r.modes) {
      Entry e;
      e.set = r.set;
      e.set.push_back(override_of(fidelity));
      e.spec = io::read_case(r.target, e.set, mode);
      e.folder = r.out + "/" + e.name();
      if (std::none_of(entries.begin(), entries.end(), [&](const Entry& other) { return other.folder == e.folder; })) entries.push_back(std::move(e));
    }
  std::stable_sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.spec.elements_across < b.spec.elements_across; });
  return entries;
}

/// What is to be done for a run whose folder may hold something.
enum class Todo { run, go_on, nothing };

Todo look_at(const Entry& e, bool force) {
  std::error_code error;
  if (force || !fs::exists(e.folder) || fs::is_empty(e.folder, error)) return Todo::run;
  if (file_text(e.folder + "/case.toml") != io::write_case(set_up(e.spec)->spec))
    throw core::CaseError(fmt::format("{}: holds something else than this run; give another --out, or --force", e.folder));
  std::ifstream f(e.folder + "/summary.json");
  const Json summary = Json::parse(f, nullptr, false);
  const std::string ended_by = summary.is_object() ? summary.value("stop_reason", "") : "interrupted";
  if (ended_by != "interrupted" && ended_by.find(io::no_room_advice) == std::string::npos) return Todo::nothing;  // at its end, or by a guard
  return fs::exists(e.folder + "/checkpoint.h5") ? Todo::go_on : Todo::run;
}

int carry_out(const Entry& e, Todo todo, const TradeRequest& r) {
  std::vector<std::string> words{"/proc/self/exe"};
  if (todo == Todo::go_on) {
    words.insert(words.end(), {"resume", e.folder});
  } else {
    words.insert(words.end(), {"run", r.target, "--mode", io::to_string(e.spec.mode), "--out", e.folder, "--force"});
    for (const auto& s : e.set) words.insert(words.end(), {"--set", s});
  }
  if (r.threads > 0) words.insert(words.end(), {"--threads", std::to_string(r.threads)});
  return run_child(words);
}

/// What runs are judged by.
struct Yardstick {
  std::string key;
  Cell truth;
};
struct Yardsticks {
  std::string from;  ///< who says so
  std::vector<Yardstick> all;
};

bool can_judge(const Cell& c) { return c.there && (!c.number || c.value != 0); }

/// Main measurements of a run, those that say something of its scene.
std::vector<Yardstick> main_measurements(const StoredRun& run) {
  static constexpr const char* of_clouds[] = {"cloud.spray_half_angle", "cloud.fast_half_angle", "cloud.axial_velocity_front"};
  static constexpr const char* of_bodies[] = {"perforated", "hole_diameter", "bulge", "crater_depth", "crater_diameter", "final_length", "foot_diameter"};
  const auto is_main = [&](const std::string& key) {
    if (std::find(std::begin(of_clouds), std::end(of_clouds), key) != std::end(of_clouds)) return true;
    const auto dot = key.rfind('.');
    if (dot == std::string::npos || key.starts_with("cloud.")) return false;
    const std::string body = key.substr(0, dot), what = key.substr(dot + 1);
    if (what == "bulge" && cell(run.measured(body + ".perforated"), "value").value != 0) return false;  // the rim's
    return std::find(std::begin(of_bodies), std::end(of_bodies), what) != std::end(of_bodies);
  };
  std::vector<Yardstick> found;
  for (const auto& [key, entry] : run.summary["measurements"].items())
    if (const Cell truth = cell(entry, "value"); is_main(key) && can_judge(truth)) found.push_back({key, truth});
  return found;
}

/// References of the case that any run has measured; without any, what the finest run in the first mode has measured.
Yardsticks yardsticks_of(const std::vector<Entry>& entries) {
  Yardsticks found{"reference", {}};
  for (const Entry& e : entries)
    for (const auto& [key, entry] : e.run.summary["measurements"].items())
      if (const Cell truth = cell(entry, "reference"); can_judge(truth))
        if (std::none_of(found.all.begin(), found.all.end(), [&, k = key](const Yardstick& y) { return y.key == k; })) found.all.push_back({key, truth});
  if (!found.all.empty()) return found;
  const auto finest = std::find_if(entries.rbegin(), entries.rend(), [&](const Entry& e) { return e.ended() && e.spec.mode == entries.front().spec.mode; });
  if (finest == entries.rend()) return found;
  return {"judged by " + finest->name(), main_measurements(finest->run)};
}

/// Relative error of one measurement, none counts as 1.
double error_of(const StoredRun& run, const Yardstick& y) {
  const Cell c = cell(run.measured(y.key), "value");
  if (!c.there) return 1;
  return y.truth.number ? relative_error(c, y.truth) : c.value == y.truth.value ? 0 : 1;
}

double root_mean_square_error(const StoredRun& run, const std::vector<Yardstick>& yardsticks) {
  double sum = 0;
  for (const auto& y : yardsticks) sum += std::pow(error_of(run, y), 2);
  return yardsticks.empty() ? 0 : std::sqrt(sum / static_cast<double>(yardsticks.size()));
}

void judge(std::vector<Entry>& entries, const std::vector<Yardstick>& yardsticks) {
  std::vector<std::size_t> ended;
  std::vector<double> cost, error;
  for (std::size_t k = 0; k < entries.size(); ++k) {
    entries[k].error = root_mean_square_error(entries[k].run, yardsticks);
    if (entries[k].ended()) ended.push_back(k), cost.push_back(entries[k].cost()), error.push_back(entries[k].error);
  }
  const auto front = pareto_front(cost, error);
  for (std::size_t k = 0; k < ended.size(); ++k) entries[ended[k]].on_front = front[k];
}

std::string table_text(const std::vector<Entry>& entries, const Yardsticks& yardsticks) {
  std::vector<std::vector<std::string>> rows{{"run", "steps", "elements", "particles", "cpu s", "wall s", "MiB", "booked %", "error %", "front"}};
  for (const auto& y : yardsticks.all) rows[0].push_back(y.key);
  for (const Entry& e : entries) {
    const StoredRun& r = e.run;
    rows.push_back({e.name(), fmt::format("{:.0f}", r.number("/steps")), fmt::format("{:.0f}", r.number("/elements/initial")), fmt::format("{:.0f}", r.number("/particles/final")),
                    fmt::format("{:.3g}", e.cost()), fmt::format("{:.3g}", r.number("/wall_seconds")), fmt::format("{:.0f}", r.number("/peak_memory_bytes") / (1 << 20)),
                    fmt::format("{:.2f}", 100 * r.booked()), e.ended() ? fmt::format("{:.2f}", 100 * e.error) : "stopped", e.on_front ? "*" : ""});
    for (const auto& y : yardsticks.all) {
      const Cell c = cell(r.measured(y.key), "value");
      rows.back().push_back(c.number && y.truth.number ? fmt::format("{} ({:+.1f} %)", c.text, 100 * error_of(r, y)) : c.text);
    }
  }
  rows.push_back({yardsticks.from, "", "", "", "", "", "", "", "", ""});
  for (const auto& y : yardsticks.all) rows.back().push_back(y.truth.text);
  return aligned(rows);
}

std::string table_csv(const std::vector<Entry>& entries, const std::vector<Yardstick>& yardsticks) {
  std::string text = "run,mode,elements_across,completed,steps,elements,particles,threads,cpu_seconds,wall_seconds,peak_memory_bytes,booked,error,on_front";
  for (const auto& y : yardsticks) text += fmt::format(",{0},{0} error", y.key);
  text += '\n';
  for (const Entry& e : entries) {
    const StoredRun& r = e.run;
    text += fmt::format("{},{},{},{},{:.0f},{:.0f},{:.0f},{:.0f},{:.6g},{:.6g},{:.0f},{:.6e},{:.6e},{}", e.name(), io::to_string(e.spec.mode), e.spec.elements_across,
                        e.ended() ? 1 : 0, r.number("/steps"), r.number("/elements/initial"), r.number("/particles/final"), r.number("/threads"), e.cost(),
                        r.number("/wall_seconds"), r.number("/peak_memory_bytes"), r.booked(), e.error, e.on_front ? 1 : 0);
    for (const auto& y : yardsticks) {
      const Cell c = cell(r.measured(y.key), "value");
      text += c.there ? fmt::format(",{:.9e},{:.6e}", c.value, error_of(r, y)) : fmt::format(",,{:.6e}", error_of(r, y));
    }
    text += '\n';
  }
  return text;
}

}  // namespace

std::vector<bool> pareto_front(const std::vector<double>& cost, const std::vector<double>& error) {
  std::vector<std::size_t> order(cost.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return cost[a] != cost[b] ? cost[a] < cost[b] : error[a] < error[b]; });
  std::vector<bool> on(cost.size(), false);
  std::optional<double> least;
  for (const auto k : order)
    if (!least || error[k] < *least) on[k] = true, least = error[k];
  return on;
}

int trade(const TradeRequest& request) {
  std::vector<Entry> entries = entries_of(request);
  std::vector<Todo> todo;
  for (const Entry& e : entries) todo.push_back(look_at(e, request.force));
  for (std::size_t k = 0; k < entries.size(); ++k) {
    fmt::print("== {} of {}: {}{}\n", k + 1, entries.size(), entries[k].folder, todo[k] == Todo::nothing ? ", there already" : "");
    if (todo[k] == Todo::nothing) continue;
    const int code = carry_out(entries[k], todo[k], request);
    if (code >= 127) fmt::print("go on with the same command; what has ended is kept\n");
    if (code >= 127 || code == 2) return code;
  }
  for (Entry& e : entries) e.run = read_stored_run(e.folder);
  const auto yardsticks = yardsticks_of(entries);
  if (yardsticks.all.empty()) throw core::CaseError(fmt::format("{}: nothing that its runs measure can be compared; name a measurement in [reference]", request.target));
  judge(entries, yardsticks.all);
  const std::string csv = request.out + "/trade.csv";
  io::write_atomically(csv, table_csv(entries, yardsticks.all));
  fmt::print("\n{}", table_text(entries, yardsticks));
  draw(trade_picture_program, {csv, "--out", request.out + "/trade.png"});
  return 0;
}

}  // namespace app
