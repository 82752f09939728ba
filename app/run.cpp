// SPDX-License-Identifier: Apache-2.0
#include "app/run.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <malloc.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>

#include "app/background.hpp"
#include "app/checkpoint.hpp"
#include "app/setup.hpp"
#include "app/snapshot.hpp"
#include "app/summary.hpp"
#include "core/error.hpp"
#include "core/isa.hpp"
#include "core/parallel.hpp"
#include "io/atomic_file.hpp"
#include "io/case_file.hpp"
#include "io/snapshot.hpp"
#include "io/toml_reader.hpp"

namespace app {

namespace fs = std::filesystem;

static std::atomic<bool> interrupted{false};
extern "C" void note_interrupt(int) { interrupted = true; }

// ------------------------------------------------------------------------------------------------ files of a run

/// Keeps a second run out of a folder while it lives.
class FolderLock {
 public:
  explicit FolderLock(const std::string& dir) : folder_(open(dir.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
    if (folder_ >= 0 && flock(folder_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
      close(folder_);
      throw core::CaseError(fmt::format("{}: another run is writing there; wait for it, or give another --out", dir));
    }
  }
  ~FolderLock() {
    if (folder_ >= 0) close(folder_);
  }
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int folder_;
};

/// Before anything is done: a folder that takes no files is for the user to put right. A disk without room stops the run, as it
/// would later on.
static void require_writable(const std::string& dir) {
  const std::string path = dir + "/log.txt";
  const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (file < 0 && errno != ENOSPC && errno != EDQUOT)
    throw core::CaseError(fmt::format("{}: cannot be written: {}; give another --out", path, std::strerror(errno)));
  if (file >= 0) close(file);
}

/// Text for the screen, which may be gone while the run goes on.
static void say(const std::string& text, std::FILE* screen = stdout) {
  std::fputs(text.c_str(), screen);
  std::fflush(screen);
}

/// A text file that grows line by line; a line that cannot be written stops the run.
class LineFile {
 public:
  LineFile(const std::string& path, bool append) : path_(path), file_(path, append ? std::ios::app : std::ios::trunc) {}
  void line(const std::string& text) {
    file_ << text << '\n' << std::flush;
    if (!file_)
      throw core::NoRoomError(path_ + ": cannot be written: no space left on the device? " + io::no_room_advice);
  }

 private:
  std::string path_;
  std::ofstream file_;
};

static const char* history_head =
    "time_s,dt_s,limiter,limiter_index,step,kinetic_J,internal_J,hourglass_J,contact_J,conversion_J,eroded_kinetic_J,"
    "eroded_internal_J,energy_error,momentum_error,elements,elements_awake,particles,leaks";

static std::string history_row(const Simulation& s) {
  const Ledger& l = s.ledger;
  return fmt::format("{:.9e},{:.6e},{},{},{},{:.9e},{:.9e},{:.9e},{:.9e},{:.9e},{:.9e},{:.9e},{:.3e},{:.3e},{},{},{},{}",
                     s.time, s.dt_old, s.limit.kind, s.limit.index, s.steps, l.now.kinetic, l.internal(), l.hourglass,
                     l.contact, l.conversion, l.eroded_kinetic, l.eroded_internal, l.energy_error, l.momentum_error,
                     s.mesh.n_alive, std::min(s.mesh.n_alive, s.mesh.awake_blocks.size() * fem::block_size),
                     s.particles.size(), s.contact.leaks);
}

/// Two times of a history are one row's: its text keeps fewer digits than the clock.
constexpr double same_time = 1e-9;

/// Drops rows later than `time`, and one that was not written to its end, from a history that a resumed run continues. Returns the
/// time of its last row [s], -1 if none is left. Throws GuardError where there is no room; the history is as it was then.
static double trim_history(const std::string& path, double time) {
  std::ifstream in(path);
  std::string kept, line;
  double last = -1;
  for (bool head = true; std::getline(in, line) && !in.eof(); head = false) {
    const double row = head ? -1 : std::strtod(line.c_str(), nullptr);
    if (row > time * (1 + same_time)) continue;
    kept += line + "\n";
    last = row;
  }
  in.close();
  io::write_atomically(path, kept);
  return last;
}

// ------------------------------------------------------------------------------------------------ progress

/// A bar with the time to go on a terminal, a line every tenth elsewhere.
class Progress {
 public:
  Progress(double start, double end) : start_(start), end_(end), terminal_(isatty(fileno(stdout))) {}
  void show(const Simulation& s) {
    const double part = (s.time - start_) / std::max(end_ - start_, 1e-300), wall = seconds();
    if (terminal_ ? wall < next_wall_ : part < next_part_) return;
    next_wall_ = wall + 0.5;
    while (next_part_ <= part) next_part_ += 0.1;
    const double left = part > 1e-6 ? wall * (1 - part) / part : 0;
    const std::string state = fmt::format("t = {:.4g} us  step {}  dt {:.3g} ns  {} elements  {} particles", s.time * 1e6,
                                          s.steps, s.dt * 1e9, s.mesh.n_alive, s.particles.size());
    if (terminal_) {
      constexpr int width = 30;
      const int full = static_cast<int>(std::lround(part * width));
      say(fmt::format("\r[{:-<{}}] {:5.1f} %  ETA {:4.0f} s  {}   ", std::string(static_cast<std::size_t>(full), '#'), width,
                      100 * part, left, state));
    } else {
      say(fmt::format("{:5.1f} %  {}  {:.0f} s gone, {:.0f} s to go\n", 100 * part, state, wall, left));
    }
  }
  void end() const {
    if (terminal_) say("\n");
  }
  double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count(); }

 private:
  double start_, end_;
  bool terminal_;
  double next_wall_ = 0, next_part_ = 0;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

// ------------------------------------------------------------------------------------------------ the loop

struct Output {
  std::string dir;
  double every, history_every, checkpoint_every;
  io::SnapshotWriter snapshots;
  LineFile history, log;
  double last_row = -1;  ///< time of the last row of history [s]
  std::size_t warnings_told = 0;
  Background background{};

  /// Bytes that are copied and written while the run goes on; more is written as it stands, before the run goes on.
  static constexpr double most_copied = 64e6;

  void write_snapshot(const Simulation& s) {
    snapshots.append(snapshot_size(s), [&](io::SnapshotSink& to) { give_snapshot(s, to); });
  }
  void add_snapshot(const Simulation& s) {
    background.wait();  // one copy of the state at a time
    if (snapshot_size(s).bytes() > most_copied) return write_snapshot(s);
    background.start([this, snapshot = take_snapshot(s)] { snapshots.append(snapshot); });
  }
  void add_checkpoint(Simulation& s) {
    const std::string path = dir + "/checkpoint.h5";
    background.wait();
    if (state_bytes(s) > most_copied) return write_checkpoint(s, path);
    background.start([copy = copy_state(s), path]() mutable { copy.write(path); });
  }

  void warn(const std::string& text) {
    log.line("warning: " + text);
    say(fmt::format("\nwarning: {}\n", text), stderr);
  }
  void tell_warnings(const Simulation& s) {
    for (; warnings_told < s.warnings.size(); ++warnings_told) warn(s.warnings[warnings_told]);
  }

  void add_history(const Simulation& s) {
    if (std::abs(s.time - last_row) <= same_time * s.time) return;
    history.line(history_row(s));
    last_row = s.time;
  }
};

/// First multiple of `every` beyond the time.
static double next_multiple(double time, double every) { return every * (std::floor(time / every * (1 + 1e-12) + 1e-9) + 1); }

static bool ended(const Simulation& s) { return s.time >= s.spec.end * (1 - 1e-12); }

/// Steps until the end, and between them what is due: output follows the first step at or past its time and moves no step.
static void advance_to_end(Simulation& s, Output& out) {
  Progress progress(s.time, s.spec.end);
  double last_checkpoint = 0, next_history = next_multiple(s.time, out.history_every);
  while (!ended(s)) {
    if (interrupted) return progress.end();
    const double next_output = next_multiple(s.time, out.every);
    choose_step(s, s.spec.end);
    step(s);
    freeze_clouds(s);
    out.tell_warnings(s);
    progress.show(s);
    if (s.time >= next_history * (1 - 1e-12)) {
      out.add_history(s);
      next_history = next_multiple(s.time, out.history_every);
    }
    if (s.time >= next_output && !ended(s)) out.add_snapshot(s);  // the last state is stored after the loop
    if (progress.seconds() - last_checkpoint > out.checkpoint_every) {
      out.add_checkpoint(s);
      last_checkpoint = progress.seconds();
    }
  }
  out.background.wait();
  progress.end();
}

/// Frees what no checkpoint holds, for a further step would find it again.
static void end_lists(Simulation& s) {
  const auto builds = s.hood.builds;
  core::free_all(s.hood, s.contact.lists, s.contact.changes, s.bond, s.correction, s.velocity_gradient);
  s.hood.builds = builds;
}

/// Gives back to the system what only a further step would need: neither stored nor measured.
static void end_steps(Simulation& s) {
  auto& e = s.mesh.elements;
  core::free_all(e.corner_force, e.hourglass, e.booked, e.volume_0, e.deformation, e.ratio_0, e.dt, e.dt_0, e.pt.q, e.pt.c, e.pt.s);
  core::free_all(s.mesh.corners, s.mesh.corner_start, s.mesh.nodes.v_mean, s.mesh.nodes.row_of_f);
  malloc_trim(0);  // room that lies between what is kept
}

/// References to what nothing is measured by: misspelt, or of what this scene does not have.
static void warn_of_references(Simulation& s, const measure::Result& result) {
  std::vector<std::string> keys;
  for (const auto& v : result.values) keys.push_back(v.key);
  for (const auto& [key, r] : s.spec.reference)
    if (std::find(keys.begin(), keys.end(), key) == keys.end())
      s.warnings.push_back(fmt::format("reference \"{}\": nothing is measured by that name in this run{}", key, io::toml_reader::did_you_mean(key, keys)));
}

/// From the first file on: an interrupted run leaves a folder to resume.
static void catch_interrupts() {
  std::signal(SIGINT, note_interrupt);
  std::signal(SIGTERM, note_interrupt);
  if (std::signal(SIGHUP, note_interrupt) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);  // started to outlive its terminal
  std::signal(SIGPIPE, SIG_IGN);  // results go to files: the run goes on without its screen
}

static void advise_of_room(const std::string& dir) {
  say(fs::exists(dir + "/checkpoint.h5") ? fmt::format("once there is room, go on with: ejecta resume {}\n", dir)
                                         : fmt::format("no state could be stored to go on from; once there is room, start anew with: ejecta run CASE --out {} --force\n", dir),
      stderr);
}

/// f(), which writes into the folder. Returns its exit code, that of a run that was stopped where there was no room before it had begun.
template <class F>
static int writing(const std::string& dir, F&& f) {
  try {
    return f();
  } catch (const core::NoRoomError& e) {
    say(fmt::format("stopped: {}\n", e.what()), stderr);
    advise_of_room(dir);
    return 3;
  }
}

/// Runs to the end or to what stops it, saves the state, reports. Returns the exit code.
static int conclude(Simulation& s, Output& out, double wall_before) {
  const auto begin_time = std::chrono::steady_clock::now();
  RunInfo info;
  int code = 0;
  bool no_room = false;
  const auto stopped = [&](const core::GuardError& e, const char* how) {
    code = 3;
    no_room |= dynamic_cast<const core::NoRoomError*>(&e) != nullptr;
    say(fmt::format("{}{}\n", how, e.what()), stderr);
  };
  try {
    advance_to_end(s, out);
    info.completed = ended(s);
    info.stop_reason = info.completed ? "end time" : "interrupted";
    code = info.completed ? 0 : 130;
  } catch (const core::GuardError& e) {
    info.stop_reason = e.what();
    stopped(e, "\nstopped: ");
  }
  info.wall_seconds = wall_before + std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_time).count();
  info.cpu_seconds = s.work.cpu_seconds_before + cpu_seconds();
  try {
    out.background.wait();
  } catch (const core::GuardError& e) {
    stopped(e, "");
  }
  // The state first, then what is derived from it, the summary last; a disk that is full may refuse any of them.
  try {
    const bool sound = std::isfinite(s.ledger.energy_error);
    end_lists(s);
    if (sound) write_checkpoint(s, out.dir + "/checkpoint.h5");
    check_peaks(s);
    end_steps(s);
    auto snapshot = take_snapshot(s);
    if (sound) out.snapshots.append(snapshot);
    if (sound && code != 130) out.add_history(s);  // a resumed run's history has the rows of one that was not interrupted
    info.elements = s.mesh.n_alive, info.particles = s.particles.size();
    const auto scene = scene_now(s);
    core::free_all(s.mesh, s.particles);
    const auto result = measure_snapshot(std::move(snapshot), scene, s.frozen);
    if (info.completed) warn_of_references(s, result);
    out.tell_warnings(s);
    write_fragments(out.dir, result);
    write_summary(out.dir, s, result, info);
    const std::string report = measurement_table(s.spec, result) + ledger_table(s);
    out.log.line(report);
    say("\n" + report);
  } catch (const core::GuardError& e) {
    stopped(e, "");
  }
  const std::string last = fmt::format("{} at t = {:.6g} us after {} steps, {:.1f} s", info.stop_reason, s.time * 1e6,
                                       s.steps, info.wall_seconds);
  say(last + "\n");
  if (code == 130) say(fmt::format("go on with: ejecta resume {}\n", out.dir));
  if (no_room) advise_of_room(out.dir);
  return code;
}

static Output open_output(const Simulation& s, const std::string& dir, bool go_on) {
  const double last_row = go_on ? trim_history(dir + "/history.csv", s.time) : -1;
  const io::Case& c = s.spec;
  const double history = c.history_every > 0 ? c.history_every : c.end / 1000;
  return {dir,
          c.every > 0 ? c.every : c.end / 20,
          history,
          c.checkpoint_every > 0 ? c.checkpoint_every : 600,
          go_on ? io::SnapshotWriter::reopen(dir, s.time) : io::SnapshotWriter(dir),
          LineFile(dir + "/history.csv", go_on),
          LineFile(dir + "/log.txt", go_on),
          last_row};
}

int run(const io::Case& spec, const std::string& dir, bool force) {
  const auto refuse_to_overwrite = [&] {
    if (fs::exists(dir) && !force && !(fs::is_directory(dir) && fs::is_empty(dir)))
      throw core::CaseError(fmt::format("{}: exists already and is not overwritten; give another --out, or --force", dir));
  };
  refuse_to_overwrite();
  std::error_code error;
  if (fs::equivalent(spec.file, fs::path(dir) / "case.toml", error))
    throw core::CaseError(fmt::format("{}: is the case itself, which the run's case.toml would overwrite; give another --out", spec.file));
  auto s = set_up(spec);
  begin(*s);
  catch_interrupts();
  fs::create_directories(dir, error);
  if (error) throw core::CaseError(fmt::format("{}: the output folder cannot be made: {}", dir, error.message()));
  const FolderLock lock(dir);
  refuse_to_overwrite();  // another run may have begun there since
  require_writable(dir);
  for (const char* name : {"summary.json", "checkpoint.h5", "fragments.csv", "measurements.csv", "report.html", "cloud.png", "speed.png"}) fs::remove(fs::path(dir) / name, error);
  return writing(dir, [&] {
    Output out = open_output(*s, dir, false);
    io::write_atomically(dir + "/case.toml", io::write_case(s->spec));
    out.history.line(history_head);
    out.log.line(fmt::format("{}\nmode {}, {} elements in {} bodies, symmetry 1/{}, {} threads, kernels for {}", spec.title,
                             io::to_string(spec.mode), s->n_elements_initial, spec.bodies.size(), s->spec.symmetry.copies(),
                             core::threads(), core::isa_name()));
    say(fmt::format("{}: {} elements, {} particles, mode {}, end {:.4g} us\n", spec.title, s->mesh.n_alive, s->particles.size(),
                    io::to_string(spec.mode), spec.end * 1e6));
    out.add_history(*s);
    out.write_snapshot(*s);
    return conclude(*s, out, 0);
  });
}

/// What f reads; a file that cannot be read stops no run that is under way: it is for the user to put right.
template <class F>
static auto reading(const std::string& advice, F&& f) {
  try {
    return f();
  } catch (const core::GuardError& e) {
    throw core::CaseError(fmt::format("{}; {}", e.what(), advice));
  }
}

int resume(const std::string& dir) {
  const std::string checkpoint = dir + "/checkpoint.h5";
  if (!fs::exists(checkpoint))
    throw core::CaseError(fmt::format("{}: holds no checkpoint.h5 to go on from; start with: ejecta run CASE --out {}", dir, dir));
  const FolderLock lock(dir);
  auto s = set_up(io::read_case(dir + "/case.toml"));
  begin(*s);
  reading(fmt::format("start anew with: ejecta run CASE --out {} --force", dir), [&] { read_checkpoint(*s, checkpoint); });
  account(*s);
  // a run that was killed, or found the disk full, between its last state and its summary still owes the summary
  if (ended(*s)) {
    if (summary_is_complete(dir)) {
      fmt::print("{}: the run has reached its end time already\n", dir);
      return 0;
    }
    s->limit = {"end", 0, s->dt_old};
  }
  catch_interrupts();
  return writing(dir, [&] {
    Output out = open_output(*s, dir, true);
    if (fs::is_empty(dir + "/history.csv")) out.history.line(history_head);
    out.log.line(fmt::format("resumed at t = {:.6g} us, step {}", s->time * 1e6, s->steps));
    if (!out.snapshots.note().empty()) out.warn(out.snapshots.note());
    say(fmt::format("{}: going on at t = {:.4g} us, step {}\n", s->spec.title, s->time * 1e6, s->steps));
    double before = 0;
    for (const double t : s->work.seconds) before += t;
    return conclude(*s, out, before);
  });
}

/// Of run.h5.
static auto read_stored(const std::string& dir, auto&& f) {
  return reading(fmt::format("finish the run with: ejecta resume {}", dir), f);
}

void measure_series(const std::string& dir) {
  if (!fs::exists(dir + "/run.h5")) throw core::CaseError(fmt::format("{}: holds no run.h5 to measure", dir));
  const auto s = set_up(io::read_case(dir + "/case.toml"));
  const std::size_t n = read_stored(dir, [&] { return io::snapshot_times(dir).size(); });
  std::string text = "time_s,key,value,unit\n";
  for (int k = 0; k < static_cast<int>(n); ++k) {
    auto snapshot = read_stored(dir, [&] { return io::read_snapshot(dir, k); });
    measure::Scene scene = s->scene;
    const auto frozen = recall(snapshot, scene);
    for (const auto& v : measure_snapshot(std::move(snapshot), scene, frozen).values)
      text += fmt::format("{:.9e},{},{:.9e},{}\n", scene.time, v.key, v.value, v.unit);
  }
  io::write_atomically(dir + "/measurements.csv", text);
}

std::string measure_again(const std::string& dir) {
  if (!fs::exists(dir + "/run.h5")) throw core::CaseError(fmt::format("{}: holds no run.h5 to measure", dir));
  const auto s = set_up(io::read_case(dir + "/case.toml"));
  auto snapshot = read_stored(dir, [&] { return io::read_snapshot(dir); });
  measure::Scene scene = s->scene;
  const auto frozen = recall(snapshot, scene);
  const auto result = measure_snapshot(std::move(snapshot), scene, frozen);
  rewrite_measurements(dir, s->spec, result);
  write_fragments(dir, result);
  return measurement_table(s->spec, result);
}

}  // namespace app
