// SPDX-License-Identifier: Apache-2.0
// io::Case to TOML that reads back to the same Case: every number in SI with all its digits. Settings that stand for a
// default of the program (-1, 0) are left out.
#include <fmt/format.h>

#include "io/case_file.hpp"
#include "io/material_file.hpp"
#include "io/toml_reader.hpp"

namespace io {
namespace {

using core::exact_decimal;
using toml_reader::toml_string;

std::string line(const char* key, const std::string& value) { return fmt::format("{} = {}\n", key, value); }
std::string line(const char* key, double value) { return line(key, exact_decimal(value)); }
std::string line(const char* key, bool value) { return line(key, std::string(value ? "true" : "false")); }
std::string line(const char* key, const core::Vec3& v) {
  return line(key, fmt::format("[{}, {}, {}]", exact_decimal(v[0]), exact_decimal(v[1]), exact_decimal(v[2])));
}

std::string list(const std::vector<std::string>& texts) {
  std::vector<std::string> parts;
  for (const std::string& t : texts) parts.push_back(toml_string(t));
  return "[" + toml_reader::join(parts) + "]";
}

std::string symmetry(const Case& c) {
  if (c.symmetry_auto) return toml_string("auto");
  std::vector<std::string> planes;
  for (std::size_t k = 0; k < 3; ++k)
    if (c.symmetry.plane[k]) planes.push_back(std::string(1, "xyz"[k]));
  return planes.empty() ? toml_string("none") : list(planes);
}

std::string sleep(double speed) {
  if (speed < 0) return toml_string("off");
  return speed == 0 ? toml_string("exact") : exact_decimal(speed);
}

std::string run(const Case& c) {
  std::string t = "\n[run]\n" + line("mode", toml_string(to_string(c.mode))) + line("end", c.end);
  if (c.mesh_end > 0) t += line("mesh_end", c.mesh_end);
  t += c.fidelity == "custom" ? line("elements_across", std::to_string(c.elements_across))
                              : line("fidelity", toml_string(c.fidelity));
  t += line("symmetry", symmetry(c)) + line("sleep", sleep(c.sleep)) + line("cfl", c.cfl);
  t += line("hourglass", toml_string(c.hourglass));
  if (c.hourglass_coefficient >= 0) t += line("hourglass_coefficient", c.hourglass_coefficient);
  if (c.viscosity_linear >= 0) t += line("viscosity_linear", c.viscosity_linear);
  if (c.viscosity_quadratic >= 0) t += line("viscosity_quadratic", c.viscosity_quadratic);
  return t + line("energy_tolerance", c.energy_tolerance);
}

std::string shape(const BodySpec& b) {
  switch (b.shape) {
    case Shape::sphere: return line("diameter", b.diameter);
    case Shape::cylinder: return line("diameter", b.diameter) + line("length", b.length);
    case Shape::plate:
      return line("size", fmt::format("[{}, {}]", exact_decimal(b.size[0]), exact_decimal(b.size[1]))) +
             line("thickness", b.size[2]);
    case Shape::box: return line("size", b.size);
    case Shape::mesh: return line("file", toml_string(b.file));
  }
  return "";
}

std::string body(const BodySpec& b) {
  std::string t = "\n[[body]]\n" + line("name", toml_string(b.name)) + line("shape", toml_string(to_string(b.shape)));
  t += shape(b) + line("center", b.center) + line("normal", b.normal) + line("velocity", b.velocity);
  t += line("spin", b.spin) + line("material", toml_string(b.material));
  if (b.element_size && b.shape != Shape::mesh) t += line("element_size", *b.element_size);
  if (b.fine_radius) t += line("fine_radius", *b.fine_radius);
  if (b.elements_through) t += line("elements_through", std::to_string(*b.elements_through));
  return t;
}

std::string bodies(const Case& c) {
  std::string t;
  for (const BodySpec& b : c.bodies) t += body(b);
  for (const RigidWall& w : c.walls) t += "\n[[wall]]\n" + line("point", w.point) + line("normal", w.normal);
  return t;
}

std::string materials(const Case& c) {
  std::string t;
  for (const auto& [name, m] : c.materials) t += "\n" + write_material(m);
  return t;
}

std::string convert(const Case& c) {
  return "\n[convert]\n" + line("criterion", list(c.criteria)) + line("deformation", c.deformation) +
         line("jacobian_ratio", c.jacobian_ratio) + line("min_angle", c.min_angle) +
         line("plastic_strain", c.plastic_strain) + line("timestep_ratio", c.timestep_ratio) +
         line("damage", c.damage) + line("particles_per_edge", std::to_string(c.particles_per_edge)) +
         line("bond", c.bond) + line("keep_nodes", c.keep_nodes);
}

std::string output(const Case& c) {
  std::string t = "\n[output]\n";
  if (c.every > 0) t += line("every", c.every);
  if (c.history_every > 0) t += line("history_every", c.history_every);
  if (c.checkpoint_every > 0) t += line("checkpoint_every", c.checkpoint_every);
  return t;
}

std::string reference(const Case& c) {
  if (c.reference.empty()) return "";
  std::string t = "\n[reference]\n";
  for (const auto& [key, r] : c.reference)
    t += fmt::format("{} = {{ value = {}, source = {} }}\n", toml_string(key),
                     key.ends_with("perforated") ? (r.value != 0 ? "true" : "false") : exact_decimal(r.value), toml_string(r.source));
  return t;
}

}  // namespace

std::string write_case(const Case& c) {
  return "# SI units: m, kg, s, Pa, J/kg, K\n" + line("title", toml_string(c.title)) + run(c) + bodies(c) + convert(c) + "\n[contact]\n" +
         line("enabled", c.contact) + line("friction", c.friction) + output(c) + reference(c) + materials(c);
}

std::string write_scene(const Case& c) { return line("mode", toml_string(to_string(c.mode))) + bodies(c) + materials(c); }

}  // namespace io
