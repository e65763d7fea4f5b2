#include "polyarm/machine/motions.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "polyarm/base/text.hpp"
#include "polyarm/realtime/periodic.hpp"
#include "polyarm/setup/controllers_start.hpp"

namespace polyarm::cell {

Motions::Motions(const CellSetup& setup, Machine& machine, Arming& arming, const ContactWatch& contacts,
                 Observer& observer)
    : setup_(setup), machine_(machine), arming_(arming), contacts_(contacts), observer_(observer) {}

namespace {
/// Without a scene file the floor is a guess of physics, and nothing to run into.
std::shared_ptr<SharedBodies> bodies_of(const CellSetup& setup) {
  if (!setup.file.scene.empty()) return std::make_shared<SharedBodies>(setup.robots, setup.scene);
  const auto scene = std::make_shared<description::Scene>(setup.scene);
  scene->floor = false;
  return {new SharedBodies(setup.robots, *scene), [scene](const SharedBodies* bodies) { delete bodies; }};
}
}  // namespace

void Motions::build(Worker& planner) {
  for (const auto& robot : setup_.robots) {
    controllers::JointTrajectoryController* follower =
        trajectory_controller_of(*robot, machine_.controllers(), !arming_.armed());
    followers_.push_back(follower);
    motions_.push_back(follower ? std::make_unique<moves::RobotMotion>(
                                      *robot->facts, *follower,
                                      [&planner](std::function<void()> job) { planner.post(std::move(job)); })
                                : nullptr);
    if (motions_.back()) motions_.back()->set_planned(robot->start);
    if (motions_.back())
      motions_.back()->set_find_obstacles(
          [this, index = motions_.size() - 1] { return obstacles(index, moment()); });
    controllers::BaseController* wheels = base_controller_of(*robot, machine_.controllers());
    bases_.push_back(wheels ? std::make_unique<moves::BaseMotion>(*wheels, seconds(machine_.period()))
                            : nullptr);
    places_.emplace_back(*robot, machine_.table(), wheels);
    if (bases_.back()) look_around(bases_.size() - 1, planner);
    const auto command = robot->joints.empty()
                             ? std::nullopt
                             : machine_.table().find_command(robot->joints.front().name + "/position");
    components_.push_back(command ? machine_.hardware().component_of_command(*command) : -1);
    note_forward(motions_.size() - 1);
    const auto asked = robot->entry.parameters.find("motion");
    if (asked != robot->entry.parameters.end() && asked->second == "forward" &&
        !forward_moves(motions_.size() - 1))
      observer_.on_note("'" + robot->entry.name + "' has `motion: forward`, but the hardware '" +
                        robot->driver + "' takes no moves: this computer interpolates");
  }
  bodies_ = bodies_of(setup_);
  for (const description::Mover& mover : setup_.scene.movers) {
    const auto state = machine_.table().find_state("scene/" + mover.name + "/position");
    movers_.push_back(state ? static_cast<int>(*state) : -1);
  }
  for (std::size_t i = 0; i < setup_.robots.size(); ++i)
    for (std::size_t k = 0; k < setup_.robots.size(); ++k)
      if (setup_.robots[i]->entry.on == setup_.robots[k]->entry.name) places_[i].set_carrier(places_[k]);
}

hardware::ForwardMoves* Motions::forward_moves(std::size_t robot) const {
  const int component = components_[robot];
  return component < 0 ? nullptr : machine_.hardware().forward_moves(static_cast<std::size_t>(component));
}

std::optional<Motions::Points> Motions::points(std::size_t robot) const {
  const controllers::JointTrajectoryController* const follower = followers_[robot];
  const controllers::TrajectoryGoal* const goal = follower ? follower->leading() : nullptr;
  if (!goal || !idle(robot)) return std::nullopt;
  return Points{goal, follower, follower->status().time.load(std::memory_order_relaxed)};
}

/// A component that is replaced may offer another object, or none.
void Motions::note_forward(std::size_t robot) {
  moves::RobotMotion* const motion = motions_[robot].get();
  if (!motion || !followers_[robot]) return;
  hardware::ForwardMoves* const moves = forward_moves(robot);
  followers_[robot]->set_forward(moves);
  if ((moves != nullptr) == motion->forward()) return;
  if (!moves) return motion->set_forward(nullptr);
  motion->set_forward([this, robot] {
    std::vector<double> out = motions_[robot]->planned();
    const std::span<const JointPlaces::Place> places = machine_.joint_places().of(robot);
    for (std::size_t j = 0; j < out.size() && j < places.size(); ++j) {
      const double at =
          places[j].state < 0 ? NAN : machine_.snapshot().states[static_cast<std::size_t>(places[j].state)];
      if (std::isfinite(at)) out[j] = at;
    }
    return out;
  });
}

void Motions::tick(const PlaceOf& place_of) {
  const Nanoseconds now = machine_.now();
  const control::Supervisor& supervisor = machine_.supervisor();
  for (const auto& base : bases_)
    if (base)
      base->tick(now, machine_.snapshot().state == control::RunState::running,
                 supervisor.share() * supervisor.override_share());
  for (std::size_t i = 0; i < motions_.size(); ++i)
    if (motions_[i] && motions_[i]->idle()) note_forward(i);
  for (const auto& motion : motions_) {
    if (!motion) continue;
    motion->set_options(plan_options());
    motion->tick(now);
    for (moves::RobotMotion::Warning& warning : motion->take_warnings()) {
      if (warning.problem.where.file.empty()) warning.problem.where = place_of(*motion, warning.move);
      if (reported_.insert(warning.problem.text()).second) observer_.on_problem(now, warning.problem);
    }
  }
}

void Motions::update_bases() {
  for (MovingBase& base : places_) base.look();
}

void Motions::set_planned(std::size_t robot, int JointPlaces::Place::*index, std::span<const double> values) {
  const std::span<const JointPlaces::Place> places = machine_.joint_places().of(robot);
  for (std::size_t j = 0; j < motions_[robot]->planned().size(); ++j) {
    const int at = places[j].*index;
    if (at >= 0 && std::isfinite(values[static_cast<std::size_t>(at)]))
      motions_[robot]->set_planned(j, values[static_cast<std::size_t>(at)]);
  }
}

void Motions::follow_others() {
  const control::Snapshot& snapshot = machine_.snapshot();
  if (!snapshot.standing) return;
  for (std::size_t i = 0; i < motions_.size(); ++i)
    if (motions_[i] && motions_[i]->idle()) set_planned(i, &JointPlaces::Place::command, snapshot.commands);
}

void Motions::begin_where_robots_are() {
  for (std::size_t i = 0; i < motions_.size(); ++i)
    if (motions_[i]) set_planned(i, &JointPlaces::Place::state, machine_.snapshot().states);
}

bool Motions::any() const {
  const auto there = [](const auto& motion) { return motion != nullptr; };
  return std::any_of(motions_.begin(), motions_.end(), there) ||
         std::any_of(bases_.begin(), bases_.end(), there);
}

bool Motions::all_idle() const {
  for (std::size_t i = 0; i < motions_.size(); ++i)
    if (!idle(i)) return false;
  return true;
}

bool Motions::motion_left() const {
  const control::ControllerManager& manager = machine_.controllers();
  const std::vector<std::string> names = manager.names();
  const auto sent = [&](const std::string& name) {
    const auto* follower = dynamic_cast<const controllers::JointTrajectoryController*>(manager.find(name));
    return follower && follower->status().active.load(std::memory_order_acquire) != 0;
  };
  return !all_idle() || std::any_of(names.begin(), names.end(), sent) ||
         std::any_of(bases_.begin(), bases_.end(), [](const auto& base) { return base && !base->idle(); });
}

Pose Motions::tcp(std::size_t robot) const {
  const CellRobot& r = *setup_.robots[robot];
  std::array<double, 64> q{};
  const control::Snapshot& snapshot = machine_.snapshot();
  const std::span<const JointPlaces::Place> places = machine_.joint_places().of(robot);
  for (std::size_t j = 0; j < places.size() && j < q.size(); ++j)
    q[j] = places[j].state >= 0 ? snapshot.states[static_cast<std::size_t>(places[j].state)] : 0;
  return r.facts->chain.forward({q.data(), r.joints.size()});
}

surroundings::Moment Motions::moment() const {
  surroundings::Moment out;
  moment(out);
  return out;
}

void Motions::moment(surroundings::Moment& out) const {
  const control::Snapshot& snapshot = machine_.snapshot();
  out.robots.resize(setup_.robots.size());
  for (std::size_t r = 0; r < setup_.robots.size(); ++r) {
    out.robots[r].base = places_[r].moves() ? places_[r].pose(snapshot) : setup_.robots[r]->entry.base;
    const std::span<const JointPlaces::Place> places = machine_.joint_places().of(r);
    std::vector<double>& joints = out.robots[r].joints;
    joints.resize(places.size());
    for (std::size_t j = 0; j < places.size(); ++j) joints[j] = JointPlaces::commanded(snapshot, places[j]);
  }
  const std::size_t parts = std::min(snapshot.world.parts.size(), setup_.scene.parts.size());
  out.parts.resize(parts);
  for (std::size_t p = 0; p < parts; ++p) {
    const hardware::PartState& part = snapshot.world.parts[p];
    out.parts[p] = {part.pose, part.in_world, part.held_by};
  }
  out.movers.clear();
  for (const int mover : movers_)
    out.movers.push_back(mover < 0 ? 0 : snapshot.states[static_cast<std::size_t>(mover)]);
}

AroundOptions Motions::around_options() const {
  AroundOptions options;
  options.clearance = setup_.file.clearance;
  if (!setup_.options.lock_step) {
    constexpr Nanoseconds kTimeout = 10'000'000'000;
    const auto end = std::make_shared<Nanoseconds>(0);
    options.stop = [end] {  // counted from its first call: other moves may be planned before
      if (*end == 0) *end = realtime::monotonic_now() + kTimeout;
      return realtime::monotonic_now() > *end;
    };
  }
  return options;
}

std::shared_ptr<moves::Obstacles> Motions::obstacles(std::size_t robot, surroundings::Moment moment) const {
  return obstacles_around(bodies_, std::move(moment), robot, around_options());
}

/// Lets a base find ways to places.
void Motions::look_around(std::size_t robot, Worker& planner) {
  moves::BaseSurroundings around;
  around.T_world_odometry = [this, robot] { return places_[robot].odometry_frame(machine_.snapshot()); };
  around.post = [&planner](std::function<void()> job) { planner.post(std::move(job)); };
  around.look = [this, robot](const Pose& goal) {
    return base_search(bodies_, moment(),
                       {robot, places_[robot].tracked(), goal, bases_[robot]->sharpest(), around_options()});
  };
  bases_[robot]->set_surroundings(std::move(around));
}

std::span<const Vec3> Motions::tcps() const {
  tcps_.resize(setup_.robots.size());
  for (std::size_t i = 0; i < tcps_.size(); ++i) tcps_[i] = tcp(i).position;
  return tcps_;
}

void Motions::end() {
  for (const auto& motion : motions_)
    if (motion) motion->end(1);
  drop_bases();
}

void Motions::drop() {
  for (const auto& motion : motions_)
    if (motion) motion->drop();
  drop_bases();
}

void Motions::drop_bases() {
  for (const auto& base : bases_)
    if (base) base->drop();
}

const ProfileEntry& Motions::limits() const {
  return profile_ == "reduced" ? setup_.file.profiles.reduced : setup_.file.profiles.full;
}

void Motions::set_profile(const std::string& name) {
  const std::vector<std::string> known = {"reduced", "full"};
  if (std::find(known.begin(), known.end(), name) == known.end())
    throw Error("unknown-profile", "there is no limits profile '" + name + "'" + did_you_mean(name, known),
                "reduced or full");
  asked_ = name;
  choose_profile();
}

void Motions::set_reduced(bool reduced) {
  reduced_ = reduced;
  choose_profile();
}

void Motions::choose_profile() {
  profile_ = reduced_ ? "reduced" : asked_;
  const bool slower = limits().tcp_speed < kNoTcpLimit || limits().joint_speed < 1;
  arming_.set_profile(slower, limits().tcp_speed, limits().joint_speed);
}

jog::JogLimits Motions::jog_limits() const {
  jog::JogLimits out{limits().joint_speed, limits().tcp_speed, limits().tcp_turning, profile_ == "reduced"};
  if (contacts_.touching()) {  // move slowly out of the contact
    constexpr double kJointShare = 0.05, kSpeed = 0.02, kTurning = 0.1;
    out.joint_share = std::min(out.joint_share, kJointShare);
    out.tcp_speed = std::min(out.tcp_speed, kSpeed);
    out.tcp_turning = std::min(out.tcp_turning, kTurning);
  }
  if (!arming_.first_pass()) return out;
  out.joint_share = std::min(out.joint_share, kReducedProfile.joint_speed);
  out.tcp_speed = std::min(out.tcp_speed, kReducedProfile.tcp_speed);
  out.tcp_turning = std::min(out.tcp_turning, kReducedProfile.tcp_turning);
  return out;
}

moves::MovePlanOptions Motions::plan_options() const {
  const bool reduced = profile_ == "reduced";
  if (arming_.first_pass()) return {0, 1, reduced};
  return {limits().tcp_speed < kNoTcpLimit ? limits().tcp_speed : 0, limits().joint_speed, reduced};
}

bool Motions::planned_as_now() const {
  if (arming_.first_pass()) return false;
  bool any = false;
  for (const auto& motion : motions_) {
    const moves::MovePlanOptions* with = motion ? motion->options_under_way() : nullptr;
    if (with && *with != plan_options()) return false;
    any = any || with;
  }
  return any;
}

std::optional<std::uint64_t> Motions::first_motion_cycle() const {
  for (const controllers::JointTrajectoryController* follower : followers_)
    if (follower && follower->status().started_cycle.load() > 0)
      return follower->status().started_cycle.load() - 1;
  return std::nullopt;
}

bool Motions::use(const controllers::Controller& controller) const {
  const auto drives = [&](const auto& base) { return base && &base->controller() == &controller; };
  return std::find(followers_.begin(), followers_.end(), &controller) != followers_.end() ||
         std::any_of(bases_.begin(), bases_.end(), drives);
}

void Motions::release(const controllers::Controller& controller,
                      const std::function<void(moves::RobotMotion&)>& forget,
                      const std::function<void(moves::BaseMotion&)>& forget_base) {
  for (std::size_t i = 0; i < bases_.size(); ++i) {
    if (!bases_[i] || &bases_[i]->controller() != &controller) continue;
    forget_base(*bases_[i]);
    places_[i].forget_wheels();
    bases_[i].reset();
  }
  for (std::size_t i = 0; i < followers_.size(); ++i) {
    if (followers_[i] != &controller) continue;
    followers_[i] = nullptr;
    forget(*motions_[i]);
    motions_[i].reset();
  }
}

}  // namespace polyarm::cell
