// SPDX-License-Identifier: Apache-2.0
// The same shot as a whole, a half and a quarter, and turned to fly along x. Bits cannot agree (sums run in another order,
// and a cloud of fragments amplifies round-off), so integral results are compared, at 1 us, eight elements across.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "app/snapshot.hpp"
#include "core/error.hpp"
#include "tests/app/small_case.hpp"

namespace {

using core::Vec3;

struct Result {
  double kinetic = 0, internal = 0, momentum = 0, downstream = 0, hole = 0, converted = 0;
};

Result shoot(const std::vector<std::string>& set, const char* toml = small_case::text, int axis = 2, double end = 0) {
  auto s = small_case::begin(set, toml);
  if (end > 0) s->spec.end = end;
  small_case::run(*s, 100000);
  const double copies = s->spec.symmetry.copies();
  Result r;
  r.kinetic = s->ledger.now.kinetic * copies;
  r.internal = s->ledger.now.internal * copies;
  r.momentum = s->ledger.now.momentum[axis] * copies;
  r.converted = static_cast<double>(s->n_converted) * copies;
  // momentum of all that has left the plate behind
  for (std::size_t i = 0; i < s->particles.size(); ++i)
    if (s->particles.x[i][axis] < -0.6e-3) r.downstream += copies * s->particles.pt.m[i] * s->particles.v[i][axis];
  for (std::size_t nd = 0; nd < s->mesh.nodes.size(); ++nd)
    if (s->mesh.nodes.x[nd][axis] < -0.6e-3) r.downstream += copies * s->mesh.nodes.m[nd] * s->mesh.nodes.v[nd][axis];
  for (const auto& v : app::measure_snapshot(app::take_snapshot(*s), app::scene_now(*s), s->frozen).values)
    if (v.key == "bumper.hole_diameter") r.hole = v.value;
  std::printf("kinetic %.5f J internal %.5f J momentum %.8f downstream %.8f N s hole %.4f mm converted %.0f\n", r.kinetic, r.internal,
              r.momentum, r.downstream, r.hole * 1e3, r.converted);
  return r;
}

void expect_close(const Result& a, const Result& b, double part, double hole) {
  EXPECT_NEAR(a.kinetic, b.kinetic, part * b.kinetic);
  EXPECT_NEAR(a.momentum, b.momentum, 1e-12 * std::abs(b.momentum));  // along the line of flight no plane takes any
  EXPECT_NEAR(a.downstream, b.downstream, 2 * part * std::abs(b.downstream));
  EXPECT_NEAR(a.hole, b.hole, hole * b.hole);
  EXPECT_NEAR(a.converted, b.converted, 3 * part * b.converted);
}

TEST(Symmetry, TheFirstStrikePushesNothingAside) {
  // The sphere's lowest node meets a node of the plate, and that node four facets of the sphere: each has a normal of its own, and what the first
  // one did alone drove it aside at a tenth of the impact's speed, and heated one of the four elements behind.
  const auto velocity_and_heat = [](const char* symmetry) {
    auto s = small_case::begin({std::string("run.symmetry=") + symmetry, "run.elements_across=8"});
    while (s->contact.dissipated == 0 || s->steps < 6) {
      app::choose_step(*s, 1);
      app::step(*s);
    }
    std::map<std::array<long, 3>, Vec3> at;
    for (std::size_t nd = 0; nd < s->mesh.nodes.size(); ++nd) {
      const Vec3 x = s->mesh.nodes.x[nd] * 1e7;
      if (x[0] > -1 && x[1] > -1) at[{std::lround(x[0]), std::lround(x[1]), std::lround(x[2])}] = s->mesh.nodes.v[nd];
    }
    double most = 0, least = 1e300;  // heat [J/kg] of the elements at the axis in the plate's first layer
    for (std::size_t el = s->mesh.body_elements[1].first; el < s->mesh.body_elements[1].last; ++el) {
      const Vec3 x = fem::centre(s->mesh, el, s->mesh.nodes.x);
      if (s->mesh.elements.pt.m[el] == 0 || std::hypot(x[0], x[1]) > 0.15e-3 || x[2] < -0.075e-3) continue;
      most = std::max(most, s->mesh.elements.pt.e[el]), least = std::min(least, s->mesh.elements.pt.e[el]);
    }
    return std::tuple(at, most, least);
  };
  const auto [whole, most, least] = velocity_and_heat("\"none\"");
  const auto [quarter, hot, unused] = velocity_and_heat("[\"x\",\"y\"]");
  ASSERT_GT(hot, 1e5);
  EXPECT_NEAR(least, most, 1e-9 * most);
  EXPECT_NEAR(hot, most, 1e-9 * most);
  double off = 0;
  for (const auto& [x, v] : quarter) {
    const auto same = whole.find(x);
    ASSERT_TRUE(same != whole.end()) << x[0] << " " << x[1] << " " << x[2];
    off = std::max(off, (same->second - v).norm());
  }
  std::printf("most that a velocity differs by %.3g m/s; heat at the axis %.4g to %.4g J/kg\n", off, least, most);
  EXPECT_LT(off, 1e-9 * 6000);
}

TEST(Symmetry, BodiesThatTouchAreStruckAlike) {
  // The sphere's pole lies on the block, but for round-off of 1e-20 m. Where the last bit said that it lay behind the face no sweep let it alone, and in the
  // end pole and face went on as one: 0.3 % of the kinetic energy at 6 across, up to a tenth elsewhere, and a crater of 1.04 mm for 1.18.
  const auto kinetic = [](const char* symmetry, double diameter, int across) {
    const std::string mm = std::to_string(diameter), radius = std::to_string(diameter / 2);
    auto s = small_case::begin({std::string("run.symmetry=") + symmetry, "run.elements_across=" + std::to_string(across), "body.projectile.diameter=" + mm + " mm",
                                "body.projectile.center=[0, 0, \"" + radius + " mm\"]", "body.bumper.size=[\"14 mm\", \"14 mm\"]",
                                "body.bumper.thickness=7 mm", "body.bumper.center=[0, 0, \"-3.5 mm\"]", "body.projectile.velocity=[0, 0, \"-5 km/s\"]"});
    for (int k = 0; k < 6; ++k) {
      app::choose_step(*s, 1);
      app::step(*s);
    }
    EXPECT_GT(s->contact.dissipated, 0.0);
    return s->ledger.now.kinetic * s->spec.symmetry.copies();
  };
  constexpr double left_by_sweeps = 1e-5;  // round-off in most
  for (const auto& [diameter, across] : {std::pair{2.0, 6}, {2.0, 4}, {1.9, 6}, {2.3, 6}, {3.1, 8}}) {
    const double whole = kinetic("\"none\"", diameter, across), half = kinetic("[\"x\"]", diameter, across), quarter = kinetic("[\"x\",\"y\"]", diameter, across);
    std::printf("%g mm, %d across: half %.2g, quarter %.2g off\n", diameter, across, half / whole - 1, quarter / whole - 1);
    EXPECT_NEAR(half, whole, left_by_sweeps * whole) << diameter << " mm, " << across << " across";
    EXPECT_NEAR(quarter, whole, left_by_sweeps * whole) << diameter << " mm, " << across << " across";
  }
}

TEST(Symmetry, BeforeChaosAQuarterIsTheWhole) {
  // 0.03 us: contact has begun, nothing has been converted yet.
  const auto whole = shoot({"run.symmetry=\"none\""}, small_case::text, 2, 0.03e-6);
  const auto half = shoot({"run.symmetry=[\"x\"]"}, small_case::text, 2, 0.03e-6);
  const auto quarter = shoot({"run.symmetry=[\"x\",\"y\"]"}, small_case::text, 2, 0.03e-6);
  ASSERT_EQ(whole.converted, 0);
  // No round-off: contact's sweeps stop within a part of the margin, and go through the pairs in another order.
  EXPECT_NEAR(half.kinetic, whole.kinetic, 5e-5 * whole.kinetic);
  EXPECT_NEAR(quarter.kinetic, whole.kinetic, 5e-5 * whole.kinetic);
}

TEST(Symmetry, APlaneThatCutsAPlateAskewIsRefused) {
  for (const char* normal : {"body.1.normal=[1, 1, 0]", "body.1.normal=[1, 2, 0]"})
    EXPECT_THROW(small_case::begin({normal, "body.1.center=[\"-5 mm\", \"-5 mm\", 0]", "body.0.center=[0, 0, 0]", "body.0.velocity=[-6000, -6000, 0]",
                                    "run.symmetry=[\"z\"]"}), core::CaseError) << normal;
}

TEST(Clouds, AreTakenBeforeTheNextPlateInEveryMode) {
  // particles of the wall itself, and of what stands behind it, are no cloud that comes near it
  const std::string text = std::string(small_case::text) + R"([[body]]
name = "wall"
shape = "plate"
size = ["4 mm", "4 mm"]
thickness = "0.3 mm"
center = ["0 mm", "0 mm", "-3 mm"]
material = "Al2024-T351"
[[body]]
name = "last"
shape = "plate"
size = ["4 mm", "4 mm"]
thickness = "0.3 mm"
center = ["0 mm", "0 mm", "-6 mm"]
material = "Al2024-T351"
)";
  for (const char* mode : {"hybrid", "sph"}) {
    auto s = small_case::begin({std::string("run.mode=\"") + mode + "\"", "run.elements_across=6", "run.sleep=\"off\""}, text);
    while (s->time < 1.2e-6) {
      app::choose_step(*s, 1.2e-6);
      app::step(*s);
      if (s->steps % 10 == 0) app::freeze_clouds(*s);
    }
    double mass = 0, front = 0;
    for (const auto& v : app::measure_snapshot(app::take_snapshot(*s), app::scene_now(*s), s->frozen).values) {
      if (v.key == "cloud.mass") mass = v.value;
      if (v.key == "cloud.axial_velocity_front") front = v.value;
    }
    const double sphere = 2785 * 3.14159265 / 6 * 1e-9;
    EXPECT_GT(mass, 0.5 * sphere) << mode;
    EXPECT_GT(front, 4500) << mode;
    EXPECT_LT(front, 7500) << mode;

    // the pressure of the impact is known by then: what the axis bears later is of other impacts
    const double before = app::scene_now(*s).peak_pressure_axis;
    EXPECT_GT(before, 60e9) << mode;
    auto& p = s->particles;
    for (std::size_t i = 0; i < p.size(); ++i)
      if (std::binary_search(s->on_axis.begin(), s->on_axis.end(), p.parent[i])) p.pt.p_max[i] = 5e12;
    EXPECT_EQ(app::scene_now(*s).peak_pressure_axis, before) << mode;
    EXPECT_EQ(app::scene_now(*s).peak_pressure_max, 5e12) << mode;
  }
}

