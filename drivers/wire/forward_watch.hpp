#pragma once
/// What components share whose controller interpolates by itself (forward mode).
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/wire/six_axes.hpp"
#include "polyarm/base/error.hpp"

namespace polyarm::wire {

/// Finds commands of a controller that moves joints: the one that hands moves over commands the joints to be
/// where they are measured. Limits may hold such a command back after a gap in the measurements; it then
/// comes nearer from cycle to cycle. Control thread.
class ForwardWatch {
 public:
  void begin() noexcept { commanded_.fill(std::numeric_limits<double>::quiet_NaN()); }
  /// The first joint whose new command differs from its measured position; nothing if no joint differs.
  std::optional<int> strays(std::span<const double> commands, const Six& measured) noexcept {
    constexpr double kElsewhere = 0.1;  // rad
    for (std::size_t j = 0; j < 6; ++j) {
      const bool changed = std::isfinite(commands[j]) && commands[j] != commanded_[j];
      const double away = std::abs(commands[j] - measured[j]), before = std::abs(commanded_[j] - measured[j]);
      commanded_[j] = commands[j];
      if (changed && !(away < kElsewhere) && !(away < before)) return static_cast<int>(j);
    }
    return std::nullopt;
  }

 private:
  Six commanded_{};
};

/// Throws Error("bad-value") for a robot that `motion: forward` is not for: one that is carried, or whose
/// joints are not the six of the controller.
inline void check_forward(const hardware::RobotInstance& robot, const std::vector<std::string>& joints) {
  if (!robot.on.empty())
    throw Error("bad-value",
                "`motion: forward` is for robots that stand still; '" + robot.name + "' is carried",
                "set `motion: stream`");
  if (!robot.model || robot.model->joint_names() != joints)
    throw Error("bad-value",
                "`motion: forward` needs a robot whose joints are the six of the controller, in their order",
                "leave grippers with joints out of the description, or set `motion: stream`");
}

}  // namespace polyarm::wire
