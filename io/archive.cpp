// SPDX-License-Identifier: Apache-2.0
#include "io/archive.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>

#include "core/error.hpp"
#include "io/atomic_file.hpp"

namespace io {
namespace {

constexpr const char* version_attribute = "ejecta_checkpoint_version";

}  // namespace

ArchiveWriter::ArchiveWriter(const std::string& path, std::int64_t version)
    : path_(path), temporary_(path + ".tmp"), file_(std::make_unique<hdf5::File>(temporary_, hdf5::Access::create)) {
  file_->set_attribute("/", version_attribute, version);
}

ArchiveWriter::~ArchiveWriter() {
  if (!file_) return;
  file_.reset();
  std::remove(temporary_.c_str());
}

void ArchiveWriter::operator()(const std::string& name, const std::string& value) {
  file_->write(name, reinterpret_cast<const std::uint8_t*>(value.data()), value.size());
}

void ArchiveWriter::operator()(const std::string& name, const std::vector<std::string>& value) {
  std::string all;
  std::vector<std::uint64_t> start{0};
  for (const std::string& s : value) {
    all += s;
    start.push_back(all.size());
  }
  (*this)(name + "/text", all);
  (*this)(name + "/start", start);
}

void ArchiveWriter::commit() {
  file_->close();
  put_in_place(temporary_, path_);
  file_.reset();
}

ArchiveReader::ArchiveReader(const std::string& path, std::int64_t version) : file_(path, hdf5::Access::read) {
  if (!file_.has_attribute("/", version_attribute)) throw core::GuardError(path + ": is no checkpoint of Ejecta");
  const std::int64_t stored = file_.integer_attribute("/", version_attribute);
  if (stored != version)
    throw core::GuardError(fmt::format("{}: is a checkpoint of version {}, this program reads version {}; resume with the "
                                       "program that wrote it, or run the case again", path, stored, version));
}

void ArchiveReader::operator()(const std::string& name, std::string& value) const {
  value.resize(file_.extent(name).size());
  file_.read(name, reinterpret_cast<std::uint8_t*>(value.data()), value.size());
}

void ArchiveReader::operator()(const std::string& name, std::vector<std::string>& value) const {
  const auto all = get<std::string>(name + "/text");
  const auto start = get<std::vector<std::uint64_t>>(name + "/start");
  value.clear();
  for (std::size_t k = 0; k + 1 < start.size(); ++k) value.push_back(all.substr(start[k], start[k + 1] - start[k]));
}

void ArchiveReader::check_columns(const std::string& name, const hdf5::Extent& extent, std::size_t columns) const {
  const bool fits = columns == 0 ? extent.dimensions == 1 : extent.dimensions == 2 && extent.columns == columns;
  if (!fits)
    throw core::GuardError(fmt::format("{}: '{}' cannot be read: it has {} columns, {} are expected", file_.path(), name,
                                       extent.columns, columns ? columns : 1));
}

}  // namespace io
