// SPDX-License-Identifier: Apache-2.0
#include "io/snapshot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <utility>

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

/// The first row of `values`, rows from `first` on, that is not finite stops the run.
void check_finite(const SnapshotSize& s, const std::string& name, std::size_t first, const double* values, std::size_t rows, std::size_t columns) {
  for (std::size_t i = 0; i < rows * columns; ++i)
    if (!std::isfinite(values[i]))
      throw core::GuardError(fmt::format("snapshot at step {} (t = {:g} s): '{}' of row {} is {}; it was not written; look "
                                         "at history.csv for the steps before, and try a lower run.cfl", s.step, s.time,
                                         name, first + i / columns, values[i]));
}

void check_size(const SnapshotSize& s, const std::string& name, std::size_t given, std::size_t expected, bool may_be_absent) {
  if (given == expected || (may_be_absent && given == 0)) return;
  throw core::GuardError(fmt::format("snapshot at step {}: '{}' has {} rows, {} are needed", s.step, name, given, expected));
}

void check_corners(const SnapshotSize& s, std::size_t first, std::span<const std::array<std::int32_t, 8>> rows) {
  for (std::size_t el = 0; el < rows.size(); ++el)
    for (const std::int32_t nd : rows[el])
      if (nd < 0 || static_cast<std::size_t>(nd) >= s.n_nodes)
        throw core::GuardError(fmt::format("snapshot at step {}: element {} has corner {} of {} nodes", s.step, first + el, nd, s.n_nodes));
}

// --- run.h5 ---

std::vector<core::Vec3> read_vectors(const File& file, const std::string& name) {
  std::vector<core::Vec3> v(file.extent(name).rows);
  file.read(name, v.empty() ? nullptr : v.front().data(), 3 * v.size());
  return v;
}

/// Parts on their way to run.h5, each checked before it is written.
class FileSink : public SnapshotSink {
 public:
  FileSink(File& file, const SnapshotSize& size) : file_(file), size_(size) {
    file.make_group("element");
    file.make_group("particle");
    std::vector<std::int32_t> cell(size.n_particles);  // ParaView makes no cells for points without a list of them
    std::iota(cell.begin(), cell.end(), 0);
    file.write("particle_node", cell);
  }
  void nodes(std::span<const core::Vec3> x, std::span<const core::Vec3> v) override {
    vectors("node_x", x, size_.n_nodes);
    vectors("node_v", v, size_.n_nodes);
  }
  void corners(std::size_t n, const NextRows<std::array<std::int32_t, 8>>& next) override {
    check_size(size_, "element_node", n, size_.n_elements, false);
    std::size_t first = 0;
    std::vector<std::array<std::int32_t, 8>> rows;
    file_.write_pieces<std::int32_t>("element_node", n, 8, [&](std::int32_t* piece, std::size_t count) {
      rows.resize(count);
      next(rows);
      check_corners(size_, first, rows);
      std::copy_n(rows.front().data(), 8 * count, piece);
      first += count;
    });
  }
  void particles(std::span<const core::Vec3> x, std::span<const core::Vec3> v) override {
    vectors("particle_x", x, size_.n_particles);
    vectors("particle_v", v, size_.n_particles);
  }
  void field(const std::string& name, std::size_t n_elements, const NextRows<double>& element, std::size_t n_particles,
             const NextRows<double>& particle) override {
    const auto block = [&](const char* of, std::size_t n, const NextRows<double>& next, std::size_t expected) {
      const std::string what = fmt::format("{} ({}s)", name, of);
      check_size(size_, what, n, expected, true);
      if (n == 0) return;
      std::size_t first = 0;
      file_.write_pieces<double>(fmt::format("{}/{}", of, name), n, 0, [&](double* piece, std::size_t count) {
        next({piece, count});
        check_finite(size_, what, first, piece, count, 1);
        first += count;
      });
    };
    block("element", n_elements, element, size_.n_elements);
    block("particle", n_particles, particle, size_.n_particles);
    ++n_fields_;
  }
  void scalar(const std::string& name, double value) override { file_.set_attribute(".", scalar_prefix + name, value); }
  void finish() {
    check_size(size_, "fields", n_fields_, size_.n_fields, false);  // room was claimed for so many
    file_.set_attribute(".", "step", size_.step);
    file_.set_attribute(".", "time", size_.time);
  }

 private:
  void vectors(const std::string& name, std::span<const core::Vec3> rows, std::size_t expected) {
    const double* values = rows.empty() ? nullptr : rows.front().data();
    check_size(size_, name, rows.size(), expected, false);
    check_finite(size_, name, 0, values, rows.size(), 3);
    file_.write(name, values, rows.size(), 3);
  }

  File& file_;
  SnapshotSize size_;
  std::size_t n_fields_ = 0;
};

