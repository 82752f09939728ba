// SPDX-License-Identifier: Apache-2.0
// The case file: the example of the contract word by word, the round trip through write_case, and what is said about
// files that cannot be used: file and line, the key, what would be valid.
#include "io/case_file.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "core/error.hpp"
#include "io/material_file.hpp"

namespace {

namespace fs = std::filesystem;

const char* const contract = R"(title = "4 mm sphere on 0.8 mm plate at 8 km/s"
[run]
mode = "hybrid"                 # hybrid | erosion | fem (nothing removed) | sph (particles from the start)
end = "20 us"
fidelity = "standard"           # draft | standard | fine | reference, or elements_across = 24
symmetry = "auto"               # auto | none | ["x"] | ["x", "y"]
sleep = "default"               # default | exact | off | a speed ("1e-6 m/s")
[[body]]
name = "projectile"
shape = "sphere"                # sphere | cylinder | plate | box | mesh (file = ...)
diameter = "4 mm"
center = ["0 mm", "0 mm", "2.05 mm"]
velocity = ["0 km/s", "0 km/s", "-8 km/s"]
material = "Al2024-T351"
[[body]]
name = "bumper"
shape = "plate"                 # normal z; front face at the larger z
size = ["40 mm", "40 mm"]
thickness = "0.8 mm"
center = ["0 mm", "0 mm", "-0.4 mm"]
material = "Al2024-T351"
[convert]
criterion = "jacobian"          # or several: ["jacobian", "timestep"]
jacobian_ratio = 2.5
min_angle = "0.5 rad"
particles_per_edge = 1
bond = true
[output]
every = "0.5 us"
[reference]
"bumper.hole_diameter" = { value = "7.8 mm", source = "Frey et al., IJIE 14 (1993) 255" }
)";

/// As the contract has it, without the table: it is not there yet.
const char* const contract_material = R"(
[materials.my-alloy]            # optional: a new material, or `base =` one of the library with some values changed
base = "Al2024-T351"
eos = { model = "mie_grueneisen", c_0 = "5.3 km/s" }
strength = { model = "johnson_cook", A = "265 MPa", B = "426 MPa", n = 0.34, C = 0.015, m = 1.0 }
)";

/// Every key, none at its default.
const char* const everything = R"(title = "all \"keys\""
[run]
mode = "erosion"
end = 1.1e-5
elements_across = 24
symmetry = ["x", "y"]
sleep = "1e-6 m/s"
cfl = 0.45
hourglass = "stiffness"
hourglass_coefficient = 0.07
viscosity_linear = 0.11
viscosity_quadratic = 1.7
energy_tolerance = 1e-5
[[body]]
name = "rod"
shape = "cylinder"
diameter = "4.5 mm"
length = "4.7 mm"
center = [0.1, 0.2, 0.3]
normal = [1, 1, 0.5]
velocity = ["1 km/s", 0, "-8 km/s"]
spin = ["10 rad/s", 0, "100 rpm"]
material = "mine"
element_size = "0.1 mm"
[[body]]
name = "wall-1"
shape = "plate"
size = ["30 mm", "40 mm"]
thickness = "1.2 mm"
fine_radius = "7 mm"
elements_through = 7
material = "OFHC-Cu"
[[body]]
name = "block"
shape = "box"
size = ["30 mm", "40 mm", "50 mm"]
center = [0, 0, -0.1]
material = "Be"
[[wall]]
point = [0, 0, "-50 mm"]
normal = [0, 3, 4]
[convert]
criterion = ["timestep", "damage"]
deformation = 2.2
jacobian_ratio = 3
min_angle = "20 deg"
plastic_strain = 1.5
timestep_ratio = 0.2
damage = 0.9
particles_per_edge = 2
bond = false
keep_nodes = true
[contact]
enabled = false
friction = 0.1
[output]
every = "1 us"
history_every = "1 ns"
checkpoint_every = "2 min"
[reference]
"wall-1.perforated" = { value = true, source = "a shot" }
"cloud.spray_half_angle" = "25 deg"
peak_pressure_max = "150 GPa"
[materials.mine]
base = "W"
rho_0 = "17.6 g/cm3"
spall = { limit = "2 GPa", fracture_energy = "0.5 kJ/m2" }
[materials.mine.strength]
model = "perfectly_plastic"
G = "160 GPa"
Y = "1.5 GPa"
)";

