#include "polyarm/tasks/programs.hpp"

#include <algorithm>
#include <filesystem>
#include <set>
#include <utility>

#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/data/frame_chain.hpp"
#include "polyarm/data/point_frames.hpp"
#include "polyarm/language/parser.hpp"
#include "polyarm/program/code.hpp"

namespace polyarm::cell {

namespace fs = std::filesystem;

Programs::Programs(const CellSetup& setup, Machine& machine, CellData& data, Motions& motions, Worker& worker,
                   Observer& observer)
    : setup_(setup),
      machine_(machine),
      data_(data),
      motions_(motions),
      worker_(worker),
      observer_(observer),
      waits_(setup.options.waits) {
  for (const std::string& answer : setup.options.answers) answers_.give(answer);
}
Programs::~Programs() = default;

ProgramHost::Context Programs::context(const std::string& task) const {
  ProgramHost::Context out;
  out.task = task;
  out.store = &data_.store;
  out.files = &data_.files();
  out.answers = const_cast<Answers*>(&answers_);
  out.observer = &observer_;
  out.now = &machine_.clock();
  out.seed = setup_.file.seed;
  out.belts = belts_.get();
  out.streams = streams_.get();
  out.folder = setup_.file.folder;
  out.in_world = [this](const data::Point& point) { return in_world(point); };
  return out;
}

/// As for programs (ProgramMoves::in_world), but robots may be under way: a frame on one is where it is now.
data::Point Programs::in_world(const data::Point& point) const {
  if (point.frame().empty()) return point;
  const data::FrameChain chain = data::frame_chain(point.frame(), [this](const std::string& name) {
    const data::Value* value = belts_ && belts_->has(name) ? nullptr : data_.store.find(name);
    return value ? value->as_point() : nullptr;
  });
  if (belts_ && belts_->has(chain.root)) return point;
  Pose frame = chain.pose;
  if (!chain.root.empty()) {
    const auto part = data::robot_frame(chain.root);
    if (part && part->robot.empty() && setup_.robots.size() != 1) return point;
    const auto on = part ? on_robot(*part) : std::nullopt;
    if (!on)
      throw Error("unknown-frame",
                  "there is no frame '" + chain.root + "'" + did_you_mean(chain.root, data_.store.names()),
                  data::kFramesAre);
    frame = *on * frame;
  }
  data::Point out = data::converted(point, "world", normalized(frame.rotation * data::axes_of(point)));
  out.pose = frame * point.pose;
  return out;
}

std::optional<Pose> Programs::on_robot(const data::RobotFrame& frame) const {
  using Part = data::RobotFrame::Part;
  for (std::size_t i = 0; i < setup_.robots.size(); ++i) {
    const CellRobot& robot = *setup_.robots[i];
    if (!frame.robot.empty() && robot.entry.name != frame.robot) continue;
    if (frame.part == Part::base) return robot.entry.base;
    const Pose tcp = motions_.tcp(i);
    return frame.part == Part::tcp ? tcp : tcp * inverse(robot.tool.tcp);
  }
  return std::nullopt;
}

void Programs::load(Problems& problems) {
  std::vector<std::string> names;
  for (const auto& robot : setup_.robots) names.push_back(robot->entry.name);
  held_parts_ = std::make_unique<HeldParts>(std::move(names), setup_.scene, machine_.table());
  if (!setup_.file.streams.empty())
    streams_ = std::make_unique<Streams>(
        setup_.file.streams,
        Streams::May{!setup_.options.lock_step || setup_.options.links, setup_.options.real});
  const auto connect = [&] {  // links bring tags, which may be encoders
    data_.connect_links(problems);
    if (!setup_.file.belts.empty())
      collect(problems, [&] { belts_ = std::make_unique<Belts>(setup_.file.belts, machine_, data_.store); });
  };
  for (const FileBreakpoints& each : setup_.options.breakpoints) keep_breakpoints(each);
  loaded_ = load_programs(setup_.file, data_.signals(), data_.files(), data_.store, problems, connect,
                          setup_.options.read);
  if (!loaded_.plc) return;
  ProgramHost::Context context = this->context("plc");
  context.keeps_events = true;
  plc_ = std::make_unique<Task>("plc", std::move(*loaded_.plc), std::move(context));
}

void Programs::start_loaded(Problems& problems) {
  std::optional<program::Program> program = std::exchange(loaded_.program, std::nullopt);
  if (!program) return;
  if (setup_.options.test) {
    ready_ = std::move(program);
  } else if (!problems.has_errors()) {  // otherwise it lacks the data that the problems are about
    collect(problems, [&] { start(std::move(*program)); });
    begun_ = !waits_;
  }
}

void Programs::start(program::Program program) {
  if (!motions_.any())
    throw Error(Problem{"no-motion", setup_.file.program_where,
                        "the program needs a robot whose joints a trajectory controller moves",
                        "give the cell a robot, and leave 'controllers' out or name a "
                        "joint_trajectory_controller for all joints"});
  std::vector<ProgramMoves::Robot> robots;
  for (std::size_t i = 0; i < setup_.robots.size(); ++i)
    robots.push_back({setup_.robots[i].get(), motions_.motion(i), motions_.wheels(i)});
  program_.reset();
  moves_ = std::make_unique<ProgramMoves>("program", std::move(robots), setup_.file.motion, data_.store);
  moves_->set_belts(belts_.get(), [this] { return motions_.first_pass(); });
  moves_->set_joints_now([this](std::size_t robot) {
    std::vector<double> out;
    for (const JointPlaces::Place& place : machine_.joint_places().of(robot))
      out.push_back(JointPlaces::commanded(machine_.snapshot(), place));
    return out;
  });
  ProgramHost::Context context = this->context("program");
  context.moves = moves_.get();
  force_ = std::make_unique<ForceReadings>(setup_, machine_, observer_);
  context.force = force_.get();
  context.standing = [this] {
    // A move that is planned may begin in the next cycle, unless the cell is held.
    const control::Snapshot& now = machine_.snapshot();
    return now.standing && (now.state != control::RunState::running || motions_.all_idle());
  };
  context.seen_outside = [this](const std::string& name) {
    const std::string set = data_.store.set_of(name);
    return (!set.empty() && data_.files().is_live(set)) || data_.links().source_of(name).has_value();
  };
  context.hold = [this](const std::string& reason, const Location& where) {
    if (setup_.options.resume_holds) return;
    Problem why{"program-hold",      where, reason, "polyarm control resume", Severity::warning,
                {{"reason", reason}}};
    observer_.on_problem(machine_.now(), why);
    machine_.hold_for(std::move(why));
  };
  program_ = std::make_unique<Task>("program", std::move(program), context);
  if (setup_.options.cycles > 0) program_->interpreter().limit_passes(setup_.options.cycles);
  begun_ = true;
  ++starts_;
  if (!setup_.options.test && setup_.options.state_folder.empty())
    safe_points_ = std::make_unique<SafePoints>(setup_.file.folder / ".state" / "program.json", worker_,
                                                setup_.options.lock_step);
  if (safe_points_) safe_points_->set_held(held_parts_->names(machine_.snapshot()));
  place_breakpoints();
}

void Programs::put(program::Program program) {
  if (under_way())
    throw Error("program-runs", "a program is running: " + program_->sentence(),
                "end it first: program.stop");
  waits_ = true;
  start(std::move(program));
  begun_ = false;
}

bool Programs::runs() const {
  if (!under_way()) return false;
  return !program_->interpreter().paused() || !machine_.snapshot().standing || !motions_.all_idle();
}

std::string Programs::hint_of_live() const {
  if (!program_ || program_->status().waiting.kind != program::WaitKind::condition) return {};
  std::set<std::string> set_here;  // set by the program or the PLC
  for (const Task* task : {program_.get(), plc_.get()}) {
    if (!task) continue;
    program::for_each_statement(task->interpreter().program().statements, [&](const program::Statement& s) {
      using Kind = program::Statement::Kind;
      if (s.kind == Kind::set || s.kind == Kind::set_literal || s.kind == Kind::pulse) set_here.insert(s.name);
      for (const program::Clause& clause : s.clauses) set_here.insert(clause.target);
    });
  }
  for (const std::string& name : program_->status().waiting.names) {
    const std::string set = data_.store.set_of(name);
    if (data_.store.tag_role(name) == data::TagRole::state) continue;  // hardware sets it
    if (set.empty() || data_.files().is_live(set) || set_here.contains(name) || data_.links().source_of(name))
      continue;
    const std::string file = data_.files().file_of(set).filename().string();
    return "nothing in the cell sets '" + name + "', which comes from " + file +
           ": the run has a copy of that file; if another program writes it, set live: [" +
           fs::path(file).stem().string() + "] in signals.yaml";
  }
  return {};
}

Location Programs::touch_of(const moves::RobotMotion& motion) const {
  return moves_ && under_way() ? moves_->touch_of(motion) : Location{};
}

bool Programs::touches(const moves::RobotMotion& motion, std::uint64_t move) const {
  return moves_ && under_way() && !moves_->touch_of(motion, move).file.empty();
}

bool Programs::touches() const {
  for (std::size_t i = 0; i < setup_.robots.size(); ++i)
    if (const moves::RobotMotion* motion = motions_.motion(i); motion && !touch_of(*motion).file.empty()) return true;
  return false;
}

Location Programs::place_of(const moves::RobotMotion& motion, std::uint64_t move) const {
  return moves_ ? moves_->place_of(motion, move) : Location{};
}

void Programs::forget(const moves::RobotMotion& motion) {
  if (moves_) moves_->forget(motion);
}
void Programs::forget(const moves::BaseMotion& base) {
  if (moves_) moves_->forget(base);
}

void Programs::end() {
  if (!under_way()) return;
  program_->interpreter().stop();
  motions_.end();
}

void Programs::stop_all() {
  for (Task* task : {program_.get(), plc_.get()})
    if (task) task->interpreter().stop();
}

program::StartReport Programs::prepare(const std::string& name, int line) {
  if (under_way()) {  // the robots are at rest, so its `on stop` runs to its end
    program_->interpreter().stop();
    program_->tick();
  }
  std::unique_ptr<Task> before = std::exchange(program_, nullptr);
  std::unique_ptr<ProgramMoves> moves = std::move(moves_);
  const std::uint64_t starts = starts_;
  try {
    begin(name, {});
    program::StartReport report;
    if (line > 0) report = program_->interpreter().start_at(line);
    program_->interpreter().pause_here();
    program_->refresh();
    if (line <= 0) report.where = program_->status().where;
    return report;
  } catch (const Error&) {  // keep the previous program, at its end
    program_ = std::move(before);
    moves_ = std::move(moves);
    starts_ = starts;
    throw;
  }
}

void Programs::begin(const std::string& name, const Location& where) {
  if (under_way())
    throw Error(Problem{"still-running", where, "the program is still running: " + program_->sentence(),
                        "wait for its end, or stop it"});
  for (std::size_t i = 0; i < setup_.robots.size(); ++i)
    if (!motions_.idle(i))
      throw Error(
          Problem{"moving", where, "the robot '" + setup_.robots[i]->entry.name + "' still moves", {}});
  if (name.empty() && ready_) {
    start(std::move(*ready_));
    return ready_.reset();
  }
  CellFile file = setup_.file;
  if (!name.empty()) file.program = name, file.program_where = where;
  file.plc.clear();
  if (file.program.empty())
    throw Error(Problem{"no-program", where, "the cell has no program", "name one: program: NAME"});
  data_.files().flush();
  Problems problems;
  LoadedPrograms programs = load_programs(file, data_.signals(), data_.files(), data_.store, problems);
  problems.throw_if_errors();
  start(std::move(*programs.program));
}

/// If the PLC cannot continue it restarts, and this is reported.
void Programs::continue_plc(const SafePoint& point) {
  Task* const plc = plc_.get();
  if (!plc) return;
  const auto anew = [&](const std::string& why) { observer_.on_note("the PLC's script restarts: " + why); };
  if (point.plc_ended) {
    plc->interpreter().stop();
  } else if (!point.plc) {
    return anew("it was waiting for a person or a file when the program was interrupted");
  } else {
    try {
      plc->interpreter().restore(*point.plc);
    } catch (const Error& e) {
      return anew(e.problems().front().what);
    }
  }
  plc->refresh();
}

program::StartReport Programs::continue_from_safe_point() {
  const SafePoint point = SafePoints::read(setup_.file.folder / ".state" / "program.json");
  if (!program_) throw Error("no-program", "the cell has no program");
  program::StartReport report = program_->interpreter().restore(point.state);
  for (const auto& [name, value] : point.values)
    if (data_.store.find(name) && !data_.store.is_tag(name)) data_.store.set(name, value, "continue");
  program_->refresh();
  for (const auto& [name, value] : point.tags) {
    const auto role = data_.store.tag_role(name);
    if (role && *role != data::TagRole::state && data_.store.find(name)->kind() == value.kind())
      data_.store.set(name, value, "continue");
  }
  continue_plc(point);
  held_before_ = point.held;
  if (!setup_.scene.parts.empty() && !setup_.options.real)
    observer_.on_note(
        "the simulated parts are at their initial places, not where the program had moved them");
  return report;
}

void Programs::keep_safe_point() {
  if (program_ && safe_points_) safe_points_->finish(*program_);
}

void Programs::end_pulses() {
  for (Task* task : {program_.get(), plc_.get()})
    if (task) task->interpreter().end_pulses();
}

namespace {
/// A tag of a lost link keeps its value, so that a belt with this encoder would seem to stand.
std::optional<Problem> lost_encoder(const std::vector<BeltEntry>& belts, const CellLinks& links) {
  for (const BeltEntry& belt : belts) {
    const auto source = links.source_of(belt.encoder);
    if (!source || source->direction == "out" || source->quality != "stale") continue;
    const std::string reason = "'" + belt.encoder + "' is stale";
    return Problem{"link-lost",
                   belt.where,
                   "the encoder of the belt '" + belt.name + "' comes over the link '" + source->link +
                       "', which is lost or brings nothing new: nobody knows where the belt is",
                   "when the link is back: polyarm control resume",
                   Severity::warning,
                   {{"link", source->link}, {"reason", reason}}};
  }
  return std::nullopt;
}
}  // namespace

void Programs::tick_belts_and_streams() {
  if (streams_) streams_->tick(machine_.now());
  if (moves_ && force_) {
    if (!leads()) moves_->end_compliance();
    moves_->tick_compliance(*force_);
    force_->tick([this](const std::string& robot) { return moves_->stands(robot); });
  }
  if (!belts_) return;
  if (const auto lost = lost_encoder(setup_.file.belts, data_.links())) {
    // Without a tick the belts' travel gets old, and robots that follow them come to rest.
    const bool runs = machine_.snapshot().state == control::RunState::running &&
                      machine_.supervisor().latch().requested() == realtime::StopKind::none;
    if (!leads() && moves_) {  // nobody waits for the link: robots that followed the belt are free again
      moves_->end_rides();
      moves_->tick_rides();
    }
    if (!under_way() || !runs) return;
    observer_.on_problem(machine_.now(), *lost);
    machine_.hold_for(*lost);
    return;
  }
  belts_->tick();
  if (!moves_) return;
  if (!leads()) moves_->end_rides();
  moves_->tick_rides();
}

bool Programs::hears_devices() const {
  const bool open = !setup_.options.lock_step || setup_.options.links;
  const std::vector<signals::Tag>& tags = data_.signals().tags;
  const auto reads = [](const signals::Tag& tag) { return tag.role == data::TagRole::state; };
  const bool inputs = std::any_of(tags.begin(), tags.end(), reads);
  return (streams_ && open) || ((belts_ || inputs) && setup_.options.real);
}

namespace {
/// True if the program ends in this tick, or its `on stop` block has not ended.
bool ends(const Task& program) {
  return program.interpreter().ending() &&
         (!program.ended() || program.interpreter().state() == program::TaskState::stopped);
}
}  // namespace

void Programs::tick_program() {
  // Robots that still move stop on their paths; the `on stop` block runs when they stand.
  const auto stop_robots = [&] {
    if (ends(*program_)) motions_.end();
  };
  if (!safe_points_) {
    program_->tick();
    return stop_robots();
  }
  if (held_parts_->changed(machine_.snapshot()))
    safe_points_->set_held(held_parts_->names(machine_.snapshot()));
  // A program that goes on behind comply() would press with a stiff tool.
  const auto look = [&] {
    safe_points_->tick(machine_.now(), *program_, plc_.get(), data_.store, !moves_ || !moves_->yields());
  };
  program_->tick(look);
  look();
  stop_robots();
}

}  // namespace polyarm::cell
