#pragma once
/// The request about robots that lead others.
#include "polyarm/protocol/facts.hpp"

namespace polyarm::protocol {

struct TeleopPair {
  std::string name, leader, follower;
  std::string mapping;   ///< joints or tcp
  std::string clutch;    ///< key, tag or gripper
  std::string state;     ///< blocked, waiting, engaging, approaching or following
  std::string reason;    ///< why it is blocked, or what holds the follower back
  std::string furthest;  ///< while it approaches: the joint furthest from the leader's pose
  double distance = 0;   ///< of that joint, rad or m
  POLYARM_MEMBERS(TeleopPair, name, leader, follower, mapping, clutch, state, reason, furthest, distance)
};

struct Teleop {
  static constexpr Facts kFacts{
      .name = "teleop",
      .role = Role::operate,
      .text =
          "Returns the leaders and followers of the cell. With `hold`, it holds the clutch of a pair (of "
          "the only one without `pair`) for that many seconds; repeat it in time, and send 0 to release.",
      .moves = true,
      .watch_without = "hold"};
  std::optional<std::string> pair;
  std::optional<double> hold;
  struct Answer {
    static constexpr const char* kOf = "Teleop";
    std::vector<TeleopPair> pairs;
    POLYARM_MEMBERS(Answer, pairs)
  };
  POLYARM_MEMBERS(Teleop, pair, hold)
};

}  // namespace polyarm::protocol
