#pragma once
/// The driver's end of the wires to one FANUC controller: Stream Motion and the Remote Motion Interface. A
/// thread of its own does all input and output while the link is open.
#include <array>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>

#include "drivers/fanuc/limit_tables.hpp"
#include "drivers/fanuc/rmi_link.hpp"
#include "drivers/fanuc/stream.hpp"
#include "drivers/fanuc/words.hpp"
#include "drivers/wire/pacer.hpp"
#include "drivers/wire/udp.hpp"
#include "polyarm/realtime/latest.hpp"

namespace polyarm::fanuc {

/// What the controller measures. rad, rad/s.
struct Sample {
  Status status;
  Six q{}, dq{};
  std::uint64_t count = 0;  ///< of packets since the connection began; 0: nothing came yet
  std::uint64_t lost = 0, repeated = 0;
  double behind = 0;           ///< rad, of the sent command behind the loop's
  std::uint64_t shaped = 0;    ///< commands that were not sent as the loop gave them
  std::uint32_t answered = 0;  ///< sequence of the last packet that a command answered
};

inline std::uint64_t sequence_of(const Sample& sample) noexcept {
  return sample.status.sequence;
}

/// A range of digital inputs or outputs in the controller's numbers.
struct IoRange {
  int first = 1, count = 0;
};
inline constexpr int kMostDigital = 64;

/// NaN: the output keeps the state that it had when streaming began.
struct Outputs {
  std::array<double, kMostDigital> digital;
  Outputs() noexcept;
};

struct LinkSettings {
  std::string host;
  int stream_port = 60015, rmi_port = 16001;
  IoRange inputs, outputs;
  bool follows = true;  ///< the loop gives one command for each packet
  double load = 1;      ///< share of the full load, for the limit tables
  Nanoseconds connect_timeout = 2'000'000'000, start_timeout = 5'000'000'000;
  Nanoseconds settle = 2'000'000'000;      ///< the controller must stay ready for so long
  Nanoseconds silence = 200'000'000;       ///< without a packet, until the link counts as lost
  Nanoseconds loop_silence = 100'000'000;  ///< without a command of the loop, until the robot is braked
  double most_behind = 0.05;               ///< rad, that the shaper may be behind
};

/// open(), close(), start() and stop() come from one thread at a time and may wait; the calls marked control
/// thread do not.
class Link : public RmiLink {
 public:
  explicit Link(LinkSettings settings);
  ~Link() { close(); }
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  /// Connects, reads versions and limits; reads states from then on. Nothing moves. False: see reason().
  bool open();
  void close();
  /// Starts streamed motion; the robot stands still. False: see reason().
  bool start();
  /// Brakes the robot and ends streamed motion.
  void stop();

  // --- control thread; nothing waits, locks or allocates ---
  bool fetch() noexcept { return samples_.fetch(); }
  const Sample& sample() const noexcept { return samples_.value(); }
  /// The newest command, rad. Without `move` the robot holds where it was commanded last.
  void command(bool move, const Six& joints) noexcept;
  /// Call it before command(): the outputs go with that command.
  void outputs(const Outputs& outputs) noexcept { outputs_.write(outputs); }

  /// Valid after open().
  double rate() const { return 1000.0 / sampling_ms_; }
  std::uint32_t version() const { return version_; }
  const LimitTables& limits() const { return limits_; }

 private:
  struct Wanted {
    bool move = false;
    std::uint32_t sequence = 0;  ///< of the packet that the loop had read
    Six joints{};                ///< degrees
  };
  enum class Phase : std::uint8_t { idle, streaming, ending };

  // before the thread runs, and while it is halted
  bool connect_stream();
  bool read_limits();
  bool begin_stream(bool with_outputs);
  bool set_up_io(bool with_outputs);
  bool check_state();
  bool call_program();
  bool await_ready();
  bool hold_ready();
  bool answer_one(Nanoseconds timeout);
  void abort_program();
  template <typename Decode>
  auto ask_stream(const std::vector<std::uint8_t>& request, Decode decode) -> decltype(decode(Bytes{}));
  void send_stop();
  void run_thread();
  void halt_thread();

  // the thread
  void run();
  void wait();
  void take_stream(Nanoseconds now);
  void take_status(const Status& status, Nanoseconds now);
  void answer(const Status& status);
  void take_rmi();
  void take_command(Nanoseconds now);
  void send_next(const Six& joints, bool motion, bool last, std::uint32_t sequence);
  void send_idle(const Status& status);
  void send_ending(const Status& status);
  void answer_what_is_left();
  void judge(Nanoseconds now);
  /// Commands of the loop count no more: the robot is braked.
  bool brakes() const noexcept { return phase_ == Phase::ending || fault_ || suspected_ != 0; }
  void judge_status(Nanoseconds now);
  void suspect(Nanoseconds now);
  void end(Nanoseconds now);
  bool motion_possible() const { return (current_.status.status & ready_bit) != 0; }
  void fill_outputs();

  LinkSettings settings_;
  Descriptor stream_;
  std::uint32_t version_ = kOldestVersion, sampling_ms_ = 8;
  LimitTables limits_;
  IoSetup io_;

  realtime::Latest<Sample> samples_;
  realtime::Latest<Wanted> commands_;
  realtime::Latest<Outputs> outputs_;

  Phase phase_ = Phase::idle;  // with mutex_
  bool stop_wanted_ = false;

  // the thread's
  Sample current_;
  Shaper shaper_;
  wire::Pacer pacer_;
  IoArea io_area_{};
  bool commanded_ = false, last_sent_ = false, rmi_gone_ = false;
  bool called_ = false;  // the streaming program
  bool fresh_ = true;    // the sequence of the packets begins again
  Outputs wanted_;
  Nanoseconds heard_ = 0, ending_since_ = 0, suspected_ = 0, asked_ = 0;
  std::uint32_t suspected_ms_ = 0;
  double speed_ = 0;  // mm/s, Cartesian
  std::atomic<bool> quit_{false};
  std::thread thread_;
};

}  // namespace polyarm::fanuc
