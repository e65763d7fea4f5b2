#pragma once
/// Keys that are held in a browser: the clients and messages of the pendant's port for the held motions of a
/// cell.
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "polyarm/operation/held_motions.hpp"
#include "polyarm/protocol/session.hpp"

namespace polyarm::server {

/// Cell thread. A motion belongs to the client that began it.
class JogWatch {
 public:
  /// Sends client `to` an event, or the reply to the request that began it, as a line.
  using Send = std::function<void(std::uint64_t to, const std::string& line)>;

  JogWatch(cell::HeldMotions& motions, Send send) : motions_(motions), send_(std::move(send)) {}

  /// Answered {jog: number} once it moves, or with why not. Throws Error for what makes no sense.
  void begin(std::uint64_t client, const protocol::Any& id, const protocol::JogBegin& request);
  /// The same towards a place.
  void go_to(std::uint64_t client, const protocol::Any& id, const protocol::JogGoto& request);
  /// A heartbeat; of one that is over it does nothing.
  void beat(std::uint64_t client, std::uint64_t jog);
  /// `why`: "released", "lost", "control", "gone".
  void end(std::uint64_t client, std::uint64_t jog, const char* why);
  /// All of the client's.
  void end_all(std::uint64_t client, const char* why);
  /// Reports what has become of them.
  void tick();
  /// The same motion by an amount, as the cell's request.
  protocol::JogMotion step(const protocol::JogStep& request) const { return motions_.step(request); }

 private:
  struct Jog {
    std::uint64_t motion = 0, client = 0;
    protocol::Any id;
  };
  bool owns(std::uint64_t client, std::uint64_t jog) const;
  void report(const Jog& jog, const cell::HeldEvent& event) const;

  cell::HeldMotions& motions_;
  Send send_;
  std::vector<Jog> jogs_;
};

/// The way of a jog.goto, only planned.
protocol::PlanPreview way_of(const protocol::JogGoto& request);

}  // namespace polyarm::server
