// SPDX-License-Identifier: Apache-2.0
#include "io/case_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <set>
#include <span>

#include "core/error.hpp"
#include "io/material_file.hpp"
#include "io/toml_reader.hpp"

namespace io {
namespace {

using core::Dimension;
using toml_reader::any_number;
using toml_reader::Node;
using toml_reader::not_negative;
using toml_reader::positive;
using toml_reader::Table;

template <class E>
struct Name {
  E value;
  const char* name;
};
constexpr std::array<Name<Mode>, 4> mode_names{
    {{Mode::hybrid, "hybrid"}, {Mode::erosion, "erosion"}, {Mode::fem, "fem"}, {Mode::sph, "sph"}}};
constexpr std::array<Name<Shape>, 5> shape_names{{{Shape::sphere, "sphere"}, {Shape::cylinder, "cylinder"},
                                                  {Shape::plate, "plate"}, {Shape::box, "box"}, {Shape::mesh, "mesh"}}};
struct Fidelity {
  const char* name;
  int across;
};
constexpr std::array<Fidelity, 4> fidelity_names{{{"draft", 10}, {"standard", 20}, {"fine", 32}, {"reference", 48}}};

template <class Table_>
std::vector<std::string> names_of(const Table_& table) {
  std::vector<std::string> names;
  for (const auto& row : table) names.push_back(row.name);
  return names;
}

template <class E, std::size_t n>
E read_choice(const Table& t, const char* key, const std::array<Name<E>, n>& table) {
  const std::string chosen = t.choice(key, names_of(table));
  for (const auto& row : table)
    if (chosen == row.name) return row.value;
  return table[0].value;
}

/// The named table of the root, an empty one where it is absent.
class Section {
 public:
  Section(const Node& root, const std::string& name, std::vector<std::string> keys)
      : table_(root.find(name) ? *root.find(name) : empty_, name, std::move(keys)) {}
  const Table* operator->() const { return &table_; }
  const Table& operator*() const { return table_; }

