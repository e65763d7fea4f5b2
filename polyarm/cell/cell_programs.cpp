#include <algorithm>
#include <filesystem>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/base/file.hpp"
#include "polyarm/cell/build.hpp"
#include "polyarm/cell/cell.hpp"
#include "polyarm/cell/program_tests.hpp"
#include "polyarm/program/code.hpp"
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

}  // namespace

void Cell::build_programs(Problems& problems) {
  for (const FileBreakpoints& each : options_.breakpoints)
    if (const std::string name = name_in(file_.folder, each.file); is_script_of(file_.folder, name))
      breakpoints_.of(name) = {name, each.lines, each.text};
  ProgramHost::Context context;
  context.store = &store_;
  context.files = files_.get();
  context.answers = &answers_;
  context.observer = &observer_;
  context.now = &now_;
  Programs programs = load_programs(
      file_, signals_, *files_, store_, problems,
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
  } else if (!problems.has_errors()) {  // else it lacks what those are about
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
  context.seen_outside = [this](const std::string& name) {
    const std::string set = store_.set_of(name);
    return (!set.empty() && files_->is_live(set)) || links_->source_of(name).has_value();
  };
  context.hold = [this](const std::string& reason, const Location& where) {
    Problem why{"program-hold",      where, reason, "polyarm control resume", Severity::warning,
                {{"reason", reason}}};
    observer_.on_problem(now_, why);
    hold_for(std::move(why));
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
  std::vector<Location> out = breakpoints_.all();
  for (Location& each : out)
    if (!fs::path(each.file).is_absolute()) each.file = (file_.folder / each.file).string();
  return out;
}

std::vector<FileBreakpoints> Cell::kept_breakpoints() const {
  std::vector<FileBreakpoints> out = breakpoints_.files();
  for (FileBreakpoints& each : out) each.file = (file_.folder / each.file).string();
  return out;
}

const TextLines* Cell::lines_of_program(const std::string& file) const {
  return program_ ? program_->interpreter().lines_of(file) : nullptr;
}

/// A line of `text` (of what the program has read) in the text that is known of the file.
int Cell::known_line(FileBreakpoints& file, int line, const std::optional<TextLines>& text) const {
  const TextLines* const read = lines_of_program(file.file);
  if (!file.text && text && (!read || *read != *text)) file.text = read ? *read : *text;
  const TextLines* const told = text ? &*text : read;
  if (!file.text || !told || *told == *file.text) return line;
  const std::vector<int> at = where_lines_are(*told, *file.text);
  const int there = line <= static_cast<int>(at.size()) ? at[static_cast<std::size_t>(line - 1)] : 0;
  return there > 0 ? there : line;
}

void Cell::add_breakpoint(const Location& place, const std::optional<TextLines>& text) {
  const std::string name = name_in(file_.folder, place.file);
  const TextLines* const read = lines_of_program(name);
  if (!read && plc_ && plc_->interpreter().has_file(name))
    throw Error("bad-argument", place.file + " is the PLC's script, which does not pause");
  if (!read && !is_script_of(file_.folder, name))
    throw Error("unknown-file",
                "no program has a file '" + place.file + "', and the cell's folder has no such script",
                "name a script of the cell, as the list of files does");
  int line = place.line;
  if (read && (!text || *text == *read)) {
    const std::vector<Location> found = program_->interpreter().set_breakpoints({{name, line, 0}});
    place_breakpoints();
    if (found.empty())
      throw Error("bad-argument", "no statement begins at or after line " + std::to_string(line) + " of " +
                                      place.file + ": nothing would pause there");
    line = found.front().line;
  }
  FileBreakpoints& file = breakpoints_.of(name_in(file_.folder, name));
  file.add(known_line(file, line, text));
  place_breakpoints();
}

void Cell::drop_breakpoint(const Location& place, const std::optional<TextLines>& text) {
  FileBreakpoints* const file = breakpoints_.find(name_in(file_.folder, place.file));
  if (!file) return;
  file->drop(known_line(*file, place.line, text));
  place_breakpoints();
}

void Cell::clear_breakpoints() {
  for (FileBreakpoints& each : breakpoints_.files()) each.lines.clear();
  place_breakpoints();
}

void Cell::edit_breakpoints(const std::string& file, TextLines text,
                            const std::optional<std::vector<int>>& lines) {
  const std::string name = name_in(file_.folder, file);
  if (!breakpoints_.find(name) && (!lines || lines->empty())) return;
  if (!is_script_of(file_.folder, name))
    throw Error("unknown-file", "the cell's folder has no script '" + file + "'",
                "name a script of the cell, as the list of files does");
  FileBreakpoints& there = breakpoints_.of(name);
  if (lines) {
    there.lines.clear();
    for (const int line : *lines) there.add(line);
    there.text = std::move(text);
  } else {
    if (const TextLines* const read = lines_of_program(name); read && !there.text) there.text = *read;
    there.follow(std::move(text));
  }
  place_breakpoints();
}

/// In the program there is: at those lines of its own text, and where that is the newest they move down
/// again.
void Cell::place_breakpoints() {
  if (!program_) return;
  program::Interpreter& interpreter = program_->interpreter();
  std::vector<Location> wanted;
  std::vector<FileBreakpoints*> same;
  for (FileBreakpoints& each : breakpoints_.files()) {
    const TextLines* const read = interpreter.lines_of(each.file);
    if (!read) continue;
    FileBreakpoints here = each;
    if (each.text && *each.text != *read)
      here.follow(*read);
    else
      same.push_back(&each);
    for (const int line : here.lines) wanted.push_back({each.file, line, 0});
  }
  const std::vector<Location> placed = interpreter.set_breakpoints(wanted);
  for (FileBreakpoints* each : same) {
    each->lines.clear();
    for (const Location& at : placed)
      if (name_in(file_.folder, at.file) == each->file) each->add(at.line);
  }
}

bool Cell::program_runs() const {
  if (!program_ || !begun_ || program_->ended()) return false;
  return !program_->interpreter().paused() || !snapshot().standing || !all_idle();
}

std::string Cell::hint_of_live() const {
  if (!program_ || program_->status().waiting.kind != program::WaitKind::condition) return {};
  std::set<std::string> set_here;  // by somebody in the cell
  for (const Task* task : {program_.get(), plc_.get()}) {
    if (!task) continue;
    program::for_each_statement(task->interpreter().program().statements, [&](const program::Statement& s) {
      using Kind = program::Statement::Kind;
      if (s.kind == Kind::set || s.kind == Kind::set_literal) set_here.insert(s.name);
      for (const program::Clause& clause : s.clauses) set_here.insert(clause.target);
    });
  }
  for (const std::string& name : program_->status().waiting.names) {
    const std::string set = store_.set_of(name);
    if (set.empty() || files_->is_live(set) || set_here.contains(name) || links_->source_of(name)) continue;
    const std::string file = files_->file_of(set).filename().string();
    return "nobody in the cell sets '" + name + "', which comes from " + file +
           ": the run has a copy of that file; where another program writes it, say live: [" +
           fs::path(file).stem().string() + "] in signals.yaml";
  }
  return {};
}

Location Cell::line_under_way(std::optional<std::size_t> robot) const {
  if (!program_ || !begun_ || program_->ended() || jogging_->engaged()) return {};
  const moves::RobotMotion* const motion = robot && moves_ ? motions_[*robot].get() : nullptr;
  const std::uint64_t move = motion ? motion->move_under_way() : 0;
  const Location place = move > 0 ? moves_->place_of(*motion, move) : Location{};
  return place.line > 0 ? place : program_->status().where;
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
  Programs programs = load_programs(file, signals_, *files_, store_, problems);
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
