// SPDX-License-Identifier: Apache-2.0
// Elastic waves in hexes: speeds, shapes and observed order. Aluminium-like: rho 2700, K 76 GPa, G 27 GPa.
#include "tests/verification/rig.hpp"

namespace {

using namespace rig;

constexpr double rho = 2700, K = 76e9, G = 27e9;

void no_viscosity(app::Simulation& s) { s.element_settings.viscosity_linear = s.element_settings.viscosity_quadratic = 0; }

/// A Gaussian velocity pulse splits into two halves (d'Alembert). Returns the relative L2 error of the velocity after the
/// pulses have travelled 0.3 of the bar; `peak` and `speed` are those of the right-going pulse.
double uniaxial_pulse(int n, bool viscous, double* peak, double* speed) {
  const double L = 1, c = std::sqrt((K + 4 * G / 3) / rho), V = 0.1, width = 0.05;
  const auto shape = [&](double z) { return V * std::exp(-(z / width) * (z / width)); };
  Rig r;
  if (!viscous) no_viscosity(*r.s);
  const double dx = L / n;
  r.add(fem::box(line(0, dx, 1), line(0, dx, 1), line(-L / 2, L / 2, n)), elastic(rho, K, G),
        [&](const Vec3& x) { return Vec3(0, 0, shape(x[2])); });
  r.fix(3, [](const Vec3&) { return true; });
  r.begin();
  r.run(0.3 * L / c);
  const auto& nodes = r.s->mesh.nodes;
  const double t = r.s->time - 0.5 * r.s->dt_old;  // of the velocities
  double error = 0, size = 0, sum = 0, first = 0;
  *peak = 0;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const double z = nodes.x[i][2], exact = 0.5 * (shape(z - c * t) + shape(z + c * t)), v = nodes.v[i][2];
    error += (v - exact) * (v - exact);
    size += exact * exact;
    if (z > 0) {
      *peak = std::max(*peak, v);
      sum += v;
      first += v * z;
    }
  }
  *peak /= 0.5 * V;
  *speed = first / sum / t;
  return std::sqrt(error / size);
}

TEST(ElasticWave, UniaxialStrainPulse) {
  double peak, speed;
  const double e1 = uniaxial_pulse(100, false, &peak, &speed), e2 = uniaxial_pulse(200, false, &peak, &speed),
               e3 = uniaxial_pulse(400, false, &peak, &speed);
  const double c = std::sqrt((K + 4 * G / 3) / rho);
  const double speed_error = report("uniaxial speed, 400 elements, m/s", speed, c);
  const double peak_error = report("amplitude of the half pulse", peak, 1);
  observed_order("L2 error of velocity, 100 to 200", e1, e2);
  const double order = observed_order("L2 error of velocity, 200 to 400", e2, e3);
  // Dispersion of central differences at 20 elements to the pulse's half-width: (k dx)^2/24 of the phase, below 0.1 %.
  EXPECT_LT(std::abs(speed_error), 1e-3);
  EXPECT_LT(std::abs(peak_error), 5e-3);
  EXPECT_LT(e3, 0.01);
  EXPECT_GT(order, 1.8);  // both the mean gradient and central differences are of second order
}

TEST(ElasticWave, DefaultViscosityDampsAPulseLittle) {
  double peak, speed;
  uniaxial_pulse(200, true, &peak, &speed);
  const double error = report("amplitude with default viscosity, 200 elements", peak, 1);
  // First order: linear viscosity C_l = 0.2 diffuses with 0.2 dx c / 2 (it acts in compression only); over 0.3 m a Gaussian of
  // 10 elements' half-width loses 1 - 1/sqrt(1 + 4 D t / w^2) = 1 - 1/sqrt(1 + 0.06) = 6 % at the most.
  EXPECT_LT(std::abs(error), 0.08);
}

/// Quarter period of a standing wave of half a wavelength, from where the mode's velocity crosses zero: the wave speed.
double standing_speed(Rig& r, double L, double guess, const std::function<double(const Vec3&, const Vec3&)>& mode) {
  auto& s = *r.s;
  const auto x_0 = s.mesh.nodes.x;
  double last_value = 0, last_time = 0;
  while (true) {
    app::choose_step(s, 1e300);
    app::step(s);
    double sum = 0;
    for (std::size_t i = 0; i < x_0.size(); ++i) sum += s.mesh.nodes.m[i] * mode(x_0[i], s.mesh.nodes.v[i]);
    const double t = s.time - 0.5 * s.dt_old;
    if (sum <= 0) {
      const double zero = last_time + (t - last_time) * last_value / (last_value - sum);
      return 0.5 * L / zero;
    }
    if (t > 2 * L / guess) return 0;
    last_value = sum;
    last_time = t;
  }
}

double bar_speed(int n) {
  // Free bar of square section, aspect 80; the lateral velocities of the mode are given too, so that nothing else rings.
  const double L = 1, a = L / 80, k = core::pi / L, V = 0.1, E = 9 * K * G / (3 * K + G), nu = (3 * K - 2 * G) / (6 * K + 2 * G);
  Rig r;
  no_viscosity(*r.s);
  r.add(fem::box(line(0, a / 2, 1), line(0, a / 2, 1), line(0, L, n)), elastic(rho, K, G), [&](const Vec3& x) {
    const double lateral = nu * V * k * std::sin(k * x[2]);
    return Vec3(lateral * x[0], lateral * x[1], V * std::cos(k * x[2]));
  });
  r.fix(1, [](const Vec3& x) { return x[0] == 0; });
  r.fix(2, [](const Vec3& x) { return x[1] == 0; });
  r.begin();
  return standing_speed(r, L, std::sqrt(E / rho), [&](const Vec3& x, const Vec3& v) { return v[2] * std::cos(k * x[2]); });
}

TEST(ElasticWave, BarSpeed) {
  const double E = 9 * K * G / (3 * K + G), exact = std::sqrt(E / rho);
  const double error = report("bar speed, 40 elements, m/s", bar_speed(40), exact);
  // Love's correction for lateral inertia, nu^2 k^2 (a^2/6) / 2, is 1.5e-5 here; the mesh has (k dx)^2/24 = 3e-4.
  EXPECT_LT(std::abs(error), 2e-3);
}

double shear_speed(int n) {
  const double L = 1, k = core::pi / L, V = 0.1;
  Rig r;
  r.add(fem::box(line(0, L / n, 1), line(0, L / n, 1), line(0, L, n)), elastic(rho, K, G),
        [&](const Vec3& x) { return Vec3(0, V * std::cos(k * x[2]), 0); });
  r.fix(5, [](const Vec3&) { return true; });
  r.begin();
  return standing_speed(r, L, std::sqrt(G / rho), [&](const Vec3& x, const Vec3& v) { return v[1] * std::cos(k * x[2]); });
}

TEST(ElasticWave, ShearSpeed) {
  const double exact = std::sqrt(G / rho), coarse = shear_speed(10) / exact - 1, fine = shear_speed(20) / exact - 1;
  report("shear speed, 20 elements, m/s", (1 + fine) * exact, exact);
  const double order = observed_order("shear speed, 10 to 20", coarse, fine);
  EXPECT_LT(std::abs(fine), 2e-3);  // (k dx)^2/24 = 1e-3
  EXPECT_GT(order, 1.7);
}

}  // namespace
