// SPDX-License-Identifier: Apache-2.0
// Checkpoints: everything a run needs to go on with the same bits, by name. Written to a temporary file beside the
// target, forced to the disk and renamed, so that a kill or a full disk leaves the previous checkpoint as it was.
// Writer and reader are called alike, archive("nodes/x", x), so that one function can list the state for both.
#pragma once

#include <array>
#include <concepts>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "core/types.hpp"
#include "io/hdf5.hpp"

namespace io {

/// Goes up whenever what a checkpoint holds changes.
constexpr std::int64_t checkpoint_version = 7;

/// What an element of an array is stored as: `columns` numbers of type T.
template <class T>
struct Stored {
  using Number = T;
  static constexpr std::size_t columns = 0;
};
template <>
struct Stored<core::Vec3> {
  using Number = double;
  static constexpr std::size_t columns = 3;
};
template <class T, std::size_t n>
struct Stored<std::array<T, n>> {
  using Number = T;
  static constexpr std::size_t columns = n;
};

template <class T>
concept Scalar = std::is_arithmetic_v<T> || std::is_enum_v<T>;

class ArchiveWriter {
 public:
  static constexpr bool reading = false;

  /// Begins path + ".tmp".
  explicit ArchiveWriter(const std::string& path, std::int64_t version = checkpoint_version);
  /// Without commit() the temporary is removed and the previous checkpoint stays.
  ~ArchiveWriter();
  ArchiveWriter(const ArchiveWriter&) = delete;
  ArchiveWriter& operator=(const ArchiveWriter&) = delete;

  template <class T>
  void operator()(const std::string& name, const std::vector<T>& value) {
    using S = Stored<T>;
    static_assert(sizeof(T) == sizeof(typename S::Number) * (S::columns ? S::columns : 1));
    file_->write(name, reinterpret_cast<const typename S::Number*>(value.data()), value.size(), S::columns);
  }
  template <Scalar T>
  void operator()(const std::string& name, const T& value) {
    if constexpr (std::is_floating_point_v<T>) {
      const double v = value;
      file_->write(name, &v, 1);
    } else {
      const std::int64_t v = static_cast<std::int64_t>(value);
      file_->write(name, &v, 1);
    }
  }
  void operator()(const std::string& name, const core::Vec3& value) { file_->write(name, value.data(), 3); }
  template <class T, std::size_t n>
  void operator()(const std::string& name, const std::array<T, n>& value) {
    file_->write(name, value.data(), n);
  }
  void operator()(const std::string& name, const std::string& value);
  void operator()(const std::string& name, const std::vector<std::string>& value);

  /// Puts the checkpoint in the place of the previous one. Throws GuardError; the previous one stays then.
  void commit();

 private:
  std::string path_, temporary_;
  std::unique_ptr<hdf5::File> file_;
};

/// A checkpoint to be written later, while the state that it was taken from goes on.
class ArchiveCopy {
 public:
  template <class T>
  void operator()(const std::string& name, const T& value) {
    parts_.push_back([name, value](ArchiveWriter& a) { a(name, value); });
  }
  /// Writes it and frees it part by part. Throws GuardError; the previous checkpoint stays then.
  void write(const std::string& path) {
    ArchiveWriter a(path);
    for (auto& part : parts_) {
      part(a);
      part = nullptr;
    }
    a.commit();
  }

 private:
  std::vector<std::function<void(ArchiveWriter&)>> parts_;
};

/// Memory that an ArchiveCopy of the same state takes.
class ArchiveSize {
 public:
  double bytes = 0;

  template <class T>
  void operator()(const std::string&, const std::vector<T>& value) {
    bytes += static_cast<double>(value.size() * sizeof(T));
  }
  template <class T>
  void operator()(const std::string&, const T&) {
    bytes += sizeof(T);
  }
};

class ArchiveReader {
 public:
  static constexpr bool reading = true;

  /// Throws GuardError where the file is no checkpoint or one of another version.
  explicit ArchiveReader(const std::string& path, std::int64_t version = checkpoint_version);

  bool has(const std::string& name) const { return file_.has(name); }

  template <class T>
  void operator()(const std::string& name, std::vector<T>& value) const {
    using S = Stored<T>;
    const hdf5::Extent extent = file_.extent(name);
    check_columns(name, extent, S::columns);
    value.resize(extent.rows);
    file_.read(name, reinterpret_cast<typename S::Number*>(value.data()), extent.size());
  }
  template <Scalar T>
  void operator()(const std::string& name, T& value) const {
    if constexpr (std::is_floating_point_v<T>) {
      double v = 0;
      file_.read(name, &v, 1);
      value = static_cast<T>(v);
    } else {
      std::int64_t v = 0;
      file_.read(name, &v, 1);
      value = static_cast<T>(v);
    }
  }
  void operator()(const std::string& name, core::Vec3& value) const { file_.read(name, value.data(), 3); }
  template <class T, std::size_t n>
  void operator()(const std::string& name, std::array<T, n>& value) const {
    file_.read(name, value.data(), n);
  }
  void operator()(const std::string& name, std::string& value) const;
  void operator()(const std::string& name, std::vector<std::string>& value) const;

  /// The value by itself: archive.get<double>("time").
  template <class T>
  T get(const std::string& name) const {
    T value{};
    (*this)(name, value);
    return value;
  }

 private:
  void check_columns(const std::string& name, const hdf5::Extent& extent, std::size_t columns) const;

  hdf5::File file_;
};

}  // namespace io