class CaseFile : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    dir_ = fs::temp_directory_path() / ("ejecta_case_" + std::string(info->name()) + "_" + std::to_string(getpid()));
    fs::create_directories(dir_);
  }
  void TearDown() override { fs::remove_all(dir_); }

  std::string write(const std::string& text) const {
    std::ofstream(file()) << text;
    return file();
  }
  std::string file() const { return (dir_ / "case.toml").string(); }

  io::Case read(const std::string& text, const std::vector<std::string>& set = {}, const std::string& mode = "") const {
    return io::read_case(write(text), set, mode);
  }

  /// What is said about the contract's case with one piece of text replaced. Messages begin with the place.
  std::string error(const std::string& from, const std::string& to, const std::vector<std::string>& set = {}) const {
    std::string text = contract;
    if (!from.empty()) {
      const auto at = text.find(from);
      EXPECT_NE(at, std::string::npos) << from;
      text.replace(at, from.size(), to);
    } else {
      text += to;
    }
    return error_of(text, set);
  }
  std::string error_of(const std::string& text, const std::vector<std::string>& set = {}) const {
    try {
      read(text, set);
    } catch (const core::CaseError& e) {
      std::string message = e.what();
      if (message.starts_with(dir_.string())) message.erase(0, dir_.string().size() + 1);
      return message;
    }
    return "accepted";
  }

  fs::path dir_;
};

void expect_parts(const std::string& message, const std::vector<std::string>& parts) {
  for (const std::string& part : parts)
    EXPECT_NE(message.find(part), std::string::npos) << "'" << part << "' is not in: " << message;
}

TEST_F(CaseFile, ExampleOfTheContract) {
  const io::Case c = read(std::string(contract) + contract_material);
  EXPECT_EQ(c.title, "4 mm sphere on 0.8 mm plate at 8 km/s");
  EXPECT_EQ(c.file, file());
  EXPECT_EQ(c.mode, io::Mode::hybrid);
  EXPECT_EQ(c.end, 20e-6);
  EXPECT_EQ(c.fidelity, "standard");
  EXPECT_EQ(c.elements_across, 20);
  EXPECT_TRUE(c.symmetry_auto);
  EXPECT_EQ(c.sleep, 0);
  ASSERT_EQ(c.bodies.size(), 2u);
  const io::BodySpec& ball = c.bodies[0];
  EXPECT_EQ(ball.name, "projectile");
  EXPECT_EQ(ball.shape, io::Shape::sphere);
  EXPECT_EQ(ball.diameter, 0.004);
  EXPECT_EQ(ball.center, core::Vec3(0, 0, 0.00205));
  EXPECT_EQ(ball.velocity, core::Vec3(0, 0, -8000));
  const io::BodySpec& plate = c.bodies[1];
  EXPECT_EQ(plate.shape, io::Shape::plate);
  EXPECT_EQ(plate.size, core::Vec3(0.04, 0.04, 0.0008));
  EXPECT_EQ(plate.normal, core::Vec3(0, 0, 1));
  EXPECT_EQ(plate.velocity, core::Vec3(0, 0, 0));
  EXPECT_FALSE(plate.fine_radius || plate.element_size || plate.elements_through);
  EXPECT_EQ(c.criteria, std::vector<std::string>{"jacobian"});
  EXPECT_EQ(c.jacobian_ratio, 2.5);
  EXPECT_EQ(c.min_angle, 0.5);
  EXPECT_EQ(c.particles_per_edge, 1);
  EXPECT_TRUE(c.bond);
  EXPECT_EQ(c.every, 0.5e-6);
  EXPECT_EQ(c.reference.at("bumper.hole_diameter").value, 0.0078);
  EXPECT_EQ(c.reference.at("bumper.hole_diameter").source, "Frey et al., IJIE 14 (1993) 255");
  EXPECT_EQ(c.reference.at("bumper.hole_diameter").line, 31);
  ASSERT_EQ(c.materials.size(), 1u);
  EXPECT_EQ(c.materials.at("Al2024-T351").rho_0, 2785.0);
}

