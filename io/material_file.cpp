// SPDX-License-Identifier: Apache-2.0
#include "io/material_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <variant>

#include "core/error.hpp"

namespace io {

extern const char* const library_text;  // made by embed.cmake

namespace {

using core::Dimension;
using toml_reader::any_number;
using toml_reader::Limits;
using toml_reader::Node;
using toml_reader::not_negative;
using toml_reader::positive;
using toml_reader::Table;

constexpr double absent = 1e299;  // limits that a material does not state are 1e300

/// One constant of a model: the same list reads, checks and writes it.
struct Field {
  const char* key;
  double* value;
  Dimension dimension;
  Limits limits;
  bool required = true;
};
using Fields = std::vector<Field>;

constexpr bool optional_field = false;

const char* model_name(const eos::IdealGas&) { return "ideal_gas"; }
const char* model_name(const eos::Polynomial&) { return "polynomial"; }
const char* model_name(const eos::MieGrueneisen&) { return "mie_grueneisen"; }
const char* model_name(const eos::Tillotson&) { return "tillotson"; }
const char* model_name(const eos::Sesame&) { return "sesame"; }
const char* model_name(const material::NoStrength&) { return "none"; }
const char* model_name(const material::PerfectlyPlastic&) { return "perfectly_plastic"; }
const char* model_name(const material::JohnsonCook&) { return "johnson_cook"; }
const char* model_name(const material::SteinbergGuinan&) { return "steinberg_guinan"; }
const char* model_name(const material::ZerilliArmstrong&) { return "zerilli_armstrong"; }
const char* model_name(const material::JohnsonCookDamage&) { return "johnson_cook"; }

Fields fields(eos::IdealGas& s) {
  return {{"gamma", &s.gamma, Dimension::none, {1, 10, true, false}}, {"cv", &s.cv, Dimension::specific_heat, positive}};
}
Fields fields(eos::Polynomial& s) {
  const auto p = Dimension::pressure;
  return {{"rho_0", &s.rho_0, Dimension::density, positive, optional_field},
          {"C0", &s.C0, p, any_number, optional_field},
          {"C1", &s.C1, p, not_negative},
          {"C2", &s.C2, p, any_number, optional_field},
          {"C3", &s.C3, p, any_number, optional_field},
          {"C4", &s.C4, Dimension::none, any_number, optional_field},
          {"C5", &s.C5, Dimension::none, any_number, optional_field},
          {"C6", &s.C6, Dimension::none, any_number, optional_field},
          {"cv", &s.cv, Dimension::specific_heat, positive},
          {"T_0", &s.T_0, Dimension::temperature, positive, optional_field}};
}
Fields fields(eos::MieGrueneisen& s) {
  return {{"rho_0", &s.rho_0, Dimension::density, positive, optional_field},
          {"c_0", &s.c_0, Dimension::velocity, positive},
          {"s_1", &s.s_1, Dimension::none, not_negative},
          {"s_2", &s.s_2, Dimension::none, any_number, optional_field},
          {"s_3", &s.s_3, Dimension::none, any_number, optional_field},
          {"gamma_0", &s.gamma_0, Dimension::none, not_negative},
          {"a", &s.a, Dimension::none, any_number, optional_field},
          {"cv", &s.cv, Dimension::specific_heat, positive},
          {"T_0", &s.T_0, Dimension::temperature, positive, optional_field}};
}
Fields fields(eos::Tillotson& s) {
  return {{"rho_0", &s.rho_0, Dimension::density, positive, optional_field},
          {"a", &s.a, Dimension::none, not_negative},
          {"b", &s.b, Dimension::none, not_negative},
          {"A", &s.A, Dimension::pressure, positive},
          {"B", &s.B, Dimension::pressure, any_number},
          {"alpha", &s.alpha, Dimension::none, not_negative},
          {"beta", &s.beta, Dimension::none, not_negative},
          {"E_0", &s.E_0, Dimension::specific_energy, positive},
          {"E_iv", &s.E_iv, Dimension::specific_energy, positive},
          {"E_cv", &s.E_cv, Dimension::specific_energy, positive},
          {"cv", &s.cv, Dimension::specific_heat, positive},
          {"T_0", &s.T_0, Dimension::temperature, positive, optional_field}};
}
Fields fields(eos::Sesame& s) { return {{"T_0", &s.T_0, Dimension::temperature, positive, optional_field}}; }
Fields fields(material::NoStrength&) { return {}; }
Fields fields(material::PerfectlyPlastic& s) {
  return {{"G", &s.G, Dimension::pressure, positive}, {"Y", &s.Y, Dimension::pressure, not_negative}};
}
Fields fields(material::JohnsonCook& s) {
  return {{"G", &s.G, Dimension::pressure, positive},
          {"A", &s.A, Dimension::pressure, not_negative},
          {"B", &s.B, Dimension::pressure, not_negative},
          {"n", &s.n, Dimension::none, not_negative},
          {"C", &s.C, Dimension::none, not_negative},
          {"m", &s.m, Dimension::none, positive},
          {"rate_0", &s.rate_0, Dimension::rate, positive, optional_field},
          {"T_room", &s.T_room, Dimension::temperature, positive, optional_field},
          {"T_melt", &s.T_melt, Dimension::temperature, positive}};
}
Fields fields(material::SteinbergGuinan& s) {
  return {{"G_0", &s.G_0, Dimension::pressure, positive},
          {"Y_0", &s.Y_0, Dimension::pressure, not_negative},
          {"Y_max", &s.Y_max, Dimension::pressure, not_negative},
          {"beta", &s.beta, Dimension::none, not_negative},
          {"n", &s.n, Dimension::none, not_negative},
          {"eps_i", &s.eps_i, Dimension::none, not_negative, optional_field},
          {"A", &s.A, Dimension::inverse_pressure, any_number},
          {"B", &s.B, Dimension::inverse_temperature, any_number},
          {"T_melt_0", &s.T_melt_0, Dimension::temperature, positive},
          {"gamma_0", &s.gamma_0, Dimension::none, positive},
          {"a", &s.a, Dimension::none, any_number}};
}
Fields fields(material::ZerilliArmstrong& s) {
  const auto p = Dimension::pressure;
  return {{"G", &s.G, p, positive},
          {"C0", &s.C0, p, not_negative},
          {"C1", &s.C1, p, not_negative, optional_field},
          {"C2", &s.C2, p, not_negative, optional_field},
          {"C3", &s.C3, Dimension::inverse_temperature, not_negative},
          {"C4", &s.C4, Dimension::inverse_temperature, not_negative},
          {"C5", &s.C5, p, not_negative, optional_field},
          {"n", &s.n, Dimension::none, {0, 1, true, false}, optional_field},
          {"T_melt", &s.T_melt, Dimension::temperature, positive}};
}
Fields fields(material::JohnsonCookDamage& s) {
  return {{"D1", &s.D1, Dimension::none, any_number},
          {"D2", &s.D2, Dimension::none, any_number},
          {"D3", &s.D3, Dimension::none, any_number},
          {"D4", &s.D4, Dimension::none, any_number},
          {"D5", &s.D5, Dimension::none, any_number},
          {"rate_0", &s.rate_0, Dimension::rate, positive, optional_field},
          {"T_room", &s.T_room, Dimension::temperature, positive, optional_field},
          {"T_melt", &s.T_melt, Dimension::temperature, positive, optional_field}};
}
Fields spall_fields(material::Material& m) {
  return {{"limit", &m.spall, Dimension::pressure, positive},
          {"fracture_energy", &m.fracture_energy, Dimension::surface_energy, not_negative, optional_field}};
}
Fields phase_fields(material::Material& m) {
  const auto e = Dimension::specific_energy;
  return {{"e_melt", &m.e_melt, e, positive, optional_field},
          {"e_melted", &m.e_melted, e, positive, optional_field},
          {"e_vapour", &m.e_vapour, e, positive, optional_field},
          {"e_vaporised", &m.e_vaporised, e, positive, optional_field}};
}

/// Conditions between the constants of one model; the table tells where.
template <class Model>
void check_model(const Model&, const Table&) {}
void check_model(const eos::Tillotson& s, const Table& t) {
  if (s.E_cv <= s.E_iv) t.fail("E_cv", "must be greater than E_iv: vaporisation ends above where it begins");
}
void check_model(const material::JohnsonCook& s, const Table& t) {
  if (s.T_melt <= s.T_room) t.fail("T_melt", fmt::format("must be above T_room ({:g} K)", s.T_room));
}
void check_model(const material::JohnsonCookDamage& s, const Table& t) {
  if (s.D5 != 0 && s.T_melt == material::JohnsonCookDamage{}.T_melt)
    t.fail("T_melt", fmt::format("is missing; D5 = {:g} needs it (only the Johnson-Cook strength lends its own)", s.D5));
  if (s.T_melt <= s.T_room) t.fail("T_melt", fmt::format("must be above T_room ({:g} K)", s.T_room));
}
void check_model(const material::SteinbergGuinan& s, const Table& t) {
  if (s.Y_max < s.Y_0) t.fail("Y_max", fmt::format("must not be below Y_0 ({:g} Pa)", s.Y_0));
}

/// What a model has beside numbers.
template <class Model>
std::vector<std::string> other_keys(const Model&) { return {"model"}; }
std::vector<std::string> other_keys(const eos::Sesame&) { return {"model", "file", "number"}; }

std::vector<std::string> keys_of(const Fields& all, std::vector<std::string> keys) {
  for (const Field& f : all) keys.push_back(f.key);
  keys.insert(keys.end(), {"source", "note"});
  return keys;
}

/// How a value is listed: as it is written, a bare number with its SI unit.
std::string listed(const Node& node, Dimension d) {
  const std::string unit = core::si_unit(d);
  return node.is_number() && !unit.empty() ? node.text + " " + unit : node.text;
}

void read_fields(const Table& table, const Node& group, const std::string& name, const Fields& all,
                 material::Material& m) {
  for (const Field& f : all) {
    if (!table.has(f.key) && !f.required) continue;
    *f.value = table.number(f.key, f.dimension, f.limits);
    const Node& node = *group.find(f.key);
    m.constants.push_back({name + "." + f.key, listed(node, f.dimension), node.source});
  }
}

template <class Model>
void read_others(const Table&, const Node&, const std::string&, material::Material&, Model&) {}
void read_others(const Table& table, const Node& group, const std::string& name, material::Material& m, eos::Sesame& s) {
  s.file = table.text("file");
  s.number = table.integer("number", 1, 99999999);
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(s.file, ignored)) table.fail("file", fmt::format("there is no file {}", s.file));
  for (const char* key : {"file", "number"}) {
    const Node& node = *group.find(key);
    m.constants.push_back({name + "." + key, node.text, node.source});
  }
}

std::string others_as_toml(const auto&) { return ""; }
std::string others_as_toml(const eos::Sesame& s) {
  return fmt::format("file = {}\nnumber = {}\n", toml_reader::toml_string(s.file), s.number);
}

template <class Model>
void read_model(const Node& group, const std::string& path, const std::string& name, material::Material& m, Model& model) {
  const Fields all = fields(model);
  const Table table(group, path, keys_of(all, other_keys(model)));
  m.constants.push_back({name + ".model", model_name(model), group.find("model")->source});
  read_others(table, group, name, m, model);
  read_fields(table, group, name, all, m);
  check_model(model, table);
  if constexpr (requires { model.rho_0; }) {
    if (std::abs(model.rho_0 - m.rho_0) > 1e-9 * m.rho_0)
      table.fail("rho_0", fmt::format("{:g} kg/m3 differs from the material's rho_0 = {:g} kg/m3: matter at rest would be "
                                      "under pressure", model.rho_0, m.rho_0));
  }
}

std::string model_of(const Node& group, const std::string& path, const std::vector<std::string>& valid) {
  if (!group.is_table())
    toml_reader::fail(group.where, path, fmt::format("{} must be a table, for example {{ model = \"{}\", ... }}",
                                                     toml_reader::shown(group), valid.back()));
  const Node* model = group.find("model");
  if (!model) toml_reader::fail(group.where, path + ".model", "is missing; one of " + toml_reader::join(valid));
  if (std::find(valid.begin(), valid.end(), model->text) == valid.end()) {
    const std::string hint = toml_reader::did_you_mean(model->text, valid);
    toml_reader::fail(model->where, path + ".model",
                      fmt::format("unknown model {}{}{} valid: {}", toml_reader::shown(*model), hint,
                                  hint.empty() ? ";" : "", toml_reader::join(valid)));
  }
  return model->text;
}

/// Calls f(T{}) for every alternative of a variant.
template <class Variant, class F, std::size_t k = 0>
void each_alternative(F&& f) {
  if constexpr (k < std::variant_size_v<Variant>) {
    f(std::variant_alternative_t<k, Variant>{});
    each_alternative<Variant, F, k + 1>(std::forward<F>(f));
  }
}

template <class Variant>
Variant read_variant(const Node& group, const std::string& path, const std::string& name, material::Material& m) {
  std::vector<std::string> valid;
  each_alternative<Variant>([&](auto model) { valid.push_back(model_name(model)); });
  const std::string wanted = model_of(group, path, valid);
  Variant result;
  each_alternative<Variant>([&](auto model) {
    if (wanted != model_name(model)) return;
    if constexpr (requires { model.rho_0; }) model.rho_0 = m.rho_0;
    read_model(group, path, name, m, model);
    result = std::move(model);
  });
  return result;
}

void read_damage(const Node& group, const std::string& path, material::Material& m) {
  if (model_of(group, path, {"none", "johnson_cook"}) == "none") {
    Table(group, path, {"model", "source", "note"});
    return;
  }
  material::JohnsonCookDamage damage;
  if (const auto* strength = std::get_if<material::JohnsonCook>(&m.strength)) {
    damage.rate_0 = strength->rate_0;
    damage.T_room = strength->T_room;
    damage.T_melt = strength->T_melt;
  }
  read_model(group, path, "damage", m, damage);
  m.damage = damage;
}

/// A group without models; a missing one changes nothing.
void read_plain(const Node* group, const std::string& path, const std::string& name, const Fields& all,
                material::Material& m) {
  if (!group) return;
  const Table table(*group, path, keys_of(all, {}));
  read_fields(table, *group, name, all, m);
}

void check_phase(const material::Material& m, const Node* group, const std::string& path) {
  const std::array<double, 4> e{m.e_melt, m.e_melted, m.e_vapour, m.e_vaporised};
  constexpr std::array<const char*, 4> key{"e_melt", "e_melted", "e_vapour", "e_vaporised"};
  for (std::size_t k = 1; k < e.size(); ++k)
    if (e[k - 1] > e[k])
      toml_reader::fail(group->where, path, e[k - 1] < absent ? fmt::format("{} = {:g} J/kg is above {} = {:g} J/kg; must rise: {}", key[k - 1], e[k - 1],
                                                                            key[k], e[k], fmt::join(key, " <= "))
                                                              : fmt::format("{} is missing; {} needs it, since they rise: {}", key[k - 1], key[k],
                                                                            fmt::join(key, " <= ")));
}

material::Material read_material(const Node& node, const std::string& name) {
  const std::string path = "materials." + toml_reader::as_key(name);
  const Table table(node, path, {"rho_0", "eos", "strength", "damage", "spall", "phase", "source", "note"});
  material::Material m;
  m.name = name;
  m.rho_0 = table.number("rho_0", Dimension::density, positive);
  const Node& rho_0 = *node.find("rho_0");
  m.constants.push_back({"rho_0", listed(rho_0, Dimension::density), rho_0.source});
  m.eos = read_variant<eos::Eos>(table.require("eos"), path + ".eos", "eos", m);
  if (const Node* strength = node.find("strength"))
    m.strength = read_variant<material::Strength>(*strength, path + ".strength", "strength", m);
  if (const Node* damage = node.find("damage")) read_damage(*damage, path + ".damage", m);
  read_plain(node.find("spall"), path + ".spall", "spall", spall_fields(m), m);
  read_plain(node.find("phase"), path + ".phase", "phase", phase_fields(m), m);
  check_phase(m, node.find("phase"), path + ".phase");
  try {
    material::prepare(m);
  } catch (const core::CaseError& e) {
    toml_reader::fail(node.where, path, e.what());
  }
  return m;
}

/// Every value is given the source that its own group states, else the place where it is written.
void stamp_sources(Node& table) {
  const Node* stated = table.find("source");
  const std::string source = stated && stated->kind == Node::Kind::text ? stated->text : "";
  for (auto& [key, child] : table.children) {
    if (child.is_table())
      stamp_sources(child);
    else
      child.source = source.empty() ? child.where : source;
  }
}

/// `changes` over `base`, group by group; a group of another model replaces the base's.
Node overlaid(Node base, const Node& changes) {
  for (const auto& [key, change] : changes.children) {
    if (key == "base") continue;
    Node* old = base.find(key);
    const Node* model = change.find("model");
    const Node* old_model = old ? old->find("model") : nullptr;
    const bool same = !model || (old_model && old_model->text == model->text);
    if (!old || !old->is_table() || !change.is_table() || !same) {
      base.set(key, change);
      continue;
    }
    for (const auto& [name, value] : change.children) old->set(name, value);
    old->where = change.where;
  }
  base.where = changes.where;
  return base;
}

const Node& library() {
  static const Node tree = [] {
    Node all = toml_reader::parse_text(library_text, "material/library.toml");
    for (auto& [name, table] : all.children) stamp_sources(table);
    return all;
  }();
  return tree;
}

std::string unknown_material(const std::string& name, const std::vector<std::string>& names) {
  const std::string hint = toml_reader::did_you_mean(name, names);
  return fmt::format("unknown material '{}'{}{} known: {}", name, hint, hint.empty() ? ";" : "", toml_reader::join(names));
}

// --- writing ---

std::string fields_as_toml(const Fields& all) {
  std::string text;
  for (const Field& f : all)
    if (*f.value < absent) text += fmt::format("{} = {}\n", f.key, core::exact_decimal(*f.value));
  return text;
}

/// source = "..." of a group: every source its constants have, once.
std::string source_as_toml(const material::Material& m, const std::string& group) {
  std::vector<std::string> sources;
  for (const auto& c : m.constants) {
    const bool ours = group.empty() ? c.key == "rho_0" : c.key.starts_with(group + ".");
    if (ours && !c.source.empty() && std::find(sources.begin(), sources.end(), c.source) == sources.end())
      sources.push_back(c.source);
  }
  if (sources.empty()) return "";
  return fmt::format("source = {}\n", toml_reader::toml_string(fmt::format("{}", fmt::join(sources, "; "))));
}

std::string group_as_toml(const material::Material& m, const std::string& group, const char* model, const Fields& all,
                          const std::string& others = "") {
  std::string text = fmt::format("\n[materials.{}.{}]\n", toml_reader::as_key(m.name), group);
  if (*model) text += fmt::format("model = \"{}\"\n", model);
  return text + others + fields_as_toml(all) + source_as_toml(m, group);
}

}  // namespace

