#include "polyarm/jog/jog_controller.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "polyarm/base/error.hpp"

namespace polyarm::jog {
namespace {
using controllers::CallbackReturn;
using controllers::ReturnType;
using Kind = JogSetpoint::Kind;

/// A step ends if it is held back and at standstill for this long, ns.
constexpr Nanoseconds kGivesUp = 200'000'000;
/// Extrapolation of a moving target, s.
constexpr double kThinkOn = 0.05;
/// Limits of the way out of a contact.
constexpr JogLimits kOut{0.05, 0.02, 0.1};
}  // namespace

JogController::JogController(const kinematics::Chain& chain, std::vector<controllers::JointFacts> joints,
                             moves::Workspace workspace)
    : chain_(chain), facts_(std::move(joints)), workspace_(std::move(workspace)) {}

CallbackReturn JogController::on_configure(controllers::ControllerContext& context) {
  joints_.clear();
  std::vector<AxisLimits> axes;
  bool any = false;
  for (const controllers::JointFacts& joint : facts_) {
    Joint out;
    if (context.has_command(joint.name + "/position"))
      out.position = static_cast<int>(claim_command(joint.name + "/position"));
    else if (context.has_command(joint.name + "/velocity"))
      out.velocity = static_cast<int>(claim_command(joint.name + "/velocity"));
    if (context.has_state(joint.name + "/position"))
      out.measured = static_cast<int>(claim_state(joint.name + "/position"));
    any = any || out.position >= 0 || out.velocity >= 0;
    joints_.push_back(out);
    axes.push_back({joint.lower, joint.upper, joint.velocity,
                    std::min(joint.acceleration, joint.deceleration), joint.jerk});
  }
  if (!any)
    throw Error("no-jog", "the joints of " + context.robot + " take neither positions nor velocities",
                "`polyarm interfaces` lists what its hardware takes");
  generator_.emplace(chain_, std::move(axes), workspace_, seconds(context.period));
  return CallbackReturn::success;
}

CallbackReturn JogController::on_activate(const hardware::Cycle& cycle) noexcept {
  std::array<double, kMostJogJoints> q{};
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    q[j] = joints_[j].position >= 0 ? command(static_cast<std::size_t>(joints_[j].position)) : NAN;
    if (!std::isfinite(q[j]) && joints_[j].measured >= 0)
      q[j] = state(static_cast<std::size_t>(joints_[j].measured));
    if (!std::isfinite(q[j])) return CallbackReturn::error;
  }
  generator_->start({q.data(), joints_.size()});
  barriers_.fetch();  // those of an earlier session
  generator_->set_barriers(nullptr);
  touching_ = false;
  inbox_.fetch();
  command_ = {};
  ended_ = std::max(ended_, session_);
  session_ = 0;
  standing_ = true;
  write(cycle);
  return CallbackReturn::success;
}

void JogController::on_deactivate(const hardware::Cycle&) noexcept {
  for (const Joint& joint : joints_)
    if (joint.velocity >= 0) set_command(static_cast<std::size_t>(joint.velocity), 0);
}

/// True if the session of the command may move now.
bool JogController::holds(const hardware::Cycle& cycle, const controllers::Verdict& verdict) noexcept {
  const std::uint32_t session = command_.session;
  if (session == 0 || session <= ended_) return false;
  const bool may = verdict.speed > 0 || verdict.held;
  const bool fresh = session != session_;
  if (!may || command_.stops != verdict.stop_requests || (!fresh && stops_ != verdict.stops) ||
      release_now_.load(std::memory_order_acquire) >= session) {
    ended_ = session;
    return false;
  }
  if (fresh) stops_ = verdict.stops;
  session_ = session;
  return cycle.time - received_ <= command_.hold;
}

