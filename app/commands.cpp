// SPDX-License-Identifier: Apache-2.0
#include "app/commands.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <thread>

#include "app/bench.hpp"
#include "app/compare.hpp"
#include "app/cost.hpp"
#include "app/report.hpp"
#include "app/run.hpp"
#include "app/setup.hpp"
#include "app/trade.hpp"
#include "core/error.hpp"
#include "core/parallel.hpp"
#include "eos/hugoniot.hpp"
#include "eos/wide_range.hpp"
#include "io/atomic_file.hpp"
#include "io/case_file.hpp"
#include "io/material_file.hpp"
#include "io/shock_points.hpp"

namespace app {

struct Arguments {
  std::string target, out, mode;
  std::vector<std::string> set;
  int threads = 0;
  bool force = false;
};

static void use_threads(int asked) {
  if (asked > 0) core::set_threads(asked);
}

/// For commands that only print: what did not get out is an error.
static int printed() {
  if (std::fflush(stdout) != 0 || std::ferror(stdout)) throw core::GuardError("the output cannot be written: no space left on the device?");
  return 0;
}

/// What outputs of a case are called by: its file, or the folder that holds case.toml.
static std::string stem_of(const std::string& target) {
  auto path = std::filesystem::absolute(target).lexically_normal();
  if (!path.has_filename() || path.filename() == "case.toml") path = path.parent_path();
  std::error_code ignored;
  return (std::filesystem::is_directory(path, ignored) ? path.filename() : path.stem()).string();
}

static int run_case(const Arguments& a) {
  use_threads(a.threads);
  const io::Case spec = io::read_case(a.target, a.set, a.mode);
  return run(spec, a.out.empty() ? "runs/" + stem_of(a.target) + "-" + io::to_string(spec.mode) : a.out, a.force);
}

static int trade_case(const Arguments& a, TradeRequest request) {
  request.target = a.target;
  request.out = a.out.empty() ? "runs/" + stem_of(a.target) + "-trade" : a.out;
  request.set = a.set;
  request.threads = a.threads;
  request.force = a.force;
  return trade(request);
}

static int check_case(const Arguments& a, bool with_cost) {
  use_threads(a.threads);
  const io::Case spec = io::read_case(a.target, a.set, a.mode);
  const Estimate cost = estimate(spec);
  const core::Symmetry symmetry = find_symmetry(spec);
  const auto s = set_up(spec);
  fmt::print("{}\n# bodies\n", io::write_case(s->spec));
  for (const auto& b : cost.bodies)
    fmt::print("#   {:<16} about {:>9.0f} elements, finest edge {:.4g} mm\n", b.name, b.elements, b.element_size * 1e3);
  fmt::print("# active: {}{}{}{}\n", symmetry.copies() > 1 ? fmt::format("symmetry (1/{} of the scene), ", symmetry.copies()) : "",
             s->sleep_threshold >= 0 ? "sleeping, " : "", s->spec.contact ? "contact once bodies can meet, " : "",
             spec.mode == io::Mode::hybrid    ? "particles, their neighbour search and the bond once an element converts"
             : spec.mode == io::Mode::erosion ? "erosion"
             : spec.mode == io::Mode::sph     ? "particles from the start"
                                              : "elements only");
  for (const auto& warning : s->warnings) fmt::print("# warning: {}\n", warning);
  if (!with_cost) return printed();
  begin(*s);
  double dt = 1e300;
  for (const double d : s->mesh.elements.dt) dt = std::min(dt, d);
  for (const double d : s->particles.dt) dt = std::min(dt, d);
  const Cost c = predict_cost(*s);
  fmt::print("# cost: {} elements, first full step {:.3g} ns, about {:.0f} steps, {:.0f} particles at the end\n", s->n_elements_initial,
             spec.cfl * dt * 1e9, c.steps, c.particles);
  fmt::print("# cost: about {:.3g} s with {} thread{} (elements {:.0f} %, particles {:.0f} %, contact {:.0f} %), {:.2f} GiB of {:.1f} GiB free\n",
             c.seconds, core::threads(), core::threads() == 1 ? "" : "s", 100 * c.elements_seconds / c.seconds,
             100 * c.particles_seconds / c.seconds, 100 * c.contact_seconds / c.seconds, c.bytes / (1 << 30), cost.available / (1 << 30));
  fmt::print("# cost: from the same case {} across, {:.0f} % of its time, {:.1f} s\n", c.pilot_across, 100 * c.pilot_part, c.pilot_seconds);
  return printed();
}

static int list_materials(const std::string& name) {
  if (name.empty()) {
    for (const auto& m : io::material_names()) {
      const auto material = io::find_material(m);
      const bool tears = material.spall < material::Material{}.spall;
      fmt::print("{:<20} {:8.0f} kg/m3{}\n", m, material.rho_0, tears ? "" : "  without a limit of tension");
    }
    return printed();
  }
  const auto material = io::find_material(name);
  fmt::print("{}\n", material.name);
  for (const auto& c : material.constants) fmt::print("  {:<28} {:<22} {}\n", c.key, c.value, c.source);
  return printed();
}

/// The state of the material's model behind a shock of this particle velocity [m/s]; none beyond the range of the model, told in `why`.
static std::optional<eos::HugoniotPoint> shocked(const material::Material& m, double up, std::string& why) {
  try {
    return eos::hugoniot(m.eos, m.rho_0, up);
  } catch (const core::CaseError& e) {
    why = e.what();
    return std::nullopt;
  }
}

static void print_against(const io::ShockSeries& measured, const material::Material& m) {
  fmt::print("\n# measured on samples of {:g} kg/m3: {}\n", measured.rho_0, measured.source);
  fmt::print("{:>10} {:>10} {:>12} {:>12} {:>12} {:>10}\n", "up km/s", "Us km/s", "p GPa", "rho kg/m3", "model p GPa", "error %");
  int compared = 0;
  double sum = 0, squares = 0, largest = 0;
  for (const auto& at : measured.points) {
    fmt::print("{:10.3f} {:10.3f} {:12.4f} {:12.1f} ", at.up * 1e-3, at.Us * 1e-3, at.p * 1e-9, at.rho);
    std::string why;
    const auto h = shocked(m, at.up, why);
    if (!h) {
      fmt::print("           -          -\n");
      continue;
    }
    const double error = h->p / at.p - 1;
    fmt::print("{:12.4f} {:10.2f}\n", h->p * 1e-9, 100 * error);
    ++compared;
    sum += error;
    squares += error * error;
    largest = std::max(largest, std::abs(error));
  }
  if (compared)
    fmt::print("# pressure of the model at the measured up, {} of {} points: mean error {:+.2f} %, root mean square {:.2f} %, largest {:.2f} %\n", compared,
               measured.points.size(), 100 * sum / compared, 100 * std::sqrt(squares / compared), 100 * largest);
}

static int print_hugoniot(const std::string& name, const std::string& file) {
  const bool folder = std::filesystem::is_directory(file);
  const io::Materials all = file.empty() ? io::Materials() : io::materials_of(folder ? file + "/case.toml" : file);
  const auto m = all.find(name);
  fmt::print("# principal Hugoniot of {}, rho_0 = {:g} kg/m3\n", name, m.rho_0);
  fmt::print("{:>10} {:>10} {:>12} {:>12} {:>10} {:>12}\n", "up km/s", "Us km/s", "p GPa", "rho kg/m3", "T K", "e MJ/kg");
  for (double up = 250; up <= 8000; up += 250) {
    std::string why;
    const auto h = shocked(m, up, why);
    if (!h && up == 250) throw core::CaseError(fmt::format("{}: {}", name, why));
    if (!h) {
      fmt::print("# no further: {}\n", why);
      break;
    }
    fmt::print("{:10.3f} {:10.3f} {:12.4f} {:12.1f} {:10.0f} {:12.4f}\n", up * 1e-3, h->Us * 1e-3, h->p * 1e-9, h->rho, h->temperature,
               h->e * 1e-6);
  }
  const auto measured = io::shock_series(all.descent(name));
  for (const auto& series : measured) print_against(series, m);
  if (measured.empty()) fmt::print("# no measured shock states of it are stored\n");
  return printed();
}

/// Writes the wide-range table of a metal and prints what a case says to use it.
static int make_table(const std::string& name, const std::string& out, int number) {
  const eos::Metal& metal = eos::find_metal(name);
  const std::string file = out.empty() ? name + ".ses" : out;
  io::require_place("--out", file);
  const eos::WideRange model(metal);
  eos::SesameMaterial table = model.table();
  if (number > 0) table.number = number;
  io::write_atomically(file, eos::sesame_text(table));
  const auto& e = model.phase_energies();
  const auto& g = table.grids.at(301);
  fmt::print("# {}: {} densities {:.4g} to {:.4g} kg/m3, {} temperatures {:.4g} to {:.4g} K; {}\n", file, g.rho.size(), g.rho.front(),
             g.rho.back(), g.T.size(), g.T.front(), g.T.back(), metal.source);
  fmt::print("[materials.{}-table]\nrho_0 = \"{:g} kg/m3\"\neos = {{ model = \"sesame\", file = {}, number = {} }}\n", name, metal.rho_0,
             io::toml_reader::toml_string(std::filesystem::path(file).filename().string()), table.number);
  fmt::print("phase = {{ e_melt = \"{:.4g} MJ/kg\", e_melted = \"{:.4g} MJ/kg\", e_vapour = \"{:.4g} MJ/kg\", e_vaporised = \"{:.4g} MJ/kg\" }}\n",
             e.melt * 1e-6, e.melted * 1e-6, e.vapour * 1e-6, e.vaporised * 1e-6);
  return printed();
}

/// The words of the command line, last first as CLI11 wants them, with a --set before every override: "--set a=1 b=2 CASE" leaves
/// CASE alone.
static std::vector<std::string> words_of(int argc, char** argv) {
  std::vector<std::string> words;
  bool overrides = false;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const bool value = i > 1 && !words.empty() && words.back() == "--set";
    const bool another = overrides && !word.starts_with('-') && word.find('=') != std::string::npos;
    if (another && !value) words.push_back("--set");
    overrides = value || another || word.starts_with("--set=");
    words.push_back(word);
  }
  std::reverse(words.begin(), words.end());
  return words;
}