TEST_F(CaseFile, EveryKeyArrives) {
  const io::Case c = read(everything);
  EXPECT_EQ(c.title, "all \"keys\"");
  EXPECT_EQ(c.mode, io::Mode::erosion);
  EXPECT_EQ(c.fidelity, "custom");
  EXPECT_EQ(c.elements_across, 24);
  EXPECT_FALSE(c.symmetry_auto);
  EXPECT_EQ(c.symmetry.plane, (std::array<bool, 3>{true, true, false}));
  EXPECT_EQ(c.sleep, 1e-6);
  EXPECT_EQ(c.cfl, 0.45);
  EXPECT_EQ(c.hourglass, "stiffness");
  EXPECT_EQ(c.hourglass_coefficient, 0.07);
  EXPECT_EQ(c.viscosity_linear, 0.11);
  EXPECT_EQ(c.viscosity_quadratic, 1.7);
  EXPECT_EQ(c.energy_tolerance, 1e-5);
  EXPECT_EQ(c.bodies[0].length, 0.0047);
  EXPECT_NEAR((c.bodies[0].normal - core::Vec3(2, 2, 1) / 3).norm(), 0, 1e-15);  // made a unit vector
  EXPECT_EQ(c.bodies[0].velocity, core::Vec3(1000, 0, -8000));
  EXPECT_NEAR(c.bodies[0].spin[2], 10.471975511965978, 1e-14);
  EXPECT_EQ(c.bodies[0].element_size, 1e-4);
  EXPECT_EQ(c.bodies[1].fine_radius, 0.007);
  EXPECT_EQ(c.bodies[1].elements_through, 7);
  EXPECT_EQ(c.bodies[2].size, core::Vec3(0.03, 0.04, 0.05));
  EXPECT_EQ(c.walls.at(0).point, core::Vec3(0, 0, -0.05));
  EXPECT_NEAR((c.walls[0].normal - core::Vec3(0, 0.6, 0.8)).norm(), 0, 1e-15);
  EXPECT_EQ(c.criteria, (std::vector<std::string>{"timestep", "damage"}));
  EXPECT_EQ(c.deformation, 2.2);
  EXPECT_EQ(c.jacobian_ratio, 3);
  EXPECT_DOUBLE_EQ(c.min_angle, 0.34906585039886590);
  EXPECT_EQ(c.plastic_strain, 1.5);
  EXPECT_EQ(c.timestep_ratio, 0.2);
  EXPECT_EQ(c.damage, 0.9);
  EXPECT_EQ(c.particles_per_edge, 2);
  EXPECT_FALSE(c.bond);
  EXPECT_TRUE(c.keep_nodes);
  EXPECT_FALSE(c.contact);
  EXPECT_EQ(c.friction, 0.1);
  EXPECT_EQ(c.every, 1e-6);
  EXPECT_EQ(c.history_every, 1e-9);
  EXPECT_EQ(c.checkpoint_every, 120);
  EXPECT_EQ(c.reference.at("wall-1.perforated").value, 1);
  EXPECT_DOUBLE_EQ(c.reference.at("cloud.spray_half_angle").value, 0.43633231299858238);
  EXPECT_EQ(c.reference.at("peak_pressure_max").value, 150e9);
  EXPECT_EQ(c.materials.size(), 3u);
  EXPECT_EQ(c.materials.at("mine").rho_0, 17600.0);
  EXPECT_EQ(std::get<material::PerfectlyPlastic>(c.materials.at("mine").strength).Y, 1.5e9);
}

