// SPDX-License-Identifier: Apache-2.0
// Plane shocks in hexes: elastic-plastic piston and symmetric flyer plates against the jump conditions; spall.
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "eos/hugoniot.hpp"
#include "eos/wide_range.hpp"
#include "io/material_file.hpp"
#include "tests/verification/rig.hpp"

namespace {

using namespace rig;

/// Elements of body 0 in the order of z.
std::vector<std::size_t> along_z(const app::Simulation& s) {
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t el = s.mesh.body_elements[0].first; el < s.mesh.body_elements[0].last; ++el)
    if (s.mesh.elements.alive[el]) order.push_back({fem::centre(s.mesh, el, s.mesh.nodes.x)[2], el});
  std::sort(order.begin(), order.end());
  std::vector<std::size_t> rows;
  for (const auto& o : order) rows.push_back(o.second);
  return rows;
}

TEST(ElasticPlasticPiston, WavesAndStates) {
  // Jump conditions of a hypoelastic, perfectly plastic solid: reference, README section 8 (derived there): G 28.6
  // GPa, Y 0.26 GPa, rho_0 2790, c_0 5330, s 1.34, gamma 2, piston 100 m/s. Here the body runs into a wall at rest.
  const double up = 100, L = 0.01;
  const int n = 400;
  auto m = mie_grueneisen(2790, 5330, 1.34, 2);
  m.strength = material::PerfectlyPlastic{28.6e9, 0.26e9};
  Rig r;
  r.add(fem::box(line(0, L / n, 1), line(0, L / n, 1), line(0, L, n)), m,
        [&](const Vec3& x) { return Vec3(0, 0, x[2] == 0 ? 0 : -up); });
  r.fix(3, [](const Vec3&) { return true; });
  r.fix(4, [](const Vec3& x) { return x[2] == 0; });
  r.begin();
  const double hel = 0.53799e9, p2 = 1.44556e9, s2 = p2 + 2.0 / 3.0 * 0.26e9;

  // Front positions (half the jump in stress, interpolated) at two times give the speeds.
  const auto front = [&](double level) {
    const auto rows = along_z(*r.s);
    const auto& pt = r.s->mesh.elements.pt;
    for (std::size_t k = rows.size() - 1; k > 0; --k) {
      const auto stress = [&](std::size_t i) { return pt.p[rows[i]] - pt.s[core::zz][rows[i]]; };
      if (stress(k - 1) < level) continue;
      const auto z = [&](std::size_t i) { return fem::centre(r.s->mesh, rows[i], r.s->mesh.nodes.x)[2]; };
      return z(k) + (z(k - 1) - z(k)) * (level - stress(k)) / (stress(k - 1) - stress(k));
    }
    return 0.0;
  };
  const double t1 = 0.7e-6, t2 = 1.4e-6;
  r.run(t1);
  const double elastic_1 = front(0.5 * hel), plastic_1 = front(0.5 * (hel + s2));
  r.run(t2);
  const double elastic_speed = (front(0.5 * hel) - elastic_1) / (t2 - t1) + up;
  const double plastic_speed = (front(0.5 * (hel + s2)) - plastic_1) / (t2 - t1) + up;

  const auto mean = [&](double from, double to, auto&& value) {
    double sum = 0;
    int count = 0;
    for (const auto el : along_z(*r.s)) {
      const double z = fem::centre(r.s->mesh, el, r.s->mesh.nodes.x)[2];
      if (z < from || z > to) continue;
      sum += value(el);
      ++count;
    }
    return sum / count;
  };
  const auto& pt = r.s->mesh.elements.pt;
  const double behind = (5505.5 - up) * t2, ahead = (6520.7 - up) * t2, gap = ahead - behind;
  const double hel_measured = mean(behind + 0.3 * gap, ahead - 0.3 * gap, [&](std::size_t k) { return pt.p[k] - pt.s[core::zz][k]; });
  const double p_measured = mean(0.3 * behind, 0.8 * behind, [&](std::size_t k) { return pt.p[k]; });
  const double rho_measured = mean(0.3 * behind, 0.8 * behind, [&](std::size_t k) { return pt.rho[k]; });
  // Fronts are spread over a few of 360 elements, states by the plateau's small oscillation.
  EXPECT_LT(std::abs(report("HEL stress, Pa", hel_measured, hel)), 0.01);
  EXPECT_LT(std::abs(report("elastic wave, m/s", elastic_speed, 6520.7)), 0.005);
  EXPECT_LT(std::abs(report("plastic wave, m/s", plastic_speed, 5505.5)), 0.005);
  EXPECT_LT(std::abs(report("pressure behind, Pa", p_measured, p2)), 0.005);
  EXPECT_LT(std::abs(report("density behind, kg/m3", rho_measured, 2839.23)), 0.001);
  EXPECT_LT(std::abs(r.s->ledger.energy_error), 1e-9);
}

