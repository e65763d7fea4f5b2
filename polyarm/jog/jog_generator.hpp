#pragma once
/// Jogging: joints or the tool centre point (TCP) follow a wish that may change at any time. The motion keeps
/// every limit and can always stop in time. Metres, radians, seconds; poses and twists in the world.
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "polyarm/base/pose.hpp"
#include "polyarm/jog/barriers.hpp"
#include "polyarm/jog/jog_axis.hpp"
#include "polyarm/jog/jog_hold.hpp"
#include "polyarm/jog/jog_line.hpp"
#include "polyarm/jog/tcp_lead.hpp"
#include "polyarm/jog/twist.hpp"
#include "polyarm/jog/twist_solver.hpp"
#include "polyarm/kinematics/chain.hpp"
#include "polyarm/moves/workspace.hpp"
#include "polyarm/trajectory/state_to_state.hpp"

namespace polyarm::jog {

/// The wish for the next cycles.
struct JogSetpoint {
  /// rest: slow down and stop. joint_velocity, tcp_velocity: move at this velocity. joint_target, tcp_target:
  /// go there, then follow the target's velocity.
  enum class Kind : std::uint8_t { rest, joint_velocity, joint_target, tcp_velocity, tcp_target };
  Kind kind = Kind::rest;
  bool tool_frame = false;  ///< the twist of tcp_velocity is in the tool's axes and turns with them
  bool at_once = false;     ///< for rest: every joint brakes as hard as it can, even off the path
  JogValues joints{};       ///< rad/s or m/s; or targets, rad or m
  JogValues joint_speed{};  ///< for joint_target: velocity of the target
  Twist twist{};            ///< of the TCP; for tcp_target: velocity of the target
  Pose target;              ///< of the TCP
  double speed = 1;         ///< for targets: fraction of the highest speed, (0, 1]
};

/// Limits of the generator. They may change at any time; a motion that is then too fast slows down.
struct JogLimits {
  double joint_share = 1;    ///< fraction of the joints' velocity limits, (0, 1]
  double tcp_speed = 1e9;    ///< m/s
  double tcp_turning = 1e9;  ///< rad/s, for requested TCP motion
  bool reduced = false;      ///< zones of the reduced profile count, not those of the full one
};

/// Call step() once in each cycle, then read the commanded joint values. Use from one thread. start(), step()
/// and the queries do not allocate, lock, throw or read a clock.
///
/// A TCP wish goes through a lead (TcpLead) and becomes joint velocities (TwistSolver). A velocity in one
/// direction is followed on a line (JogLine), which slows the motion down before limits instead of bending it.
/// Other velocities are reduced in time before joint limits, workspace boundaries and barriers. The joints
/// follow by jerk-limited steps. A step is accepted only if every joint can still brake within its limits after it, and the TCP
/// stays in the workspace meanwhile. Otherwise it is reduced, down to braking, which the previous cycle has
/// checked to be possible.
class JogGenerator {
 public:
  /// `axes`: limits of all joints of the chain, which must outlive the generator. `period`: of a cycle, s.
  /// Throws Error("too-many-joints") beyond kMostJogJoints.
  JogGenerator(const kinematics::Chain& chain, std::vector<AxisLimits> axes, moves::Workspace workspace,
               double period);

  std::size_t joints() const noexcept { return axes_.size(); }
  const std::vector<AxisLimits>& axes() const noexcept { return axes_; }
  const moves::Workspace& workspace() const noexcept { return workspace_; }

  /// Starts at rest at `q`.
  void start(std::span<const double> q) noexcept;
  void step(const JogSetpoint& wish, const JogLimits& limits) noexcept;
  /// What is near, for the next steps; null: nothing. It stays valid until the next call.
  void set_barriers(const Barriers* barriers) noexcept { barriers_ = barriers; }

  const AxisState& axis(std::size_t joint) const noexcept { return state_[joint]; }
  bool standing() const noexcept;
  /// For a target: true if it is reached.
  bool arrived() const noexcept { return arrived_; }
  JogHold hold() const noexcept { return hold_; }
  /// The joint or zone that holds the motion back; -1: none.
  std::int32_t which() const noexcept { return which_; }
  /// The pose and velocity of the TCP after the last step.
  Pose tcp() const noexcept { return {solver_.position(), solver_.rotation()}; }
  double tcp_speed() const noexcept { return tcp_speed_; }