/// All that write_case writes is in its text, so equal texts mean equal cases.
TEST_F(CaseFile, ResolvedCaseReadsBackToTheSame) {
  for (const std::string& text : {std::string(contract), std::string(everything)}) {
    const io::Case c = read(text);
    const std::string once = io::write_case(c);
    const io::Case back = read(once);
    EXPECT_EQ(io::write_case(back), once);
    EXPECT_EQ(back.end, c.end);
    EXPECT_EQ(back.fidelity, c.fidelity);
    EXPECT_EQ(back.min_angle, c.min_angle);
    EXPECT_EQ(back.hourglass_coefficient, c.hourglass_coefficient);
    EXPECT_EQ(back.checkpoint_every, c.checkpoint_every);
    ASSERT_EQ(back.bodies.size(), c.bodies.size());
    for (std::size_t k = 0; k < c.bodies.size(); ++k) {
      EXPECT_EQ(back.bodies[k].normal, c.bodies[k].normal);
      EXPECT_EQ(back.bodies[k].spin, c.bodies[k].spin);
      EXPECT_EQ(back.bodies[k].size, c.bodies[k].size);
    }
    for (const auto& [name, m] : c.materials) {
      EXPECT_EQ(back.materials.at(name).eos.index(), m.eos.index());
      EXPECT_EQ(back.materials.at(name).strength.index(), m.strength.index());
      EXPECT_EQ(back.materials.at(name).spall, m.spall);
      EXPECT_EQ(back.materials.at(name).fracture_energy, m.fracture_energy);
      EXPECT_EQ(back.materials.at(name).e_vaporised, m.e_vaporised);
      EXPECT_EQ(back.materials.at(name).damage.has_value(), m.damage.has_value());
    }
  }
}

/// A run writes its case, and goes on only from the same one.
TEST_F(CaseFile, WhatIsNoIntegerOfTomlReadsBackToTheSame) {
  const io::Case c = read(std::string(contract) + "\"peak_pressure\" = 12345678901234567890.0\n", {"body.0.center=[-0.0, 0, \"-0 mm\"]"});
  const std::string once = io::write_case(c);
  const io::Case back = read(once);
  EXPECT_EQ(io::write_case(back), once);
  EXPECT_TRUE(std::signbit(back.bodies[0].center[0]) && std::signbit(back.bodies[0].center[2])) << once;
  EXPECT_EQ(back.reference.at("peak_pressure").value, 12345678901234567890.0);
}

TEST_F(CaseFile, FidelityStandsForElementsAcross) {
  for (const auto& [name, across] : std::vector<std::pair<std::string, int>>{
           {"draft", 10}, {"standard", 20}, {"fine", 32}, {"reference", 48}})
    EXPECT_EQ(read(contract, {"run.fidelity=" + name}).elements_across, across);
}

TEST_F(CaseFile, SleepAndSymmetryWords) {
  EXPECT_EQ(read(contract, {"run.sleep=exact"}).sleep, 0);
  EXPECT_EQ(read(contract, {"run.sleep=off"}).sleep, -1);
  EXPECT_EQ(read(contract, {"run.sleep=1 mm/s"}).sleep, 1e-3);
  const io::Case none = read(contract, {"run.symmetry=none"});
  EXPECT_FALSE(none.symmetry_auto);
  EXPECT_EQ(none.symmetry.copies(), 1);
  EXPECT_EQ(read(contract, {"run.symmetry=[\"z\"]"}).symmetry.plane[2], true);
  EXPECT_EQ(read(contract, {"run.symmetry=[x, y]"}).symmetry.copies(), 4);
}

TEST_F(CaseFile, OverridesComeBeforeReading) {
  const io::Case c = read(contract, {"run.end=5 us", "body.projectile.velocity=[0,0,-7000]", "body.0.diameter=3 mm",
                                     "convert.jacobian_ratio=2", "run.elements_across=14", "title=other"}, "erosion");
  EXPECT_EQ(c.end, 5e-6);
  EXPECT_EQ(c.bodies[0].velocity, core::Vec3(0, 0, -7000));
  EXPECT_EQ(c.bodies[0].diameter, 0.003);
  EXPECT_EQ(c.jacobian_ratio, 2);
  EXPECT_EQ(c.elements_across, 14);  // takes the place of the file's fidelity
  EXPECT_EQ(c.fidelity, "custom");
  EXPECT_EQ(c.mode, io::Mode::erosion);
  EXPECT_EQ(c.title, "other");
}

