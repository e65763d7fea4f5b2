#pragma once
/// Requests that stop the motion of a cell and resume it; and the contacts.
#include "polyarm/base/pose.hpp"
#include "polyarm/protocol/facts.hpp"
#include "polyarm/protocol/problem.hpp"

namespace polyarm::protocol {

/// The answer of a request that only starts something: its verb.
struct Asked {
  std::string asked;
  POLYARM_MEMBERS(Asked, asked)
};

struct ControlHold {
  static constexpr Facts kFacts{.name = "control.hold",
                                .role = Role::watch,
                                .text = "Stops on the path.",
                                .moves = true,
                                .urgent = true};
  using Answer = Asked;
  POLYARM_MEMBERS(ControlHold)
};

struct ControlStop {
  static constexpr Facts kFacts{
      .name = "control.stop",
      .role = Role::watch,
      .text =
          "Stops on the path as hard as the joints can. Category 1 then switches the drives off, "
          "category 2 (default) holds.",
      .moves = true,
      .urgent = true};
  std::optional<double> category;
  struct Answer {
    static constexpr const char* kOf = "ControlStop";
    std::string asked = "stop";
    int category = 2;
    std::optional<std::vector<std::string>> inactive;  ///< components that were switched off
    POLYARM_MEMBERS(Answer, asked, category, inactive)
  };
  POLYARM_MEMBERS(ControlStop, category)
};

struct ControlResume {
  static constexpr Facts kFacts{
      .name = "control.resume",
      .role = Role::operate,
      .text =
          "Continues along the path after a hold. Refused if the robot was moved meanwhile, or if it "
          "touches something that the motion would press against, unless `anyway`.",
      .moves = true};
  bool anyway = false;
  using Answer = Asked;
  POLYARM_MEMBERS(ControlResume, anyway)
};

struct ControlBack {
  static constexpr Facts kFacts{
      .name = "control.back",
      .role = Role::operate,
      .text =
          "During a hold, moves slowly back along the planned path, by `time` seconds of the plan (1) "
          "or by `distance`. Then it holds again.",
      .moves = true};
  std::optional<double> time, distance;
  struct Answer {
    static constexpr const char* kOf = "ControlBack";
    std::string asked = "back", state;
    std::map<std::string, double> joints;  ///< how far each joint has moved, rad or m
    POLYARM_MEMBERS(Answer, asked, state, joints)
  };
  POLYARM_MEMBERS(ControlBack, time, distance)
};

struct ControlOverride {
  static constexpr Facts kFacts{
      .name = "control.override",
      .role = Role::operate,
      .text =
          "Sets how much of the planned speed is used, 0 to 100 percent. Without `percent` it only "
          "returns the value. `allowed` is the share that arming allows now, 0 to 1.",
      .moves = true,
      .watch_without = "percent"};
  std::optional<double> percent;
  struct Answer {
    static constexpr const char* kOf = "ControlOverride";
    std::string asked = "override";
    double percent = 0, allowed = 0;
    POLYARM_MEMBERS(Answer, asked, percent, allowed)
  };
  POLYARM_MEMBERS(ControlOverride, percent)
};

struct ControlDiscard {
  static constexpr Facts kFacts{
      .name = "control.discard",
      .role = Role::operate,
      .text =
          "During a hold, discards the rest of the motion, and the position from which it would "
          "continue.",
      .moves = true};
  struct Answer {
    static constexpr const char* kOf = "ControlDiscard";
    std::string asked = "discard";
    bool discarded = false;  ///< true if a motion was left
    std::string next;
    POLYARM_MEMBERS(Answer, asked, discarded, next)
  };
  POLYARM_MEMBERS(ControlDiscard)
};

/// A contact of two bodies. m, world frame.
struct Touch {
  std::string a, b, robot;
  double at_s = 0, depth = 0;
  Vec3 position;
  bool now = false;
  std::string doing, where, text;
  POLYARM_MEMBERS(Touch, a, b, robot, at_s, depth, position, now, doing, where, text)
};

/// A body whose contacts nothing detects; code and facts let pages translate the sentence.
struct UncheckedBody {
  std::string code;
  FactValues facts;
  POLYARM_MEMBERS(UncheckedBody, code, facts)
};

struct ContactState {
  bool checked = false;  ///< true if contacts are detected in this cell
  OrNull<int> stop;      ///< the category of the stop after a contact
  bool touching = false;
  std::vector<std::string> unchecked;        ///< bodies whose contacts nothing detects, one sentence each
  std::vector<UncheckedBody> unchecked_why;  ///< codes and facts of these sentences, in the same order
  std::vector<Touch> list;                   ///< newest last
  POLYARM_MEMBERS(ContactState, checked, stop, touching, unchecked, unchecked_why, list)
};

struct Contacts {
  static constexpr Facts kFacts{
      .name = "contacts",
      .role = Role::watch,
      .text =
          "Returns past and present contacts in physics, with positions, and the bodies whose contacts "
          "are not detected."};
  using Answer = ContactState;
  POLYARM_MEMBERS(Contacts)
};

struct ControlRecover {
  static constexpr Facts kFacts{.name = "control.recover",
                                .role = Role::operate,
                                .text = "Changes the state from fault to held. Nothing moves.",
                                .moves = true};
  using Answer = Asked;
  POLYARM_MEMBERS(ControlRecover)
};

/// A finished stop.
struct StopFacts {
  double at_s = 0, time_s = 0;
  int category = 2;
  std::string cause, cause_code;
  std::map<std::string, double> tcp_m;   ///< by robot
  std::map<std::string, double> joints;  ///< rad or m
  POLYARM_MEMBERS(StopFacts, at_s, time_s, category, cause, cause_code, tcp_m, joints)
};

/// For each request about stopped motion, the reason why it is not possible now; null: possible.
struct PossibleNow {
  OrNull<ProblemFacts> resume, discard, back, recover, program;
  std::map<std::string, OrNull<ProblemFacts>> jog;  ///< by robot
  POLYARM_MEMBERS(PossibleNow, resume, discard, back, recover, program, jog)
};

}  // namespace polyarm::protocol
