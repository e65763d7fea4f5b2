#pragma once
/// A simulated robot behind a simulated controller of Universal Robots: modes, safety, joints, inputs and
/// outputs. It has no sockets; far_side.hpp gives it some. rad, m, s. One thread.
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/ur/primary.hpp"
#include "drivers/ur/words.hpp"
#include "polyarm/description/robot_model.hpp"

namespace polyarm::ur {

using Six = std::array<double, 6>;

/// What the robot's type fixes.
struct MachineFacts {
  std::string model = "UR5e";
  int type = 1;  ///< the controller's number of it
  Six lower{}, upper{}, velocity{};
  Kinematics kinematics;  ///< nominal
  Kinematics arm;         ///< of this arm: the same unless it is calibrated
};
/// The arm gets errors as large as those that a factory measures: tenths of a millimetre, a milliradian.
void make_calibrated(MachineFacts& facts);
/// From a model of six revolute joints in a chain with the axes of these robots. Throws Error("bad-model").
MachineFacts facts_of(const description::RobotModel& model);

struct MachineOptions {
  MachineFacts facts;
  Six start{0, -1.5708, 0, -1.5708, 0, 0};
  int major = 5, minor = 15, bugfix = 0;
  bool on = true;      ///< powered, brakes released
  bool remote = true;  ///< remote control
};

class Machine {
 public:
  explicit Machine(MachineOptions options);

  /// One step of the controller.
  void step(double dt);

  // What the joints do until the next word.
  void servo(const Six& target, double lookahead);
  void speed(const Six& velocity, double acceleration);
  void brake(double deceleration);
  void follow(const Six& next);  ///< to this place in the next step
  bool still() const;

  // By the pendant and the dashboard. Each returns false if the robot refuses.
  bool switch_on();
  void switch_off();
  bool release_brakes();
  bool unlock();
  void safety(int mode);  ///< a stop; emergency stops switch the robot off
  void set_remote(bool on) { remote_ = on; }

  // The program. The far side runs it; the machine knows that there is one.
  enum class Program : std::uint8_t { none, playing, paused };
  void program(Program state) { program_ = state; }
  Program program() const { return program_; }
  bool may_move() const {
    return robot_mode_ == running && (safety_mode_ == safety_normal || safety_mode_ == safety_reduced);
  }

  /// The value of an RTDE output; empty: it is not simulated, and reads as zero.
  std::vector<double> value(std::string_view name) const;
  /// An RTDE input; apply_inputs() takes over what the masks choose, at the end of a package.
  void input(std::string_view name, double value);
  void apply_inputs();
  void set_register(const std::string& name, double value) { registers_[name] = value; }
  void digital_input(int bit, bool on);
  bool digital_output(int bit) const { return outputs_ >> bit & 1; }
  /// The input follows the output, as a vacuum switch follows its valve.
  void wire_output(int output, int input) { wires_.emplace_back(output, input); }
  void digital_output(int bit, bool on);
  void push_by_hand(const Six& change);
  /// RTDE declares an output as DOUBLE and reports this number, which may be none.
  void report_instead(const std::string& output, double value) { reported_[output] = value; }
  bool reports_instead(std::string_view output) const { return reported_.contains(output); }

  const MachineOptions& options() const { return options_; }
  const Six& q() const { return q_; }
  const Six& qd() const { return qd_; }
  int robot_mode() const { return robot_mode_; }
  int safety_mode() const { return safety_mode_; }
  bool remote() const { return remote_; }
  double time() const { return time_; }
  double speed_slider() const { return slider_; }
  /// The largest change of a target from one step to the next since the motion began, rad.
  double largest_jump() const { return jump_; }
  void forget_jumps() { jump_ = 0; }

 private:
  enum class Motion : std::uint8_t { brake, servo, speed, path };

  MachineOptions options_;
  Six q_, qd_{}, target_{};
  Motion motion_ = Motion::brake;
  double lookahead_ = 0.03, rate_ = 15, slider_ = 1, time_ = 41, stopped_at_ = 0, jump_ = 0;
  int robot_mode_ = power_off, safety_mode_ = safety_normal;
  bool remote_ = true, servoing_ = false;
  Program program_ = Program::none;
  std::uint64_t inputs_ = 0, outputs_ = 0;
  std::array<double, 2> analog_{};
  std::map<std::string, double, std::less<>> registers_, asked_, reported_;
  std::vector<std::pair<int, int>> wires_;
};

}  // namespace polyarm::ur
