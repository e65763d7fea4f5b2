#pragma once
/// A simulated robot of Franka behind its controller: modes, motions by joints, limits, reflexes, recovery.
/// It has no sockets; far_side.hpp gives it some. rad and seconds. One thread.
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "drivers/franka/errors.hpp"
#include "drivers/franka/fci.hpp"
#include "drivers/franka/limits.hpp"
#include "polyarm/description/robot_model.hpp"
#include "polyarm/kinematics/chain.hpp"

namespace polyarm::franka {

/// What the robot's type fixes.
struct MachineFacts {
  int version = 9;  ///< of the interface: 5 for a Panda
  Seven lower{}, upper{};
  std::shared_ptr<const kinematics::Chain> chain;  ///< to the flange
};
/// From a model of seven revolute joints in a chain. Throws Error("bad-model").
MachineFacts facts_of(const description::RobotModel& model);

struct MachineOptions {
  MachineFacts facts;
  Seven start{0, -0.785398, 0, -2.356194, 0, 1.570796, 0.785398};
};

class Machine {
 public:
  explicit Machine(MachineOptions options);
  /// One millisecond.
  void step();
  double period() const { return 0.001; }

  // What people do at the robot, and what happens to it.
  void press_user_stop(bool on);
  void guide(bool on);
  void close_brakes(bool on);
  void safety_function(bool on);
  void raise(ErrorFlag flag);
  void push_by_hand(double first_joint);
  /// A force on the hand along z of the base, N.
  void set_force(double z);
  void sag(double second_joint) { sag_[1] = second_joint; }

  // What a client asks for.
  struct Answer {
    Status status = Status::success;
  };
  Answer answer(Request request, Bytes data, std::uint32_t id);
  /// A command for the newest state; an older one counts as none.
  void take(const RobotCommand& command);
  /// The client is gone.
  void leave();
  /// The end of a motion since the last call: id of its request, and how it ended.
  std::optional<std::pair<std::uint32_t, Status>> take_end() { return std::exchange(end_, std::nullopt); }
  RobotState state() const;

  int version() const { return options_.facts.version; }
  std::uint64_t id() const { return id_; }
  RobotMode mode() const { return mode_; }
  bool moves() const { return mode_ == RobotMode::move; }
  const ErrorFlags& errors() const { return errors_; }
  const CollisionBehavior& collision() const { return collision_; }
  const Load& load() const { return load_; }
  const Seven& joint_stiffness() const { return joint_stiffness_; }
  const Six& cartesian_stiffness() const { return cartesian_stiffness_; }
  const std::array<bool, 7>& guiding_axes() const { return guiding_axes_; }
  std::uint64_t commands() const { return commands_; }
  std::uint64_t recoveries() const { return recoveries_; }
  /// Measured, and desired. Degrees.
  Seven q() const;
  Seven q_d() const;
  /// The largest difference of two desired positions in a row. Degrees.
  double largest_jump() const;
  void forget_jumps() { jump_ = 0; }
  /// The largest commanded share of the limits of velocity, acceleration and jerk since the last call.
  Seven take_extremes() { return std::exchange(extremes_, Seven{}); }

  bool refuse_motion = false;    ///< motions are not possible
  bool refuse_settings = false;  ///< settings have an invalid argument
  bool refuse_recovery = false;  ///< a person must recover it
  bool singular = false;         ///< motions would start at a singular pose
  double success_share = 1;      ///< that the rate of success is multiplied with

 private:
  void follow();
  void extrapolate();
  bool within_limits(const Seven& q, const Seven& dq, const Seven& ddq);
  void advance(const Seven& q, const Seven& dq, const Seven& ddq);
  void brake();
  void measure();
  void judge_force();
  void end_motion(Status status);
  void stop_with(RobotMode mode, Status status);
  Status set(Request request, Bytes data);
  Status begin(Bytes data, std::uint32_t id);
  Status recover();

  MachineOptions options_;
  std::uint64_t id_ = 1000, commands_ = 0, recoveries_ = 0;
  Seven q_{}, dq_{}, q_d_{}, dq_d_{}, ddq_d_{}, sag_{}, extremes_{};
  RobotMode mode_ = RobotMode::idle;
  Generator generator_ = Generator::idle;
  Controller controller_ = Controller::other;
  ErrorFlags errors_, reflex_;
  bool brakes_closed_ = false, safe_ = false;
  std::optional<RobotCommand> command_;
  std::optional<std::uint32_t> motion_;
  std::optional<std::pair<std::uint32_t, Status>> end_;
  int missing_ = 0;           ///< commands in a row
  bool first_ = false;        ///< no command of this motion has come
  std::bitset<100> in_time_;  ///< commands, the newest first
  CollisionBehavior collision_;
  Load load_;
  Seven joint_stiffness_{3000, 3000, 3000, 2500, 2500, 2000, 2000};
  Six cartesian_stiffness_{2000, 2000, 2000, 100, 100, 100};
  std::array<bool, 7> guiding_axes_{true, true, true, true, true, true, true};
  Matrix4 ee_to_k_, ne_to_ee_;
  double force_ = 0, jump_ = 0;
};

}  // namespace polyarm::franka
