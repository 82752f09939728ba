// SPDX-License-Identifier: Apache-2.0
#include "fem/added_inertia.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace fem {

using core::Mat3;
using core::Vec3;
using AtCorners = std::array<Vec3, 8>;

static AtCorners corners_of(const Mesh& mesh, std::size_t el, const std::vector<Vec3>& a) {
  AtCorners c;
  for (std::size_t k = 0; k < 8; ++k) c[k] = a[static_cast<std::size_t>(mesh.elements.node[el][k])];
  return c;
}

/// An element's corners and the part of their motions that is neither a translation nor a rotation.
class Strainer {
 public:
  Strainer(const Mesh& mesh, std::size_t el) : r_(corners_of(mesh, el, mesh.nodes.x)) {
    const Vec3 middle = centre(mesh, el, mesh.nodes.x);
    Mat3 spin = Mat3::Zero();
    for (auto& r : r_) {
      r -= middle;
      spin += r.squaredNorm() * Mat3::Identity() - r * r.transpose();
    }
    inverse_ = spin.inverse();
  }
  AtCorners operator()(AtCorners a) const {
    Vec3 mean = Vec3::Zero(), torque = Vec3::Zero();
    for (const auto& v : a) mean += 0.125 * v;
    for (std::size_t c = 0; c < 8; ++c) torque += r_[c].cross(a[c]);
    const Vec3 turn = inverse_ * torque;
    for (std::size_t c = 0; c < 8; ++c) a[c] -= mean + turn.cross(r_[c]);
    return a;
  }

 private:
  AtCorners r_;
  Mat3 inverse_;
};

static bool squeezed(const Elements& e, std::size_t el) { return e.dt[el] < 0.9 * e.dt_0[el]; }

/// Does it strain by less than a hundredth while sound crosses it?
static bool quiet(const Mesh& mesh, std::size_t el) {
  constexpr double most = 0.01;
  const AtCorners v = corners_of(mesh, el, mesh.nodes.v);
  const Vec3 mean = centre(mesh, el, mesh.nodes.v);
  const double limit = most * mesh.elements.pt.c[el];
  return std::all_of(v.begin(), v.end(), [&](const Vec3& a) { return (a - mean).squaredNorm() < limit * limit; });
}

/// How many elements have steps in each part of [shortest, 2 shortest); those that must not be slowed count for too many.
constexpr std::size_t parts = 32;
template <class May>
static std::array<std::size_t, parts> count_by_step(const Mesh& mesh, double shortest, double longest, std::size_t too_many, May&& may) {
  using Counts = std::array<std::size_t, parts>;
  const Elements& e = mesh.elements;
  return core::reduce(
      e.size(), Counts{},
      [&](std::size_t first, std::size_t last) {
        Counts c{};
        for (std::size_t el = first; el < last; ++el) {
          if (!(e.dt[el] >= shortest) || !(e.dt[el] < longest)) continue;
          const auto part = static_cast<std::size_t>((e.dt[el] / shortest - 1) * parts);
          c[std::min(part, parts - 1)] += may(el) ? 1 : too_many;
        }
        return c;
      },
      [](Counts a, const Counts& b) {
        for (std::size_t k = 0; k < parts; ++k) a[k] += b[k];
        return a;
      });
}

double step_with_few_slowed(const Mesh& mesh, core::MinWhere shortest) {
  constexpr std::size_t one_in = 100;
  const Elements& e = mesh.elements;
  if (!(shortest.value < 1e300) || !squeezed(e, shortest.index) || !quiet(mesh, shortest.index)) return shortest.value;
  // what nothing has reached does not count, asleep or awake
  const std::size_t few = core::sum(e.size(), std::size_t{0}, [&](std::size_t el) { return std::size_t{e.alive[el] && e.deformation[el] > 0}; }) / one_in;
  const auto longest = [&](double below, auto&& may) {
    const auto counts = count_by_step(mesh, shortest.value, below, few + 1, may);
    std::size_t part = 0;
    for (std::size_t n = 0; part < parts && (n += counts[part]) <= few; ++part) {}
    return shortest.value * (1 + static_cast<double>(part) / parts);
  };
  // first by what lies in arrays alone: few are left then whose corners must be looked at
  const double bound = longest(2 * shortest.value, [&](std::size_t el) { return squeezed(e, el); });
  return std::min(bound, longest(bound, [&](std::size_t el) { return quiet(mesh, el); }));
}

std::vector<Slowed> slowed_elements(const Mesh& mesh, double dt) {
  const Elements& e = mesh.elements;
  return core::collect<Slowed>(e.size(), [&](std::size_t el, std::vector<Slowed>& slowed) {
    if (!(e.dt[el] < dt) || !squeezed(e, el)) return;
    const double ratio = dt / e.dt[el];
    slowed.push_back({static_cast<std::uint32_t>(el), ratio * ratio - 1});
  });
}

