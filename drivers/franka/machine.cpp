#include "drivers/franka/machine.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/wire/six_axes.hpp"
#include "polyarm/base/pose.hpp"

namespace polyarm::franka {

namespace {

constexpr double kPeriod = 0.001;
constexpr double kFollows = 0.2;      // of the way to the desired position, in each cycle
constexpr double kThere = 1e-12;      // rad
constexpr int kMostMissing = 20;      // commands in a row, until the reflex
constexpr int kMostWaiting = 1000;    // the same before the first one
constexpr double kStartStep = 0.01;   // rad, of the first command
constexpr double kEndSpeed = 0.01;    // rad/s, at which a motion may end
constexpr double kBrake = 0.8;        // of the acceleration limits, when the robot stops by itself
constexpr double kTolerance = 1.001;  // of a limit
constexpr double kAfter = 0.05;       // rad beyond its range, before a recovery does not help

constexpr Matrix4 kIdentity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

Matrix4 matrix_of(const Pose& pose) {
  Matrix4 out{};
  const Vec3 axes[3] = {pose.rotation * Vec3{1, 0, 0}, pose.rotation * Vec3{0, 1, 0},
                        pose.rotation * Vec3{0, 0, 1}};
  for (std::size_t c = 0; c < 3; ++c) {
    out[4 * c] = axes[c].x, out[4 * c + 1] = axes[c].y, out[4 * c + 2] = axes[c].z;
  }
  out[12] = pose.position.x, out[13] = pose.position.y, out[14] = pose.position.z, out[15] = 1;
  return out;
}

Seven in_degrees(Seven values) {
  for (double& one : values) one *= wire::kDegrees;
  return values;
}

}  // namespace

MachineFacts facts_of(const description::RobotModel& model) {
  const auto joints = wire::revolute_joints(model, 7, 7, "franka/fr3");
  MachineFacts out;
  const std::string type = model.name.substr(model.name.find('/') + 1);
  const bool panda = type.find("panda") != std::string::npos || type.find("fer") != std::string::npos;
  out.version = panda ? 5 : 9;
  for (std::size_t i = 0; i < 7; ++i) {
    out.lower[i] = joints[i]->limits.lower.value_or(-2.8);
    out.upper[i] = joints[i]->limits.upper.value_or(2.8);
  }
  const int flange = wire::flange_link(model, joints.back()->child_link);
  out.chain = std::make_shared<const kinematics::Chain>(model, flange);
  return out;
}

Machine::Machine(MachineOptions options) : options_(std::move(options)) {
  q_ = q_d_ = options_.start;
  collision_.lower_torque.fill(20), collision_.upper_torque.fill(40);
  collision_.lower_force.fill(20), collision_.upper_force.fill(40);
  ee_to_k_ = ne_to_ee_ = kIdentity;
}

Seven Machine::q() const {
  return in_degrees(q_);
}
Seven Machine::q_d() const {
  return in_degrees(q_d_);
}
double Machine::largest_jump() const {
  return jump_ * wire::kDegrees;
}

// --- people -----------------------------------------------------------------------------------------------

/// The motion ends; the robot brakes.
void Machine::stop_with(RobotMode mode, Status status) {
  mode_ = mode;
  end_motion(status);
}

void Machine::end_motion(Status status) {
  if (motion_) end_ = {*motion_, status};
  motion_.reset();
  command_.reset();
  generator_ = Generator::idle;
  controller_ = Controller::other;
}

void Machine::press_user_stop(bool on) {
  if (on) return stop_with(RobotMode::user_stopped, Status::user_stop);
  if (mode_ == RobotMode::user_stopped) mode_ = brakes_closed_ ? RobotMode::other : RobotMode::idle;
}

void Machine::guide(bool on) {
  if (on && mode_ != RobotMode::user_stopped && mode_ != RobotMode::other)
    return stop_with(RobotMode::guiding, Status::preempted);
  if (mode_ == RobotMode::guiding) mode_ = RobotMode::idle;
}

void Machine::close_brakes(bool on) {
  brakes_closed_ = on;
  if (on) return stop_with(RobotMode::other, Status::aborted);
  if (mode_ == RobotMode::other) mode_ = RobotMode::idle;
}

void Machine::safety_function(bool on) {
  safe_ = on;
  if (on && moves()) stop_with(RobotMode::idle, Status::preempted_by_safety);
}

void Machine::raise(ErrorFlag flag) {
  errors_.set(static_cast<std::size_t>(flag));
  reflex_ = errors_;
  if (mode_ == RobotMode::user_stopped || mode_ == RobotMode::other) return;
  stop_with(RobotMode::reflex, Status::reflex);
}

void Machine::push_by_hand(double first_joint) {
  if (moves()) return;
  q_d_[0] += first_joint;
  q_[0] = q_d_[0];
}

void Machine::set_force(double z) {
  force_ = z;
}

void Machine::leave() {
  if (moves()) {
    mode_ = RobotMode::idle;
    motion_.reset();
    end_motion(Status::aborted);
  }
  end_.reset();
}

// --- motion -----------------------------------------------------------------------------------------------

void Machine::take(const RobotCommand& command) {
  if (!moves() || command.id != id_) return;
  command_ = command;
  ++commands_;
}

void Machine::step() {
  if (moves())
    follow();
  else
    brake();
  command_.reset();
  judge_force();
  measure();
  ++id_;
}

/// The command of this cycle, or what follows from the last ones.
void Machine::follow() {
  in_time_ <<= 1;
  in_time_[0] = command_.has_value();
  if (!command_) {
    if (++missing_ > (first_ ? kMostWaiting : kMostMissing)) return raise(ErrorFlag::communication);
    return first_ ? void() : extrapolate();
  }
  missing_ = 0;
  const bool by_velocity = generator_ == Generator::joint_velocity;
  Seven q, dq, ddq;
  for (std::size_t i = 0; i < 7; ++i) {
    dq[i] = by_velocity ? command_->dq[i] : (command_->q[i] - q_d_[i]) / kPeriod;
    q[i] = by_velocity ? q_d_[i] + dq[i] * kPeriod : command_->q[i];
    ddq[i] = (dq[i] - dq_d_[i]) / kPeriod;
  }
  for (std::size_t i = 0; first_ && !by_velocity && i < 7; ++i)
    if (!(std::abs(q[i] - q_d_[i]) <= kStartStep)) return raise(ErrorFlag::start_pose);
  if (!within_limits(q, dq, ddq)) return;
  first_ = false;
  const bool finished = command_->finished;
  advance(q, dq, ddq);
  if (!finished) return;
  if (std::any_of(dq.begin(), dq.end(), [](double v) { return std::abs(v) > kEndSpeed; }))
    return raise(ErrorFlag::velocity_discontinuity);
  dq_d_ = ddq_d_ = {};
  stop_with(RobotMode::idle, Status::success);
}

/// A lost command counts as one with the same acceleration.
void Machine::extrapolate() {
  Seven q = q_d_, dq = dq_d_;
  for (std::size_t i = 0; i < 7; ++i) {
    const VelocityBounds bounds = velocity_bounds(version(), i, q_d_[i]);
    dq[i] = std::clamp(dq_d_[i] + ddq_d_[i] * kPeriod, bounds.lower, bounds.upper);
    q[i] += dq[i] * kPeriod;
  }
  advance(q, dq, ddq_d_);
}

/// Raises the reflex for the first limit that is exceeded.
bool Machine::within_limits(const Seven& q, const Seven& dq, const Seven& ddq) {
  const MotionLimits& limits = motion_limits(version());
  for (std::size_t i = 0; i < 7; ++i) {
    const double jerk = (ddq[i] - ddq_d_[i]) / kPeriod;
    if (!std::isfinite(q[i]) || !std::isfinite(dq[i])) return raise(ErrorFlag::velocity_discontinuity), false;
    if (std::abs(ddq[i]) > limits.acceleration[i] * kTolerance)
      return raise(ErrorFlag::velocity_discontinuity), false;
    if (std::abs(jerk) > limits.jerk[i] * kTolerance)
      return raise(ErrorFlag::acceleration_discontinuity), false;
    const VelocityBounds bounds = velocity_bounds(version(), i, q_d_[i]);
    const bool faster = std::abs(dq[i]) > std::abs(dq_d_[i]);  // braking is always allowed
    if (faster && (dq[i] > bounds.upper * kTolerance + 0.025 || dq[i] < bounds.lower * kTolerance - 0.025))
      return raise(ErrorFlag::velocity_limits), false;
    const bool out = q[i] > options_.facts.upper[i] || q[i] < options_.facts.lower[i];
    if (out && dq[i] * (q[i] - (options_.facts.upper[i] + options_.facts.lower[i]) / 2) > 0)
      return raise(version() >= 9 ? ErrorFlag::joint_position_limits : ErrorFlag::position_limits), false;
    extremes_[0] = std::max(extremes_[0], std::abs(dq[i]) / limits.velocity[i]);
    extremes_[1] = std::max(extremes_[1], std::abs(ddq[i]) / limits.acceleration[i]);
    extremes_[2] = std::max(extremes_[2], std::abs(jerk) / limits.jerk[i]);
  }
  return true;
}

void Machine::advance(const Seven& q, const Seven& dq, const Seven& ddq) {
  for (std::size_t i = 0; i < 7; ++i) jump_ = std::max(jump_, std::abs(q[i] - q_d_[i]));
  q_d_ = q;
  dq_d_ = dq;
  ddq_d_ = ddq;
}

/// A stop of the robot's own.
void Machine::brake() {
  Seven q = q_d_, dq = dq_d_;
  for (std::size_t i = 0; i < 7; ++i) {
    const double most = kBrake * motion_limits(version()).acceleration[i] * kPeriod;
    dq[i] = std::abs(dq[i]) <= most ? 0 : dq[i] - std::copysign(most, dq[i]);
    q[i] += dq[i] * kPeriod;
  }
  advance(q, dq, {});
}

void Machine::measure() {
  for (std::size_t i = 0; i < 7; ++i) {
    const double away = q_d_[i] - sag_[i] - q_[i];
    const double step = std::abs(away) < kThere ? away : kFollows * away;
    q_[i] = std::abs(away) < kThere ? q_d_[i] - sag_[i] : q_[i] + step;
    dq_[i] = step / kPeriod;
  }
}

/// A force above its upper threshold is a collision.
void Machine::judge_force() {
  if (moves() && std::abs(force_) > collision_.upper_force[2]) raise(ErrorFlag::cartesian_reflex);
}

// --- requests ---------------------------------------------------------------------------------------------

Machine::Answer Machine::answer(Request request, Bytes data, std::uint32_t id) {
  switch (request) {
    case Request::move:
      return {begin(data, id)};
    case Request::stop_move:
      if (!moves()) return {Status::not_possible};
      stop_with(RobotMode::idle, Status::preempted);
      return {};
    case Request::recover:
      return {recover()};
    case Request::load_model_library:
    case Request::get_robot_model:
    case Request::get_cartesian_limit:
      return {Status::not_possible};
    default:
      return {set(request, data)};
  }
}

Status Machine::begin(Bytes data, std::uint32_t id) {
  const auto move = decode_move(data, version());
  if (!move) return Status::invalid_argument;
  if (safe_) return Status::refused_by_safety;
  if (mode_ == RobotMode::user_stopped) return version() <= 5 ? Status::not_possible : Status::user_stop;
  if (mode_ != RobotMode::idle || refuse_motion) return Status::not_possible;
  if (singular) return Status::singular_start;
  const bool by_joints =
      move->generator == Generator::joint_position || move->generator == Generator::joint_velocity;
  if (!by_joints || move->controller == Controller::external) return Status::invalid_argument;
  mode_ = RobotMode::move;
  generator_ = move->generator;
  controller_ = move->controller;
  motion_ = id;
  reflex_.reset();
  errors_.reset();
  missing_ = 0;
  first_ = true;
  in_time_.set();
  dq_d_ = ddq_d_ = {};
  return Status::started;
}

Status Machine::recover() {
  if (mode_ == RobotMode::user_stopped) return Status::user_stop;
  if (mode_ == RobotMode::other || mode_ == RobotMode::guiding || moves()) return Status::not_possible;
  if (refuse_recovery) return Status::manual_recovery;
  for (std::size_t i = 0; i < 7; ++i)
    if (q_d_[i] > options_.facts.upper[i] + kAfter || q_d_[i] < options_.facts.lower[i] - kAfter)
      return Status::manual_recovery;
  errors_.reset();
  mode_ = RobotMode::idle;
  ++recoveries_;
  return Status::success;
}

Status Machine::set(Request request, Bytes data) {
  if (safe_) return Status::refused_by_safety;
  if (moves() || mode_ == RobotMode::user_stopped) return Status::not_possible;
  if (refuse_settings) return Status::invalid_argument;
  const auto positive = [](const auto& values) {
    return std::all_of(values.begin(), values.end(), [](double one) { return one >= 0; });
  };
  Seven seven{};
  Six six{};
  Matrix4 matrix{};
  switch (request) {
    case Request::set_collision_behavior:
      if (const auto behavior = decode_collision(data)) return collision_ = *behavior, Status::success;
      return Status::invalid_argument;
    case Request::set_joint_impedance:
      if (!read_numbers(data, seven) || !positive(seven)) return Status::invalid_argument;
      return joint_stiffness_ = seven, Status::success;
    case Request::set_cartesian_impedance:
      if (!read_numbers(data, six) || !positive(six)) return Status::invalid_argument;
      return cartesian_stiffness_ = six, Status::success;
    case Request::set_guiding_mode:
      if (data.size() != 7) return Status::invalid_argument;
      for (std::size_t i = 0; i < 7; ++i) guiding_axes_[i] = data[i] != 0;
      return Status::success;
    case Request::set_load:
      if (const auto load = decode_load(data)) return load_ = *load, Status::success;
      return Status::invalid_argument;
    case Request::set_k_frame:
    case Request::set_ee_frame:
      if (!read_numbers(data, matrix) || matrix[15] != 1) return Status::invalid_argument;
      return (request == Request::set_k_frame ? ee_to_k_ : ne_to_ee_) = matrix, Status::success;
    case Request::set_filters:
      return data.size() == 40 ? Status::success : Status::invalid_argument;
    default:
      return Status::not_possible;
  }
}

RobotState Machine::state() const {
  RobotState out;
  out.id = id_;
  const auto pose = [this](const Seven& q) { return options_.facts.chain->forward(q); };
  if (options_.facts.chain) {
    out.O_T_EE = matrix_of(pose(q_));
    out.O_T_EE_d = matrix_of(pose(q_d_));
    std::array<double, 42> J{};
    options_.facts.chain->jacobian(q_, J);
    // A force on the flange along z; the rows of J are x y z, then rotations.
    for (std::size_t i = 0; i < 7; ++i) out.tau_ext[i] = J[2 * 7 + i] * force_;
    const Vec3 own = inverse(pose(q_).rotation) * Vec3{0, 0, force_};
    out.K_F_ext = {own.x, own.y, own.z, 0, 0, 0};
  } else {
    out.O_T_EE = out.O_T_EE_d = kIdentity;
  }
  out.O_F_ext = {0, 0, force_, 0, 0, 0};
  out.F_T_EE = out.F_T_NE = kIdentity;
  out.NE_T_EE = ne_to_ee_;
  out.EE_T_K = ee_to_k_;
  out.load = load_;
  out.tau_J = out.tau_ext;
  out.q = q_, out.dq = dq_, out.q_d = q_d_, out.dq_d = dq_d_, out.ddq_d = ddq_d_;
  out.cartesian_contact[2] = std::abs(force_) > collision_.lower_force[2];
  out.cartesian_collision[2] = std::abs(force_) > collision_.upper_force[2];
  out.generator = generator_;
  out.controller = controller_;
  out.errors = errors_;
  out.reflex = reflex_;
  out.mode = mode_;
  if (moves()) out.success_rate = success_share * static_cast<double>(in_time_.count()) / 100;
  return out;
}

}  // namespace polyarm::franka
