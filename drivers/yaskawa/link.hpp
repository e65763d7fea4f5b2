#pragma once
/// The driver's end of the wires to one controller of Yaskawa: MotoROS and the High-Speed Ethernet Server.
/// While the link is open, one thread reads states and sends points, another one asks for the rest and writes
/// outputs.
#include <array>
#include <atomic>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>

#include "drivers/wire/link_base.hpp"
#include "drivers/wire/signals.hpp"
#include "drivers/yaskawa/hses.hpp"
#include "drivers/yaskawa/moto.hpp"
#include "drivers/yaskawa/point_stream.hpp"
#include "polyarm/realtime/latest.hpp"
#include "polyarm/realtime/queue.hpp"

namespace polyarm::yaskawa {

/// What MotoROS measures. rad, rad/s.
struct Sample {
  Six q{}, dq{};
  MotoStatus status;
  std::uint64_t sequence = 0;  ///< states since the connection; 0: nothing came
  double behind = 0;           ///< rad, of the sent command behind the loop's
  std::uint64_t shaped = 0;    ///< points that were not as the loop gave them
  std::uint64_t busy = 0;      ///< points that were sent again
  int buffered_ms = 0;         ///< of motion in the controller, as it said last
};

/// What the Ethernet server and the signals show.
struct Panel {
  HsesStatus status;
  HsesPosition pose;
  std::array<std::int32_t, 8> torque{};
  bool seen = false;  ///< the Ethernet server answered
  std::uint32_t inputs = 0, outputs = 0;
};

/// NaN: stays as it is.
struct Outputs {
  std::array<double, kMostSignals> digital;
  Outputs() noexcept;
};

struct LinkSettings {
  std::string host;
  int motion_port = kMotionPort, state_port = kStatePort, io_port = kIoPort;
  bool hses = true;
  int hses_port = kHsesPort;
  int group = 0;             ///< control group of the robot
  int cycles = 5;            ///< of the loop, for one point
  int point_ms = 20;         ///< the same, ms
  int lead_ms = 120;         ///< of motion that the controller's buffer holds ahead
  int interpolation_ms = 4;  ///< of the controller, for the steps in its buffer
  bool servo_on = true;      ///< activating may switch the servos on
  bool stepped = false;      ///< the controller's clock waits; serve_services() asks for the rest
  wire::SignalRange inputs, outputs;
  wire::AxisLimits limits;  ///< degrees, of commands
  Nanoseconds timeout = 2'000'000'000, start_timeout = 10'000'000'000;
  Nanoseconds silence = 500'000'000;       ///< without a state
  Nanoseconds loop_silence = 100'000'000;  ///< without a command of the loop, until the robot is braked
  double most_behind = 0.05;               ///< rad, that the shaper may be behind
};

/// open(), close(), start() and stop() come from one thread at a time and may wait; the calls marked control
/// thread do not.
class Link : public wire::LinkBase<Cause> {
 public:
  explicit Link(LinkSettings settings);
  ~Link() { close(); }
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  /// Connects and reads states. Nothing moves. False: see reason().
  bool open();
  void close();
  /// Starts the job that lets MotoROS move the robot; it stands still. False: see reason().
  bool start();
  /// Brakes the robot and ends that job.
  void stop();
  /// One exchange with the Ethernet server and the signals. For simulated controllers, whose clock waits.
  void serve_services();
  /// Waits until every command is with the controller. For the same.
  void settle(Nanoseconds timeout);

  // --- control thread; nothing waits, locks or allocates ---
  bool fetch() noexcept {
    panels_.fetch();
    return samples_.fetch();
  }
  const Sample& sample() const noexcept { return samples_.value(); }
  const Panel& panel() const noexcept { return panels_.value(); }
  /// The command of a cycle, rad. Without `move` the robot comes to rest.
  void command(bool move, const Six& joints) noexcept;
  void outputs(const Outputs& outputs) noexcept { outputs_.write(outputs); }

  /// Hz that the loop must have; this link takes any.
  double rate() const { return 1000.0 * settings_.cycles / settings_.point_ms; }
  /// Valid after open().
  const std::string& system() const { return system_; }
  ByteOrder order() const { return state_.order(); }

