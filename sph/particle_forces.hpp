// SPDX-License-Identifier: Apache-2.0
// Pair forces of updated-Lagrangian SPH with corrected kernel gradients, in the form that follows from the corrected
// velocity gradient, so that momentum and energy close pair by pair:
//   B_i  = [ sum_j V_j (x_j - x_i) (x) grad_i W_ij ]^-1                         Randles & Libersky, CMAME 139 (1996) 375
//   L_i  = [ sum_j V_j (v_j - v_i) (x) grad_i W_ij ] B_i
//   f_ij = V_i V_j (sigma_i B_i^T + sigma_j B_j^T) grad_i W_ij - m_i m_j Pi_ij grad_i W_ij = -f_ji
//   dE_i = -dt sum_j [ V_i V_j sigma_i B_i^T grad_i W_ij - m_i m_j Pi_ij grad_i W_ij / 2 ] . (v_mean_i - v_mean_j)
// W_ij is taken at the mean h. Pi_ij: Monaghan, Annu. Rev. Astron. Astrophys. 30 (1992) 543, eqs 4.1-4.2, with the shear
// switch of Balsara, J. Comput. Phys. 121 (1995) 357. Artificial stress against the tensile instability: Gray, Monaghan &
// Swift, CMAME 190 (2001) 6641, eqs 3.12-3.16. Between particles that bear shear, with D the strain rate of the last step, a
// pair's approach is split into what D explains and the rest: the linear viscosity leaves out the first, limited as in
// Frontiere, Raskin & Owen, J. Comput. Phys. 332 (2017) 160, and motion that no D explains (hourglass modes, which bear no
// stress, tear solids and spread bars) is damped whether it approaches or recedes; that penalty on the non-affine part as in
// Ganzenmueller, CMAME 286 (2015) 87, here as a viscosity. Pairs of different bodies push and never pull: both stresses are replaced
// by -max(-n.sigma n, 0), n towards the strangers near, a foreigner's by -max(p, 0), and B by 1, in force, work and L alike (in L not
// towards images behind rigid walls, which complete the lattice). Where stranger i bears more than j by over what their approach makes, Z u (Z: mean
// of both rho c, u: speed of approach), the part 1 - Z u / (p_i - p_j) of their approach strains j in place of i, and that part of i's work
// goes to j: what divides two bodies moves (Godunov, Mat. Sb. 47 (1959) 271). Where a
// particle has too few neighbours for B_i, the plain gradient takes over smoothly. Between a particle and a foreigner of its own body,
// sigma_j B_j is the particle's too (coupling/bond.hpp), and where the anchors a that take the force do not move as the pair's middle,
// (x_i + x_j)/2, would by the velocity gradient L_a of the elements round them, the particle is strained by that as well:
//   L_i += sum_j V_j [2 v_a - v_i - v_j - L_a (2 x_a - x_i - x_j)] (x) grad_i W_ij B_i
#pragma once

#include "sph/neighbourhood.hpp"
#include "sph/particles.hpp"

namespace sph {

struct ParticleSettings {
  double viscosity_linear = 1.0;     ///< alpha [-]
  double viscosity_quadratic = 2.0;  ///< beta [-]
  double artificial_stress = 0.3;    ///< epsilon of Gray et al., between particles [-]
  double hourglass = 1.5;            ///< xi: viscosity of motion that the velocity gradients do not see [-]
};

/// Sets hood.unit and fills the particles' rows of hood.actors from the particles: everything but stress, push and motion.
void fill_actors(const Particles& particles, const std::vector<double>& rho_0, Neighbourhood& hood);

/// Gradient corrections, then sigma B^T, artificial stress and what strangers are pushed with of every particle into its actor.
void correct_gradients(const Particles& particles, const ParticleSettings& settings, Neighbourhood& hood,
                       std::vector<core::Mat3>& correction);

/// particles.f and hood.anchor_force of time n.
void add_pair_forces(const ParticleSettings& settings, Neighbourhood& hood, Particles& particles);

/// Work of the same forces with the mean velocities into the particles' energy, what it leaves to others into hood.foreign_power,
/// and the velocity gradient at mid-step of every particle [1/s].
void pair_work(const ParticleSettings& settings, const std::vector<double>& rho_0, double dt_kick, double dt_drift,
               const std::vector<core::Mat3>& correction, Neighbourhood& hood, Particles& particles,
               std::vector<core::Mat3>& velocity_gradient);

/// Kernel sums' pairs gone through since the start are counted by the caller: this is one pass's number.
std::uint64_t n_pairs(const Neighbourhood& hood);

}  // namespace sph
