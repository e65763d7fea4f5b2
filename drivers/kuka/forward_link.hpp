#pragma once
/// The driver's end of EthernetKRL in forward mode: moves go to the program PolyarmMoves, the controller
/// interpolates. A thread of its own does all input and output while the link is open.
#include <cstdint>
#include <optional>
#include <string>

#include "drivers/forward/move_link.hpp"
#include "drivers/kuka/eki_link.hpp"
#include "drivers/kuka/link.hpp"

namespace polyarm::kuka {

/// Moves that the program holds at a time, with the one under way.
inline constexpr std::size_t kMoveSlots = 6;

/// What the controller says. rad, rad/s.
struct ForwardSample {
  Six q{}, dq{};
  EkiState state;
  std::uint64_t count = 0;  ///< of readings since the connection began; 0: none
};

struct ForwardSettings {
  std::string host;
  int eki_port = 54600;
  bool drives_on = true;
  wire::SignalRange outputs;
  forward::MoveFrame frame;
  bool stepped = false;           ///< reads only in exchange()
  Nanoseconds poll = 20'000'000;  ///< between two readings
  int watchdog_ms = 500;          ///< without a request, until the program stops the robot
  Nanoseconds timeout = 2'000'000'000, start_timeout = 10'000'000'000;
  Nanoseconds answer = 1'000'000'000;      ///< without an answer, until the link counts as lost
  Nanoseconds loop_silence = 100'000'000;  ///< without a cycle of the loop, until the robot is stopped
};

/// open(), close(), start() and stop() come from one thread at a time and may wait. moves(), cycle() and what
/// reads the sample belong to the control thread. The override of cycle() counts nothing.
class ForwardLink : public forward::MoveLink<EkiLink, Cause, ForwardSample, Outputs> {
 public:
  explicit ForwardLink(ForwardSettings settings);
  ~ForwardLink() { close(); }
  ForwardLink(const ForwardLink&) = delete;
  ForwardLink& operator=(const ForwardLink&) = delete;

  /// Connects and reads states from then on. Nothing moves. False: see reason().
  bool open();
  void close();
  /// Begins a session of moves; the robot stands still. False: see reason().
  bool start();
  /// Stops the robot and ends the session.
  void stop();

  /// Valid after open().
  const EkiIdentity& identity() const { return identity_; }

 private:
  // how it begins and ends; forward_link_setup.cpp
  bool end_old_session(const EkiState& state);
  bool await_session();

  // the thread
  void round() override;
  bool ask_next(bool asked);
  bool ask(EkiDo what, int number = 0, int value = 0, const std::optional<EkiMove>& move = std::nullopt);
  bool ask_override();
  bool ask_order();
  bool ask_output();
  bool ask_end();
  void take(const EkiReply& reply);
  void judge(const EkiState& state);
  forward::MoveReport report() const;

  ForwardSettings settings_;
  EkiIdentity identity_;

  // the thread's; start() and stop() use them while it is halted
  ForwardSample current_;
  Outputs written_;
  bool end_asked_ = false;  ///< the session was asked to end
  bool end_heard_ = false;  ///< and the program has answered
  int session_ = 0, percent_ = -1;
  std::optional<int> percent_before_;  ///< until a session that changed the override has ended in order
  std::int64_t time_ms_ = 0;           ///< of the controller, without the end of its range
};

}  // namespace polyarm::kuka
