/// Requests that check or rehearse a program or cell without running it, and requests about cells that can be
/// opened.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <mutex>
#include <thread>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/reach.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/cell/cell.hpp"
#include "polyarm/cell/check.hpp"
#include "polyarm/cell/handlers.hpp"
#include "polyarm/cell/known_cells.hpp"
#include "polyarm/cell/rehearsal.hpp"
#include "polyarm/hardware/node_graph.hpp"
#include "polyarm/inside/requests_later.hpp"
#include "polyarm/language/parser.hpp"
#include "polyarm/protocol/projects.hpp"
#include "polyarm/realtime/periodic.hpp"
#include "polyarm/yaml/yaml.hpp"

namespace polyarm::cell {

namespace fs = std::filesystem;

namespace {

using namespace protocol;

/// The parts of the cell that these handlers read.
struct CellsOwners {
  const CellSetup& setup;
  Worker& worker;
};

constexpr std::size_t kMostBytes = 500'000'000;

/// A temporary folder, removed when the last user releases it.
class Scratch {
 public:
  Scratch() {
    std::string pattern = (fs::temp_directory_path() / "polyarm-XXXXXX").string();
    if (!mkdtemp(pattern.data())) throw Error("unwritable", "there is no place for temporary files");
    path_ = pattern;
    grant_->allow(path_);
  }
  ~Scratch() {
    std::error_code error;
    fs::remove_all(path_, error);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
  const std::shared_ptr<ReachGrant> grant_ = reach().grant();
};

/// A background thread that runs one long job at a time, because a job of seconds would block the cell's
/// worker. The process waits for the running job at exit.
class Aside {
 public:
  static Aside& only() {
    static Aside aside;
    return aside;
  }
  void begin(std::function<void()> job) {
    const std::lock_guard lock(mutex_);
    if (busy_.load(std::memory_order_acquire))
      throw Error("busy", "a dry run or check is running", "wait until it has ended");
    busy_.store(true, std::memory_order_release);
    thread_ = std::jthread([this, job = std::move(job)] {
      job();
      busy_.store(false, std::memory_order_release);
    });
  }

