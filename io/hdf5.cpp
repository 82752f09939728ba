// SPDX-License-Identifier: Apache-2.0
#include "io/hdf5.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <hdf5.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string_view>

#include "core/error.hpp"
#include "io/atomic_file.hpp"

namespace io::hdf5 {
namespace {

/// An identifier of the library, released by the function that goes with its kind.
class Handle {
 public:
  Handle(hid_t id, herr_t (*release)(hid_t)) : id_(id), release_(release) {}
  ~Handle() {
    if (id_ >= 0) release_(id_);
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  operator hid_t() const { return id_; }
  bool valid() const { return id_ >= 0; }

 private:
  hid_t id_;
  herr_t (*release_)(hid_t);
};

template <class T>
hid_t native();
template <>
hid_t native<double>() { return H5T_NATIVE_DOUBLE; }
template <>
hid_t native<float>() { return H5T_NATIVE_FLOAT; }
template <>
hid_t native<std::int32_t>() { return H5T_NATIVE_INT32; }
template <>
hid_t native<std::int64_t>() { return H5T_NATIVE_INT64; }
template <>
hid_t native<std::uint8_t>() { return H5T_NATIVE_UINT8; }
template <>
hid_t native<std::uint16_t>() { return H5T_NATIVE_UINT16; }
template <>
hid_t native<std::uint32_t>() { return H5T_NATIVE_UINT32; }
template <>
hid_t native<std::uint64_t>() { return H5T_NATIVE_UINT64; }

/// What the library says went wrong: the system's errno where there is one, else its innermost message.
struct Cause {
  int error = 0;
  std::string text;
};

herr_t collect(unsigned n, const H5E_error2_t* entry, void* data) {
  Cause& cause = *static_cast<Cause*>(data);
  const std::string text = entry->desc ? entry->desc : "";
  constexpr std::string_view mark = "errno = ";
  if (const std::size_t at = text.find(mark); cause.error == 0 && at != std::string::npos)
    cause.error = std::atoi(text.c_str() + at + mark.size());
  if (n == 0) cause.text = text;
  return 0;
}

Cause cause_of_failure() {
  Cause cause;
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, collect, &cause);
  H5Eclear2(H5E_DEFAULT);
  return cause;
}

bool is_full(int error) { return error == ENOSPC || error == EDQUOT || error == EFBIG; }

[[noreturn]] void stop(const std::string& path, const std::string& action, int error, const std::string& text,
                       std::size_t bytes = 0) {
  std::string message = fmt::format("{}: {}: {}", path, action, error != 0 ? std::strerror(error) : text);
  if (is_full(error)) {
    if (bytes > 0) message += fmt::format("; {} bytes more were needed", bytes);
    throw core::NoRoomError(message + "; " + no_room_advice + ", or write less often (output.every)");
  }
  throw core::GuardError(message);
}

[[noreturn]] void stop(const std::string& path, const std::string& action, std::size_t bytes = 0) {
  const Cause cause = cause_of_failure();
  stop(path, action, cause.error, cause.text.empty() ? "HDF5 gives no reason" : cause.text, bytes);
}

void silence() {
  // A file that could not be closed (full disk) must not be closed again by the library's exit handler.
  static const bool done = H5dont_atexit() >= 0 && H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr) >= 0;
  (void)done;
}

Handle make_access() {
  const hid_t properties = H5Pcreate(H5P_FILE_ACCESS);
  H5Pset_file_locking(properties, false, true);  // a viewer that has the file open does not stop a run
  return {properties, H5Pclose};
}

bool creates(Access access) { return access == Access::create || access == Access::create_to_grow; }

Handle make_creation(Access access) {
  constexpr unsigned most = 65535, expected = 1000, name_length = 12;
  const hid_t properties = H5Pcreate(H5P_FILE_CREATE);
  if (access == Access::create_to_grow) {
    H5Pset_link_creation_order(properties, H5P_CRT_ORDER_TRACKED);  // headers of this kind alone hold links
    H5Pset_link_phase_change(properties, most, most);
    H5Pset_est_link_info(properties, expected, name_length);
  }
  return {properties, H5Pclose};
}

hid_t open_file(const std::string& path, Access access, hid_t creation, hid_t properties) {
  if (creates(access)) return H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation, properties);
  return H5Fopen(path.c_str(), access == Access::read ? H5F_ACC_RDONLY : H5F_ACC_RDWR, properties);
}

