// SPDX-License-Identifier: Apache-2.0
// Snapshots of a run: DIR/run.h5 with one group a snapshot (/step_000123), and DIR/run.xdmf that shows them to ParaView
// as a series in time of two blocks, elements (hexahedra) and particles (points). The file is closed between snapshots,
// so that it can be looked at while the run goes on. Format: XDMF 3, https://xdmf.org/index.php/XDMF_Model_and_Format.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/types.hpp"

namespace io {

struct Snapshot {
  double time = 0;                                               ///< [s]
  std::int64_t step = 0;
  std::vector<core::Vec3> node_x, node_v;                        ///< [m], [m/s]
  std::vector<std::array<std::int32_t, 8>> element_node;         ///< corners, order of fem/generate.hpp
  std::vector<core::Vec3> particle_x, particle_v;                ///< [m], [m/s]
  struct Field {
    std::string name;                                            ///< mass, density, pressure, speed, temperature, damage ...
    std::vector<double> element, particle;                       ///< one a row, or empty where a block does not have it
  };
  std::vector<Field> fields;                                     ///< come back sorted by name
  std::vector<std::pair<std::string, double>> scalars;           ///< anything else, order kept
  /// The field of that name, or null.
  const Field* find(const std::string& name) const;
};

/// How large a snapshot is, known before its parts come.
struct SnapshotSize {
  double time = 0;                                               ///< [s]
  std::int64_t step = 0;
  std::size_t n_nodes = 0, n_elements = 0, n_particles = 0, n_fields = 0;
  double bytes() const;                                          ///< of its arrays
};

/// Gives the next rows of a part, as many as there is room for.
template <class T>
using NextRows = std::function<void(std::span<T>)>;

/// Where the parts of a snapshot go, one after the other: what is written need not all be there at once. Names and rows as
/// in Snapshot.
class SnapshotSink {
 public:
  virtual ~SnapshotSink() = default;
  virtual void nodes(std::span<const core::Vec3> x, std::span<const core::Vec3> v) = 0;
  virtual void corners(std::size_t n, const NextRows<std::array<std::int32_t, 8>>& next) = 0;
  virtual void particles(std::span<const core::Vec3> x, std::span<const core::Vec3> v) = 0;
  virtual void field(const std::string& name, std::size_t n_elements, const NextRows<double>& element, std::size_t n_particles,
                     const NextRows<double>& particle) = 0;
  virtual void scalar(const std::string& name, double value) = 0;
};
using SnapshotParts = std::function<void(SnapshotSink&)>;

/// All parts in one.
Snapshot collect(const SnapshotSize& size, const SnapshotParts& parts);

class SnapshotWriter {
 public:
  /// Makes DIR where needed and an empty run.h5 and run.xdmf in it, replacing what was there.
  explicit SnapshotWriter(const std::string& dir);
  /// Goes on with the run.h5 in DIR: snapshots later than `time` are dropped, in run.h5 with the next that is added. A file
  /// that can no longer be read is moved to run.h5.damaged and a new one begun; note() says so.
  static SnapshotWriter reopen(const std::string& dir, double time);

  /// Adds a snapshot; one of the same step is replaced. Throws GuardError for a full disk and for a number that is not
  /// finite; then, and when the program is killed at any time, run.h5 keeps what it had.
  void append(const Snapshot& s);
  void append(const SnapshotSize& size, const SnapshotParts& parts);

  std::size_t size() const { return stored_.size(); }
  const std::string& note() const { return note_; }

 private:
  struct Existing {};
  SnapshotWriter(const std::string& dir, Existing) : dir_(dir) {}
  std::string h5_path() const { return dir_ + "/run.h5"; }
  void write_xdmf() const;

  struct Stored {
    std::int64_t step;
    std::string xdmf;  ///< its part of run.xdmf
  };
  std::string dir_;
  std::vector<Stored> stored_;
  std::vector<std::string> to_drop_;  ///< groups of run.h5 that are not stored_
  std::string note_;
};

/// Times of the snapshots in a run.h5 (or in the folder that holds it), increasing.
std::vector<double> snapshot_times(const std::string& path);
/// One snapshot; index -1 is the last, -2 the one before it.
Snapshot read_snapshot(const std::string& path, int index = -1);

}  // namespace io
