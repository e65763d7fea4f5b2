#include "polyarm/cell/cell.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/cell/build.hpp"
#include "polyarm/cell/program_tests.hpp"
#include "polyarm/controllers/types.hpp"
#include "polyarm/description/scene_file.hpp"
#include "polyarm/program/parser.hpp"
#include "polyarm/realtime/refusals.hpp"

namespace polyarm::cell {

namespace {
/// A run in which nothing can happen any more is given this long, in cell time, before it is called a
/// deadlock.
constexpr Nanoseconds kDeadlockPatience = 2'000'000'000;
/// Parts that were let go of are given this long to come to rest after the program has ended.
constexpr Nanoseconds kSettlePatience = 2'000'000'000;
/// A cell that only sends messages ends when nothing has moved for this long.
constexpr Nanoseconds kSendSettle = 500'000'000;
}  // namespace

Cell::Cell(const CellFile& file, const description::Catalogue& catalogue, CellOptions options,
           Observer& observer)
    : file_(file),
      options_(std::move(options)),
      observer_(observer),
      calls_(options_.lock_step, observer),
      catalogue_(catalogue) {
  Problems problems;
  std::vector<std::string> notes = file_.notes;
  load_plugins(file_, problems);
  robots_ = resolve_robots(file_, catalogue, options_.real, problems, notes);
  for (const std::string& note : notes) observer_.on_note(note);
  collect(problems, [&] {
    if (!file_.scene.empty()) scene_ = description::read_scene((file_.folder / file_.scene).string());
  });
  parts_ = PartTracker(scene_);
  problems.throw_if_errors();

  ManagerParameters manager;
  collect(problems, [&] {
    Problems later;  // told again where the controllers are made
    manager = read_cell_controllers(file_, later).manager;
  });
  const double rate = rate_of(file_, problems);
  control::LoopOptions loop;
  loop.period = static_cast<Nanoseconds>(std::llround(1e9 / rate));
  loop.limits = manager.enforce_command_limits;
  loop.measure_parts = !options_.lock_step;
  loop.overrun = file_.loop.overrun;
  loop.overrun_after = file_.loop.overrun_after;
  loop.black_box_rows = static_cast<std::size_t>(10 * rate);
  loop_ = std::make_unique<control::ControlLoop>(loop);
  loop_->supervisor().watch_cell = !options_.lock_step;
  add_components(loop_->hardware(), robots_, scene_, loop.period, options_.lock_step, manager, problems);
  problems.throw_if_errors();
  start_hardware();
  for (const std::string& summary : loop_->hardware().summaries()) observer_.on_note(summary);
  arming_ = std::make_unique<Arming>(*loop_, robots_, options_.full_speed, observer_);
  jogging_ = std::make_unique<Jogging>(*this);
  set_profile(file_.profiles.name);

  requests_ = std::make_unique<Requests>(*this);
  worker_ = std::make_unique<Worker>(options_.lock_step);
  planner_ = std::make_unique<Worker>(options_.lock_step);
  for (const std::string& answer : options_.answers) answers_.give(answer);
  build_tags(problems);
  collect(problems, [&] { build_controllers(problems); });
  for (const auto& [name, value] : options_.faults)
    collect(problems, [&, n = name, v = value] { loop_->hardware().force(n, v); });
  std::vector<controllers::JointFacts> joints;
  for (const auto& robot : robots_) joints.insert(joints.end(), robot->joints.begin(), robot->joints.end());
  loop_->prepare(joints);
  Problems told;  // with the hardware
  for (const auto& robot : robots_)
    loop_->limits().set_turns(robot->entry.name + "/", divisor_of(*robot, loop_->options().period, told));
  offer_named_states();
  collect(problems, [&] { build_programs(problems); });
  problems.throw_if_errors();
  for (const Problem& problem : problems.list()) observer_.on_problem(0, problem);
  told_version_ = store_.version();
}

Cell::~Cell() {
  if (loop_) shut_hardware_down(options_.hardware_patience);
}

void Cell::start_hardware() {
  constexpr Nanoseconds kShort = 1'000'000'000;  // who has asked for the end waits no longer
  calls_.give_up_when(options_.start_given_up);
  try {
    loop_->start_hardware(calls_);
  } catch (...) {
    const bool asked = options_.start_given_up && options_.start_given_up();
    calls_.give_up_when({});
    shut_hardware_down(asked ? std::min(kShort, options_.hardware_patience) : options_.hardware_patience);
    throw;
  }
  calls_.give_up_when({});
}

/// False: a component is still in a call, and knows its robots; they stay until the process ends.
bool Cell::shut_hardware_down(Nanoseconds patience) {
  calls_.give_up_after(patience);
  if (loop_->hardware().shut_down(calls_)) return true;
  static auto* left = new std::vector<CellRobots>;
  left->push_back(std::move(robots_));
  for (CellRobots& robots : reloaded_) left->push_back(std::move(robots));
  return false;
}

namespace {
/// The inside boxes of the cell's workspace: what a pose from outside may be where nobody says more.
signals::PoseRange range_of(const std::vector<motion::WorkspaceZone>& workspace) {
  signals::PoseRange out;
  for (const motion::WorkspaceZone& zone : workspace) {
    if (zone.kind != motion::ZoneKind::inside) continue;
    const double a[] = {zone.low.x, zone.low.y, zone.low.z}, b[] = {zone.high.x, zone.high.y, zone.high.z};
    for (std::size_t k = 0; k < 3; ++k) {
      out.lower[k] = std::max(out.lower[k], std::min(a[k], b[k]));
      out.upper[k] = std::min(out.upper[k], std::max(a[k], b[k]));
    }
  }
  return out;
}

/// Poses from outside keep to the range of their point, else to the workspace: in files and over links.
void bound_poses(signals::Signals& signals, const std::vector<motion::WorkspaceZone>& zones,
                 DataFiles& files) {
  const signals::PoseRange workspace = range_of(zones), wide;
  const auto range = [workspace, points = signals.points](const std::string& name) {
    const auto stated = points.find(name);
    return stated == points.end() ? workspace : stated->second;
  };
  files.check_poses([range](const std::string& name, const Pose& pose) { return range(name).refuses(pose); });
  for (signals::LinkEntry& link : signals.links)
    for (signals::LinkTag& tag : link.tags)
      if (tag.within.lower == wide.lower && tag.within.upper == wide.upper) tag.within = range(tag.name);
}
}  // namespace

void Cell::build_tags(Problems& problems) {
  pass_state_ = states_.add("program/pass");
  running_state_ = states_.add("program/running");
  line_state_ = states_.add("program/line");
  held_state_ = states_.add("cell/held");
  fault_state_ = states_.add("cell/fault");
  for (const auto& robot : robots_)
    tcp_states_.push_back({states_.add(robot->entry.name + "/tcp/x"),
                           states_.add(robot->entry.name + "/tcp/y"),
                           states_.add(robot->entry.name + "/tcp/z")});
  collect(problems, [&] {
    if (!file_.signals.empty()) signals_ = signals::load_signals((file_.folder / file_.signals).string());
  });
  const signals::Signals& signals = signals_;
  std::set<std::string> live(signals.live.begin(), signals.live.end());
  if (options_.test) live.clear();  // a test writes to no file of the user's
  files_ = std::make_unique<DataFiles>(store_,
                                       StateFolder(file_.folder, live, options_.keep, options_.state_folder),
                                       *worker_, options_.lock_step);
  bound_poses(signals_, file_.workspace, *files_);
  for (const signals::LinkEntry& link : signals.links) {  // before the tags that are bound to them
    states_.add("link/" + link.name + "/up");
    states_.add("link/" + link.name + "/losses");
  }
  tags_ = std::make_unique<TagBinding>(signals.tags, loop_->table(), states_, store_, problems);
  for (const signals::CameraLink& link : signals.cameras) {
    if (!link.on.empty() && std::none_of(robots_.begin(), robots_.end(),
                                         [&](const auto& robot) { return robot->entry.name == link.on; }))
      problems.error("unknown-robot", link.where,
                     "the cell has no robot '" + link.on + "' to carry the camera");
    cameras_.emplace_back(Camera::Setup{link.camera, link.point, link.request, link.done, link.noise,
                                        link.seed, link.on, link.mount, link.view, link.reach},
                          scene_);
  }
}

void Cell::build_controllers(Problems& problems) {
  ControllerPlan plan = plan_controllers(file_, robots_, *loop_, tags_->command_names(), options_.lock_step,
                                         observer_, problems);
  wanted_controllers_ = cell::wanted_controllers(plan, file_);
  start_controllers(std::move(plan), file_, *loop_, observer_, problems);
  if (auto* io = loop_->controllers().find(kIoController))
    tags_->connect(dynamic_cast<controllers::ForwardCommandController*>(io));
  for (const auto& robot : robots_) {
    controllers::JointTrajectoryController* follower =
        trajectory_controller_of(*robot, loop_->controllers(), !arming_->armed());
    trajectory_controllers_.push_back(follower);
    motions_.push_back(follower ? std::make_unique<motion::RobotMotion>(
                                      *robot->facts, *follower,
                                      [this](std::function<void()> job) { planner_->post(std::move(job)); })
                                : nullptr);
    if (motions_.back()) motions_.back()->set_planned(robot->start);
    controllers::DiffDriveController* wheels = base_controller_of(*robot, loop_->controllers());
    bases_.push_back(wheels ? std::make_unique<motion::BaseMotion>(*wheels, seconds(loop_->options().period))
                            : nullptr);
  }
}

/// The named states of descriptions (SRDF, catalogue) are points that a program may move to; names from its
/// data files go before them. In a cell of several robots the robot's name stands before the state's.
void Cell::offer_named_states() {
  for (const auto& robot : robots_)
    for (const auto& [state, positions] : robot->model.named_states)
      store_.set(robots_.size() == 1 ? state : robot->entry.name + "_" + state,
                 data::JointState{robot->model.joint_names(), positions}, robot->entry.name);
}

std::shared_ptr<const Remaking> Cell::remake(const std::string& name) {
  auto out = std::make_shared<Remaking>();
  out->name = name;
  worker_->post([out, file = file_, catalogue = catalogue_, real = options_.real, &scene = scene_,
                 period = loop_->options().period] {
    try {
      out->made = make_again(out->name, file, catalogue, real, scene, period);
    } catch (...) {
      out->failed = std::current_exception();
    }
    out->done.store(true, std::memory_order_release);
  });
  return out;
}

std::shared_ptr<hardware::Transition> Cell::begin_reload(const Remaking& remade) {
  if (remade.failed) std::rethrow_exception(remade.failed);
  reloaded_.push_back(std::move(remade.made.robots));
  hardware::Hardware& hardware = loop_->hardware();
  return hardware.begin_replace(static_cast<std::size_t>(hardware.find(remade.name)),
                                std::move(remade.made.component), remade.made.context);
}

void Cell::build_programs(Problems& problems) {
  ProgramHost::Context context;
  context.store = &store_;
  context.files = files_.get();
  context.answers = &answers_;
  context.observer = &observer_;
  context.now = &now_;
  Programs programs = load_programs(file_, *files_, store_, problems, [&] {
    links_ = std::make_unique<CellLinks>(signals_, states_, store_, options_.lock_step,
                                         options_.lock_step && !options_.links, problems);
    heartbeats_ = std::make_unique<Heartbeats>(signals_, store_, problems);
  });
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
  const auto there = [](const auto& motion) { return motion != nullptr; };
  if (std::none_of(motions_.begin(), motions_.end(), there) &&
      std::none_of(bases_.begin(), bases_.end(), there))
    problems.error("no-motion", file_.program_where,
                   "the program needs a robot whose joints a trajectory controller moves",
                   "give the cell a robot, and leave 'controllers' out or name a "
                   "joint_trajectory_controller for all joints");
  if (test_) {
    ready_program_ = std::move(programs.program);
  } else {
    start_program(std::move(*programs.program));
  }
}

void Cell::start_program(program::Program program) {
  std::vector<ProgramMoves::Robot> robots;
  for (std::size_t i = 0; i < robots_.size(); ++i)
    robots.push_back({robots_[i].get(), motions_[i].get(), bases_[i].get()});
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
  ended_at_ = -1;
  finished_ = false;
  if (!options_.test && options_.state_folder.empty())
    safe_points_ =
        std::make_unique<SafePoints>(file_.folder / ".state" / "program.json", *worker_, options_.lock_step);
}

bool Cell::all_idle() const {
  for (std::size_t i = 0; i < robots_.size(); ++i)
    if (!idle(i)) return false;
  return true;
}

program::StartReport Cell::prepare_program(const std::string& name, int line) {
  if (program_ && !program_->ended()) {  // its `on stop` is done: the robots stand
    program_->interpreter().stop();
    program_->tick();
  }
  std::unique_ptr<Task> before = std::exchange(program_, nullptr);
  std::unique_ptr<ProgramMoves> moves = std::move(moves_);
  try {
    begin_program(name, {});
    program::StartReport report = program_->interpreter().start_at(line);
    program_->interpreter().pause_here();
    program_->refresh();
    return report;
  } catch (const Error&) {  // the one before stays as it was, at its end
    program_ = std::move(before);
    moves_ = std::move(moves);
    throw;
  }
}

program::StartReport Cell::continue_program() {
  const SafePoint point = SafePoints::read(file_.folder / ".state" / "program.json");
  if (!program_) throw Error("no-program", "the cell has no program");
  program::StartReport report = program_->interpreter().restore(point.state);
  for (const auto& [name, value] : point.values)
    if (store_.find(name) && !store_.is_tag(name)) store_.set(name, value, "continue");
  program_->refresh();
  return report;
}

void Cell::keep_safe_point() {
  if (program_ && safe_points_) safe_points_->finish(*program_);
}

void Cell::begin_program(const std::string& name, const Location& where) {
  if (program_ && !program_->ended())
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

Pose Cell::tcp(std::size_t robot) const {
  const CellRobot& r = *robots_[robot];
  std::array<double, 64> q{};
  const control::Snapshot& snapshot = loop_->outbox().value();
  for (std::size_t j = 0; j < r.joints.size() && j < q.size(); ++j) {
    const auto index = loop_->table().find_state(r.joints[j].name + "/position");
    q[j] = index ? snapshot.states[*index] : 0;
  }
  return r.facts->chain.forward({q.data(), r.joints.size()});
}

/// The flange that carries the camera, in the world.
Pose Cell::carrier_of(const Camera& camera) const {
  for (std::size_t i = 0; i < robots_.size(); ++i)
    if (robots_[i]->entry.name == camera.setup().robot) return tcp(i) * inverse(robots_[i]->tool.tcp);
  return {};
}

void Cell::update_states(const control::Snapshot& snapshot) {
  const bool running = program_ && !program_->ended();
  states_.set(pass_state_, program_ ? static_cast<double>(program_->status().passes + (running ? 1 : 0)) : 0);
  states_.set(running_state_, running ? 1 : 0);
  states_.set(line_state_, running ? program_->status().where.line : 0);
  states_.set(held_state_, snapshot.state == control::RunState::held ? 1 : 0);
  states_.set(fault_state_, snapshot.state == control::RunState::fault ? 1 : 0);
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    const Pose at = tcp(i);
    states_.set(tcp_states_[i][0], at.position.x);
    states_.set(tcp_states_[i][1], at.position.y);
    states_.set(tcp_states_[i][2], at.position.z);
  }
}

/// Where somebody else moved a robot to is where its next move begins.
void Cell::follow_strangers(const control::Snapshot& snapshot) {
  if (!snapshot.standing) return;
  for (std::size_t i = 0; i < motions_.size(); ++i) {
    if (!motions_[i] || !motions_[i]->idle()) continue;
    std::vector<double> at = motions_[i]->planned();
    for (std::size_t j = 0; j < at.size(); ++j)
      if (const auto index = loop_->table().find_command(robots_[i]->joints[j].name + "/position"))
        if (std::isfinite(snapshot.commands[*index])) at[j] = snapshot.commands[*index];
    motions_[i]->set_planned(at);
  }
}

void Cell::tell_loop_events() {
  using Kind = control::LoopEvent::Kind;
  control::ControllerManager& manager = loop_->controllers();
  for (const control::LoopEvent& event : manager.take_events()) {
    const bool hardware = event.kind == Kind::component_failed || event.kind == Kind::component_deactivated;
    const auto who = static_cast<std::size_t>(event.who);
    const std::string name = hardware ? loop_->hardware().component_name(who) : manager.name_of(event.who);
    constexpr const char* kTexts[] = {
        "the controller {} failed and is inactive, with all that works through it",
        "the controller {} was stopped with what it works on",
        "the controller {} took over",
        "the hardware component {} failed",
        "the hardware component {} asked to be deactivated",
        "nothing new comes for the controller {}: what it was sent last has ended"};
    std::string text = fmt::format(fmt::runtime(kTexts[static_cast<std::size_t>(event.kind)]), name);
    if (const std::string reason = hardware ? loop_->hardware().reason(who) : ""; !reason.empty())
      text += ": " + reason;
    observer_.on_note(text);
    if (hardware || event.kind == Kind::controller_failed) falling_ = hardware ? name : "";
    if (event.kind == Kind::controller_stopped && !falling_.empty()) fallen_[falling_].push_back(name);
    if (event.kind == Kind::component_failed) calls_.post(who, hardware::Step::error);
    if (event.kind == Kind::component_deactivated) calls_.post(who, hardware::Step::deactivate);
  }
  calls_.tick(loop_->hardware(), now_);
}

namespace {
/// 1, 10, 100, …: told at once, and then not a thousand times a second.
bool is_worth_telling(std::uint64_t count) {
  while (count % 10 == 0) count /= 10;
  return count == 1;
}
}  // namespace

void Cell::tell_overruns() {
  const auto tell = [this](const std::string& name, const realtime::Overrun& overrun, const char* advice) {
    const std::uint64_t count = ++overruns_[{name, overrun.callback}];
    if (!is_worth_telling(count)) return;
    observer_.on_note(fmt::format("{}: {} took {:.3f} ms in cycle {}, its budget is {:.3f} ms{} ({})", name,
                                  overrun.callback, static_cast<double>(overrun.took) * 1e-6, overrun.cycle,
                                  static_cast<double>(overrun.budget) * 1e-6,
                                  count == 1 ? "" : fmt::format("; {} times now", count), advice));
  };
  realtime::Overrun overrun;
  while (loop_->hardware().take_overrun(overrun))
    tell(loop_->hardware().component_name(static_cast<std::size_t>(overrun.who)), overrun,
         "is_async=\"true\" of its <ros2_control> gives it a thread of its own");
  while (loop_->controllers().take_overrun(overrun))
    tell(loop_->controllers().name_of(overrun.who), overrun, "is_async: true gives it a thread of its own");
}

/// What the machine refused a component's thread, and that it is late: once.
void Cell::tell_threads() {
  hardware::Hardware& hardware = loop_->hardware();
  told_threads_.resize(hardware.size());
  for (std::int32_t who = 0; hardware.take_late(who);) {
    const auto i = static_cast<std::size_t>(who);
    const realtime::ThreadHealth& health = *hardware.thread_health(i);
    constexpr const char* kThen[] = {"it goes on", "the loop stops on the path and holds", "it is taken off"};
    observer_.on_note(
        fmt::format("the thread of {} is late: {} runs were, and {} missed their turn; {} "
                    "('overrun' of its thread); polyarm health shows its times",
                    hardware.component_name(i), std::uint64_t{health.late}, std::uint64_t{health.missed},
                    kThen[static_cast<std::size_t>(hardware.when_late(i))]));
  }
  for (std::size_t i = 0; i < hardware.size(); ++i) {
    const realtime::ThreadHealth* health = hardware.thread_health(i);
    const unsigned refused = health ? health->refused.load(std::memory_order_acquire) : 0;
    if (refused == 0 || std::exchange(told_threads_[i], 1)) continue;
    for (const std::string& text : realtime::refusals(refused, hardware.thread_options(i),
                                                      "the thread of " + hardware.component_name(i)))
      observer_.on_note(text);
  }
}

const std::vector<controllers::GoalEvent>& Cell::goal_events(const std::string& name) {
  constexpr std::size_t kKept = 1000;
  std::vector<controllers::GoalEvent>& out = goal_events_[name];
  controllers::Controller* const controller = loop_->controllers().find(name);
  try {
    while (const auto event = controller ? controller->next_goal_event() : std::nullopt)
      out.push_back(*event);
  } catch (...) {
    observer_.on_note(name + ": asked what became of its goals it threw: " + what_was_thrown());
  }
  if (out.size() > 2 * kKept) out.erase(out.begin(), out.end() - kKept);
  return out;
}

std::vector<std::string> Cell::take_fallen(const std::string& component) {
  return std::exchange(fallen_[component], {});
}

Problems Cell::load_controller(const std::string& name, const std::string& type,
                               controllers::Parameters parameters, const std::string& file) {
  Problems problems, found;
  Observer nobody;
  CellFile source = file_;
  if (!file.empty()) {
    source.controllers = {file};
    source.launched = nullptr;
  }
  ControllerPlan plan = plan_controllers(source, robots_, *loop_, {}, options_.lock_step, nobody, problems);
  std::vector<std::string> known;
  for (PlannedController& planned : plan.controllers) {
    known.push_back(planned.context.name);
    if (type.empty() ? planned.context.name != name : &planned != &plan.controllers.front()) continue;
    if (!type.empty()) {
      planned.context.name = name;
      planned.context.type = type;
      planned.context.parameters = std::move(parameters);
      planned.controller = controllers::make_controller(type, planned.context.parameters);
      planned.options = {};
      planned.options.lock_step = options_.lock_step;
    } else {
      for (auto& [key, entry] : parameters.entries)
        planned.context.parameters.entries[key] = std::move(entry);
    }
    control::ControllerManager& manager = loop_->controllers();
    manager.load(std::move(planned.controller), std::move(planned.context), std::move(planned.options));
    goal_events_.erase(name);  // of another that had this name
    try {
      manager.configure(name);
    } catch (const Error&) {
      manager.unload(name);
      throw;
    }
    for (const Problem& problem : manager.findings(name)) found.add(problem);
    return found;
  }
  problems.throw_if_errors();
  throw Error("unknown-controller",
              "no controllers file describes '" + name + "'" + did_you_mean(name, known),
              "say its type, or put it into the controllers file");
}

void Cell::unload_controller(const std::string& name) {
  const controllers::Controller* leaving = loop_->controllers().find(name);
  const bool program_runs = program_ && !program_->ended();
  const auto in_use = [&](const std::string& by) {
    throw Error("in-use", "the controller '" + name + "' cannot be unloaded: " + by + " works through it");
  };
  if (leaving && name == kIoController) in_use("the cell's tags");
  for (std::size_t i = 0; leaving && i < trajectory_controllers_.size(); ++i)
    if (trajectory_controllers_[i] == leaving && program_runs) in_use("the program");
  const auto led = [&](const auto& base) { return base && &base->controller() == leaving; };
  const auto base = std::find_if(bases_.begin(), bases_.end(), led);
  if (leaving && base != bases_.end() && program_runs) in_use("the program");
  loop_->controllers().unload(name);
  goal_events_.erase(name);
  if (leaving && base != bases_.end()) {
    if (moves_) moves_->forget(**base);
    base->reset();
  }
  for (std::size_t i = 0; i < trajectory_controllers_.size(); ++i)
    if (trajectory_controllers_[i] == leaving) {
      trajectory_controllers_[i] = nullptr;
      if (moves_) moves_->forget(*motions_[i]);
      motions_[i].reset();
    }
}

/// Messages that the cell file sends when the cell starts.
void Cell::send_start_messages() {
  started_ = true;
  for (const auto& [to, path] : file_.send) {
    try {
      const std::filesystem::path file = file_.folder / path;
      nlohmann::json request{{"request", "send"}, {"to", to}, {"message", read_file(file)}};
      requests_->handle(request.dump(), [this, file](const std::string& line) {
        const auto answer = nlohmann::json::parse(line, nullptr, false);
        if (answer.value("ok", false)) return true;
        fail(now_, {"not-sent",
                    {file.string()},
                    answer["error"].value("what", line),
                    answer["error"].value("advice", "")});
        return false;
      });
    } catch (const Error& e) {
      fail(now_, e.problems().front());
    }
  }
}

void Cell::tick(Nanoseconds now) {
  now_ = now;
  store_.set_now(now);
  loop_->outbox().fetch();
  loop_->supervisor().heartbeat(now);
  const control::Snapshot& snapshot = loop_->outbox().value();
  tell_loop_events();
  tell_overruns();
  tell_threads();
  if (!started_ && arming_->armed()) send_start_messages();
  watch_stops(now, snapshot);
  requests_->tick();
  follow_strangers(snapshot);
  update_states(snapshot);
  links_->read(now);
  tags_->read(snapshot.states, states_);
  heartbeats_->tick(now, snapshot.cycle.index, store_);
  for (Camera& camera : cameras_) camera.tick(snapshot.world, store_, carrier_of(camera));
  jogging_->tick(now);
  if (arming_->needed() || arming_->reduced()) {
    std::vector<Vec3> tcps;
    for (std::size_t i = 0; i < robots_.size(); ++i) tcps.push_back(tcp(i).position);
    arming_->govern(now, tcps, snapshot.commands,
                    program_ && (program_->ended() || program_->status().passes > 0), moves_as_planned_now());
  }
  watch_links(now, snapshot);
  const bool may_run = !failure_ && arming_->armed() && links_ready_;
  tick_motions(now);
  if (may_run && plc_) plc_->tick();
  if (test_) test_->tick();
  if (may_run && program_ && snapshot.state == control::RunState::running && !jogging_->engaged())
    tick_program(now);
  tick_motions(now);
  write_outputs(now, snapshot);
  files_->exchange(now);
  for (const Problem& problem : files_->take_warnings()) observer_.on_problem(now, problem);
  parts_.update(now, snapshot.world);
  contacts_max_ = std::max(contacts_max_, snapshot.world.contacts);
  tracking_error_max_ = std::max(tracking_error_max_, snapshot.world.tracking_error);
  tell_changes(now);
  if (failure_) return;
  watch_contacts(now, snapshot);
  watch_for_deadlock(now, snapshot);
  watch_end(now);
}

/// A link or a sign of life that is missed holds the cell; who resumes it meanwhile is held again.
void Cell::watch_links(Nanoseconds now, const control::Snapshot& snapshot) {
  for (const Problem& problem : links_->take_news()) observer_.on_problem(now, problem);
  if (!links_ready_) {
    links_ready_ = links_->ready();
    if (!links_ready_ && now > 1'000'000'000 && !std::exchange(told_waiting_, true))
      for (const CellLinks::Status& link : links_->status())
        if (!link.state.was_up)
          observer_.on_note("the programs begin when the link '" + link.entry->name +
                            "' is there: " + link.state.reason);
  }
  const std::optional<std::string> lost = links_->lost();
  const std::optional<std::string>& why = lost ? lost : heartbeats_->stopped();
  missed_ = why.has_value();
  const bool works = (program_ && !program_->ended()) || jogging_->engaged();
  if (!missed_ || !works || snapshot.state != control::RunState::running) return;
  if (loop_->supervisor().latch().requested() != realtime::StopKind::none) return;
  observer_.on_problem(now, {"held", program_ ? program_->status().where : Location{}, *why,
                             "mend it, then polyarm control resume", Severity::warning});
  loop_->supervisor().latch().request(realtime::StopKind::controlled);
}

/// Tags to interfaces and links, or what their rules say.
void Cell::write_outputs(Nanoseconds now, const control::Snapshot& snapshot) {
  const bool over = failure_ || (program_ ? program_->ended() : plc_ && plc_->ended());
  signals::Situation situation;
  situation.stopped = over && snapshot.standing;
  situation.held = snapshot.state == control::RunState::held || snapshot.state == control::RunState::fault;
  situation.link_lost = missed_ || links_->any_down();
  tags_->write(situation);
  links_->write(situation);
  if (!situation.stopped) stopped_at_ = -1;
  if (situation.stopped && stopped_at_ < 0) stopped_at_ = now;
}

bool Cell::outputs_settled() const {
  constexpr Nanoseconds kHardware = 3 * kTick, kFarSide = 500'000'000;
  const bool ruled = std::any_of(signals_.tags.begin(), signals_.tags.end(),
                                 [](const signals::Tag& tag) { return tag.rules.on_stop.has_value(); });
  if (stopped_at_ < 0 || (!ruled && !links_->any())) return true;
  return now_ - stopped_at_ > kHardware && (links_->idle() || now_ - stopped_at_ > kFarSide);
}

void Cell::tick_program(Nanoseconds now) {
  if (!safe_points_) return program_->tick();
  const auto look = [&] { safe_points_->tick(now, *program_, store_); };
  program_->tick(look);
  look();
}

/// Before the programs, for what has arrived; after them, for what they want next.
void Cell::tick_motions(Nanoseconds now) {
  const control::Supervisor& supervisor = loop_->supervisor();
  for (const auto& base : bases_)
    if (base && !failure_)
      base->tick(now, snapshot().state == control::RunState::running,
                 supervisor.share() * supervisor.override_share());
  for (const auto& motion : motions_) {
    if (!motion || failure_) continue;
    motion->set_options(plan_options());
    motion->tick(now);
    for (motion::RobotMotion::Warning& warning : motion->take_warnings()) {
      if (moves_ && warning.problem.where.file.empty())
        warning.problem.where = moves_->place_of(*motion, warning.move);
      if (told_warnings_.insert(warning.problem.text()).second) observer_.on_problem(now, warning.problem);
    }
  }
}

void Cell::set_profile(const std::string& name) {
  const std::vector<std::string> known = {"reduced", "full"};
  if (std::find(known.begin(), known.end(), name) == known.end())
    throw Error("unknown-profile", "there is no limits profile '" + name + "'" + did_you_mean(name, known),
                "reduced or full");
  const ProfileEntry& profile = name == "reduced" ? file_.profiles.reduced : file_.profiles.full;
  profile_ = name;
  const bool slower = profile.tcp_speed < kNoTcpLimit || profile.joint_speed < 1;
  arming_->set_profile(slower, profile.tcp_speed, profile.joint_speed);
}

motion::JogLimits Cell::jog_limits() const {
  const ProfileEntry& profile = profile_ == "reduced" ? file_.profiles.reduced : file_.profiles.full;
  motion::JogLimits out{profile.joint_speed, profile.tcp_speed, profile.tcp_turning};
  if (!arming_->first_pass()) return out;
  out.joint_share = std::min(out.joint_share, kReducedProfile.joint_speed);
  out.tcp_speed = std::min(out.tcp_speed, kReducedProfile.tcp_speed);
  out.tcp_turning = std::min(out.tcp_turning, kReducedProfile.tcp_turning);
  return out;
}

void Cell::drop_bases() {
  for (const auto& base : bases_)
    if (base) base->drop();
}

motion::MovePlanOptions Cell::plan_options() const {
  if (arming_->first_pass()) return {};
  const ProfileEntry& profile = profile_ == "reduced" ? file_.profiles.reduced : file_.profiles.full;
  return {profile.tcp_speed < kNoTcpLimit ? profile.tcp_speed : 0, profile.joint_speed};
}

/// Do planned moves, and at least one, go as the profile wants them planned now?
bool Cell::moves_as_planned_now() const {
  if (arming_->first_pass()) return false;
  bool any = false;
  for (const auto& motion : motions_) {
    const motion::MovePlanOptions* with = motion ? motion->options_under_way() : nullptr;
    if (with && *with != plan_options()) return false;
    any = any || with;
  }
  return any;
}

const char* Cell::control_holder() const {
  if (jogging_->engaged()) return "jog";
  return program_ && !program_->ended() ? "program" : "nobody";
}

void Cell::tell_changes(Nanoseconds now) {
  if (store_.version() == told_version_) return;
  for (const data::Change& change : store_.changes_since(told_version_))
    if (change.now && change.old && change.who != "state")
      observer_.on_tag(now, change.name, change.now->text(), change.who);
  told_version_ = store_.version();
}

void Cell::fail(Nanoseconds now, Problem problem) {
  if (failure_) return;
  observer_.on_problem(now, problem);
  failure_ = Failure{std::move(problem), now};
  for (const auto& motion : motions_)
    if (motion) motion->drop();
  drop_bases();
  loop_->supervisor().latch().request(realtime::StopKind::controlled);
}

void Cell::watch_contacts(Nanoseconds now, const control::Snapshot& snapshot) {
  const hardware::WorldState& world = snapshot.world;
  const auto& names = loop_->hardware().world_names();
  for (; findings_seen_ < world.finding_count; ++findings_seen_) {
    if (findings_seen_ >= hardware::WorldState::kMaxFindings) continue;
    const hardware::Contact& contact = world.findings[static_cast<std::size_t>(findings_seen_)];
    const auto called = [&](int id) {
      return id >= 0 && id < static_cast<int>(names.size()) ? names[static_cast<std::size_t>(id)]
                                                            : "something";
    };
    Problem problem{"contact", program_ ? program_->status().where : Location{},
                    fmt::format("{} touched {} at {:.3f} s, {:.2f} mm deep", called(contact.a),
                                called(contact.b), seconds(contact.time), 1e3 * contact.depth),
                    "move the points or the obstacle, or run with --allow-contact"};
    if (options_.allow_contact) {
      problem.severity = Severity::warning;
      observer_.on_problem(now, problem);
    } else {
      fail(now, std::move(problem));
    }
  }
  watch_faults(now, snapshot);
  watch_groups(now, snapshot);
  if (const auto note = recorder_.tick(now, *loop_, *worker_)) observer_.on_note(*note);
}

void Cell::set_armed() {
  arming_->set_armed(now_);
  for (std::size_t i = 0; i < motions_.size(); ++i) {  // moves begin where the robot is
    if (!motions_[i]) continue;
    std::vector<double> at = motions_[i]->planned();
    for (std::size_t j = 0; j < at.size(); ++j)
      if (const auto index = loop_->table().find_state(robots_[i]->joints[j].name + "/position"))
        if (std::isfinite(snapshot().states[*index])) at[j] = snapshot().states[*index];
    motions_[i]->set_planned(at);
  }
}

/// A fault ends what works towards an end; a cell that waits for others is brought back by them.
void Cell::watch_faults(Nanoseconds now, const control::Snapshot& snapshot) {
  const bool fault = snapshot.state == control::RunState::fault;
  const bool news = fault && !std::exchange(in_fault_, fault);
  in_fault_ = fault;
  if (!news) return;
  using Cause = control::StopCause;
  const bool of_hardware = snapshot.cause == Cause::component || snapshot.cause == Cause::not_a_number ||
                           snapshot.cause == Cause::jump || snapshot.cause == Cause::not_following ||
                           snapshot.cause == Cause::late;
  std::string who;
  if (of_hardware && snapshot.culprit >= 0) {
    const auto component = static_cast<std::size_t>(snapshot.culprit);
    const std::string reason = loop_->hardware().reason(component);
    who = " (" + loop_->hardware().component_name(component) + (reason.empty() ? "" : ": " + reason) + ")";
  } else if (snapshot.cause == Cause::limits && snapshot.culprit >= 0) {
    who = " (" + loop_->table().command_names()[static_cast<std::size_t>(snapshot.culprit)] + ")";
  } else if (snapshot.cause == Cause::controller && snapshot.culprit >= 0) {
    who = " (" + loop_->controllers().name_of(snapshot.culprit) + ")";
  }
  Problem problem{"fault", {}, std::string(control::name(snapshot.cause)) + who, {}};
  const bool waits = waits_for_others();
  problem.advice = !waits ? "see the recorded cycles of this run"
                   : snapshot.cause == Cause::limits
                       ? "polyarm control recover and resume; it may then be moved inwards only"
                       : "polyarm hardware list and polyarm hardware recover";
  if (!waits) return fail(now, std::move(problem));
  observer_.on_problem(now, problem);
  recorder_.begin(begin_record(*this, problem), now);
}

/// A fault of a robot whose fault stops nothing else: the run goes on, and does not end well.
void Cell::watch_groups(Nanoseconds now, const control::Snapshot& snapshot) {
  hardware::Hardware& hardware = loop_->hardware();
  fallen_seen_.resize(snapshot.fallen.size());
  std::string told;  // what fell together is told once
  for (std::size_t i = 0; i < snapshot.fallen.size(); ++i) {
    const control::StopCause cause = snapshot.fallen[i];
    const bool news = std::exchange(fallen_seen_[i], cause) == control::StopCause::none &&
                      cause != control::StopCause::none;
    if (!news || !hardware.contained(i) || snapshot.state == control::RunState::fault) continue;
    if (std::exchange(told, hardware.group(i)) == hardware.group(i)) continue;
    const std::string reason = hardware.reason(i), name = hardware.component_name(i);
    Problem problem{
        "fault",
        {},
        fmt::format("{} ({}{}); only what works on {} has stopped", control::name(cause), name,
                    reason.empty() ? "" : ": " + reason, hardware.group(i)),
        "polyarm hardware recover " + name + ", then start its controllers: polyarm control switch -a NAME"};
    observer_.on_problem(now, problem);
    group_faults_.push_back(problem);
    if (waits_for_others()) recorder_.begin(begin_record(*this, problem), now);
  }
}

void Cell::watch_stops(Nanoseconds now, const control::Snapshot& snapshot) {
  constexpr std::size_t kKept = 1000;
  if (joint_places_.all().empty()) joint_places_ = JointPlaces(robots_, loop_->table());
  held_place_.tick(snapshot, joint_places_);
  const auto stop = stop_watch_.tick(snapshot, robots_, joint_places_);
  if (!stop) return;
  if (stops_.size() >= kKept) stops_.erase(stops_.begin());
  stops_.push_back(*stop);
  observer_.on_stop(now, *stop);
  recorder_.note_stop(stop->sentence());
}

void Cell::watch_for_deadlock(Nanoseconds now, const control::Snapshot& snapshot) {
  const auto stuck = [](const Task* task) {
    return !task || task->ended() ||
           (task->status().waiting.kind == program::WaitKind::condition && !task->status().waiting.until);
  };
  const bool quiet = !test_ && program_ && !program_->ended() && stuck(program_.get()) && stuck(plc_.get()) &&
                     snapshot.standing && snapshot.world.at_rest && !parts_.anything_moving() &&
                     snapshot.state == control::RunState::running && !files_->has_outside_writers() &&
                     !links_->any() && store_.version() == quiet_version_;
  quiet_version_ = store_.version();
  if (!quiet) quiet_since_ = now;
  if (now - quiet_since_ < kDeadlockPatience) return;
  std::string waiting = program_->sentence();
  if (plc_ && !plc_->ended()) waiting += "; " + plc_->sentence();
  fail(now, {"deadlock", program_->status().where,
             "every task waits, and no clock, link or motion can change what it waits for: " + waiting,
             "check who is to set these tags"});
}

void Cell::watch_end(Nanoseconds now) {
  for (Task* task : {program_.get(), plc_.get()})
    if (task && task->failed())
      fail(now, task->status().problem.value_or(
                    Problem{"failed", task->status().where, task->name() + " failed", {}}));
  if (const auto lost = files_->take_failure()) fail(now, lost->problems().front());
  if (failure_) return;
  if (!program_ && !file_.send.empty() && !started_) return;
  if (!program_ && !file_.send.empty()) {  // what was sent has been done
    if (!loop_->outbox().value().standing) ended_at_ = now;
    finished_ = ended_at_ >= 0 && loop_->outbox().value().standing && now - ended_at_ > kSendSettle;
    if (now - arming_->armed_at() > kSettlePatience && ended_at_ < 0) finished_ = true;
    return;
  }
  if (!program_ || !program_->ended()) return;
  if (ended_at_ < 0) ended_at_ = now;
  const bool settled = !parts_.anything_moving() && loop_->outbox().value().standing;
  finished_ = (settled || now - ended_at_ > kSettlePatience) && outputs_settled();
}

std::optional<std::uint64_t> Cell::first_motion_cycle() const {
  for (const controllers::JointTrajectoryController* follower : trajectory_controllers_)
    if (follower && follower->status().started_cycle.load() > 0)
      return follower->status().started_cycle.load() - 1;
  return std::nullopt;
}

void Cell::stop_programs() {
  for (Task* task : {program_.get(), plc_.get()})
    if (task) task->interpreter().stop();
}

}  // namespace polyarm::cell
