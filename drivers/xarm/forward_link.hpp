#pragma once
/// The driver's end of the wires to a controller of UFACTORY in forward mode: moves go into its queue in
/// position mode, the controller interpolates. A thread of its own does all input and output while the link
/// is open.
#include <cstdint>
#include <optional>
#include <string>

#include "drivers/forward/move_link.hpp"
#include "drivers/watchdog/link.hpp"
#include "drivers/wire/link_base.hpp"
#include "drivers/xarm/moves.hpp"
#include "drivers/xarm/panel_port.hpp"
#include "drivers/xarm/report.hpp"

namespace polyarm::xarm {

/// Moves that the controller holds at a time, with the one under way. Few: nothing stops them when the cable
/// is pulled.
inline constexpr std::size_t kMoveSlots = 3;

/// What the controller says. rad, rad/s.
struct ForwardSample {
  Six q{}, dq{};
  Report report;
  Panel panel;
  std::uint64_t count = 0;  ///< of reports since the connection began; 0: none
};

struct ForwardSettings {
  std::string host;
  int command_port = kCommandPort, report_port = kRealPort;
  bool clear_errors = true;
  UsedSignals signals;
  forward::MoveFrame frame;
  forward::AskingTimes times;
  Nanoseconds period = 4'000'000;  ///< between two reports of a controller whose clock waits
  Nanoseconds silence = 300'000'000;
  Nanoseconds timeout = 2'000'000'000, start_timeout = 10'000'000'000;
  Nanoseconds answer = 1'000'000'000;  ///< without an answer, until the link counts as lost
  int watchdog_ms = 2000;  ///< without a round, until a process of its own stops the robot; 0: none
};

/// open(), close(), start() and stop() come from one thread at a time and may wait. moves(), cycle() and what
/// reads the sample belong to the control thread.
///
/// Nothing at the controller ends its moves unless a client does: it makes those that it holds, kMoveSlots at
/// most, and stands. Every end that this link notices stops the robot at once; if its connection is lost, it
/// makes another one for that. If this process dies or hangs, a watchdog process stops it.
class ForwardLink : public forward::MoveLink<wire::LinkBase<Cause>, Cause, ForwardSample, Outputs> {
 public:
  explicit ForwardLink(ForwardSettings settings);
  ~ForwardLink() { close(); }
  ForwardLink(const ForwardLink&) = delete;
  ForwardLink& operator=(const ForwardLink&) = delete;

  /// Connects and reads states from then on. Nothing moves. False: see reason().
  bool open();
  void close();
  /// Switches motors and position mode on, with no move at the controller; the robot stands still. False: see
  /// reason().
  bool start();
  /// Stops the robot and ends the session.
  void stop();

  /// Valid after open().
  const Version& version() const { return version_; }

 private:
  enum class Halt : std::uint8_t { none, asked, stopping, starting };

  // how it begins and ends; forward_link_setup.cpp
  bool refuse_panel();
  bool identify();
  bool connect_reports();
  template <typename Seen>
  bool await_report(Nanoseconds timeout, Seen seen);
  bool begin();
  bool becomes(bool seen, Cause otherwise);
  bool start_watchdog();
  void lose();

  // the thread
  void round() override;
  bool take_reports();
  void take(const Report& report, int reports);
  bool read_panel();
  void watch_idle();
  void judge();
  void judge_stop();
  void count_moves();
  void act();
  bool set_state(unsigned state);
  void steer_pause();
  void go_on_halting();
  void send_order();
  bool send_move();
  bool send_tool();
  bool note_panel();
  bool beat();
  void end();
  bool send_stop();
  bool has_stopped() const { return still_reports_ >= kStillReports; }
  forward::MoveReport report() const { return {time_, current_.q, ended_, halted_}; }

  static constexpr int kStillReports = 3;

  ForwardSettings settings_;
  Version version_;
  UxMoveForms forms_;

  // the thread's; start() and stop() use them while it is halted
  UxPort port_;
  PanelPort panel_;
  Descriptor report_socket_;
  ReportReader report_reader_;
  ForwardSample current_;
  Nanoseconds heard_ = 0;
  double time_ = 0;  ///< s, of the newest report
  int still_reports_ = 0, foreign_reports_ = 0;
  std::uint8_t bits_ = 0;  ///< of the newest reply
  int queued_ = 0;         ///< moves at the controller
  bool paused_ = false;   ///< by this driver
  Halt halt_ = Halt::none;
  int put_ = 0, ended_ = 0, halting_ = 0, halted_ = 0;
  bool forgotten_ = false;  ///< the queue was emptied: until the next move its length says nothing of ended_
  std::optional<double> tool_set_;
  watchdog::Link watchdog_;
  double changed_at_ = 0;  ///< s: when this driver changed the state of the controller
  double moved_at_ = 0;    ///< s: when the controller had a move
  bool stop_sent_ = false;  ///< at the end of a session: the stop was sent, or is not needed
  int end_attempts_ = 0;
  Nanoseconds ending_since_ = 0;
};

}  // namespace polyarm::xarm
