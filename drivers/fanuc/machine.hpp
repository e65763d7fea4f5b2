#pragma once
/// A simulated robot behind a simulated FANUC controller: modes, alarms, joints, inputs and outputs. It has
/// no sockets; far_side.hpp gives it some. Degrees, millimetres, seconds, as the controller has them; joint 3
/// as Stream Motion has it. One thread.
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "drivers/fanuc/limit_tables.hpp"
#include "drivers/fanuc/stream.hpp"
#include "polyarm/base/pose.hpp"
#include "polyarm/description/robot_model.hpp"
#include "polyarm/kinematics/chain.hpp"

namespace polyarm::fanuc {

/// What the robot's type fixes.
struct MachineFacts {
  std::string model = "CRX-10iA";
  Six lower{}, upper{}, velocity{}, acceleration{}, jerk{};
  std::shared_ptr<const kinematics::Chain> chain;
  double world_height = 0;  ///< m, of the controller's world frame above the base: the height of axis 2
};
/// From a model of six revolute joints in a chain. Throws Error("bad-model").
MachineFacts facts_of(const description::RobotModel& model);

struct MachineOptions {
  MachineFacts facts;
  Six start{0, 0, 0, 0, -90, 0};
  double lag = 0.02;          ///< s, of the joints behind their commands
  double table_share = 2;     ///< the tables of acceleration and jerk, of the description's limits
  double loaded_share = 0.8;  ///< the limits at full load, of those without
};

enum class TeachMode : std::uint8_t { automatic, t1, t2 };

class Machine {
 public:
  static constexpr int kPorts = 512;
  explicit Machine(MachineOptions options);

  /// One step of the controller towards the commanded joints.
  void step(double dt);
  void drive(const Six& joints);
  void stop() { commanded_ = q_; }  ///< at once, where it is

  // What people do.
  void emergency(bool on);
  void fence(bool open);
  void teach(TeachMode mode);
  void touch();  ///< a collaborative robot stops at a contact
  void alarm(const std::string& text);
  /// Clears alarms whose cause is gone; false if one stays.
  bool reset();
  void push_by_hand(const Six& change);

  bool servo_ready() const {
    return !emergency_ && !fence_ && alarm_.empty() && mode_ == TeachMode::automatic;
  }
  const std::string& alarm_text() const { return alarm_; }
  TeachMode mode() const { return mode_; }
  bool emergency() const { return emergency_; }
  std::uint8_t robot_bits() const;
  /// An emergency stop ends what moves a moment after its alarm, as measured on a CRX.
  bool may_move() const;
  ContactStop contact() const { return contact_; }
  bool moving() const;

  const MachineOptions& options() const { return options_; }
  const Six& q() const { return q_; }
  const Six& commanded() const { return commanded_; }
  double time() const { return time_; }
  /// The largest change of the commanded joints in one step, degrees.
  double largest_jump() const { return jump_; }
  void forget_jumps() { jump_ = 0; }

  // Inputs and outputs, numbered from 1; false and nothing out of range.
  bool input(int port) const { return valid(port) && inputs_[static_cast<std::size_t>(port - 1)]; }
  bool output(int port) const { return valid(port) && outputs_[static_cast<std::size_t>(port - 1)]; }
  void set_input(int port, bool on);
  void set_output(int port, bool on);
  /// The input follows the output, as a vacuum switch follows its valve.
  void wire_output(int output, int input) { wires_.emplace_back(output, input); }
  static bool valid(int port) { return port >= 1 && port <= kPorts; }

  /// X Y Z in mm, W P R in degrees, of the face plate in the controller's world frame.
  static std::array<double, 6> pose_values(const Pose& pose);
  static Pose pose_of(const std::array<double, 6>& values);
  Pose flange(const Six& joints) const;
  /// The joints that reach a pose of the face plate, near `seed`; empty if none is found.
  std::optional<Six> joints_for(const Pose& flange, const Six& seed) const;
  LimitTable limits(int axis, LimitKind kind) const;

  // What the Remote Motion Interface reads and writes.
  std::map<int, double> registers;
  std::map<int, std::array<double, 6>> frames, tools;
  int frame = 0, tool = 1, override_percent = 100;

 private:
  MachineOptions options_;
  Six q_, commanded_, last_q_;
  double time_ = 0, jump_ = 0, emergency_since_ = 0, speed_ = 0;
  bool emergency_ = false, fence_ = false;
  TeachMode mode_ = TeachMode::automatic;
  ContactStop contact_ = ContactStop::none;
  std::string alarm_;
  std::array<bool, kPorts> inputs_{}, outputs_{};
  std::vector<std::pair<int, int>> wires_;
};

}  // namespace polyarm::fanuc
