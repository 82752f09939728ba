// SPDX-License-Identifier: Apache-2.0
// Materials: the library is complete and sane, a case's materials inherit group by group, and wrong ones are refused.
// Values of Al2024-T351 are those of reference data, Johnson & Holmquist (1989) and Marsh (1980).
#include "io/material_file.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "io/atomic_file.hpp"
#include "tests/io/temporary_folder.hpp"

namespace {

using io::toml_reader::Node;

/// The material `name` of a case whose text holds [materials...] tables.
material::Material find_in(const std::string& text, const std::string& name) {
  const Node root = io::toml_reader::parse_text(text, "case.toml");
  return io::Materials(root.find("materials")).find(name);
}

std::string error_of(const std::string& text) {
  try {
    find_in(text, "x");
  } catch (const core::CaseError& e) {
    return e.what();
  }
  return "accepted";
}

void expect_parts(const std::string& message, const std::vector<std::string>& parts) {
  for (const std::string& part : parts)
    EXPECT_NE(message.find(part), std::string::npos) << "'" << part << "' is not in: " << message;
}

const std::string fluid = "[materials.x]\nrho_0 = 1000\neos = { model = \"mie_grueneisen\", c_0 = \"1480 m/s\", s_1 = 1.9, "
                          "gamma_0 = 0.28, cv = \"4.18 kJ/(kg K)\" }\n";

TEST(MaterialFile, LibraryHoldsTheNamesOfTheContract) {
  const std::vector<std::string> names = io::material_names();
  for (const char* name : {"Al2024-T351", "Al2017-T4", "Al6061-T6", "Al7075-T6", "Al2219-T87", "Al1100-O", "OFHC-Cu",
                           "Armco-Fe", "Steel-4340", "SS-304", "Ti-6Al-4V", "Be"})
    EXPECT_NE(std::find(names.begin(), names.end(), name), names.end()) << name;
}

TEST(MaterialFile, EveryMaterialOfTheLibraryReadsAndStatesSources) {
  for (const std::string& name : io::material_names()) {
    const material::Material m = io::find_material(name);
    EXPECT_EQ(m.name, name);
    EXPECT_GT(m.rho_0, 50) << name;
    EXPECT_LT(m.rho_0, 25000) << name;
    EXPECT_GE(m.constants.size(), 3u) << name;
    for (const auto& c : m.constants)
      EXPECT_TRUE(c.value == "none" || (!c.source.empty() && c.source.find(".toml") == std::string::npos)) << name << " " << c.key << ": a place is no source";
  }
}

TEST(MaterialFile, Al2024T351IsAsPublished) {
  const material::Material m = io::find_material("Al2024-T351");
  EXPECT_EQ(m.rho_0, 2785.0);
  const auto& eos = std::get<eos::MieGrueneisen>(m.eos);
  EXPECT_EQ(eos.rho_0, 2785.0);
  EXPECT_EQ(eos.c_0, 5328.0);
  EXPECT_EQ(eos.s_1, 1.338);
  EXPECT_GT(eos.x_pole, 0);  // prepared
  const auto& strength = std::get<material::JohnsonCook>(m.strength);
  EXPECT_EQ(strength.A, 265e6);
  EXPECT_EQ(strength.B, 426e6);
  EXPECT_EQ(strength.n, 0.34);
  EXPECT_EQ(strength.T_melt, 775.0);
  ASSERT_TRUE(m.damage);
  const auto A = std::find_if(m.constants.begin(), m.constants.end(), [](const auto& c) { return c.key == "strength.A"; });
  ASSERT_NE(A, m.constants.end());
  EXPECT_EQ(A->value, "265 MPa");
  EXPECT_NE(A->source.find("Johnson & Holmquist"), std::string::npos);
}

TEST(MaterialFile, NewMaterial) {
  const material::Material m = find_in(fluid, "x");
  EXPECT_EQ(m.rho_0, 1000);
  EXPECT_EQ(std::get<eos::MieGrueneisen>(m.eos).cv, 4180);
  EXPECT_EQ(std::get<eos::MieGrueneisen>(m.eos).T_0, 294);  // default
  EXPECT_TRUE(std::holds_alternative<material::NoStrength>(m.strength));
  EXPECT_FALSE(m.damage);
  EXPECT_EQ(m.spall, 1e300);
  EXPECT_EQ(m.constants[0].value, "1000 kg/m3");
  EXPECT_EQ(m.constants[0].source, "case.toml:2");
}

TEST(MaterialFile, EveryModelReads) {
  EXPECT_TRUE(std::holds_alternative<eos::IdealGas>(
      find_in("[materials.x]\nrho_0 = 1.2\neos = { model = \"ideal_gas\", gamma = 1.4, cv = 718 }\n", "x").eos));
  const material::Material p = find_in("[materials.x]\nrho_0 = 2700\neos = { model = \"polynomial\", C1 = \"76 GPa\", C4 = 2, "
                                       "cv = 884 }\nstrength = { model = \"perfectly_plastic\", G = \"27 GPa\", Y = 0 }\n", "x");
  EXPECT_EQ(std::get<eos::Polynomial>(p.eos).C1, 76e9);
  EXPECT_EQ(std::get<eos::Polynomial>(p.eos).rho_0, 2700);
  EXPECT_TRUE(std::holds_alternative<eos::Tillotson>(io::find_material("Al-Tillotson").eos));
  EXPECT_TRUE(std::holds_alternative<material::SteinbergGuinan>(io::find_material("Be").strength));
  const auto iron = std::get<material::ZerilliArmstrong>(io::find_material("Armco-Fe-ZA").strength);
  EXPECT_EQ(iron.C1, 1033e6);
  EXPECT_EQ(iron.C2, 0);
  EXPECT_EQ(iron.n, 0.289);
}

TEST(MaterialFile, SingleConstantsChangeTheBase) {
  const material::Material m = find_in(
      "[materials.x]\nbase = \"Al2024-T351\"\nstrength = { A = \"300 MPa\" }\neos = { model = \"mie_grueneisen\", s_1 = 1.4, "
      "source = \"mine\" }\n", "x");
  const auto& strength = std::get<material::JohnsonCook>(m.strength);
  EXPECT_EQ(strength.A, 300e6);
  EXPECT_EQ(strength.B, 426e6);
  EXPECT_EQ(std::get<eos::MieGrueneisen>(m.eos).s_1, 1.4);
  EXPECT_EQ(std::get<eos::MieGrueneisen>(m.eos).c_0, 5328);
  EXPECT_TRUE(m.damage);
  EXPECT_EQ(m.spall, 1.2e9);
  for (const auto& c : m.constants) {
    if (c.key == "strength.A") {
      EXPECT_EQ(c.source, "case.toml:3");
    }
    if (c.key == "strength.B") {
      EXPECT_NE(c.source.find("Johnson & Holmquist"), std::string::npos);
    }
    if (c.key == "eos.s_1") {
      EXPECT_EQ(c.source, "mine");
    }
    if (c.key == "eos.c_0") {
      EXPECT_NE(c.source.find("Marsh"), std::string::npos);
    }
  }
}

TEST(MaterialFile, AnotherModelReplacesTheGroup) {
  const std::string change = "[materials.x]\nbase = \"Al2024-T351\"\nstrength = { model = \"perfectly_plastic\", G = \"27 GPa\"";
  EXPECT_EQ(std::get<material::PerfectlyPlastic>(find_in(change + ", Y = \"0.3 GPa\" }\n", "x").strength).Y, 0.3e9);
  expect_parts(error_of(change + " }\n"), {"case.toml:3: materials.x.strength.Y: is missing", "pressure"});
  EXPECT_FALSE(find_in("[materials.x]\nbase = \"Al2024-T351\"\ndamage = { model = \"none\" }\n", "x").damage);
}

TEST(MaterialFile, FractureEnergyStaysWhereOnlyTheLimitChanges) {
  const material::Material m = find_in("[materials.x]\nbase = \"Al6061-T6\"\nspall = { limit = \"2 GPa\" }\n", "x");
  EXPECT_EQ(m.spall, 2e9);
  EXPECT_EQ(m.fracture_energy, 10900);
  EXPECT_EQ(find_in("[materials.x]\nbase = \"W\"\nspall = { limit = 1, fracture_energy = \"3 J/cm2\" }\n", "x").fracture_energy, 30000);
  expect_parts(error_of("[materials.x]\nbase = \"W\"\nspall = { fracture_energy = \"-1 J/m2\" }\n"), {"case.toml:3: materials.x.spall.fracture_energy", "-1"});
  expect_parts(error_of("[materials.x]\nbase = \"W\"\nspall = { fracture_energy = \"1 J\" }\n"), {"case.toml:3: materials.x.spall.fracture_energy", "kJ/m2"});
}

TEST(MaterialFile, DensityOfTheBaseMayChange) {
  const material::Material m = find_in("[materials.x]\nbase = \"Al2024-T351\"\nrho_0 = \"2.8 g/cm3\"\n", "x");
  EXPECT_EQ(std::get<eos::MieGrueneisen>(m.eos).rho_0, 2800);
}

TEST(MaterialFile, BaseMayBeOfTheSameNameOrOfTheCase) {
  EXPECT_EQ(find_in("[materials.Be]\nbase = \"Be\"\nspall = { limit = 1 }\n", "Be").spall, 1);
  EXPECT_EQ(find_in("[materials.x]\nbase = \"y\"\n[materials.y]\nbase = \"Be\"\nrho_0 = 1800\n", "x").rho_0, 1800);
  expect_parts(error_of("[materials.x]\nbase = \"y\"\n[materials.y]\nbase = \"x\"\n"), {"case.toml:4", "comes back to itself"});
}

/// Without it D5 would be lost: T* counts from T_room to T_melt.
TEST(MaterialFile, DamageThatHeatMovesNeedsAMeltingPoint) {
  const std::string solid = fluid + "strength = { model = \"perfectly_plastic\", G = \"28 GPa\", Y = \"0.3 GPa\" }\n"
                                    "damage = { model = \"johnson_cook\", D1 = 0.1, D2 = 0.1, D3 = -1.5, D4 = 0, ";
  expect_parts(error_of(solid + "D5 = 0.5 }\n"), {"case.toml:5: materials.x.damage.T_melt: is missing", "D5 = 0.5"});
  EXPECT_EQ(find_in(solid + "D5 = 0.5, T_melt = 775 }\n", "x").damage->T_melt, 775);
  EXPECT_EQ(find_in(solid + "D5 = 0 }\n", "x").damage->D5, 0);
}

TEST(MaterialFile, WrongOnesAreRefused) {
  const std::string base = "[materials.x]\nbase = \"Al2024-T351\"\n";
  expect_parts(error_of(base + "strength = { AA = 1 }\n"), {"case.toml:3: materials.x.strength.AA: unknown key", "A, B, n, C, m"});
  expect_parts(error_of(base + "strenght = { A = 1 }\n"), {"case.toml:3", "did you mean 'strength'"});
  expect_parts(error_of(base + "eos = { model = \"mie_gruneisen\" }\n"), {"case.toml:3: materials.x.eos.model", "did you mean 'mie_grueneisen'"});
  expect_parts(error_of(base + "strength = { A = \"265 mm\" }\n"), {"case.toml:3", "strength.A", "is a length, but a pressure"});
  expect_parts(error_of(base + "strength = { A = \"-1 MPa\" }\n"), {"case.toml:3", "at least 0"});
  expect_parts(error_of(base + "strength = { n = -0.1 }\n"), {"strength.n", "at least 0"});
  expect_parts(error_of(base + "strength = { T_melt = 200 }\n"), {"strength.T_melt", "above T_room"});
  expect_parts(error_of(base + "rho_0 = -1\n"), {"case.toml:3: materials.x.rho_0", "greater than 0"});
  expect_parts(error_of(base + "eos = { c_0 = 0 }\n"), {"eos.c_0", "greater than 0"});
  expect_parts(error_of(base + "eos = { rho_0 = 2700 }\n"), {"eos.rho_0", "under pressure"});
  expect_parts(error_of(base + "phase = { e_melt = \"9 MJ/kg\" }\n"), {"phase", "must rise"});
  expect_parts(error_of(base + "eos = 5\n"), {"case.toml:3: materials.x.eos", "must be a table"});
  expect_parts(error_of("[materials.x]\nrho_0 = 1\n"), {"case.toml:1: materials.x.eos: is missing"});
  expect_parts(error_of("[materials]\nx = 3\n"), {"case.toml:2", "must be a table"});
  expect_parts(error_of(fluid + "strength = { G = 1 }\n"), {"strength.model: is missing; one of none"});
}

TEST(MaterialFile, NoDamageHasNoConstants) {
  const std::string base = "[materials.x]\nbase = \"Al2024-T351\"\n";
  EXPECT_EQ(error_of(base + "damage = { model = \"none\", note = \"as in the paper\" }\n"), "accepted");
  expect_parts(error_of(base + "damage = { model = \"none\", D1 = 0.3 }\n"), {"case.toml:3: materials.x.damage.D1: unknown key"});
}

TEST(MaterialFile, PhaseEnergiesThatAreMissingAreNamed) {
  expect_parts(error_of(fluid + "phase = { e_vapour = \"1 MJ/kg\" }\n"), {"materials.x.phase: e_melted is missing; e_vapour needs it"});
}

TEST(MaterialFile, UnknownNameHasSuggestions) {
  try {
    io::find_material("Al2024-T35");
    FAIL();
  } catch (const core::CaseError& e) {
    expect_parts(e.what(), {"unknown material 'Al2024-T35'; did you mean 'Al2024-T351'", "known: "});
  }
}

TEST(MaterialFile, WrittenMaterialReadsBackToTheSame) {
  for (const std::string& name : io::material_names()) {
    const std::string once = io::write_material(io::find_material(name));
    const material::Material back = find_in(once, name);
    EXPECT_EQ(io::write_material(back), once) << name;
    EXPECT_EQ(back.rho_0, io::find_material(name).rho_0);
  }
}

TEST(MaterialFile, TableIsFoundBesideTheCaseAndWrittenWithItsFullPath) {
  const test::TemporaryFolder folder;
  eos::SesameGrid g;  // p = K (rho/rho_n - 1) + 2 rho cv T, e = its cold work + cv T
  for (double eta = 0.1; eta < 3; eta += 0.05) g.rho.push_back(eta * 2700);
  for (double T = 10; T < 1e4; T *= 1.5) g.T.push_back(T);
  for (const double T : g.T)
    for (const double rho : g.rho) {
      const double eta = rho / 2700;
      g.p.push_back(76e9 * (eta - 1) + 2 * rho * 900 * T);
      g.e.push_back(76e9 / 2700 * (std::log(eta) + 1 / eta - 1) + 900 * T);
    }
  eos::SesameMaterial source;
  source.number = 7, source.Z = 13, source.A = 27, source.rho_0 = 2700;
  source.grids[301] = g;
  io::write_atomically(folder / "al.ses", eos::sesame_text(source));
  const std::string text = "[materials.x]\nrho_0 = 2660\neos = { model = \"sesame\", file = \"al.ses\", number = 7, T_0 = \"300 K\" }\n";
  const Node root = io::toml_reader::parse_text(text, "case.toml");
  const auto m = io::Materials(root.find("materials"), folder.path.string()).find("x");
  const auto& s = std::get<eos::Sesame>(m.eos);
  EXPECT_EQ(s.file, folder / "al.ses");
  EXPECT_EQ(s.T_0, 300);
  EXPECT_NEAR(eos::state(m.eos, 2660.0, 0.0).p, 0, 1e6);
  // written out, it is found from anywhere
  const Node again = io::toml_reader::parse_text(io::write_material(m), "written.toml");
  const auto back = std::get<eos::Sesame>(io::Materials(again.find("materials"), "/elsewhere").find("x").eos);
  EXPECT_EQ(back.file, s.file);
  EXPECT_EQ(back.number, 7);
  EXPECT_EQ(eos::state(back, 3000.0, 1e6).p, eos::state(s, 3000.0, 1e6).p);
}

TEST(MaterialFile, TableInAFolderThatACaseCannotNameIsRefused) {  // case.toml would hold its path and not be read again
  const Node root = io::toml_reader::parse_text("[materials.x]\neos = { model = \"sesame\", file = \"al.ses\" }\n", "case.toml");
  try {
    io::Materials(root.find("materials"), "/tmp/\xff");
    FAIL();
  } catch (const core::CaseError& e) {
    expect_parts(e.what(), {"case.toml:2: materials.x.eos.file", "UTF-8"});
  }
}

TEST(MaterialFile, TableThatIsNotThereIsNamed) {
  expect_parts(error_of("[materials.x]\nrho_0 = 2700\neos = { model = \"sesame\", file = \"no.ses\", number = 7 }\n"),
               {"case.toml:3", "materials.x.eos.file", "there is no file", "no.ses"});
  expect_parts(error_of("[materials.x]\nrho_0 = 2700\neos = { model = \"sesame\", number = 7 }\n"), {"case.toml:3", "file"});
}

}  // namespace
