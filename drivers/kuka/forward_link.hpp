#pragma once
/// The driver's end of EthernetKRL in forward mode: moves go to the program PolyarmMoves, the controller
/// interpolates. A thread of its own does all input and output while the link is open.
#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <thread>

#include "drivers/forward/move_queue.hpp"
#include "drivers/kuka/eki_link.hpp"
#include "drivers/kuka/link.hpp"
#include "polyarm/realtime/latest.hpp"

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
/// reads the sample belong to the control thread.
class ForwardLink : public EkiLink {
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

  forward::MoveQueue& moves() noexcept { return moves_; }
  bool fetch() noexcept { return samples_.fetch(); }
  const ForwardSample& sample() const noexcept { return samples_.value(); }
  /// In each cycle of the loop, with the outputs that are wanted; their override counts nothing.
  void cycle(const Outputs& outputs) noexcept;
  /// Reads once, with everything that is to be sent before. False: no answer in time.
  bool exchange(Nanoseconds timeout) noexcept;

  /// Valid after open().
  const EkiIdentity& identity() const { return identity_; }

 private:
  enum class Phase : std::uint8_t { idle, active, ending };

  // how it begins and ends; forward_link_setup.cpp
  void run_thread();
  void halt_thread();
  bool end_old_session(const EkiState& state);
  bool await_session();

  // the thread
  void run();
  void wait();
  void take_wanted(Nanoseconds now);
  void round();
  bool ask_next(bool asked);
  bool ask(EkiDo what, int number = 0, int value = 0, const std::optional<EkiMove>& move = std::nullopt);
  bool ask_override();
  bool ask_order();
  bool ask_output();
  bool ask_end();
  void take(const EkiReply& reply);
  void judge(const EkiState& state);
  void judge_loop(Nanoseconds now);
  forward::MoveReport report() const;

  ForwardSettings settings_;
  EkiIdentity identity_;
  forward::MoveQueue moves_;
  realtime::Latest<ForwardSample> samples_;
  realtime::Latest<Outputs> outputs_;
  std::atomic<Phase> phase_{Phase::idle};
  std::atomic<std::uint64_t> cycles_{0}, rounds_{0};
  std::atomic<bool> round_wanted_{false}, own_rounds_{false}, gone_{false}, over_{false}, quit_{false};

  // the thread's; start() and stop() use them while it is halted
  ForwardSample current_;
  Outputs wanted_, written_;
  forward::MoveOrder order_;
  bool ordered_ = false;    ///< order_ is to be sent
  bool end_asked_ = false;  ///< the session was asked to end
  bool end_heard_ = false;  ///< and the program has answered
  int session_ = 0, percent_ = -1;
  std::optional<int> percent_before_;  ///< until a session that changed the override has ended in order
  std::uint64_t cycles_seen_ = 0;
  Nanoseconds next_round_ = 0, cycled_at_ = 0, read_at_ = 0;
  std::int64_t time_ms_ = 0;  ///< of the controller, without the end of its range
  std::thread thread_;
};

}  // namespace polyarm::kuka
