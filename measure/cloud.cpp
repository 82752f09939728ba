// SPDX-License-Identifier: Apache-2.0
// Debris clouds. Axial means along the projectile's line of flight (direction d, through the point of aim), radial across
// it; the angle of a velocity is atan2(radial, axial). A percentile is the smallest value that at least that part of the
// weight (mass, or magnitude of momentum) does not exceed. Keys follow docs/measurements.md.
// Half-angle to the outermost projectile material: Campbell & Vignjevic, Int. J. Impact Engng 20 (1997) 143.
#include <algorithm>
#include <cmath>
#include <optional>

#include "measure/families.hpp"

namespace measure {
namespace {

using core::Vec3;
using Rows = std::vector<std::uint32_t>;

constexpr double spray_part = 0.90, nearly_all = 0.99, nearly_none = 0.01;
constexpr double fast_speed = 0.5;  // of the impact speed

/// The smallest value that `part` of the weight does not exceed.
std::optional<double> percentile(std::vector<std::pair<double, double>> value_weight, double part) {
  std::sort(value_weight.begin(), value_weight.end());
  double total = 0, sum = 0;
  for (const auto& [value, weight] : value_weight) total += weight;
  if (value_weight.empty() || total <= 0) return std::nullopt;
  for (const auto& [value, weight] : value_weight)
    if ((sum += weight) >= part * total * (1 - 1e-12)) return value;
  return value_weight.back().first;
}

/// Positions and velocities relative to the line of flight.
class Flight {
 public:
  Flight(const Whole& whole, const Scene& scene) : whole_(whole), aim_(scene.aim) {}
  double axial_velocity(std::uint32_t row) const { return whole_.matter.v[row].dot(whole_.flight); }
  double radial_velocity(std::uint32_t row) const { return across(whole_.matter.v[row]); }
  double angle(std::uint32_t row) const { return std::atan2(radial_velocity(row), axial_velocity(row)); }
  double axial_position(std::uint32_t row) const { return (whole_.matter.x[row] - aim_).dot(whole_.flight); }
  double radius(std::uint32_t row) const { return across(whole_.matter.x[row] - aim_); }

 private:
  double across(const Vec3& a) const { return (a - a.dot(whole_.flight) * whole_.flight).norm(); }
  const Whole& whole_;
  Vec3 aim_;
};

/// Percentile over rows; value(row) and weight(row).
template <class Value, class Weight>
std::optional<double> percentile_of(const Rows& rows, double part, Value value, Weight weight) {
  std::vector<std::pair<double, double>> pairs;
  pairs.reserve(rows.size());
  for (const std::uint32_t row : rows) pairs.emplace_back(value(row), weight(row));
  return percentile(std::move(pairs), part);
}

template <class Keep>
Rows rows_where(const Rows& rows, Keep keep) {
  Rows result;
  std::copy_if(rows.begin(), rows.end(), std::back_inserter(result), keep);
  return result;
}

/// Part of a phase change that is done at specific energy e.
double progress(double e, double begins, double complete) {
  if (e < begins || begins >= 1e300) return 0;
  return complete > begins ? std::min(1.0, (e - begins) / (complete - begins)) : 1.0;
}

class Cloud {
  double m(std::uint32_t row) const { return whole_.matter.m[row]; }
  auto mass() const {
    return [this](std::uint32_t row) { return m(row); };
  }

 public:
  Cloud(const Whole& whole, const Scene& scene, std::size_t plate, Result& result)
      : whole_(whole), scene_(scene), flight_(whole, scene), frame_(plate_frame(scene, scene.plates[plate])),
        rows_(cloud_rows(whole, scene, plate)),
        prefix_(plate == 0 ? "cloud." : scene.bodies[scene.plates[plate]].name + ".cloud."), result_(result) {}

  void totals() {
    double mass = 0, momentum = 0, energy = 0;
    for (const std::uint32_t row : rows_) {
      mass += m(row);
      momentum += m(row) * flight_.axial_velocity(row);
      energy += 0.5 * m(row) * whole_.matter.v[row].squaredNorm();
    }
    put("mass", mass, "kg");
    put("momentum", momentum, "N s");
    put("kinetic_energy", energy, "J");
  }

  void angles() {
    const auto angle = [&](std::uint32_t row) { return flight_.angle(row); };
    put("spray_half_angle", percentile_of(rows_, spray_part, angle, [&](std::uint32_t row) {
          return m(row) * whole_.matter.v[row].norm();
        }), "rad");
    const Rows fast = rows_where(rows_, [&](std::uint32_t row) {
      return flight_.axial_velocity(row) > fast_speed * whole_.impact_speed;
    });
    put("fast_half_angle", percentile_of(fast, nearly_all, angle, mass()), "rad");
    const auto outermost = std::max_element(rows_.begin(), rows_.end(), [&](std::uint32_t i, std::uint32_t j) {
      return projectile_radius(i) < projectile_radius(j);
    });
    if (outermost != rows_.end() && projectile_radius(*outermost) >= 0)
      put("half_angle_outer_projectile", angle(*outermost), "rad");
    envelope();
  }

