#pragma once
/// The driver's end of the wires to one controller of UFACTORY. While the link is open, one thread reads the
/// reports and sends servo commands; another one asks for errors and signals over a connection of its own,
/// because the answers of a device at the tool take long.
#include <array>
#include <atomic>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "drivers/wire/link_base.hpp"
#include "drivers/wire/shaper.hpp"
#include "drivers/xarm/panel_port.hpp"
#include "drivers/xarm/report.hpp"
#include "polyarm/realtime/queue.hpp"

namespace polyarm::xarm {

/// What the controller reports. rad, rad/s.
struct Sample {
  Seven q{}, dq{};
  Report report;
  std::uint64_t sequence = 0;  ///< reports since the connection; 0: nothing came
  double behind = 0;           ///< rad, of the sent command behind the loop's
  std::uint64_t shaped = 0;    ///< commands that were not as the loop gave them
  std::uint64_t replaced = 0;  ///< commands that a newer one replaced before they were sent
};

struct LinkSettings : wire::StreamSettings {
  std::string host;
  int command_port = kCommandPort, report_port = kRealPort;
  std::size_t axes = 6;
  double period = 0.004;     ///< s, between two servo commands
  int cycles = 1;            ///< of the loop, for one of them
  double report_period = 0;  ///< s, between two reports; 0: by the clock of this computer
  bool clear_errors = true;  ///< activating clears an error that is not there any more
  UsedSignals signals;
  wire::AxisLimitsOf<7> limits;  ///< degrees, of commands
};

class Link : public wire::StreamLink<wire::LinkBase<Cause>, Sample, Panel> {
 public:
  explicit Link(LinkSettings settings);
  ~Link() { close(); }

  /// Connects and reads reports. Nothing moves. False: see reason().
  bool open();
  void close();
  /// Clears errors, switches motors and servo mode on; the robot stands still. False: see reason().
  bool start();
  /// Brakes the robot; it is stopped, in position mode.
  void stop();
  /// One exchange of errors and signals. For simulated controllers, whose clock waits.
  void serve_services();
  /// Waits until every command is with the controller. For the same.
  void settle(Nanoseconds timeout);

  // --- control thread; nothing waits, locks or allocates ---
  /// The command of a cycle, rad. Without `move` the robot comes to rest.
  void command(bool move, const Seven& joints) noexcept;
  void outputs(const Outputs& outputs) noexcept { outputs_.write(outputs); }

  /// Hz that the loop must have; this link takes any.
  double rate() const { return 1 / (settings_.period / settings_.cycles); }
  /// Valid after open().
  const Version& version() const { return version_; }

 private:
  struct Wanted {
    bool move = false;
    Seven joints{};  ///< degrees
  };

  // how it begins and ends; link_setup.cpp
  bool refuse_port(const UxPort& port);
  bool connect_reports();
  bool identify();
  bool refuse_panel();
  bool set(Register reg, unsigned value);
  bool await_report(Nanoseconds timeout, bool (Link::*seen)() const);
  bool has_report() const { return reports_seen_ > 0; }
  bool stands_still() const { return still_reports_ >= kStillReports; }
  bool in_servo_mode() const { return mode_ == static_cast<int>(Mode::servo); }
  bool is_ready() const { return in_servo_mode() && ready_state(state_); }
  static bool ready_state(int state) { return state <= static_cast<int>(State::standing); }
  bool set_up_motion();
  void begin_streaming();

  // the second connection; link_services.cpp
  void run_services();
  bool serve_round();
  PanelPort::Why explain_stop();

  // the thread of reports and commands; link.cpp
  void run();
  void wait();
  void take_reports(Nanoseconds now);
  bool receive_reports();
  void take_report(const Report& report, Nanoseconds now);
  void judge_report(const Report& report);
  void judge_doubt();
  void take_commands(Nanoseconds now);
  void feed(const Wanted& wanted);
  void shape();
  bool answer_is_late(Nanoseconds now) const noexcept;
  void take_answers();
  void send_next(Nanoseconds now);
  void end_with(Cause cause, int detail);
  void judge(Nanoseconds now);
  void end(Nanoseconds now);
  void brake_on(Nanoseconds now);
  void bridge_gap(Nanoseconds now);
  void note_settled();
  bool owns_motion() const noexcept { return phase_ != Phase::idle && !stands_; }
  bool follows_reports() const noexcept { return settings_.stepped && report_socket_; }
  bool can_send() const noexcept { return owns_motion() && !lost_ && !stopped_; }

  static constexpr int kStillReports = 3;

  LinkSettings settings_;
  Version version_;
  Descriptor services_wake_;
  UxPort motion_;
  Descriptor report_socket_;
  ReportReader report_reader_;

  std::recursive_mutex services_mutex_;  // second connection, of any thread but the control thread
  UxPort services_port_;
  PanelPort panel_{services_port_, settings_.signals, settings_.timeout};
  bool open_ = false;
  Outputs wanted_;
  Panel current_panel_;

  realtime::Queue<Wanted> commands_{256};
  realtime::Latest<Outputs> outputs_;
  std::atomic<std::uint64_t> pushed_{0};  ///< commands

  std::atomic<bool> lost_{false};     // the connection for motion is of no use
  std::atomic<bool> stopped_{false};  // the controller stopped by itself, or somebody else did it
  std::atomic<std::uint64_t> reports_seen_{0};
  std::atomic<int> still_reports_{0}, mode_{0}, state_{0};
  std::uint64_t settled_commands_ = 0, settled_reports_ = 0;  // with mutex_

  // the thread of reports and commands
  Sample current_;
  wire::ShaperOf<7> shaper_;
  Nanoseconds asked_at_ = 0, heard_ = 0, commanded_at_ = 0, ending_since_ = 0, brake_due_ = 0;
  bool asked_ = false;    ///< a command waits for its answer
  bool pending_ = false;  ///< a command waits to be sent
  bool fresh_ = false;    ///< it is newest_, which the shaper has not taken yet
  Wanted newest_;         ///< of the loop
  bool waited_ = false;   ///< for an answer, since the robot was where the loop wants it
  bool begun_ = false;
  int since_ = 0;  ///< cycles since the last command
  std::uint64_t taken_ = 0, braked_report_ = 0;
  Cause doubt_ = Cause::none;  ///< of a command that was not taken
  int doubtful_reports_ = 0;

  std::thread thread_, services_;
};

}  // namespace polyarm::xarm