struct Flyer {
  double speed, p, rho;  ///< [m/s] [Pa] [kg/m3]
};

struct Result {
  double p, rho, peak;
};

/// A flyer comes down at `speed` on a target with its face at z = 0; columns of elements dx thick in uniaxial strain, 0.05 dx apart.
void add_plates(Rig& r, const material::Material& m, double speed, double dx, int n_target, int n_flyer) {
  const double gap = 0.05 * dx;
  r.add(fem::box(line(0, dx, 1), line(0, dx, 1), line(-n_target * dx, 0, n_target)), m, [](const Vec3&) { return Vec3(0, 0, 0); });
  r.add(fem::box(line(0, dx, 1), line(0, dx, 1), line(gap, n_flyer * dx + gap, n_flyer)), m, [&](const Vec3&) { return Vec3(0, 0, -speed); });
  r.fix(3, [](const Vec3&) { return true; });
  r.begin();
}

/// Two plates of n elements meet at `speed`; plateau means, away from the interface and the front.
Result flyer(const material::Material& m, const Flyer& f, int n) {
  const double dx = 1e-4, L = n * dx, gap = 0.05 * dx;
  Rig r;
  add_plates(r, m, f.speed, dx, n, n);
  const double Us = f.p / (m.rho_0 * 0.5 * f.speed);
  r.run(0.7 * L / Us + gap / f.speed);
  const auto rows = along_z(*r.s);
  const auto& pt = r.s->mesh.elements.pt;
  Result out{0, 0, 0};
  int count = 0;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    out.peak = std::max(out.peak, pt.p_max[rows[k]]);
    const double from_interface = static_cast<double>(n) - static_cast<double>(k);
    if (from_interface < 0.15 * n || from_interface > 0.45 * n) continue;
    out.p += pt.p[rows[k]];
    out.rho += pt.rho[rows[k]];
    ++count;
  }
  out.p /= count;
  out.rho /= count;
  EXPECT_LT(std::abs(r.s->ledger.energy_error), 1e-9);
  EXPECT_EQ(r.s->contact.leaks, 0u);
  return out;
}

void check_flyers(const material::Material& m, const std::vector<Flyer>& shots, double overshoot = 0.05) {
  for (const auto& f : shots) {
    const Result r = flyer(m, f, 100);
    std::printf(" %g m/s\n", f.speed);
    const std::string at = " at " + std::to_string(static_cast<int>(f.speed)) + " m/s";
    // 1 % is the goal of the project; 100 elements leave the plateau flat to far less.
    EXPECT_LT(std::abs(report("pressure, Pa" + at, r.p, f.p)), 0.01);
    EXPECT_LT(std::abs(report("density, kg/m3" + at, r.rho, f.rho)), 0.01);
    EXPECT_LT(report("peak pressure, Pa" + at, r.peak, f.p), overshoot);
  }
}

/// Symmetric impact from 2 to 16 km/s against the jump conditions with the model's own p(rho, e).
void check_fast_flyers(const material::Material& m) {
  std::vector<Flyer> shots;
  for (const double speed : {2000.0, 4000.0, 8000.0, 12000.0, 16000.0}) {
    const auto h = eos::hugoniot(m.eos, m.rho_0, 0.5 * speed);
    shots.push_back({speed, h.p, h.rho});
  }
  check_flyers(m, shots, 0.06);  // the start overshoots more the stronger the shock
}

TEST(FastFlyer, MieGrueneisen) { check_fast_flyers(mie_grueneisen(2700, 5350, 1.34, 2.1, 0.48)); }

TEST(FastFlyer, Tillotson) {
  material::Material m;
  m.name = "test", m.rho_0 = 2700;
  m.eos = eos::Tillotson{.rho_0 = 2700, .a = 0.5, .b = 1.63, .A = 75.2e9, .B = 65e9, .alpha = 5, .beta = 5, .E_0 = 5e6, .E_iv = 3e6,
                         .E_cv = 13.9e6, .cv = 884};
  eos::prepare(m.eos);
  check_fast_flyers(m);
}

TEST(FastFlyer, Sesame) {
  const auto file = std::filesystem::temp_directory_path() / ("shock_test_" + std::to_string(::getpid()) + ".ses");
  const auto table = eos::WideRange(eos::find_metal("Al")).table();
  std::ofstream(file) << eos::sesame_text(table);
  eos::Sesame s;
  s.file = file.string(), s.number = table.number;
  material::Material m;
  m.name = "test";
  m.eos = s;
  eos::prepare(m.eos);
  std::filesystem::remove(file);
  m.rho_0 = std::get<eos::Sesame>(m.eos).rho_0;
  check_fast_flyers(m);
}

