// SPDX-License-Identifier: Apache-2.0
// Things put into rows, each row's in the order in which they come: a counting sort.
#pragma once

#include <cstddef>
#include <vector>

namespace core {

/// start: [n_rows + 1] where each row begins in `list`. each(put) calls put(row, value) for all that is to go in, and is called
/// twice: it must do the same both times.
template <class Index, class Value, class Each>
void sort_into_rows(std::size_t n_rows, Each&& each, std::vector<Index>& start, std::vector<Value>& list) {
  start.assign(n_rows + 1, 0);
  each([&](std::size_t row, const Value&) { ++start[row + 1]; });
  for (std::size_t row = 0; row < n_rows; ++row) start[row + 1] += start[row];
  list.resize(start.back());
  std::vector<Index> next(start.begin(), start.end() - 1);
  each([&](std::size_t row, const Value& value) { list[next[row]++] = value; });
}

}  // namespace core
