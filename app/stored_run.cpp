// SPDX-License-Identifier: Apache-2.0
#include "app/stored_run.hpp"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "app/summary.hpp"
#include "core/error.hpp"

namespace app {

double StoredRun::number(const std::string& path) const {
  const Json j = at(path);
  return j.is_number() ? j.get<double>() : 0;
}

double StoredRun::energy(const std::string& term) const {
  const double initial = number("/conservation/initial_kinetic");
  return initial > 0 ? number("/conservation/ledger/" + term) / initial : 0;
}

double StoredRun::booked() const { return energy("hourglass") + std::abs(energy("contact")) + energy("conversion"); }

std::string StoredRun::text(const std::string& path) const {
  const Json j = at(path);
  return j.is_string() ? j.get<std::string>() : "-";
}

StoredRun read_stored_run(const std::string& folder) {
  StoredRun run;
  run.folder = folder;
  const auto path = std::filesystem::absolute(folder).lexically_normal();
  run.name = (path.has_filename() ? path : path.parent_path()).filename().string();
  const std::string summary = folder + "/summary.json";
  std::ifstream f(summary);
  run.summary = Json::parse(f, nullptr, false);
  if (!run.summary.is_object() || !run.at("/measurements").is_object())
    throw core::CaseError(fmt::format("{}: is not there, or no summary of a run; valid: output folders of runs that have ended", summary));
  return run;
}

std::string file_text(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

Cell cell(const Json& measurement, const char* key) {
  if (!measurement.is_object() || !measurement.contains(key)) return {};
  const Json& v = measurement[key];
  if (v.is_boolean()) return {true, false, v.get<bool>() ? 1.0 : 0.0, readable(v.get<bool>(), "bool")};
  if (!v.is_number()) return {};
  const Json unit = measurement.value("unit", Json());
  return {true, true, v.get<double>(), readable(v.get<double>(), unit.is_string() ? unit.get<std::string>() : "")};
}

double relative_error(const Cell& c, const Cell& truth) { return (c.value - truth.value) / std::abs(truth.value); }

}  // namespace app
