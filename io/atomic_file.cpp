// SPDX-License-Identifier: Apache-2.0
#include "io/atomic_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "core/error.hpp"

namespace io {
namespace {

[[noreturn]] void stop(const std::string& path, int error, std::size_t bytes) {
  std::string message = fmt::format("{}: cannot be written: {}", path, std::strerror(error));
  if (error == ENOSPC || error == EDQUOT || error == EFBIG)
    throw core::NoRoomError(message + fmt::format("; {} bytes were needed; {}", bytes, no_room_advice));
  throw core::GuardError(message);
}

/// Returns errno.
int write_all(int descriptor, const std::string& text) {
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t n = ::write(descriptor, text.data() + done, text.size() - done);
    if (n < 0 && errno != EINTR) return errno;
    if (n > 0) done += static_cast<std::size_t>(n);
  }
  return 0;
}

/// Best effort: not every file system knows how.
void sync_folder(const std::string& path) {
  const std::filesystem::path folder = std::filesystem::absolute(path).parent_path();
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  ::fsync(descriptor);
  ::close(descriptor);
}

}  // namespace

void put_in_place(const std::string& temporary, const std::string& path) {
  const int descriptor = ::open(temporary.c_str(), O_RDWR | O_CLOEXEC);
  if (descriptor < 0) stop(path, errno, 0);
  const int error = ::fsync(descriptor) != 0 && errno != EINVAL ? errno : 0;
  ::close(descriptor);
  if (error != 0) stop(path, error, 0);
  if (std::rename(temporary.c_str(), path.c_str()) != 0) stop(path, errno, 0);
  sync_folder(path);
}

void require_place(const std::string& option, const std::string& path) {
  std::error_code ignored;
  const auto folder = std::filesystem::absolute(path).parent_path();
  if (!std::filesystem::is_directory(folder, ignored)) throw core::CaseError(fmt::format("{} {}: there is no folder {}", option, path, folder.string()));
  if (std::filesystem::is_directory(path, ignored)) throw core::CaseError(fmt::format("{} {}: is a folder; name a file", option, path));
}

void write_atomically(const std::string& path, const std::string& text) {
  struct stat status{};
  const bool replaced = ::lstat(path.c_str(), &status) != 0 || S_ISREG(status.st_mode) || S_ISDIR(status.st_mode);
  const std::string temporary = replaced ? path + ".tmp" : path;
  const int descriptor = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor < 0) stop(path, errno, text.size());
  int error = write_all(descriptor, text);
  if (::close(descriptor) != 0 && error == 0) error = errno;
  if (error == 0 && replaced && std::rename(temporary.c_str(), path.c_str()) != 0) error = errno;
  if (error == 0) return;
  if (replaced) std::remove(temporary.c_str());
  stop(path, error, text.size());
}

}  // namespace io
