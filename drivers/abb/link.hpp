#pragma once
/// The driver's end of the wires to one ABB controller: EGM and Robot Web Services. While the link is open,
/// one thread answers the packets of EGM, another one asks for states and signals.
#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "drivers/abb/egm.hpp"
#include "drivers/abb/rws.hpp"
#include "drivers/abb/words.hpp"
#include "drivers/wire/link_base.hpp"
#include "drivers/wire/pacer.hpp"
#include "drivers/wire/shaper.hpp"
#include "drivers/wire/udp.hpp"

namespace polyarm::abb {

using wire::Six;

/// What EGM measures. rad, rad/s.
struct Sample {
  Six q{}, dq{};
  EgmPose pose;  ///< mm, of the tool in the work object that the RAPID module names
  std::array<double, 6> force{};
  bool with_pose = false, with_force = false;
  MotorState motors = MotorState::undefined;
  EgmState state = EgmState::undefined;
  RapidState rapid = RapidState::undefined;
  bool converged = false, collision = false;
  double utilization = 0;
  std::uint32_t sequence = 0, time_ms = 0;
  std::uint64_t count = 0;  ///< of packets since EGM began; 0: nothing came
  std::uint64_t lost = 0, repeated = 0, strangers = 0;
  double behind = 0;         ///< rad, of the sent command behind the loop's
  std::uint64_t shaped = 0;  ///< commands that were not sent as the loop gave them
};

inline constexpr std::size_t kMostSignals = 32;

/// What Robot Web Services show.
struct Panel {
  enum class Control : std::uint8_t { other, motors_on, motors_off, guard_stop, emergency_stop, failure };
  Control control = Control::other;
  bool automatic = false, running = false;
  double speed_ratio = 1;
  std::array<bool, kMostSignals> inputs{}, outputs{};
  Six joints{};  ///< rad, while EGM is silent
  std::uint64_t count = 0;
};

/// NaN: stays as it is.
struct Outputs {
  std::array<double, kMostSignals> digital;
  double speed_ratio;
  Outputs() noexcept;
};

struct LinkSettings : wire::StreamSettings {
  RwsSettings rws;
  std::string egm_address;  ///< of this machine; empty: the one that reaches the controller
  int egm_port = 6510;
  int sampling_ms = 4;
  std::string task = "T_ROB1";
  std::vector<std::string> inputs, outputs;  ///< names of signals
  bool motors_on = true;                     ///< activating may switch the motors on
  bool speed_reference = true;               ///< commands carry the velocity too
  wire::AxisLimits limits;                   ///< degrees, of commands
};

class Link : public wire::StreamLink<wire::LinkBase<Cause>, Sample, Panel> {
 public:
  explicit Link(LinkSettings settings);
  ~Link() { close(); }

  /// Connects, reads version, options, states and signals. Nothing moves. False: see reason().
  bool open();
  void close();
  /// Starts the program of the controller; the robot stands still. False: see reason().
  bool start();
  /// Brakes the robot and stops the program.
  void stop();
  /// Asks for states and signals once, and writes what changed. For simulated controllers, whose clock waits.
  void serve_services();

  // --- control thread; nothing waits, locks or allocates ---
  /// The newest command, rad. Without `move` the robot holds where it was commanded last.
  void command(bool move, const Six& joints) noexcept;
  void outputs(const Outputs& outputs) noexcept { outputs_.write(outputs); }

  /// Valid after open().
  const RwsIdentity& identity() const { return identity_; }
  std::string fingerprint() const { return fingerprint_; }
  double rate() const { return 1000.0 / settings_.sampling_ms; }
  int egm_port() const { return wire::local_port(egm_.number()); }

 private:
  struct Wanted {
    bool move = false;
    std::uint64_t count = 0;  ///< of the packet that the loop had read
    Six joints{};             ///< degrees
  };
  /// What made the robot stop, as EGM shows it.
  enum class Sign : std::uint8_t { none, motors, program, egm, error, silence, restart };

  // how it begins and ends; link_setup.cpp
  bool refuse_rws();
  bool connect_services();
  bool check_controller();
  bool bind_egm();
  bool read_all();
  bool read_signals(Panel& panel);
  bool check_panel();
  bool switch_motors_on();
  bool begin_program();
  bool await_running();
  bool refuse_why(Cause otherwise);
  void stop_program();
  void run_egm();
  void run_service_thread();
  void halt_threads();
  void begin_session();

  // the thread of EGM; link.cpp
  void run();
  void wait();
  void take_packets(Nanoseconds now);
  bool is_controller(const wire::UdpAddress& from);
  void take_packet(const EgmRobot& robot, Nanoseconds now);
  void check_start(const EgmRobot& robot);
  bool take_sequence(const EgmRobot& robot);
  void fill_sample(const EgmRobot& robot);
  void answer(const EgmRobot& robot);
  void answer_start(const EgmRobot& robot);
  void take_command(Nanoseconds now);
  void send(const Six& joints, const Six& velocity);
  void brake();
  bool brakes() const noexcept { return phase_ == Phase::ending || fault_ || sign_ != Sign::none; }
  void judge(Nanoseconds now);
  /// The newest packet waits for the loop's answer.
  bool is_open() const noexcept { return commanded_ && answered_ != current_.count; }
  Sign sign_of() const noexcept;
  Cause cause_of(Sign sign) const noexcept;
  void end(Nanoseconds now);

  // the thread of Robot Web Services; link_services.cpp
  void run_services();
  void serve_round();
  bool write_outputs();
  void say_why();
  Rws::Failure find_why(Sign sign);

  LinkSettings settings_;
  RwsIdentity identity_;
  std::string fingerprint_;
  bool open_ = false;
  Descriptor egm_, services_wake_;
  std::uint32_t controller_ = 0;  // its address, network byte order

  std::recursive_mutex
      rws_mutex_;  // the client, and what belongs to it; never the control thread's, nor EGM's
  Rws rws_;
  long seen_event_ = 0;
  Outputs wanted_, written_;
  Panel current_panel_;
  int round_ = 0, failures_ = 0;

  realtime::Latest<Wanted> commands_;
  realtime::Latest<Outputs> outputs_;
  std::atomic<Sign> asked_{Sign::none};  // the services shall say why
  std::atomic<bool> strange_{false};     // somebody else sends to EGM's port

  std::atomic<bool> stop_wanted_{false};

  // EGM's thread
  Sample current_;
  wire::Shaper shaper_;
  wire::Pacer pacer_;
  wire::UdpAddress sender_;
  Sign sign_ = Sign::none;
  bool commanded_ = false, fresh_ = true, running_ = false;
  bool late_ = false;           // the loop missed a packet, and has not caught up since
  std::uint64_t answered_ = 0;  // count of the last packet with an answer
  int steady_ = 0, behind_ = 0, errors_ = 0;
  std::uint32_t sequence_ = 0;
  Nanoseconds heard_ = 0, ending_since_ = 0, began_ = 0, sign_since_ = 0;
  Cause unusable_ = Cause::none;  // what makes the packets of a start useless; with mutex_
  int unusable_detail_ = 0;
  std::thread thread_, services_;
};

}  // namespace polyarm::abb