TEST(Clouds, AreNotTakenWhenSomethingElseComesNear) {
  // a second sphere flies past the bumper and is at the wall while the first has just struck the bumper
  const std::string text = std::string(small_case::text) + R"([[body]]
name = "second"
shape = "sphere"
diameter = "1 mm"
center = ["0 mm", "4.5 mm", "0.52 mm"]
velocity = ["0 km/s", "0 km/s", "-5.9 km/s"]
material = "Al2024-T351"
[[body]]
name = "wall"
shape = "plate"
size = ["12 mm", "12 mm"]
thickness = "0.3 mm"
center = ["0 mm", "0 mm", "-3 mm"]
material = "Al2024-T351"
)";
  auto s = small_case::begin({"run.elements_across=6", "body.projectile.center=[0, 0, \"3.5 mm\"]"}, text);
  while (s->time < 1.2e-6) {
    app::choose_step(*s, 1.2e-6);
    app::step(*s);
    if (s->steps % 10 == 0) app::freeze_clouds(*s);
  }
  ASSERT_EQ(s->cloud_frozen[0], 1);
  double mass = 0, front = 0;
  for (const auto& v : app::measure_snapshot(app::take_snapshot(*s), app::scene_now(*s), s->frozen).values) {
    if (v.key == "cloud.mass") mass = v.value;
    if (v.key == "cloud.axial_velocity_front") front = v.value;
  }
  const double sphere = 2785 * 3.14159265 / 6 * 1e-9;
  EXPECT_GT(mass, 0.5 * sphere);
  EXPECT_GT(front, 4500);
  EXPECT_LT(front, 7500);
}

