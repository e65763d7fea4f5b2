#pragma once
/// The moves of the simulated controller: a queue as in the driver's program, and motions with trapezoids of
/// speed and rounded corners. rad, m, s. One thread.
#include <deque>
#include <vector>

#include "drivers/ur/machine.hpp"
#include "drivers/ur/move_script.hpp"

namespace polyarm::ur {

/// A move runs at its speed and acceleration on its way. With a blend it ends `blend` before its corner and
/// goes on, on a curve in joint space, into the next move as far behind the corner. The speed slider scales
/// time, and takes kSliderRamp to change. A joint that exceeds its limit is a protective stop. The shape of a
/// blend and the ramp are ours: the maker states neither.
class FarMoves {
 public:
  static constexpr double kSliderRamp = 0.2;  ///< s from 0 to 1

  explicit FarMoves(Machine& machine) : machine_(machine) {}
  /// A program begins.
  void begin();
  /// False: there is no room for the move.
  bool take(const MoveMessage& message);
  /// One step of the controller; the machine moves after it.
  void step(double dt);
  /// The program pauses: the move under way begins again from where the robot comes to rest.
  void interrupt() { part_ = ahead_ = {}; }
  /// The program ends: all moves are forgotten. The caller brakes the robot.
  void forget();

 private:
  /// A move, or what is left of one from the middle of a blend on.
  struct Part {
    std::vector<Six> q;
    std::vector<double> at, limit;  ///< way in joint space, rad, and the highest speed there, rad/s
    double acceleration = 1;        ///< rad/s² along the way
    bool under_way() const { return !q.empty(); }
    double length() const { return at.empty() ? 0 : at.back(); }
  };

  bool start();
  bool prepare_end();
  bool shape(const MoveMessage& move, const Six& from, Part& out) const;
  bool shape_path(const MoveMessage& move, const Six& from, std::vector<Six>& out) const;
  void set_speeds(const MoveMessage& move, Part& out) const;
  void cut_end(const MoveMessage& move, Part& part) const;
  bool round_corner(const Part& before, double blend, Part& next) const;
  void slow_down(Part& part, double last) const;
  Pose tcp(const Six& q) const;
  void end_part();

  Machine& machine_;
  Pose tool_;
  std::deque<MoveMessage> waiting_;  ///< the first one is under way if part_ is
  Part part_, ahead_;                ///< ahead_: the whole next move, for a blend
  double way_ = 0, speed_ = 0, pace_ = 1;
  int halting_ = 0;  ///< number of the halt that is under way; 0: none
};

}  // namespace polyarm::ur
