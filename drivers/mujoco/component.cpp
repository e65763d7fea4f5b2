#include "drivers/mujoco/component.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "drivers/mujoco/mjcf.hpp"
#include "polyarm/base/error.hpp"

namespace polyarm::drivers {

using hardware::CallbackReturn;
using hardware::ReturnType;

namespace {
/// Every part needs a body, because all its properties follow from it.
void check_parts(const description::Scene& scene) {
  Problems problems;
  for (const description::Part& part : scene.parts)
    if (part.shape.kind == description::ShapeKind::mesh && part.shape.pieces.empty())
      problems.error("mesh-part", {},
                     "the part '" + part.name + "' has no body, as its mesh could not be read",
                     "mend the mesh, or give the part a box, cylinder, capsule or sphere of its size");
  problems.throw_if_errors();
}

/// The ROS names of the components of a pose.
constexpr const char* kPoseNames[] = {"position.x",    "position.y",    "position.z",   "orientation.x",
                                      "orientation.y", "orientation.z", "orientation.w"};

constexpr const char* kWrenchNames[] = {"force.x", "force.y", "force.z", "torque.x", "torque.y", "torque.z"};

std::array<double, 7> pose_numbers(const Pose& p) {
  return {p.position.x, p.position.y, p.position.z, p.rotation.x, p.rotation.y, p.rotation.z, p.rotation.w};
}
}  // namespace

CallbackReturn MujocoComponent::on_init(const hardware::ComponentContext& context) {
  if (context.scene) check_parts(*context.scene);
  context_ = context;
  constexpr Nanoseconds kLongestStep = 1'000'000;
  substeps_ = static_cast<int>(std::max<Nanoseconds>(1, (context.period + kLongestStep - 1) / kLongestStep));
  timestep_ = seconds(context.period) / substeps_;
  for (const hardware::RobotInstance& facts : context_.robots) {
    Robot robot;
    robot.facts = facts;
    robot.servo = std::make_unique<Servo>(facts);
    robot.gripper = std::make_unique<Gripper>(facts.tool, robots_.size());
    robot.first_state = states_.size();
    robot.first_command = commands_.size();
    const std::vector<std::string> joints = facts.model->joint_names();
    robot.joints = joints.size();
    for (std::size_t j = 0; j < joints.size(); ++j)
      for (const char* quantity : {"position", "velocity", "effort"}) {
        const std::string name = facts.name + "/" + joints[j] + "/" + quantity;
        const bool position = quantity[0] == 'p';
        states_.push_back(
            {name, position && j < facts.initial_positions.size() ? facts.initial_positions[j] : 0.0});
        commands_.push_back({name});
      }
    if (is_freestanding(facts)) {
      robot.base_state = static_cast<int>(states_.size());
      const std::array<double, 7> at = pose_numbers(facts.base);
      for (std::size_t k = 0; k < at.size(); ++k)
        states_.push_back({facts.name + "/base/" + kPoseNames[k], at[k]});
    }
    const std::vector<ForceSensor> sensors = force_sensors(facts);
    robot.force_state = static_cast<int>(states_.size());
    robot.force_sensors = sensors.size();
    for (const ForceSensor& sensor : sensors)
      for (const char* axis : kWrenchNames)
        states_.push_back({facts.name + "/" + sensor.name + "/" + axis, 0.0});
    if (std::any_of(sensors.begin(), sensors.end(),
                    [](const ForceSensor& each) { return each.errors.any(); })) {
      std::size_t series = 0;  // those of the robots before are taken
      for (const Robot& each : robots_) series += each.errors.size();
      for (const ForceSensor& sensor : sensors) robot.errors.emplace_back(sensor.errors, series++);
    }
    for (auto* values : {&robot.position, &robot.velocity, &robot.effort}) values->assign(robot.joints, NAN);
    if (robot.gripper->suction() || robot.gripper->parallel()) {
      const std::string tool = facts.name + "/tool/";
      robot.tool_command = static_cast<int>(commands_.size());
      commands_.push_back({tool + (robot.gripper->suction() ? "vacuum" : "grip")});
      robot.tool_state = static_cast<int>(states_.size());
      states_.push_back({tool + (robot.gripper->suction() ? "vacuum" : "width"), 0.0});
      states_.push_back({tool + "part_present", 0.0});
    }
    robots_.push_back(std::move(robot));
  }
  machines_ = std::make_unique<Machines>(context_.scene, states_, commands_);
  parts_ = std::make_unique<Parts>(context_.scene);
  contacts_ = std::make_unique<ContactReader>(robots_.size(), parts_->size());
  models_ = std::make_unique<ModelSet>(context_, timestep_);
  return CallbackReturn::success;
}

CallbackReturn MujocoComponent::on_configure() {
  int largest = 0, most_places = 0;
  for (std::size_t i = 0; i < models_->size(); ++i) {
    largest = std::max(largest, models_->view(i).m()->nv);
    most_places = std::max(most_places, models_->view(i).m()->nq);
  }
  places_.assign(static_cast<std::size_t>(most_places), 0);
  acceleration_.assign(static_cast<std::size_t>(largest), 0);
  inertial_force_.assign(static_cast<std::size_t>(largest), 0);
  active_ = models_->index_for(parts_->awake());
  for (std::size_t r = 0; r < robots_.size(); ++r) {
    const std::vector<double>& start = robots_[r].facts.initial_positions;
    view().place(r, start);
    std::vector<double> at(robots_[r].joints, 0.0);
    std::copy_n(start.begin(), std::min(start.size(), at.size()), at.begin());
    robots_[r].servo->start_at(at);
  }
  world_.parts.resize(parts_->size());
  parts_->lay_out(*models_, view());
  machines_->lay_out(view());
  mj_forward(view().m(), view().d());
  known_ = Known::kinematics;
  publish();
  return CallbackReturn::success;
}

MujocoComponent::Robot* MujocoComponent::robot_of(const std::string& interface, std::size_t& joint,
                                                  JointMode& mode) {
  for (Robot& robot : robots_)
    for (std::size_t j = 0; j < robot.joints; ++j)
      for (std::size_t k = 0; k < 3; ++k)
        if (commands_[robot.first_command + 3 * j + k].name == interface) {
          joint = j;
          mode = static_cast<JointMode>(k);
          return &robot;
        }
  return nullptr;
}

ReturnType MujocoComponent::prepare_command_mode_switch(std::span<const std::string>,
                                                        std::span<const std::string>) {
  return ReturnType::ok;
}

ReturnType MujocoComponent::perform_command_mode_switch(std::span<const std::string> start,
                                                        std::span<const std::string> stop) noexcept {
  std::size_t joint = 0;
  JointMode mode = JointMode::position;
  const auto at = [&](const Robot& robot) -> const ModelView::Robot& {
    return view().robots[static_cast<std::size_t>(&robot - robots_.data())];
  };
  for (const std::string& name : stop)
    if (Robot* robot = robot_of(name, joint, mode))
      robot->servo->stop(joint, mode, view().d()->qpos[at(*robot).qpos[joint]]);
  // Priority among several interfaces of one joint: position, then velocity, then effort.
  for (const JointMode wanted : {JointMode::effort, JointMode::velocity, JointMode::position})
    for (const std::string& name : start)
      if (Robot* robot = robot_of(name, joint, mode); robot && mode == wanted)
        robot->servo->start(joint, mode, view().d()->qpos[at(*robot).qpos[joint]],
                            view().d()->qvel[at(*robot).dof[joint]]);
  return ReturnType::ok;
}

void MujocoComponent::take_commands(std::span<const double> commands) noexcept {
  for (Robot& robot : robots_) {
    for (std::size_t j = 0; j < robot.joints; ++j) {
      robot.position[j] = commands[robot.first_command + 3 * j];
      robot.velocity[j] = commands[robot.first_command + 3 * j + 1];
      robot.effort[j] = commands[robot.first_command + 3 * j + 2];
    }
    robot.servo->command(robot.position, robot.velocity, robot.effort, timestep_ * substeps_);
    if (robot.tool_command >= 0)
      if (const double value = commands[static_cast<std::size_t>(robot.tool_command)]; std::isfinite(value))
        robot.gripper->command(value);
  }
  machines_->command(commands);
}

void MujocoComponent::step() noexcept {
  mjModel* m = view().m();
  mjData* d = view().d();
  first_half_of_step(m, d, known_);
  contacts_->read(view(), *parts_, now_, world_);
  std::fill_n(acceleration_.begin(), m->nv, 0.0);
  for (std::size_t r = 0; r < robots_.size(); ++r) {
    robots_[r].servo->accelerations(view(), r, acceleration_.data(), timestep_);
    tracking_error_ = std::max(tracking_error_, robots_[r].servo->tracking_error());
  }
  mj_mulM(m, d, inertial_force_.data(), acceleration_.data());
  for (std::size_t r = 0; r < robots_.size(); ++r) {
    robots_[r].servo->torques(view(), r, inertial_force_.data());
    robots_[r].gripper->push(view());
  }
  std::copy_n(d->qpos, m->nq, places_.begin());
  mj_step2(m, d);
  parts_->pull(view(), timestep_);
  // What stands still keeps its poses and contacts.
  const bool still =
      std::memcmp(d->qpos, places_.data(), sizeof(mjtNum) * static_cast<std::size_t>(m->nq)) == 0 &&
      quaternions_stay(m, d);
  if (!still) mj_kinematics(m, d);
  for (Robot& robot : robots_)
    robot.gripper->update(view(), *parts_, *contacts_, vec3(m->opt.gravity), timestep_);
  known_ = still ? Known::positions : Known::kinematics;
  if (machines_->step(view(), *parts_, timestep_)) known_ = Known::nothing;
  if (parts_->changed()) change_model();
  failed_ |= d->warning[mjWARN_BADQACC].number > 0 || d->warning[mjWARN_BADQPOS].number > 0 ||
             d->warning[mjWARN_BADQVEL].number > 0;
  if (failed_) known_ = Known::nothing;  // MuJoCo has reset what was not finite
  now_ += nanoseconds(timestep_);
}

void MujocoComponent::copy_robots(const ModelView& from, ModelView& to) noexcept {
  for (std::size_t r = 0; r < robots_.size(); ++r) {
    const auto copy = [&](int qpos_from, int qpos_to, int dof_from, int dof_to) {
      to.d()->qpos[qpos_to] = from.d()->qpos[qpos_from];
      to.d()->qvel[dof_to] = from.d()->qvel[dof_from];
      to.d()->qacc_warmstart[dof_to] = from.d()->qacc_warmstart[dof_from];
    };
    for (std::size_t j = 0; j < robots_[r].joints; ++j)
      copy(from.robots[r].qpos[j], to.robots[r].qpos[j], from.robots[r].dof[j], to.robots[r].dof[j]);
    for (std::size_t k = 0; k < from.robots[r].followers.size(); ++k) {
      const auto &a = from.robots[r].followers[k], &b = to.robots[r].followers[k];
      copy(a.qpos, b.qpos, a.dof, b.dof);
    }
    if (const ModelView::Robot& a = from.robots[r], &b = to.robots[r]; a.base_dof >= 0) {
      for (int k = 0; k < 7; ++k) to.d()->qpos[b.base_qpos + k] = from.d()->qpos[a.base_qpos + k];
      for (int k = 0; k < 6; ++k) {
        to.d()->qvel[b.base_dof + k] = from.d()->qvel[a.base_dof + k];
        to.d()->qacc_warmstart[b.base_dof + k] = from.d()->qacc_warmstart[a.base_dof + k];
      }
    }
    for (std::size_t side = 0; side < 2; ++side)
      if (from.robots[r].finger_dof[side] >= 0)
        copy(from.robots[r].finger_qpos[side], to.robots[r].finger_qpos[side],
             from.robots[r].finger_dof[side], to.robots[r].finger_dof[side]);
  }
}

void MujocoComponent::change_model() noexcept {
  const std::size_t wanted = models_->index_for(parts_->awake());
  if (wanted != active_) {
    copy_robots(models_->view(active_), models_->view(wanted));
    std::copy_n(models_->view(active_).d()->sensordata, view().m()->nsensordata,
                models_->view(wanted).d()->sensordata);
    active_ = wanted;
  }
  parts_->lay_out(*models_, view());
  machines_->lay_out(view());
  mj_kinematics(view().m(), view().d());
  known_ = Known::kinematics;
}

void MujocoComponent::publish() noexcept {
  world_.at_rest = parts_->awake() == 0 && !machines_->moving();
  for (const Robot& robot : robots_) world_.at_rest = world_.at_rest && !robot.gripper->moving(view());
  for (std::size_t i = 0; i < parts_->size(); ++i) {
    const Parts::Part& part = (*parts_)[i];
    hardware::PartState& out = world_.parts[i];
    out.pose = part.pose;
    out.linear_velocity = {part.velocity[0], part.velocity[1], part.velocity[2]};
    out.speed = part.speed;
    out.entered = part.entered;
    out.in_world = parts_->in_world(i);
    out.asleep = part.mode == Parts::Mode::asleep;
    out.held_by = part.robot < 0 ? -1 : context_.robots[static_cast<std::size_t>(part.robot)].number;
  }
  world_.tracking_error = tracking_error_;
  tracking_error_ = 0;
}

ReturnType MujocoComponent::read(const hardware::Cycle& cycle, std::span<double> states) noexcept {
  const mjtNum* wrench = view().d()->sensordata;
  for (std::size_t r = 0; r < robots_.size(); ++r) {
    Robot& robot = robots_[r];
    const ModelView::Robot& at = view().robots[r];
    for (std::size_t j = 0; j < robot.joints; ++j) {
      states[robot.first_state + 3 * j] = view().d()->qpos[at.qpos[j]];
      states[robot.first_state + 3 * j + 1] = view().d()->qvel[at.dof[j]];
      states[robot.first_state + 3 * j + 2] = robot.servo->torque(j);
    }
    if (robot.base_state >= 0) {
      const mjtNum* q = view().d()->qpos + at.base_qpos;  // x y z, then w x y z
      const double numbers[] = {q[0], q[1], q[2], q[4], q[5], q[6], q[3]};
      std::copy_n(numbers, 7, states.begin() + robot.base_state);
    }
    // The models have no other sensors than these, three numbers of force and three of torque each. MuJoCo
    // reports what the carrying link exerts; the sensor reports what acts on the link, as sensors of robots
    // do.
    for (std::size_t k = 0; k < 6 * robot.force_sensors; ++k)
      states[static_cast<std::size_t>(robot.force_state) + k] = -*wrench++;
    for (std::size_t k = 0; k < robot.errors.size(); ++k)
      robot.errors[k].add(seconds(cycle.period),
                          &states[static_cast<std::size_t>(robot.force_state) + 6 * k]);
    if (robot.tool_state < 0) continue;
    states[static_cast<std::size_t>(robot.tool_state)] =
        robot.gripper->suction() ? robot.gripper->level() : robot.gripper->width(view());
    states[static_cast<std::size_t>(robot.tool_state) + 1] = robot.gripper->senses() ? 1 : 0;
  }
  machines_->read(*parts_, states);
  publish();
  return failed_ ? ReturnType::error : ReturnType::ok;
}

ReturnType MujocoComponent::write(const hardware::Cycle& cycle, std::span<const double> commands) noexcept {
  now_ = cycle.time;
  take_commands(commands);
  for (int k = 0; k < substeps_; ++k) step();
  return failed_ ? ReturnType::error : ReturnType::ok;
}

const hardware::DriverFacts* MujocoComponent::facts() const noexcept {
  static constexpr hardware::DriverFacts kFacts = {
      "system", "robots, tools, parts and machines of a cell in the physics of MuJoCo",
      "laws of physics and whole cells, in tests", {}};
  return &kFacts;
}

std::string MujocoComponent::summary() const {
  return fmt::format("MuJoCo {}, physics step {:.3g} ms", mj_versionString(), timestep_ * 1e3);
}

}  // namespace polyarm::drivers
