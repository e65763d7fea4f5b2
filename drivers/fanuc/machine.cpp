#include "drivers/fanuc/machine.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "drivers/wire/six_axes.hpp"

namespace polyarm::fanuc {

namespace {

constexpr double kStillSpeed = 0.01;                     // degrees/s
constexpr double kReadyFalls = 0.3, kButtonShows = 0.5;  // s after an emergency stop
constexpr double kSlowEnd = 0.6;  // of the limits of acceleration and jerk, at full Cartesian speed

Six radians(const Six& degrees) {
  Six out;
  for (std::size_t i = 0; i < 6; ++i) out[i] = degrees[i] / wire::kDegrees;
  return out;
}

}  // namespace

MachineFacts facts_of(const description::RobotModel& model) {
  const wire::AxisFacts axes = wire::axis_facts(model, "fanuc/crx_10ia_l", wire::kDegrees);
  MachineFacts out;
  out.model = axes.model;
  out.lower = axes.lower;
  out.upper = axes.upper;
  out.velocity = axes.velocity;
  const auto joints = wire::six_revolute_joints(model, "fanuc/crx_10ia_l");
  for (std::size_t i = 0; i < 6; ++i) {
    out.acceleration[i] = joints[i]->limits.acceleration.value_or(7) * wire::kDegrees;
    out.jerk[i] = joints[i]->limits.jerk.value_or(90) * wire::kDegrees;
  }
  out.chain = std::make_shared<const kinematics::Chain>(model, axes.flange);
  out.world_height = out.chain->axes().at(1).point.z;
  return out;
}

Machine::Machine(MachineOptions options)
    : options_(std::move(options)), q_(options_.start), commanded_(q_), last_q_(q_) {}

void Machine::drive(const Six& joints) {
  for (std::size_t i = 0; i < 6; ++i) jump_ = std::max(jump_, std::abs(joints[i] - commanded_[i]));
  commanded_ = joints;
}

void Machine::step(double dt) {
  time_ += dt;
  last_q_ = q_;
  speed_ = 0;
  for (std::size_t i = 0; i < 6; ++i) {
    q_[i] += (commanded_[i] - q_[i]) * dt / (options_.lag + dt);
    if (std::abs(commanded_[i] - q_[i]) < 1e-9) q_[i] = commanded_[i];
    speed_ = std::max(speed_, std::abs(q_[i] - last_q_[i]) / dt);
  }
  for (const auto& [output, input] : wires_) set_input(input, this->output(output));
}

bool Machine::moving() const {
  return speed_ > kStillSpeed;
}

void Machine::emergency(bool on) {
  if (on && !emergency_) {
    emergency_since_ = time_;
    alarm("SRVO-002 Teach pendant E-stop");
  }
  emergency_ = on;
}

void Machine::fence(bool open) {
  fence_ = open;
  if (open) alarm("SRVO-004 Fence open");
}

void Machine::teach(TeachMode mode) {
  mode_ = mode;
}

void Machine::touch() {
  contact_ = ContactStop::stop;
  alarm("SYST-320 Contact stop");
}

void Machine::alarm(const std::string& text) {
  if (alarm_.empty()) alarm_ = text;
}

bool Machine::reset() {
  if (emergency_ || fence_) return false;
  alarm_.clear();
  contact_ = ContactStop::none;
  return true;
}

void Machine::push_by_hand(const Six& change) {
  for (std::size_t i = 0; i < 6; ++i) q_[i] += change[i];
  commanded_ = q_;
}

std::uint8_t Machine::robot_bits() const {
  const bool shown = emergency_ && time_ - emergency_since_ > kButtonShows;
  return static_cast<std::uint8_t>((alarm_.empty() ? 0 : error_bit) |
                                   (mode_ == TeachMode::automatic ? 0 : teach_bit) |
                                   (shown ? emergency_bit : 0));
}

bool Machine::may_move() const {
  if (mode_ != TeachMode::automatic || fence_ || contact_ == ContactStop::stop) return false;
  if (emergency_) return time_ - emergency_since_ < kReadyFalls;
  return alarm_.empty();
}

void Machine::set_input(int port, bool on) {
  if (valid(port)) inputs_[static_cast<std::size_t>(port - 1)] = on;
}

void Machine::set_output(int port, bool on) {
  if (valid(port)) outputs_[static_cast<std::size_t>(port - 1)] = on;
}

std::array<double, 6> Machine::pose_values(const Pose& pose) {
  const Vec3 wpr = to_rpy(pose.rotation);
  return {1000 * pose.position.x, 1000 * pose.position.y, 1000 * pose.position.z,
          wpr.x * wire::kDegrees, wpr.y * wire::kDegrees, wpr.z * wire::kDegrees};
}

Pose Machine::pose_of(const std::array<double, 6>& v) {
  return {{v[0] / 1000, v[1] / 1000, v[2] / 1000},
          from_rpy(v[3] / wire::kDegrees, v[4] / wire::kDegrees, v[5] / wire::kDegrees)};
}

Pose Machine::flange(const Six& joints) const {
  if (!options_.facts.chain) return {};
  Pose out = options_.facts.chain->forward(radians(joints));
  out.position.z -= options_.facts.world_height;
  return out;
}

std::optional<Six> Machine::joints_for(const Pose& flange, const Six& seed) const {
  constexpr double kDamping = 1e-6, kMostStep = 0.3, kClose = 1e-7;
  if (!options_.facts.chain) return std::nullopt;
  Pose target = flange;
  target.position.z += options_.facts.world_height;
  Six q = radians(seed);
  std::array<double, 36> J;
  for (int round = 0; round < 60; ++round) {
    const Pose now = options_.facts.chain->jacobian(q, J);
    const Vec3 way = target.position - now.position;
    const Vec3 turn = to_rotation_vector(target.rotation * inverse(now.rotation));
    Eigen::Matrix<double, 6, 1> error;
    error << way.x, way.y, way.z, turn.x, turn.y, turn.z;
    if (error.norm() < kClose) {
      Six out;
      for (std::size_t i = 0; i < 6; ++i) {
        out[i] = q[i] * wire::kDegrees;
        if (out[i] < options_.facts.lower[i] || out[i] > options_.facts.upper[i]) return std::nullopt;
      }
      return out;
    }
    const Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>> matrix(J.data());
    const Eigen::Matrix<double, 6, 6> square =
        matrix.transpose() * matrix + kDamping * Eigen::Matrix<double, 6, 6>::Identity();
    Eigen::Matrix<double, 6, 1> step = square.ldlt().solve(matrix.transpose() * error);
    if (const double size = step.norm(); size > kMostStep) step *= kMostStep / size;
    for (std::size_t i = 0; i < 6; ++i) q[i] += step[static_cast<Eigen::Index>(i)];
  }
  return std::nullopt;
}

LimitTable Machine::limits(int axis, LimitKind kind) const {
  LimitTable out;
  out.axis = static_cast<std::uint32_t>(axis);
  out.kind = kind;
  const auto i = static_cast<std::size_t>(axis - 1);
  const MachineFacts& facts = options_.facts;
  const double full = i >= 6                            ? 1
                      : kind == LimitKind::velocity     ? facts.velocity[i]
                      : kind == LimitKind::acceleration ? facts.acceleration[i]
                                                        : facts.jerk[i];
  for (std::size_t k = 0; k < kLimitSteps; ++k) {
    const double place = static_cast<double>(k) / (kLimitSteps - 1);
    const bool velocity = kind == LimitKind::velocity;
    const double limit = velocity ? full : full * options_.table_share * (1 - (1 - kSlowEnd) * place);
    out.empty[k] = static_cast<float>(limit);
    out.loaded[k] = static_cast<float>(velocity ? limit : limit * options_.loaded_share);
  }
  return out;
}

}  // namespace polyarm::fanuc
