// SPDX-License-Identifier: Apache-2.0
#include "coupling/contact_search.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/parallel.hpp"
#include "core/rows.hpp"
#include "fem/hex8.hpp"

namespace coupling {

using core::Box;
using core::Cells;
using core::Vec3;

constexpr double face_part = 0.05;  // faces reach this part of their size beyond their box: margin and edges
constexpr double usable = 0.8;      // part of the reach used up when lists are made anew; the rest is for what impulses add
constexpr double far_reaches = 3, apart_reaches = 12;

static bool may_strike(const ContactPoint& p, const ContactFace& f) {
  return p.body != f.body && (p.particle || std::find(f.node.begin(), f.node.end(), p.index) == f.node.end());
}

static Vec3 built_node(const ContactLists& l, std::size_t nd) { return l.origin + l.node_built[nd].cast<double>(); }
static Vec3 built_particle(const ContactLists& l, std::size_t i) { return l.origin + l.particle_built[i].cast<double>(); }
static Vec3 built(const ContactLists& l, const ContactPoint& p) {
  return p.particle ? built_particle(l, p.index) : built_node(l, p.index);
}

static core::Vec3f rounded(const ContactLists& l, const Vec3& x) { return (x - l.origin).cast<float>(); }
static void round_all(const ContactLists& l, const std::vector<Vec3>& x, std::vector<core::Vec3f>& to) {
  to.resize(x.size());
  core::for_each(x.size(), [&](std::size_t i) { to[i] = rounded(l, x[i]); });
}

static Box face_box(const ContactLists& l, const FaceNodes& node) {
  Box box;
  for (const auto nd : node) box.add(built_node(l, nd));
  return box.widened(face_part * (box.high - box.low).maxCoeff() + l.reach);
}

static ContactFace contact_face(const fem::Mesh& mesh, const fem::Face& face) { return {face, face_nodes(mesh, face), mesh.elements.body(face.element), {}}; }

static std::int32_t body_of_node(const fem::Mesh& mesh, std::size_t nd) {
  for (std::size_t b = 0; b < mesh.body_nodes.size(); ++b)
    if (mesh.body_nodes[b].contains(nd)) return static_cast<std::int32_t>(b);
  return -1;
}

/// Its row of points.
static std::uint32_t& row_of(ContactLists& l, const ContactPoint& p) { return (p.particle ? l.particle_point : l.node_point)[p.index]; }
static std::uint32_t bin_of_corner(const ContactLists& l, std::uint32_t nd) { return l.points[l.node_point[nd]].bin; }

/// A point of the list is in this bin.
static void place_point(ContactLists& l, std::uint32_t k, std::uint32_t bin) {
  ContactPoint& point = l.points[k];
  point.bin = bin;
  row_of(l, point) = k;
  l.bins[bin].points.push_back(k);
}

static void add_pair(ContactLists& l, const Candidate& pair) {
  l.candidates.push_back(pair);
  auto& place = l.faces[pair.face].paired;
  if (place != ContactFace::unpaired) return;
  place = static_cast<std::uint32_t>(l.paired.size());
  l.paired.push_back(pair.face);
}

/// f(bin) for all bins that a box touches.
template <class F>
static void each_bin(const ContactLists& l, const Box& box, F&& f) {
  const core::Cell low = l.cells.cell(box.low), high = l.cells.cell(box.high);
  double cells = 1;
  for (std::size_t d = 0; d < 3; ++d) cells *= static_cast<double>(high[d] - low[d] + 1);
  if (cells > static_cast<double>(l.cells.size())) {  // a face much larger than the bins
    for (std::uint32_t b = 0; b < l.cells.size(); ++b) {
      const core::Cell& c = l.cells[b];
      bool in = true;
      for (std::size_t d = 0; d < 3; ++d) in = in && c[d] >= low[d] && c[d] <= high[d];
      if (in) f(b);
    }
    return;
  }
  for (auto i = low[0]; i <= high[0]; ++i)
    for (auto j = low[1]; j <= high[1]; ++j)
      for (auto k = low[2]; k <= high[2]; ++k)
        if (const auto b = l.cells.find({i, j, k}); b != Cells::none) f(b);
}

static void add_face_bin(ContactBin& bin, std::uint32_t b) {
  if (std::find(bin.face_bins.begin(), bin.face_bins.end(), b) == bin.face_bins.end()) bin.face_bins.push_back(b);
}

/// From here on something may strike something in the bin. seen: [bin] scratch, all zero, and again so afterwards.
static void contest(const ContactLists& l, ContactBin& bin, std::vector<std::uint8_t>& seen) {
  bin.contested = true;
  for (const auto f : bin.faces)
    for (const auto nd : l.faces[f].node)
      if (const auto b = bin_of_corner(l, nd); !seen[b]) {
        seen[b] = 1;
        bin.face_bins.push_back(b);
      }
  for (const auto b : bin.face_bins) seen[b] = 0;
}

static void contest(const ContactLists& l, ContactBin& bin) {
  std::vector<std::uint8_t> seen(l.cells.size());
  contest(l, bin, seen);
}

// ------------------------------------------------------------------------------------------------ new lists

static void list_points(const fem::Mesh& mesh, const sph::Particles& particles, ContactLists& l) {
  l.points.clear();
  l.points.reserve(l.surface.nodes.size() + particles.size());
  std::size_t body = 0;
  for (const auto nd : l.surface.nodes) {
    while (!mesh.body_nodes[body].contains(nd)) ++body;
    if (!l.left_out[body]) l.points.push_back({nd, false, static_cast<std::int32_t>(body)});
  }
  if (mesh.n_removed > 0)  // free nodes: mass but no element alive
    for (std::uint32_t nd = 0; nd < mesh.nodes.size(); ++nd)
      if (!l.surface.faces_at[nd] && mesh.nodes.m[nd] > 0 && !fem::belongs_to_elements(mesh, nd)) l.points.push_back({nd, false, -1});
  for (std::uint32_t i = 0; i < particles.size(); ++i) l.points.push_back({i, true, -1});
}

/// Reach: about the size of a small face, or a few steps at full speed.
static void choose_reach(const fem::Mesh& mesh, const sph::Particles& particles, const std::vector<fem::Face>& faces, double dt, ContactLists& l) {
  std::vector<double> size_2(faces.size());
  core::for_each(size_2.size(), [&](std::size_t f) {
    const auto n = face_nodes(mesh, faces[f]);
    size_2[f] = 0.5 * (mesh.nodes.x[n[2]] - mesh.nodes.x[n[0]]).cross(mesh.nodes.x[n[3]] - mesh.nodes.x[n[1]]).norm();
  });
  const auto small = size_2.begin() + static_cast<std::ptrdiff_t>(size_2.size() / 4);
  std::nth_element(size_2.begin(), small, size_2.end());
  const double speed = std::sqrt(-core::min_where(l.points.size(), [&](std::size_t k) {
                                    const auto& p = l.points[k];
                                    return -(p.particle ? particles.v : mesh.nodes.v)[p.index].squaredNorm();
                                  }).value);
  constexpr double steps = 6;  // two that meet head on at full speed
  l.reach = std::max(std::sqrt(*small), steps * speed * dt);
  l.far = far_reaches * l.reach;
  l.apart = apart_reaches * l.reach;
}

/// Districts are so wide that all corners of a face within `apart` of a point lie in districts that touch its own.
class Districts {
 public:
  Districts(const ContactLists& l, double widest_face) : bins_across_(static_cast<std::int64_t>((widest_face + l.apart) / l.far) + 1) { cells_.reset(1); }
  std::uint32_t insert(const core::Cell& bin) { return cells_.insert(at(bin)); }
  std::uint32_t find(const core::Cell& bin) const { return cells_.find(at(bin)); }
  /// Which touch which, itself included.
  std::vector<std::vector<std::uint32_t>> touching() const {
    std::vector<std::vector<std::uint32_t>> rows(cells_.size());
    for (std::size_t d = 0; d < rows.size(); ++d)
      for (std::int64_t i = -1; i <= 1; ++i)
        for (std::int64_t j = -1; j <= 1; ++j)
          for (std::int64_t k = -1; k <= 1; ++k)
            if (const auto o = cells_.find({cells_[d][0] + i, cells_[d][1] + j, cells_[d][2] + k}); o != Cells::none) rows[d].push_back(o);
    return rows;
  }

