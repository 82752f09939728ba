// SPDX-License-Identifier: Apache-2.0
// The order of points along the Morton curve.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/isa.hpp"
#include "core/types.hpp"

namespace core {

/// Keys have 21 bits an axis in the cube around all points. Where more than `crowd` points share a key (a far outlier
/// makes the cube too coarse for the rest), they are put in order by keys in a cube of their own, and so on.
class MortonSort {
 public:
  static constexpr std::size_t crowd = 16;

  /// Fills `order` with the indices of x sorted by key, then by index.
  void sort(std::span<const Vec3> x, Isa isa, std::vector<std::uint32_t>& order);

  /// The sorted keys of the last call.
  std::span<const std::uint64_t> keys() const { return key_; }

 private:
  bool merge_nearly_sorted();
  void mark_strays();
  void radix_sort(std::vector<std::uint64_t>& key, std::vector<std::uint32_t>& index);
  static void sort_crowds(std::span<const Vec3> x, Isa isa, std::span<const std::uint64_t> key,
                          std::span<std::uint32_t> order);

  std::vector<std::uint64_t> key_, key_2_, word_;
  std::vector<std::uint32_t> index_, index_2_;
  std::vector<unsigned char> stray_;
};

}  // namespace core