const char* action_of(Access access) {
  return creates(access) ? "cannot be created" : access == Access::read ? "cannot be read" : "cannot be opened";
}

Handle make_links() {
  const hid_t properties = H5Pcreate(H5P_LINK_CREATE);
  H5Pset_create_intermediate_group(properties, 1);
  return {properties, H5Pclose};
}

Handle make_group_creation() {
  const hid_t properties = H5Pcreate(H5P_GROUP_CREATE);
  H5Pset_attr_creation_order(properties, H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED);
  return {properties, H5Pclose};
}

hid_t make_layout(int deflate, const hsize_t* dims, int rank) {
  const hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_obj_track_times(properties, false);  // the same run gives the same bytes
  if (deflate > 0 && dims[0] > 0) {
    hsize_t chunk[2] = {std::min<hsize_t>(dims[0], 65536), rank > 1 ? dims[1] : 1};
    H5Pset_chunk(properties, rank, chunk);
    H5Pset_shuffle(properties);
    H5Pset_deflate(properties, static_cast<unsigned>(deflate));
  }
  return properties;
}

constexpr std::size_t metadata_room = 64 * 1024;  // groups and attributes between two arrays

}  // namespace

File::File(const std::string& path, Access access) : path_(path), writable_(access != Access::read) {
  silence();
  std::error_code ignored;
  if (!creates(access) && !std::filesystem::exists(path, ignored)) stop(path, action_of(access), ENOENT, "");
  if (std::filesystem::is_directory(path, ignored)) stop(path, action_of(access), EISDIR, "");
  const Handle creation = make_creation(access), properties = make_access();  // to be released after the cause of a failure
  id_ = open_file(path, access, creation, properties);                        // was asked for: releasing clears it
  if (id_ < 0) stop(path, action_of(access));
  if (writable_) descriptor_ = ::open(path.c_str(), O_RDWR | O_CLOEXEC);
}

File::~File() {
  try {
    close();
  } catch (const core::GuardError&) {
    // whoever wants to know calls close()
  }
}

File::File(File&& other) noexcept { *this = std::move(other); }

File& File::operator=(File&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(id_, other.id_);
  std::swap(unlinked_, other.unlinked_);
  std::swap(descriptor_, other.descriptor_);
  std::swap(writable_, other.writable_);
  return *this;
}

void File::close() {
  if (id_ < 0) return;
  if (unlinked_ >= 0) H5Gclose(unlinked_);  // with all that it holds
  unlinked_ = -1;
  haddr_t end = 0;
  const bool flushed = !writable_ || (H5Fflush(id_, H5F_SCOPE_LOCAL) >= 0 && H5Fget_eoa(id_, &end) >= 0);
  const Cause cause = flushed ? Cause{} : cause_of_failure();
  const bool closed = H5Fclose(id_) >= 0;
  id_ = -1;
  const int error = flushed && closed ? trim(end) : 0;
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
  if (!flushed) stop(path_, "cannot be written", cause.error, cause.text);
  if (!closed) stop(path_, "cannot be closed");
  if (error != 0) stop(path_, "cannot be closed", error, "");
}

/// Gives back the room that was claimed and not used. Returns errno.
int File::trim(std::uint64_t end) const {
  struct stat status{};
  if (descriptor_ < 0 || ::fstat(descriptor_, &status) != 0 || !S_ISREG(status.st_mode)) return 0;
  if (static_cast<std::uint64_t>(status.st_size) <= end) return 0;
  return ::ftruncate(descriptor_, static_cast<off_t>(end)) == 0 ? 0 : errno;
}