 private:
  std::mutex mutex_;
  std::atomic<bool> busy_{false};
  std::jthread thread_;
};

/// Runs `job` in the background and answers with its result. The job must not touch the cell.
template <class Job>
auto aside(Job job) {
  auto sent = errand(std::move(job), [](auto& result) { return std::move(result); });
  Aside::only().begin(std::move(sent.run));
  return std::move(sent.done);
}

/// Path as the user knows it: relative to the cell's folder.
std::string shown(const std::string& file, const fs::path& folder) {
  const fs::path relative = fs::path(file).lexically_relative(folder);
  return relative.empty() || *relative.begin() == ".." ? file : relative.string();
}

std::vector<Finding> findings_in(const std::vector<Problem>& problems, const fs::path& folder) {
  std::vector<Finding> out;
  for (const Problem& p : problems)
    out.push_back({p.code, static_cast<FindingSeverity>(p.severity), shown(p.where.file, folder),
                   p.where.line, p.where.column, p.what, p.advice, protocol::facts_of(p)});
  return out;
}

/// An observer that ignores all events.
class Silence : public Observer {};

std::vector<RehearsedWay> ways_of(const std::vector<RehearsedPath>& paths) {
  std::vector<RehearsedWay> out;
  for (const RehearsedPath& path : paths) out.push_back({path.robot, path.where.line, path.seconds, path.tcp});
  return out;
}

/// Writes the program's text into a folder of its own, together with the scripts beside it that it may
/// include.
fs::path stage_program(const fs::path& original, const std::string& text, const fs::path& to) {
  std::error_code error;
  Problems left_out;  // links that lead outside the cell: a program that includes them reports the error
  for (const auto& entry : fs::directory_iterator(original.parent_path(), error))
    if (entry.is_regular_file(error) && lower(entry.path().extension().string()) == ".script")
      collect(left_out, [&] {
        write_file_atomically(to / entry.path().filename(), read_file(entry.path(), bounds::kProgramBytes));
      });
  const fs::path staged = to / original.filename();
  write_file_atomically(staged, text);
  return staged;
}

/// Collects the reported contacts.
struct ContactList : Observer {
  std::vector<Problem> found;
  void on_problem(Nanoseconds, const Problem& problem) override {
    if (problem.code == "contact") found.push_back(problem);
  }
};

/// Adds the contacts of the program from a physics run. Its time is limited because a person waits for the
/// answer.
void add_contacts(const CellFile& file, const description::Catalogue& catalogue, const fs::path& folder,
                  const fs::path& state, ProgramDry::Answer& out) {
  constexpr Nanoseconds kMost = 120'000'000'000, kTimeout = 20'000'000'000;
  if (!file.signals.empty() && !signals::load_signals((file.folder / file.signals).string()).live.empty()) {
    out.contacts.unchecked = {
        "contacts are not checked here, because the program writes live data files: polyarm check --dry runs "
        "it"};
    return;
  }
  ContactList contacts;
  CellOptions options;
  options.lock_step = true;
  options.allow_contact = options.contact_errors = true;
  options.no_code = true;
  options.cycles = 1;
  options.state_folder = state;
  Cell cell(file, catalogue, options, contacts);
  CellInside& inside = inside_of(cell);
  const ContactState facts = contact_state(inside.setup, inside.machine, inside.contacts);
  out.contacts.checked = facts.checked;
  out.contacts.unchecked = facts.unchecked;
  if (!facts.checked) return;
  control::ControlLoop& loop = inside.machine.loop();
  const Nanoseconds until = realtime::monotonic_now() + kTimeout;
  loop.begin();
  while (!inside.life->finished() && !inside.life->failure() && loop.cycle().time < kMost &&
         realtime::monotonic_now() < until) {
    const Nanoseconds next = loop.cycle().time + Cell::kTick;
    cell.tick(loop.cycle().time);
    while (loop.cycle().time < next) loop.step_next();
  }
  loop.end();
  out.contacts.seconds = seconds(loop.cycle().time);
  out.contacts.whole = inside.life->finished();
  for (Finding& finding : findings_in(contacts.found, folder)) out.problems.push_back(std::move(finding));
  for (Finding& finding : findings_in(inside.guards->would_stop(), folder))
    out.problems.push_back(std::move(finding));
}

ProgramDry::Answer dry_run(CellFile file, const description::Catalogue& catalogue, const fs::path& original,
                           const std::string& text) {
  const hardware::OffGraph off_graph;
  const Scratch scratch;
  const fs::path folder = scratch.path() / "program";
  fs::create_directory(folder);
  file.program = stage_program(original, text, folder).string();
  const CellFile physics = file;
  for (RobotEntry& robot : file.robots) robot.hardware = "mock";
  CellOptions options;
  options.lock_step = true;
  options.allow_contact = true;
  options.no_code = true;
  options.state_folder = scratch.path() / "state";
  ProgramDry::Answer out;
  Silence silence;
  try {
    Cell cell(file, catalogue, options, silence);
    const Rehearsal found = rehearse(inside_of(cell), true);
    out.problems = findings_in(found.problems.list(), folder);
    out.moves = static_cast<std::size_t>(found.moves);
    out.paths = ways_of(found.paths);
    if (!found.reached.file.empty())
      out.reached.emplace(FileLine{shown(found.reached.file, folder), found.reached.line});
  } catch (const Error& e) {
    out.problems = findings_in(e.problems(), folder);
  }
  Problems reported_already;  // by the rehearsal
  collect(reported_already, [&] { add_contacts(physics, catalogue, folder, scratch.path() / "physics", out); });
  return out;
}

fs::path new_project(const std::string& name) {
  const auto good = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-';
  };
  if (name.empty() || name.size() > 60 || !std::all_of(name.begin(), name.end(), good))
    throw Error("bad-argument", "'" + name + "' is not a name for a cell", "letters, digits, _ and -");
  const fs::path folder = projects_folder() / name;
  std::error_code error;
  if (fs::exists(folder, error))
    throw Error("exists", "there is a cell '" + name + "' already", "take another name");
  fs::create_directories(folder.parent_path(), error);
  if (error) throw Error("unwritable", "'" + folder.parent_path().string() + "': " + error.message());
  return folder;
}

/// Copies everything except hidden files and links.
void copy_project(const fs::path& from, const fs::path& to) {
  std::uintmax_t bytes = 0;
  fs::create_directory(to);
  for (auto each = fs::recursive_directory_iterator(from); each != fs::recursive_directory_iterator();
       ++each) {
    const fs::path at = to / each->path().lexically_relative(from);
    if (each->path().filename().string().starts_with(".") || each->is_symlink()) {
      if (each->is_directory()) each.disable_recursion_pending();
    } else if (each->is_directory()) {
      fs::create_directory(at);
    } else if (each->is_regular_file()) {
      bytes += each->file_size();
      if (bytes > kMostBytes) throw Error("too-large", "the cell's folder has more than 500 MB");
      fs::copy_file(each->path(), at);
    }
  }
}

/// Builds the project in a temporary folder beside its final place, then renames it when complete.
NameAndFolder make_project(const std::string& name, const std::function<void(const fs::path&)>& fill) {
  const AsUser user;
  const fs::path folder = new_project(name);
  const fs::path coming = folder.parent_path() / ("." + name + ".coming");
  std::error_code error;
  fs::remove_all(coming, error);
  try {
    fill(coming);
    fs::rename(coming, folder);
  } catch (const fs::filesystem_error& e) {
    fs::remove_all(coming, error);
    throw Error("unwritable", e.what());
  } catch (...) {
    fs::remove_all(coming, error);
    throw;
  }
  return {name, folder.string()};
}

void write_new_cell(const fs::path& folder, const std::string& robot) {
  fs::create_directory(folder);
  write_file_atomically(folder / "cell.yaml",
                        "polyarm: cell/1\nrobots:\n  arm: {model: " + robot +
                            ", hardware: mujoco}\nscene: scene.yaml\nprogram: main.script\n");
  write_file_atomically(folder / "scene.yaml",
                        "polyarm: scene/1\nfloor: {height: -0.75}\nfixtures:\n"
                        "  table: {box: [1.4, 1.4, 0.04], at: [0.2, 0, -0.02]}\n");
  write_file_atomically(folder / "points.points", "# Poses of the TCP in the world\nPose: RPY\n");
  write_file_atomically(folder / "main.script", "load points\n");
}

// --- handlers

Poll<ProgramDry::Answer> program_dry(const CellsOwners& cell, const ProgramDry& request) {
  const fs::path original = project_file(cell.setup.file.folder, request.name);
  const std::string text = request.text ? *request.text : read_file(original);
  if (text.size() > kLargestText) throw Error("too-large", "the text has more than 900 kB");
  return aside([file = cell.setup.file, catalogue = cell.setup.catalogue, original, text] {
    return dry_run(file, catalogue, original, text);
  });
}

Poll<CellCheck::Answer> cell_check(const CellsOwners& cell, const CellCheck&) {
  const CellFile& file = cell.setup.file;
  Overrides overrides;
  if (file.robots.size() == 1) overrides.robot = file.robots.front().model;
  return aside([path = file.path, folder = file.folder, catalogue = cell.setup.catalogue, overrides] {
    const hardware::OffGraph off_graph;
    const Scratch scratch;
    CheckOptions options;
    options.state_folder = scratch.path() / "state";
    const CheckResult result = check(path, overrides, catalogue, options);
    return CellCheck::Answer{findings_in(result.problems, folder), result.points.size(),
                             static_cast<std::size_t>(result.moves)};
  });
}

Poll<CellReach::Answer> cell_reach(const CellsOwners& cell, const CellReach& request) {
  return aside([open = cell.setup.file.path, folder = request.folder.value_or(""),
                allowed = request.allow.value_or(Names{})] { return reach_of_cell(open, folder, allowed); });
}

Poll<CellsList::Answer> cells(const CellsOwners& cell, const CellsList&) {
  return later(cell.worker, [open = cell.setup.file.folder] { return known_cells(open); });
}

Poll<NameAndFolder> cell_save_as(const CellsOwners& cell, const CellSaveAs& request) {
  return later(cell.worker, [name = request.name, from = cell.setup.file.folder] {
    return make_project(name, [&](const fs::path& to) { copy_project(from, to); });
  });
}

Poll<NameAndFolder> cell_new(const CellsOwners& cell, const CellNew& request) {
  return later(cell.worker, [name = request.name, robot = request.robot, catalogue = cell.setup.catalogue] {
    catalogue.load(robot);  // throws if there is no such robot
    return make_project(name, [&](const fs::path& to) { write_new_cell(to, robot); });
  });
}

}  // namespace

std::vector<Handler> cells_handlers() {
  return handlers<program_dry, cell_check, cell_reach, cells, cell_save_as, cell_new>();
}

}  // namespace polyarm::cell
