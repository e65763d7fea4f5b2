#pragma once
/// Keys that are held in a browser: motion goes on for as long as heartbeats come, and for a moment longer.
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "polyarm/cell/cell.hpp"
#include "polyarm/protocol/session.hpp"

namespace polyarm::server {

/// Cell thread. Works through the cell's `jog` requests: each is good for kSilence, and each heartbeat asks
/// again. So the controller brings the robot to rest by itself when nothing more comes, whoever has died.
class JogWatch {
 public:
  /// Rest begins so long after the last heartbeat, s.
  static constexpr double kSilence = 0.12;

  /// Sends client `to` an event, or the reply to the request that began it, as a line.
  using Tell = std::function<void(std::uint64_t to, const std::string& line)>;

  JogWatch(cell::Cell& cell, Tell tell) : cell_(cell), tell_(std::move(tell)) {}

  /// Answered {jog: number} once it moves, or with why not. Throws Error for what makes no sense.
  void begin(std::uint64_t client, const protocol::Any& id, const protocol::JogBegin& request);
  /// The same towards a place. The way is planned first; where there is none it is refused with the reason, and nothing
  /// moves. Else the joints go there, or the TCP in a straight line, and it is over when it stands there ("arrived").
  void go_to(std::uint64_t client, const protocol::Any& id, const protocol::JogGoto& request);
  /// A heartbeat; of one that is over it does nothing.
  void beat(std::uint64_t client, std::uint64_t jog);
  /// Brought to rest. `why`: "released", "lost", "control", "blur".
  void end(std::uint64_t client, std::uint64_t jog, const char* why);
  /// All of the client's.
  void end_all(std::uint64_t client, const char* why);
  void tick();
  bool any() const { return !jogs_.empty(); }

  /// The same motion by an amount, as the cell's request.
  protocol::JogMotion step(const protocol::JogStep& request) const;

 private:
  /// What holds a motion back now; all are empty if nothing does.
  struct HeldBack {
    std::string by, reason, which;
    bool operator==(const HeldBack&) const = default;
  };
  struct Jog {
    std::uint64_t number = 0, client = 0;
    std::size_t robot = 0;
    protocol::Any id;
    std::optional<protocol::Request> wish;  ///< what each heartbeat asks for
    std::uint32_t session = 0;
    Nanoseconds pressed = 0, beat = 0;
    bool asked = false, begun = false, over = false, beaten = false;
    std::optional<protocol::Request> rest;  ///< of a base with wheels: what brings it to rest
    bool goes = false;                      ///< to a place
    bool planning = false;                  ///< the way there, which is then
    bool planned = false;                   ///< and not yet asked for
    std::vector<double> joints;             ///< of that place; empty: it is `place`
    Pose place;
    HeldBack held_back, reported;
    std::optional<Error> refused;
  };
  std::size_t robot_of(const std::optional<std::string>& name) const;
  template <class Keys>
  protocol::JogMotion wish_of(std::size_t robot, const Keys& request, double amount, bool by) const;
  void drive(std::uint64_t client, const protocol::Any& id, std::size_t robot, const protocol::JogBegin& request);
  std::shared_ptr<Jog> begun_by(std::uint64_t client, const protocol::Any& id, std::size_t robot);
  void take_plan(Jog& jog, const protocol::PlanPreview::Answer& plan, bool line, double speed);
  bool is_there(const Jog& jog) const;
  void ask(const std::shared_ptr<Jog>& jog);
  void take_reply(Jog& jog, const protocol::Reply& reply) const;
  void finish(Jog& jog, const std::string& why, const std::string& text);
  void report(const Jog& jog, bool over, const std::string& why, const std::string& text,
              const std::string& which = {}) const;
  bool waits_for_rest(const std::shared_ptr<Jog>& jog);
  void follow(Jog& jog);

  cell::Cell& cell_;
  Tell tell_;
  std::vector<std::shared_ptr<Jog>> jogs_;
  std::shared_ptr<const bool> here_ = std::make_shared<const bool>(true);  ///< as long as it is there
  std::uint64_t last_ = 0;
};

/// The way of a jog.goto, only planned.
protocol::PlanPreview way_of(const protocol::JogGoto& request);

}  // namespace polyarm::server