TEST(Reference, IsOfThePlateWhereNothingLiesBeforeIt) {
  const auto pressure = [](const char* center) {
    return small_case::set_up({"body.projectile.center=[0, 0, 3 mm]"}, std::string(small_case::text) + R"([[body]]
name = "ball"
shape = "sphere"
diameter = "1 mm"
material = "OFHC-Cu"
center = )" + center + "\n")->scene;
  };
  EXPECT_EQ(pressure("[0, 0, \"0.5 mm\"]").peak_pressure_axis_hugoniot, 0) << "a ball of copper lies on the plate and is struck first";
  EXPECT_EQ(pressure("[0, 0, \"0.5 mm\"]").peak_pressure_jetting, 0);
  for (const char* beside : {"[0, 0, \"-0.9 mm\"]", "[\"2 mm\", 0, \"0.5 mm\"]", "[0, 0, \"5 mm\"]"}) EXPECT_NEAR(pressure(beside).peak_pressure_axis_hugoniot, 78.05e9, 0.1e9) << beside;
}

void run_looking_at_clouds(app::Simulation& s, double end) {
  while (s.time < end) {
    app::choose_step(s, end);
    app::step(s);
    app::freeze_clouds(s);
  }
}

TEST(Clouds, WaitForDebrisWhereAPlatesOwnEdgeIsNearTheNext) {
  // the bumper stands askew, and its lower edge all but touches the wall behind it
  std::string text = small_case::text;
  const auto replace = [&](const std::string& a, const std::string& b) { text.replace(text.rfind(a), a.size(), b); };
  replace("\"0 mm\", \"0 mm\", \"-0.15 mm\"]\n", "0, 0, 0]\nnormal = [1, 0, 1]\n");
  replace("\"6 mm\", \"6 mm\"", "\"4 mm\", \"4 mm\"");
  replace("\"0.52 mm\"", "\"1.2 mm\"");
  text += R"([[body]]
name = "wall"
shape = "plate"
size = ["8 mm", "8 mm"]
thickness = "0.5 mm"
center = ["0 mm", "0 mm", "-1.78 mm"]
material = "Al2024-T351"
)";
  std::map<std::string, double> mass;
  for (const char* set : {"run.sleep=exact", "run.sleep=off", "run.mode=sph"}) {
    auto s = small_case::begin({set}, text);
    ASSERT_EQ(s->scene.plates.size(), 2u);
    run_looking_at_clouds(*s, 0.6e-6);
    EXPECT_EQ(s->cloud_frozen[0], 1) << set << ": debris has come to the wall by now";
    EXPECT_GT(app::scene_now(*s).peak_pressure_axis, 50e9) << set;
    for (const auto& v : s->frozen)
      if (v.key == "cloud.mass") mass[set] = v.value;
    const double sphere = 2785 * 3.14159265 / 6 * 1e-9;
    EXPECT_GT(mass[set], 0.5 * sphere) << set;
  }
  EXPECT_EQ(mass["run.sleep=exact"], mass["run.sleep=off"]);
}

