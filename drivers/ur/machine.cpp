#include "drivers/ur/machine.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::ur {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kStopDeceleration = 30;  // rad/s², of the stops that the controller makes by itself
constexpr double kServoAcceleration = 40;
constexpr double kOverspeed = 1.1;  // of a joint's limit: the controller makes a protective stop
constexpr double kEndless = 200;    // rad, of a joint without limits
constexpr double kUnlockAfter = 5;  // s

int type_of(const std::string& model) {
  constexpr std::pair<const char*, int> kTypes[] = {{"UR30", 8}, {"UR20", 7}, {"UR18", 5},
                                                    {"UR16", 4}, {"UR15", 9}, {"UR10", 2},
                                                    {"UR8", 6},  {"UR3", 3},  {"UR5", 1}};
  for (const auto& [name, type] : kTypes)
    if (model.starts_with(name)) return type;
  return 1;
}

std::vector<double> list(const Six& six) {
  return {six.begin(), six.end()};
}

}  // namespace

MachineFacts facts_of(const description::RobotModel& model) {
  std::vector<const description::Joint*> joints;
  for (const int i : model.actuated) joints.push_back(&model.joints[static_cast<std::size_t>(i)]);
  if (joints.size() < 6 || std::any_of(joints.begin(), joints.begin() + 6, [](const auto* j) {
        return j->type != description::JointType::revolute && j->type != description::JointType::continuous;
      }))
    throw Error("bad-model", "'" + model.name + "' does not begin with six revolute joints",
                "choose a robot of Universal Robots, for example universal_robots/ur5e");
  MachineFacts out;
  out.model = model.name.substr(model.name.find('/') + 1);
  std::transform(out.model.begin(), out.model.end(), out.model.begin(),
                 [](char c) { return static_cast<char>(std::toupper(c)); });
  if (out.model.ends_with("E")) out.model.back() = 'e';
  out.type = type_of(out.model);
  for (std::size_t i = 0; i < 6; ++i) {
    const description::JointLimits& limits = joints[i]->limits;
    out.lower[i] = limits.lower.value_or(-kEndless);
    out.upper[i] = limits.upper.value_or(kEndless);
    out.velocity[i] = limits.velocity.value_or(kPi);
  }
  Kinematics& k = out.kinematics;
  const auto at = [&](std::size_t i) { return joints[i]->origin.position; };
  k.alpha = {kPi / 2, 0, 0, kPi / 2, -kPi / 2, 0};
  k.a = {0, at(2).x, at(3).x, 0, 0, 0};
  k.d = {at(0).z, 0, 0, at(3).z, -at(4).y, at(5).y};
  out.arm = k;
  return out;
}

void make_calibrated(MachineFacts& facts) {
  Kinematics& k = facts.arm;
  const Six theta{0, 4e-4, -7e-4, 3e-4, -2e-4, 0}, a{2e-5, 6e-4, -4e-4, -5e-5, 6e-5, 0},
      d{3e-4, 2, -2.0005, 4e-4, -2e-4, 1e-4}, alpha{-6e-4, 2e-4, -1e-4, -8e-4, 4e-4, 0};
  for (std::size_t i = 0; i < 6; ++i) {
    k.theta[i] += theta[i];
    k.a[i] += a[i];
    k.d[i] += d[i];
    k.alpha[i] += alpha[i];
  }
}

Machine::Machine(MachineOptions options) : options_(std::move(options)), q_(options_.start) {
  remote_ = options_.remote;
  if (options_.on) robot_mode_ = running;
  set_register("output_int_register_24", 0);
}

void Machine::servo(const Six& target, double lookahead) {
  if (!may_move()) return;
  if (motion_ == Motion::servo && servoing_) {
    for (std::size_t i = 0; i < 6; ++i) jump_ = std::max(jump_, std::abs(target[i] - target_[i]));
  } else {
    for (std::size_t i = 0; i < 6; ++i) jump_ = std::max(jump_, std::abs(target[i] - q_[i]));
  }
  motion_ = Motion::servo;
  servoing_ = true;
  target_ = target;
  lookahead_ = std::max(lookahead, 1e-3);
}

void Machine::speed(const Six& velocity, double acceleration) {
  if (!may_move()) return;
  motion_ = Motion::speed;
  target_ = velocity;
  rate_ = acceleration;
}

void Machine::follow(const Six& next) {
  if (!may_move()) return;
  for (std::size_t i = 0; i < 6; ++i) jump_ = std::max(jump_, std::abs(next[i] - q_[i]));
  motion_ = Motion::path;
  servoing_ = false;
  target_ = next;
}

void Machine::brake(double deceleration) {
  motion_ = Motion::brake;
  servoing_ = false;
  rate_ = deceleration;
}

bool Machine::still() const {
  return std::all_of(qd_.begin(), qd_.end(), [](double v) { return std::abs(v) < 1e-9; });
}

void Machine::step(double dt) {
  time_ += dt;
  if (!may_move() && motion_ != Motion::brake) brake(kStopDeceleration);
  const double scale = std::clamp(slider_, 0.0, 1.0);
  for (std::size_t i = 0; i < 6; ++i) {
    const double most = options_.facts.velocity[i] * scale;
    double wanted = 0, change = rate_ * dt;
    if (motion_ == Motion::servo) {
      wanted = std::clamp((target_[i] - q_[i]) / (lookahead_ + dt), -most, most);
      change = kServoAcceleration * dt;
    } else if (motion_ == Motion::speed) {
      wanted = std::clamp(target_[i] * scale, -most, most);
    }
    qd_[i] += std::clamp(wanted - qd_[i], -change, change);
    if (motion_ == Motion::path) {
      const double fastest = kOverspeed * options_.facts.velocity[i];
      const double speed = (target_[i] - q_[i]) / dt;
      qd_[i] = std::clamp(speed, -fastest, fastest);
      if (speed != qd_[i]) safety(protective_stop);
    }
    q_[i] += qd_[i] * dt;
    if (q_[i] < options_.facts.lower[i] || q_[i] > options_.facts.upper[i]) safety(protective_stop);
  }
  for (const auto& [output, input] : wires_) digital_input(input, digital_output(output));
}

