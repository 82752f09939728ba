// SPDX-License-Identifier: Apache-2.0
// HDF5 files with plain calls: arrays of one or two dimensions, attributes, groups. Every failure is a core::GuardError
// that names the file, what was being done and why (the system's words). Room on the disk is claimed before an array is
// written, so that a full disk is met before the file is touched.
// T is double, float, int32_t, int64_t, uint8_t, uint32_t or uint64_t.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace io::hdf5 {

/// create_to_grow: what is linked to the root lies in its header, which has room for a thousand links (40 kB), so that any
/// change of them is one write to the disk.
enum class Access { read, modify, create, create_to_grow };

/// Rows and columns of an array; columns is 1 for one dimension.
struct Extent {
  std::size_t rows = 0, columns = 1;
  int dimensions = 1;
  std::size_t size() const { return rows * columns; }
};

class File {
 public:
  File(const std::string& path, Access access);
  ~File();  ///< closes; errors are lost, so call close() after writing
  File(File&& other) noexcept;
  File& operator=(File&& other) noexcept;
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  /// Flushes and closes; throws where the data did not reach the file.
  void close();

  /// Claims room for `bytes` more; `what` is named in the error. write() does it for its own array.
  void claim(std::size_t bytes, const std::string& what);

  /// Groups on the way are made. columns = 0 writes one dimension. deflate 1 ... 9 compresses, 0 does not.
  template <class T>
  void write(const std::string& name, const T* data, std::size_t rows, std::size_t columns = 0, int deflate = 0);
  template <class T>
  void write(const std::string& name, const std::vector<T>& data, int deflate = 0) {
    write(name, data.data(), data.size(), 0, deflate);
  }

  /// The same of rows that need not all be there at once: next(piece, n) puts the next n of them there.
  template <class T>
  void write_pieces(const std::string& name, std::size_t rows, std::size_t columns, const std::function<void(T* piece, std::size_t n)>& next);

  Extent extent(const std::string& name) const;
  /// Reads into data[extent(name).size()], which must hold `size` values. The stored type must be T.
  template <class T>
  void read(const std::string& name, T* data, std::size_t size) const;
  template <class T>
  std::vector<T> read(const std::string& name) const {
    std::vector<T> data(extent(name).size());
    read(name, data.data(), data.size());
    return data;
  }

  /// Attributes of a group or array ("/" is the file itself). An existing one is replaced.
  void set_attribute(const std::string& object, const std::string& name, double value);
  void set_attribute(const std::string& object, const std::string& name, std::int64_t value);
  void set_attribute(const std::string& object, const std::string& name, const std::string& value);
  bool has_attribute(const std::string& object, const std::string& name) const;
  double real_attribute(const std::string& object, const std::string& name) const;
  std::int64_t integer_attribute(const std::string& object, const std::string& name) const;
  std::string text_attribute(const std::string& object, const std::string& name) const;
  /// Attributes of a group made by make_group that hold one real number, in the order in which they were made.
  std::vector<std::pair<std::string, double>> real_attributes(const std::string& object) const;

  void make_group(const std::string& name);

  /// From here on names count from a new group ("." itself) that nobody can find; link_as() gives it its place under the
  /// root, `instead_of` those groups. A program that is killed at any of its writes leaves a file (create_to_grow) in
  /// which that is done or not done; a file that is closed before, one that never had the group.
  void begin_unlinked();
  void link_as(const std::string& name, const std::vector<std::string>& instead_of);

  bool has(const std::string& name) const;
  std::vector<std::string> children(const std::string& group) const;  ///< sorted by name
  void remove(const std::string& name);

  const std::string& path() const { return path_; }

 private:
  std::int64_t here() const { return unlinked_ >= 0 ? unlinked_ : id_; }
  int trim(std::uint64_t end) const;
  std::int64_t make_array(const std::string& name, std::int64_t type, std::size_t rows, std::size_t columns, int deflate, std::size_t bytes);
  template <class T>
  void write_attribute(const std::string& object, const std::string& name, T value);
  template <class T>
  T read_attribute(const std::string& object, const std::string& name) const;

  std::string path_;
  std::int64_t id_ = -1;
  std::int64_t unlinked_ = -1;  ///< the group that is being written and has no name yet
  int descriptor_ = -1;  ///< of our own, for claiming room
  bool writable_ = false;
};

}  // namespace io::hdf5