TEST(Clouds, LayersThatLieOnEachOtherAreStruckAsOne) {
  // what the first layer's debris presses on at once is no other impact: the stack bears what a plate of its thickness does
  std::map<int, double> peak;
  for (const int layers : {1, 2}) {
    std::string text = small_case::text;
    text.erase(text.rfind("[[body]]"));
    for (int k = 0; k < layers; ++k)
      text += "[[body]]\nname = \"layer" + std::to_string(k) + "\"\nshape = \"plate\"\nsize = [\"2 mm\", \"2 mm\"]\nmaterial = \"Al2024-T351\"\nthickness = " +
              std::to_string(0.2e-3 / layers) + "\ncenter = [0, 0, " + std::to_string(-(k + 0.5) * 0.2e-3 / layers) + "]\n";
    auto s = small_case::begin({"run.elements_across=10"}, text);
    run_looking_at_clouds(*s, 0.15e-6);
    peak[layers] = app::scene_now(*s).peak_pressure_axis;
  }
  EXPECT_NEAR(peak[2], peak[1], 0.2 * peak[1]);  // one element thick, the layers ring a little higher
}

TEST(Symmetry, QuarterHalfAndWholeAgree) {
  const std::string coarse = "body.bumper.elements_through=2";  // of three layers more has broken by then: 1.7 % of what is converted differs
  const auto whole = shoot({coarse, "run.symmetry=\"none\""});
  const auto half = shoot({coarse, "run.symmetry=[\"x\"]"});
  const auto quarter = shoot({coarse, "run.symmetry=[\"x\",\"y\"]"});
  // the order of contact impulses (Gauss-Seidel) and of conversions differs, and eight elements across are coarse; the hole is ragged
  expect_close(half, whole, 0.005, 0.03);
  expect_close(quarter, whole, 0.005, 0.03);
}