bool Machine::switch_on() {
  if (safety_mode_ > safety_reduced) return false;
  if (robot_mode_ == power_off) robot_mode_ = idle;
  return true;
}

void Machine::switch_off() {
  robot_mode_ = power_off;
  brake(kStopDeceleration);
}

bool Machine::release_brakes() {
  if (robot_mode_ != idle) return robot_mode_ == running;
  robot_mode_ = running;
  return true;
}

bool Machine::unlock() {
  if (safety_mode_ != protective_stop || time_ - stopped_at_ < kUnlockAfter) return false;
  safety_mode_ = safety_normal;
  return true;
}

void Machine::safety(int mode) {
  if (safety_mode_ == mode) return;
  safety_mode_ = mode;
  stopped_at_ = time_;
  if (mode <= safety_reduced) return;
  brake(kStopDeceleration);
  if (mode == system_emergency || mode == robot_emergency || mode == violation || mode == fault) switch_off();
}

void Machine::digital_input(int bit, bool on) {
  inputs_ = on ? inputs_ | std::uint64_t{1} << bit : inputs_ & ~(std::uint64_t{1} << bit);
}

void Machine::digital_output(int bit, bool on) {
  outputs_ = on ? outputs_ | std::uint64_t{1} << bit : outputs_ & ~(std::uint64_t{1} << bit);
}

void Machine::push_by_hand(const Six& change) {
  for (std::size_t i = 0; i < 6; ++i) q_[i] += change[i];
}

std::vector<double> Machine::value(std::string_view name) const {
  const auto number = [](auto v) { return std::vector<double>{static_cast<double>(v)}; };
  const auto pose = [&] { return list(flange_pose(options_.facts.arm, q_)); };
  const bool emergency = safety_mode_ == system_emergency || safety_mode_ == robot_emergency;
  if (const auto found = reported_.find(name); found != reported_.end()) return {found->second};
  if (name == "timestamp") return {time_};
  if (name == "actual_q") return list(q_);
  if (name == "target_q") return list(motion_ == Motion::servo ? target_ : q_);
  if (name == "actual_qd" || name == "target_qd") return list(qd_);
  if (name == "actual_TCP_pose" || name == "target_TCP_pose") return pose();
  if (name == "robot_mode") return number(robot_mode_);
  if (name == "safety_mode" || name == "safety_status") return number(safety_mode_);
  if (name == "runtime_state")
    return number(program_ == Program::playing  ? int{playing}
                  : program_ == Program::paused ? int{paused}
                                                : int{stopped});
  if (name == "robot_status_bits")
    return number((robot_mode_ >= idle ? 1 : 0) | (program_ == Program::playing ? 2 : 0));
  if (name == "safety_status_bits")
    return number((safety_mode_ == safety_normal) | (safety_mode_ == protective_stop) << 2 |
                  (safety_mode_ == safeguard_stop) << 4 | (safety_mode_ == robot_emergency) << 6 |
                  emergency << 7);
  if (name == "speed_scaling" || name == "target_speed_fraction") return {slider_};
  if (name == "actual_digital_input_bits") return number(inputs_);
  if (name == "actual_digital_output_bits") return number(outputs_);
  if (name == "standard_analog_output0") return {analog_[0]};
  if (name == "standard_analog_output1") return {analog_[1]};
  if (name == "joint_mode") return std::vector<double>(6, 253);
  if (name == "target_gravity") return {0, 0, 9.82};
  if (name == "actual_main_voltage" || name == "actual_robot_voltage") return {48};
  if (name == "joint_temperatures") return std::vector<double>(6, 25);
  if (const auto found = registers_.find(name); found != registers_.end()) return {found->second};
  return {};
}

void Machine::input(std::string_view name, double value) {
  auto& where = name.starts_with("input_") ? registers_ : asked_;
  where.insert_or_assign(std::string(name), value);
}

void Machine::apply_inputs() {
  const auto asked = [this](const std::string& name) {
    const auto found = asked_.find(name);
    return found == asked_.end() ? 0.0 : found->second;
  };
  const auto bits = [&](const std::string& name) { return static_cast<unsigned>(asked(name)); };
  if (bits("speed_slider_mask") & 1) slider_ = std::clamp(asked("speed_slider_fraction"), 0.0, 1.0);
  constexpr std::pair<const char*, int> kGroups[] = {
      {"standard_digital_output", 0}, {"configurable_digital_output", 8}, {"tool_digital_output", 16}};
  for (const auto& [name, first] : kGroups)
    for (int bit = 0; bit < 8; ++bit)
      if (bits(std::string(name) + "_mask") >> bit & 1) digital_output(first + bit, bits(name) >> bit & 1);
  for (std::size_t i = 0; i < 2; ++i)
    if (bits("standard_analog_output_mask") >> i & 1)
      analog_[i] = asked("standard_analog_output_" + std::to_string(i));
  std::erase_if(asked_, [](const auto& one) { return one.first.ends_with("_mask"); });
}

}  // namespace polyarm::ur
