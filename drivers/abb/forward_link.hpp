#pragma once
/// The driver's end in forward mode: moves go to our RAPID program PolyarmMoves, the controller interpolates.
/// One thread asks that program, another one Robot Web Services.
#include <cstdint>
#include <optional>
#include <string>

#include "drivers/abb/move_wire.hpp"
#include "drivers/abb/rws_link.hpp"
#include "drivers/forward/move_link.hpp"

namespace polyarm::abb {

/// What the program says. rad, rad/s.
struct ForwardSample {
  Six q{}, dq{};
  std::uint64_t count = 0;  ///< of readings since the session began; 0: none
};

struct ForwardSettings : ControllerSettings {
  int moves_port = kMovesPort;
  forward::MoveFrame frame;
  RapidLoad load;  ///< of the tool
  forward::AskingTimes times;
  int watchdog_ms = 500;  ///< without a request, until the program stops the robot
  Nanoseconds timeout = 2'000'000'000, start_timeout = 10'000'000'000;
  Nanoseconds answer = 1'000'000'000;  ///< without an answer, until the link counts as lost
};

/// The loop's outputs go over Robot Web Services.
struct NoOutputs {};

/// open(), close(), start() and stop() come from one thread at a time and may wait. moves(), cycle() and what
/// reads the sample belong to the control thread. Until a session begins, the joints come over Robot Web
/// Services.
class ForwardLink : public forward::MoveLink<RwsLink, Cause, ForwardSample, NoOutputs> {
 public:
  explicit ForwardLink(ForwardSettings settings);
  ~ForwardLink() { close(); }
  ForwardLink(const ForwardLink&) = delete;
  ForwardLink& operator=(const ForwardLink&) = delete;

  /// Connects, reads version, states and signals. Nothing moves. False: see reason().
  bool open();
  void close();
  /// Starts the program and begins a session of moves; the robot stands still. False: see reason().
  bool start();
  /// Stops the robot, ends the session and stops the program.
  void stop();

  bool fetch() noexcept {
    panels_.fetch();
    return AskingLink::fetch();
  }
  const Panel& panel() const noexcept { return panels_.value(); }
  void cycle(const Outputs& outputs) noexcept {
    RwsLink::outputs(outputs);
    AskingLink::cycle({});
  }

 private:
  // how it begins and ends; forward_link_setup.cpp
  bool check_controller();
  bool connect_program();
  bool begin_moves();
  bool check_frame(const MoveReply& reply);
  std::optional<MoveReply> ask_first(const MoveRequest& request);
  void end_program();
  void halt_threads();
  void run_threads();

  // the thread
  void round() override;
  bool ask_next(bool asked);
  bool ask(const MoveRequest& request);
  std::optional<MoveReply> await_reply();
  bool ask_pace();
  bool ask_order();
  void end_round();
  bool is_stopped();
  void lose(Cause otherwise);
  void take(const MoveReply& reply);
  void judge(const MoveReply& reply);
  forward::MoveReport report() const;

  // of the thread of Robot Web Services
  bool guided() const override { return phase_ != Phase::idle; }
  void show(const Panel& panel) override { panels_.write(panel); }
  Cause vague_cause() const override { return Cause::moves_silent; }

  ForwardSettings settings_;
  realtime::Latest<Panel> panels_;

  // the thread's; start() and stop() use them while it is halted
  MovePort port_;
  ForwardSample current_;
  MoveReply newest_;
  bool end_asked_ = false;  ///< the session was asked to end
  int session_ = 0, percent_ = -1;
  std::int64_t time_ms_ = 0;  ///< of the program, without the end of its range
};

}  // namespace polyarm::abb