/// Claims the bytes behind the end of the file; file systems that cannot do it are left to find out by writing.
void File::claim(std::size_t bytes, const std::string& what) {
  struct stat status{};
  haddr_t used = 0;
  if (descriptor_ < 0 || ::fstat(descriptor_, &status) != 0 || !S_ISREG(status.st_mode)) return;
  if (H5Fget_eoa(id_, &used) < 0) return;
  const std::size_t end = static_cast<std::size_t>(used) + bytes + metadata_room;
  const std::size_t now = static_cast<std::size_t>(status.st_size);
  if (end <= now) return;
  const int error = ::posix_fallocate(descriptor_, static_cast<off_t>(now), static_cast<off_t>(end - now));
  if (!is_full(error)) return;
  [[maybe_unused]] const int undone = ::ftruncate(descriptor_, static_cast<off_t>(now));
  stop(path_, "no room for " + what, error, "", end - now);
}

static std::string not_written(const std::string& name) { return fmt::format("'{}' cannot be written", name); }

/// The array to write to, with room on the disk.
std::int64_t File::make_array(const std::string& name, std::int64_t type, std::size_t rows, std::size_t columns, int deflate, std::size_t bytes) {
  claim(bytes, "'" + name + "'");
  const hsize_t dims[2] = {rows, columns};
  const int rank = columns ? 2 : 1;
  const Handle space(H5Screate_simple(rank, dims, nullptr), H5Sclose);
  const Handle links = make_links();
  const Handle layout(make_layout(deflate, dims, rank), H5Pclose);
  const auto make = [&] { return H5Dcreate2(here(), name.c_str(), type, space, links, layout, H5P_DEFAULT); };
  hid_t made = make();
  if (made < 0) {  // it is there already, mostly; asking first would cost every array a look-up
    if (has(name)) remove(name);
    made = make();
  }
  if (made < 0) stop(path_, not_written(name), bytes);
  return made;
}

template <class T>
void File::write(const std::string& name, const T* data, std::size_t rows, std::size_t columns, int deflate) {
  const std::size_t bytes = sizeof(T) * rows * (columns ? columns : 1);
  const Handle set(make_array(name, native<T>(), rows, columns, deflate, bytes), H5Dclose);
  if (bytes > 0 && H5Dwrite(set, native<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, data) < 0) stop(path_, not_written(name), bytes);
}

template <class T>
void File::write_pieces(const std::string& name, std::size_t rows, std::size_t columns, const std::function<void(T*, std::size_t)>& next) {
  constexpr std::size_t at_once = 1 << 16;
  const std::size_t each = columns ? columns : 1, bytes = sizeof(T) * rows * each;
  const Handle set(make_array(name, native<T>(), rows, columns, 0, bytes), H5Dclose), all(H5Dget_space(set), H5Sclose);
  std::vector<T> piece(std::min(rows, at_once) * each);
  for (std::size_t first = 0; first < rows; first += at_once) {
    const hsize_t from[2] = {first, 0}, size[2] = {std::min(at_once, rows - first), columns};
    next(piece.data(), size[0]);
    const Handle here(H5Screate_simple(columns ? 2 : 1, size, nullptr), H5Sclose);
    if (H5Sselect_hyperslab(all, H5S_SELECT_SET, from, nullptr, size, nullptr) < 0 || H5Dwrite(set, native<T>(), here, all, H5P_DEFAULT, piece.data()) < 0)
      stop(path_, not_written(name), bytes);
  }
}

Extent File::extent(const std::string& name) const {
  const Handle set(H5Dopen2(here(), name.c_str(), H5P_DEFAULT), H5Dclose);
  if (!set.valid()) stop(path_, fmt::format("'{}' cannot be read", name));
  const Handle space(H5Dget_space(set), H5Sclose);
  hsize_t dims[2] = {1, 1};
  const int rank = H5Sget_simple_extent_ndims(space);
  if (rank < 1 || rank > 2 || H5Sget_simple_extent_dims(space, dims, nullptr) < 0)
    stop(path_, fmt::format("'{}' cannot be read", name), 0, fmt::format("it has {} dimensions, 1 or 2 are known", rank));
  return {static_cast<std::size_t>(dims[0]), static_cast<std::size_t>(rank == 2 ? dims[1] : 1), rank};
}

