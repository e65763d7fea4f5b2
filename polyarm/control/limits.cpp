#include "polyarm/control/limits.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace polyarm::control {

namespace {
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
/// A planned step may touch its limit exactly; rounding must not count as a clamp.
constexpr double kSlack = 1 + 1e-6;
}  // namespace

void CommandLimits::build(const hardware::InterfaceTable& table,
                          const std::vector<controllers::JointFacts>& joints, Nanoseconds period) {
  positions_.clear();
  velocities_.clear();
  for (const controllers::JointFacts& joint : joints) {
    if (const auto command = table.find_command(joint.name + "/position")) {
      const auto state = table.find_state(joint.name + "/position");
      positions_.push_back({static_cast<std::uint32_t>(*command),
                            state ? static_cast<std::int32_t>(*state) : -1, joint.lower, joint.upper,
                            joint.velocity * seconds(period) * kSlack, kNone});
    }
    if (const auto command = table.find_command(joint.name + "/velocity"))
      velocities_.push_back({static_cast<std::uint32_t>(*command), joint.velocity * kSlack, kNone});
  }
}

void CommandLimits::note(std::uint64_t cycle, std::uint32_t command, double asked, double given) noexcept {
  ++clamps_;
  last_ = {cycle, static_cast<std::int32_t>(command), asked, given};
}

void CommandLimits::restrict(std::span<double> commands, std::span<const double> states,
                             std::uint64_t cycle) noexcept {
  for (Position& p : positions_) {
    const double asked = commands[p.command];
    if (std::isnan(asked) && std::isnan(p.given)) continue;  // never commanded
    if (std::isnan(p.given))
      p.given = p.state >= 0 && std::isfinite(states[static_cast<std::size_t>(p.state)])
                    ? states[static_cast<std::size_t>(p.state)]
                    : asked;
    double given = std::isfinite(asked) ? asked : p.given;
    given = std::clamp(given, std::min(p.lower, p.given), std::max(p.upper, p.given));
    given = std::clamp(given, p.given - p.step, p.given + p.step);
    if (given != asked) note(cycle, p.command, asked, given);
    commands[p.command] = p.given = given;
  }
  for (Velocity& v : velocities_) {
    const double asked = commands[v.command];
    if (std::isnan(asked) && std::isnan(v.given)) continue;
    const double given = std::isfinite(asked) ? std::clamp(asked, -v.limit, v.limit) : 0.0;
    if (given != asked) note(cycle, v.command, asked, given);
    commands[v.command] = v.given = given;
  }
}

}  // namespace polyarm::control
