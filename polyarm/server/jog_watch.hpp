#pragma once
/// Keys that are held in a browser: motion goes on for as long as heartbeats come, and for a moment longer.
#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "polyarm/cell/cell.hpp"

namespace polyarm::server {

/// Cell thread. Works through the cell's `jog` requests: each is good for kSilence, and each heartbeat asks
/// again. So the controller brings the robot to rest by itself when nothing more comes, whoever has died.
class JogWatch {
 public:
  /// Rest begins so long after the last heartbeat, s.
  static constexpr double kSilence = 0.12;

  using Json = nlohmann::json;
  /// Tells client `to` an event, or an answer to the request that began it.
  using Tell = std::function<void(std::uint64_t to, const Json& message)>;

  JogWatch(cell::Cell& cell, Tell tell) : cell_(cell), tell_(std::move(tell)) {}

  /// `request`: {id?, robot?, mode: joint | tcp | drive (axis 0: ahead, 1: to the left, of a base), frame?,
  /// axis: number or six numbers, direction?, speed?}. It is answered {jog: number} once it moves, or with
  /// why not. Throws Error for what makes no sense.
  void begin(std::uint64_t client, const Json& request);
  /// The same towards a place: {id?, robot?, joints: {…} | pose: {p, q}, kind?: joint | line, speed?}. The
  /// way is planned first; where there is none it is refused with the reason, and nothing moves. Else the
  /// joints go there, or the TCP in a straight line, and it is over when it stands there ("arrived").
  void go_to(std::uint64_t client, const Json& request);
  /// A heartbeat; of one that is over it does nothing.
  void beat(std::uint64_t client, std::uint64_t jog);
  /// Brought to rest. `why`: "released", "lost", "control", "blur".
  void end(std::uint64_t client, std::uint64_t jog, const char* why);
  /// All of the client's.
  void end_all(std::uint64_t client, const char* why);
  void tick();
  bool any() const { return !jogs_.empty(); }

  /// The same motion by an amount, as the cell's request: {robot, mode, frame, axis, amount, speed} of
  /// `request`.
  Json step(const Json& request) const;

 private:
  struct Jog {
    std::uint64_t number = 0, client = 0;
    std::size_t robot = 0;
    Json id, wish;
    std::uint32_t session = 0;
    Nanoseconds beat = 0;
    bool asked = false, begun = false, over = false, beaten = false;
    bool drives = false;         ///< a base with wheels
    Json rest;                   ///< of those: what brings it to rest
    bool goes = false;           ///< to a place
    bool planning = false;       ///< the way there, which is then
    bool planned = false;        ///< and not yet asked for
    std::vector<double> joints;  ///< of that place; empty: it is `place`
    Pose place;
    Json held_back, told;  ///< {why, text, which} of what holds it back; null: nothing does
    std::string refused;
  };
  std::size_t robot_of(const Json& request) const;
  Json wish_of(std::size_t robot, const Json& request, double amount, bool by) const;
  void drive(std::uint64_t client, std::size_t robot, const Json& request);
  std::shared_ptr<Jog> begun_by(std::uint64_t client, std::size_t robot, const Json& request);
  void take_plan(Jog& jog, const Json& plan, bool line, double speed);
  bool is_there(const Jog& jog) const;
  void ask(const std::shared_ptr<Jog>& jog);
  void finish(Jog& jog, const std::string& why, const std::string& text);
  void follow(Jog& jog);

  cell::Cell& cell_;
  Tell tell_;
  std::vector<std::shared_ptr<Jog>> jogs_;
  std::shared_ptr<const bool> here_ = std::make_shared<const bool>(true);  ///< as long as it is there
  std::uint64_t last_ = 0;
};

}  // namespace polyarm::server
