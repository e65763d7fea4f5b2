#pragma once
/// Real hardware moves after a person has armed it, and slowly at first.
#include <span>
#include <string>
#include <vector>

#include "polyarm/base/pose.hpp"
#include "polyarm/control/control_loop.hpp"
#include "polyarm/setup/observer.hpp"
#include "polyarm/setup/robots.hpp"

namespace polyarm::cell {

/// What of a cell is real, whether it is armed, and how fast it may go. Cell thread. Loop, robots and
/// observer outlive it.
class Arming {
 public:
  /// Finds the real components and slows the loop down unless `full_speed`. Nothing happens in a cell without
  /// real hardware.
  Arming(control::ControlLoop& loop, const CellRobots& robots, bool full_speed, Observer& observer);

  /// Tells what waits for a person, where its joints are, and how to arm it. Once the cell can be reached
  /// from other terminals and before its loop begins.
  void announce() const;

  /// Real components; empty for a cell without.
  const std::vector<std::size_t>& components() const { return components_; }
  bool needed() const { return !components_.empty(); }
  bool armed() const { return components_.empty() || armed_; }
  bool may_be_enabled(std::size_t component) const { return armed() || !is_real(component); }
  /// Throws Error("disarmed") for a real component that nobody has armed. Asked before one is enabled.
  void require_armed(std::size_t component) const;
  /// After a reload: what was simulated and is real now waits for a person like everything real.
  void look_again();

  /// What a person sees before arming: each joint, where it is measured and where the cell expects it.
  struct Expected {
    std::string joint;
    double measured, expected;  ///< rad or m; measured is NaN where nothing is measured yet
  };
  /// `states`: of the interface table, or of a snapshot.
  std::vector<Expected> expected_positions(std::span<const double> states) const;
  /// Throws Error("unverified") for a robot whose facts nobody accepted.
  void require_verified() const;
  void set_armed(Nanoseconds now);
  Nanoseconds armed_at() const { return armed_at_; }

  /// The limits profile of the cell: at reduced speed until it is another, real hardware or not.
  void set_profile(bool reduced, double tcp_speed, double joint_share);
  /// At reduced speed: by the profile, or real hardware before its program has run through once.
  bool reduced() const { return reduced_ || profile_reduced_; }
  /// Real hardware before its program has run through once.
  bool first_pass() const { return reduced_; }
  /// Reduced speed, every tick: the share of the planned speed falls at once where a TCP is too fast, rises
  /// slowly while something moves, and waits low while all stands, so that no motion begins too fast. `tcps`:
  /// places of the TCPs in the world, m. `commands`: of a snapshot. `passed`: the program has run through
  /// once, which ends it. `planned`: what moves was planned within these speeds, and goes as planned unless a
  /// TCP is too fast all the same.
  void govern(Nanoseconds now, const std::vector<Vec3>& tcps, std::span<const double> commands, bool passed,
              bool planned);

 private:
  void set_share(double of_path, double of_joints);
  void slow_down();
  double joint_share() const;
  bool is_real(std::size_t component) const;
  bool stands(double fastest, std::span<const double> commands);

  control::ControlLoop& loop_;
  const CellRobots& robots_;
  Observer& observer_;
  std::vector<std::size_t> components_;
  bool full_speed_;
  bool armed_ = false, reduced_ = false, profile_reduced_ = false, planned_ = false;
  double profile_tcp_ = 0.25, profile_joint_ = 0.1;
  double share_ = 1;  ///< of the planned speed, at reduced speed
  std::vector<Vec3> tcps_before_;
  std::vector<double> commands_before_;
  Nanoseconds before_ = 0, armed_at_ = 0;
};

}  // namespace polyarm::cell
