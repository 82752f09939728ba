// SPDX-License-Identifier: Apache-2.0
// Materials from the library (material/library.toml, built into the program) and from a case's [materials.NAME].
// A group (eos, strength, damage, spall, phase) names its model and every constant of it; with `base`, a group without
// model or with the base's model takes the constants it does not state from there.
#pragma once

#include <string>
#include <vector>

#include "io/toml_reader.hpp"
#include "material/material.hpp"

namespace io {

/// A material of the library. Throws CaseError with the nearest names.
material::Material find_material(const std::string& name);

/// Names in the library, in its order.
std::vector<std::string> material_names();

/// Materials of a case: its own first, then the library's.
class Materials {
 public:
  /// `own` is the case's [materials] table, or null; files that it names are relative to `folder`.
  explicit Materials(const toml_reader::Node* own = nullptr, const std::string& folder = "");

  bool has(const std::string& name) const;
  material::Material find(const std::string& name) const;
  /// The material and what it is based on, down to where its constants begin.
  std::vector<std::string> descent(const std::string& name) const;
  std::vector<std::string> names() const;
  std::vector<std::string> own_names() const;

 private:
  toml_reader::Node merged(const std::string& name, std::vector<std::string>& chain) const;

  toml_reader::Node own_;
};

/// The library and what the [materials] of a case file add to it.
Materials materials_of(const std::string& file);

/// [materials.NAME] in full: SI numbers with all their digits, sources kept.
std::string write_material(const material::Material& m);

}  // namespace io
