#pragma once
/// The driver's end of the High-Speed Ethernet Server in forward mode: moves go to the variables of the job
/// POLYARM, the controller interpolates. A thread of its own does all input and output while the link is
/// open.
#include <cstdint>
#include <optional>
#include <string>

#include "drivers/forward/move_link.hpp"
#include "drivers/wire/link_base.hpp"
#include "drivers/wire/signals.hpp"
#include "drivers/yaskawa/hses.hpp"
#include "drivers/yaskawa/inform.hpp"
#include "drivers/yaskawa/link.hpp"

namespace polyarm::yaskawa {

/// What the controller says. rad, rad/s.
struct ForwardSample {
  Six q{}, dq{};
  HsesStatus status;
  std::uint32_t inputs = 0, outputs = 0;
  std::uint64_t count = 0;  ///< of readings since the connection began; 0: none
};

struct ForwardSettings {
  std::string host;
  int hses_port = kHsesPort;
  forward::MoveFrame frame;
  Six pulses{};            ///< for a radian of each axis
  double base_height = 0;  ///< m, of the controller's base coordinates above those of the description
  int tool_number = 0;
  int heartbeat_byte = kHeartbeatByte;
  bool servo_on = true;
  wire::SignalRange inputs, outputs;
  forward::AskingTimes times;
  Nanoseconds period = 4'000'000;      ///< of the loop, and of a controller whose clock waits
  Nanoseconds watchdog = 600'000'000;  ///< of the timer in the ladder
  Nanoseconds timeout = 2'000'000'000, start_timeout = 10'000'000'000;
  Nanoseconds answer = 900'000'000;  ///< without an answer, until the link counts as lost
};

/// open(), close(), start() and stop() come from one thread at a time and may wait. moves(), cycle() and what
/// reads the sample belong to the control thread.
///
/// While a session is open, each round changes the heartbeat. When it stops for any reason, the ladder of the
/// controller holds the robot, and a held job does not go on before a new session starts it from its first
/// line.
class ForwardLink : public forward::MoveLink<wire::LinkBase<Cause>, Cause, ForwardSample, Outputs> {
 public:
  explicit ForwardLink(ForwardSettings settings);
  ~ForwardLink() { close(); }
  ForwardLink(const ForwardLink&) = delete;
  ForwardLink& operator=(const ForwardLink&) = delete;

  /// Reads states from then on. Nothing is written, nothing moves. False: see reason().
  bool open();
  void close();
  /// Proves that the robot is held without the heartbeat, and starts the job; the robot stands still. False:
  /// see reason().
  bool start();
  /// Stops the robot and ends the session.
  void stop();

  /// Valid after open().
  const std::string& system() const { return system_; }

 private:
  enum class End : std::uint8_t { hold, standing, over };

  // how it begins and ends; forward_link_setup.cpp
  bool begin();
  bool check_panel(const HsesStatus& status);
  bool end_old_job(const HsesStatus& status);
  bool prove_watchdog();
  bool prepare_job();
  bool switch_servo_on();
  bool start_job();
  void give_up();
  bool refuse_hses();
  template <typename Seen>
  bool await_status(Nanoseconds timeout, bool beats, Seen seen);

  // the thread
  void round() override;
  bool beat();
  bool write_beat();
  bool read();
  bool read_signals(bool inputs, const wire::SignalRange& range, std::uint32_t& into);
  void take(const HsesStatus& status, const HsesPosition& place, const std::vector<std::int32_t>& shared);
  void judge();
  void note_alarm(Cause cause);
  void act();
  void steer_hold();
  void await_halt();
  void send_order();
  bool send_move();
  bool check_tool();
  void write_output();
  void end();
  bool has_stopped() const;
  template <typename Answer>
  bool came(const Answer& answer);
  std::int32_t shared(int number) const {
    return shared_[static_cast<std::size_t>(number - SharedDoubles::first)];
  }
  double now() const;

  ForwardSettings settings_;
  std::string system_;
  Hses hses_;

  // the thread's; start() and stop() use them while it is halted
  ForwardSample current_;
  double read_at_ = 0;  ///< s
  std::array<std::int32_t, SharedDoubles::count> shared_{};
  bool beat_ = false, session_open_ = false;
  bool holding_ = false;                 ///< by this driver
  double held_at_ = 0, started_at_ = 0;  ///< s
  int still_readings_ = 0, unread_ = 0;
  int put_ = 0, ended_ = 0, halting_ = 0, halted_ = 0;
  bool forgotten_ = false;  ///< what the job calls ended was forgotten: ended_ stays
  Outputs written_;
  int output_asked_ = 0, output_next_ = 0;
  End end_ = End::hold;
  Nanoseconds ending_since_ = 0;
};

}  // namespace polyarm::yaskawa
