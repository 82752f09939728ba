// SPDX-License-Identifier: Apache-2.0
#include "io/shock_points.hpp"

#include <algorithm>
#include <cmath>

#include "io/toml_reader.hpp"

namespace io {

extern const char* const shock_points_text;  // made by embed.cmake

std::vector<ShockSeries> shock_series(const std::vector<std::string>& materials) {
  const toml_reader::Node root = toml_reader::parse_text(shock_points_text, "material/shock_points.toml");
  std::vector<ShockSeries> found;
  for (const auto& node : root.find("series")->items) {
    const toml_reader::Table table(node, "series", {"source", "rho_0", "materials", "points"});
    const auto ours = table.texts("materials");
    if (std::find_first_of(ours.begin(), ours.end(), materials.begin(), materials.end()) == ours.end()) continue;
    ShockSeries s{table.text("source"), table.number("rho_0", core::Dimension::density, toml_reader::positive), {}};
    for (const auto& pair : table.require("points").items) {
      const double V = pair.items.at(0).real, p = pair.items.at(1).real * 1e9;  // V over V0
      const double up = std::sqrt(p * (1 - V) / s.rho_0);
      s.points.push_back({up, p / (s.rho_0 * up), p, s.rho_0 / V});
    }
    std::sort(s.points.begin(), s.points.end(), [](const auto& a, const auto& b) { return a.up < b.up; });
    found.push_back(std::move(s));
  }
  return found;
}

}  // namespace io
