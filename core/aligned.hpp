// SPDX-License-Identifier: Apache-2.0
// Arrays that begin on a cache line, so that loads of a whole vector register do not straddle two.
#pragma once

#include <cstddef>
#include <new>
#include <vector>

namespace core {

template <class T>
struct OnCacheLine {
  using value_type = T;
  static constexpr std::align_val_t line{64};

  OnCacheLine() = default;
  template <class U>
  OnCacheLine(const OnCacheLine<U>&) {}

  T* allocate(std::size_t n) { return static_cast<T*>(::operator new(n * sizeof(T), line)); }
  void deallocate(T* a, std::size_t) { ::operator delete(a, line); }
  bool operator==(const OnCacheLine&) const = default;
};

template <class T>
using Aligned = std::vector<T, OnCacheLine<T>>;

}  // namespace core