 private:
  struct Wanted {
    bool move = false;
    Six joints{};  ///< degrees
  };
  enum class Phase : std::uint8_t { idle, streaming, ending };
  enum class Asked : std::uint8_t { nothing, point, ready, queue };

  // how it begins and ends; link_setup.cpp
  bool refuse_port(const MotoPort& port);
  bool connect_moto();
  bool connect_hses();
  bool check_ready();
  bool await_state(Nanoseconds timeout, bool (Link::*seen)() const);
  bool has_state() const { return states_seen_ > 0; }
  bool stands_still() const { return still_states_ >= kStillStates; }
  bool may_move() const { return possible_ && stands_still(); }
  bool await_standing();
  bool start_job();
  void begin_streaming();

  // the thread of the rest; link_services.cpp
  void run_services();
  bool serve_round();
  bool exchange_signals();
  bool write_outputs();
  bool read_signals(bool inputs, const wire::SignalRange& range, std::uint32_t& into);
  bool read_hses();
  std::optional<std::uint32_t> ask_io(MotoType what, std::uint32_t address, std::uint32_t value = 0);
  struct Explained {
    int detail;
    std::string text;
  };
  Explained explain(Cause cause, int detail);

  // the thread of MotoROS; link.cpp
  void run();
  void wait(Nanoseconds now);
  void take_states(Nanoseconds now);
  void take_state(const Message& message, Nanoseconds now);
  void publish(const MotoStatus& status, Nanoseconds now);
  void take_commands(Nanoseconds now);
  void feed(const Wanted& wanted);
  void take_answers(Nanoseconds now);
  void take_answer(const MotoReply& reply);
  void take_point_answer(const MotoReply& reply);
  void take_queue_answer(int count);
  void end_with(Cause cause, int detail);
  void ask_next(Nanoseconds now);
  void send(std::span<const std::uint8_t> bytes, Asked what, Nanoseconds now);
  void send_point(Nanoseconds now);
  void judge(Nanoseconds now);
  void end(Nanoseconds now);
  void note_settled();
  bool owns_motion() const noexcept { return phase_ != Phase::idle && !stands_; }

  static constexpr int kStillStates = 3;

  LinkSettings settings_;
  std::string system_;
  Descriptor services_wake_;
  MotoPort state_, motion_, io_;  // io_: with services_mutex_

  std::recursive_mutex services_mutex_;  // Ethernet server and signals, of any thread but the control thread
  Hses hses_;
  bool open_ = false;
  Outputs wanted_, written_;
  Panel current_panel_;

  realtime::Latest<Sample> samples_;
  realtime::Latest<Panel> panels_;
  realtime::Queue<Wanted> commands_{256};
  realtime::Latest<Outputs> outputs_;
  std::atomic<std::uint64_t> pushed_{0};  ///< commands

  std::atomic<Phase> phase_{Phase::idle};  // changed with mutex_
  std::atomic<bool> renew_{false};         // the thread begins a session
  std::atomic<bool> stands_{true};         // what is ending stands, or is out of reach
  std::atomic<bool> lost_{false};          // the connection for motion is of no use
  std::atomic<std::uint64_t> states_seen_{0};
  std::atomic<int> still_states_{0};
  std::atomic<bool> possible_{false};
  std::atomic<int> alarm_code_{0};
  std::uint64_t settled_commands_ = 0, settled_states_ = 0;  // with mutex_

  // the thread of MotoROS
  Sample current_;
  MotoFeedback feedback_;
  bool fresh_feedback_ = false;
  PointStream stream_;
  Asked asked_ = Asked::nothing;
  Nanoseconds asked_at_ = 0, heard_ = 0, commanded_at_ = 0, ending_since_ = 0, busy_since_ = 0;
  bool retry_ = false;  ///< busy: the point goes out again with the next state
  bool begun_ = false, check_ = false, braked_ = false;
  bool stopped_ = false;  ///< the controller takes no points: it stopped by itself
  int since_check_ = 0, without_feedback_ = 0;
  std::uint64_t taken_ = 0;
  int queue_ = -1;  ///< steps in the controller's buffer; -1: unknown
  std::int32_t control_sequence_ = 0;

  std::atomic<bool> quit_{false};
  std::thread thread_, services_;
};

}  // namespace polyarm::yaskawa
