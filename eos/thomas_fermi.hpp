// SPDX-License-Identifier: Apache-2.0
// Electrons of an atom in a spherical cell after Thomas and Fermi at finite temperature: Feynman, Metropolis & Teller, Phys.
// Rev. 75 (1949) 1561; Latter, Phys. Rev. 99 (1955) 1854. In atomic units, with eta = (mu + V)/T and psi = r T eta,
//   psi'' = 4 pi r n,   n = (sqrt(2)/pi^2) T^(3/2) I_1/2(eta),   psi(0) = Z,   psi'(R) = psi(R)/R
//   p = (2 sqrt(2)/(3 pi^2)) T^(5/2) I_3/2(eta(R)),   K = integral of (sqrt(2)/pi^2) T^(5/2) I_3/2
//   E = 3 p V - K (virial theorem),   T S = 5/3 K - integral of n T eta.
// No exchange, no shells.
#pragma once

#include <vector>

namespace eos {

/// Per atom, in atomic units (hartree, bohr, hartree/k).
struct ThomasFermiCell {
  double p;  ///< pressure
  double e;  ///< energy, zero with everything at rest at infinity
  double f;  ///< Helmholtz energy
};

/// Z > 0; R cell radius [bohr]; T > 0 [hartree/k]; T = 1e-5 stands for absolute zero.
ThomasFermiCell thomas_fermi(double Z, double R, double T);

/// I_1/2 and I_3/2, I_k(eta) = integral over x from 0 of x^k/(1 + exp(x - eta)).
struct FermiIntegrals {
  double half, three_halves;
};
FermiIntegrals fermi_integrals(double eta);

/// The part of the electrons' free energy that heat adds, F(rho, T) - F(rho, 0), by splines through cells computed
/// once over densities and temperatures: p and e are exact derivatives of one function.
class ElectronHeat {
 public:
  /// Z; A [g/mol]; range of densities [kg/m3].
  ElectronHeat(double Z, double A, double rho_min, double rho_max);

  struct Value {
    double f, e, p;  ///< [J/kg] [J/kg] [Pa]
  };
  Value operator()(double rho, double T) const;

  /// Pressure of the same model at absolute zero [Pa].
  double cold_pressure(double rho) const;

 private:
  double Z_, A_, ln_rho_min_;
  std::vector<std::vector<double>> ln_f_, curvature_;  ///< [density][temperature] of ln(-F)
};

}  // namespace eos