TEST_F(CaseFile, OverridesAreNamedInErrors) {
  expect_parts(error("", "", {"run.end=5 mm"}), {"--set run.end: '5 mm' is a length, but a time is needed"});
  expect_parts(error("", "", {"run.fideltiy=fine"}), {"--set run.fideltiy: unknown key", "did you mean 'fidelity'"});
  expect_parts(error("", "", {"body.bumpr.thickness=1 mm"}), {"--set body.bumpr.thickness", "did you mean 'bumper'"});
  expect_parts(error("", "", {"run.fidelity=fine", "run.elements_across=10"}), {"--set run.elements_across: fidelity is given"});
  try {
    read(contract, {}, "hybird");
    FAIL();
  } catch (const core::CaseError& e) {
    expect_parts(e.what(), {"--mode: \"hybird\" is not known; did you mean 'hybrid'"});
  }
}

TEST_F(CaseFile, MisspeltKeys) {
  expect_parts(error("fidelity =", "fideltiy ="), {"case.toml:5: run.fideltiy: unknown key; did you mean 'fidelity'?",
                                                   "elements_across"});
  expect_parts(error("diameter =", "diametr ="), {"case.toml:11: body.projectile.diametr: unknown key", "'diameter'"});
  expect_parts(error("[output]", "[ouput]"), {"case.toml:28: ouput: unknown key; did you mean 'output'?"});
  expect_parts(error("bond = true", "glue = true"), {"case.toml:27: convert.glue: unknown key; valid here: criterion"});
  expect_parts(error("source = \"Frey", "sourse = \"Frey"), {"case.toml:31", "sourse", "did you mean 'source'"});
}

TEST_F(CaseFile, MissingKeys) {
  expect_parts(error("end = \"20 us\"", ""), {"case.toml:2: run.end: is missing", "end = \"20 us\""});
  expect_parts(error("diameter = \"4 mm\"", ""), {"case.toml:8: body.projectile.diameter: is missing; a sphere needs it"});
  expect_parts(error("thickness = \"0.8 mm\"", ""), {"case.toml:15: body.bumper.thickness: is missing; a plate needs it"});
  expect_parts(error("name = \"bumper\"", ""), {"case.toml:15: body.1.name: is missing"});
  expect_parts(error("shape = \"sphere\"", ""), {"case.toml:8: body.projectile.shape: is missing"});
  expect_parts(error("\nmaterial = \"Al2024-T351\"", ""), {"case.toml:8: body.projectile.material: is missing"});
  expect_parts(error_of("[run]\nend = 1\n"), {"case.toml: [[body]]: is missing"});
  expect_parts(error_of("[[body]]\nname = \"a\"\n"), {"case.toml: [run]: is missing"});
}

TEST_F(CaseFile, ValuesOutOfRange) {
  expect_parts(error("\"0.8 mm\"", "\"0 mm\""), {"case.toml:19: body.bumper.thickness: \"0 mm\" is out of range; must be greater than 0"});
  expect_parts(error("\"0.8 mm\"", "-0.001"), {"case.toml:19", "thickness", "-0.001", "greater than 0"});
  expect_parts(error("\"4 mm\"", "0"), {"case.toml:11", "diameter", "greater than 0"});
  expect_parts(error("\"20 us\"", "\"-1 us\""), {"case.toml:4: run.end", "greater than 0"});
  expect_parts(error("\"20 us\"", "inf"), {"case.toml:4: run.end: inf is not finite"});
  expect_parts(error("\"-8 km/s\"", "nan"), {"case.toml:13: body.projectile.velocity[2]: nan is not finite"});
  expect_parts(error("\"-8 km/s\"", "-8e9"), {"case.toml:13", "velocity", "m/s"});
  expect_parts(error("jacobian_ratio = 2.5", "jacobian_ratio = 1"), {"case.toml:24", "greater than 1"});
  expect_parts(error("particles_per_edge = 1", "particles_per_edge = 4"), {"case.toml:26", "from 1 to 3"});
  expect_parts(error("particles_per_edge = 1", "particles_per_edge = 1.5"), {"case.toml:26", "whole number"});
  expect_parts(error("min_angle = \"0.5 rad\"", "min_angle = \"120 deg\""), {"case.toml:25", "less than 1.5708 rad"});
  expect_parts(error("diameter = \"4 mm\"", "diameter = \"4 mm\"\nelement_size = \"5 mm\""), {"case.toml:12", "smallest extent, 0.004 m"});
  expect_parts(error("", "", {"run.cfl=1.5"}), {"--set run.cfl: 1.5 is out of range; must be greater than 0 and at most 1"});
  expect_parts(error("", "", {"body.bumper.normal=[0,0,0]"}), {"--set body.bumper.normal", "no length"});
}

