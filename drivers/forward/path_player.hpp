#pragma once
/// The motion of a simulated controller: a queue of moves, trapezoids of speed on their paths, and rounded
/// corners. rad, m, s. One thread.
#include <array>
#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include "drivers/wire/six_axes.hpp"
#include "polyarm/base/pose.hpp"
#include "polyarm/hardware/forward_moves.hpp"

namespace polyarm::forward {

using wire::Six;

/// A move as a controller gets it.
struct PlayedMove {
  hardware::ForwardMove::Kind kind = hardware::ForwardMove::Kind::joint;
  int number = 0;
  Six goal{};                     ///< joints of the end; a line or an arc may have `end` instead
  std::optional<Pose> end;        ///< of the TCP in the base
  Six via{};                      ///< joints of the point on the way of an arc; or `via_point`
  std::optional<Vec3> via_point;  ///< in the base
  double share = 0;               ///< above 0, of a joint move: of the joints' speeds, instead of `speed`
  double acceleration = 0;        ///< rad/s² of the joint that turns most, or m/s²; a share with `share`
  double speed = 0;               ///< rad/s of that joint, or m/s
  double time = 0;                ///< s; above 0 it replaces speed and acceleration of a line or an arc
  /// s, of a joint move; above 0 it replaces the speed, and `acceleration` is a share.
  double joint_time = 0;
  double turn = 0;                ///< rad/s; above 0 it is the speed of a line on which the TCP only turns
  double blend = 0;               ///< m before the end
  double blend_share = 0;         ///< above 0: of half of the way, instead of `blend`
};

/// The arm that a controller moves.
struct PlayedArm {
  std::function<const Six&()> q;
  std::function<bool()> still, may_move;
  std::function<void(const Six&)> follow;                           ///< to this place in the next step
  std::function<void()> refuse;                                     ///< a path that the arm cannot follow
  std::function<void(int)> ended;                                   ///< the move with this number ended
  std::function<Pose(const Six&, std::array<double, 36>&)> flange;  ///< and its Jacobian, by rows
  Six velocity{}, acceleration{};                                   ///< of the joints, for shares of them
};

/// The arm of a simulated controller that counts in degrees, without `q` and `refuse`; `speed_up`: s, of a
/// joint to its full speed. Machine has still(), may_move(), drive() and options() with AxisFacts.
template <class Machine>
PlayedArm arm_in_degrees(Machine& machine, int& ended, double speed_up) {
  PlayedArm out;
  out.still = [&machine] { return machine.still(); };
  out.may_move = [&machine] { return machine.may_move(); };
  out.follow = [&machine](const Six& next) { machine.drive(wire::scaled(next, wire::kDegrees)); };
  out.ended = [&ended](int number) { ended = number; };
  out.flange = [&machine](const Six& q, std::array<double, 36>& J) {
    return machine.options().facts.tool_flange->jacobian(q, J);
  };
  out.velocity = wire::scaled(machine.options().facts.velocity, wire::kRadians);
  out.acceleration = wire::scaled(out.velocity, 1 / speed_up);
  return out;
}

/// A move runs at its speed and acceleration on its way. With a blend it ends that far before its corner and
/// goes on, on a curve in joint space, into the next move as far behind the corner. The pace scales time. The
/// shape of a blend and the ramps are ours: the makers state neither.
class PathPlayer {
 public:
  static constexpr double kPaceRamp = 0.2;  ///< s from 0 to 1

  PathPlayer(PlayedArm arm, std::size_t slots) : arm_(std::move(arm)), slots_(slots) {}
  void set_tool(const Pose& T_flange_tcp) { tool_ = T_flange_tcp; }
  /// False: there is no room for the move.
  bool take(const PlayedMove& move);
  /// No move follows the last one for now: unless it is under way, it ends at rest.
  void end_last();
  /// The pace goes towards this share of 1.
  void change_pace(double share, double dt);
  /// One step of the controller; the arm moves after it.
  void step(double dt);
  /// The move under way begins again from where the arm comes to rest.
  void interrupt() { part_ = ahead_ = {}; }
  /// All moves are forgotten. The caller brakes the arm.
  void forget();
  std::size_t waiting() const { return waiting_.size(); }

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
  bool shape(const PlayedMove& move, const Six& from, Part& out) const;
  bool shape_path(const PlayedMove& move, const Six& from, std::vector<Six>& out) const;
  void set_speeds(const PlayedMove& move, Part& out) const;
  void set_joint_speeds(const PlayedMove& move, Part& out) const;
  static double speed_for(double time, double way, double acceleration);
  double way_of_tcp(const Part& part) const;
  void cut_end(double blend, Part& part) const;
  bool round_corner(const Part& before, double blend, Part& next) const;
  void slow_down(Part& part, double last) const;
  Pose tcp(const Six& q) const;
  void end_part();

  PlayedArm arm_;
  std::size_t slots_;
  Pose tool_;
  std::deque<PlayedMove> waiting_;  ///< the first one is under way if part_ is
  Part part_, ahead_;               ///< ahead_: the whole next move, for a blend
  double way_ = 0, speed_ = 0, pace_ = 1;
};

}  // namespace polyarm::forward
