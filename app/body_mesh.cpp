// SPDX-License-Identifier: Apache-2.0
#include "app/body_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/box.hpp"
#include "core/error.hpp"
#include "core/orientation.hpp"
#include "fem/hex8.hpp"
#include "io/mesh_deck.hpp"

namespace app {

using core::Vec3;
using io::Shape;

double smallest_extent(const io::BodySpec& b) { return extent(b).minCoeff(); }

void measure_decks(io::Case& spec) {
  for (auto& b : spec.bodies) {
    if (b.shape != Shape::mesh || b.element_size) continue;  // no case gives a deck's element size: it is known by now
    auto deck = io::read_mesh_deck(b.file, 1.0);
    core::Box box;
    for (const Vec3& x : deck.x) box.add(x);
    b.size = box.high - box.low;
    b.deck_middle = 0.5 * (box.low + box.high);
    const auto count = static_cast<double>(deck.node.size());
    b.element_size = std::cbrt(fem::quality({std::move(deck.x), std::move(deck.node)}).volume / count);
  }
}

/// Edge of the elements of what flies [m].
static double projectile_edge(const io::Case& spec) {
  const auto& shot = spec.bodies[static_cast<std::size_t>(projectile_of(spec))];
  return shot.element_size.value_or(smallest_extent(shot) / spec.elements_across);
}

bool is_box(const io::BodySpec& b) { return b.shape == Shape::plate || b.shape == Shape::box; }

Vec3 at_rest(const io::Case& spec) {
  const auto& bodies = spec.bodies;
  const bool boxes = std::any_of(bodies.begin(), bodies.end(), is_box);
  const auto rests = [&](const io::BodySpec& b) { return (!boxes || is_box(b)) && b.velocity.isZero(0); };
  const auto flies_along = [&](const io::BodySpec& b) { return b.velocity == bodies.front().velocity; };
  if (!spec.walls.empty() || std::any_of(bodies.begin(), bodies.end(), rests)) return Vec3::Zero();
  if (!boxes && std::all_of(bodies.begin(), bodies.end(), flies_along)) return Vec3::Zero();  // nothing strikes anything
  const auto width = [](const io::BodySpec& b) { return extent(b)[0] * extent(b)[1]; };
  const io::BodySpec* widest = &bodies.front();
  for (const auto& b : bodies)
    if (width(b) > width(*widest) || (width(b) == width(*widest) && b.velocity.norm() < widest->velocity.norm())) widest = &b;
  return widest->velocity;
}

int projectile_of(const io::Case& spec) {
  const Vec3 rest = at_rest(spec);
  const auto speed = [&](std::size_t b) { return (spec.bodies[b].velocity - rest).norm(); };
  std::size_t best = 0;
  for (std::size_t b = 1; b < spec.bodies.size(); ++b)
    if (speed(b) > speed(best)) best = b;
  return static_cast<int>(best);
}

/// Turns the body's own axes into the scene's.
static core::Mat3 rotation(const io::BodySpec& b) {
  if (b.shape == Shape::sphere) return core::Mat3::Identity();
  const Vec3 n = b.normal.normalized();
  return core::orientation(b.shape == Shape::mesh ? n : core::upright(n));  // a mesh is not the same upside down
}

/// Is the body's own axis `own` the scene's `axis`, but for round-off? What is tilted by more, be it by a millionth, has no nodes on a plane of symmetry.
static bool is_axis(const core::Mat3& turn, int axis, int own) {
  constexpr double round_off = 1e-14;
  return (turn.row(axis).transpose() - Vec3(Vec3::Unit(own))).norm() < round_off;
}

bool lies_along(const io::BodySpec& b, int axis) {
  const core::Mat3 r = rotation(b);
  return is_axis(r, axis, 0) || is_axis(r, axis, 1) || is_axis(r, axis, 2);
}

/// The scene's symmetry planes in the body's own axes.
static core::Symmetry own_planes(const io::Case& spec, const io::BodySpec& b) {
  const core::Mat3 r = rotation(b);
  core::Symmetry own;
  for (int d = 0; d < 3; ++d)
    for (int a = 0; a < 3; ++a)
      if (spec.symmetry.plane[static_cast<std::size_t>(d)] && is_axis(r, d, a)) own.plane[static_cast<std::size_t>(a)] = true;
  return own;
}

Vec3 middle(const io::BodySpec& b) { return b.center + rotation(b) * b.deck_middle; }

/// The projectile's velocity as seen from a body; from what is at rest where the two fly together.
static Vec3 approach(const io::Case& spec, const io::BodySpec& b) {
  const Vec3 shot = spec.bodies[static_cast<std::size_t>(projectile_of(spec))].velocity;
  return shot == b.velocity ? Vec3(shot - at_rest(spec)) : Vec3(shot - b.velocity);
}

static Vec3 flight(const io::Case& spec, const io::BodySpec& b) {
  const Vec3 v = approach(spec, b);
  return v.isZero(0) ? Vec3(0, 0, -1) : Vec3(v.normalized());
}

Vec3 where_struck(const io::Case& spec, std::size_t body) {
  const auto& b = spec.bodies[body];
  const Vec3 n = b.normal.normalized(), from = middle(spec.bodies[static_cast<std::size_t>(projectile_of(spec))]), v = flight(spec, b);
  const double side = v.dot(n) > 0 ? -1 : 1;
  const double along = v.dot(n), thickness = extent(b)[2];
  if (std::abs(along) < 1e-9) return b.center;
  return from + v * (n.dot(b.center + side * 0.5 * thickness * n - from) / along);
}

/// Where a moving body's line of flight, as seen from a plate that may fly too, meets the plate's near face, in the plate's own axes.
static Vec3 struck_at(const io::Case& spec, std::size_t body, std::size_t striker) {
  const auto &b = spec.bodies[body], &s = spec.bodies[striker];
  const core::Mat3 own = rotation(b).transpose();
  const Vec3 from = own * (middle(s) - b.center), v = own * (s.velocity == b.velocity ? flight(spec, b) : Vec3(s.velocity - b.velocity));
  if (std::abs(v[2]) < 1e-9 * v.norm() || v.isZero(0)) return Vec3::Zero();
  return from + v * ((-std::copysign(0.5 * extent(b)[2], v[2]) - from[2]) / v[2]);
}

bool struck_from_side(const io::Case& spec, std::size_t body) {
  const auto& b = spec.bodies[body];
  const core::Mat3 own = rotation(b).transpose();
  const Vec3 from = own * (middle(spec.bodies[static_cast<std::size_t>(projectile_of(spec))]) - b.center), along = own * flight(spec, b);
  std::array<double, 3> enters{};
  for (int axis = 0; axis < 3; ++axis)
    enters[static_cast<std::size_t>(axis)] = std::abs(along[axis]) < 1e-9 ? -1e300 : (-std::copysign(0.5 * extent(b)[axis], along[axis]) - from[axis]) / along[axis];
  return enters[2] < std::max(enters[0], enters[1]);
}

std::vector<int> plates_in_order(const io::Case& spec) {
  const int shot = projectile_of(spec);
  const Vec3 from = middle(spec.bodies[static_cast<std::size_t>(shot)]), flies = spec.bodies[static_cast<std::size_t>(shot)].velocity;
  const bool all_rest = flies == at_rest(spec);
  std::vector<std::pair<double, int>> met;
  for (std::size_t b = 0; b < spec.bodies.size(); ++b) {
    const auto& body = spec.bodies[b];
    if (static_cast<int>(b) == shot || (body.velocity == flies && !all_rest) || !is_box(body)) continue;
    const core::Mat3 own = rotation(body).transpose();
    const Vec3 v = flight(spec, body);
    const Vec3 hit = where_struck(spec, b), local = own * (hit - body.center), start = own * (from - body.center), along = own * v;
    if (std::abs(local[0]) > 0.5 * body.size[0] || std::abs(local[1]) > 0.5 * body.size[1]) continue;
    bool beside = false;  // the line runs along the body and past it
    for (int axis = 0; axis < 3; ++axis) beside = beside || (std::abs(along[axis]) < 1e-9 && std::abs(start[axis]) > 0.5 * body.size[axis]);
    if (beside) continue;
    const double speed = approach(spec, body).norm();
    met.push_back({v.dot(hit - from) / (speed > 0 ? speed : 1), static_cast<int>(b)});
  }
  std::sort(met.begin(), met.end());
  std::vector<int> order;
  for (const auto& [when, b] : met)
    if (when > 0) order.push_back(b);
  return order;
}

/// Signed distance from a point to the body's surface, negative inside; conservative outside near edges.
static double distance(const io::BodySpec& b, const Vec3& x) {
  const Vec3 l = rotation(b).transpose() * (x - b.center);
  if (b.shape == Shape::sphere) return l.norm() - 0.5 * b.diameter;
  if (b.shape == Shape::cylinder)
    return std::max(std::hypot(l[0], l[1]) - 0.5 * b.diameter, std::abs(l[2]) - 0.5 * b.length);
  const Vec3 d = l.cwiseAbs() - 0.5 * b.size;
  return d.maxCoeff();
}

/// Can anything get as far as this body before that time? Debris flies at most half as fast again as the fastest body,
/// and a shock of an impact at that speed v runs at no more than the sound speed and three quarters of v.
static bool reached(const io::Case& spec, const io::BodySpec& b, double time) {
  const Vec3 rest = at_rest(spec);
  double sound = 0, fastest = 0, nearest = 1e300;
  for (const auto& m : spec.bodies) {
    const auto& material = spec.materials.at(m.material);
    sound = std::max(sound, material::sound_speed(material));
    const double speed = (m.velocity - rest).norm();
    if (speed == 0 && m.spin.isZero(0)) continue;
    const double radius = 0.5 * extent(m).norm();
    fastest = std::max(fastest, speed + m.spin.norm() * radius);
    nearest = std::min(nearest, distance(b, middle(m)) - radius);
  }
  return fastest == 0 || nearest < std::max(1.5 * fastest, sound + 0.75 * fastest) * time;
}

/// Is this plate meshed as one that nothing gets to?
static bool out_of_reach(const io::Case& spec, const io::BodySpec& b) {
  return spec.mode != io::Mode::sph && !b.element_size && !reached(spec, b, spec.mesh_end > 0 ? spec.mesh_end : spec.end);
}

// ------------------------------------------------------------------------------------------------ plates

constexpr double coarsest = 20;  ///< largest edge along a plate, in fine ones

struct PlateGrid {
  std::vector<double> x, y, z;
  double fine = 0;
};

/// Fine edge and half-width of the fine mesh for the k-th plate in flight order (k < 0: not on the line of flight).
static std::pair<double, double> fineness(const io::Case& spec, const io::BodySpec& b, int k, double distance) {
  const auto& shot = spec.bodies[static_cast<std::size_t>(projectile_of(spec))];
  const double d = smallest_extent(shot);
  double fine = projectile_edge(spec);
  double half = 1.5 * d;
  constexpr double later_layers = 6, cloud_slope = 0.25, widest = 6;
  if (k > 0) {
    fine = std::max(fine, b.size[2] / later_layers);
    half = std::min(1.5 * d + cloud_slope * distance, widest * d);  // farther off, what arrives is thin
  }
  if (spec.mode == io::Mode::sph) {  // long flat hexes would make particles with gaps between them
    half = extent(b).norm();
    fine = std::min(fine, b.size[2]);
  } else if (b.size[2] > 2 * d) {
    half = 2.2 * d;  // a thick target: the crater and its rim
  }
  if (out_of_reach(spec, b)) fine *= coarsest;
  if (b.element_size) fine = *b.element_size;
  if (b.fine_radius) half = *b.fine_radius;
  return {fine, half};
}

/// Refuses what no machine holds, before a line of so many elements is drawn.
static void require_few(const io::Case& spec, const io::BodySpec& b, double elements) {
  constexpr double most = 1e7;
  if (elements > most)
    throw core::CaseError(fmt::format("{}: body.{}: has {:.3g} elements in a line, {:g} at most; take a larger element_size or fewer elements_across, or a smaller body",
                                      spec.file, b.name, elements, most));
}

static int elements_along(const io::Case& spec, const io::BodySpec& b, double length, double size, int least) {
  require_few(spec, b, length / size);
  return std::max(least, static_cast<int>(std::lround(length / size)));
}

/// A line of nodes that coarsens away from where a body is struck.
static std::vector<double> graded(const io::Case& spec, const io::BodySpec& b, double low, double high, const fem::Grading& g) {
  require_few(spec, b, std::min(2 * g.fine_half, high - low) / g.fine + (high - low) / g.coarse);
  return fem::graded_line(low, high, g);
}

/// Layers of elements that a plate has at least: how wide its cloud flies is known from five on, the hole that something slow and hard leaves
/// from four on. Flat ones let what strikes them, of more mass a face, drive the first one too fast: none has less than half of its edge for
/// the sake of four, and two thirds for that of five.
static int least_layers(const io::Case& spec, const io::BodySpec& b, double fine) {
  constexpr double round_off = 1e-9;
  constexpr int few = 2;  // one layer of particles has no way to become thinner, and bears pressure in its plane like a block
  const bool projectile = &b == &spec.bodies[static_cast<std::size_t>(projectile_of(spec))];
  if (projectile || b.element_size || spec.mode == io::Mode::sph) return few;  // particles of flat elements would have gaps between them
  const auto up_to = [&](double layers, double flattest) { return static_cast<int>(std::min(layers, b.size[2] / (flattest * fine) + round_off)); };
  return std::max({few, up_to(4, 1.0 / 2), up_to(5, 2.0 / 3)});
}

static std::vector<double> through(const io::Case& spec, const io::BodySpec& b, double fine, double half, double d, double focus, bool cut) {
  const double t = b.size[2];
  const int least = least_layers(spec, b, fine);
  if (cut) {
    std::vector<double> z;
    const int n = b.elements_through ? *b.elements_through / 2 : elements_along(spec, b, 0.5 * t, fine, least / 2);
    for (int i = 0; i <= n; ++i) z.push_back(0.5 * t * i / n);
    return z;
  }
  if (b.elements_through || t <= 2 * d) {
    const int n = b.elements_through ? *b.elements_through : elements_along(spec, b, t, fine, least);
    std::vector<double> z;
    for (int i = 0; i <= n; ++i) z.push_back(-0.5 * t + t * i / n);
    return z;
  }
  fem::Grading g;
  g.fine = fine;
  g.fine_half = spec.mode == io::Mode::sph ? half : std::min(half, 2.5 * d);
  g.focus = focus;
  g.coarse = 12 * fine;
  return graded(spec, b, -0.5 * t, 0.5 * t, g);
}

/// Does a body whose line of flight meets a plate's near face here strike it, with more than its edge?
static bool strikes(const io::BodySpec& striker, const io::BodySpec& plate, const Vec3& at) {
  const double radius = 0.5 * extent(striker).maxCoeff();
  return std::abs(at[0]) < 0.5 * plate.size[0] + radius && std::abs(at[1]) < 0.5 * plate.size[1] + radius;
}

/// Half-width of the fine mesh along one of a plate's own axes, `half` that of a sphere that strikes it square at `local` [m].
static double fine_half(const io::Case& spec, std::size_t body, int axis, const Vec3& local, double half) {
  const auto& b = spec.bodies[body];
  const auto shot_number = static_cast<std::size_t>(projectile_of(spec));
  const auto& shot = spec.bodies[shot_number];
  const Vec3 own_axis = rotation(b).col(axis);
  // an oblique shot spreads along the plate's tilt
  const Vec3 along = flight(spec, b);
  if (std::abs(along.dot(own_axis)) > 1e-9) half /= std::max(0.3, std::abs(along.dot(b.normal.normalized())));
  if (body == shot_number || b.fine_radius) return half;
  if (shot.shape != Shape::sphere) {  // what flies may be wider than it is thick
    const core::Mat3 turn = rotation(shot);
    double wide = 0;
    for (int a = 0; a < 3; ++a) wide += 0.5 * extent(shot)[a] * std::abs(turn.col(a).dot(own_axis));
    half += std::max(0.0, wide - 0.5 * smallest_extent(shot));
  }
  for (std::size_t o = 0; o < spec.bodies.size(); ++o) {  // others that strike it
    const io::BodySpec& other = spec.bodies[o];
    if (o == body || o == shot_number || !((b.center - middle(other)).dot(other.velocity - b.velocity) > 0)) continue;
    if (const Vec3 at = struck_at(spec, body, o); strikes(other, b, at))
      half = std::max(half, std::abs(at[axis] - local[axis]) + 1.5 * smallest_extent(other));
  }
  return half;
}

static PlateGrid plate_grid(const io::Case& spec, std::size_t body) {
  const auto& b = spec.bodies[body];
  const core::Symmetry own = own_planes(spec, b);
  if (own.plane[2] && b.elements_through && *b.elements_through % 2 != 0)
    throw core::CaseError(fmt::format("{}: body.{}.elements_through = {}: run.symmetry cuts the plate in its middle; must be even", spec.file, b.name,
                                      *b.elements_through));
  const auto order = plates_in_order(spec);
  const auto found = std::find(order.begin(), order.end(), static_cast<int>(body));
  const int k = found == order.end() ? -1 : static_cast<int>(found - order.begin());
  const Vec3 hit = where_struck(spec, body);
  const auto shot_number = static_cast<std::size_t>(projectile_of(spec));
  const auto& shot = spec.bodies[shot_number];
  Vec3 local = body == shot_number ? Vec3(Vec3::Zero()) : struck_at(spec, body, shot_number);
  if (k < 0 && !strikes(shot, b, local)) local.setZero();
  const double distance = k > 0 ? (hit - where_struck(spec, static_cast<std::size_t>(order[0]))).norm() : 0;
  const auto [fine, half] = fineness(spec, b, k, distance);
  PlateGrid g;
  g.fine = fine;
  for (int axis = 0; axis < 2; ++axis) {
    fem::Grading grading;
    grading.fine = fine;
    grading.fine_half = fine_half(spec, body, axis, local, half);
    grading.focus = local[axis];
    grading.coarse = coarsest * fine;
    const double edge = b.size[axis];
    const bool cut = own.plane[static_cast<std::size_t>(axis)];
    auto& line = axis == 0 ? g.x : g.y;
    line = graded(spec, b, cut ? 0.0 : -0.5 * edge, 0.5 * edge, grading);
  }
  // the face that is struck; of what flies the leading one; the line of flight where that enters through a side
  const double across = flight(spec, b).dot(rotation(b).col(2)), ahead = body == shot_number ? 0.5 : -0.5;
  const double focus = std::abs(across) < 1e-9 ? std::clamp(local[2], -0.5 * b.size[2], 0.5 * b.size[2]) : std::copysign(b.size[2], across) * ahead;
  g.z = through(spec, b, fine, half, smallest_extent(shot), focus, own.plane[2]);
  return g;
}

// ------------------------------------------------------------------------------------------------ all shapes

static fem::HexMesh placed(fem::HexMesh mesh, const io::BodySpec& b) {
  const core::Mat3 r = rotation(b);
  const bool turn = !r.isIdentity(0);
  for (Vec3& x : mesh.x) x = (turn ? Vec3(r * x) : x) + b.center;
  return mesh;
}

/// Meshes of round bodies are inscribed in them, and 1.2 % too light with 20 elements across. In place, widened until the volume is that
/// of the body as given; one that flies (`velocity`, as seen from what is at rest) stands back by what its front gains, so that it touches what it touched.
static fem::HexMesh filled_out(fem::HexMesh mesh, const io::BodySpec& b, core::Symmetry keep, const Vec3& velocity) {
  const bool sphere = b.shape == Shape::sphere;
  const double d = b.diameter, whole = sphere ? core::pi / 6 * d * d * d : core::pi / 4 * d * d * b.length;
  const double lacks = whole / (keep.copies() * fem::quality(mesh).volume), wider = sphere ? std::cbrt(lacks) : std::sqrt(lacks);
  for (Vec3& x : mesh.x) x = x.cwiseProduct(Vec3(wider, wider, sphere ? wider : 1));
  mesh = placed(std::move(mesh), b);
  if (velocity.isZero(0)) return mesh;
  const Vec3 along = velocity.normalized(), own = rotation(b).transpose() * along;
  const double gains = (wider - 1) * 0.5 * d * (sphere ? 1 : std::hypot(own[0], own[1]));
  for (Vec3& x : mesh.x) x -= gains * along;
  return mesh;
}

static PlacedBody place(const io::Case& spec, std::size_t body) {
  const io::BodySpec& b = spec.bodies[body];
  const double size = b.element_size.value_or(projectile_edge(spec));
  const core::Symmetry keep = own_planes(spec, b);
  PlacedBody p;
  p.spec = &b;
  const Vec3 flies = b.velocity - at_rest(spec);
  p.element_size = size;
  switch (b.shape) {
    case Shape::sphere: {
      const int n = elements_along(spec, b, b.diameter, size, 4);
      p.element_size = std::min(size, b.diameter / 4);
      p.count = 0.52 * std::pow(n, 3) / keep.copies();
      p.make = [&b, n, keep, flies] { return filled_out(fem::sphere(b.diameter, n, keep), b, keep, flies); };
      break;
    }
    case Shape::cylinder: {
      const int n = elements_along(spec, b, b.diameter, size, 4);
      int along = elements_along(spec, b, b.length, size, 2);
      for (int axis = 0; axis < 3; ++axis)  // whole as it is where a plane of symmetry cuts it
        if (std::abs(rotation(b)(axis, 2)) > 1 - 1e-12 && b.center[axis] == 0 && b.velocity[axis] == 0) along += along % 2;
      p.element_size = std::min(size, b.diameter / 4);
      p.count = 0.785 * n * n * along / keep.copies();
      p.make = [&b, n, along, keep, flies] { return filled_out(fem::cylinder(b.diameter, b.length, n, along, keep), b, keep, flies); };
      break;
    }
    case Shape::plate:
    case Shape::box: {
      const PlateGrid g = plate_grid(spec, body);
      p.element_size = g.fine;
      p.layer = extent(b).maxCoeff();
      for (std::size_t k = 1; k < g.z.size(); ++k) p.layer = std::min(p.layer, g.z[k] - g.z[k - 1]);
      p.too_coarse = out_of_reach(spec, b) && reached(spec, b, spec.end);
      p.count = static_cast<double>((g.x.size() - 1) * (g.y.size() - 1) * (g.z.size() - 1));
      p.make = [&b, g] { return placed(fem::box(g.x, g.y, g.z), b); };
      break;
    }
    case Shape::mesh: {
      auto deck = io::read_mesh_deck(b.file, 1.0);
      p.count = static_cast<double>(deck.node.size());
      fem::HexMesh mesh{std::move(deck.x), std::move(deck.node)};
      p.make = [&b, mesh] { return placed(mesh, b); };
      break;
    }
  }
  return p;
}

std::vector<PlacedBody> place_bodies(const io::Case& spec) {
  std::vector<PlacedBody> r;
  for (std::size_t b = 0; b < spec.bodies.size(); ++b) r.push_back(place(spec, b));
  return r;
}

// ------------------------------------------------------------------------------------------------ what lies where it must not

/// What a body fills: points over its surface and inside, the box round them, and the elements of one from a file, in place.
struct Filled {
  const io::BodySpec* body = nullptr;
  std::vector<Vec3> points;
  core::Box box;
  fem::HexMesh deck;
  double size = 0;  ///< smallest extent, of a deck its elements' [m]
};

static std::vector<Vec3> samples(const io::BodySpec& b) {
  std::vector<Vec3> r;
  const core::Mat3 turn = rotation(b);
  const Vec3 half = 0.5 * extent(b);
  constexpr int n = 24;
  for (int i = -n; i <= n; ++i)
    for (int j = -n; j <= n; ++j)
      for (int k = -n; k <= n; k += (std::abs(i) == n || std::abs(j) == n) ? 1 : n) {
        Vec3 u(double(i) / n, double(j) / n, double(k) / n);
        if (b.shape == Shape::sphere && !u.isZero()) u *= u.cwiseAbs().maxCoeff() / u.norm();
        if (b.shape == Shape::cylinder && std::hypot(u[0], u[1]) > 0)
          u.head<2>() *= u.head<2>().cwiseAbs().maxCoeff() / u.head<2>().norm();
        r.push_back(b.center + turn * u.cwiseProduct(half));
      }
  return r;
}

static Filled filled(const PlacedBody& placed) {
  const io::BodySpec& b = *placed.spec;
  Filled f;
  f.body = &b;
  f.size = smallest_extent(b);
  if (b.shape == Shape::mesh) {
    f.deck = placed.make();
    f.size = *b.element_size;
    f.points = f.deck.x;
    for (const auto& corners : f.deck.node) {
      Vec3 middle = Vec3::Zero();
      for (const auto nd : corners) middle += 0.125 * f.deck.x[static_cast<std::size_t>(nd)];
      f.points.push_back(middle);
    }
  } else {
    f.points = samples(b);
  }
  for (const Vec3& x : f.points) f.box.add(x);
  return f;
}

/// How far inside an element a point lies, by the planes through the middles of its faces; negative outside.
static double depth_in(const fem::HexMesh& mesh, const std::array<std::int32_t, 8>& corners, const Vec3& x) {
  double depth = 1e300;
  for (const auto& face : fem::face_corner) {
    const auto at = [&](std::size_t k) { return mesh.x[static_cast<std::size_t>(corners[static_cast<std::size_t>(face[k])])]; };
    const Vec3 outward = (at(2) - at(0)).cross(at(3) - at(1)).normalized();
    depth = std::min(depth, outward.dot(0.25 * (at(0) + at(1) + at(2) + at(3)) - x));
  }
  return depth;
}

/// How far points of p lie inside q [m].
static double overlap(const Filled& p, const Filled& q) {
  const core::Box common{p.box.low.cwiseMax(q.box.low), p.box.high.cwiseMin(q.box.high)};
  if ((common.low.array() > common.high.array()).any()) return 0;
  std::vector<Vec3> points;
  for (const Vec3& x : p.points)
    if (common.contains(x)) points.push_back(x);
  double deepest = 0;
  if (q.body->shape != Shape::mesh) {
    for (const Vec3& x : points) deepest = std::max(deepest, -distance(*q.body, x));
    return deepest;
  }
  for (const auto& corners : q.deck.node) {
    core::Box box;
    for (const auto nd : corners) box.add(q.deck.x[static_cast<std::size_t>(nd)]);
    if (!box.touches(common)) continue;
    for (const Vec3& x : points)
      if (box.contains(x)) deepest = std::max(deepest, depth_in(q.deck, corners, x));
  }
  return deepest;
}

/// How far two boxes would have to be moved to part, 0 where they are apart (separating axes): thin plates that cross may have no
/// point of one's samples in the other.
static double boxes_overlap(const io::BodySpec& p, const io::BodySpec& q) {
  if (!is_box(p) || !is_box(q)) return 0;
  const core::Mat3 a = rotation(p), b = rotation(q);
  const Vec3 apart = q.center - p.center;
  double least = 1e300;
  const auto part = [&](const Vec3& axis) {
    const double length = axis.norm();
    if (length < 1e-6) return;
    const double reach = 0.5 * ((a.transpose() * axis).cwiseAbs().dot(extent(p)) + (b.transpose() * axis).cwiseAbs().dot(extent(q)));
    least = std::min(least, (reach - std::abs(apart.dot(axis))) / length);
  };
  for (int i = 0; i < 3; ++i) {
    part(a.col(i));
    part(b.col(i));
    for (int j = 0; j < 3; ++j) part(a.col(i).cross(b.col(j)));
  }
  return std::max(least, 0.0);
}

void check_places(const io::Case& spec, const std::vector<PlacedBody>& placed) {
  std::vector<Filled> all;
  for (const auto& b : placed) all.push_back(filled(b));
  constexpr double whole = 1e-6, faceted = 0.02;  // of the smaller size: curved bodies that touch are facets in a deck
  for (std::size_t a = 0; a < all.size(); ++a)
    for (std::size_t b = a + 1; b < all.size(); ++b) {
      const Filled &p = all[a], &q = all[b];
      const bool decks = p.body->shape == Shape::mesh || q.body->shape == Shape::mesh;
      const double depth = std::max({overlap(p, q), overlap(q, p), boxes_overlap(*p.body, *q.body)});
      if (depth > (decks ? faceted : whole) * std::min(p.size, q.size))
        throw core::CaseError(fmt::format(
            "{}: bodies \"{}\" and \"{}\" overlap by {:.4g} mm: move one of them (body.{}.center) so that they at most touch",
            spec.file, p.body->name, q.body->name, depth * 1e3, q.body->name));
    }
  for (std::size_t w = 0; w < spec.walls.size(); ++w)
    for (std::size_t o = 0; o < w; ++o) {
      const double cosine = std::abs(spec.walls[w].normal.normalized().dot(spec.walls[o].normal.normalized()));
      constexpr double square = 1e-9;
      if (cosine > square && cosine < 1 - square)
        throw core::CaseError(fmt::format("{}: wall.{} stands at {:.4g} deg to wall.{}: images in the two would not be each other's; walls stand at right angles or are parallel",
                                          spec.file, w, std::acos(cosine) * 180 / core::pi, o));
    }
  for (std::size_t w = 0; w < spec.walls.size(); ++w)
    for (const Filled& f : all) {
      const Vec3 n = spec.walls[w].normal.normalized();
      double lowest = 1e300;
      for (const Vec3& x : f.points) lowest = std::min(lowest, n.dot(x - spec.walls[w].point));
      if (lowest < -whole * f.size)
        throw core::CaseError(fmt::format(
            "{}: body \"{}\" reaches {:.4g} mm behind wall.{}: matter is on the side that the wall's normal points to; move the body "
            "(body.{}.center) or the wall (wall.{}.point), or turn its normal", spec.file, f.body->name, -lowest * 1e3, w, f.body->name, w));
    }
}

}  // namespace app
