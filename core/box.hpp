// SPDX-License-Identifier: Apache-2.0
// A box along the axes, around what is added to it.
#pragma once

#include "core/types.hpp"

namespace core {

struct Box {
  Vec3 low = Vec3::Constant(1e300), high = Vec3::Constant(-1e300);

  void add(const Vec3& x) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  void add(const Box& b) {
    low = low.cwiseMin(b.low);
    high = high.cwiseMax(b.high);
  }
  static Box join(Box a, const Box& b) {
    a.add(b);
    return a;
  }
  bool empty() const { return low[0] > high[0]; }
  bool contains(const Vec3& x) const { return (x.array() >= low.array()).all() && (x.array() <= high.array()).all(); }
  bool touches(const Box& o) const { return (o.high.array() >= low.array()).all() && (o.low.array() <= high.array()).all(); }
  Box widened(double by) const { return {low.array() - by, high.array() + by}; }
  double distance(const Box& o) const {
    return (o.low - high).cwiseMax(low - o.high).cwiseMax(Vec3::Zero()).norm();
  }
  /// Largest differences in the coordinates between a point here and one there.
  Vec3 apart(const Box& o) const { return (high - o.low).cwiseMax(o.high - low); }
};

}  // namespace core
