#include "polyarm/joint_control/asked_limits.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "polyarm/base/text.hpp"

namespace polyarm::controllers {

namespace {
const char* name_of(Asked kind) {
  constexpr const char* kNames[] = {"a position", "a velocity", "an acceleration", "an effort"};
  return kNames[static_cast<std::size_t>(kind)];
}
}  // namespace

void RequestedLimits::reset(std::size_t joints) {
  joints_.assign(joints, {});
  at_ = std::make_unique<std::atomic<double>[]>(joints);
  for (std::size_t j = 0; j < joints; ++j) note_position(j, std::numeric_limits<double>::quiet_NaN());
}

void RequestedLimits::set(std::size_t joint, std::string told, const JointFacts* facts) {
  Joint& out = joints_[joint];
  out.told = std::move(told);
  if (!facts) return;
  if (!facts->continuous && facts->lower <= facts->upper) out.lower = facts->lower, out.upper = facts->upper;
  if (facts->states_velocity) out.velocity = facts->velocity;
  if (facts->states_acceleration) out.acceleration = facts->acceleration;
  out.effort = facts->effort;
}

void RequestedLimits::check_position(Problems& problems, std::size_t j, double value,
                                 const std::string& where) const {
  const Joint& joint = joints_[j];
  double lower = std::max(joint.lower, -kMost), upper = std::min(joint.upper, kMost);
  const std::string limits = format_number(lower) + " to " + format_number(upper);
  if (const double at = position(j); std::isfinite(at)) lower = std::min(lower, at), upper = std::max(upper, at);
  if (value >= lower - kRounding && value <= upper + kRounding) return;
  problems.error("beyond-limits", {},
                 "'" + joint.told + "' gets a command for a position of " + format_number(value) + where +
                     "; its limits are " + limits,
                 "command a position within them, rad or m");
}

void RequestedLimits::check(Problems& problems, std::size_t j, Asked kind, double value,
                        const std::string& where) const {
  const Joint& joint = joints_[j];
  if (!std::isfinite(value))
    return problems.error("not-a-number", {},
                          "'" + joint.told + "' gets a command for " + name_of(kind) +
                              " that is not a finite number (" + format_number(value) + ")" + where);
  if (kind == Asked::position) return check_position(problems, j, value, where);
  const double limit = kind == Asked::velocity       ? joint.velocity
                       : kind == Asked::acceleration ? joint.acceleration
                                                     : joint.effort;
  if (std::abs(value) <= (limit > 0 ? std::min(kFarBeyond * limit, kMost) : kMost)) return;
  problems.error("beyond-limits", {},
                 "'" + joint.told + "' gets a command for " + name_of(kind) + " of " + format_number(value) +
                     where + (limit < kMost ? "; its limit is " + format_number(limit) : ""),
                 "a command a little above is limited; one far above is refused");
}

void RequestedLimits::require(std::size_t joint, Asked kind, double value) const {
  Problems problems;
  check(problems, joint, kind, value);
  problems.throw_if_errors();
}

}  // namespace polyarm::controllers