/// Of an array that is there, one piece after the other.
template <class T>
NextRows<T> rows_of(const std::vector<T>& all) {
  return [&all, first = std::size_t{0}](std::span<T> rows) mutable {
    std::copy_n(all.begin() + static_cast<std::ptrdiff_t>(first), rows.size(), rows.begin());
    first += rows.size();
  };
}

/// Parts into one snapshot.
class Collector : public SnapshotSink {
 public:
  explicit Collector(Snapshot& to) : to_(to) {}
  void nodes(std::span<const core::Vec3> x, std::span<const core::Vec3> v) override {
    to_.node_x.assign(x.begin(), x.end());
    to_.node_v.assign(v.begin(), v.end());
  }
  void corners(std::size_t n, const NextRows<std::array<std::int32_t, 8>>& next) override {
    to_.element_node.resize(n);
    next(to_.element_node);
  }
  void particles(std::span<const core::Vec3> x, std::span<const core::Vec3> v) override {
    to_.particle_x.assign(x.begin(), x.end());
    to_.particle_v.assign(v.begin(), v.end());
  }
  void field(const std::string& name, std::size_t n_elements, const NextRows<double>& element, std::size_t n_particles,
             const NextRows<double>& particle) override {
    auto& f = to_.fields.emplace_back(Snapshot::Field{name, std::vector<double>(n_elements), std::vector<double>(n_particles)});
    element(f.element);
    particle(f.particle);
  }
  void scalar(const std::string& name, double value) override { to_.scalars.emplace_back(name, value); }

 private:
  Snapshot& to_;
};

/// What run.xdmf has to know of one snapshot.
struct SnapshotEntry {
  std::string group;
  double time = 0;
  std::int64_t step = 0;
  std::size_t n_nodes = 0, n_elements = 0, n_particles = 0;
  std::vector<std::string> element_fields, particle_fields;  // sorted
};

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

/// Snapshots of a file in order of time.
std::vector<SnapshotEntry> entries_of(const File& file) {
  check_version(file);
  std::vector<SnapshotEntry> entries;
  for (const std::string& name : file.children("/"))
    if (name.starts_with("step_")) entries.push_back(entry_of(file, name));
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
  File file(h5_path(), Access::create_to_grow);
  file.set_attribute("/", version_attribute, format_version);
  file.close();
  write_xdmf();
}

SnapshotWriter SnapshotWriter::reopen(const std::string& dir, double time) {
  SnapshotWriter writer(dir, Existing{});
  const std::string path = writer.h5_path();
  try {
    for (const SnapshotEntry& e : entries_of(File(path, Access::read))) {
      if (e.time <= time)
        writer.stored_.push_back({e.step, snapshot_block(e)});
      else
        writer.to_drop_.push_back(e.group);
    }
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

double SnapshotSize::bytes() const {
  return 8.0 * 6 * static_cast<double>(n_nodes + n_particles) + 32.0 * static_cast<double>(n_elements) +
         8.0 * static_cast<double>(n_fields) * static_cast<double>(n_elements + n_particles);
}

Snapshot collect(const SnapshotSize& size, const SnapshotParts& parts) {
  Snapshot s;
  s.time = size.time;
  s.step = size.step;
  Collector to(s);
  parts(to);
  return s;
}

void SnapshotWriter::append(const Snapshot& s) {
  append({s.time, s.step, s.node_x.size(), s.element_node.size(), s.particle_x.size(), s.fields.size()}, [&](SnapshotSink& to) {
    to.nodes(s.node_x, s.node_v);
    to.corners(s.element_node.size(), rows_of(s.element_node));
    to.particles(s.particle_x, s.particle_v);
    for (const Snapshot::Field& f : s.fields) to.field(f.name, f.element.size(), rows_of(f.element), f.particle.size(), rows_of(f.particle));
    for (const auto& [name, value] : s.scalars) to.scalar(name, value);
  });
}

void SnapshotWriter::append(const SnapshotSize& size, const SnapshotParts& parts) {
  const std::string group = group_of(size.step);
  const bool again = !stored_.empty() && stored_.back().step == size.step;
  if (!stored_.empty() && size.step < stored_.back().step)
    throw core::GuardError(fmt::format("{}: snapshot of step {} comes after that of step {}", h5_path(), size.step,
                                       stored_.back().step));
  constexpr std::size_t headers = 256 << 10;
  File file(h5_path(), Access::modify);
  file.claim(static_cast<std::size_t>(size.bytes()) + 4 * size.n_particles + headers, fmt::format("the snapshot of step {}", size.step));
  file.begin_unlinked();
  FileSink to(file, size);
  parts(to);
  to.finish();
  if (again) to_drop_.push_back(group);
  file.link_as(group, std::exchange(to_drop_, {}));
  const SnapshotEntry entry = entry_of(file, group);
  file.close();
  if (again) stored_.pop_back();
  stored_.push_back({size.step, snapshot_block(entry)});
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
