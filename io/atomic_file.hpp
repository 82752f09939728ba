// SPDX-License-Identifier: Apache-2.0
// Files that are there whole or not at all: written beside their place and renamed.
#pragma once

#include <string>

namespace io {

/// Stands in every message of core::NoRoomError.
inline constexpr const char* no_room_advice = "make room, or give another --out";

/// Replaces the file at `path` by `text`, which can be made again: it is not forced to the disk. Throws GuardError; what was
/// there before stays then. A link, a pipe or a device stays what it is: the text is written into it.
void write_atomically(const std::string& path, const std::string& text);

/// Throws CaseError where `path`, which the user gave after `option`, is a folder or in none: before work is done for it.
void require_place(const std::string& option, const std::string& path);

/// Forces the closed file `temporary` to the disk and gives it the name `path`. Throws GuardError.
void put_in_place(const std::string& temporary, const std::string& path);

}  // namespace io
