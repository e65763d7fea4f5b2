#include "polyarm/cell/cell.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/cell/bodies.hpp"
#include "polyarm/cell/build.hpp"
#include "polyarm/cell/cell_reach.hpp"
#include "polyarm/cell/controllers_plan.hpp"
#include "polyarm/cell/controllers_start.hpp"
#include "polyarm/cell/floor.hpp"
#include "polyarm/cell/program_tests.hpp"
#include "polyarm/controllers/types.hpp"
#include "polyarm/description/scene_file.hpp"
#include "polyarm/protocol/messages.hpp"
#include "polyarm/realtime/refusals.hpp"

namespace polyarm::cell {

Cell::Cell(const CellFile& file, const description::Catalogue& catalogue, CellOptions options,
           Observer& observer)
    : file_(file),
      options_(std::move(options)),
      calls_(options_.lock_step, observer_),
      catalogue_(catalogue) {
  observers_.add(observer);
  Problems problems;
  std::vector<std::string> notes = file_.notes;
  if (options_.no_code)
    look_at_plugins(file_, problems);
  else
    load_plugins(file_, problems);
  ros_files::ControllersFile described;
  collect(problems, [&] { described = read_cell_controllers(file_, problems); });
  robots_ = resolve_robots(file_, described.joint_limits, catalogue, options_.real, problems, notes);
  add_hardware_faults(robots_, Severity::error, problems);
  collect(problems, [&] {
    scene_ = file_.scene.empty()
                 ? scene_without_file(robots_, notes)
                 : description::read_scene(file_of_cell(file_, file_.scene, file_.scene_where), problems);
  });
  make_robot_bodies(robots_, problems);
  make_scene_bodies(robots_, scene_, problems);
  unchecked_bodies_ = cell::unchecked_bodies(robots_, scene_);
  for (const auto& more : {sentences(unchecked_bodies_), placeholder_notes(robots_)})
    notes.insert(notes.end(), more.begin(), more.end());
  for (const std::string& note : notes) observer_.on_note(note);
  parts_ = PartTracker(scene_);
  problems.throw_if_errors();

  manager_ = described.manager;
  const double rate = rate_of(file_, described);
  control::LoopOptions loop;
  loop.period = static_cast<Nanoseconds>(std::llround(1e9 / rate));
  loop.limits = manager_.enforce_command_limits;
  loop.measure_parts = !options_.lock_step;
  loop.overrun = file_.loop.overrun;
  loop.overrun_after = file_.loop.overrun_after;
  loop.stall_holds = file_.loop.stall_holds;
  loop.black_box_rows = static_cast<std::size_t>(10 * rate);
  loop_ = std::make_unique<control::ControlLoop>(loop);
  loop_->supervisor().set_contact_stop(options_.allow_contact ? control::ContactStop::none
                                                              : file_.contact_stop);
  add_components(loop_->hardware(), robots_, scene_, loop.period, options_.lock_step, manager_, problems);
  problems.throw_if_errors();
  loop_->supervisor().watch_cell = !options_.lock_step && loop_->holds_after_gap();
  start_hardware();
  for (const std::string& summary : loop_->hardware().diagnostics().summaries()) observer_.on_note(summary);
  arming_ = std::make_unique<Arming>(*loop_, robots_, options_.full_speed, observer_);
  jogging_ = std::make_unique<Jogging>(*this);
  set_profile(file_.profiles.name);

  requests_ = std::make_unique<Requests>(*this);
  worker_ = std::make_unique<Worker>(options_.lock_step);
  planner_ = std::make_unique<Worker>(options_.lock_step);
  for (const std::string& answer : options_.answers) answers_.give(answer);
  build_tags(problems);
  collect(problems, [&] { build_controllers(described, problems); });
  for (const auto& [name, value] : options_.faults)
    collect(problems, [&, n = name, v = value] { loop_->hardware().force(n, v); });
  std::vector<controllers::JointFacts> joints;
  for (const auto& robot : robots_) joints.insert(joints.end(), robot->joints.begin(), robot->joints.end());
  loop_->prepare(joints);
  joint_places_ = JointPlaces(robots_, loop_->table());
  Problems told;  // with the hardware
  for (const auto& robot : robots_)
    loop_->limits().set_turns(robot->entry.name + "/", divisor_of(*robot, loop_->options().period, told));
  offer_named_states();
  std::vector<std::string> names;
  for (const auto& robot : robots_) names.push_back(robot->entry.name);
  held_parts_ = std::make_unique<HeldParts>(std::move(names), scene_, loop_->table());
  collect(problems, [&] { build_programs(problems); });
  problems.throw_if_errors();
  for (const Problem& problem : problems.list()) observer_.on_problem(0, problem);
  told_version_ = store_.version();
}

Cell::~Cell() {
  recording_.reset();
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
signals::PoseRange range_of(const std::vector<moves::WorkspaceZone>& workspace) {
  signals::PoseRange out;
  for (const moves::WorkspaceZone& zone : workspace) {
    if (zone.kind != moves::ZoneKind::inside) continue;
    const double a[] = {zone.low.x, zone.low.y, zone.low.z}, b[] = {zone.high.x, zone.high.y, zone.high.z};
    for (std::size_t k = 0; k < 3; ++k) {
      out.lower[k] = std::max(out.lower[k], std::min(a[k], b[k]));
      out.upper[k] = std::min(out.upper[k], std::max(a[k], b[k]));
    }
  }
  return out;
}

/// Poses from outside keep to the range of their point, else to the workspace: in files and over links.
void bound_poses(signals::Signals& signals, const std::vector<moves::WorkspaceZone>& zones,
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

namespace {
/// How long a run waits for another one of the same folder, ms: batches come one after the other.
constexpr int kBatchPatience = 30'000, kLivePatience = 500, kNeverWaits = -1;

/// Robots without a cell have no folder of their own: any number of them run side by side.
int patience_of(const CellFile& file, bool lock_step) {
  const std::string kind = file.path.extension().string();
  const bool has_folder = (kind == ".yaml" || kind == ".yml") && !file.launched;
  return !has_folder ? kNeverWaits : lock_step ? kBatchPatience : kLivePatience;
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
    if (!file_.signals.empty())
      signals_ = signals::load_signals(file_of_cell(file_, file_.signals, file_.signals_where));
  });
  check_live(file_, signals_, problems);
  if (!options_.lock_step || options_.links) admit_links(file_, signals_, problems);
  if (!options_.lock_step) admit_doors(file_, problems);
  const signals::Signals& signals = signals_;
  std::set<std::string> live(signals.live.begin(), signals.live.end());
  if (options_.test) live.clear();  // a test writes to no file of the user's
  files_ = std::make_unique<DataFiles>(
      store_,
      StateFolder(file_.folder, live, options_.keep, options_.state_folder,
                  patience_of(file_, options_.lock_step), file_.path.filename().string()),
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

void Cell::build_controllers(const ros_files::ControllersFile& described, Problems& problems) {
  std::vector<PlannedController> plan =
      plan_controllers(described, robots_, *loop_, {tags_->command_names(), options_.lock_step, file_.budget},
                       observer_, problems);
  chosen_controllers_ = start_controllers(std::move(plan), file_, described, robots_, *loop_, observer_, problems);
  if (auto* io = loop_->controllers().find(kIoController))
    tags_->connect(dynamic_cast<controllers::ForwardCommandController*>(io));
  for (const auto& robot : robots_) {
    controllers::JointTrajectoryController* follower =
        trajectory_controller_of(*robot, loop_->controllers(), !arming_->armed());
    trajectory_controllers_.push_back(follower);
    motions_.push_back(follower ? std::make_unique<moves::RobotMotion>(
                                      *robot->facts, *follower,
                                      [this](std::function<void()> job) { planner_->post(std::move(job)); })
                                : nullptr);
    if (motions_.back()) motions_.back()->set_planned(robot->start);
    controllers::DiffDriveController* wheels = base_controller_of(*robot, loop_->controllers());
    bases_.push_back(wheels ? std::make_unique<moves::BaseMotion>(*wheels, seconds(loop_->options().period))
                            : nullptr);
    places_.emplace_back(*robot, loop_->table(), wheels);
  }
  for (std::size_t i = 0; i < robots_.size(); ++i)
    for (std::size_t k = 0; k < robots_.size(); ++k)
      if (robots_[i]->entry.on == robots_[k]->entry.name) places_[i].set_carrier(places_[k]);
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

Pose Cell::tcp(std::size_t robot) const {
  const CellRobot& r = *robots_[robot];
  std::array<double, 64> q{};
  const control::Snapshot& snapshot = loop_->outbox().value();
  const std::span<const JointPlaces::Place> places = joint_places_.of(robot);
  for (std::size_t j = 0; j < places.size() && j < q.size(); ++j)
    q[j] = places[j].state >= 0 ? snapshot.states[static_cast<std::size_t>(places[j].state)] : 0;
  return r.facts->chain.forward({q.data(), r.joints.size()});
}

/// The flange that carries the camera, in the world.
Pose Cell::carrier_of(const Camera& camera) const {
  for (std::size_t i = 0; i < robots_.size(); ++i)
    if (robots_[i]->entry.name == camera.setup().robot) return tcp(i) * inverse(robots_[i]->tool.tcp);
  return {};
}

void Cell::update_states(const control::Snapshot& snapshot) {
  const bool running = program_ && begun_ && !program_->ended();
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
    const std::span<const JointPlaces::Place> places = joint_places_.of(i);
    for (std::size_t j = 0; j < motions_[i]->planned().size(); ++j) {
      const int command = places[j].command;
      const double at = command < 0 ? std::numeric_limits<double>::quiet_NaN()
                                    : snapshot.commands[static_cast<std::size_t>(command)];
      if (std::isfinite(at)) motions_[i]->set_planned(j, at);
    }
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
  ros_files::ControllersFile described;
  if (type.empty()) described = read_cell_controllers(source, problems);
  problems.throw_if_errors();
  std::vector<PlannedController> plan =
      plan_controllers(described, robots_, *loop_, {{}, options_.lock_step, file_.budget}, nobody, problems);
  std::vector<std::string> known;
  for (PlannedController& planned : plan) {
    known.push_back(planned.context.name);
    if (type.empty() ? planned.context.name != name : &planned != &plan.front()) continue;
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
  const bool at_work = program_ && begun_ && !program_->ended();
  const auto in_use = [&](const std::string& by) {
    throw Error("in-use", "the controller '" + name + "' cannot be unloaded: " + by + " works through it");
  };
  if (leaving && name == kIoController) in_use("the cell's tags");
  for (std::size_t i = 0; leaving && i < trajectory_controllers_.size(); ++i)
    if (trajectory_controllers_[i] == leaving && at_work) in_use("the program");
  const auto led = [&](const auto& base) { return base && &base->controller() == leaving; };
  const auto base = std::find_if(bases_.begin(), bases_.end(), led);
  if (leaving && base != bases_.end() && at_work) in_use("the program");
  loop_->controllers().unload(name);
  goal_events_.erase(name);
  if (leaving && base != bases_.end()) {
    if (moves_) moves_->forget(**base);
    places_[static_cast<std::size_t>(base - bases_.begin())].forget_wheels();
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
      protocol::SendMessage request;
      request.to = to;
      request.message = protocol::Message(read_file(file));
      requests_->ask(request, [this, file](const protocol::Reply& reply) {
        if (!reply.refusal) return true;
        const Problem& why = reply.refusal->problems().front();
        fail(now_, {"not-sent", {file.string()}, why.what, why.advice});
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
  for (MovingBase& base : places_) base.look();
  const control::Snapshot& snapshot = loop_->outbox().value();
  tell_loop_events();
  tell_overruns();
  tell_threads();
  if (!started_ && arming_->armed()) send_start_messages();
  watch_contacts(now, snapshot);  // before moves that a contact ended are forgotten
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
  const bool stop_asked = loop_->supervisor().latch().requested() != realtime::StopKind::none;
  if (may_run && program_ && begun_ && snapshot.state == control::RunState::running && !stop_asked &&
      !jogging_->engaged())
    tick_program(now);
  tick_motions(now);
  write_outputs(now, snapshot);
  files_->exchange(now);
  for (const Problem& problem : files_->take_warnings()) observer_.on_problem(now, problem);
  parts_.update(now, snapshot.world);
  contacts_max_ = std::max(contacts_max_, snapshot.world.contacts);
  tracking_error_max_ = std::max(tracking_error_max_, snapshot.world.tracking_error);
  tell_changes(now);
  if (!failure_) {
    watch_faults(now, snapshot);
    watch_groups(now, snapshot);
    if (const auto note = recorder_.tick(now, *loop_, *worker_)) observer_.on_note(*note);
    watch_for_deadlock(now, snapshot);
    watch_end(now);
  }
  if (recording_) recording_->tick(now);
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
    for (moves::RobotMotion::Warning& warning : motion->take_warnings()) {
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

jog::JogLimits Cell::jog_limits() const {
  const ProfileEntry& profile = profile_ == "reduced" ? file_.profiles.reduced : file_.profiles.full;
  jog::JogLimits out{profile.joint_speed, profile.tcp_speed, profile.tcp_turning};
  if (contact_watch_.touching()) {  // out of it slowly
    constexpr double kJointShare = 0.05, kSpeed = 0.02, kTurning = 0.1;
    out.joint_share = std::min(out.joint_share, kJointShare);
    out.tcp_speed = std::min(out.tcp_speed, kSpeed);
    out.tcp_turning = std::min(out.tcp_turning, kTurning);
  }
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

moves::MovePlanOptions Cell::plan_options() const {
  if (arming_->first_pass()) return {};
  const ProfileEntry& profile = profile_ == "reduced" ? file_.profiles.reduced : file_.profiles.full;
  return {profile.tcp_speed < kNoTcpLimit ? profile.tcp_speed : 0, profile.joint_speed};
}

/// Do planned moves, and at least one, go as the profile wants them planned now?
bool Cell::moves_as_planned_now() const {
  if (arming_->first_pass()) return false;
  bool any = false;
  for (const auto& motion : motions_) {
    const moves::MovePlanOptions* with = motion ? motion->options_under_way() : nullptr;
    if (with && *with != plan_options()) return false;
    any = any || with;
  }
  return any;
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

std::optional<std::uint64_t> Cell::first_motion_cycle() const {
  for (const controllers::JointTrajectoryController* follower : trajectory_controllers_)
    if (follower && follower->status().started_cycle.load() > 0)
      return follower->status().started_cycle.load() - 1;
  return std::nullopt;
}

}  // namespace polyarm::cell
