// SPDX-License-Identifier: Apache-2.0
// A wide-range equation of state of a metal from free energies, after QEOS: More, Warren, Young & Zimmerman, Phys. Fluids 31
// (1988) 3059, with the changes marked *:
//   F(rho, T) = E_c(rho) + F_ion + F_el
// Ions: Debye solid with theta(rho), d ln theta/d ln rho = gamma; from T_m(rho) on Cowan's fluid (their section III),
//   F = (kT/m) [-11/2 + 9/2 w^(1/3) + 3/2 ln(theta^2/(T T_m))],  w = T_m/T,   T_m by Lindemann: d ln T_m/d ln rho = 2 gamma - 2/3,
//   * with the entropy of fusion, - S_m (T - T_m), so that melting takes heat,
//   * and in the vapour an entropy such that the liquid boils at T_boil at 1e5 Pa: it stands for what Cowan's fluid lacks of
//     the ideal gas' entropy, less the ionisation that Thomas-Fermi, which has no shells, overrates there.
//   * gamma = 2/3 + (gamma_0 - 2/3) rho_0/rho in compression, with the same slope and curving back in expansion.
// Electrons: Thomas-Fermi, the heated part (eos/thomas_fermi.hpp).
// Cold curve: * in compression integrated so that the principal Hugoniot is the measured Us = c_0 + s up, to up_fit; from
//   there on it passes over to the Thomas-Fermi one at 30 rho_0, cubic in ln p(ln rho); in expansion p_c = B (eta^m - eta^2) with
//   the modulus at rho_0 and the cohesive energy (in place of their bonding correction).
// Phases: at each temperature the equilibrium is the lower convex hull of F over volume (common tangents), solid-liquid and
//   liquid-vapour alike. * A solid may carry tension down to max_stretch of rho_0: beyond, it is two-phase matter.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "eos/sesame_file.hpp"
#include "eos/thomas_fermi.hpp"

namespace eos {

/// What the model is made from. All at 298 K and no pressure where nothing else is said.
struct Metal {
  std::string name;
  double Z, A;             ///< atomic number; atomic mass [g/mol]
  double rho_0;            ///< [kg/m3]
  double c_0, s;           ///< Us = c_0 + s up [m/s], [-]
  double up_fit;           ///< to here the Hugoniot is that line [m/s]
  double gamma_0;          ///< Grueneisen coefficient [-]
  double theta_0;          ///< Debye temperature [K]
  double E_coh;            ///< cohesive energy [J/kg]
  double T_melt;           ///< melting point [K]
  double heat_of_fusion;   ///< [J/kg]
  double T_boil;           ///< boiling point at 1e5 Pa [K]
  int number;              ///< of the table
  std::string source;
};

/// Al, Cu, Fe, Ti. Throws core::CaseError with the valid names.
const Metal& find_metal(const std::string& name);
std::vector<std::string> metal_names();

/// Energies above rest at which melting and vaporisation begin and end after release to 1e5 Pa [J/kg].
struct PhaseEnergies {
  double melt, melted, vapour, vaporised;
};

class WideRange {
 public:
  explicit WideRange(const Metal& metal);

  struct Value {
    double f, e, p;  ///< [J/kg] from the cold solid at rho_0, [J/kg] from rest (298 K), [Pa]
  };
  /// One phase at (rho, T): `solid` or fluid, whether or not it is the stable one.
  Value phase(double rho, double T, bool solid) const;
  double melting_temperature(double rho) const;  ///< above it the fluid has the lower F at that density [K]

  const PhaseEnergies& phase_energies() const { return phases_; }

  /// Records 201, 301 and 401.
  SesameMaterial table() const;

 private:
  struct Cold {
    double e, p;
  };
  struct Hull;
  Cold cold(double rho) const;
  Value ion(double rho, double T, bool solid) const;
  double thermal_pressure(double rho, double e) const;
  void calibrate_melting();
  void integrate_cold_curve();
  void calibrate_boiling();
  Hull equilibrium(double T) const;
  double density_at_rest(double T, bool solid) const;

  const Metal m_;
  double R_;                       ///< k/m of an atom [J/(kg K)]
  ElectronHeat electrons_;
  double T_m0_ = 0, S_m_ = 0;      ///< T_m(rho_0) [K], entropy of fusion at constant volume [J/(kg K)]
  double S_gas_ = 0;               ///< entropy added to the gas [J/(kg K)]
  double B_ = 0, power_ = 0, p_rest_ = 0;    ///< of the cold curve in expansion [Pa], [-], p_c(rho_0) [Pa]
  double d_eta_ = 0;
  std::vector<double> e_cold_, p_cold_;      ///< at steps of d_eta_ from 1
  double y_fit_ = 0, y_end_ = 0, ln_p_fit_ = 0, ln_p_end_ = 0, slope_fit_ = 0, slope_end_ = 0;
  double e_fit_ = 0;
  double e_rest_ = 0;
  PhaseEnergies phases_{};
};

}  // namespace eos
