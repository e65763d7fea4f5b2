#pragma once
/// Requests that the pendant's port answers itself: about clients, control, and held jog keys.
#include <variant>

#include "polyarm/protocol/facts.hpp"
#include "polyarm/protocol/jog.hpp"
#include "polyarm/protocol/motion.hpp"
#include "polyarm/protocol/points.hpp"

namespace polyarm::protocol {

struct Nothing {
  POLYARM_MEMBERS(Nothing)
};

/// A client of the port.
struct ClientName {
  std::uint64_t client = 0;
  std::string name;
  POLYARM_MEMBERS(ClientName, client, name)
};

struct SessionHello {
  static constexpr Facts kFacts{.name = "session.hello",
                                .role = Role::watch,
                                .text = "Gives this client a name. Events are sent from now on.",
                                .session = true};
  std::optional<std::string> name;
  struct Answer {
    static constexpr const char* kOf = "SessionHello";
    std::uint64_t client = 0;
    OrNull<ClientName> holder;
    bool you_hold = false;
    std::string version;
    bool token_ok = true;
    OrNull<std::string> cell;
    bool local = false;
    Role role = Role::watch;
    POLYARM_MEMBERS(Answer, client, holder, you_hold, version, token_ok, cell, local, role)
  };
  POLYARM_MEMBERS(SessionHello, name)
};

struct SessionWatch {
  static constexpr Facts kFacts{
      .name = "session.watch",
      .role = Role::watch,
      .text = "Sends binary state frames, `rate` times a second (30, at most 60; 0: none).",
      .session = true};
  std::optional<double> rate;
  struct Answer {
    static constexpr const char* kOf = "SessionWatch";
    double rate = 0;
    POLYARM_MEMBERS(Answer, rate)
  };
  POLYARM_MEMBERS(SessionWatch, rate)
};

struct SessionEnd {
  static constexpr Facts kFacts{.name = "session.end",
                                .role = Role::watch,
                                .text = "Ends the request of this client with the id `of`.",
                                .session = true};
  std::optional<Any> of;
  using Answer = Nothing;
  POLYARM_MEMBERS(SessionEnd, of)
};

struct JogBeat {
  static constexpr Facts kFacts{.name = "jog.beat",
                                .role = Role::watch,
                                .text = "The heartbeat of a held key. It has no answer.",
                                .session = true};
  std::optional<Any> jog;
  using Answer = Nothing;
  POLYARM_MEMBERS(JogBeat, jog)
};

struct JogEnd {
  static constexpr Facts kFacts{
      .name = "jog.end",
      .role = Role::watch,
      .text = "Ends the motion `jog` of a released key; without `jog`, all of this client.",
      .session = true};
  std::optional<std::uint64_t> jog;
  using Answer = Nothing;
  POLYARM_MEMBERS(JogEnd, jog)
};

struct SessionTake {
  static constexpr Facts kFacts{
      .name = "session.take",
      .role = Role::watch,
      .text =
          "Takes control. The client that has control is asked first, unless this client is on the same "
          "machine and sets `force`.",
      .session = true};
  bool force = false;
  struct Answer {
    static constexpr const char* kOf = "SessionTake";
    bool you_hold = false;
    OrNull<ClientName> holder;
    double seconds = 0;  ///< until the holder loses control
    POLYARM_MEMBERS(Answer, you_hold, holder, seconds)
  };
  POLYARM_MEMBERS(SessionTake, force)
};

struct ControlHolder {
  bool you_hold = false;
  OrNull<ClientName> holder;
  POLYARM_MEMBERS(ControlHolder, you_hold, holder)
};

struct SessionRelease {
  static constexpr Facts kFacts{
      .name = "session.release", .role = Role::watch, .text = "Gives control up.", .session = true};
  using Answer = ControlHolder;
  POLYARM_MEMBERS(SessionRelease)
};

struct SessionAnswer {
  static constexpr Facts kFacts{.name = "session.answer",
                                .role = Role::watch,
                                .text = "Answers a client that asks for control: gives it, or keeps it.",
                                .session = true};
  bool give = false;
  using Answer = ControlHolder;
  POLYARM_MEMBERS(SessionAnswer, give)
};

struct JogBegun {
  std::uint64_t jog = 0;  ///< number of the motion, for beats
  std::uint32_t session = 0;
  double beat_s = 0, silence_s = 0;  ///< interval of the heartbeats, and the time without one after which the
                                     ///< robot stops
  POLYARM_MEMBERS(JogBegun, jog, session, beat_s, silence_s)
};

struct JogBegin {
  static constexpr Facts kFacts{
      .name = "jog.begin",
      .role = Role::operate,
      .text =
          "Begins to move while a key is held. `mode` is joint, tcp or drive (a mobile base: axis 0 "
          "ahead, 1 to the left). `axis` is the number of one axis, or a list with a fraction in [-1, "
          "1] for each. The answer comes when the robot moves.",
      .moves = true,
      .session = true};
  std::optional<std::string> robot, mode, frame;
  Any axis;
  std::optional<double> direction, speed;
  using Answer = JogBegun;
  POLYARM_MEMBERS(JogBegin, robot, mode, frame, axis, direction, speed)
};

struct JogGoto {
  static constexpr Facts kFacts{
      .name = "jog.goto",
      .role = Role::operate,
      .text =
          "Moves to joint values or a pose {p, q} while a key is held. `kind` is joint or line. Refused "
          "if there is no path. With `dry` it only plans, like `plan.preview`.",
      .moves = true,
      .watch_with = "dry",
      .session = true};
  std::optional<std::string> robot, to;
  std::optional<Map> joints, pose;
  std::optional<MoveKind> kind;
  std::optional<double> speed;
  bool dry = false;
  using Answer = std::variant<JogBegun, PlanPreview::Answer>;
  POLYARM_MEMBERS(JogGoto, robot, to, joints, pose, kind, speed, dry)
};

struct JogStep {
  static constexpr Facts kFacts{
      .name = "jog.step",
      .role = Role::operate,
      .text = "Moves by `amount` (rad or m). The other arguments are those of `jog.begin`.",
      .moves = true,
      .session = true};
  std::optional<std::string> robot, mode, frame;
  Any axis;
  std::optional<double> direction, amount, speed;
  using Answer = JogAnswer;
  POLYARM_MEMBERS(JogStep, robot, mode, frame, axis, direction, amount, speed)
};

struct CellChange {
  static constexpr Facts kFacts{.name = "cell.change",
                                .role = Role::administer,
                                .text = "Builds the cell anew with another `model` for `robot`.",
                                .moves = true,
                                .session = true};
  std::optional<std::string> robot, model, folder;
  using Answer = Asked;
  POLYARM_MEMBERS(CellChange, robot, model, folder)
};

struct CellOpen {
  static constexpr Facts kFacts{.name = "cell.open",
                                .role = Role::administer,
                                .text = "Opens the cell in `folder`.",
                                .moves = true,
                                .session = true};
  std::optional<std::string> robot, model, folder;
  using Answer = Asked;
  POLYARM_MEMBERS(CellOpen, robot, model, folder)
};

struct CellReset {
  static constexpr Facts kFacts{.name = "cell.reset",
                                .role = Role::administer,
                                .text = "Builds the cell anew from its files.",
                                .moves = true,
                                .session = true};
  std::optional<std::string> robot, model, folder;
  using Answer = Asked;
  POLYARM_MEMBERS(CellReset, robot, model, folder)
};

}  // namespace polyarm::protocol
