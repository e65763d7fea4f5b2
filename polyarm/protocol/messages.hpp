#pragma once
/// Requests about controllers' parameters, messages to controllers, and their outputs.
#include <variant>

#include "polyarm/protocol/facts.hpp"
#include "polyarm/protocol/motion.hpp"

namespace polyarm::protocol {

struct Parameter {
  std::string key, type, value, default_;
  bool changeable = false;
  std::string text;
  std::optional<std::vector<std::string>> choices;
  POLYARM_MEMBERS(Parameter, key, type, value, default_, changeable, text, choices)
};

struct ParamList {
  static constexpr Facts kFacts{
      .name = "param.list", .role = Role::watch, .text = "Lists the parameters of a controller."};
  std::string name;
  using Answer = std::vector<Parameter>;
  POLYARM_MEMBERS(ParamList, name)
};

struct ParamGet {
  static constexpr Facts kFacts{.name = "param.get", .role = Role::watch, .text = "Returns one parameter."};
  std::string name, key;
  using Answer = Parameter;
  POLYARM_MEMBERS(ParamGet, name, key)
};

struct ParamSet {
  static constexpr Facts kFacts{.name = "param.set",
                                .role = Role::administer,
                                .text = "Changes parameters between two cycles, all or none.",
                                .moves = true};
  std::string name;
  Map values;
  struct Answer {
    static constexpr const char* kOf = "ParamSet";
    std::size_t changed = 0;
    POLYARM_MEMBERS(Answer, changed)
  };
  POLYARM_MEMBERS(ParamSet, name, values)
};

struct SendMessage {
  static constexpr Facts kFacts{
      .name = "send",
      .role = Role::operate,
      .text =
          "Sends a message to a controller. A goal is followed until it ends: answers with {goal, "
          "feedback} come meanwhile, and the result at the end.",
      .moves = true};
  std::string to;
  Message message;
  bool goal = false;
  struct Answer {
    static constexpr const char* kOf = "SendMessage";
    std::optional<std::string> to;  ///< of a message that is not a goal
    std::optional<std::uint64_t> goal;
    std::optional<std::string> status;  ///< accepted, succeeded, aborted, canceled
    std::optional<int> error_code;
    std::optional<std::string> error;
    std::optional<std::string> joint;  ///< the joint that is off its goal
    std::optional<double> off_by, tolerance;
    std::optional<std::string> note;
    std::optional<double> position, effort;  ///< of a gripper
    std::optional<bool> stalled, reached_goal;
    std::optional<Any> feedback;  ///< a ROS message
    POLYARM_MEMBERS(Answer, to, goal, status, error_code, error, joint, off_by, tolerance, note, position,
                    effort, stalled, reached_goal, feedback)
  };
  POLYARM_MEMBERS(SendMessage, to, message, goal)
};

struct GoalCancel {
  static constexpr Facts kFacts{
      .name = "goal.cancel", .role = Role::operate, .text = "Cancels an active goal.", .moves = true};
  std::string to;
  double goal = 0;
  using Answer = Asked;
  POLYARM_MEMBERS(GoalCancel, to, goal)
};

struct QueryTrajectory {
  static constexpr Facts kFacts{
      .name = "query",
      .role = Role::watch,
      .text =
          "Returns the state of a controller's trajectory at a cell time in s; without a time, its "
          "present state."};
  std::string name;
  std::optional<double> at;
  struct Answer {
    static constexpr const char* kOf = "QueryTrajectory";
    std::vector<std::string> joints;
    bool found = false;
    std::vector<double> position, velocity, acceleration;
    POLYARM_MEMBERS(Answer, joints, found, position, velocity, acceleration)
  };
  POLYARM_MEMBERS(QueryTrajectory, name, at)
};

/// The reason why no message comes.
struct NoMessage {
  std::string waiting, state, what, advice;
  POLYARM_MEMBERS(NoMessage, waiting, state, what, advice)
};

struct WatchOutput {
  static constexpr Facts kFacts{
      .name = "watch",
      .role = Role::watch,
      .text =
          "Returns the output of a controller as its ROS message, `rate` times a second (10). With "
          "`patience`, one answer gives the reason if nothing has come for that many seconds."};
  std::string name;
  std::optional<double> rate, patience;
  using Answer = std::variant<Any, NoMessage>;
  POLYARM_MEMBERS(WatchOutput, name, rate, patience)
};

}  // namespace polyarm::protocol
