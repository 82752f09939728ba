// SPDX-License-Identifier: Apache-2.0
// Tables for people.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

namespace app {

/// Lines of cells, each column as wide as the widest of it: the first to the left, all others to the right. A row of one cell is a heading
/// and stands by itself.
inline std::string aligned(const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> width;
  for (const auto& row : rows)
    for (std::size_t c = 0; c < row.size() && row.size() > 1; ++c) {
      if (c == width.size()) width.push_back(0);
      width[c] = std::max(width[c], row[c].size());
    }
  std::string text;
  for (const auto& row : rows) {
    for (std::size_t c = 0; c < row.size(); ++c)
      text += c == 0 && row.size() > 1 ? fmt::format("{:<{}}", row[c], width[c]) : c == 0 ? row[c] : fmt::format("  {:>{}}", row[c], width[c]);
    text += '\n';
  }
  return text;
}

}  // namespace app
