#pragma once
/// Jog keys held in a browser: connects clients and messages of the pendant's port to the held motions of a
/// cell.
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "polyarm/operation/held_motions.hpp"
#include "polyarm/protocol/session.hpp"

namespace polyarm::server {

/// Cell thread. Each motion belongs to the client that started it.
class JogWatch {
 public:
  /// Sends a line to client `to`: an event, or the reply to the request that started the motion.
  using Send = std::function<void(std::uint64_t to, const std::string& line)>;

  JogWatch(cell::HeldMotions& motions, Send send) : motions_(motions), send_(std::move(send)) {}

  /// Starts a motion. The reply {jog: number} follows when it moves, or a refusal with the reason. Throws
  /// Error for an invalid request.
  void begin(std::uint64_t client, const protocol::Any& id, const protocol::JogBegin& request);
  /// The same, towards a target.
  void go_to(std::uint64_t client, const protocol::Any& id, const protocol::JogGoto& request);
  /// A heartbeat. Ignored if the motion has ended or belongs to another client.
  void beat(std::uint64_t client, std::uint64_t jog);
  /// `why`: "released", "lost", "control", "gone".
  void end(std::uint64_t client, std::uint64_t jog, const char* why);
  /// Ends all motions of the client.
  void end_all(std::uint64_t client, const char* why);
  /// Sends replies and events to the clients.
  void tick();
  /// The equivalent motion by a fixed amount, as a request of the cell.
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

/// The motion of a `jog.goto` as a request that only plans it.
protocol::PlanPreview way_of(const protocol::JogGoto& request);

}  // namespace polyarm::server