template <class T>
void File::read(const std::string& name, T* data, std::size_t size) const {
  const std::string action = fmt::format("'{}' cannot be read", name);
  const std::size_t stored = extent(name).size();
  if (stored != size) stop(path_, action, 0, fmt::format("it holds {} values, {} are expected", stored, size));
  const Handle set(H5Dopen2(here(), name.c_str(), H5P_DEFAULT), H5Dclose);
  const Handle type(H5Dget_type(set), H5Tclose);
  if (H5Tequal(type, native<T>()) <= 0) stop(path_, action, 0, "it holds numbers of another type");
  if (size > 0 && H5Dread(set, native<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, data) < 0) stop(path_, action);
}

template <class T>
void File::write_attribute(const std::string& object, const std::string& name, T value) {
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  if (has_attribute(object, name)) H5Adelete_by_name(here(), object.c_str(), name.c_str(), H5P_DEFAULT);
  const Handle a(H5Acreate_by_name(here(), object.c_str(), name.c_str(), native<T>(), space, H5P_DEFAULT, H5P_DEFAULT,
                                   H5P_DEFAULT), H5Aclose);
  if (!a.valid() || H5Awrite(a, native<T>(), &value) < 0)
    stop(path_, fmt::format("attribute '{}' of '{}' cannot be written", name, object), sizeof(T));
}

