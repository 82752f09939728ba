// SPDX-License-Identifier: Apache-2.0
// Parallel loops whose results do not depend on the number of threads: every index is written by one iteration, and
// sums run over blocks of fixed size that are added up in order. The only file that may mention OpenMP.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <vector>
#ifdef _OPENMP
#include <omp.h>
#endif

namespace core {

inline void set_threads([[maybe_unused]] int n) {
#ifdef _OPENMP
  omp_set_num_threads(n);
#endif
}

inline int threads() {
#ifdef _OPENMP
  return omp_get_max_threads();
#else
  return 1;
#endif
}

/// f(first, last) over pieces of [0, n) of the given size, in no particular order; for loops that carry scratch. Threads begin with
/// shares of their own, the same at every call, so that what they wrote is still in their caches; who is done helps others.
template <class F>
void for_each_block(std::size_t n, std::size_t block, F&& f) {
  const std::size_t n_blocks = (n + block - 1) / block;
  const auto run = [&](std::size_t b) { f(b * block, std::min(n, (b + 1) * block)); };
  const auto n_shares = std::min(static_cast<std::size_t>(threads()), n_blocks);
  if (n_shares <= 1) {
    for (std::size_t b = 0; b < n_blocks; ++b) run(b);
    return;
  }
  struct alignas(64) Share {
    std::atomic<std::size_t> next;
    std::size_t end;
  };
  std::vector<Share> share(n_shares);
  for (std::size_t k = 0; k < n_shares; ++k) share[k].next = n_blocks * k / n_shares, share[k].end = n_blocks * (k + 1) / n_shares;
#pragma omp parallel for schedule(static, 1) num_threads(static_cast<int>(n_shares))
  for (std::size_t own = 0; own < n_shares; ++own)
    for (std::size_t k = 0; k < n_shares; ++k) {
      Share& s = share[(own + k) % n_shares];
      for (std::size_t b; (b = s.next.fetch_add(1, std::memory_order_relaxed)) < s.end;) run(b);
    }
}

/// f(i) for i in [0, n), in no particular order.
template <class F>
void for_each(std::size_t n, F&& f) {
  constexpr std::size_t few = 1024, block = 512;
  if (n <= few)
    for (std::size_t i = 0; i < n; ++i) f(i);
  else
    for_each_block(n, block, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) f(i);
    });
}

/// f(first, last) over [0, n) in one range for each thread; for loops that go through everything and keep what falls into the range.
template <class F>
void for_each_share(std::size_t n, F&& f) {
  const auto parts = static_cast<std::size_t>(threads());
  for_each_block(parts, 1, [&](std::size_t part, std::size_t) { f(n * part / parts, n * (part + 1) / parts); });
}

/// What add(k, list) appends for k in [0, n), in order.
template <class T, class Add>
std::vector<T> collect(std::size_t n, Add&& add) {
  constexpr std::size_t block = 1024;
  std::vector<std::vector<T>> part((n + block - 1) / block);
  for_each_block(n, block, [&](std::size_t first, std::size_t last) {
    for (std::size_t k = first; k < last; ++k) add(k, part[first / block]);
  });
  std::vector<T> all;
  for (const auto& list : part) all.insert(all.end(), list.begin(), list.end());
  return all;
}

constexpr std::size_t reduction_block = 1024;

/// combine over blocks of fixed size, partial results joined in order: the same bits on any number of threads.
/// map(first, last) -> R for one block; join(R, R) -> R.
template <class R, class Map, class Join>
R reduce(std::size_t n, R start, Map&& map, Join&& join) {
  const std::size_t n_blocks = (n + reduction_block - 1) / reduction_block;
  if (n_blocks <= 1) return n == 0 ? start : join(start, map(std::size_t{0}, n));
  std::vector<R> part(n_blocks, start);
  for_each_block(n, reduction_block,
                 [&](std::size_t first, std::size_t last) { part[first / reduction_block] = map(first, last); });
  R result = start;
  for (const R& r : part) result = join(result, r);
  return result;
}

/// Sum of f(i) over [0, n).
template <class R, class F>
R sum(std::size_t n, R zero, F&& f) {
  return reduce(
      n, zero,
      [&](std::size_t first, std::size_t last) {
        R r = zero;
        for (std::size_t i = first; i < last; ++i) r += f(i);
        return r;
      },
      [](R a, const R& b) { return R(a + b); });
}

/// The smallest value of f(i) and the lowest index that has it.
struct MinWhere {
  double value = 1e300;
  std::size_t index = 0;
};
template <class F>
MinWhere min_where(std::size_t n, F&& f) {
  return reduce(
      n, MinWhere{},
      [&](std::size_t first, std::size_t last) {
        MinWhere r;
        for (std::size_t i = first; i < last; ++i)
          if (const double v = f(i); v < r.value) r = {v, i};
        return r;
      },
      [](MinWhere a, MinWhere b) { return b.value < a.value ? b : a; });
}

}  // namespace core