 private:
  using States = std::array<AxisState, kMostJogJoints>;
  /// The fractions of the joints' limits for slowing down before a limit.
  struct Before {
    double acceleration, jerk;
  };
  static constexpr Before kFirmly{0.5, 0.25}, kGently{0.25, 0.05};

  void setpoint_joints(const JogSetpoint& wish, const JogLimits& limits, JogValues& rates) noexcept;
  bool step_straight(std::span<const trajectory::MotionState> to,
                     std::span<const trajectory::MotionLimits> limits, States& next) noexcept;
  bool step_to_joints(const JogSetpoint& wish, const JogLimits& limits, States& next) noexcept;
  void setpoint_tcp(const JogSetpoint& wish, const JogLimits& limits, JogValues& rates) noexcept;
  Twist twist_now() const noexcept;
  void tell(const TwistSolver::Solution& solution) noexcept;
  double throttle(const JogLimits& limits, Before before, bool common, JogValues& rates) noexcept;
  void follow(const JogValues& rates, const JogLimits& limits, States& next) noexcept;
  void guard(const JogLimits& limits, States& next) noexcept;
  /// What a motion may come near to: a barrier, or a boundary of the workspace.
  struct Limit {
    double room = 0;       ///< m, rad
    JogValues gradient{};  ///< of the room, by joint
    JogHold hold = JogHold::none;
    std::size_t which = 0;
    bool slides = false;  ///< a translation of the TCP slides along it
    bool turns = false;   ///< a rotation of the TCP does
  };
  std::size_t near_limits() const noexcept {
    return (barriers_ ? barriers_->count : 0) + workspace_.boundaries();
  }
  bool find_limit(std::size_t i, const JogValues& q, Limit& out) const noexcept;
  double share_before(const Limit& limit, std::span<const double> rates, double a,
                      double jerk) const noexcept;
  double closing_of(const Limit& limit, std::span<const double> rates) const noexcept;
  void slide_joints(JogValues& rates) noexcept;
  bool slide_tcp(Twist& wanted) noexcept;
  bool begin_line(const JogSetpoint& wish, const Twist& wanted, double size) noexcept;
  bool setpoint_on_line(const JogSetpoint& wish, const Twist& wanted, const JogLimits& limits,
                        JogValues& rates) noexcept;
  Twist error_on_line() const noexcept;
  void rates_on_line(JogValues& rates) noexcept;
  bool brake_on_line(const JogLimits& limits, States& out) noexcept;
  JogLine::Stop stop_ahead(std::span<const double> tangent) const noexcept;
  JogLine::Stop barrier_ahead(std::span<const double> tangent) const noexcept;
  struct Pull {
    double acceleration, jerk;
  };
  Pull pull_of(std::span<const double> rates, Before before) const noexcept;
  JogValues positions() const noexcept;
  struct Ahead;
  void look_ahead(const States& from, bool looks_at_tcp, Ahead& out) noexcept;
  void note(JogHold hold, std::size_t which) noexcept;
  AxisLimits limits_of(std::size_t joint, const JogLimits& limits) const noexcept;

  const kinematics::Chain& chain_;
  std::vector<AxisLimits> axes_;
  std::vector<double> velocity_, acceleration_, jerk_, lower_, upper_;  // inputs of the solver
  std::vector<double> gentle_acceleration_, gentle_jerk_;
  moves::Workspace workspace_;
  double dt_, length_ = 1;
  TwistSolver solver_;
  TcpLead lead_;
  JogLine line_;  // that the lead is on
  trajectory::StateToState to_joints_;

  const Barriers* barriers_ = nullptr;
  States state_{};
  JogSetpoint::Kind kind_ = JogSetpoint::Kind::rest;
  JogValues rates_{}, wanted_{};  // rates_: of the last cycle; wanted_: the wanted rates
  JogValues rates_before_{};      // of the cycle before that
  Twist asked_{};
  JogValues soon_{};   // the joints after this cycle, for which solver_ is set
  Twist line_wish_{};  // the direction of line_ as it was asked for
  bool line_of_tool_ = false;
  bool rates_hold_ = false;  // rates_ belongs to the same wish as the next cycle
  JogHold hold_ = JogHold::none;
  std::int32_t which_ = -1;
  bool arrived_ = false;
  bool reduced_ = false;  // JogLimits::reduced of this cycle
  double tcp_speed_ = 0;
};

}  // namespace polyarm::jog
