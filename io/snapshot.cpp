// SPDX-License-Identifier: Apache-2.0
#include "io/snapshot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>

#include "core/error.hpp"
#include "core/units.hpp"
#include "io/atomic_file.hpp"
#include "io/hdf5.hpp"

namespace io {
namespace {

using hdf5::Access;
using hdf5::File;

constexpr std::int64_t format_version = 1;
constexpr const char* version_attribute = "ejecta_snapshots_version";
constexpr const char* scalar_prefix = "scalar_";

std::string group_of(std::int64_t step) { return fmt::format("step_{:06d}", step); }

// --- checks ---

/// The first row of `values` that is not finite stops the run before it is written.
void check_finite(const Snapshot& s, const std::string& name, const double* values, std::size_t rows, std::size_t columns) {
  for (std::size_t i = 0; i < rows * columns; ++i)
    if (!std::isfinite(values[i]))
      throw core::GuardError(fmt::format("snapshot at step {} (t = {:g} s): '{}' of row {} is {}; it was not written; look "
                                         "at history.csv for the steps before, and try a lower run.cfl", s.step, s.time,
                                         name, i / columns, values[i]));
}

void check_size(const Snapshot& s, const std::string& name, std::size_t given, std::size_t expected, bool may_be_absent) {
  if (given == expected || (may_be_absent && given == 0)) return;
  throw core::GuardError(fmt::format("snapshot at step {}: '{}' has {} rows, {} are needed", s.step, name, given, expected));
}

void check_corners(const Snapshot& s) {
  for (std::size_t el = 0; el < s.element_node.size(); ++el)
    for (const std::int32_t nd : s.element_node[el])
      if (nd < 0 || static_cast<std::size_t>(nd) >= s.node_x.size())
        throw core::GuardError(fmt::format("snapshot at step {}: element {} has corner {} of {} nodes", s.step, el, nd,
                                           s.node_x.size()));
}

const double* data(const std::vector<core::Vec3>& v) { return v.empty() ? nullptr : v.front().data(); }

void check(const Snapshot& s) {
  check_size(s, "node_v", s.node_v.size(), s.node_x.size(), false);
  check_size(s, "particle_v", s.particle_v.size(), s.particle_x.size(), false);
  check_corners(s);
  check_finite(s, "node_x", data(s.node_x), s.node_x.size(), 3);
  check_finite(s, "node_v", data(s.node_v), s.node_v.size(), 3);
  check_finite(s, "particle_x", data(s.particle_x), s.particle_x.size(), 3);
  check_finite(s, "particle_v", data(s.particle_v), s.particle_v.size(), 3);
  for (const Snapshot::Field& f : s.fields) {
    check_size(s, f.name + " (elements)", f.element.size(), s.element_node.size(), true);
    check_size(s, f.name + " (particles)", f.particle.size(), s.particle_x.size(), true);
    check_finite(s, f.name + " (elements)", f.element.data(), f.element.size(), 1);
    check_finite(s, f.name + " (particles)", f.particle.data(), f.particle.size(), 1);
  }
}

// --- run.h5 ---

void write_vectors(File& file, const std::string& name, const std::vector<core::Vec3>& v) {
  file.write(name, data(v), v.size(), 3);
}

std::vector<core::Vec3> read_vectors(const File& file, const std::string& name) {
  std::vector<core::Vec3> v(file.extent(name).rows);
  file.read(name, v.empty() ? nullptr : v.front().data(), 3 * v.size());
  return v;
}

/// Bytes that write_group will need, headers included.
std::size_t bytes_of(const Snapshot& s) {
  std::size_t bytes = 8 * 6 * (s.node_x.size() + s.particle_x.size()) + 32 * s.element_node.size() + 4 * s.particle_x.size();
  for (const Snapshot::Field& f : s.fields) bytes += 8 * (f.element.size() + f.particle.size());
  constexpr std::size_t header = 1024;
  return bytes + header * (8 + 2 * s.fields.size() + s.scalars.size());
}

/// The attribute `time` comes last: a group without it was not finished.
void write_group(File& file, const std::string& group, const Snapshot& s) {
  file.make_group(group);
  file.make_group(group + "/element");
  file.make_group(group + "/particle");
  write_vectors(file, group + "/node_x", s.node_x);
  write_vectors(file, group + "/node_v", s.node_v);
  const std::int32_t* corners = s.element_node.empty() ? nullptr : s.element_node.front().data();
  file.write(group + "/element_node", corners, s.element_node.size(), 8);
  write_vectors(file, group + "/particle_x", s.particle_x);
  write_vectors(file, group + "/particle_v", s.particle_v);
  std::vector<std::int32_t> cell(s.particle_x.size());  // ParaView makes no cells for points without a list of them
  std::iota(cell.begin(), cell.end(), 0);
  file.write(group + "/particle_node", cell);
  for (const Snapshot::Field& f : s.fields) {
    if (!f.element.empty()) file.write(group + "/element/" + f.name, f.element);
    if (!f.particle.empty()) file.write(group + "/particle/" + f.name, f.particle);
  }
  for (const auto& [name, value] : s.scalars) file.set_attribute(group, scalar_prefix + name, value);
  file.set_attribute(group, "step", s.step);
  file.set_attribute(group, "time", s.time);
}

/// What run.xdmf has to know of one snapshot.
struct SnapshotEntry {
  std::string group;
  double time = 0;
  std::int64_t step = 0;
  std::size_t n_nodes = 0, n_elements = 0, n_particles = 0;
  std::vector<std::string> element_fields, particle_fields;  // sorted
};

SnapshotEntry entry_of(const Snapshot& s) {
  SnapshotEntry e{group_of(s.step), s.time, s.step, s.node_x.size(), s.element_node.size(), s.particle_x.size(), {}, {}};
  for (const Snapshot::Field& f : s.fields) {
    if (!f.element.empty()) e.element_fields.push_back(f.name);
    if (!f.particle.empty()) e.particle_fields.push_back(f.name);
  }
  for (auto* names : {&e.element_fields, &e.particle_fields}) std::sort(names->begin(), names->end());
  return e;
}

SnapshotEntry entry_of(const File& file, const std::string& group) {
  SnapshotEntry e;
  e.group = group;
  e.time = file.real_attribute(group, "time");
  e.step = file.integer_attribute(group, "step");
  e.n_nodes = file.extent(group + "/node_x").rows;
  e.n_elements = file.extent(group + "/element_node").rows;
  e.n_particles = file.extent(group + "/particle_x").rows;
  e.element_fields = file.children(group + "/element");
  e.particle_fields = file.children(group + "/particle");
  return e;
}

void check_version(const File& file) {
  if (!file.has_attribute("/", version_attribute)) throw core::GuardError(file.path() + ": holds no snapshots of Ejecta");
  const std::int64_t stored = file.integer_attribute("/", version_attribute);
  if (stored != format_version)
    throw core::GuardError(fmt::format("{}: its snapshots have format {}, this program reads {}", file.path(), stored,
                                       format_version));
}

/// Snapshots of a file in order of time, unfinished ones left out.
std::vector<SnapshotEntry> entries_of(const File& file) {
  check_version(file);
  std::vector<SnapshotEntry> entries;
  for (const std::string& name : file.children("/"))
    if (name.starts_with("step_") && file.has_attribute(name, "time")) entries.push_back(entry_of(file, name));
  std::sort(entries.begin(), entries.end(), [](const auto& a, const auto& b) { return a.step < b.step; });
  return entries;
}

std::string h5_of(const std::string& path) {
  return std::filesystem::is_directory(path) ? path + "/run.h5" : path;
}

// --- run.xdmf ---

std::string escaped(const std::string& s) {
  std::string r;
  for (const char c : s)
    r += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '"' ? "&quot;" : std::string(1, c);
  return r;
}

std::string data_item(const std::string& dimensions, const std::string& name, bool integer = false) {
  return fmt::format("<DataItem Dimensions=\"{}\" NumberType=\"{}\" Precision=\"{}\" Format=\"HDF\">run.h5:/{}</DataItem>",
                     dimensions, integer ? "Int" : "Float", integer ? 4 : 8, escaped(name));
}

std::string geometry(const std::string& name, std::size_t n) {
  return fmt::format("<Geometry GeometryType=\"XYZ\">{}</Geometry>\n", data_item(fmt::format("{} 3", n), name));
}

std::string vector_attribute(const std::string& name, std::size_t n) {
  return fmt::format("<Attribute Name=\"velocity\" AttributeType=\"Vector\" Center=\"Node\">{}</Attribute>\n",
                     data_item(fmt::format("{} 3", n), name));
}

std::string scalar_attribute(const std::string& name, const char* center, const std::string& set, std::size_t n) {
  return fmt::format("<Attribute Name=\"{}\" AttributeType=\"Scalar\" Center=\"{}\">{}</Attribute>\n", escaped(name), center,
                     data_item(std::to_string(n), set));
}

std::string elements_block(const SnapshotEntry& e) {
  if (e.n_elements == 0) return "";
  std::string t = "<Grid Name=\"elements\" GridType=\"Uniform\">\n";
  t += fmt::format("<Topology TopologyType=\"Hexahedron\" NumberOfElements=\"{}\">{}</Topology>\n", e.n_elements,
                   data_item(fmt::format("{} 8", e.n_elements), e.group + "/element_node", true));
  t += geometry(e.group + "/node_x", e.n_nodes) + vector_attribute(e.group + "/node_v", e.n_nodes);
  for (const std::string& f : e.element_fields) t += scalar_attribute(f, "Cell", e.group + "/element/" + f, e.n_elements);
  return t + "</Grid>\n";
}

/// Fields of particles are given to their points (glyphs, point Gaussians) and to their cells (one colouring for both
/// blocks); both read the same data.
std::string particles_block(const SnapshotEntry& e) {
  if (e.n_particles == 0) return "";
  std::string t = "<Grid Name=\"particles\" GridType=\"Uniform\">\n";
  t += fmt::format("<Topology TopologyType=\"Polyvertex\" NumberOfElements=\"{}\" NodesPerElement=\"1\">{}</Topology>\n",
                   e.n_particles, data_item(fmt::format("{} 1", e.n_particles), e.group + "/particle_node", true));
  t += geometry(e.group + "/particle_x", e.n_particles) + vector_attribute(e.group + "/particle_v", e.n_particles);
  for (const char* center : {"Cell", "Node"})
    for (const std::string& f : e.particle_fields)
      t += scalar_attribute(f, center, e.group + "/particle/" + f, e.n_particles);
  return t + "</Grid>\n";
}

std::string snapshot_block(const SnapshotEntry& e) {
  return fmt::format("<Grid Name=\"{}\" GridType=\"Collection\" CollectionType=\"Spatial\">\n<Time Value=\"{}\"/>\n", e.group,
                     core::exact_decimal(e.time)) +
         elements_block(e) + particles_block(e) + "</Grid>\n";
}

}  // namespace

const Snapshot::Field* Snapshot::find(const std::string& name) const {
  for (const Field& f : fields)
    if (f.name == name) return &f;
  return nullptr;
}

SnapshotWriter::SnapshotWriter(const std::string& dir) : dir_(dir) {
  std::error_code error;
  std::filesystem::create_directories(dir, error);
  if (error) throw core::GuardError(fmt::format("{}: the folder cannot be made: {}", dir, error.message()));
  File file(h5_path(), Access::create);
  file.set_attribute("/", version_attribute, format_version);
  file.close();
  write_xdmf();
}

SnapshotWriter SnapshotWriter::reopen(const std::string& dir, double time) {
  SnapshotWriter writer(dir, Existing{});
  const std::string path = writer.h5_path();
  try {
    File file(path, Access::modify);
    for (const SnapshotEntry& e : entries_of(file)) {
      if (e.time <= time)
        writer.stored_.push_back({e.step, snapshot_block(e)});
      else
        file.remove(e.group);
    }
    file.close();
  } catch (const core::GuardError& e) {
    std::error_code error;
    const bool was_there = std::filesystem::exists(path, error);
    if (was_there) std::filesystem::rename(path, path + ".damaged", error);
    if (error) throw;
    SnapshotWriter fresh(dir);
    fresh.note_ = fmt::format("{}; a new file was begun{}", e.what(), was_there ? ", the old one is run.h5.damaged" : "");
    return fresh;
  }
  writer.write_xdmf();
  return writer;
}

void SnapshotWriter::append(const Snapshot& s) {
  check(s);
  const std::string group = group_of(s.step);
  const bool again = !stored_.empty() && stored_.back().step == s.step;
  if (!stored_.empty() && s.step < stored_.back().step)
    throw core::GuardError(fmt::format("{}: snapshot of step {} comes after that of step {}", h5_path(), s.step,
                                       stored_.back().step));
  File file(h5_path(), Access::modify);
  if (file.has(group)) file.remove(group);
  if (again) stored_.pop_back();
  try {
    file.claim(bytes_of(s), fmt::format("the snapshot of step {}", s.step));
    write_group(file, group, s);
  } catch (const core::GuardError&) {
    if (file.has(group)) file.remove(group);
    file.close();
    if (again) write_xdmf();
    throw;
  }
  stored_.push_back({s.step, snapshot_block(entry_of(s))});
  file.close();
  write_xdmf();
}

void SnapshotWriter::write_xdmf() const {
  std::string t = "<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\">\n<Domain>\n"
                  "<Grid Name=\"run\" GridType=\"Collection\" CollectionType=\"Temporal\">\n";
  for (const Stored& s : stored_) t += s.xdmf;
  write_atomically(dir_ + "/run.xdmf", t + "</Grid>\n</Domain>\n</Xdmf>\n");
}

std::vector<double> snapshot_times(const std::string& path) {
  std::vector<double> times;
  for (const SnapshotEntry& e : entries_of(File(h5_of(path), Access::read))) times.push_back(e.time);
  return times;
}

Snapshot read_snapshot(const std::string& path, int index) {
  const File file(h5_of(path), Access::read);
  const std::vector<SnapshotEntry> entries = entries_of(file);
  const int n = static_cast<int>(entries.size());
  const int k = index < 0 ? index + n : index;
  if (k < 0 || k >= n)
    throw core::GuardError(fmt::format("{}: there is no snapshot {}; it holds {}", file.path(), index, n));
  const SnapshotEntry& e = entries[static_cast<std::size_t>(k)];
  Snapshot s;
  s.time = e.time;
  s.step = e.step;
  s.node_x = read_vectors(file, e.group + "/node_x");
  s.node_v = read_vectors(file, e.group + "/node_v");
  s.particle_x = read_vectors(file, e.group + "/particle_x");
  s.particle_v = read_vectors(file, e.group + "/particle_v");
  s.element_node.resize(e.n_elements);
  file.read(e.group + "/element_node", e.n_elements ? s.element_node.front().data() : nullptr, 8 * e.n_elements);
  for (const std::string& f : e.element_fields) s.fields.push_back({f, file.read<double>(e.group + "/element/" + f), {}});
  for (const std::string& f : e.particle_fields) {
    const auto same = std::find_if(s.fields.begin(), s.fields.end(), [&](const auto& g) { return g.name == f; });
    Snapshot::Field& field = same != s.fields.end() ? *same : s.fields.emplace_back(Snapshot::Field{f, {}, {}});
    field.particle = file.read<double>(e.group + "/particle/" + f);
  }
  std::sort(s.fields.begin(), s.fields.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  const std::string prefix = scalar_prefix;
  for (const auto& [name, value] : file.real_attributes(e.group))
    if (name.starts_with(prefix)) s.scalars.emplace_back(name.substr(prefix.size()), value);
  return s;
}

}  // namespace io
