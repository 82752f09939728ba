// SPDX-License-Identifier: Apache-2.0
// What a run has left in its folder, for the commands that look at runs: compare, report, trade.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace app {

using Json = nlohmann::ordered_json;

struct StoredRun {
  std::string folder;
  std::string name;  ///< of the folder
  Json summary;      ///< summary.json

  /// What stands at a path of the summary, "/work/element_updates"; null where nothing does.
  Json at(const std::string& path) const { return summary.value(Json::json_pointer(path), Json()); }
  /// The number there, 0 where there is none.
  double number(const std::string& path) const;
  std::string text(const std::string& path) const;
  /// A term of the ledger over the initial kinetic energy, 0 where there was none.
  double energy(const std::string& term) const;
  /// Hourglass + |contact| + conversion over it.
  double booked() const;
  /// A measurement, {value, unit, reference ...}; null where it was not measured.
  Json measured(const std::string& key) const { return summary["measurements"].value(key, Json()); }
};

/// Throws core::CaseError where the folder's summary.json is not there or is none.
StoredRun read_stored_run(const std::string& folder);

/// All of a file; nothing where it cannot be read.
std::string file_text(const std::string& path);

/// A measurement's number and how people write it.
struct Cell {
  bool there = false, number = false;
  double value = 0;  ///< 1 and 0 where it is yes or no
  std::string text = "-";
};

/// `key` of a measurement: "value" or "reference".
Cell cell(const Json& measurement, const char* key);

/// How far a number is from one that is not zero, over the size of that.
double relative_error(const Cell& c, const Cell& truth);

}  // namespace app
