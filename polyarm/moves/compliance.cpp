#include "polyarm/moves/compliance.hpp"

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
constexpr double kStands = 1e-4;        // rad/s or m/s
constexpr double kShareOfLimits = 0.3;  // of the joints' velocities

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

/// The way that the tool yields is bounded, and so are the velocities of the joints. A joint that meets a
/// limit of its range stays there.
void Compliance::keep_within(const Joints& path, double period) noexcept {
  const SixVector& x = rule_->displacement();
  const double gone = std::hypot(x[0], x[1], x[2]);
  const SixVector& v = rule_->twist();
  const bool outwards = x[0] * v[0] + x[1] * v[1] + x[2] * v[2] > 0;
  const bool bound = gone > settings_.reach && outwards;
  at_bound_.store(gone > 0.99 * settings_.reach, std::memory_order_relaxed);
  double fast = 0;
  for (std::size_t j = 0; j < put_.size(); ++j)
    fast = std::max(fast, std::abs(rule_->velocity()[j]) / (kShareOfLimits * limits_[j].velocity));
  for (std::size_t j = 0; j < put_.size(); ++j) {
    const double before = put_[j] - path.position[j];
    const double most = bound ? 0 : kShareOfLimits * limits_[j].velocity * period;
    if (bound || fast > 1) rule_->bound(j, before - most, before + most);
    rule_->bound(j, chain_.lower()[j] - path.position[j], chain_.upper()[j] - path.position[j]);
  }
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