Materials::Materials(const Node* own, const std::string& folder) {
  if (!own) return;
  if (!own->is_table()) toml_reader::fail(own->where, "materials", "must be tables [materials.NAME]");
  own_ = *own;
  for (auto& [name, table] : own_.children) {
    if (!table.is_table())
      toml_reader::fail(table.where, "materials." + name, "must be a table: [materials." + toml_reader::as_key(name) + "]");
    stamp_sources(table);
    Node* eos = table.find("eos");
    Node* file = eos ? eos->find("file") : nullptr;
    if (!file || file->kind != Node::Kind::text) continue;
    file->text = std::filesystem::absolute(std::filesystem::path(folder) / file->text).lexically_normal().string();
    toml_reader::check_utf8(file->text, file->where, "materials." + toml_reader::as_key(name) + ".eos.file");
  }
}

bool Materials::has(const std::string& name) const { return own_.find(name) || library().find(name); }

Node Materials::merged(const std::string& name, std::vector<std::string>& chain) const {
  const bool again = std::find(chain.begin(), chain.end(), name) != chain.end();
  const Node* own = again ? nullptr : own_.find(name);  // a material may be based on the library's of the same name
  if (!own) {
    chain.push_back(name);
    if (const Node* stock = library().find(name)) return *stock;
    throw core::CaseError(unknown_material(name, names()));
  }
  const Node* base = own->find("base");
  chain.push_back(name);
  if (!base) return *own;
  const std::string key = "materials." + toml_reader::as_key(name) + ".base";
  if (base->kind != Node::Kind::text) toml_reader::fail(base->where, key, "must be the name of a material, in quotes");
  if (!has(base->text)) toml_reader::fail(base->where, key, unknown_material(base->text, names()));
  const bool round = std::find(chain.begin(), chain.end(), base->text) != chain.end();
  if (round && !library().find(base->text))
    toml_reader::fail(base->where, key, "comes back to itself: " + toml_reader::join(chain) + ", " + base->text);
  return overlaid(merged(base->text, chain), *own);
}

