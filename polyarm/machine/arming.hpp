#pragma once
/// Arming: real hardware moves only after a person has armed it, and at reduced speed at first.
#include <span>
#include <string>
#include <vector>

#include "polyarm/base/pose.hpp"
#include "polyarm/control/control_loop.hpp"
#include "polyarm/setup/observer.hpp"
#include "polyarm/setup/robots.hpp"

namespace polyarm::cell {

/// Knows which components are real, whether they are armed, and how fast the cell may move. Cell thread.
/// Loop, robots and observer must outlive this object.
class Arming {
 public:
  /// Finds the real components and reduces the loop's speed unless `full_speed`. Has no effect in a cell
  /// without real hardware.
  Arming(control::ControlLoop& loop, const CellRobots& robots, bool full_speed, Observer& observer);

  /// Reports which components wait for arming, their joint positions, and how to arm them. Call when the cell
  /// can be reached from other terminals and before its loop begins.
  void announce() const;

  /// The real components; empty if there are none.
  const std::vector<std::size_t>& components() const { return components_; }
  bool needed() const { return !components_.empty(); }
  bool armed() const { return components_.empty() || armed_; }
  bool may_be_enabled(std::size_t component) const { return armed() || !is_real(component); }
  /// Throws Error("disarmed") if the component is real and not armed. Call before a component is enabled.
  void require_armed(std::size_t component) const;
  /// Call after a reload: a component that was simulated and is real now must be armed, too.
  void look_again();

  /// Shown to a person before arming: each joint with its measured position and the one that the cell
  /// expects.
  struct Expected {
    std::string joint;
    double measured, expected;  ///< rad or m; measured is NaN if nothing was measured yet
  };
  /// `states`: of the interface table or of a snapshot.
  std::vector<Expected> expected_positions(std::span<const double> states) const;
  /// Throws Error("unverified") if the facts of a robot were not accepted by a person.
  void require_verified() const;
  void set_armed(Nanoseconds now);
  Nanoseconds armed_at() const { return armed_at_; }

  /// Sets the limits profile of the cell; `reduced` applies with and without real hardware. `tcp_speed` in
  /// m/s.
  void set_profile(bool reduced, double tcp_speed, double joint_share);
  /// True at reduced speed: by the profile, or because real hardware has not completed its first program
  /// pass.
  bool reduced() const { return reduced_ || profile_reduced_; }
  /// True for real hardware before its program has completed one pass.
  bool first_pass() const { return reduced_; }
  /// Controls the share of the planned speed at reduced speed; call each tick. The share drops at once if a
  /// TCP is too fast, rises slowly during motion, and stays low at standstill, so no motion starts too fast.
  /// `tcps`: TCP positions in the world, m. `commands`: of a snapshot. `passed`: the program has completed
  /// one pass, which ends reduced speed. `planned`: the motion was planned within these limits and runs
  /// unchanged unless a TCP is still too fast.
  void govern(Nanoseconds now, std::span<const Vec3> tcps, std::span<const double> commands, bool passed,
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
  double share_ = 1;  ///< share of the planned speed, at reduced speed
  std::vector<Vec3> tcps_before_;
  std::vector<double> commands_before_;
  Nanoseconds before_ = 0, armed_at_ = 0;
};

}  // namespace polyarm::cell