int command_line(int argc, char** argv) {
  CLI::App cli("Ejecta: hypervelocity impact with elements that become particles", "ejecta");
  cli.require_subcommand(1);
  Arguments a;
  std::string material, file;
  std::vector<std::string> folders;
  int code = 0, number = 0;
  const auto case_and_overrides = [&](CLI::App* c) {
    c->add_option("CASE", a.target, "case file, or the folder that holds case.toml")->required();
    c->add_option("--set", a.set, "key=value in place of what the case says, e.g. run.end=\"5 us\"")->take_all()->allow_extra_args(false);
    c->add_option("--threads", a.threads, "number of threads (default: all)")->check(CLI::Range(1, 1024));
  };
  const auto case_options = [&](CLI::App* c) {
    case_and_overrides(c);
    c->add_option("--mode", a.mode, "hybrid | erosion | fem | sph, in place of run.mode");
  };
  auto* c_run = cli.add_subcommand("run", "run a case");
  case_options(c_run);
  c_run->add_option("--out", a.out, "output folder (default: runs/CASE-MODE)");
  c_run->add_flag("--force", a.force, "overwrite an existing output folder");
  c_run->callback([&] { code = run_case(a); });
  auto* c_resume = cli.add_subcommand("resume", "continue from the last checkpoint");
  c_resume->add_option("DIR", a.target, "output folder of a run")->required();
  c_resume->add_option("--threads", a.threads, "number of threads (default: all)")->check(CLI::Range(1, 1024));
  c_resume->callback([&] {
    use_threads(a.threads);
    code = resume(a.target);
  });
  auto* c_check = cli.add_subcommand("check", "read, build, print the resolved case, what will be active and the cost");
  case_options(c_check);
  bool no_cost = false;
  c_check->add_flag("--no-cost", no_cost, "without the predicted cost, which takes a few seconds of trial runs");
  c_check->callback([&] { code = check_case(a, !no_cost); });
  auto* c_measure = cli.add_subcommand("measure", "the measurements again, from the stored state");
  c_measure->add_option("DIR", a.target, "output folder of a run")->required();
  bool series = false;
  c_measure->add_flag("--series", series, "every snapshot as well, into DIR/measurements.csv");
  c_measure->callback([&] {
    fmt::print("{}", measure_again(a.target));
    if (series) measure_series(a.target);
    code = printed();
  });
  auto* c_compare = cli.add_subcommand("compare", "runs side by side: what differs in the cases, cost, measurements, energies");
  c_compare->add_option("DIR", folders, "output folders of two or more runs")->required();
  c_compare->callback([&] {
    fmt::print("{}", compare(folders));
    code = printed();
  });
  auto* c_report = cli.add_subcommand("report", "pictures and report.html of a run, into its folder");
  c_report->add_option("DIR", a.target, "output folder of a run that has ended")->required();
  c_report->callback([&] {
    fmt::print("{}", report(a.target));
    code = printed();
  });
  auto* c_trade = cli.add_subcommand("trade", "cost against accuracy over fidelities and modes: table, picture, Pareto front");
  case_and_overrides(c_trade);
  TradeRequest study;
  c_trade->add_option("--modes", study.modes, "modes (default: hybrid,erosion)")->delimiter(',');
  c_trade->add_option("--fidelities", study.fidelities, "draft | standard | fine | reference, or elements across (default: draft,standard,fine)")->delimiter(',');
  c_trade->add_option("--out", a.out, "folder of the study, whose runs that have ended are kept (default: runs/CASE-trade)");
  c_trade->add_flag("--force", a.force, "run anew what is there");
  c_trade->callback([&] {
    code = trade_case(a, study);
    printed();
  });
  auto* c_materials = cli.add_subcommand("materials", "the library: constants, units, sources");
  c_materials->add_option("NAME", material, "a material; without it all names");
  c_materials->callback([&] { code = list_materials(material); });
  auto* c_hugoniot = cli.add_subcommand("hugoniot", "Hugoniot of a material against measured shock states");
  c_hugoniot->add_option("MATERIAL", material, "a material of the library, or with --case of the case")->required();
  c_hugoniot->add_option("--case", file, "case file, or the folder that holds case.toml, whose [materials] are known as well");
  c_hugoniot->callback([&] { code = print_hugoniot(material, file); });
  auto* c_eos = cli.add_subcommand("eos", "tables of equations of state");
  c_eos->require_subcommand(1);
  auto* c_table = c_eos->add_subcommand("table", "write a wide-range SESAME table of a metal");
  c_table->add_option("MATERIAL", material, fmt::format("{}", fmt::join(eos::metal_names(), " | ")))->required();
  c_table->add_option("--out", file, "file to write (default: MATERIAL.ses)");
  c_table->add_option("--number", number, "number of the material in the file")->check(CLI::Range(1, 999999));
  c_table->callback([&] { code = make_table(material, file, number); });
  BenchRequest timing;
  auto* c_bench = cli.add_subcommand("bench", "rates of the kernels on this machine");
  c_bench->add_option("KERNEL", timing.kernel, "hex | sph | octree | all (default)")->check(CLI::IsMember({"hex", "sph", "octree", "all"}));
  c_bench->add_option("--size", timing.size, "hex: elements along an edge (60); sph, octree: number of particles (50000), points (1000000); "
                                             "all: along an edge, of each")
      ->check(CLI::Range(1, 100000000));
  c_bench->add_option("--points", timing.points, "octree: file of float32 x y z radius, point after point");
  c_bench->add_option("--threads", a.threads, "number of threads (default: all)")->check(CLI::Range(1, 1024));
  c_bench->add_option("--json", timing.json, "file for the rates, machine and spread");
  c_bench->callback([&] {
    use_threads(a.threads);
    bench(timing);
    code = printed();
  });
  try {
    std::vector<std::string> names;
    for (const auto* c : cli.get_subcommands({})) names.push_back(c->get_name());
    if (argc < 2) {
      fmt::print(stderr, "error: a command is missing; valid: {}\n", fmt::join(names, ", "));
      return 2;
    }
    if (argv[1][0] != '-' && std::find(names.begin(), names.end(), argv[1]) == names.end()) {
      fmt::print(stderr, "error: \"{}\" is no command{}; valid: {}\n", argv[1], io::toml_reader::did_you_mean(argv[1], names),
                 fmt::join(names, ", "));
      return 2;
    }
    cli.parse(words_of(argc, argv));
  } catch (const CLI::ParseError& e) {
    return cli.exit(e) == 0 ? 0 : 2;
  } catch (const core::CaseError& e) {
    fmt::print(stderr, "error: {}\n", e.what());
    return 2;
  } catch (const core::GuardError& e) {
    fmt::print(stderr, "stopped: {}\n", e.what());
    return 3;
  } catch (const std::filesystem::filesystem_error& e) {  // a path that cannot be looked at
    std::fputs(fmt::format("error: {}\n", e.what()).c_str(), stderr);
    return 2;
  } catch (const std::system_error& e) {  // a stream or file that can no longer be written
    std::fputs(fmt::format("stopped: {}\n", e.what()).c_str(), stderr);
    return 3;
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "stopped: out of memory; a coarser run.fidelity needs less\n");
    return 3;
  }
  return code;
}

}  // namespace app
