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
  static constexpr Facts kFacts{.name = "jog",
                                .role = Role::operate,
                                .text =
                                    "move joints or the TCP by hand: with velocities {elbow_joint: 0.1} or "
                                    "{z: 0.02} in `frame` (base, world, "
                                    "tool or the name of a point) for `hold` seconds (0.25) unless it comes "
                                    "again with the `session` of the "
                                    "answer; with `by` it moves by that much, and the last answer comes when "
                                    "it is done; with `end` it ends",
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
  static constexpr Facts kFacts{
      .name = "jog.state", .role = Role::watch, .text = "where a robot is, and what holds it back"};
  std::optional<std::string> robot;
  using Answer = JogAnswer;
  POLYARM_MEMBERS(JogState, robot)
};

struct FollowTarget {
  static constexpr Facts kFacts{.name = "target",
                                .role = Role::operate,
                                .text =
                                    "go to joints or a pose {position, orientation or rpy}, again and again "
                                    "with the `session` of the answer: "
                                    "what a sensor or a hand streams becomes smooth motion, which ends "
                                    "`hold` seconds (0.25) after the last "
                                    "one",
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
      .text = "the limits profile of the cell, or another one: reduced (teaching) or full",
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
          "go to points on one path through all of them (with `rests` it comes to rest at each); a point is "
          "a name "
          "of the cell's data, {joints: …} or {pose: {position, rpy or orientation}}, with a `duration` that "
          "the way "
          "to it takes at least; `kind` is joint (default) or line, `pace` s for each rad of the way, "
          "`speed` a "
          "share of the limits. When the asker disconnects, the robot stops on the path",
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