void JogController::begin_step() noexcept {
  const JogSetpoint last = step_setpoint_;
  const bool on_top = step_done_ != step_begun_ && last.kind == command_.wish.kind;
  step_setpoint_ = command_.wish;
  step_begun_ = command_.step;
  blocked_since_ = -1;
  for (std::size_t j = 0; j < joints_.size(); ++j)
    step_setpoint_.joints[j] = (on_top ? last.joints[j] : generator_->axis(j).position) + command_.wish.joints[j];
  Pose from = on_top ? last.target : generator_->tcp();
  const Twist& by = command_.wish.twist;
  Vec3 shift{by[0], by[1], by[2]}, turn{by[3], by[4], by[5]};
  if (command_.wish.tool_frame) {
    shift = from.rotation * shift;
    turn = from.rotation * turn;
  }
  const double angle = norm(turn);
  from.position = from.position + shift;
  if (angle > 0) from.rotation = normalized(from_axis_angle((1 / angle) * turn, angle) * from.rotation);
  step_setpoint_.target = from;
  step_setpoint_.twist = {};
  step_setpoint_.joint_speed = {};
}

/// The wish in this cycle, from the valid command.
JogSetpoint JogController::setpoint_now(const hardware::Cycle& cycle) const noexcept {
  if (command_.by) return step_done_ == step_begun_ ? JogSetpoint{} : step_setpoint_;
  JogSetpoint wish = command_.wish;
  const double age = std::min(seconds(cycle.time - received_), kThinkOn);
  if (wish.kind == Kind::joint_target)
    for (std::size_t j = 0; j < joints_.size(); ++j) wish.joints[j] += age * wish.joint_speed[j];
  if (wish.kind == Kind::tcp_target) {
    const Twist& v = wish.twist;
    const Vec3 turn{age * v[3], age * v[4], age * v[5]};
    wish.target.position = wish.target.position + age * Vec3{v[0], v[1], v[2]};
    if (const double angle = norm(turn); angle > 0)
      wish.target.rotation = normalized(from_axis_angle((1 / angle) * turn, angle) * wish.target.rotation);
  }
  return wish;
}

ReturnType JogController::update(const hardware::Cycle& cycle, const controllers::Verdict& verdict) noexcept {
  if (inbox_.fetch()) {
    command_ = inbox_.value();
    received_ = cycle.time;
  }
  if (barriers_.fetch()) {
    generator_->set_barriers(&barriers_.value());
    touching_ = barriers_.value().touching;
  }
  const bool good = holds(cycle, verdict);
  JogSetpoint wish;
  if (good) {
    if (command_.by && command_.step != step_begun_) begin_step();
    wish = setpoint_now(cycle);
  } else {
    wish.at_once = verdict.immediate;
    step_done_ = step_begun_;
  }
  JogLimits now = limits();
  if (touching_)
    now = {std::min(now.joint_share, kOut.joint_share), std::min(now.tcp_speed, kOut.tcp_speed),
           std::min(now.tcp_turning, kOut.tcp_turning), now.reduced};
  generator_->step(wish, now);
  standing_ = !(good && wish.kind != Kind::rest) && generator_->standing();
  if (good && command_.by && step_done_ != step_begun_) {
    const bool stands = generator_->standing() || generator_->tcp_speed() < 1e-6;
    const bool blocked = generator_->hold() != JogHold::none && stands;
    if (!blocked) blocked_since_ = -1;
    if (blocked && blocked_since_ < 0) blocked_since_ = cycle.time;
    const bool gives_up = blocked && cycle.time - blocked_since_ > kGivesUp;
    if (generator_->arrived() || gives_up) {
      step_done_ = step_begun_;
      step_hold_ = generator_->arrived() ? JogHold::none : generator_->hold();
      step_which_ = generator_->arrived() ? -1 : generator_->which();
    }
  }
  write(cycle);
  return ReturnType::ok;
}

void JogController::write(const hardware::Cycle& cycle) noexcept {
  JogStatus& status = outbox_.draft();
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const AxisState& axis = generator_->axis(j);
    if (joints_[j].position >= 0) set_command(static_cast<std::size_t>(joints_[j].position), axis.position);
    if (joints_[j].velocity >= 0) set_command(static_cast<std::size_t>(joints_[j].velocity), axis.velocity);
    status.joints[j] = axis.position;
  }
  status.time = cycle.time;
  status.session = standing_ && session_ <= ended_ ? 0 : session_;
  status.ended = ended_;
  status.step = step_done_;
  status.standing = standing_;
  status.step_hold = step_hold_;
  status.step_which = step_which_;
  status.hold = generator_->hold();
  status.which = generator_->which();
  status.tcp = generator_->tcp();
  status.tcp_speed = generator_->tcp_speed();
  outbox_.publish();
}

}  // namespace polyarm::jog