material::Material Materials::find(const std::string& name) const {
  std::vector<std::string> chain;
  return read_material(merged(name, chain), name);
}

std::vector<std::string> Materials::descent(const std::string& name) const {
  std::vector<std::string> chain;
  merged(name, chain);
  return chain;
}

std::vector<std::string> Materials::own_names() const {
  std::vector<std::string> names;
  for (const auto& [name, table] : own_.children) names.push_back(name);
  return names;
}

std::vector<std::string> Materials::names() const {
  std::vector<std::string> all = own_names();
  for (const auto& [name, table] : library().children)
    if (!own_.find(name)) all.push_back(name);
  return all;
}

material::Material find_material(const std::string& name) { return Materials().find(name); }

Materials materials_of(const std::string& file) {
  const Node root = toml_reader::parse_file(file);
  return Materials(root.find("materials"), std::filesystem::path(file).parent_path().string());
}

std::vector<std::string> material_names() { return Materials().names(); }

std::string write_material(const material::Material& m) {
  material::Material copy = m;  // fields() points into what it is given
  std::string text = fmt::format("[materials.{}]\nrho_0 = {}\n{}", toml_reader::as_key(m.name),
                                 core::exact_decimal(m.rho_0), source_as_toml(m, ""));
  std::visit([&](auto& s) { text += group_as_toml(m, "eos", model_name(s), fields(s), others_as_toml(s)); }, copy.eos);
  std::visit([&](auto& s) { text += group_as_toml(m, "strength", model_name(s), fields(s)); }, copy.strength);
  if (copy.damage) text += group_as_toml(m, "damage", model_name(*copy.damage), fields(*copy.damage));
  if (m.spall < absent) text += group_as_toml(m, "spall", "", spall_fields(copy));
  if (m.e_melt < absent || m.e_vapour < absent) text += group_as_toml(m, "phase", "", phase_fields(copy));
  return text;
}

}  // namespace io