 private:
  core::Cell at(const core::Cell& bin) const {
    const auto part = [&](std::int64_t i) { return (i >= 0 ? i : i - bins_across_ + 1) / bins_across_; };
    return {part(bin[0]), part(bin[1]), part(bin[2])};
  }
  std::int64_t bins_across_;
  core::Cells cells_;
};

/// Takes quiet nodes out of the points.
static Districts leave_quiet(const fem::Mesh& mesh, const std::vector<fem::Face>& faces, ContactLists& l) {
  const double widest = -core::min_where(faces.size(), [&](std::size_t f) {
                           const Box box = face_box(l, face_nodes(mesh, faces[f]));
                           return -(box.high - box.low).maxCoeff();
                         }).value;
  Districts districts(l, widest);
  constexpr std::int32_t several = -1;
  std::vector<std::int32_t> body;  // [district] the one whose nodes are all that is there
  std::vector<std::uint32_t> home(l.points.size());
  for (std::size_t k = 0; k < home.size(); ++k) {
    home[k] = districts.insert(l.cells.cell(built(l, l.points[k])));
    if (home[k] == body.size()) body.push_back(l.points[k].body);
    if (body[home[k]] != l.points[k].body) body[home[k]] = several;
  }
  l.touching = districts.touching();
  std::vector<std::uint8_t> quiet(body.size());
  for (std::size_t d = 0; d < quiet.size(); ++d)
    quiet[d] = body[d] != several && std::all_of(l.touching[d].begin(), l.touching[d].end(), [&](auto o) { return body[o] == body[d]; });
  l.beside_quiet.resize(quiet.size());
  for (std::size_t d = 0; d < quiet.size(); ++d)
    l.beside_quiet[d] = std::any_of(l.touching[d].begin(), l.touching[d].end(), [&](auto o) { return quiet[o] != 0; });
  l.quiet.clear();
  std::size_t kept = 0;
  for (std::size_t k = 0; k < home.size(); ++k)
    if (quiet[home[k]])
      l.quiet.push_back(l.points[k].index);
    else
      l.points[kept++] = l.points[k];
  l.points.resize(kept);
  l.points.shrink_to_fit();  // where most were quiet
  return districts;
}

static void bin_points(const Districts& districts, ContactLists& l) {
  l.node_point.assign(l.node_built.size(), ContactLists::no_point);
  l.particle_point.assign(l.particle_built.size(), ContactLists::no_point);
  for (auto& bin : l.bins) bin.points.clear(), bin.faces.clear(), bin.face_bins.clear(), bin.contested = false;
  l.district.clear();
  for (std::uint32_t k = 0; k < l.points.size(); ++k) {
    const core::Cell cell = l.cells.cell(built(l, l.points[k]));
    const auto b = l.cells.insert(cell);
    if (b >= l.bins.size()) l.bins.resize(b + 1);
    if (b == l.district.size()) l.district.push_back(districts.find(cell));
    place_point(l, k, b);
  }
  l.cells.tabulate();
}

/// Faces of which no corner is quiet.
static void bin_faces(const fem::Mesh& mesh, const std::vector<fem::Face>& faces, ContactLists& l) {
  l.faces = core::collect<ContactFace>(faces.size(), [&](std::size_t f, std::vector<ContactFace>& kept) {
    const auto node = face_nodes(mesh, faces[f]);
    if (std::all_of(node.begin(), node.end(), [&](auto nd) { return l.node_point[nd] != ContactLists::no_point; })) kept.push_back(contact_face(mesh, faces[f]));
  });
  constexpr std::size_t block = 256;
  std::vector<std::vector<std::pair<std::uint32_t, std::uint32_t>>> known((l.faces.size() + block - 1) / block);  // bin, face
  core::for_each_block(l.faces.size(), block, [&](std::size_t first, std::size_t last) {
    for (std::size_t f = first; f < last; ++f) {
      l.faces[f].box = face_box(l, l.faces[f].node);
      each_bin(l, l.faces[f].box.widened(l.far - l.reach),
               [&](std::uint32_t b) { known[first / block].push_back({b, static_cast<std::uint32_t>(f)}); });
    }
  });
  core::for_each_share(l.cells.size(), [&](std::size_t low, std::size_t high) {
    for (const auto& list : known)
      for (const auto& [b, f] : list)
        if (b - low < high - low) l.bins[b].faces.push_back(f);
  });
}

struct PairScratch {
  std::vector<std::uint8_t> seen;  ///< [bin] all zero; empty until something is contested
  std::vector<Vec3> x;             ///< of a bin's points
};

/// Pairs of one bin.
static void pair_up(const ContactLists& l, ContactBin& bin, PairScratch& scratch, std::vector<Candidate>& found) {
  const auto all_alike = [](const auto& rows, const auto& things) {
    return std::all_of(rows.begin(), rows.end(), [&](auto k) { return things[k].body == things[rows[0]].body; });
  };
  if (bin.points.empty() || bin.faces.empty()) return;
  if (l.points[bin.points[0]].body == l.faces[bin.faces[0]].body && all_alike(bin.points, l.points) &&
      all_alike(bin.faces, l.faces))
    return;
  scratch.seen.resize(l.cells.size());  // only where something may strike: there are as many bins as particles in a late cloud
  contest(l, bin, scratch.seen);
  Box points;
  scratch.x.clear();
  for (const auto k : bin.points) points.add(scratch.x.emplace_back(built(l, l.points[k])));
  for (const auto f : bin.faces) {
    const Box& box = l.faces[f].box;
    if (!box.touches(points)) continue;
    for (std::size_t i = 0; i < scratch.x.size(); ++i)
      if (box.contains(scratch.x[i]) && may_strike(l.points[bin.points[i]], l.faces[f])) found.push_back({bin.points[i], f});
  }
}

/// Bodies that are out of everybody's reach for many steps.
static void leave_out(std::span<const double> times_to_meet, double time, double dt, ContactLists& l) {
  constexpr double steps = 40;
  l.left_out.assign(times_to_meet.size(), 0);
  l.until = 1e300;
  for (std::size_t b = 0; b < l.left_out.size(); ++b)
    if (times_to_meet[b] > steps * dt) {
      l.left_out[b] = 1;
      l.until = std::min(l.until, time + times_to_meet[b]);
    }
}

void make_lists(const fem::Mesh& mesh, const sph::Particles& particles, std::span<const double> times_to_meet, double time,
                double dt, ContactLists& l) {
  fem::update_surface(mesh, l.surface);
  leave_out(times_to_meet, time, dt, l);
  list_points(mesh, particles, l);
  std::vector<fem::Face> faces;
  faces.reserve(l.surface.faces.size());
  for (const auto& f : l.surface.faces)
    if (!l.left_out[mesh.elements.body(f.element)]) faces.push_back(f);
  l.faces.clear();
  l.quiet.clear();
  l.origin = mesh.nodes.x[0];
  round_all(l, mesh.nodes.x, l.node_built);
  round_all(l, particles.x, l.particle_built);
  l.candidates.clear();
  l.paired.clear();
  l.rows.n = 0, l.rows.start.clear();
  l.valid = true;
  if (faces.empty()) return;
  choose_reach(mesh, particles, faces, dt, l);
  l.cells.reset(l.far);
  bin_points(leave_quiet(mesh, faces, l), l);
  bin_faces(mesh, faces, l);
  constexpr std::size_t block = 16;
  std::vector<std::vector<Candidate>> part((l.cells.size() + block - 1) / block);
  core::for_each_block(l.cells.size(), block, [&](std::size_t first, std::size_t last) {
    PairScratch scratch;
    for (std::size_t b = first; b < last; ++b) pair_up(l, l.bins[b], scratch, part[first / block]);
  });
  for (const auto& list : part)
    for (const auto& pair : list) add_pair(l, pair);
}

// ------------------------------------------------------------------------------------------------ what appears

/// False where nothing was when the lists were made, or what may strike its own body comes near quiet faces: then nobody knows what is near.
static bool add_point(ContactLists& l, const ContactPoint& point) {
  const Vec3 x = built(l, point);
  const auto b = l.cells.find(l.cells.cell(x));
  if (b == Cells::none || (point.body < 0 && l.beside_quiet[l.district[b]])) return false;
  const auto k = static_cast<std::uint32_t>(l.points.size());
  l.points.push_back(point);
  if (point.particle) l.particle_point.push_back(ContactLists::no_point);
  place_point(l, k, b);
  ContactBin& bin = l.bins[b];
  for (const auto f : bin.faces) {
    if (point.body == l.faces[f].body) continue;
    if (!bin.contested) contest(l, bin);
    if (may_strike(point, l.faces[f]) && l.faces[f].box.contains(x)) add_pair(l, {k, f});
  }
  return true;
}

static bool add_face(ContactLists& l, const ContactFace& face) {
  if (l.left_out[static_cast<std::size_t>(face.body)]) return false;
  for (const auto nd : face.node)
    if (l.node_point[nd] == ContactLists::no_point) return false;
  const auto f = static_cast<std::uint32_t>(l.faces.size());
  l.faces.push_back(face);
  const Box box = l.faces.back().box = face_box(l, face.node);
  each_bin(l, box.widened(l.far - l.reach), [&](std::uint32_t b) {
    ContactBin& bin = l.bins[b];
    bin.faces.push_back(f);
    if (bin.contested)
      for (const auto nd : face.node) add_face_bin(bin, bin_of_corner(l, nd));
    for (const auto k : bin.points) {
      if (l.points[k].body == face.body) continue;
      if (!bin.contested) contest(l, bin);
      if (box.contains(built(l, l.points[k])) && may_strike(l.points[k], face)) add_pair(l, {k, f});
    }
  });
  return true;
}

/// Where a particle would have been when the lists were made, had it moved as the element that it was.
static Vec3 earlier(const fem::Mesh& mesh, const sph::Particles& p, std::size_t i, const ContactLists& l) {
  Vec3 moved = Vec3::Zero();
  for (const auto node : mesh.elements.node[p.parent[i]]) {
    const auto nd = static_cast<std::size_t>(node);
    moved += mesh.nodes.x[nd] - built_node(l, nd);
  }
  return p.x[i] - moved / 8;
}

/// Puts in what has appeared since; false when that cannot be done.
static bool extend(const fem::Mesh& mesh, const sph::Particles& particles, ContactLists& l) {
  const std::size_t before = l.particle_built.size();
  if (particles.size() < before || l.faces.empty()) return false;
  fem::update_surface(mesh, l.surface);
  for (const auto nd : l.surface.lost_nodes)
    if (mesh.nodes.m[nd] > 0) return false;  // it flies on alone and may strike its own body now
  for (const auto nd : l.surface.new_nodes)
    if (!add_point(l, {nd, false, body_of_node(mesh, nd)})) return false;
  for (std::size_t i = before; i < particles.size(); ++i) {
    if (l.left_out[particles.body[i]]) return false;
    l.particle_built.push_back(rounded(l, earlier(mesh, particles, i, l)));
    if (!add_point(l, {static_cast<std::uint32_t>(i), true, -1})) return false;
  }
  return std::all_of(l.surface.new_faces.begin(), l.surface.new_faces.end(),
                     [&](const fem::Face& f) { return add_face(l, contact_face(mesh, f)); });
}

/// Do displacements, a time ahead, differ by less than the lists allow?
static bool hold(const fem::Mesh& mesh, const sph::Particles& particles, double ahead, const ContactLists& l) {
  if (l.faces.empty() && l.quiet.empty()) return true;
  struct Moved {
    Box all, nodes;
  };
  const fem::Nodes& n = mesh.nodes;
  const auto add_node = [&](std::size_t nd, Box& box) {
    if (!n.awake[nd])
      box.add(Vec3::Zero());
    else if (n.m[nd] > 0)
      box.add(n.x[nd] - built_node(l, nd) + ahead * n.v[nd]);
  };
  std::vector<Moved> moved(l.cells.size());
  core::for_each_block(moved.size(), 16, [&](std::size_t first, std::size_t last) {
    for (std::size_t b = first; b < last; ++b) {
      Moved m;
      for (const auto k : l.bins[b].points) {
        const auto& p = l.points[k];
        if (p.particle)
          m.all.add(particles.x[p.index] - built_particle(l, p.index) + ahead * particles.v[p.index]);
        else
          add_node(p.index, m.nodes);
      }
      m.all.add(m.nodes);
      moved[b] = m;
    }
  });
  Moved whole;
  whole.nodes = core::reduce(
      l.quiet.size(), Box{},
      [&](std::size_t first, std::size_t last) {
        Box box;
        for (std::size_t k = first; k < last; ++k) add_node(l.quiet[k], box);
        return box;
      },
      Box::join);
  whole.all = whole.nodes;
  std::vector<Moved> district(l.touching.size());
  for (std::size_t b = 0; b < moved.size(); ++b) {
    district[l.district[b]].all.add(moved[b].all);
    district[l.district[b]].nodes.add(moved[b].nodes);
  }
  for (const auto& m : district) whole.all.add(m.all), whole.nodes.add(m.nodes);
  if (whole.all.apart(whole.nodes).maxCoeff() > usable * l.apart) return false;
  for (std::size_t d = 0; d < district.size(); ++d)
    for (const auto o : l.touching[d])
      if (district[d].all.apart(district[o].nodes).maxCoeff() > usable * l.far) return false;
  const double limit = usable * l.reach;
  return core::min_where(moved.size(), [&](std::size_t b) {
           double most = 0;
           if (l.bins[b].contested)
             for (const auto o : l.bins[b].face_bins) most = std::max(most, moved[b].all.apart(moved[o].nodes).maxCoeff());
           return -most;
         }).value >= -limit;
}

bool keep_lists(const fem::Mesh& mesh, const sph::Particles& particles, double time, double dt, ContactLists& l) {
  if (!l.valid || time + steps_covered * dt > l.until) return false;
  const bool grows = l.surface.n_removed != mesh.n_removed || l.particle_built.size() != particles.size();
  // Paths are straight: what held at the last step's end and holds ahead holds in between.
  return (!grows || (extend(mesh, particles, l) && hold(mesh, particles, 0, l))) &&
         hold(mesh, particles, steps_covered * dt, l);
}

// ------------------------------------------------------------------------------------------------ who is in which pair

/// Each stands in the row of the point that strikes and in those of the four corners.
static void make_rows(ContactLists& l) {
  l.rows.n = l.candidates.size();
  core::sort_into_rows(
      l.points.size(),
      [&](auto&& put) {
        for (std::uint32_t c = 0; c < l.rows.n; ++c) {
          put(l.candidates[c].point, c);
          for (const auto nd : l.faces[l.candidates[c].face].node) put(l.node_point[nd], c);
        }
      },
      l.rows.start, l.rows.list);
}

std::vector<Candidate> candidates_of(std::span<const ContactPoint> matter, ContactLists& l) {
  constexpr std::size_t many = 64;  // pairs that came later are all given, until there is one for so many in rows
  if (l.candidates.size() > l.rows.n + l.rows.n / many) make_rows(l);
  const CandidateRows& rows = l.rows;
  std::vector<Candidate> found(l.candidates.begin() + static_cast<std::ptrdiff_t>(rows.n), l.candidates.end());
  std::vector<std::uint8_t> given(rows.n);
  for (const auto& m : matter) {
    const std::size_t k = row_of(l, m);
    if (k + 1 >= rows.start.size()) continue;  // no point, or in later pairs only
    for (auto r = rows.start[k]; r < rows.start[k + 1]; ++r)
      if (const auto c = rows.list[r]; !given[c]) {
        given[c] = 1;
        found.push_back(l.candidates[c]);
      }
  }
  return found;
}

// ------------------------------------------------------------------------------------------------ whole bodies

std::vector<double> times_to_meet(const fem::Mesh& mesh, const sph::Particles& particles) {
  struct Extent {
    Box box;
    double speed_2 = 0;
    void add(const Vec3& x, const Vec3& v) {
      box.add(x);
      speed_2 = std::max(speed_2, v.squaredNorm());
    }
    void add(const Extent& o) {
      box.add(o.box);
      speed_2 = std::max(speed_2, o.speed_2);
    }
  };
  const std::size_t n = mesh.body_elements.size();
  std::vector<Extent> solid(n), cloud(n);
  for (std::size_t b = 0; b < n; ++b) {
    if (mesh.body_nodes[b].size() == 0) continue;
    if (!mesh.body_awake[b]) {
      solid[b].box = mesh.body_box[b];
      continue;
    }
    struct Both {
      Extent solid, free;
    };
    const Both both = core::reduce(
        mesh.body_nodes[b].size(), Both{},
        [&](std::size_t first, std::size_t last) {
          Both e;
          for (std::size_t nd = mesh.body_nodes[b].first + first; nd < mesh.body_nodes[b].first + last; ++nd)
            if (mesh.nodes.m[nd] > 0)
              (mesh.n_removed == 0 || fem::belongs_to_elements(mesh, nd) ? e.solid : e.free).add(mesh.nodes.x[nd], mesh.nodes.v[nd]);
          return e;
        },
        [](Both a, const Both& o) {
          a.solid.add(o.solid);
          a.free.add(o.free);
          return a;
        });
    solid[b] = both.solid;
    cloud[b] = both.free;  // may strike the body that they come from
  }
  for (std::size_t i = 0; i < particles.size(); ++i) cloud[particles.body[i]].add(particles.x[i], particles.v[i]);
  double speed_2 = 0;
  for (std::size_t b = 0; b < n; ++b) speed_2 = std::max({speed_2, solid[b].speed_2, cloud[b].speed_2});
  const double closing = 2 * 1.2 * std::sqrt(speed_2) + 1e-300;  // both may move, and be sped up a little meanwhile
  std::vector<double> time(n, 1e300);
  for (std::size_t b = 0; b < n; ++b) {
    if (solid[b].box.empty()) continue;
    double gap = 1e300;
    for (std::size_t a = 0; a < n; ++a) {
      if (a != b && !solid[a].box.empty()) gap = std::min(gap, solid[a].box.distance(solid[b].box));
      if (!cloud[a].box.empty()) gap = std::min(gap, cloud[a].box.distance(solid[b].box));
    }
    time[b] = gap / closing;
  }
  return time;
}

}  // namespace coupling
