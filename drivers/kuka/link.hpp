#pragma once
/// The driver's end of the wires to one KUKA controller: RSI and EthernetKRL. While the link is open, one
/// thread answers the packets of RSI, another one asks for states and writes outputs.
#include <array>
#include <atomic>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>

#include "drivers/kuka/eki_link.hpp"
#include "drivers/kuka/rsi.hpp"
#include "drivers/kuka/words.hpp"
#include "drivers/wire/link_base.hpp"
#include "drivers/wire/shaper.hpp"
#include "drivers/wire/signals.hpp"
#include "drivers/wire/udp.hpp"

namespace polyarm::kuka {

/// What RSI measures. rad, rad/s.
struct Sample {
  Six q{}, dq{};
  Six pose{};  ///< mm and degrees X Y Z A B C; of the tool in the base that the program chose
  bool with_pose = false;
  int delay = 0;  ///< late answers in a row
  std::uint32_t inputs = 0;
  std::uint64_t sequence = 0;  ///< IPOC
  std::uint64_t count = 0;     ///< of packets since RSI began; 0: nothing came
  std::uint64_t lost = 0, repeated = 0, strangers = 0;
  double behind = 0;         ///< rad, of the sent command behind the loop's
  std::uint64_t shaped = 0;  ///< commands that were not sent as the loop gave them
};

/// What EthernetKRL shows.
struct Panel {
  EkiState state;
  std::uint64_t count = 0;  ///< 0: unknown
};

/// NaN: stays as it is.
struct Outputs {
  std::array<double, kMostSignals> digital;
  double speed_override;
  Outputs() noexcept;
};

struct LinkSettings : wire::StreamSettings {
  std::string host;
  bool eki = true;  ///< false: a person starts the program, and packets are answered from open() on
  int eki_port = 54600;
  std::string rsi_host;     ///< of the controller's RSI network; empty: `host`
  std::string rsi_address;  ///< of this machine; empty: the one that reaches the controller
  int rsi_port = 59152;
  std::string sen_type = kSenType;  ///< SENTYPE of the configuration of RSI
  int cycle_ms = 4;
  bool drives_on = true;  ///< activating may switch the drives on
  bool relative = false;  ///< corrections for one cycle each; known from EthernetKRL, if there is one
  double correction_limit = 360;  ///< degrees; the same
  wire::SignalRange outputs;
  wire::AxisLimits limits;  ///< degrees, of commands
};

class Link : public wire::StreamLink<EkiLink, Sample, Panel> {
 public:
  explicit Link(LinkSettings settings);
  ~Link() { close(); }

  /// Connects, reads versions and states. Nothing moves. False: see reason().
  bool open();
  void close();
  /// Starts RSI; the robot stands still. False: see reason().
  bool start();
  /// Brakes the robot and ends RSI.
  void stop();
  /// Asks for states once, and writes what changed. For simulated controllers, whose clock waits.
  void serve_services();

  // --- control thread; nothing waits, locks or allocates ---
  /// The newest command, rad. Without `move` the robot holds where it was commanded last.
  void command(bool move, const Six& joints) noexcept;
  void outputs(const Outputs& outputs) noexcept { outputs_.write(outputs); }

  /// Valid after open().
  const EkiIdentity& identity() const { return identity_; }
  double rate() const { return 1000.0 / settings_.cycle_ms; }
  int rsi_port() const { return wire::local_port(rsi_.number()); }

 private:
  struct Wanted {
    bool move = false;
    std::uint64_t count = 0;  ///< of the packet that the loop had read
    Six joints{};             ///< degrees
  };

  // how it begins and ends; link_setup.cpp
  bool connect_services();
  bool bind_rsi();
  bool end_old_session(bool runs);
  bool begin_program();
  bool await_running();
  bool await_rsi_end(Nanoseconds timeout);
  void give_up_start();
  void rest();
  std::string stranger() const {
    const std::lock_guard lock(mutex_);
    return stranger_;
  }

  // the thread of EthernetKRL; link_services.cpp
  void run_services();
  bool serve_round();
  bool take_panel(const EkiState& state);
  bool write_outputs();
  void judge_panel(const EkiState& state);
  Cause cause_of(const EkiState& state, int& detail) const;

  // the thread of RSI; link.cpp
  void run();
  void wait(Nanoseconds now);
  void begin_session(Nanoseconds now);
  void take_packets(Nanoseconds now);
  bool is_controller(const wire::UdpAddress& from);
  bool take_clock(const RsiRobot& robot);
  void check_cycle(std::uint64_t step);
  void fill_sample(const RsiRobot& robot);
  void take_packet(const RsiRobot& robot, Nanoseconds now);
  void answer(Nanoseconds now);
  void take_command(Nanoseconds now);
  void go_on();
  double stopping_way(std::size_t axis) const noexcept;
  bool allowed(const Wanted& wanted);
  void send(const Six& joints, bool stop = false);
  void brake();
  bool brakes() const noexcept { return phase_ == Phase::ending || fault_; }
  bool is_open() const noexcept { return answered_ != current_.count; }
  void judge(Nanoseconds now);
  void end(Nanoseconds now);

  LinkSettings settings_;
  EkiIdentity identity_;
  std::string own_address_;  // where RSI is listened to
  bool open_ = false;
  Descriptor rsi_, services_wake_;
  std::uint32_t sender_host_ = 0;  // network byte order

  std::recursive_mutex eki_mutex_;  // of eki_, and what belongs to it; never another thread's
  Outputs wanted_, written_;
  Panel current_panel_;

  realtime::Latest<Wanted> commands_;
  realtime::Latest<Outputs> outputs_;

  std::atomic<bool> go_{false};            // the loop may command as soon as RSI runs
  std::atomic<bool> silent_{false};        // packets ended, and nobody knows why yet
  std::atomic<bool> quiet_{false};         // its packets have ended
  std::atomic<bool> rsi_off_{false};       // EthernetKRL says so
  // Without EthernetKRL: RSI may still run, with corrections of an earlier session. Zero ones would move the
  // robot back to where RSI began, so that nothing is answered until its packets have ended.
  std::atomic<bool> displaced_{false};
  std::atomic<int> late_answers_{0};  // of the newest packet
  std::atomic<double> most_correction_{0};
  std::atomic<int> most_axis_{0};
  std::string stranger_;  // address of the first other sender; with mutex_

  // RSI's thread
  Sample current_;
  wire::Shaper shaper_;
  wire::UdpAddress sender_;
  Six base_{}, sent_{};  // degrees: where RSI began; what was sent last
  bool commanded_ = false, fresh_ = true, late_ = false;
  bool ended_ = false;                      // RSI was asked to end
  bool streamed_ = false;                   // the loop has commanded in this session
  std::uint64_t answered_ = 0;              // count of the last packet with an answer
  int steady_ = 0, behind_ = 0, slow_ = 0;  // packets in a row
  Nanoseconds heard_ = 0, commanded_at_ = 0, ending_since_ = 0;
  Cause unusable_ = Cause::none;  // what makes a start useless; with mutex_
  int unusable_detail_ = 0;
  std::thread thread_, services_;
};

}  // namespace polyarm::kuka
