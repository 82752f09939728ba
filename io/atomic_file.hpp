// SPDX-License-Identifier: Apache-2.0
// Files that are there whole or not at all: written beside their place and renamed.
#pragma once

#include <string>

namespace io {

/// Replaces the file at `path` by `text`, which can be made again: it is not forced to the disk. Throws GuardError; what was
/// there before stays then.
void write_atomically(const std::string& path, const std::string& text);

/// Forces the closed file `temporary` to the disk and gives it the name `path`. Throws GuardError.
void put_in_place(const std::string& temporary, const std::string& path);

}  // namespace io
