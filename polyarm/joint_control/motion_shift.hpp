#pragma once
/// A motion that is added to the one that a trajectory controller follows, such as that of a conveyor belt.
/// Radians or metres, per s, per s². Control thread.
#include <span>

#include "polyarm/base/time.hpp"

namespace polyarm::controllers {

class MotionShift {
 public:
  virtual ~MotionShift() = default;

  /// In: the joint states of the path in this cycle. Out: those to command.
  struct Joints {
    std::span<double> position, velocity, acceleration;
  };
  /// What the loop allows in this cycle: a share of the speed, 0: come to rest; immediate: harder than the
  /// limits.
  struct Request {
    Nanoseconds now = 0;
    double period = 0;  ///< s
    double speed = 1;
    bool immediate = false;
  };
  enum class Outcome { inactive, shifted, ended };

  /// True if the next apply() shifts.
  virtual bool active() const noexcept = 0;
  /// ended: the joints are at rest, and from now on the controller holds them where it put them in this
  /// cycle.
  virtual Outcome apply(const Request& request, const Joints& joints) noexcept = 0;
  /// True if the shifted joints are at rest.
  virtual bool standing() const noexcept = 0;
  /// The controller gave the motion up; the joints hold or brake by themselves.
  virtual void drop() noexcept = 0;
};

}  // namespace polyarm::controllers
