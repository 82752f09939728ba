// SPDX-License-Identifier: Apache-2.0
// Files of SESAME tables in ASCII. Records and units: Lyon & Johnson, SESAME: The Los Alamos National Laboratory Equation of
// State Database, LA-UR-92-3407 (1992). Two layouts are read:
//   cards    Los Alamos' own (Sesame ASCII File Format, LA-UR-19-24891 (2019)): before each record a line with file number,
//            material, record and word count (dates follow); words five a line in fields of 15 (or 22) characters;
//   headed   M-ANEOS' (DOI 10.5281/zenodo.3525030): "INDEX MATID = 1 NWDS = 9", then "RECORD TYPE = 301 NWDS = 51279"
//            before each record; five a line in fields of 16.
// Fields are cut by column, because negative numbers leave no blank between them. Records that are not named below are
// passed over. Files hold Mg/m3, K, GPa, MJ/kg; the structs hold SI.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace eos {

/// Record 301 (total), 303 (ions and cold curve), 304 (electrons), 305 (ions) or 306 (cold curve).
struct SesameGrid {
  std::vector<double> rho;  ///< rising [kg/m3]; a value may stand twice
  std::vector<double> T;    ///< rising [K]; a value may stand twice
  std::vector<double> p;    ///< [T][rho] [Pa]
  std::vector<double> e;    ///< [T][rho] [J/kg]
  std::vector<double> f;    ///< Helmholtz energy [T][rho] [J/kg]; empty where the file has none
};

/// Record 401, one entry a temperature.
struct SesameVapour {
  std::vector<double> p, T, rho_vapour, rho_liquid, e_vapour, e_liquid, f_vapour, f_liquid;  ///< [Pa] [K] [kg/m3] [J/kg]
};

struct SesameMaterial {
  int number = 0;
  double Z = 0, A = 0;                 ///< record 201: mean atomic number, mean atomic mass [g/mol]
  double rho_0 = 0;                    ///< record 201: normal density [kg/m3]
  double bulk_modulus = 0;             ///< record 201 [Pa]; some files hold another unit here, so nothing relies on it
  std::map<int, SesameGrid> grids;     ///< by record
  std::optional<SesameVapour> vapour;
};

/// Material `number` of a file. Throws core::CaseError with file, line, material and what would be valid.
SesameMaterial read_sesame(const std::string& path, int number);

/// The total: record 301, or the sum of 303 + 304 or of 304 + 305 + 306 where there is no 301.
SesameGrid total(const SesameMaterial& m, const std::string& path);

/// The material as cards.
std::string sesame_text(const SesameMaterial& m);

}  // namespace eos