TEST_F(CaseFile, ValuesOfAnotherKind) {
  expect_parts(error("\"20 us\"", "\"20 kg\""), {"case.toml:4: run.end: '20 kg' is a mass, but a time is needed, for example \"20 us\""});
  expect_parts(error("\"20 us\"", "true"), {"case.toml:4: run.end: true is no number"});
  expect_parts(error("bond = true", "bond = \"true\""), {"case.toml:27: convert.bond", "neither true nor false"});
  expect_parts(error("[\"0 mm\", \"0 mm\", \"2.05 mm\"]", "[0, 0]"), {"case.toml:12: body.projectile.center", "a list of 3"});
  expect_parts(error("[\"40 mm\", \"40 mm\"]", "\"40 mm\""), {"case.toml:18: body.bumper.size", "a list of 2"});
  expect_parts(error("\"hybrid\"", "\"hybird\""), {"case.toml:3: run.mode: \"hybird\" is not known; did you mean 'hybrid'?", "erosion, fem, sph"});
  expect_parts(error("\"standard\"", "\"ultra\""), {"case.toml:5: run.fidelity", "draft, standard, fine, reference"});
  expect_parts(error("\"auto\"", "[\"w\"]"), {"case.toml:6: run.symmetry: 'w' is not known", "[\"x\", \"y\"]"});
  expect_parts(error("\"default\"", "\"defualt\""), {"case.toml:7: run.sleep", "\"exact\"", "1e-6 m/s"});
  expect_parts(error("\"default\"", "\"-1 m/s\""), {"case.toml:7: run.sleep", "at least 0"});
  expect_parts(error("criterion = \"jacobian\"", "criterion = [\"jacobain\"]"), {"case.toml:23: convert.criterion", "did you mean 'jacobian'"});
  expect_parts(error("criterion = \"jacobian\"", "criterion = [\"damage\", \"damage\"]"), {"listed twice"});
  expect_parts(error("criterion = \"jacobian\"", "criterion = []"), {"is empty"});
  expect_parts(error("[run]", "[[run]]"), {"case.toml:2: run: ", "no table"});
  expect_parts(error_of("[run]\nend = 1\n[body]\nname = \"a\"\n"), {"case.toml:3: body: must be written [[body]]"});
}

TEST_F(CaseFile, BodiesThatDoNotFit) {
  expect_parts(error("name = \"bumper\"", "name = \"projectile\""), {"case.toml:16", "name of an earlier body"});
  expect_parts(error("name = \"bumper\"", "name = \"\""), {"case.toml:16: body.1.name: is empty"});
  expect_parts(error("name = \"bumper\"", "name = \"a.b\""), {"case.toml:16", "holds '.'"});
  expect_parts(error("shape = \"sphere\"", "shape = \"spher\""), {"case.toml:10", "did you mean 'sphere'"});
  expect_parts(error("diameter = \"4 mm\"", "diameter = \"4 mm\"\nlength = 1"), {"case.toml:12: body.projectile.length: a sphere has no length; it belongs to: cylinder"});
  expect_parts(error("material = \"Al2024-T351\"\n[[", "material = \"Al2024-T531\"\n[["),
               {"case.toml:14: body.projectile.material: unknown material \"Al2024-T531\"; did you mean 'Al2024-T351'", "OFHC-Cu"});
  expect_parts(error("shape = \"sphere\"                # sphere | cylinder | plate | box | mesh (file = ...)\ndiameter = \"4 mm\"",
                     "shape = \"mesh\"\nfile = \"none.k\""), {"case.toml:11: body.projectile.file: there is no file", "none.k"});
  expect_parts(error("fidelity = \"standard\"", "fidelity = \"standard\"\nelements_across = 24"), {"case.toml:6: run.elements_across: fidelity is given too"});
}

