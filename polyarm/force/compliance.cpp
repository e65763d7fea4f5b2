#include "polyarm/force/compliance.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "polyarm/base/error.hpp"

namespace polyarm::moves {

using controllers::AdmittanceParameters;
using controllers::AdmittanceRule;
using controllers::SixVector;

namespace {
constexpr Nanoseconds kOldWrench = 100'000'000;
/// kg. On a hard contact the arm pushes with its own mass times the acceleration of this mass, and the answer
/// comes some cycles later: a mass much below that of the arm would chatter.
constexpr double kMass = 10;
constexpr double kResponse = 0.01;    // s, in which the velocity that a force makes is reached, or more
constexpr double kSmoothing = 0.004;  // s, of the wrench
constexpr double kHeld = 2e4;         // N/m: axes that do not yield come back to the path
constexpr double kJointDamping = 1;   // 1/s
constexpr double kInverseDamping = 1e-6;
constexpr double kStands = 1e-4;                     // rad/s or m/s
constexpr double kShareOfLimits = 0.3;               // of the joints' velocities
constexpr double kFastest = 0.25, kFastestTurn = 1;  // m/s, rad/s
constexpr double kBraking = 1, kTurnBraking = 10;    // m/s², rad/s²: before the end of the reach
constexpr double kRest = 0.03;  // s in which a velocity falls to a third when the robot yields no more

AdmittanceParameters parameters_of(const ComplianceSettings& settings) {
  AdmittanceParameters out;
  out.axes = settings.axes;
  out.joint_damping = kJointDamping;
  out.alpha = kInverseDamping;
  SixVector damping;
  for (std::size_t i = 0; i < 6; ++i) {
    const double arm = i < 3 ? 1 : ComplianceSettings::kRotation;
    out.mass[i] = arm * std::max(kMass, kResponse * settings.damping);
    out.stiffness[i] = arm * (settings.axes[i] ? settings.stiffness : kHeld);
    damping[i] = settings.axes[i] ? arm * settings.damping : 2 * std::sqrt(out.mass[i] * out.stiffness[i]);
  }
  out.damping = damping;
  return out;
}
}  // namespace

Compliance::Compliance(const description::RobotModel& model, const kinematics::Chain& chain,
                       std::span<const trajectory::JointMotionLimits> limits)
    : model_(model), chain_(chain), limits_(limits.begin(), limits.end()) {
  for (auto* values : {&last_, &put_}) values->assign(chain.joints(), 0.0);
}

void Compliance::begin(const ComplianceSettings& settings, std::span<const double> at) {
  const std::size_t n = chain_.joints();
  if (n > kMost) throw Error("bad-value", "this robot has too many joints to yield to forces");
  if (!rule_) {
    std::vector<std::size_t> joints(n);
    std::iota(joints.begin(), joints.end(), std::size_t{0});
    const int tool = model_.tool_link(), root = model_.root;
    rule_ = std::make_unique<AdmittanceRule>(
        model_, controllers::AdmittanceFrames{tool, root, tool, root, root}, std::move(joints));
  }
  settings_ = settings;
  yielding_ = resting_ = parameters_of(settings);
  resting_.axes = {};
  resting_.stiffness = {};
  resting_.damping = SixVector{};
  resting_.joint_damping = 1 / kRest;
  std::copy_n(at.begin(), std::min(at.size(), last_.size()), last_.begin());
  at_bound_ = stale_ = false;
  wanted_.store(true, std::memory_order_release);
}

void Compliance::start() noexcept {
  rule_->reset();
  running_.store(true, std::memory_order_release);
}

void Compliance::end() noexcept {
  if (running_.load(std::memory_order_relaxed)) std::copy(put_.begin(), put_.end(), last_.begin());
  standing_ = true;
  running_.store(false, std::memory_order_release);
}

void Compliance::drop() noexcept {
  wanted_.store(false, std::memory_order_release);
  end();
}

/// False if nobody knows what acts on the tool.
bool Compliance::feel(Nanoseconds now, SixVector& out) noexcept {
  wrench_.fetch();
  const Felt& felt = wrench_.value();
  const bool known = felt.time >= 0 && now - felt.time <= kOldWrench;
  stale_.store(!known, std::memory_order_relaxed);
  if (!known) return false;
  for (std::size_t i = 0; i < 6; ++i) out[i] = felt.wrench[i] + settings_.push[i];
  return true;
}

/// The way that the tool yields is bounded, and so are its velocity and those of the joints: all joints slow
/// down together, and before the end of the reach. A joint that meets a limit of its range stays there.
void Compliance::keep_within(const Joints& path, double period) noexcept {
  const SixVector &x = rule_->displacement(), &v = rule_->twist();
  double share = 1;
  const auto slow = [&share](double speed, double most) {
    if (speed > most) share = std::min(share, most / speed);
  };
  const auto stop_within = [&](std::size_t first, double most, double braking) {
    const double gone = std::hypot(x[first], x[first + 1], x[first + 2]);
    if (gone > 0)
      slow((x[first] * v[first] + x[first + 1] * v[first + 1] + x[first + 2] * v[first + 2]) / gone,
           std::sqrt(2 * braking * std::max(0.0, most - gone)));
    return gone > 0.99 * most;
  };
  const bool at_end = stop_within(0, settings_.reach, kBraking),
             turned = stop_within(3, settings_.most_turn(), kTurnBraking);
  at_bound_.store(at_end || turned, std::memory_order_relaxed);
  slow(std::hypot(v[0], v[1], v[2]), kFastest);
  slow(std::hypot(v[3], v[4], v[5]), kFastestTurn);
  for (std::size_t j = 0; j < put_.size(); ++j)
    slow(std::abs(rule_->velocity()[j]), kShareOfLimits * limits_[j].velocity);
  if (share < 1) rule_->slow_down(share, period);
  for (std::size_t j = 0; j < put_.size(); ++j)
    rule_->bound(j, chain_.lower()[j] - path.position[j], chain_.upper()[j] - path.position[j]);
}

controllers::MotionShift::Outcome Compliance::apply(const Request& request, const Joints& joints) noexcept {
  const std::size_t n = put_.size();
  if (!running_.load(std::memory_order_relaxed)) start();
  const std::span<const double> offset = rule_->offset();
  for (std::size_t j = 0; j < n; ++j) put_[j] = joints.position[j] + offset[j];
  const bool wanted = wanted_.load(std::memory_order_acquire);
  SixVector wrench{};
  const bool yields = feel(request.now, wrench) && wanted && request.speed > 0;
  yielding_.filter = resting_.filter = request.period / (request.period + kSmoothing);
  rule_->set(yields ? yielding_ : resting_);
  if (!rule_->update(put_, joints.position, wrench, request.period)) rule_->freeze();
  keep_within(joints, request.period);
  bool rests = true;
  for (std::size_t j = 0; j < n; ++j) {
    put_[j] = joints.position[j] + offset[j];
    rests = rests && std::abs(rule_->velocity()[j]) < kStands && std::abs(joints.velocity[j]) < kStands;
    joints.position[j] = put_[j];
    joints.velocity[j] += rule_->velocity()[j];
    joints.acceleration[j] += rule_->acceleration()[j];
  }
  standing_ = rests;
  if (wanted || !rests) return Outcome::shifted;
  for (std::size_t j = 0; j < n; ++j) joints.velocity[j] = joints.acceleration[j] = 0;
  end();
  return Outcome::ended;
}

}  // namespace polyarm::moves
