#pragma once
/// Motion by hand: joints or the tool centre point (TCP) go where they are pushed, at any moment, within
/// every limit, and can always still stop in time. Metres, radians, seconds, poses and twists in the world.
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "polyarm/base/pose.hpp"
#include "polyarm/jog/jog_axis.hpp"
#include "polyarm/jog/tcp_lead.hpp"
#include "polyarm/jog/twist.hpp"
#include "polyarm/jog/twist_solver.hpp"
#include "polyarm/kinematics/chain.hpp"
#include "polyarm/moves/workspace.hpp"
#include "polyarm/trajectory/state_to_state.hpp"

namespace polyarm::jog {

/// What is wanted of the next cycles.
struct JogWish {
  /// rest: slow down and stand. joint_velocity, tcp_velocity: go on like this. joint_target, tcp_target: get
  /// there, and from there on with the target's velocity.
  enum class Kind : std::uint8_t { rest, joint_velocity, joint_target, tcp_velocity, tcp_target };
  Kind kind = Kind::rest;
  bool tool_frame = false;  ///< the twist of tcp_velocity is in the tool's axes, which turn with it
  bool at_once = false;     ///< rest: every joint brakes as hard as it may, path or not
  JogValues joints{};       ///< rad/s or m/s; or targets, rad or m
  JogValues joint_speed{};  ///< of joint_target: the target's own velocity
  Twist twist{};            ///< of the TCP; of tcp_target: the target's own velocity
  Pose target;              ///< of the TCP
  double speed = 1;         ///< of targets: share of the greatest speed, (0, 1]
};

/// What holds a motion back.
enum class JogHold : std::uint8_t {
  none,
  speed,        ///< a limit of speed: of a joint, or of the TCP
  singularity,  ///< damped, or joint by joint, or in the way
  direction,    ///< the arm has too few joints for it
  joint_limit,  ///< `which`: the joint
  workspace,    ///< `which`: the zone
};
inline constexpr int kJogHolds = 6;
/// "joint limit"
const char* name(JogHold hold);

/// What the generator keeps to. Shares and speeds may be changed at any time; who is faster then slows down.
struct JogLimits {
  double joint_share = 1;    ///< of the joints' velocities, (0, 1]
  double tcp_speed = 1e9;    ///< m/s
  double tcp_turning = 1e9;  ///< rad/s, of what is asked of the TCP
};

/// Once each cycle: step(), and then where every joint has to be. One thread; no allocation, no locks, no
/// exceptions, no clock in start(), step() and what only reads.
///
/// What is wanted of the TCP leads it (TcpLead), becomes joint velocities (TwistSolver), those are slowed
/// down in time before joint limits and workspace boundaries along the way, and joints go there by
/// jerk-limited steps. Each step is taken only if from its end every joint can still brake within its limits
/// and the TCP stays where it may be meanwhile; else as much of it as that allows, down to braking, which was
/// found to be possible in the cycle before.
class JogGenerator {
 public:
  /// `axes`: limits of all joints of the chain, which outlives the generator. `period`: of a cycle, s. Throws
  /// Error("too-many-joints") beyond kMostJogJoints.
  JogGenerator(const kinematics::Chain& chain, std::vector<AxisLimits> axes, moves::Workspace workspace,
               double period);

  std::size_t joints() const noexcept { return axes_.size(); }
  const std::vector<AxisLimits>& axes() const noexcept { return axes_; }
  const moves::Workspace& workspace() const noexcept { return workspace_; }

  /// At rest at `q`.
  void start(std::span<const double> q) noexcept;
  void step(const JogWish& wish, const JogLimits& limits) noexcept;

  const AxisState& axis(std::size_t joint) const noexcept { return state_[joint]; }
  bool standing() const noexcept;
  /// Of a target: is it reached?
  bool arrived() const noexcept { return arrived_; }
  JogHold hold() const noexcept { return hold_; }
  /// The joint or zone that holds back; -1: none.
  std::int32_t which() const noexcept { return which_; }
  /// Where the TCP is, m and rotation, and how fast, as of the last step.
  Pose tcp() const noexcept { return {solver_.position(), solver_.rotation()}; }
  double tcp_speed() const noexcept { return tcp_speed_; }

 private:
  using States = std::array<AxisState, kMostJogJoints>;
  /// What a motion slows down with before a limit, of what joints may.
  struct Before {
    double acceleration, jerk;
  };
  static constexpr Before kFirmly{0.5, 0.25}, kGently{0.25, 0.05};

  void wish_joints(const JogWish& wish, const JogLimits& limits, JogValues& rates) noexcept;
  bool step_straight(std::span<const trajectory::MotionState> to,
                     std::span<const trajectory::MotionLimits> limits, States& next) noexcept;
  bool step_to_joints(const JogWish& wish, const JogLimits& limits, States& next) noexcept;
  void wish_tcp(const JogWish& wish, const JogLimits& limits, JogValues& rates) noexcept;
  Twist twist_now() const noexcept;
  void tell(const TwistSolver::Solution& solution) noexcept;
  double throttle(const JogLimits& limits, Before before, bool common, JogValues& rates) noexcept;
  void follow(const JogValues& rates, const JogLimits& limits, States& next) noexcept;
  void guard(const JogLimits& limits, States& next) noexcept;
  struct Ahead;
  void look_ahead(const States& from, Ahead& out) noexcept;
  void note(JogHold hold, std::size_t which) noexcept;
  AxisLimits limits_of(std::size_t joint, const JogLimits& limits) const noexcept;

  const kinematics::Chain& chain_;
  std::vector<AxisLimits> axes_;
  std::vector<double> velocity_, acceleration_, jerk_, lower_, upper_;  // for the solver
  std::vector<double> gentle_acceleration_, gentle_jerk_;
  moves::Workspace workspace_;
  double dt_, length_ = 1;
  TwistSolver solver_;
  TcpLead lead_;
  trajectory::StateToState to_joints_;

  States state_{};
  JogWish::Kind kind_ = JogWish::Kind::rest;
  JogValues rates_{}, wanted_{};  // of the last cycle; what was wanted of them
  Twist asked_{};
  bool rates_hold_ = false;  // rates_ is of the same wish as the next
  JogHold hold_ = JogHold::none;
  std::int32_t which_ = -1;
  bool arrived_ = false;
  double tcp_speed_ = 0;
};

}  // namespace polyarm::jog