TEST_F(CaseFile, ReferencesThatDoNotFit) {
  expect_parts(error("\"7.8 mm\"", "\"7.8 deg\""), {"case.toml:31: reference.\"bumper.hole_diameter\".value: '7.8 deg' is an angle, but a length"});
  expect_parts(error("\"bumper.hole", "\"bumpr.hole"), {"case.toml:31", "no body 'bumpr'; did you mean 'bumper'"});
  expect_parts(error("", "\"bumper.rim_displacement\" = \"3 kg\"\n"), {"case.toml:32", "'3 kg' is a mass, but a length"});
  expect_parts(error("", "\"cloud.kinetic_energy\" = \"3 mm\"\n"), {"case.toml:32", "'3 mm' is a length, but an energy"});
  expect_parts(error("\"bumper.hole_diameter\" =", "bumper.hole_diameter ="), {"case.toml:31", "in quotes: \"bumper.hole_diameter\""});
}

TEST_F(CaseFile, MaterialsOfTheCaseThatDoNotFit) {
  expect_parts(error("", "[materials.x]\nbase = \"Al2042-T351\"\n"), {"case.toml:33: materials.x.base: unknown material 'Al2042-T351'; did you mean 'Al2024-T351'"});
  expect_parts(error("", "[materials.x]\nbase = \"Be\"\nrho_0 = 0\n"), {"case.toml:34: materials.x.rho_0", "greater than 0"});
}

TEST_F(CaseFile, FilesThatAreNoCase) {
  expect_parts(error("end = ", "end "), {"case.toml:4: this is no valid TOML"});
  expect_parts(error_of("[project]\nname = \"x\"\n"), {"case.toml: this is TOML, but no case"});
  expect_parts(error_of("\x89PNG\r\n\x1a\n\x00\x01"), {"case.toml:1: this is no valid TOML"});
  expect_parts(error_of(""), {"no case"});
  EXPECT_THROW(io::read_case((dir_ / "absent.toml").string()), core::CaseError);
  const fs::path folder = dir_ / "folder";
  fs::create_directory(folder);
  try {
    io::read_case(folder.string());
    FAIL();
  } catch (const core::CaseError& e) {
    expect_parts(e.what(), {"folder", "without a case.toml"});
  }
}

TEST_F(CaseFile, FolderStandsForItsCase) {
  write(contract);
  EXPECT_EQ(io::read_case(dir_.string()).bodies.size(), 2u);
}

TEST_F(CaseFile, MeshFileIsRelativeToTheCase) {
  std::ofstream(dir_ / "ball.k") << "*KEYWORD\n*END\n";
  const io::Case c = read("[run]\nend = 1\n[[body]]\nname = \"m\"\nshape = \"mesh\"\nfile = \"ball.k\"\nmaterial = \"Be\"\n");
  EXPECT_EQ(c.bodies[0].file, fs::absolute(dir_ / "ball.k").string());
  EXPECT_EQ(read(io::write_case(c)).bodies[0].file, c.bodies[0].file);
}

TEST_F(CaseFile, ReadingWritesNothing) {
  write(contract);
  const auto stamp = fs::last_write_time(file());
  io::read_case(file());
  EXPECT_EQ(fs::last_write_time(file()), stamp);
  EXPECT_EQ(std::distance(fs::directory_iterator(dir_), fs::directory_iterator()), 1);
}

}  // namespace