TEST(Symmetry, QuarterAndWholeAgreeInErosionAndSph) {
  const std::string layers = "body.bumper.elements_through=3";  // of four some erode by chance: whole, half and quarter keep 9.6, 9.0 and 6.5 % of the energy
  for (const char* mode : {"run.mode=\"erosion\"", "run.mode=\"sph\""}) {
    const auto whole = shoot({mode, layers, "run.symmetry=\"none\""});
    const auto quarter = shoot({mode, layers, "run.symmetry=[\"x\",\"y\"]"});
    // sph has no contact and agrees to round-off. In erosion a tenth of the energy is left, in few coarse elements, and
    // which of them go hangs on the step in which a criterion is looked at: 1 % of what there was at the start.
    const double part = std::string(mode).find("sph") != std::string::npos ? 1e-6 : 0.01;
    EXPECT_NEAR(quarter.kinetic, whole.kinetic, part * 24.44) << mode;
    EXPECT_NEAR(quarter.downstream, whole.downstream, part * 8.147e-3) << mode;
    EXPECT_NEAR(quarter.hole, whole.hole, 0.03 * whole.hole) << mode;
  }
}

TEST(Rotation, AShotAlongXIsTheShotAlongZ) {
  const auto z = shoot({"run.symmetry=\"none\""});
  const auto x = shoot({"run.symmetry=\"none\""}, small_case::turned, 0);
  expect_close(x, z, 0.005, 0.03);
  EXPECT_GT(x.hole, 0);
  const auto half = shoot({}, small_case::turned, 0);  // auto: about y
  expect_close(half, z, 0.005, 0.03);
}

TEST(Rotation, ATurnedSceneMayNameItsPlanes) {
  // A sphere on a plate with normal x is its own mirror image about y and about z.
  const auto z = shoot({});
  const auto quarter = shoot({"run.symmetry=[\"y\",\"z\"]"}, small_case::turned, 0);
  expect_close(quarter, z, 0.005, 0.03);
}

std::string moving(const Vec3& shot, const Vec3& bumper) {
  std::string toml = small_case::text;
  const auto velocity = [](const Vec3& v) { return "velocity = [" + std::to_string(v[0]) + ", " + std::to_string(v[1]) + ", " + std::to_string(v[2]) + "]\n"; };
  const std::string given = "velocity = [\"0 km/s\", \"0 km/s\", \"-6 km/s\"]\n";
  toml.replace(toml.find(given), given.size(), velocity(shot));
  return toml + velocity(bumper);
}

TEST(Boost, AShotAtAPlateThatFliesIsTheShotAtOneAtRest) {
  const auto measured = [](const std::string& toml, double end) {
    auto s = small_case::begin({"run.symmetry=\"none\"", "run.sleep=\"off\""}, toml);
    s->spec.end = end;
    small_case::run(*s, 100000);
    std::map<std::string, double> r;
    for (const auto& v : app::measure_snapshot(app::take_snapshot(*s), app::scene_now(*s), s->frozen).values) r[v.key] = v.value;
    return r;
  };
  const double early = 0.03e-6, late = 0.6e-6;  // before anything has been converted, and after
  const auto still = measured(small_case::text, late), begun = measured(small_case::text, early);
  for (const Vec3& v : {Vec3(0, 0, 2000), Vec3(3000, -500, 5000)}) {
    const std::string toml = moving(Vec3(0, 0, -6000) + v, v);
    const auto a = small_case::set_up({"run.symmetry=\"none\""}), b = small_case::set_up({"run.symmetry=\"none\""}, toml);
    EXPECT_EQ(b->scene.projectile, 0);
    EXPECT_EQ(b->scene.plates, a->scene.plates);
    EXPECT_LT((b->scene.aim - a->scene.aim).norm(), 1e-15);
    EXPECT_EQ(b->on_axis, a->on_axis);
    ASSERT_EQ(b->mesh.nodes.size(), a->mesh.nodes.size());
    for (std::size_t nd = 0; nd < a->mesh.nodes.size(); ++nd) EXPECT_LT((b->mesh.nodes.x[nd] - a->mesh.nodes.x[nd]).norm(), 1e-15);
    const auto soon = measured(toml, early), r = measured(toml, late);
    for (const char* key : {"bumper.impulse", "peak_pressure", "peak_pressure_max", "peak_pressure_hugoniot"})
      EXPECT_NEAR(soon.at(key), begun.at(key), 1e-3 * begun.at(key)) << key;
    const std::map<std::string, double> within{{"bumper.hole_diameter", 0.08}, {"cloud.mass", 0.03}, {"cloud.momentum", 0.03}, {"cloud.kinetic_energy", 0.03},
                                               {"cloud.spray_half_angle", 0.05}, {"cloud.axial_velocity_front", 0.03}, {"cloud.length", 0.05}, {"fragments.mass", 0.03}};
    for (const auto& [key, part] : within) EXPECT_NEAR(r.at(key), still.at(key), part * still.at(key)) << key;
  }
}