  void velocities() {
    const auto axial = [&](std::uint32_t row) { return flight_.axial_velocity(row); };
    const auto radial = [&](std::uint32_t row) { return flight_.radial_velocity(row); };
    put("axial_velocity_front", percentile_of(rows_, nearly_all, axial, mass()), "m/s");
    put("axial_velocity_rear", percentile_of(rows_, nearly_none, axial, mass()), "m/s");
    put("radial_velocity_max", percentile_of(rows_, nearly_all, radial, mass()), "m/s");
  }

  void shape() {
    const auto axial = [&](std::uint32_t row) { return flight_.axial_position(row); };
    const auto front = percentile_of(rows_, nearly_all, axial, mass());
    const auto rear = percentile_of(rows_, nearly_none, axial, mass());
    const auto radius =
        percentile_of(rows_, nearly_all, [&](std::uint32_t row) { return flight_.radius(row); }, mass());
    if (!front || !rear || !radius) return;
    put("length", *front - *rear, "m");
    put("width", 2 * *radius, "m");
  }

  void phases() {
    double all = 0, melted = 0, vapour = 0, projectile = 0, projectile_melted = 0;
    bool melts = true, boils = true, projectile_melts = true;  // where the energies of it are known
    for (const std::uint32_t row : rows_) {
      const BodyScene& body = scene_.bodies[whole_.matter.body[row]];
      const double e = whole_.matter.e[row], melt = m(row) * progress(e, body.e_melt, body.e_melted);
      all += m(row);
      melted += melt;
      melts = melts && body.e_melt < 1e300, boils = boils && body.e_vapour < 1e300;
      vapour += m(row) * progress(e, body.e_vapour, body.e_vaporised);
      if (!body.is_projectile) continue;
      projectile += m(row);
      projectile_melted += melt;
      projectile_melts = projectile_melts && body.e_melt < 1e300;
    }
    if (all > 0 && melts) put("melt_fraction", melted / all, "");
    if (all > 0 && boils) put("vapour_fraction", vapour / all, "");
    if (projectile > 0 && projectile_melts) put("projectile_melt_fraction", projectile_melted / projectile, "");
  }

 private:
  double projectile_radius(std::uint32_t row) const {
    return scene_.bodies[whole_.matter.body[row]].is_projectile ? flight_.radius(row) : -1;
  }

  /// Cone with its tip where the line of flight meets the plate's mid-plane, over debris that left the plate well behind.
  void envelope() {
    const Vec3 normal = frame_.axes.row(2).transpose();
    const double closing = whole_.flight.dot(normal);
    if (closing == 0) return;
    const double tip = (frame_.origin - scene_.aim).dot(normal) / closing;
    const double least = -(frame_.half.z() + scene_.projectile_size);
    const Rows far = rows_where(rows_, [&](std::uint32_t row) {
      return frame_.local(whole_.matter.x[row]).z() < least && flight_.axial_position(row) > tip;
    });
    const auto angle = [&](std::uint32_t row) {
      return std::atan2(flight_.radius(row), flight_.axial_position(row) - tip);
    };
    put("envelope_half_angle", percentile_of(far, nearly_all, angle, mass()), "rad");
  }

  void put(const char* key, std::optional<double> value, const char* unit) {
    if (value) add(result_, prefix_ + key, *value, unit);
  }

  const Whole& whole_;
  const Scene& scene_;
  Flight flight_;
  PlateFrame frame_;
  Rows rows_;
  std::string prefix_;
  Result& result_;
};

}  // namespace

namespace {

/// Nothing passes through a plate's material, so what crossed its mid-plane within its edges went through an opening, and
/// what crossed it outside flew round. Behind a plate debris flies straight, so its velocity tells where it crossed.
bool came_through(const PlateFrame& frame, const Vec3& local_x, const Vec3& local_v) {
  const bool recedes = local_v.z() < 0;
  return frame.rim(recedes ? Vec3(local_x - local_x.z() / local_v.z() * local_v) : local_x) <= 1;
}

/// Where the plate's held material lies, seen from behind: matter above it has not come through.
class Underside {
 public:
  Underside(const Whole& whole, const PlateFrame& frame, int body) {
    Surface upside_down = surface_of(whole, frame, body, whole.held);
    const Window window = disturbed_window(upside_down, frame);
    if (!window.exists) return;
    for (Quad& q : upside_down.quads)
      for (Vec3& x : q.x) x.z() = -x.z();
    for (Sphere& s : upside_down.spheres) s.x.z() = -s.x.z();
    columns_ = columns_over(window, window.size);
    depth_ = front_heights(upside_down, columns_);
  }
  /// True for a point with held material farther back.
  bool is_above(const Vec3& local_x) const {
    const auto cell = [&](int axis) { return static_cast<int>(std::floor((local_x[axis] - columns_.low[axis]) / columns_.h)); };
    const int i = cell(0), j = cell(1);
    if (depth_.empty() || i < 0 || j < 0 || i >= columns_.n[0] || j >= columns_.n[1]) return false;
    return depth_[columns_.index(i, j)] > -local_x.z();
  }

