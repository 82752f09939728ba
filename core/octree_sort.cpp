// SPDX-License-Identifier: Apache-2.0
// Sorting by Morton key: points that were in order in the last step are nearly so in this one. Where few are out of
// place, only those are sorted, and merged with the rest (the idea of E. Ernerfeldt's drop-merge sort); otherwise a
// radix sort from the lowest digit up. Both give the one order by key, then by index. All loops run over pieces of
// fixed size, so that threads share them and change nothing.
#include "core/octree_sort.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <tuple>
#include <utility>

#include "core/box.hpp"
#include "core/octree_kernel.hpp"
#include "core/parallel.hpp"

namespace core {

namespace {

constexpr std::size_t piece = 16384;
std::size_t n_pieces(std::size_t n) { return (n + piece - 1) / piece; }

Box bounds(std::span<const Vec3> x) {
  return reduce(
      x.size(), Box{},
      [&](std::size_t first, std::size_t last) {
        Box c;
        for (std::size_t i = first; i < last; ++i) c.add(x[i]);
        return c;
      },
      Box::join);
}

/// Cells across a unit of length; 0 where a cube has no size that keys could divide.
double key_scale(const Box& c) {
  const double scale = 0x1p21 / (c.high - c.low).maxCoeff();
  return scale < 1e300 ? scale : 0;
}

/// Sorts a few by key, then by the order they stand in.
void sort_run(std::uint64_t* key, std::uint32_t* index, std::size_t n) {
  constexpr std::size_t few = 24;
  if (n <= few) {
    for (std::size_t i = 1; i < n; ++i) {
      const std::uint64_t k = key[i];
      const std::uint32_t id = index[i];
      std::size_t to = i;
      for (; to > 0 && key[to - 1] > k; --to) key[to] = key[to - 1], index[to] = index[to - 1];
      key[to] = k, index[to] = id;
    }
    return;
  }
  std::vector<std::pair<std::uint64_t, std::uint32_t>> both(n);
  for (std::size_t i = 0; i < n; ++i) both[i] = {key[i], index[i]};
  std::stable_sort(both.begin(), both.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  for (std::size_t i = 0; i < n; ++i) std::tie(key[i], index[i]) = both[i];
}

}  // namespace

void MortonSort::sort(std::span<const Vec3> x, Isa isa, std::vector<std::uint32_t>& order) {
  const std::size_t n = x.size();
  key_.resize(n);
  index_.resize(n);
  const Box cube = bounds(x);
  const double scale = key_scale(cube);
  const auto morton_keys = octree_kernels(isa).morton_keys;
  for_each_block(n, piece, [&](std::size_t first, std::size_t last) {
    morton_keys(x[first].data(), last - first, cube.low.data(), scale, &key_[first]);
  });
  if (!merge_nearly_sorted()) {
    for_each(n, [&](std::size_t i) { index_[i] = static_cast<std::uint32_t>(i); });
    radix_sort(key_, index_);
  }
  order.swap(index_);
  sort_crowds(x, isa, key_, order);
}

/// Marks points so that the rest is in order: wherever a key is less than the last one kept, both go, since either may
/// be the one out of place.
void MortonSort::mark_strays() {
  const std::size_t n = key_.size();
  stray_.assign(n, 0);
  for_each_block(n, piece, [&](std::size_t first, std::size_t last) {
    std::uint32_t* const kept = &index_[first];  // a stack of those kept
    std::size_t n_kept = 0;
    for (std::size_t i = first; i < last; ++i) {
      if (n_kept > 0 && key_[i] < key_[kept[n_kept - 1]])
        stray_[i] = stray_[kept[--n_kept]] = 1;
      else
        kept[n_kept++] = static_cast<std::uint32_t>(i);
    }
  });
  // The same where two pieces meet, with the last one kept on the left and the first one kept on the right.
  for (std::size_t cut = piece; cut < n; cut += piece) {
    std::size_t left = cut, right = cut;
    for (;; stray_[left - 1] = stray_[right] = 1) {
      while (left > 0 && stray_[left - 1]) --left;
      while (right < n && stray_[right]) ++right;
      if (left == 0 || right == n || key_[left - 1] <= key_[right]) break;
    }
  }
}

/// Sorts key_ into index_ and key_ if at most a quarter of the points is out of place; else does nothing.
bool MortonSort::merge_nearly_sorted() {
  const std::size_t n = key_.size();
  const auto falls = sum(n, std::size_t{0}, [&](std::size_t i) { return std::size_t{i > 0 && key_[i] < key_[i - 1]}; });
  if (8 * falls > n) return false;  // each makes two strays, as a rule
  mark_strays();
  std::vector<std::size_t> kept_before(n_pieces(n) + 1, 0);
  for_each_block(n, piece, [&](std::size_t first, std::size_t last) {
    std::size_t strays = 0;
    for (std::size_t i = first; i < last; ++i) strays += stray_[i];
    kept_before[first / piece + 1] = last - first - strays;
  });
  for (std::size_t p = 0; p < n_pieces(n); ++p) kept_before[p + 1] += kept_before[p];
  const std::size_t n_kept = kept_before.back(), n_strays = n - n_kept;
  if (4 * n_strays > n) return false;

  key_2_.resize(n);
  index_2_.resize(n);
  std::vector<std::uint64_t> stray_key(n_strays);
  std::vector<std::uint32_t> stray_index(n_strays);
  for_each_block(n, piece, [&](std::size_t first, std::size_t last) {
    std::size_t k = kept_before[first / piece], s = first - k;
    for (std::size_t i = first; i < last; ++i) {
      if (stray_[i]) {
        stray_key[s] = key_[i];
        stray_index[s++] = static_cast<std::uint32_t>(i);
      } else {
        key_2_[k] = key_[i];
        index_2_[k++] = static_cast<std::uint32_t>(i);
      }
    }
  });
  std::vector<std::uint64_t> kept_key;
  std::vector<std::uint32_t> kept_index;
  kept_key.swap(key_2_);
  kept_index.swap(index_2_);
  radix_sort(stray_key, stray_index);

  const auto strays_before = [&](std::size_t k) {  // those that come before the k-th kept one
    if (k == 0) return std::size_t{0};
    if (k >= n_kept) return n_strays;
    auto at = static_cast<std::size_t>(std::lower_bound(stray_key.begin(), stray_key.end(), kept_key[k]) - stray_key.begin());
    while (at < n_strays && stray_key[at] == kept_key[k] && stray_index[at] < kept_index[k]) ++at;
    return at;
  };
  for_each_block(std::max<std::size_t>(n_kept, 1), piece, [&](std::size_t first, std::size_t last) {
    std::size_t s = strays_before(first), out = std::min(first, n_kept) + s;
    const std::size_t k_end = std::min(last, n_kept), s_end = last >= n_kept ? n_strays : strays_before(last);
    for (std::size_t k = first; k < k_end; ++k) {
      while (s < s_end && (stray_key[s] < kept_key[k] || (stray_key[s] == kept_key[k] && stray_index[s] < kept_index[k]))) {
        key_[out] = stray_key[s];
        index_[out++] = stray_index[s++];
      }
      key_[out] = kept_key[k];
      index_[out++] = kept_index[k];
    }
    for (; s < s_end; ++s) {
      key_[out] = stray_key[s];
      index_[out++] = stray_index[s];
    }
  });
  kept_key.swap(key_2_);
  kept_index.swap(index_2_);
  return true;
}

/// Stable: equal keys keep their order. By the upper half of the keys, which tells nearly all points apart, digit by digit;
/// the few that share it are put in order where they stand. What is moved about is that half and the place in `key`, one word.
void MortonSort::radix_sort(std::vector<std::uint64_t>& key, std::vector<std::uint32_t>& index) {
  constexpr int digit_bits = 11, place_bits = 32, first_bit = 63 - (64 - place_bits);
  constexpr std::size_t n_digits = std::size_t{1} << digit_bits;
  const std::size_t n = key.size();
  if (n < 1024) return sort_run(key.data(), index.data(), n);
  word_.resize(n);
  key_2_.resize(n);
  index_2_.resize(n);
  for_each(n, [&](std::size_t i) { word_[i] = key[i] >> first_bit << place_bits | i; });
  std::vector<std::uint32_t> start(n_digits * n_pieces(n));  // of each digit and piece, in this order
  for (int shift = place_bits; shift < 64; shift += digit_bits) {
    const auto digit = [shift](std::uint64_t w) { return w >> shift & (n_digits - 1); };
    for_each_block(n, piece, [&](std::size_t first, std::size_t last) {
      std::array<std::uint32_t, n_digits> count{};
      for (std::size_t i = first; i < last; ++i) ++count[digit(word_[i])];
      for (std::size_t d = 0; d < n_digits; ++d) start[d * n_pieces(n) + first / piece] = count[d];
    });
    std::uint32_t total = 0;
    for (std::uint32_t& s : start) total += std::exchange(s, total);
    for_each_block(n, piece, [&](std::size_t first, std::size_t last) {
      std::array<std::uint32_t, n_digits> at;
      for (std::size_t d = 0; d < n_digits; ++d) at[d] = start[d * n_pieces(n) + first / piece];
      for (std::size_t i = first; i < last; ++i) key_2_[at[digit(word_[i])]++] = word_[i];
    });
    word_.swap(key_2_);
  }
  for_each(n, [&](std::size_t k) {
    const auto from = static_cast<std::uint32_t>(word_[k]);
    key_2_[k] = key[from];
    index_2_[k] = index[from];
  });
  key.swap(key_2_);
  index.swap(index_2_);
  const auto upper = [&](std::size_t k) { return key[k] >> first_bit; };
  for_each_block(n, piece, [&](std::size_t first, std::size_t last) {  // those that begin in this piece
    while (first > 0 && first < last && upper(first) == upper(first - 1)) ++first;
    for (std::size_t end; first < last; first = end) {
      end = first + 1;
      while (end < n && upper(end) == upper(first)) ++end;
      if (end - first > 1) sort_run(&key[first], &index[first], end - first);
    }
  });
}

/// Points that share a key, if they are many and not all in one place, are sorted by keys of their own.
void MortonSort::sort_crowds(std::span<const Vec3> x, Isa isa, std::span<const std::uint64_t> key,
                             std::span<std::uint32_t> order) {
  const std::size_t n = key.size();
  for (std::size_t first = 0, last; first < n; first = last) {
    last = first + 1;
    while (last < n && key[last] == key[first]) ++last;
    if (last - first <= crowd) continue;
    const std::vector<std::uint32_t> member(&order[first], &order[first] + (last - first));
    std::vector<Vec3> own(member.size());
    for (std::size_t k = 0; k < own.size(); ++k) own[k] = x[member[k]];
    if (key_scale(bounds(own)) == 0) continue;
    std::vector<std::uint32_t> inner;
    MortonSort().sort(own, isa, inner);
    for (std::size_t k = 0; k < own.size(); ++k) order[first + k] = member[inner[k]];
  }
}

}  // namespace core