TEST(Boost, SpheresThatBothFlyAreTheShotAtOneAtRest) {
  // no plate: the wider one is what is struck
  const auto scene = [](const Vec3& v) {
    std::string text = small_case::text;
    const auto replace = [&](const std::string& a, const std::string& b) { text.replace(text.rfind(a), a.size(), b); };
    replace("\"plate\"\nsize = [\"6 mm\", \"6 mm\"]\nthickness = \"0.3 mm\"", "\"sphere\"\ndiameter = \"1.2 mm\"");
    replace("\"-0.15 mm\"", "\"-0.6 mm\"");
    const auto velocity = [](const Vec3& u) { return "velocity = [" + std::to_string(u[0]) + ", " + std::to_string(u[1]) + ", " + std::to_string(u[2]) + "]\n"; };
    replace("velocity = [\"0 km/s\", \"0 km/s\", \"-6 km/s\"]\n", velocity(v - Vec3(0, 0, 6000)));
    return text + velocity(v);
  };
  const auto measured = [](app::Simulation& s) {
    app::begin(s);
    small_case::run(s, 100000);
    std::map<std::string, double> r;
    for (const auto& v : app::measure_snapshot(app::take_snapshot(s), app::scene_now(s), s.frozen).values) r[v.key] = v.value;
    return r;
  };
  const std::vector<std::string> set{"run.symmetry=none", "run.sleep=off", "run.end=0.3 us"};
  const auto still = small_case::set_up(set, scene(Vec3::Zero()));
  const auto expected = measured(*still);
  for (const Vec3& v : {Vec3(0, 0, 3000), Vec3(2000, -1000, 7000)}) {
    const auto s = small_case::set_up(set, scene(v));
    EXPECT_EQ(s->scene.projectile, 0);
    EXPECT_EQ(s->scene.impact_velocity, Vec3(0, 0, -6000));
    EXPECT_EQ(s->mesh.elements.size(), still->mesh.elements.size());
    const auto r = measured(*s);
    for (const char* key : {"fragments.mass", "fragments.momentum", "peak_pressure"}) EXPECT_NEAR(r.at(key), expected.at(key), 0.03 * expected.at(key)) << key;
  }
  // bodies that fly together strike nothing
  EXPECT_EQ(small_case::set_up({"body.0.velocity=[0, 0, 500]", "body.1.velocity=[0, 0, 500]"}, scene(Vec3::Zero()))->scene.rest, Vec3(0, 0, 0));
}

TEST(Symmetry, QuartersOfAllBodiesLieOnThePositiveSide) {
  // However a body's normal points: what is left of it after the cut must lie where the others' halves lie.
  const std::string plate = "center = [\"0 mm\", \"0 mm\", \"-0.15 mm\"]\n";
  for (const char* normal : {"[0,0,1]", "[0,0,-1]"})
    for (const bool cylinder : {false, true}) {
      std::string toml = small_case::text;
      toml.insert(toml.rfind(plate), std::string("normal = ") + normal + "\n");
      if (cylinder) {
        toml.replace(toml.find("\"sphere\"\n"), 9, std::string("\"cylinder\"\nlength = \"1 mm\"\nnormal = ") + normal + "\n");
      }
      const auto s = small_case::set_up({}, toml);
      ASSERT_TRUE(s->spec.symmetry.plane[0] && s->spec.symmetry.plane[1]);
      for (std::size_t b = 0; b < 2; ++b) {
        double lowest = 0;
        for (auto nd = s->mesh.body_nodes[b].first; nd < s->mesh.body_nodes[b].last; ++nd)
          lowest = std::min({lowest, s->mesh.nodes.x[nd][0], s->mesh.nodes.x[nd][1]});
        EXPECT_GE(lowest, 0) << s->spec.bodies[b].name << " with normal " << normal << (cylinder ? ", cylinder" : ", sphere");
      }
    }
}

TEST(Rotation, AutoSymmetryFindsThePlanesOfATurnedShot) {
  const auto s = small_case::set_up({}, small_case::turned);
  EXPECT_FALSE(s->spec.symmetry.plane[0]);
  EXPECT_TRUE(s->spec.symmetry.plane[1]);
}

}  // namespace