// Rankine-Hugoniot with Us = c_0 + s up: reference/csv/verif_symmetric_flyer.csv (derived).
TEST(SymmetricFlyer, Aluminium2024) {
  check_flyers(mie_grueneisen(2785, 5328, 1.338, 2.0, 0.48), {{500, 3.9425e9, 2913.6},
                                                              {1000, 8.3508e9, 3038.3},
                                                              {2000, 18.5648e9, 3276.5},
                                                              {4000, 44.5823e9, 3712.7},
                                                              {8000, 118.9752e9, 4452.7},
                                                              {10000, 167.3507e9, 4769.2}});
}

TEST(SymmetricFlyer, Copper) {
  check_flyers(mie_grueneisen(8930, 3940, 1.489, 2.02, 0.47), {{500, 9.6271e9, 9479.6},
                                                               {1000, 20.9163e9, 9997.0},
                                                               {2000, 48.4810e9, 10946.3},
                                                               {4000, 123.5555e9, 12561.6},
                                                               {8000, 353.4851e9, 14988.3},
                                                               {10000, 508.3403e9, 15923.0}});
}

struct Spall {
  double pull_back;                ///< fall of the rear face's velocity after its first plateau [m/s]
  double plane;                    ///< mean distance of torn elements from the rear face [m]
  int torn;                        ///< elements
};

/// A flyer of thickness H strikes a target of 2 H; tension appears H in front of the target's rear face.
Spall spall(const material::Material& m, double speed, double H, int n) {
  const double dx = H / n;
  Rig r;
  add_plates(r, m, speed, dx, 2 * n, n);
  const auto& mesh = r.s->mesh;
  std::size_t rear = 0;
  for (std::size_t nd = 0; nd < mesh.nodes.size(); ++nd)
    if (mesh.nodes.x[nd][2] < mesh.nodes.x[rear][2]) rear = nd;
  double plateau = 0, lowest = 1e9;
  const double transit = H / 5328;
  while (r.s->time < 9 * transit) {
    app::choose_step(*r.s, 1);
    app::step(*r.s);
    const double u = -mesh.nodes.v[rear][2];
    if (r.s->time < 3 * transit)  // the shock comes at 1.9, the release at 3.7
      plateau = u;
    else if (r.s->time < 4.5 * transit)
      lowest = std::min(lowest, u);
  }
  Spall out{plateau - lowest, 0, 0};
  const auto rows = along_z(*r.s);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    if (mesh.elements.pt.damage[rows[k]] < 1) continue;
    ++out.torn;
    out.plane += (static_cast<double>(k) + 0.5) * dx;
  }
  if (out.torn) out.plane /= out.torn;
  EXPECT_LT(std::abs(r.s->ledger.energy_error), 1e-9);
  return out;
}

// Novikov, Divnov & Ivanov, Phys. Met. Metallogr. 21 (1966) 608: limit = rho_0 c_0 (pull-back) / 2. The plane lies where the two
// releases meet, a flyer's thickness from the rear face; one opens, and what it unloads stays whole. Were tension lost at once,
// four to eight elements would go and the pull-back would read 37 to 49 % short.
TEST(SpallOfAPlate, PullBackAndPlane) {
  auto m = mie_grueneisen(2785, 5328, 1.338, 2.0, 0.48);
  m.strength = material::PerfectlyPlastic{1e9, 1e6};
  m.spall = 1.2e9;
  m.fracture_energy = 8200;
  for (const int n : {25, 50, 100}) {
    const Spall at = spall(m, 400, 1e-3, n);
    std::printf("  %d elements a flyer\n", n);
    EXPECT_LT(std::abs(report("pull-back, m/s", at.pull_back, 2 * 1.2e9 / (2785 * 5328.0))), 0.03);
    EXPECT_LT(std::abs(report("plane, mm from the rear face", 1e3 * at.plane, 1)), 0.03);
    note("elements torn through", at.torn);
    EXPECT_GE(at.torn, 1);
    EXPECT_LE(at.torn, 2);
  }
}

// The library's alloys as they stand, damage by plastic strain included: their pull-back gives the limit that plate impact tests
// give (ranges commonly quoted). 6061-T6 gave 0.39 GPa and tore in eight elements when its fit of fracture strains was carried
// on to where it is negative.
TEST(SpallOfAPlate, AlloysBearWhatTestsGive) {
  struct {
    const char* name;
    double low, high;  // [GPa]
  } const measured[] = {{"Al6061-T6", 1.2, 1.5}, {"Al2024-T351", 1.2, 1.6}, {"Al1100-O", 0.6, 1.0}};
  for (const auto& at : measured) {
    const material::Material m = io::find_material(at.name);
    for (const int n : {25, 50}) {
      const Spall out = spall(m, 400, 1e-3, n);
      const double limit = 0.5e-9 * m.rho_0 * 5328 * out.pull_back;
      report(at.name, limit, m.spall * 1e-9);
      EXPECT_GT(limit, at.low);
      EXPECT_LT(limit, at.high);
      EXPECT_NEAR(out.plane, 1e-3, 0.08e-3);
      EXPECT_GE(out.torn, 1);
      EXPECT_LE(out.torn, 3);
    }
  }
}

}  // namespace