 private:
  Node empty_;
  Table table_;
};

// --- [run] ---

void read_fidelity(const Table& run, Case& c) {
  if (run.has("fidelity") && run.has("elements_across"))
    run.fail("elements_across", "fidelity is given too; state only one of them: a fidelity is a number of elements across");
  if (run.has("fidelity")) {
    c.fidelity = run.choice("fidelity", fidelities());
    c.elements_across = elements_across(c.fidelity);
  } else if (run.has("elements_across")) {
    c.fidelity = "custom";
    c.elements_across = run.integer("elements_across", 2, 1000);
  }
}

void read_symmetry(const Table& run, Case& c) {
  if (!run.has("symmetry")) return;
  const std::string valid = "valid: \"auto\", \"none\", or a list of planes of symmetry named by their normals, "
                            "[\"x\"], [\"x\", \"y\"] ...";
  const std::vector<std::string> planes = run.texts("symmetry");
  const bool is_list = run.find("symmetry")->kind == Node::Kind::array;
  c.symmetry_auto = false;
  if (!is_list && planes[0] == "none") return;
  if (!is_list && planes[0] == "auto") {
    c.symmetry_auto = true;
    return;
  }
  for (const std::string& plane : planes) {
    const std::size_t axis = std::string("xyz").find(plane);
    if (plane.size() != 1 || axis == std::string::npos) run.fail("symmetry", "'" + plane + "' is not known; " + valid);
    if (c.symmetry.plane[axis]) run.fail("symmetry", "'" + plane + "' is listed twice");
    c.symmetry.plane[axis] = true;
  }
}

void read_sleep(const Table& run, Case& c) {
  const Node* node = run.find("sleep");
  if (!node) return;
  if (node->text == "default" || node->text == "exact") {
    c.sleep = 0;
  } else if (node->text == "off") {
    c.sleep = -1;
  } else {
    const bool word = node->kind == Node::Kind::text && std::isalpha(static_cast<unsigned char>(node->text.c_str()[0]));
    if (word)
      run.fail("sleep", toml_reader::shown(*node) +
                            " is not known; valid: \"default\", \"exact\", \"off\" or a speed, for example \"1e-6 m/s\"");
    c.sleep = run.number("sleep", Dimension::velocity, not_negative);
  }
}

void read_run(const Node& root, Case& c) {
  const Section run(root, "run",
                    {"mode", "end", "mesh_end", "fidelity", "elements_across", "symmetry", "sleep", "cfl", "hourglass",
                     "hourglass_coefficient", "viscosity_linear", "viscosity_quadratic", "energy_tolerance"});
  if (!root.find("run")) toml_reader::fail(root.where, "[run]", "is missing; it needs at least end = \"20 us\"");
  if (run->has("mode")) c.mode = read_choice(*run, "mode", mode_names);
  c.end = run->number("end", Dimension::time, positive);
  run->read("mesh_end", c.mesh_end, Dimension::time, positive);
  read_fidelity(*run, c);
  read_symmetry(*run, c);
  read_sleep(*run, c);
  run->read("cfl", c.cfl, Dimension::none, {0, 1, true, false});
  if (run->has("hourglass")) c.hourglass = run->choice("hourglass", {"viscous", "stiffness"});
  run->read("hourglass_coefficient", c.hourglass_coefficient, Dimension::none, {0, 1});
  run->read("viscosity_linear", c.viscosity_linear, Dimension::none, {0, 10});
  run->read("viscosity_quadratic", c.viscosity_quadratic, Dimension::none, {0, 100});
  run->read("energy_tolerance", c.energy_tolerance, Dimension::none, {0, 1, true, false});
}

// --- [[body]] and [[wall]] ---

struct ShapeKey {
  const char* key;
  std::set<Shape> shapes;
  std::set<Shape> required;
};
const std::vector<ShapeKey>& shape_keys() {
  static const std::vector<ShapeKey> keys{
      {"diameter", {Shape::sphere, Shape::cylinder}, {Shape::sphere, Shape::cylinder}},
      {"length", {Shape::cylinder}, {Shape::cylinder}},
      {"size", {Shape::plate, Shape::box}, {Shape::plate, Shape::box}},
      {"thickness", {Shape::plate}, {Shape::plate}},
      {"file", {Shape::mesh}, {Shape::mesh}},
      {"fine_radius", {Shape::plate, Shape::box}, {}},
      {"elements_through", {Shape::plate}, {}},
      {"element_size", {Shape::sphere, Shape::cylinder, Shape::plate, Shape::box}, {}},
  };
  return keys;
}

std::string listed(const std::set<Shape>& shapes) {
  std::vector<std::string> names;
  for (const Shape s : shapes) names.push_back(to_string(s));
  return toml_reader::join(names);
}

/// Keys of another shape, and keys that this one cannot do without.
void check_shape_keys(const Table& t, Shape shape) {
  for (const ShapeKey& k : shape_keys()) {
    if (t.has(k.key) && !k.shapes.contains(shape))
      t.fail(k.key, fmt::format("a {} has no {}; it belongs to: {}", to_string(shape), k.key, listed(k.shapes)));
    if (!t.has(k.key) && k.required.contains(shape))
      t.fail(k.key, fmt::format("is missing; a {} needs it", to_string(shape)));
  }
}

core::Vec3 direction(const Table& t, const char* key) {
  core::Vec3 n = t.vector(key, Dimension::none);
  const double greatest = n.cwiseAbs().maxCoeff();
  if (greatest > 1e150 || (greatest > 0 && greatest < 1e-150)) n /= greatest;  // its square is no number
  const double norm = n.norm();
  if (!(norm > 0)) t.fail(key, "has no length; must point somewhere, for example [0, 0, 1]");
  // a direction that is of unit length already keeps its bits
  return std::abs(norm - 1) < 1e-15 ? n : core::Vec3(n / norm);
}

std::string absolute_path(const std::string& file, const std::string& folder) {
  return std::filesystem::absolute(std::filesystem::path(folder) / file).lexically_normal().string();
}

void read_size(const Table& t, BodySpec& b) {
  const bool plate = b.shape == Shape::plate;
  const std::vector<double> size = t.numbers("size", plate ? 2 : 3, Dimension::length, positive);
  b.size = {size[0], size[1], plate ? t.number("thickness", Dimension::length, positive) : size[2]};
}

void read_shape(const Table& t, const std::string& folder, BodySpec& b) {
  b.shape = read_choice(t, "shape", shape_names);
  check_shape_keys(t, b.shape);
  t.read("diameter", b.diameter, Dimension::length, positive);
  t.read("length", b.length, Dimension::length, positive);
  if (t.has("size")) read_size(t, b);
  if (t.has("file")) {
    b.file = absolute_path(t.text("file"), folder);
    toml_reader::check_utf8(b.file, t.find("file")->where, t.full_key("file"));
    if (!std::filesystem::is_regular_file(b.file)) t.fail("file", fmt::format("there is no file {}", b.file));
  }
  if (t.has("element_size")) {
    b.element_size = t.number("element_size", Dimension::length, positive);
    const double smallest = extent(b).minCoeff();
    if (*b.element_size > smallest)
      t.fail("element_size", fmt::format("{:g} m is more than the body's smallest extent, {:g} m", *b.element_size,
                                         smallest));
  }
  if (t.has("fine_radius")) b.fine_radius = t.number("fine_radius", Dimension::length, positive);
  if (t.has("elements_through")) b.elements_through = t.integer("elements_through", 1, 1000);
}

void check_name(const Table& t, const std::string& name, const std::vector<BodySpec>& others) {
  if (name.empty()) t.fail("name", "is empty; measurements need a name, for example \"bumper\"");
  for (const char c : name)
    if (std::string(".,\"=|/\\").find(c) != std::string::npos || static_cast<unsigned char>(c) <= ' ')
      t.fail("name", fmt::format("\"{}\" holds '{}'; letters, digits, '-' and '_' are fine", name, c));
  for (const char* taken : {"cloud", "ejecta", "fragments"})
    if (name == taken) t.fail("name", fmt::format("\"{}\" is what measurements of the debris are called; take another name", name));
  for (const BodySpec& other : others)
    if (other.name == name) t.fail("name", fmt::format("\"{}\" is the name of an earlier body too", name));
}

std::string body_path(const Node& node, std::size_t index) {
  const Node* name = node.find("name");
  return "body." + (name && name->kind == Node::Kind::text && !name->text.empty() ? name->text : std::to_string(index));
}

BodySpec read_body(const Node& node, std::size_t index, const Materials& materials, const std::string& folder,
                   const std::vector<BodySpec>& others) {
  const Table t(node, body_path(node, index),
                {"name", "shape", "diameter", "length", "size", "thickness", "center", "normal", "velocity", "spin",
                 "material", "file", "element_size", "fine_radius", "elements_through"});
  BodySpec b;
  b.name = t.text("name");
  check_name(t, b.name, others);
  read_shape(t, folder, b);
  t.read("center", b.center, Dimension::length);
  constexpr double farthest = 1e4;
  if (b.center.cwiseAbs().maxCoeff() > farthest)
    t.fail("center", fmt::format("is farther than {:g} m from the origin, where micrometres are lost to round-off; a bare number is in m", farthest));
  if (t.has("normal")) b.normal = direction(t, "normal");
  t.read("velocity", b.velocity, Dimension::velocity);
  if (b.velocity.norm() > 1e6)
    t.fail("velocity", fmt::format("{:g} m/s is beyond any impact; a bare number is in m/s", b.velocity.norm()));
  t.read("spin", b.spin, Dimension::angular_velocity);
  const double rim = b.spin.stableNorm() * 0.5 * extent(b).maxCoeff();
  if (rim > 1e6) t.fail("spin", fmt::format("moves the body's surface at {:g} m/s, beyond any impact; a bare number is in rad/s", rim));
  b.material = t.text("material");
  if (!materials.has(b.material)) {
    const std::string hint = toml_reader::did_you_mean(b.material, materials.names());
    t.fail("material", fmt::format("unknown material \"{}\"{}{} known: {}", b.material, hint, hint.empty() ? ";" : "",
                                   toml_reader::join(materials.names())));
  }
  return b;
}

const std::vector<Node>& tables_of(const Node& root, const std::string& name) {
  static const std::vector<Node> none;
  const Node* array = root.find(name);
  if (!array) return none;
  if (array->kind != Node::Kind::array)
    toml_reader::fail(array->where, name, fmt::format("must be written [[{}]], with two brackets, once for each", name));
  return array->items;
}

void read_bodies(const Node& root, const Materials& materials, const std::string& folder, Case& c) {
  const std::vector<Node>& bodies = tables_of(root, "body");
  if (bodies.empty()) toml_reader::fail(root.where, "[[body]]", "is missing; a case has at least one body");
  for (std::size_t k = 0; k < bodies.size(); ++k)
    c.bodies.push_back(read_body(bodies[k], k, materials, folder, c.bodies));
}

void read_walls(const Node& root, Case& c) {
  const std::vector<Node>& walls = tables_of(root, "wall");
  for (std::size_t k = 0; k < walls.size(); ++k) {
    const Table t(walls[k], fmt::format("wall.{}", k), {"point", "normal"});
    t.require("point");
    t.require("normal");
    c.walls.push_back({t.vector("point", Dimension::length), direction(t, "normal")});
  }
}

// --- [convert], [contact], [output] ---

void read_convert(const Node& root, Case& c) {
  const Section t(root, "convert",
                  {"criterion", "deformation", "jacobian_ratio", "min_angle", "plastic_strain", "timestep_ratio",
                   "damage", "particles_per_edge", "bond", "keep_nodes"});
  const std::vector<std::string> valid{"deformation", "jacobian", "plastic_strain", "timestep", "damage"};
  if (t->has("criterion")) {
    c.criteria = t->texts("criterion");
    if (c.criteria.empty()) t->fail("criterion", "is empty; one or more of " + toml_reader::join(valid));
    for (std::size_t k = 0; k < c.criteria.size(); ++k) {
      const std::string& name = c.criteria[k];
      if (std::find(valid.begin(), valid.end(), name) == valid.end()) {
        const std::string hint = toml_reader::did_you_mean(name, valid);
        t->fail("criterion", fmt::format("\"{}\" is not known{}{} valid: {}", name, hint, hint.empty() ? ";" : "",
                                         toml_reader::join(valid)));
      }
      if (std::find(c.criteria.begin(), c.criteria.begin() + static_cast<std::ptrdiff_t>(k), name) !=
          c.criteria.begin() + static_cast<std::ptrdiff_t>(k))
        t->fail("criterion", fmt::format("\"{}\" is listed twice", name));
    }
  }
  t->read("deformation", c.deformation, Dimension::none, positive);
  t->read("jacobian_ratio", c.jacobian_ratio, Dimension::none, {1, toml_reader::no_limit, true, false});
  t->read("min_angle", c.min_angle, Dimension::angle, {0, core::pi / 2, false, true});
  t->read("plastic_strain", c.plastic_strain, Dimension::none, positive);
  t->read("timestep_ratio", c.timestep_ratio, Dimension::none, {0, 1, true, true});
  t->read("damage", c.damage, Dimension::none, {0, 1, true, false});
  t->read("particles_per_edge", c.particles_per_edge, 1, 3);
  t->read("bond", c.bond);
  t->read("keep_nodes", c.keep_nodes);
}

void read_contact(const Node& root, Case& c) {
  const Section t(root, "contact", {"enabled", "friction"});
  t->read("enabled", c.contact);
  t->read("friction", c.friction, Dimension::none, {0, 10});
}

void read_output(const Node& root, Case& c) {
  const Section t(root, "output", {"every", "history_every", "checkpoint_every"});
  t->read("every", c.every, Dimension::time, positive);
  t->read("history_every", c.history_every, Dimension::time, positive);
  t->read("checkpoint_every", c.checkpoint_every, Dimension::time, positive);
}

// --- [reference] ---

struct Measurement {
  const char* name;
  Dimension dimension;
};
/// What is measured (docs/measurements.md): of the scene; of clouds, by `cloud.` and `<body>.cloud.`; and of the rest by its owner.
constexpr std::array<Measurement, 4> of_scene{{{"peak_pressure", Dimension::pressure}, {"peak_pressure_max", Dimension::pressure},
    {"peak_pressure_hugoniot", Dimension::pressure}, {"peak_pressure_jetting", Dimension::pressure}}};
constexpr std::array<Measurement, 15> of_clouds{{{"mass", Dimension::mass}, {"momentum", Dimension::momentum}, {"kinetic_energy", Dimension::energy},
    {"spray_half_angle", Dimension::angle}, {"fast_half_angle", Dimension::angle}, {"half_angle_outer_projectile", Dimension::angle},
    {"envelope_half_angle", Dimension::angle}, {"axial_velocity_front", Dimension::velocity}, {"axial_velocity_rear", Dimension::velocity},
    {"radial_velocity_max", Dimension::velocity}, {"length", Dimension::length}, {"width", Dimension::length}, {"melt_fraction", Dimension::none},
    {"projectile_melt_fraction", Dimension::none}, {"vapour_fraction", Dimension::none}}};
constexpr std::array<Measurement, 2> of_ejecta{{{"mass", Dimension::mass}, {"momentum", Dimension::momentum}}};
constexpr std::array<Measurement, 7> of_fragments{{{"count", Dimension::none}, {"mass", Dimension::mass}, {"momentum", Dimension::momentum},
    {"largest_mass", Dimension::mass}, {"lone_mass_fraction", Dimension::none}, {"failed_mass_fraction", Dimension::none}, {"reach_mass_fraction", Dimension::none}}};
constexpr std::array<Measurement, 15> of_bodies{{{"hole_diameter", Dimension::length}, {"hole_diameter_min", Dimension::length}, {"hole_diameter_max", Dimension::length},
    {"crater_depth", Dimension::length}, {"crater_diameter", Dimension::length}, {"crater_lip_height", Dimension::length}, {"perforated", Dimension::none},
    {"bulge", Dimension::length}, {"detached_mass", Dimension::mass}, {"debris_mass_behind", Dimension::mass}, {"rim_displacement", Dimension::length},
    {"impulse", Dimension::momentum}, {"final_length", Dimension::length}, {"foot_diameter", Dimension::length}, {"diameter_at_fifth", Dimension::length}}};

/// The dimension of a measurement; an error names those that there are.
Dimension dimension_of(const Node& node, const std::string& path, const std::string& key) {
  const auto dot = key.find('.');
  const std::string owner = key.substr(0, dot);
  std::string name = dot == std::string::npos ? key : key.substr(dot + 1), before = dot == std::string::npos ? "" : owner + ".";
  std::span<const Measurement> all = of_bodies;
  if (before.empty()) {
    all = of_scene;
  } else if (owner == "cloud" || name.starts_with("cloud.")) {
    all = of_clouds;
    if (owner != "cloud") name = name.substr(6), before += "cloud.";
  } else if (owner == "ejecta") {
    all = of_ejecta;
  } else if (owner == "fragments") {
    all = of_fragments;
  }
  std::vector<std::string> names;
  for (const Measurement& m : all) {
    if (name == m.name) return m.dimension;
    names.push_back(before + m.name);
  }
  toml_reader::fail(node.where, path, fmt::format("nothing is measured by that name{}; valid: {}", toml_reader::did_you_mean(key, names), toml_reader::join(names)));
}

double reference_value(const Node& node, const std::string& path, const std::string& key) {
  const Dimension dimension = dimension_of(node, path, key);
  const bool truth = key.ends_with(".perforated");
  if (truth != (node.kind == Node::Kind::boolean))
    toml_reader::fail(node.where, path, fmt::format("{}; must be {}", toml_reader::shown(node), truth ? "true or false" : "a number"));
  if (truth) return node.boolean ? 1 : 0;
  return toml_reader::to_number(node, path, dimension, any_number);
}

void read_reference(const Node& root, Case& c) {
  const Node* node = root.find("reference");
  if (!node) return;
  if (!node->is_table()) toml_reader::fail(node->where, "reference", "must be a table");
  std::vector<std::string> owners{"cloud", "ejecta", "fragments"};
  for (const BodySpec& b : c.bodies) owners.push_back(b.name);
  for (const auto& [key, child] : node->children) {
    const std::string path = "reference." + toml_reader::as_key(key);
    const std::string owner = key.substr(0, key.find('.'));
    if (child.is_table() && !child.find("value") && key == owner)
      toml_reader::fail(child.where, path, fmt::format("has no value; a key with a dot goes in quotes: \"{}.{}\" = ...", key,
                                                       child.children.empty() ? "hole_diameter" : child.children[0].key));
    if (owner != key && std::find(owners.begin(), owners.end(), owner) == owners.end())
      toml_reader::fail(child.where, path, fmt::format("there is no body '{}'{}{} measurements belong to: {}", owner,
                                                       toml_reader::did_you_mean(owner, owners),
                                                       toml_reader::nearest(owner, owners).empty() ? ";" : "",
                                                       toml_reader::join(owners)));
    Case::Reference r;
    r.line = child.line;
    if (child.is_table()) {
      const Table t(child, path, {"value", "source"});
      r.value = reference_value(t.require("value"), t.full_key("value"), key);
      t.read("source", r.source);
    } else {
      r.value = reference_value(child, path, key);
    }
    c.reference[key] = r;
  }
}

// --- the whole ---

/// run.fidelity and run.elements_across say the same thing: an override of one takes the place of the file's other.
void let_override_win(Node& root) {
  Node* run = root.find("run");
  if (!run) return;
  const Node* a = run->find("fidelity");
  const Node* b = run->find("elements_across");
  if (!a || !b || a->from_override() == b->from_override()) return;
  const std::string loser = a->from_override() ? "elements_across" : "fidelity";
  std::erase_if(run->children, [&](const auto& child) { return child.key == loser; });
}

void override_mode(Node& root, const std::string& mode) {
  if (mode.empty()) return;
  if (!root.find("run")) root.set("run", Node{});
  if (Node* run = root.find("run"); run->is_table())
    run->set("mode", toml_reader::parse_value(toml_reader::toml_string(mode), "--mode"));
}

std::string file_of(const std::string& path) {
  std::error_code ignored;
  const std::filesystem::path inside = std::filesystem::path(path) / "case.toml";
  if (std::filesystem::is_directory(path, ignored)) {
    if (std::filesystem::is_regular_file(inside, ignored)) return inside.string();
    throw core::CaseError(path + ": is a folder without a case.toml; name the case file");
  }
  if (!std::filesystem::exists(path, ignored)) throw core::CaseError(path + ": there is no such file");
  return path;
}

void check_is_case(const Node& root) {
  if (root.find("run") || root.find("body")) return;
  throw core::CaseError(root.where + ": this is TOML, but no case: it has neither [run] nor [[body]]");
}

Case read_tree(const Node& root, const std::string& file) {
  const Table top(root, "", {"title", "run", "body", "wall", "convert", "contact", "output", "reference", "materials"});
  const std::string folder = std::filesystem::path(file).parent_path().string();
  Case c;
  c.file = file;
  top.read("title", c.title);
  const Materials materials(root.find("materials"), folder);
  read_run(root, c);
  read_bodies(root, materials, folder, c);
  read_walls(root, c);
  read_convert(root, c);
  read_contact(root, c);
  read_output(root, c);
  read_reference(root, c);
  for (const std::string& name : materials.own_names()) materials.find(name);  // unused ones have to be right as well
  for (const BodySpec& b : c.bodies)
    if (!c.materials.contains(b.material)) c.materials[b.material] = materials.find(b.material);
  return c;
}

}  // namespace

Case read_case(const std::string& path, const std::vector<std::string>& overrides, const std::string& mode_override) {
  const std::string file = file_of(path);
  Node root = toml_reader::parse_file(file);
  check_is_case(root);
  for (const std::string& assignment : overrides) toml_reader::apply_override(root, assignment);
  override_mode(root, mode_override);
  let_override_win(root);
  return read_tree(root, file);
}

const char* to_string(Mode mode) {
  for (const auto& row : mode_names)
    if (row.value == mode) return row.name;
  return "";
}

const char* to_string(Shape shape) {
  for (const auto& row : shape_names)
    if (row.value == shape) return row.name;
  return "";
}

int elements_across(const std::string& fidelity) {
  for (const Fidelity& f : fidelity_names)
    if (fidelity == f.name) return f.across;
  throw core::CaseError(fmt::format("unknown fidelity '{}'; valid: {}", fidelity, toml_reader::join(fidelities())));
}

std::vector<std::string> fidelities() { return names_of(fidelity_names); }

}  // namespace io
