#pragma once
/// Requests about jogging, streamed targets, the limits profile, and moves to points.
#include <array>

#include "polyarm/base/pose.hpp"
#include "polyarm/protocol/facts.hpp"

namespace polyarm::protocol {

/// The pose of a robot, and what limits its jog; rad, m and m/s, world frame.
struct JogFacts {
  std::string robot, model, tool;
  std::vector<std::string> names;  ///< names of joints, in the robot's order
  std::vector<bool> slides;
  std::map<std::string, double> joints;
  std::map<std::string, OrNull<std::array<double, 2>>> limits;  ///< null: the joint is continuous
  Vec3 position, rpy;                                           ///< of the TCP
  Quaternion orientation;
  double speed = 0;
  bool moving = false;
  std::string held_back, reason;
  std::string which;  ///< the joint or the workspace zone that limits it; empty: neither
  std::string profile, control;
  POLYARM_MEMBERS(JogFacts, robot, model, tool, names, slides, joints, limits, position, rpy, orientation,
                  speed, moving, held_back, reason, which, profile, control)
};

struct JogAnswer : JogFacts {
  std::optional<std::uint32_t> session;
  std::optional<bool> done;  ///< of a step: the full amount was moved
  POLYARM_MORE_MEMBERS(JogAnswer, JogFacts, session, done)
};

struct JogMotion {
  static constexpr Facts kFacts{
      .name = "jog",
      .role = Role::operate,
      .text =
          "Moves joints or the TCP by hand. Velocities are {elbow_joint: 0.1} or {z: 0.02} in `frame` "
          "(base, world, tool or the name of a point). The motion ends after `hold` seconds (0.25) "
          "unless the request is repeated with the `session` of the answer. With `by`, the values are "
          "distances, and the last answer comes at the end of the motion. `end` ends the session.",
      .moves = true};
  std::optional<std::string> robot;
  std::optional<Map> joints, tcp;
  std::optional<std::string> frame;
  bool by = false;
  std::optional<double> speed, hold, session;
  bool end = false;
  using Answer = JogAnswer;
  POLYARM_MEMBERS(JogMotion, robot, joints, tcp, frame, by, speed, hold, session, end)
};

struct JogState {
  static constexpr Facts kFacts{.name = "jog.state",
                                .role = Role::watch,
                                .text = "Returns the pose of a robot, and what limits its jog."};
  std::optional<std::string> robot;
  using Answer = JogAnswer;
  POLYARM_MEMBERS(JogState, robot)
};

struct FollowTarget {
  static constexpr Facts kFacts{
      .name = "target",
      .role = Role::operate,
      .text =
          "Moves towards joint values or a pose {position, orientation or rpy}. Repeat it with the "
          "`session` of the answer: a stream of targets becomes smooth motion. The motion ends `hold` "
          "seconds (0.25) after the last target.",
      .moves = true};
  std::optional<std::string> robot;
  std::optional<Map> joints, pose;
  std::optional<std::string> frame;
  std::optional<double> speed, hold, session;
  using Answer = JogAnswer;
  POLYARM_MEMBERS(FollowTarget, robot, joints, pose, frame, speed, hold, session)
};

struct LimitsProfile {
  static constexpr Facts kFacts{
      .name = "profile",
      .role = Role::operate,
      .text =
          "Returns the limits profile of the cell, or changes it to `name`: reduced (for teaching) or "
          "full.",
      .moves = true,
      .watch_without = "name"};
  std::optional<std::string> name;
  struct Answer {
    static constexpr const char* kOf = "LimitsProfile";
    std::string profile;
    double joint_speed = 1;    ///< fraction of each joint's maximum
    OrNull<double> tcp_speed;  ///< m/s; null: no limit
    POLYARM_MEMBERS(Answer, profile, joint_speed, tcp_speed)
  };
  POLYARM_MEMBERS(LimitsProfile, name)
};

enum class MoveKind { joint, line };
template <>
struct Words<MoveKind> {
  static constexpr const char* kNoun = "kind of move";
  static constexpr const char* kWords[] = {"joint", "line"};
};

struct MoveTo {
  static constexpr Facts kFacts{
      .name = "move",
      .role = Role::operate,
      .text =
          "Moves to points on one path; with `rests` the robot stops at each point. A point is a name "
          "from the data of the cell, {joints: …} or {pose: {position, rpy or orientation}}; a pose may "
          "have a `frame`. A point may have a `duration`: the minimum time of the way to it. `kind` is joint "
          "(default) or line. "
          "`pace` is a time in s for each rad of the path, `speed` a fraction of the limits. If the "
          "client disconnects, the robot stops on the path.",
      .moves = true};
  Message points;
  std::optional<std::string> robot;
  std::optional<MoveKind> kind;
  std::optional<double> pace, speed;
  bool rests = false;
  struct Answer {
    static constexpr const char* kOf = "MoveTo";
    std::string robot, cell, cause;
    double elapsed_s = 0;
    OrNull<double> left_s, left_m;  ///< null: not planned yet
    std::optional<bool> done;
    POLYARM_MEMBERS(Answer, robot, cell, cause, elapsed_s, left_s, left_m, done)
  };
  POLYARM_MEMBERS(MoveTo, points, robot, kind, pace, speed, rests)
};

}  // namespace polyarm::protocol
