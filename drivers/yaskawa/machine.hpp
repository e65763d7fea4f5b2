#pragma once
/// A simulated robot behind a simulated controller of Yaskawa: pendant, job, MotoROS' buffer, signals. It has
/// no sockets; far_side.hpp gives it some. Degrees, millimetres, seconds; motors count in pulses. One thread.
#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "drivers/wire/shaper.hpp"
#include "drivers/yaskawa/hses.hpp"
#include "drivers/yaskawa/moto.hpp"
#include "polyarm/base/pose.hpp"
#include "polyarm/description/robot_model.hpp"
#include "polyarm/kinematics/chain.hpp"

namespace polyarm::yaskawa {

using wire::Six;
using Pulses = std::array<std::int64_t, 6>;

/// What the robot's type fixes.
struct MachineFacts {
  std::string model = "GP7";
  Six lower{}, upper{}, velocity{};
  Six pulses{1500, 1500, 1500, 1200, 1200, 800};  ///< for a degree; an assumption
  std::shared_ptr<const kinematics::Chain> chain;
};
/// From a model of six revolute joints in a chain. Throws Error("bad-model").
MachineFacts facts_of(const description::RobotModel& model);

struct MachineOptions {
  MachineFacts facts;
  Six start{0, 0, 0, 0, -45, 0};
  std::string system = "YAS4.12.00A(EN/JP)-00", application = "GP7";
  int interpolation_ms = 4;
  int group = 0;
  double begin = 0.1;  ///< s, from the start of the job until it waits for MotoROS
};

enum class KeySwitch : std::uint8_t { teach, play, remote };

class Machine {
 public:
  explicit Machine(MachineOptions options);
  /// One interpolation cycle.
  void step();
  double period() const { return options_.interpolation_ms / 1000.0; }

  // What people do at the controller.
  void emergency(bool on);
  void turn_key(KeySwitch key);
  void switch_servo(bool on);
  void hold(int which, bool on);  ///< 1 pendant, 2 external, 3 command
  void stop_job();
  void raise_alarm(std::uint32_t code, const std::string& name);
  void raise_error();
  bool reset();
  void touch(bool on);  ///< power and force limiting
  void push_by_hand(const Six& change);

  // MotoROS.
  bool ready() const;
  int not_ready() const;  ///< NotReady
  /// Starts the job; `ready()` follows, or not. False: a person must do something first.
  bool start_trajectory();
  bool stop_trajectory();
  bool stop_motion();
  bool servo(bool on);
  struct Answer {
    MotoResult result;
    int subcode;
  };
  Answer take(const MotoPoint& point);
  int queued() const { return static_cast<int>(queue_.size()); }
  MotoFeedback feedback() const;
  MotoStatus status() const;
  bool starting() const { return running_ && !waiting_ && !stuck_job; }

  // The Ethernet server.
  HsesStatus panel() const;
  const HsesAlarm& alarm() const { return alarm_; }
  const std::vector<HsesAlarm>& history() const { return history_; }
  HsesPosition pulses() const;
  HsesPosition pose() const;
  std::array<std::int32_t, 8> torque() const;
  std::array<std::int32_t, 8> error() const;
  const std::string& job() const { return job_; }
  bool select_job(const std::string& name);
  std::uint64_t selections() const { return selections_; }
  bool start_job();
  bool runs(const std::string& job) const { return running_ && servo_on_ && job_ == job; }

  // Jobs in INFORM.
  bool servo_on() const { return servo_on_; }
  Six setpoint() const;
  bool still() const;
  /// To this place in the next cycle.
  void drive(const Six& degrees) { driven_ = pulses_of(degrees); }
  int cycle_mode = 3;  ///< 1 step, 2 one cycle, 3 continuous

  // Signals, numbers from 1.
  bool input(int number) const { return inputs_ >> (number - 1) & 1; }
  bool output(int number) const { return outputs_ >> (number - 1) & 1; }
  void set_input(int number, bool on);
  void set_output(int number, bool on);
  void wire_output(int output, int input) { wires_.emplace_back(output, input); }

  Pose tool;  ///< T_flange_tcp of the selected tool file

  MachineOptions& options() { return options_; }
  Six q() const;
  /// The largest difference of two commanded positions in a row. Degrees.
  double largest_jump() const { return jump_; }
  void forget_jumps() { jump_ = 0; }
  /// The largest speed of an axis since the last call, degrees/s.
  double take_fastest() { return std::exchange(fastest_, 0.0); }
  std::uint64_t points() const { return points_; }

  bool refuse_servo = false;
  bool stuck_job = false;     ///< the job starts and does not come to its wait
  bool refuse_step = false;   ///< the next step of a motion is refused
  bool refuse_speed = false;  ///< points are too fast
  bool other_moves = false;   ///< something else moves the robot
  bool deaf_hold = false;     ///< a hold by a command is confirmed, and the job runs on
  int busy = 0;               ///< points that find the controller busy

 private:
  struct Step {
    int time = 0;
    Pulses way{};
  };
  struct Motion {
    int time = 0;
    Six position{}, velocity{};  // degrees
  };
  bool operating() const { return running_ && servo_on_; }
  bool holds() const { return holds_[0] || holds_[1] || holds_[2]; }
  void stop_all();
  Pulses pulses_of(const Six& degrees) const;
  Answer begin(const Motion& first);
  void interpolate();
  void move();
  void follow();

  MachineOptions options_;
  Pulses command_{}, planned_{};
  std::array<double, 6> feedback_{}, speed_{};  // pulses, pulses/s
  std::optional<Pulses> driven_;
  std::deque<Step> queue_;
  Motion now_, from_, to_;
  bool data_ = false, segment_ = false;
  int calculated_ = 0, leftover_ = 0, queue_time_ = 0;
  double jump_ = 0, fastest_ = 0, since_start_ = 0;
  std::uint64_t points_ = 0, selections_ = 0;
  KeySwitch key_ = KeySwitch::remote;
  bool emergency_ = false, servo_on_ = true, running_ = false, waiting_ = false, error_ = false, pfl_ = false,
       step_error_ = false;
  std::array<bool, 3> holds_{};
  HsesAlarm alarm_;
  std::vector<HsesAlarm> history_;
  std::string job_ = "MASTER";
  std::uint32_t inputs_ = 0, outputs_ = 0;
  std::vector<std::pair<int, int>> wires_;
};

}  // namespace polyarm::yaskawa
