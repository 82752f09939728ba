// SPDX-License-Identifier: Apache-2.0
#include "coupling/meeting.hpp"

#include <algorithm>
#include <cmath>

namespace coupling {

using core::Vec3;

struct Triangle {
  Vec3 a, b, c;  // c: the face's centre
  Vec3 normal() const { return (a - c).cross(b - c); }
};

static Triangle moved(const Triangle& t, const Triangle& v, double dt) {
  return {t.a + dt * v.a, t.b + dt * v.b, t.c + dt * v.c};
}

/// Barycentric coordinates (a, b) of the foot of p on the triangle; c has the rest.
static std::array<double, 2> barycentric(const Triangle& t, const Vec3& p) {
  const Vec3 u = t.a - t.c, w = t.b - t.c, d = p - t.c;
  const double uu = u.dot(u), ww = w.dot(w), uw = u.dot(w), du = d.dot(u), dw = d.dot(w);
  const double det = uu * ww - uw * uw;
  return {(du * ww - dw * uw) / det, (dw * uu - du * uw) / det};
}

static double gap_at(const Triangle& t, const Triangle& v, const Vec3& p, const Vec3& vp, double time) {
  const Triangle now = moved(t, v, time);
  return now.normal().normalized().dot(p + time * vp - now.c);
}

/// Time at which the signed distance falls to `gap`, by bracketed secant steps; 0 where it starts below.
static double time_of_gap(const Triangle& t, const Triangle& v, const Vec3& p, const Vec3& vp, double dt, double gap,
                          double gap_start, double gap_end, double tolerance) {
  double t0 = 0, g0 = gap_start - gap, t1 = dt, g1 = gap_end - gap, when = 0;
  if (g1 >= 0) return dt;
  for (int k = 0; k < 12 && g0 > tolerance; ++k) {
    when = t0 + (t1 - t0) * g0 / (g0 - g1);
    const double g = gap_at(t, v, p, vp, when) - gap;
    if (std::abs(g) < tolerance) break;
    if (g > 0)
      t0 = when, g0 = g;
    else
      t1 = when, g1 = g;
  }
  return when;
}

/// A corner of the face, and its velocity.
struct Corner {
  Vec3 x, v;
};

/// Does p(t) come nearer than the margin to the moving triangle, from outside, within dt? before, after: the face's corners that
/// go before t.a and after t.b.
static bool meets(const Triangle& t, const Triangle& v, const Corner& before, const Corner& after, const Vec3& p, const Vec3& vp,
                  double dt, double margin, bool strict, Meeting& m, std::array<double, 2>& where) {
  const Vec3 n0 = t.normal();
  const double area2 = n0.norm();
  if (!(area2 > 0)) return false;
  const double gap_0 = n0.dot(p - t.c) / area2;
  if (gap_0 < (strict ? -1e-9 : -1e-3) * margin) return false;  // already behind this sheet's plane: not from outside
  m.target = strict ? 0.0 : std::max(0.0, std::min(gap_0, margin));
  m.slack = 0.02 * margin;
  const Triangle end = moved(t, v, dt);
  const Vec3 n1 = end.normal();
  const double end_norm = n1.norm();
  if (!(end_norm > 0)) return false;
  m.normal = n1 / end_norm;
  m.gap_end = m.normal.dot(p + dt * vp - end.c);
  // what touches is to keep no gap: round-off on either side of none is none, or such a pair would never be let alone
  if (m.gap_end >= (strict ? -1e-9 * margin : 0.5 * m.target - 0.5e-9 * margin)) return false;
  const double low = strict ? 0.0 : -edge_tolerance;
  const auto inside_at = [&](double gap) {
    const double when = time_of_gap(t, v, p, vp, dt, gap, gap_0, m.gap_end, 0.1 * margin);
    const Triangle now = moved(t, v, when);
    const Vec3 at = p + when * vp;
    const double most = strict ? 1.0 : 1 + overhang;
    where = barycentric(now, at);
    if (!(where[0] >= low && where[1] >= low && where[0] + where[1] <= most)) return false;
    // over the triangle beside this one it may lie beyond the face's edge
    const auto over = [&](const Vec3& a, const Vec3& b) {
      const auto w = barycentric({a, b, now.c}, at);
      return w[0] + w[1] <= most;
    };
    if (where[1] < 0 && !over(before.x + when * before.v, now.a)) return false;
    return !(where[0] < 0) || over(now.b, after.x + when * after.v);
  };
  // A point that slides along while it closes in may come over the triangle only between margin and sheet.
  return inside_at(m.target) || (m.target > 0 && m.gap_end < 0 && inside_at(0.0));
}

/// The line of the impulse, and where that meets the triangle. outward: at its corners.
static void aim(const Triangle& t, const Triangle& v, const Triangle& outward, const Vec3& p, const Vec3& vp, double dt, Meeting& m, std::array<double, 2>& where) {
  where = {std::clamp(where[0], 0.0, 1.0), std::clamp(where[1], 0.0, 1.0)};
  if (const double sum = where[0] + where[1]; sum > 1) where = {where[0] / sum, where[1] / sum};
  // Along the direction of the step's start: that of its end depends on which corners have been stopped already, so on the order of the
  // sweeps, and would push sideways what meets flat. But where that would take much more than the pair closes by, the face turns.
  const Vec3 closing = vp - (where[0] * v.a + where[1] * v.b + (1 - where[0] - where[1]) * v.c);
  constexpr double most_of_closing = 1.5, least_cosine = 0.5;
  m.push = (where[0] * outward.a + where[1] * outward.b + (1 - where[0] - where[1]) * outward.c).normalized();
  if (m.target - m.gap_end > -most_of_closing * dt * closing.dot(m.push) || m.push.dot(m.normal) < least_cosine) m.push = m.normal;
  // The impulse acts on positions of the step's start: there its line must pass through the foot, or it makes a couple.
  const Vec3 n0 = t.normal();
  const auto foot = barycentric(t, p - n0.dot(p - t.c) / n0.dot(m.push) * m.push);
  if (foot[0] > -0.5 && foot[1] > -0.5 && foot[0] + foot[1] < 1.5) where = foot;
}

Meeting meet(const fem::Nodes& n, const FaceNodes& node, const Outward* outward, const Vec3& x, const Vec3& v, double dt, bool strict) {
  const Vec3 xc = 0.25 * (n.x[node[0]] + n.x[node[1]] + n.x[node[2]] + n.x[node[3]]);
  const Vec3 vc = 0.25 * (n.v[node[0]] + n.v[node[1]] + n.v[node[2]] + n.v[node[3]]);
  const Vec3 diagonals = (n.x[node[2]] - n.x[node[0]]).cross(n.x[node[3]] - n.x[node[1]]);
  const double margin = margin_part * std::sqrt(0.5 * diagonals.norm());
  Meeting best;
  const double reach = margin + (v - vc).norm() * dt;
  double face = 0;
  for (const auto k : node) face = std::max(face, (n.x[k] - xc).norm() + (n.v[k] - vc).norm() * dt);
  if ((x - xc).norm() > reach + face) return best;
  for (std::size_t k = 0; k < 4; ++k) {
    const std::size_t a = node[k], b = node[(k + 1) % 4], before = node[(k + 3) % 4], after = node[(k + 2) % 4];
    Meeting m;
    std::array<double, 2> w;
    const Triangle start{n.x[a], n.x[b], xc}, motion{n.v[a], n.v[b], vc};
    if (!meets(start, motion, {n.x[before], n.v[before]}, {n.x[after], n.v[after]}, x, v, dt, margin, strict, m, w)) continue;
    if (best.found && best.gap_end <= m.gap_end) continue;
    if (outward) {
      const auto& o = *outward;
      aim(start, motion, {o[k], o[(k + 1) % 4], 0.25 * (o[0] + o[1] + o[2] + o[3])}, x, v, dt, m, w);
    }
    best = m;
    best.found = true;
    best.triangle = k;
    best.weight.fill(0.25 * (1 - w[0] - w[1]));
    best.weight[k] += w[0];
    best.weight[(k + 1) % 4] += w[1];
  }
  return best;
}

double gap_at_end(const fem::Nodes& n, const FaceNodes& node, std::size_t triangle, const Vec3& x, const Vec3& v, double dt) {
  const auto end = [&](std::size_t k) -> Vec3 { return n.x[node[k]] + dt * n.v[node[k]]; };
  const Vec3 centre = 0.25 * (end(0) + end(1) + end(2) + end(3));
  const Triangle t{end(triangle), end((triangle + 1) % 4), centre};
  return t.normal().normalized().dot(x + dt * v - centre);
}

FaceSweep face_sweep(const fem::Nodes& n, const FaceNodes& node, double dt) {
  FaceSweep f;
  f.x = 0.25 * (n.x[node[0]] + n.x[node[1]] + n.x[node[2]] + n.x[node[3]]);
  f.v = 0.25 * (n.v[node[0]] + n.v[node[1]] + n.v[node[2]] + n.v[node[3]]);
  f.normal = (n.x[node[2]] - n.x[node[0]]).cross(n.x[node[3]] - n.x[node[1]]).normalized();
  f.dt = dt;
  double size_2 = 0, spread_2 = 0;
  for (const auto k : node) {
    const Vec3 d = n.x[k] - f.x, w = n.v[k] - f.v;
    size_2 = std::max(size_2, d.squaredNorm());
    spread_2 = std::max(spread_2, w.squaredNorm());
    const double start = f.normal.dot(d), end = start + dt * f.normal.dot(w);
    f.low = std::min({f.low, start, end});
    f.high = std::max({f.high, start, end});
  }
  // The area of a quadrilateral is at most twice the square of its largest half diagonal: 0.01 of that covers the margin
  // three times, and 0.05 of the slab what triangles reach beyond their edges.
  const double size = std::sqrt(size_2), wider = 0.01 * size + 0.05 * (f.high - f.low);
  f.low -= wider;
  f.high += wider;
  f.radius = (1.01 + edge_tolerance) * size + dt * std::sqrt(spread_2);
  return f;
}

}  // namespace coupling
