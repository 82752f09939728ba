// SPDX-License-Identifier: Apache-2.0
// The case file (TOML) to io::Case and back. Every key has a unit, a default and a range; whatever cannot be used throws
// core::CaseError with file, line, key, value and what would be valid. Reading writes nothing.
#pragma once

#include <string>
#include <vector>

#include "io/case.hpp"

namespace io {

/// Reads a case. `path` is the file, or a folder that holds a case.toml. `overrides` are "key=value" as after --set;
/// `mode_override` replaces run.mode where it is not empty. Paths of meshes and tables come out absolute.
Case read_case(const std::string& path, const std::vector<std::string>& overrides = {},
               const std::string& mode_override = "");

/// The resolved case as TOML: SI numbers with all their digits, materials written out. Reads back to the same Case.
std::string write_case(const Case& c);

/// The part of it that a state belongs to and cannot be carried over from: mode, bodies, walls and materials.
std::string write_scene(const Case& c);

/// "hybrid", "sphere", ...
const char* to_string(Mode mode);
const char* to_string(Shape shape);

/// Elements over the projectile that a fidelity stands for: draft 10, standard 20, fine 32, reference 48.
int elements_across(const std::string& fidelity);
std::vector<std::string> fidelities();

}  // namespace io
