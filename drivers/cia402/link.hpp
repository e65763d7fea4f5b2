#pragma once
/// The connection to the drives of one arm. A thread of its own sends targets and SYNC in each cycle, takes
/// what the drives answer, and judges it. Angles in rad, torques in N m, of the joints.
///
/// open(), close(), start(), stop() come from one thread at a time and may wait. Connecting switches nothing
/// on; start() holds the measured positions; whatever ends the link makes every drive that is reached stop.
#include <memory>
#include <thread>
#include <vector>

#include "drivers/cia402/preparation.hpp"
#include "drivers/cia402/watchdog.hpp"
#include "drivers/watchdog/link.hpp"
#include "drivers/wire/link_base.hpp"

namespace polyarm::cia402 {

using Joints = std::array<double, kMostDrives>;

/// After each cycle.
struct Sample {
  Joints q{}, dq{}, effort{};
  std::uint64_t cycle = 0;
  std::uint32_t enabled = 0, limited = 0, warned = 0;  ///< one bit for each joint
  std::uint64_t lost = 0;                              ///< positions that did not come in their cycle
  std::uint64_t refused = 0;                           ///< frames that the adapter could not send
};
struct Wanted {
  bool move = false;
  Joints joints{};
};
struct NoPanel {};

class Link : public wire::StreamLink<wire::LinkBase<Cause>, Sample, NoPanel> {
 public:
  explicit Link(const Settings& settings);
  ~Link();

  bool open();
  void close() { close(false); }
  bool start();
  void stop();
  /// As close(), and switches the drives off if the settings say so.
  void shut_down();
  double rate() const noexcept { return 1 / seconds(settings_.cycle); }
  /// Drives that do not stop by themselves at the end of the heartbeat, and so need the watchdog process.
  bool needs_watchdog() const noexcept { return needs_watchdog_; }
  int watchdog_process() const noexcept { return watchdog_.process(); }

  // --- control thread ---
  /// `move` false: the drives keep their targets.
  void command(bool move, const Joints& joints) noexcept;

  // --- for drives that are simulated in this process ---
  /// The clock of the link stands still; exchange() moves it by a cycle.
  void hold(bool on) noexcept;
  void exchange(Nanoseconds timeout) noexcept;
  /// stop() without waiting; exchange() goes on until stands().
  void begin_stop() noexcept;
  bool stands() const noexcept { return stands_; }

 private:
  /// What the thread knows of a drive.
  struct Drive {
    StatePdo state;
    FeedbackPdo feedback;
    DriveState now = DriveState::not_ready;
    bool state_new = false, feedback_new = false, seen = false, restarted = false;
    int lost = 0;
    std::int32_t target = 0;
    std::uint16_t control = 0;
    int resets = 0;  ///< cycles of a fault reset
    int still = 0;   ///< cycles without motion
    std::int32_t was = 0;
    std::uint64_t measured_in = 0;  ///< cycle of the last position
    Emergency emergency;
    Nanoseconds alive = 0;  ///< of the last heartbeat
    NmtState nmt = NmtState::unknown;
    int puzzled = 0;         ///< cycles since a fault whose code has not come
    std::uint16_t code = 0;  ///< what it answered when it was asked for its error
    double rated_torque = 0;
  };

  bool introduce_all();
  bool await_first_positions();
  bool start_watchdog();
  watchdog::Names watchdog_names() const;
  void end_thread();
  void leave_drives(bool off);
  void close(bool off);

  void run();
  void cycle();
  void listen_until(Nanoseconds deadline);
  void collect();
  bool all_here() const noexcept;
  void take(const CanFrame& frame);
  bool take_pdo(const CanFrame& frame);
  bool take_heartbeat(const CanFrame& frame);
  std::optional<std::size_t> joint_of(int node) const noexcept;
  void bus_trouble(BusState state);
  void keep_time();
  void serve_step();

  void take_command();
  void steer();
  void steer_to_start(std::size_t joint);
  void steer_fault(std::size_t joint);
  void judge_start();
  void send_all();
  void set_target(std::size_t joint, double angle);
  void judge();
  void count_lost();
  void judge_silence();
  void name_silence();
  void judge_heartbeats();
  void judge_drive(std::size_t joint);
  void judge_network(std::size_t joint);
  void judge_fault(std::size_t joint);
  void judge_stand();
  void guard();
  void publish();
  void measure(std::size_t joint);
  void give_up_start(Cause cause, int detail, const std::string& text);
  void note_drive(std::size_t joint, Cause cause, int detail = 0);
  bool brakes() const noexcept { return phase_ == Phase::ending || fault_ || troubled_ || silent_; }
  bool lost(const Drive& drive) const noexcept { return drive.lost >= settings_.lost_cycles; }

  Settings settings_;
  std::unique_ptr<CanBus> bus_;
  std::vector<Drive> drives_;
  realtime::Latest<Wanted> commands_;
  bool needs_watchdog_ = false;
  std::mutex watch_mutex_;
  watchdog::Link watchdog_;
  std::atomic<bool> armed_{false};

  // of the thread
  Sample current_;
  bool commanded_ = false, bus_lost_ = false;
  std::optional<std::size_t>
      troubled_;  ///< the drive whose cause is being looked for; all others stop meanwhile
  std::optional<std::size_t> silent_;  ///< the same for one that sends nothing
  Nanoseconds silent_since_ = 0;
  bool gap_ = false;    ///< the last cycle was long ago
  bool blind_ = false;  ///< since a gap, the drives have not told their states: nothing is commanded
  int enabled_for_ = 0;
  std::uint64_t refused_before_ = 0;  ///< when the last position came
  Nanoseconds now_ = 0, due_ = 0, beaten_at_ = 0, commanded_at_ = 0, began_at_ = 0, ending_since_ = 0;

  std::atomic<bool> stepped_{false}, clock_changed_{false}, seen_all_{false};
  std::atomic<bool> stood_{true};  ///< at the last end, every drive that is reached was seen to stand
  std::atomic<std::uint64_t> asked_{0};
  std::uint64_t served_ = 0;
  Descriptor done_;
  std::thread thread_;
};

}  // namespace polyarm::cia402