template <class T>
T File::read_attribute(const std::string& object, const std::string& name) const {
  T value{};
  const Handle a(H5Aopen_by_name(here(), object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  if (!a.valid() || H5Aread(a, native<T>(), &value) < 0)
    stop(path_, fmt::format("attribute '{}' of '{}' cannot be read", name, object));
  return value;
}

void File::set_attribute(const std::string& object, const std::string& name, double value) {
  write_attribute(object, name, value);
}
void File::set_attribute(const std::string& object, const std::string& name, std::int64_t value) {
  write_attribute(object, name, value);
}

void File::set_attribute(const std::string& object, const std::string& name, const std::string& value) {
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type, std::max<std::size_t>(value.size(), 1));
  H5Tset_strpad(type, H5T_STR_NULLPAD);
  H5Tset_cset(type, H5T_CSET_UTF8);
  if (has_attribute(object, name)) H5Adelete_by_name(here(), object.c_str(), name.c_str(), H5P_DEFAULT);
  const Handle a(H5Acreate_by_name(here(), object.c_str(), name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                 H5Aclose);
  if (!a.valid() || H5Awrite(a, type, value.c_str()) < 0)
    stop(path_, fmt::format("attribute '{}' of '{}' cannot be written", name, object), value.size());
}

bool File::has_attribute(const std::string& object, const std::string& name) const {
  const bool found = H5Aexists_by_name(here(), object.c_str(), name.c_str(), H5P_DEFAULT) > 0;
  H5Eclear2(H5E_DEFAULT);
  return found;
}

double File::real_attribute(const std::string& object, const std::string& name) const {
  return read_attribute<double>(object, name);
}
std::int64_t File::integer_attribute(const std::string& object, const std::string& name) const {
  return read_attribute<std::int64_t>(object, name);
}

std::string File::text_attribute(const std::string& object, const std::string& name) const {
  const Handle a(H5Aopen_by_name(here(), object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  const std::string action = fmt::format("attribute '{}' of '{}' cannot be read", name, object);
  if (!a.valid()) stop(path_, action);
  const Handle type(H5Aget_type(a), H5Tclose);
  if (H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) > 0)
    stop(path_, action, 0, "it is no text of fixed length");
  std::string value(H5Tget_size(type), '\0');
  if (H5Aread(a, type, value.data()) < 0) stop(path_, action);
  while (!value.empty() && value.back() == '\0') value.pop_back();
  return value;
}

std::vector<std::pair<std::string, double>> File::real_attributes(const std::string& object) const {
  std::vector<std::string> names;
  const auto take = [](hid_t, const char* name, const H5A_info_t*, void* data) -> herr_t {
    static_cast<std::vector<std::string>*>(data)->push_back(name);
    return 0;
  };
  hsize_t from = 0;
  if (H5Aiterate_by_name(here(), object.c_str(), H5_INDEX_CRT_ORDER, H5_ITER_INC, &from, take, &names, H5P_DEFAULT) < 0)
    stop(path_, fmt::format("attributes of '{}' cannot be read", object));
  std::vector<std::pair<std::string, double>> result;
  for (const std::string& name : names) {
    const Handle a(H5Aopen_by_name(here(), object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    const Handle type(H5Aget_type(a), H5Tclose);
    if (H5Tget_class(type) == H5T_FLOAT) result.emplace_back(name, real_attribute(object, name));
  }
  return result;
}

void File::make_group(const std::string& name) {
  const Handle links = make_links();
  const Handle creation = make_group_creation();
  const Handle group(H5Gcreate2(here(), name.c_str(), links, creation, H5P_DEFAULT), H5Gclose);
  if (!group.valid()) stop(path_, fmt::format("group '{}' cannot be made", name));
}

void File::begin_unlinked() {
  const Handle creation = make_group_creation();
  unlinked_ = H5Gcreate_anon(id_, creation, H5P_DEFAULT);
  if (unlinked_ < 0) stop(path_, "a group cannot be made");
}

void File::link_as(const std::string& name, const std::vector<std::string>& instead_of) {
  const std::int64_t group = std::exchange(unlinked_, -1);
  const Handle made(group, H5Gclose);
  const std::string action = fmt::format("group '{}' cannot be made", name);
  if (H5Fflush(id_, H5F_SCOPE_LOCAL) < 0) stop(path_, action);
  for (const std::string& old : instead_of) remove(old);
  if (H5Olink(group, id_, name.c_str(), H5P_DEFAULT, H5P_DEFAULT) < 0) stop(path_, action);
}

bool File::has(const std::string& name) const {
  // every group on the way has to be there before the library may be asked for the next
  for (std::size_t end = name.find('/', 1); end != std::string::npos; end = name.find('/', end + 1))
    if (H5Lexists(here(), name.substr(0, end).c_str(), H5P_DEFAULT) <= 0) return false;
  return H5Lexists(here(), name.c_str(), H5P_DEFAULT) > 0;
}

std::vector<std::string> File::children(const std::string& group) const {
  std::vector<std::string> names;
  const auto take = [](hid_t, const char* name, const H5L_info_t*, void* data) -> herr_t {
    static_cast<std::vector<std::string>*>(data)->push_back(name);
    return 0;
  };
  hsize_t from = 0;
  if (H5Literate_by_name(here(), group.c_str(), H5_INDEX_NAME, H5_ITER_INC, &from, take, &names, H5P_DEFAULT) < 0)
    stop(path_, fmt::format("group '{}' cannot be read", group));
  std::sort(names.begin(), names.end());
  return names;
}

void File::remove(const std::string& name) {
  if (H5Ldelete(here(), name.c_str(), H5P_DEFAULT) < 0) stop(path_, fmt::format("'{}' cannot be removed", name));
}

template void File::write(const std::string&, const double*, std::size_t, std::size_t, int);
template void File::write(const std::string&, const float*, std::size_t, std::size_t, int);
template void File::write(const std::string&, const std::int32_t*, std::size_t, std::size_t, int);
template void File::write(const std::string&, const std::int64_t*, std::size_t, std::size_t, int);
template void File::write(const std::string&, const std::uint16_t*, std::size_t, std::size_t, int);
template void File::write(const std::string&, const std::uint8_t*, std::size_t, std::size_t, int);
template void File::write(const std::string&, const std::uint32_t*, std::size_t, std::size_t, int);
template void File::write(const std::string&, const std::uint64_t*, std::size_t, std::size_t, int);
template void File::write_pieces(const std::string&, std::size_t, std::size_t, const std::function<void(double*, std::size_t)>&);
template void File::write_pieces(const std::string&, std::size_t, std::size_t, const std::function<void(std::int32_t*, std::size_t)>&);
template void File::read(const std::string&, double*, std::size_t) const;
template void File::read(const std::string&, float*, std::size_t) const;
template void File::read(const std::string&, std::int32_t*, std::size_t) const;
template void File::read(const std::string&, std::int64_t*, std::size_t) const;
template void File::read(const std::string&, std::uint16_t*, std::size_t) const;
template void File::read(const std::string&, std::uint8_t*, std::size_t) const;
template void File::read(const std::string&, std::uint32_t*, std::size_t) const;
template void File::read(const std::string&, std::uint64_t*, std::size_t) const;

}  // namespace io::hdf5
