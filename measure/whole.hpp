// SPDX-License-Identifier: Apache-2.0
// The matter of the whole scene and how it hangs together: the faces of its elements, the bonds of its particles, and
// which of it still belongs to its plate. Every family of measurements starts from here.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "measure/matter.hpp"

namespace measure {

/// The speeds, as parts of the impact speed, that decide what belongs to what.
constexpr double settled_speed = 0.01;  ///< a plate's settled material is slower (relative to the plate's rim)
constexpr double bond_speed = 0.01;     ///< two points of one piece part more slowly
constexpr double loose_speed = 0.05;    ///< material faster than this is debris even where it still touches its plate
/// Elements of a plate that bends are settled up to loose_speed, or this where it is more [m/s].
constexpr double bending_speed = 100;

/// The matter with its mirror images: elements of all copies first, then particles. Nodes on a symmetry plane are shared.
Matter mirrored(Matter part, const core::Symmetry& symmetry);

/// A face of an element; `b` is the element on its other side, -1 where there is none. Corners go round.
struct Face {
  std::array<std::int32_t, 4> node;
  std::int32_t a, b;
};
/// The faces of elements for which wanted(face), each once.
std::vector<Face> faces_where(const Matter& matter, const std::function<bool(const Face&)>& wanted);

/// Two rows of which one at least is a particle, close to each other and parting slowly.
struct Bond {
  std::uint32_t i, j;
};
/// Particles closer than 1.5 x the mean of their spacings, and particles closer to the surface of an element than their
/// own spacing; relative speed below `speed_limit` [m/s]. A spacing counts at no less than half the reference density.
std::vector<Bond> all_bonds(const Matter& matter, const Scene& scene, double speed_limit);

/// Spacing of a row that decides about bonds: cbrt(m / max(rho, rho_0 / 2)) [m].
double bond_spacing(const Matter& matter, const Scene& scene, std::size_t row);

/// A plate's own frame: origin at the middle as built, or where it would have flown by now, third axis its normal, towards where the projectile comes from.
struct PlateFrame {
  core::Vec3 origin;
  core::Mat3 axes;           ///< rows are the axes
  double thickness = 0;      ///< [m]
  core::Vec3 half{0, 0, 0};  ///< half edges in the plane, half thickness [m]
  core::Vec3 local(const core::Vec3& x) const { return axes * (x - origin); }
  /// 1 at the plate's edge, 0 in its middle.
  double rim(const core::Vec3& local_x) const {
    return std::max(std::abs(local_x.x()) / half.x(), std::abs(local_x.y()) / half.y());
  }
};
PlateFrame plate_frame(const Scene& scene, int body);

/// What a plate's outer rim, which the impact has hardly reached, does as a whole.
struct Rim {
  bool exists = false;
  core::Vec3 velocity{0, 0, 0};  ///< [m/s]
  double displacement = 0;       ///< along the normal [m]
};

struct Whole {
  Matter matter;
  std::vector<Face> faces;           ///< bounding_faces(), where surfaces are read
  std::vector<Bond> bonds;
  std::vector<int> plates;           ///< bodies that are plates: those of the scene in order, then any others
  std::vector<Rim> rims;             ///< one a body
  std::vector<char> joined;          ///< connected to its plate's rim, at whatever speed
  std::vector<char> sound;           ///< the same through what has not failed to powder
  std::vector<char> held;            ///< joined: all elements, and particles slower than loose_speed
  std::vector<char> settled;         ///< connected to its plate's rim through material slower than settled_speed
  std::vector<char> debris;          ///< detached from every plate, or joined and faster than loose_speed
  double impact_speed = 0;           ///< [m/s]
  core::Vec3 flight{0, 0, -1};       ///< direction of the projectile's line of flight

  std::size_t size() const { return matter.x.size(); }
  bool is_element(std::size_t row) const { return row < matter.n_elements; }
};
/// All but the faces.
Whole make_whole(Matter part, const Scene& scene);
/// Faces of plates; without those between two settled elements, most of all, which bound nothing.
std::vector<Face> bounding_faces(const Whole& whole);

/// Connected pieces of the rows in `mask`: piece[row] is the lowest row of its piece, -1 outside the mask. Bonds between
/// bodies count only with `across_bodies`.
std::vector<std::int64_t> connected_pieces(const Whole& whole, std::span<const char> mask, bool across_bodies);

}  // namespace measure
