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
#include "drivers/abb/rws_link.hpp"
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

struct LinkSettings : wire::StreamSettings, ControllerSettings {
  std::string egm_address;  ///< of this machine; empty: the one that reaches the controller
  int egm_port = 6510;
  int sampling_ms = 4;
  bool speed_reference = true;  ///< commands carry the velocity too
  wire::AxisLimits limits;      ///< degrees, of commands
};

class Link : public wire::StreamLink<RwsLink, Sample, Panel> {
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

  // --- control thread; nothing waits, locks or allocates ---
  /// The newest command, rad. Without `move` the robot holds where it was commanded last.
  void command(bool move, const Six& joints) noexcept;

  double rate() const { return 1000.0 / settings_.sampling_ms; }
  int egm_port() const { return wire::local_port(egm_.number()); }

 private:
  struct Wanted {
    bool move = false;
    std::uint64_t count = 0;  ///< of the packet that the loop had read
    Six joints{};             ///< degrees
  };

  // how it begins and ends; link_setup.cpp
  bool check_controller();
  bool bind_egm();
  bool await_running();
  void run_egm();
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

  // of the thread of Robot Web Services
  bool guided() const override { return phase_ != Phase::idle; }
  void show(const Panel& panel) override { panels_.write(panel); }
  Cause vague_cause() const override { return strange_ ? Cause::other_sender : Cause::silent; }

  LinkSettings settings_;
  Descriptor egm_;

  realtime::Latest<Wanted> commands_;
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
  std::thread thread_;
};

}  // namespace polyarm::abb