namespace {

/// (M + sum of M_e) a = f at the nodes of what is slowed, by conjugate gradients with the diagonal as preconditioner.
class Inertia {
 public:
  Inertia(const Mesh& mesh, const std::vector<Slowed>& slowed) : mesh_(mesh) {
    for (const Slowed& s : slowed) {
      const auto& node = mesh.elements.node[s.element];
      for (const auto nd : node) nodes_.push_back(static_cast<std::uint32_t>(nd));
      strainer_.emplace_back(mesh, s.element);
      mass_.push_back(0.125 * s.inertia * mesh.elements.pt.m[s.element]);
    }
    std::sort(nodes_.begin(), nodes_.end());
    nodes_.erase(std::unique(nodes_.begin(), nodes_.end()), nodes_.end());
    for (const auto nd : nodes_) diagonal_.push_back(mesh.nodes.m[nd]);
    for (std::size_t k = 0; k < slowed.size(); ++k) {
      std::array<std::uint32_t, 8> at;
      for (std::size_t c = 0; c < 8; ++c) {
        const auto nd = static_cast<std::uint32_t>(mesh.elements.node[slowed[k].element][c]);
        at[c] = static_cast<std::uint32_t>(std::lower_bound(nodes_.begin(), nodes_.end(), nd) - nodes_.begin());
        diagonal_[at[c]] += mass_[k];
      }
      at_.push_back(at);
    }
  }

  const std::vector<std::uint32_t>& nodes() const { return nodes_; }

  /// The corner forces against accelerations, -M_e a, and likewise momenta against velocities.
  AtCorners against(std::size_t k, const std::vector<Vec3>& a) const {
    AtCorners c;
    for (std::size_t i = 0; i < 8; ++i) c[i] = a[at_[k][i]];
    c = strainer_[k](c);
    for (auto& v : c) v *= -mass_[k];
    return c;
  }

  /// Accelerations [m/s2] under forces [N].
  std::vector<Vec3> solve(const std::vector<Vec3>& force) const {
    constexpr int most = 30;
    constexpr double close = 1e-4;
    const std::size_t n = nodes_.size();
    std::vector<Vec3> a(n, Vec3::Zero()), r(force), z(n), p(n), q(n);
    double old = 0, first = 0;
    for (int k = 0; k < most; ++k) {
      double rz = 0;
      for (std::size_t i = 0; i < n; ++i) z[i] = r[i] / diagonal_[i], rz += r[i].dot(z[i]);
      if (k == 0) first = rz;
      if (!(rz > close * close * first)) break;
      for (std::size_t i = 0; i < n; ++i) p[i] = k == 0 ? z[i] : Vec3(z[i] + rz / old * p[i]);
      apply(p, q);
      double pq = 0;
      for (std::size_t i = 0; i < n; ++i) pq += p[i].dot(q[i]);
      for (std::size_t i = 0; i < n; ++i) a[i] += rz / pq * p[i], r[i] -= rz / pq * q[i];
      old = rz;
    }
    return a;
  }

 private:
  void apply(const std::vector<Vec3>& a, std::vector<Vec3>& f) const {
    for (std::size_t i = 0; i < nodes_.size(); ++i) f[i] = mesh_.nodes.m[nodes_[i]] * a[i];
    for (std::size_t k = 0; k < at_.size(); ++k) {
      const AtCorners c = against(k, a);
      for (std::size_t i = 0; i < 8; ++i) f[at_[k][i]] -= c[i];
    }
    for (std::size_t i = 0; i < nodes_.size(); ++i) f[i] = free_part(f[i], mesh_.nodes.fixed[nodes_[i]]);
  }

  const Mesh& mesh_;
  std::vector<std::uint32_t> nodes_;
  std::vector<double> diagonal_;                   ///< [node] [kg]
  std::vector<Strainer> strainer_;                 ///< [slowed]
  std::vector<double> mass_;                       ///< [slowed] added at a corner [kg]
  std::vector<std::array<std::uint32_t, 8>> at_;   ///< [slowed] corners in `nodes`
};

}  // namespace

double add_inertia(Mesh& mesh, const std::vector<Slowed>& slowed) {
  if (slowed.empty()) return 0;
  const Inertia inertia(mesh, slowed);
  std::vector<Vec3> force, v;
  for (const auto nd : inertia.nodes()) {
    force.push_back(free_part(force_at(mesh, nd), mesh.nodes.fixed[nd]));
    v.push_back(mesh.nodes.v[nd]);
  }
  const auto a = inertia.solve(force);
  double energy = 0;
  for (std::size_t k = 0; k < slowed.size(); ++k) {
    const AtCorners f = inertia.against(k, a), momentum = inertia.against(k, v);
    for (std::size_t c = 0; c < 8; ++c) {
      for (int d = 0; d < 3; ++d) *force_of(mesh.elements, corner_index(slowed[k].element, static_cast<int>(c), d)) += f[c][d];
      energy -= 0.5 * momentum[c].dot(mesh.nodes.v[static_cast<std::size_t>(mesh.elements.node[slowed[k].element][c])]);
    }
  }
  return energy;
}

}  // namespace fem