 private:
  Columns columns_;
  std::vector<double> depth_;
};

}  // namespace

/// Does the line of flight of a body, as seen from a plate, pass the plate with all of the body beyond its edges?
static bool flies_round(const Scene& scene, int plate, int body) {
  const BodyScene &p = scene.bodies[plate], &b = scene.bodies[body];
  const PlateFrame frame = plate_frame(scene, plate);
  const Vec3 x = frame.axes * (b.center - p.center), v = frame.axes * (b.velocity - p.velocity);
  if (v.z() >= 0) return false;
  const Vec3 beyond = (x - x.z() / v.z() * v).cwiseAbs() - frame.half;
  return std::max(beyond.x(), beyond.y()) > 0.5 * b.extent.norm();
}

static bool stands_before(const Scene& scene, std::size_t plate_index, int body) {
  const auto found = std::find(scene.plates.begin(), scene.plates.end(), body);
  if (found != scene.plates.end()) return static_cast<std::size_t>(found - scene.plates.begin()) <= plate_index;
  if (body == scene.projectile) return true;
  const BodyScene& plate = scene.bodies[scene.plates[plate_index]];
  const double side = plate.normal.dot(scene.impact_velocity) > 0 ? -1 : 1;
  return side * plate.normal.dot(scene.bodies[body].center - plate.center) > 0 && !flies_round(scene, scene.plates[plate_index], body);
}

std::vector<std::uint8_t> built_before(const Scene& scene, std::size_t plate_index) {
  std::vector<std::uint8_t> before;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) before.push_back(stands_before(scene, plate_index, static_cast<int>(b)));
  return before;
}

std::vector<std::uint32_t> cloud_rows(const Whole& whole, const Scene& scene, std::size_t plate_index) {
  const int plate = scene.plates[plate_index];
  const PlateFrame frame = plate_frame(scene, plate);
  std::optional<Underside> underside;  // only where debris may lie in a dish
  std::optional<bool> perforated;      // only where it does not lie still there: it may push a wall that holds
  const auto lies_in_dish = [&](std::uint32_t row, const Vec3& x) {
    if (!underside) underside.emplace(whole, frame, plate);
    if (!underside->is_above(x)) return false;
    if ((whole.matter.v[row] - whole.rims[plate].velocity).norm() <= loose_speed * whole.impact_speed) return true;
    if (!perforated) perforated = make_plate(whole, scene, plate).opening.through;
    return !*perforated;
  };
  const auto before = built_before(scene, plate_index);
  Rows rows;
  for (std::uint32_t row = 0; row < whole.size(); ++row) {
    const Vec3 v = whole.matter.v[row] - scene.bodies[plate].velocity;
    if (!whole.debris[row] || v.dot(whole.flight) <= 0) continue;
    const Vec3 x = frame.local(whole.matter.x[row]);
    if (x.z() >= -frame.half.z()) continue;
    const int body = whole.matter.body[row];
    if (!before[body]) continue;
    if (body != plate && (!came_through(frame, x, frame.axes * v) || lies_in_dish(row, x))) continue;
    rows.push_back(row);
  }
  return rows;
}

void measure_cloud_behind(const Whole& whole, const Scene& scene, std::size_t plate_index, Result& result) {
  Cloud cloud(whole, scene, plate_index, result);
  cloud.totals();
  cloud.angles();
  cloud.velocities();
  cloud.shape();
  cloud.phases();
}

void measure_debris_behind(const Whole& whole, const Scene& scene, std::size_t plate_index, Result& result) {
  double mass = 0;
  for (const std::uint32_t row : cloud_rows(whole, scene, plate_index)) mass += whole.matter.m[row];
  add(result, scene.bodies[scene.plates[plate_index]].name + ".debris_mass_behind", mass, "kg");
}

void measure_ejecta(const Whole& whole, const Scene& scene, Result& result) {
  const PlateFrame frame = plate_frame(scene, scene.plates.front());
  const Vec3 normal = frame.axes.row(2).transpose();
  double mass = 0, momentum = 0;
  for (std::size_t row = 0; row < whole.size(); ++row) {
    const Vec3& v = whole.matter.v[row];
    if (!whole.debris[row] || v.dot(normal) <= 0 || frame.local(whole.matter.x[row]).z() <= frame.half.z()) continue;
    mass += whole.matter.m[row];
    momentum -= whole.matter.m[row] * v.dot(whole.flight);
  }
  add(result, "ejecta.mass", mass, "kg");
  add(result, "ejecta.momentum", momentum, "N s");
}

}  // namespace measure
