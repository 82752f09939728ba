// SPDX-License-Identifier: Apache-2.0
// Tables made from closed forms, so that every value has one to be compared with: a Grueneisen solid
//   p = K/n (eta^n - 1) + G rho cv T,   e = integral of the cold pressure + cv T,   and one with a two-phase plateau.
#include "eos/sesame.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>

#include "core/error.hpp"
#include "eos/hugoniot.hpp"

namespace {

constexpr double rho_n = 2700, K = 76e9, n = 4, G = 2, cv = 900;

double cold_p(double eta) { return K / n * (std::pow(eta, n) - 1); }
/// Integral of p/(rho_n eta^2) from 1.
double cold_e(double eta) { return K / (n * rho_n) * ((std::pow(eta, n - 1) - 1) / (n - 1) + 1 / eta - 1); }

eos::SesameGrid solid() {
  eos::SesameGrid g;
  for (double eta = 0.01; eta < 0.6; eta *= 1.1) g.rho.push_back(eta * rho_n);
  for (double eta = 0.6; eta < 4; eta += 0.01) g.rho.push_back(eta * rho_n);
  for (double T = 10; T < 2e5; T *= 1.15) g.T.push_back(T);
  for (const double T : g.T)
    for (const double rho : g.rho) {
      g.p.push_back(cold_p(rho / rho_n) + G * rho * cv * T);
      g.e.push_back(cold_e(rho / rho_n) + cv * T);
    }
  return g;
}

/// The solid, but pressure nowhere below a vapour pressure of 1e5 Pa.
eos::SesameGrid plateau() {
  eos::SesameGrid g = solid();
  for (double& p : g.p) p = std::max(p, 1e5);
  return g;
}

eos::Sesame model(const eos::SesameGrid& g) {
  eos::Sesame m;
  m.file = "test", m.number = 1, m.T_0 = 300;
  m.table = std::make_shared<const eos::SesameTable>(eos::invert(g, rho_n, "test"));
  eos::prepare(m);
  return m;
}

class Folder {
 public:
  Folder() : path_(std::filesystem::temp_directory_path() / ("sesame_test_" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(path_);
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  std::string write(const std::string& text) const {
    const auto file = path_ / "t.ses";
    std::ofstream(file) << text;
    return file.string();
  }

 private:
  std::filesystem::path path_;
};

std::string message(const std::string& file, int number) {
  try {
    eos::read_sesame(file, number);
  } catch (const core::CaseError& e) {
    return e.what();
  }
  return "";
}

// Two densities, two temperatures; cards as Los Alamos punches them: negative numbers touch, three digits drop the E.
const char* const cards =
    " 0  3717   101    93   r 82803 22704   1\n"
    "material. comment that fills a whole card of eighty characters, as these files do ...\n"
    "and goes on\n"
    " 1  3717   201     5   r 82803 22704   1\n"
    " 1.30000000E+01 2.69815386E+01 2.70000000E+00 7.60000000E+01 0.00000000E+0011111\n"
    " 1  3717   301    14   r 82803 22704   1\n"
    " 2.00000000E+00 2.00000000E+00 1.00000000E+00 2.70000000E+00 0.00000000E+0011111\n"
    " 3.00000000E+02-1.50000000E+00-2.50000000E-01 4.00000000E+00 1.00000000-10011111\n"
    "-1.00000000E-01-2.00000000E-01 3.00000000E-01 4.00000000E-01                11110\n"
    " 1  4270   201     5   r 82803 22704   1\n"
    " 2.90000000E+01 6.35460000E+01 8.93000000E+00 1.40000000E+02 0.00000000E+0011111\n"
    " 2\n";

const char* const headed =
    " INDEX     MATID = 900013   NWDS =        9\n"
    "  9.00013000E+05  2.01122000E+05  2.01122000E+05  1.00000000E+00  2.00000000E+00\n"
    "  2.01000000E+02  3.01000000E+02  5.00000000E+00  5.12790000E+04\n"
    " RECORD     TYPE =  201     NWDS =        5\n"
    "  1.30000000E+01  2.69800000E+01  2.70000000E+00  7.73000000E+11  2.98000000E+02\n"
    " RECORD     TYPE =  301     NWDS =       14\n"
    "  2.00000000E+00  2.00000000E+00  1.00000000E+00  2.70000000E+00  0.00000000E+00\n"
    "  3.00000000E+02 -1.50000000E+00 -2.50000000E-01  4.00000000E+00  5.00000000E+00\n"
    " -1.00000000E-01 -2.00000000E-01  3.00000000E-01  4.00000000E-01\n";

void expect_small_table(const eos::SesameMaterial& m, double last_p) {
  EXPECT_EQ(m.Z, 13);
  EXPECT_NEAR(m.rho_0, 2700, 1e-9);
  const auto& g = m.grids.at(301);
  ASSERT_EQ(g.rho.size(), 2u);
  EXPECT_NEAR(g.rho[1], 2700, 1e-9);   // Mg/m3
  EXPECT_EQ(g.T[1], 300);
  EXPECT_NEAR(g.p[0], -1.5e9, 1);      // GPa
  EXPECT_NEAR(g.p[2], 4e9, 1);
  EXPECT_NEAR(g.p[3], last_p, 1);
  EXPECT_NEAR(g.e[1], -2e5, 1e-3);     // MJ/kg
  EXPECT_TRUE(g.f.empty());
}

}  // namespace

TEST(SesameFile, ReadsCards) {
  const Folder f;
  const auto m = eos::read_sesame(f.write(cards), 3717);
  expect_small_table(m, 0);
  EXPECT_NEAR(m.bulk_modulus, 76e9, 1);
}

TEST(SesameFile, ReadsHeadedRecords) {
  const Folder f;
  expect_small_table(eos::read_sesame(f.write(headed), 900013), 5e9);
}

TEST(SesameFile, ErrorsSayWhereAndWhatIsValid) {
  const Folder f;
  EXPECT_NE(message("/nowhere/x.ses", 1).find("/nowhere/x.ses"), std::string::npos);
  EXPECT_NE(message(f.write(cards), 5).find("material 5: is not in the file; valid: 3717, 4270"), std::string::npos);
  EXPECT_NE(message(f.write(cards), 4270).find("301, 303, 304, 305, 306"), std::string::npos);
  std::string text = cards;
  const std::string number = " 3.00000000E+02-1.5";
  text.replace(text.find(number), number.size(), " 3.0000000xE+02-1.5");
  EXPECT_NE(message(f.write(text), 3717).find("t.ses:8: material 3717, record 301"), std::string::npos) << message(f.write(text), 3717);
  text = headed;
  text.resize(text.rfind(" -1.0000"));
  EXPECT_NE(message(f.write(text), 900013).find("ends after 10 of 14 words"), std::string::npos);
  text = headed;
  text.replace(text.find("1.00000000E+00  2.70"), 14, "9.00000000E+00");
  EXPECT_NE(message(f.write(text), 900013).find("density number 2"), std::string::npos);
  for (const char* count : {"999999999999999999999", "1000000001"}) {
    text = headed;
    text.replace(text.find("NWDS =       14") + 7, 8, count);
    EXPECT_NE(message(f.write(text), 900013).find("from 1 to 1000000000"), std::string::npos) << count;
  }
  text = headed;
  text.replace(text.find("NWDS =       14") + 7, 8, "999999999");  // takes no memory that the file does not fill
  EXPECT_NE(message(f.write(text), 900013).find("word 15 of 999999999 is missing"), std::string::npos);
}

TEST(SesameFile, ReadsFilesThatWereJoined) {
  const Folder f;
  expect_small_table(eos::read_sesame(f.write(std::string(" 0  4270   201     5   r\n 2.90000000E+01 6.35460000E+01 8.93000000E+00 1.40000000E+02 "
                                                          "0.00000000E+0011111\n 2\n") + cards), 3717), 0);
  std::string many;
  for (int k = 0; k < 200000; ++k) many += " 2\n";
  expect_small_table(eos::read_sesame(f.write(many + cards), 3717), 0);
  EXPECT_NE(message(f.write("\x1b[2J\xff no table"), 1).find("header: \"?[2J? no table\""), std::string::npos);
}

TEST(SesameFile, SumsIonsAndElectrons) {
  const Folder f;
  std::string text = cards;
  const std::string block = text.substr(text.find(" 1  3717   301"), text.find(" 1  4270") - text.find(" 1  3717   301"));
  std::string ions = block, electrons = block;
  ions.replace(ions.find("301"), 3, "303"), electrons.replace(electrons.find("301"), 3, "304");
  text.replace(text.find(block), block.size(), ions + electrons);
  const auto m = eos::read_sesame(f.write(text), 3717);
  EXPECT_NEAR(eos::total(m, "x").p[0], -3e9, 1);
}

TEST(SesameFile, RoundTrip) {
  const Folder f;
  eos::SesameMaterial m;
  m.number = 42, m.Z = 13, m.A = 27, m.rho_0 = rho_n;
  m.grids[301] = solid();
  m.vapour = eos::SesameVapour{{1e5}, {2000}, {0.1}, {2300}, {1e7}, {2e6}, {1}, {2}};
  const auto back = eos::read_sesame(f.write(eos::sesame_text(m)), 42);
  const auto &a = m.grids[301], &b = back.grids.at(301);
  ASSERT_EQ(a.p.size(), b.p.size());
  for (std::size_t i = 0; i < a.p.size(); ++i) {
    EXPECT_NEAR(a.p[i], b.p[i], 1e-8 * std::abs(a.p[i]));  // nine digits
    EXPECT_NEAR(a.e[i], b.e[i], 1e-8 * std::abs(a.e[i]));
  }
  EXPECT_NEAR(back.vapour->rho_liquid[0], 2300, 1e-5);
  EXPECT_NEAR(back.vapour->e_vapour[0], 1e7, 1);
}

TEST(Sesame, RestIsWithoutPressureAndEnergy) {
  const auto m = model(solid());
  // K/n (eta^n - 1) + G rho cv T = 0 at 300 K, solved outside
  EXPECT_NEAR(m.rho_0, 2647.7061, 0.01);
  const auto s = eos::state(m, m.rho_0, 0.0);
  EXPECT_EQ(s.p, 0);  // not round-off: what rests may sleep
  EXPECT_NEAR(s.temperature, 300, 0.01);
}

TEST(Sesame, RestIsAmongTheIsotherms) {
  auto m = model(solid());
  const double coldest = m.table->source_T.front();
  m.rho_0 = 0, m.T_0 = coldest;
  eos::prepare(m);
  EXPECT_NEAR(m.e_ref, cold_e(m.rho_0 / rho_n) + cv * coldest, 1);
  for (const double T : {0.5 * coldest, 1e7}) {
    m.T_0 = T;
    EXPECT_THROW(eos::prepare(m), core::CaseError) << T;
  }
}

TEST(Sesame, WrongUnitsAreRefused) {
  for (const double p : {1e-3, 1e-2, 1e9}) {  // TPa, Mbar, Pa in place of GPa
    auto g = solid();
    for (double& x : g.p) x *= p;
    EXPECT_THROW(eos::invert(g, rho_n, "test"), core::CaseError) << p;
  }
  auto g = solid();
  for (double& x : g.e) x *= 1e6;
  EXPECT_THROW(eos::invert(g, rho_n, "test"), core::CaseError);
}

TEST(Sesame, InversionAgreesWithTheClosedForm) {
  const auto m = model(solid());
  const double e_rest = cold_e(m.rho_0 / rho_n) + cv * 300;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> u(0, 1);
  for (int i = 0; i < 2000; ++i) {
    const double eta = 0.7 + 3 * u(random), rho = eta * rho_n, T = 20 * std::pow(5000, u(random));
    const double e = cold_e(eta) + cv * T - e_rest;
    const auto s = eos::state(m, rho, e);
    const double p = cold_p(eta) + G * rho * cv * T;
    EXPECT_NEAR(s.p, p, 1e-3 * std::max(std::abs(p), 1e10)) << eta << " " << T;  // the promise: 0.1 %
    EXPECT_NEAR(s.temperature, T, 0.01 * T + 1) << eta << " " << T;
    const double c2 = K / rho_n * std::pow(eta, n - 1) + G * (G + 1) * cv * T;
    if (p > 0) {
      EXPECT_NEAR(s.c2, c2, 0.02 * c2) << eta << " " << T;
    }
  }
}

TEST(Sesame, SoundSpeedIsTheDerivativeOfPressure) {
  const auto m = model(solid());
  std::mt19937 random(6);
  std::uniform_real_distribution<double> u(0, 1);
  int compared = 0;
  for (int i = 0; i < 300; ++i) {
    const double rho = 2700 * (0.95 + u(random)), e = 2e6 * u(random) + 2e5 + cold_e(rho / rho_n), h = 1e-6 * rho;
    const auto s = eos::state(m, rho, e);
    const double de = s.p / (rho * rho) * h;
    const double ahead = eos::state(m, rho + h, e + de).p, behind = eos::state(m, rho - h, e - de).p;
    if (std::abs(ahead + behind - 2 * s.p) > 1e-5 * std::abs(ahead - behind)) continue;  // across the edge of a cell
    ++compared;
    EXPECT_NEAR(s.c2, (ahead - behind) / (2 * h), 1e-4 * s.c2);
  }
  EXPECT_GT(compared, 250);
}

TEST(Sesame, SoundSpeedBeyondTheLargestDensityIsTheDerivativeOfPressure) {
  const auto m = model(solid());
  int compared = 0;
  for (const double times : {1.05, 1.3, 2.0, 3.0})
    for (double heat = 1e6; heat < 1e8; heat *= 1.37) {
      const double rho = times * m.table->rho_max / m.scale, e = cold_e(m.table->rho_max / rho_n) + heat, h = 1e-6 * rho;
      const auto s = eos::state(m, rho, e);
      const double de = s.p / (rho * rho) * h;
      const double ahead = eos::state(m, rho + h, e + de).p, behind = eos::state(m, rho - h, e - de).p;
      if (std::abs(ahead + behind - 2 * s.p) > 1e-5 * std::abs(ahead - behind)) continue;  // across the edge of a cell
      ++compared;
      EXPECT_NEAR(s.c2, (ahead - behind) / (2 * h), 1e-4 * s.c2) << times << " " << heat;
    }
  EXPECT_GT(compared, 40);
}

TEST(Sesame, MonotoneWhereTheTableIs) {
  const auto t = eos::invert(plateau(), rho_n, "test");
  for (const double h : {1e3, 3e5, 4e6}) {  // along rows of equal thermal energy
    double before = 0;
    for (double eta = 0.02; eta < 3.9; eta *= 1.0007) {
      const double rho = eta * rho_n, cold = cold_e(eta) + cv * 10;
      const double p = eos::detail::table_state(t, rho, cold + h).p;
      EXPECT_GE(p, before * (1 - 2e-3)) << eta << " " << h;  // the cold curve of the table stands in for the exact one
      EXPECT_GE(p, 0.99e5);                                  // no undershoot below the plateau
      before = std::max(before, p);
    }
  }
}

TEST(Sesame, TwoPhasePlateauAndItsRestState) {
  const auto m = model(plateau());
  // The plateau begins at 2647.7; its corner lies within a cell of the file's grid, which is 1 % in density and 15 % in T
  // (0.3 % in density).
  EXPECT_NEAR(m.rho_0, 2647.7, 0.013 * 2647.7);
  const auto s = eos::state(m, 0.5 * m.rho_0, cold_e(0.5 * m.rho_0 / rho_n) - cold_e(m.rho_0 / rho_n));
  EXPECT_EQ(eos::state(m, m.rho_0, 0.0).p, 0);
  EXPECT_NEAR(s.p, 1e5 - 1.1e5, 1);  // rest is a little above the plateau
  EXPECT_GT(s.c2, 0);
}

TEST(Sesame, EdgesAreContinuousAndTold) {
  const auto m = model(solid());
  const double rho_max = m.table->rho_max, rho_min = m.table->rho_min;
  const double e = cold_e(rho_max / rho_n) + 1e7;
  EXPECT_NEAR(eos::state(m, rho_max * (1 + 1e-9), e).p, eos::state(m, rho_max, e).p, 1e-6 * eos::state(m, rho_max, e).p);
  EXPECT_GT(eos::state(m, 2 * rho_max, e).p, eos::state(m, rho_max, e).p);
  EXPECT_NEAR(eos::state(m, rho_min / 10, 5e7).p, eos::state(m, rho_min, 5e7).p / 10, 1e-6 * std::abs(eos::state(m, rho_min, 5e7).p));
  EXPECT_TRUE(std::isfinite(eos::state(m, 2700.0, 1e12).p));
  EXPECT_TRUE(std::isfinite(eos::state(m, 2700.0, -1e12).p));
  EXPECT_TRUE(eos::inside(m, 2700, 1e5));
  EXPECT_FALSE(eos::inside(m, 1.01 * rho_max, e));
  EXPECT_FALSE(eos::inside(m, 0.9 * rho_min, 5e7));
  EXPECT_FALSE(eos::inside(m, 2700, 1e12));
  EXPECT_FALSE(eos::inside(m, 3500, -1e6));
  EXPECT_TRUE(eos::inside(m, 0.9 * 2700, -2e5));  // a cold solid with voids
}

TEST(Sesame, AnAlloyIsTheTableScaled) {
  auto m = model(solid());
  auto alloy = m;
  alloy.rho_0 = 1.03 * m.rho_0;
  eos::prepare(alloy);
  const auto a = eos::state(m, 1.3 * m.rho_0, 2e6), b = eos::state(alloy, 1.3 * alloy.rho_0, 2e6 / 1.03);
  EXPECT_NEAR(b.p, a.p, 1e-9 * a.p);          // same compression, same energy a volume
  EXPECT_NEAR(b.c2, a.c2 / 1.03, 1e-9 * a.c2);
  EXPECT_NEAR(b.temperature, a.temperature, 1e-6);
  alloy.rho_0 = 1.2 * m.rho_0;
  EXPECT_THROW(eos::prepare(alloy), core::CaseError);
}

TEST(Sesame, LanesGiveTheBitsOfSinglePoints) {
  const auto m = model(plateau());
  std::mt19937 random(7);
  std::uniform_real_distribution<double> u(0, 1);
  for (int i = 0; i < 500; ++i) {
    alignas(64) double rho[8], e[8];
    for (int l = 0; l < 8; ++l) rho[l] = 2700 * std::exp(-6 + 8 * u(random)), e[l] = -1e6 + std::pow(10, 9.5 * u(random));
    const auto s = eos::state(m, core::load<core::Pack<8>>(rho), core::load<core::Pack<8>>(e));
    for (int l = 0; l < 8; ++l) {
      const auto one = eos::state(m, rho[l], e[l]);
      EXPECT_EQ(one.p, s.p[l]);
      EXPECT_EQ(one.c2, s.c2[l]);
      EXPECT_EQ(one.temperature, s.temperature[l]);
      EXPECT_GT(one.c2, 0);
    }
  }
}

// An aluminium made by another program (EJECTA_SHARED/data/eos, see README there) and the Hugoniot that it printed itself.
TEST(Sesame, HugoniotOfAnIndependentTable) {
  const std::string folder = std::string(EJECTA_SHARED) + "/data/eos/";
  std::ifstream rows(folder + "aluminium_aneos_hugoniot.csv");
  if (!rows) GTEST_SKIP() << "no reference data in " << folder;
  eos::Sesame m;
  m.file = folder + "aluminium_aneos_sesame.txt", m.number = 900013, m.T_0 = 298;
  eos::prepare(m);
  EXPECT_NEAR(m.rho_0, 2700, 0.5);
  std::string line;
  std::getline(rows, line);
  int compared = 0;
  while (std::getline(rows, line)) {
    double rho, T, p, e, Us, up;
    ASSERT_EQ(std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf,%lf,%lf", &rho, &T, &p, &e, &Us, &up), 6);
    if (up < 0.2 || up > 12) continue;
    const auto h = eos::hugoniot(m, m.rho_0, up * 1e3);
    ++compared;
    EXPECT_NEAR(h.p * 1e-9, p, 1e-3 * p) << up;  // the promise: 0.1 %
    EXPECT_NEAR(h.rho, rho, 1e-3 * rho) << up;
    EXPECT_NEAR(h.temperature, T, 0.02 * T) << up;  // melting is spread over a cell
  }
  EXPECT_GT(compared, 40);
}
