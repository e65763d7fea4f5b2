#pragma once
/// The driver's end of the Remote Motion Interface in forward mode: moves go out as instructions, the
/// controller interpolates. A thread of its own does all input and output while the link is open.
#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "drivers/fanuc/instructions.hpp"
#include "drivers/fanuc/link.hpp"
#include "drivers/fanuc/rmi_link.hpp"
#include "drivers/forward/move_buffer.hpp"
#include "polyarm/hardware/forward_moves.hpp"
#include "polyarm/realtime/latest.hpp"

namespace polyarm::fanuc {

/// What the controller says. rad, rad/s. NaN: not read yet.
struct ForwardSample {
  Six q{}, dq{};
  std::uint64_t count = 0;  ///< of readings since the connection began
  bool ready = false, moving = false, teach = false, error = false;
  std::array<double, kMostDigital> inputs, outputs;
  ForwardSample() noexcept;
};

struct ForwardSettings {
  std::string host;
  int rmi_port = 16001;
  IoRange inputs, outputs;
  InstructionFrame frame;
  int window = 8;                 ///< instructions without an answer, at most
  bool stepped = false;           ///< reads only in exchange()
  Nanoseconds poll = 20'000'000;  ///< between two readings
  Nanoseconds connect_timeout = 2'000'000'000, start_timeout = 5'000'000'000;
  Nanoseconds silence = 1'000'000'000;     ///< without an answer, until the link counts as lost
  Nanoseconds loop_silence = 100'000'000;  ///< without a cycle of the loop, until the robot is stopped
};

/// open(), close(), start() and stop() come from one thread at a time and may wait. ForwardMoves, cycle() and
/// what reads the sample belong to the control thread.
class ForwardLink : public RmiLink, public hardware::ForwardMoves {
 public:
  explicit ForwardLink(ForwardSettings settings);
  ~ForwardLink() { close(); }
  ForwardLink(const ForwardLink&) = delete;
  ForwardLink& operator=(const ForwardLink&) = delete;

  /// Connects and reads states from then on. Nothing moves. False: see reason().
  bool open();
  void close();
  /// Begins remote motion; the robot stands still. False: see reason().
  bool start();
  /// Stops the robot and ends remote motion.
  void stop();

  hardware::ForwardMoves& moves() noexcept { return *this; }
  bool accept(const hardware::ForwardMove& move) noexcept override;
  void set_pace(double share) noexcept override;
  void clear() noexcept override;
  hardware::ForwardFlow flow() const noexcept override;

  bool fetch() noexcept { return samples_.fetch(); }
  const ForwardSample& sample() const noexcept { return samples_.value(); }
  /// In each cycle of the loop, with the outputs that are wanted.
  void cycle(const Outputs& outputs) noexcept;
  /// Reads once, with everything that is to be sent before. False: no answer in time.
  bool exchange(Nanoseconds timeout) noexcept;

 private:
  enum class Phase : std::uint8_t { idle, active };
  /// The command without an answer.
  enum class Asked : std::uint8_t {
    nothing,
    status,
    joints,
    input,
    output,
    pause,
    resume,
    abort,
    initialize,
    pace,
    tool_data,
    tool,
    configuration,
    error
  };
  enum class Round : std::uint8_t { none, begun, joints, over };

  bool read_outputs();
  void run_thread();
  void halt_thread();
  void end_remote_motion();

  // the thread
  void run();
  void wait();
  void take(Nanoseconds now);
  void take_answer(const RmiMessage& message, Nanoseconds now);
  void take_status(const RmiMessage& message);
  void take_joints(const RmiMessage& message, Nanoseconds now);
  void take_alarm(const RmiMessage& message);
  void take_instruction(const RmiMessage& message);
  void take_wanted(Nanoseconds now);
  void act(Nanoseconds now);
  bool act_on_fault(Nanoseconds now);
  bool act_on_clear(Nanoseconds now);
  bool act_on_pace(Nanoseconds now);
  bool act_on_outputs(Nanoseconds now);
  bool send_moves(Nanoseconds now);
  bool ready_to_send(const hardware::ForwardMove& next, Nanoseconds now);
  void read_on(Nanoseconds now);
  void ask(Asked what, const RmiLine& line, Nanoseconds now);
  void land(Nanoseconds now);
  void suspect() { suspected_ = true; }
  void judge(Nanoseconds now);
  void publish();

  ForwardSettings settings_;
  Phase phase_ = Phase::idle;  ///< changes while the thread is halted
  realtime::Latest<ForwardSample> samples_;
  realtime::Latest<Outputs> outputs_;
  forward::MoveBuffer moves_;

  // the control thread writes
  std::atomic<double> pace_{0};
  std::atomic<std::uint64_t> cycles_{0};
  // the thread writes
  std::atomic<bool> at_rest_{false}, carries_out_{false}, paused_{false}, hold_seen_{false};
  std::atomic<bool> rmi_gone_{false}, aborted_{false};
  // anybody
  std::atomic<bool> round_wanted_{false}, own_rounds_{false}, quit_{false};
  std::atomic<std::uint64_t> rounds_{0};

  // the thread's
  ForwardSample current_;
  Asked asked_ = Asked::nothing;
  const char* asked_name_ = "";
  Nanoseconds asked_at_ = 0, read_at_ = 0, next_round_ = 0, cycled_at_ = 0, error_at_ = 0;
  Round round_ = Round::none;
  unsigned turn_ = 0;
  int sequence_ = 1, percent_ = 0, percent_asked_ = 0, still_ = 0, input_ = 0, output_ = -1, errors_ = 0;
  bool suspected_ = false, configuration_known_ = false;
  int begins_ = 0;                              ///< refused, of the same clear()
  std::uint64_t begin_after_ = 0;               ///< readings: not asked again before
  std::pair<int, const char*> refusal_{0, ""};  ///< error number, and of which command
  std::optional<Pose> tool_, tool_asked_;
  Configuration configuration_;
  Outputs wanted_;
  std::uint64_t cycles_seen_ = 0;
  std::thread thread_;
};

}  // namespace polyarm::fanuc
