#include <algorithm>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/base/file.hpp"
#include "polyarm/cell/build.hpp"
#include "polyarm/cell/cell.hpp"
#include "polyarm/cell/program_tests.hpp"
#include "polyarm/program/parser.hpp"

namespace polyarm::cell {

namespace {

namespace fs = std::filesystem;

/// A file of the folder by its name in there; another as it is.
std::string name_in(const fs::path& folder, const std::string& file) {
  std::error_code error;
  const std::string name = fs::proximate(file, folder, error).generic_string();
  return error || name.empty() || name.starts_with("..") ? file : name;
}

bool is_script_of(const fs::path& folder, const std::string& name) {
  std::error_code error;
  const fs::path path(name);
  return !path.is_absolute() && !name.starts_with("..") && path.extension() == ".script" &&
         fs::is_regular_file(folder / path, error);
}

bool same_place(const Location& a, const Location& b) {
  return a.file == b.file && a.line == b.line;
}

}  // namespace

void Cell::build_programs(Problems& problems) {
  for (const Location& each : options_.breakpoints)
    if (const std::string name = name_in(file_.folder, each.file); is_script_of(file_.folder, name))
      breakpoints_.push_back({name, each.line, 0});
  ProgramHost::Context context;
  context.store = &store_;
  context.files = files_.get();
  context.answers = &answers_;
  context.observer = &observer_;
  context.now = &now_;
  Programs programs = load_programs(
      file_, *files_, store_, problems,
      [&] {
        links_ = std::make_unique<CellLinks>(signals_, states_, store_, options_.lock_step,
                                             options_.lock_step && !options_.links, problems);
        heartbeats_ = std::make_unique<Heartbeats>(signals_, store_, problems);
      },
      options_.read);
  if (programs.plc) {
    context.task = "plc";
    plc_ = std::make_unique<Task>("plc", std::move(*programs.plc), context);
  }
  program_context_ = context;
  if (options_.test) {
    program::Program tests = program::load_program(options_.test->file.string());
    test_ = std::make_unique<TestTask>(*this, std::move(tests), options_.test->index, context, problems);
  }
  if (!programs.program) return;
  if (test_) {
    ready_program_ = std::move(programs.program);
  } else {
    collect(problems, [&] { start_program(std::move(*programs.program)); });
    begun_ = !options_.waits;
  }
}

void Cell::start_program(program::Program program) {
  const auto there = [](const auto& motion) { return motion != nullptr; };
  if (std::none_of(motions_.begin(), motions_.end(), there) &&
      std::none_of(bases_.begin(), bases_.end(), there))
    throw Error(Problem{"no-motion", file_.program_where,
                        "the program needs a robot whose joints a trajectory controller moves",
                        "give the cell a robot, and leave 'controllers' out or name a "
                        "joint_trajectory_controller for all joints"});
  std::vector<ProgramMoves::Robot> robots;
  for (std::size_t i = 0; i < robots_.size(); ++i)
    robots.push_back({robots_[i].get(), motions_[i].get(), bases_[i].get()});
  told_ended_.erase(program_.get());
  program_.reset();
  moves_ = std::make_unique<ProgramMoves>("program", std::move(robots), file_.motion, store_);
  ProgramHost::Context context = program_context_;
  context.task = "program";
  context.moves = moves_.get();
  context.standing = [this] { return snapshot().standing; };
  context.hold = [this](const std::string& reason, const Location& where) {
    observer_.on_problem(now_, {"held", where, reason, "polyarm control resume", Severity::warning});
    loop_->supervisor().latch().request(realtime::StopKind::controlled);
  };
  program_ = std::make_unique<Task>("program", std::move(program), context);
  if (options_.cycles > 0) program_->interpreter().limit_passes(options_.cycles);
  begun_ = true;
  ended_at_ = -1;
  finished_ = false;
  if (!options_.test && options_.state_folder.empty())
    safe_points_ =
        std::make_unique<SafePoints>(file_.folder / ".state" / "program.json", *worker_, options_.lock_step);
  if (safe_points_) safe_points_->set_held(held_parts_->names(snapshot()));
  place_breakpoints();
}

void Cell::put_program(program::Program program) {
  if (program_ && begun_ && !program_->ended())
    throw Error("program-runs", "a program is under way: " + program_->sentence(),
                "end it first: program.stop");
  options_.waits = true;
  start_program(std::move(program));
  begun_ = false;
}

std::vector<Location> Cell::breakpoints() const {
  std::vector<Location> out = breakpoints_;
  for (Location& each : out)
    if (!fs::path(each.file).is_absolute()) each.file = (file_.folder / each.file).string();
  return out;
}

void Cell::add_breakpoint(const Location& place) {
  Location wanted{name_in(file_.folder, place.file), place.line, 0};
  if (program_ && program_->interpreter().has_file(wanted.file)) {
    const std::vector<Location> found = program_->interpreter().set_breakpoints({wanted});
    place_breakpoints();
    if (found.empty())
      throw Error("bad-argument", "no statement begins at or after line " + std::to_string(place.line) +
                                      " of " + place.file + ": nothing would pause there");
    wanted = {name_in(file_.folder, found.front().file), found.front().line, 0};
  } else if (plc_ && plc_->interpreter().has_file(wanted.file)) {
    throw Error("bad-argument", place.file + " is the PLC's script, which does not pause");
  } else if (!is_script_of(file_.folder, wanted.file)) {
    throw Error("unknown-file",
                "no program has a file '" + place.file + "', and the cell's folder has no such script",
                "name a script of the cell, as the list of files does");
  }
  const auto same = [&](const Location& each) { return same_place(each, wanted); };
  if (std::none_of(breakpoints_.begin(), breakpoints_.end(), same)) breakpoints_.push_back(wanted);
  place_breakpoints();
}

void Cell::drop_breakpoint(const Location& place) {
  const Location wanted{name_in(file_.folder, place.file), place.line, 0};
  std::erase_if(breakpoints_, [&](const Location& each) { return same_place(each, wanted); });
  place_breakpoints();
}

/// In the program there is; where its text has changed they move down again.
void Cell::place_breakpoints() {
  if (!program_) return;
  program::Interpreter& interpreter = program_->interpreter();
  std::vector<Location> now;
  for (const Location& each : breakpoints_)
    if (!interpreter.has_file(each.file)) now.push_back(each);
  for (const Location& each : interpreter.set_breakpoints(breakpoints_))
    now.push_back({name_in(file_.folder, each.file), each.line, 0});
  breakpoints_ = std::move(now);
}

bool Cell::program_runs() const {
  if (!program_ || !begun_ || program_->ended()) return false;
  return !program_->interpreter().paused() || !snapshot().standing || !all_idle();
}

void Cell::end_moves() {
  for (const auto& motion : motions_)
    if (motion) motion->end(1);
  drop_bases();
}

void Cell::end_program() {
  if (!program_ || !begun_ || program_->ended()) return;
  program_->interpreter().stop();
  end_moves();
}

bool Cell::all_idle() const {
  for (std::size_t i = 0; i < robots_.size(); ++i)
    if (!idle(i)) return false;
  return true;
}

program::StartReport Cell::prepare_program(const std::string& name, int line) {
  if (program_ && begun_ && !program_->ended()) {  // its `on stop` is done: the robots stand
    program_->interpreter().stop();
    program_->tick();
  }
  std::unique_ptr<Task> before = std::exchange(program_, nullptr);
  std::unique_ptr<ProgramMoves> moves = std::move(moves_);
  try {
    begin_program(name, {});
    program::StartReport report;
    if (line > 0) report = program_->interpreter().start_at(line);
    program_->interpreter().pause_here();
    program_->refresh();
    if (line <= 0) report.where = program_->status().where;
    return report;
  } catch (const Error&) {  // the one before stays as it was, at its end
    program_ = std::move(before);
    moves_ = std::move(moves);
    throw;
  }
}

namespace {
/// What a PLC cannot take up it begins anew, and says so.
void continue_plc(Cell& cell, const SafePoint& point) {
  Task* const plc = cell.plc();
  if (!plc) return;
  const auto anew = [&](const std::string& why) { cell.tell("the PLC's script begins anew: " + why); };
  if (point.plc_ended) {
    plc->interpreter().stop();
  } else if (!point.plc) {
    return anew("it was waiting for a person or a file when the program was cut off");
  } else {
    try {
      plc->interpreter().restore(*point.plc);
    } catch (const Error& e) {
      return anew(e.problems().front().what);
    }
  }
  plc->refresh();
}
}  // namespace

program::StartReport Cell::continue_program() {
  const SafePoint point = SafePoints::read(file_.folder / ".state" / "program.json");
  if (!program_) throw Error("no-program", "the cell has no program");
  program::StartReport report = program_->interpreter().restore(point.state);
  for (const auto& [name, value] : point.values)
    if (store_.find(name) && !store_.is_tag(name)) store_.set(name, value, "continue");
  program_->refresh();
  for (const auto& [name, value] : point.tags) {
    const auto role = store_.tag_role(name);
    if (role && *role != data::TagRole::state && store_.find(name)->kind() == value.kind())
      store_.set(name, value, "continue");
  }
  continue_plc(*this, point);
  held_before_ = point.held;
  if (!scene_.parts.empty() && !options_.real)
    observer_.on_note("the simulated parts lie where the scene puts them: what was held or moved is not");
  return report;
}

void Cell::keep_safe_point() {
  if (program_ && safe_points_) safe_points_->finish(*program_);
}

void Cell::begin_program(const std::string& name, const Location& where) {
  if (program_ && begun_ && !program_->ended())
    throw Error(Problem{"still-running", where, "the program is still running: " + program_->sentence(),
                        "wait for its end, or stop it"});
  for (std::size_t i = 0; i < robots_.size(); ++i)
    if (!idle(i))
      throw Error(Problem{"moving", where, "the robot '" + robots_[i]->entry.name + "' still moves", {}});
  if (name.empty() && ready_program_) {
    start_program(std::move(*ready_program_));
    return ready_program_.reset();
  }
  CellFile file = file_;
  if (!name.empty()) file.program = name, file.program_where = where;
  file.plc.clear();
  if (file.program.empty())
    throw Error(Problem{"no-program", where, "the cell has no program", "name one: program: NAME"});
  files_->flush();
  Problems problems;
  Programs programs = load_programs(file, *files_, store_, problems);
  problems.throw_if_errors();
  start_program(std::move(*programs.program));
}

void Cell::tick_program(Nanoseconds now) {
  if (!safe_points_) return program_->tick();
  if (held_parts_->changed(snapshot())) safe_points_->set_held(held_parts_->names(snapshot()));
  const auto look = [&] { safe_points_->tick(now, *program_, plc_.get(), store_); };
  program_->tick(look);
  look();
}

const char* Cell::control_holder() const {
  if (jogging_->engaged()) return "jog";
  return program_runs() ? "program" : "nobody";
}

void Cell::stop_programs() {
  for (Task* task : {program_.get(), plc_.get()})
    if (task) task->interpreter().stop();
}

}  // namespace polyarm::cell
