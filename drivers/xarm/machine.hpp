#pragma once
/// A simulated robot behind a simulated controller of UFACTORY: motors, modes, states, errors, signals. It
/// has no sockets; far_side.hpp gives it some. Degrees and seconds, millimetres on its wire. One thread.
#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "drivers/forward/path_player.hpp"
#include "drivers/wire/shaper.hpp"
#include "drivers/xarm/moves.hpp"
#include "drivers/xarm/report.hpp"
#include "drivers/xarm/ux.hpp"
#include "polyarm/description/robot_model.hpp"
#include "polyarm/kinematics/chain.hpp"

namespace polyarm::xarm {

/// What the robot's type fixes.
struct MachineFacts {
  std::string model = "xarm_6";
  std::size_t axes = 6;
  int type = 6;  ///< as the version names it
  Seven lower{}, upper{}, velocity{};
  std::shared_ptr<const kinematics::Chain> chain;
};
/// From a model of five to seven revolute joints in a chain. Throws Error("bad-model").
MachineFacts facts_of(const description::RobotModel& model);

struct MachineOptions {
  MachineFacts facts;
  Seven start{};
  std::string firmware = "1.12.10";
  int cycle_ms = 4;
};

class Machine {
 public:
  explicit Machine(MachineOptions options);
  Machine(const Machine&) = delete;
  Machine& operator=(const Machine&) = delete;
  /// One cycle.
  void step();
  double period() const { return options_.cycle_ms / 1000.0; }

  // What people do at the controller, and what happens to it.
  void emergency(int code, bool on);  ///< code 1 to 3
  void raise_error(int code);
  void raise_warning(int code) { warning_ = code; }
  void set_mode(int mode);
  void set_state(int state);
  void switch_motors(bool on);
  void push_by_hand(const Seven& change);

  /// A request of a client; `bits` and data of the reply.
  UxReply answer(const UxRequest& request);
  Report report() const;
  SlowReport slow_report() const;

  // Signals, numbers from 0.
  bool input(int number) const { return inputs_ >> number & 1; }
  bool output(int number) const { return outputs_ >> number & 1; }
  bool tool_output(int number) const { return tool_outputs_ >> number & 1; }
  void set_input(int number, bool on);
  void set_tool_input(int number, bool on);
  void wire_output(int output, int input) { wires_.emplace_back(output, input); }

  MachineOptions& options() { return options_; }
  Seven q() const { return measured_; }
  int error() const { return error_; }
  Mode mode() const { return mode_; }
  State state() const { return state_; }
  bool enabled() const { return enabled_; }
  bool is_ready() const { return enabled_ && state_ <= State::standing && error_ == 0; }
  /// The largest difference of two commanded positions in a row. Degrees.
  double largest_jump() const { return jump_; }
  void forget_jumps() { jump_ = 0; }
  /// The largest speed of a joint since the last call, degrees/s.
  double take_fastest() { return std::exchange(fastest_, 0.0); }
  std::uint64_t servo_commands() const { return servo_commands_; }
  /// The last cycle had a servo command, and the next one has none yet.
  bool awaits_target() const { return had_target_ && !has_target_ && is_ready(); }

  bool refuse_enable = false;   ///< the motors do not switch on
  bool refuse_mode = false;     ///< servo mode is not taken
  bool refuse_state = false;    ///< it does not become ready
  bool refuse_servo = false;    ///< servo commands are invalid
  bool refuse_moves = false;    ///< moves are invalid
  bool refuse_tool = false;     ///< another TCP is not taken
  bool ignore_stop = false;     ///< it is not stopped by a program
  bool locked_outputs = false;  ///< outputs cannot be written
  bool other_moves = false;     ///< something else moves the robot
  int other_axes = 0;           ///< that the version says; 0: its own

 private:
  struct Move {
    Seven target{};  ///< degrees
    double speed = 20, acceleration = 500;
  };
  using Data = std::vector<std::uint8_t>;

  // machine_requests.cpp
  Data read(const UxRequest& request, std::uint8_t& bits);
  bool act(const UxRequest& request);
  bool set_signals(const UxRequest& request);
  bool enable(const UxRequest& request);
  bool take_servo(const UxRequest& request);
  bool take_move(const UxRequest& request);
  bool play(const UxMove& move);
  bool take_velocity(const UxRequest& request);
  bool take_values(const UxRequest& request);
  Data forward(const UxRequest& request, std::uint8_t& bits) const;
  Data tool_register(const UxRequest& request, std::uint8_t& bits);
  std::optional<Seven> joints_in(Bytes data) const;

  void stop_motion();
  void follow_target();
  void follow_velocity();
  void plan();
  void play_moves();
  bool drive(const Six& next);
  void coast();
  bool stands() const;
  /// The controller interpolates: in position mode, for an arm with six joints. Others have joint moves only.
  bool plays() const { return mode_ == Mode::position && options_.facts.axes == 6 && options_.facts.chain; }
  std::size_t queued() const { return moves_.size() + player_.waiting(); }
  forward::PlayedArm played_arm();
  void measure();
  bool within_limits(const Seven& degrees) const;
  std::string version() const;
  Six pose_of(const Seven& degrees) const;
  std::uint8_t state_bits() const;

  MachineOptions options_;
  Seven command_{}, measured_{}, target_{}, velocity_{};
  bool has_target_ = false, had_target_ = false;
  std::deque<Move> moves_;
  bool planning_ = false;
  wire::ShaperOf<7> shaper_;
  forward::PathPlayer player_;
  Six played_{};             ///< rad: where the joints are, for the player
  std::optional<Six> next_;  ///< rad: where they go in this cycle
  Six last_pose_{};          ///< mm, rad: of the TCP, where the last move in the queue ends
  Seven speed_{};            ///< of the command, degrees/s
  double coasting_ = 0;      ///< s, until a robot stands whose moves were stopped
  int alone_ = 0;            ///< cycles with one move and none behind it
  double jump_ = 0, fastest_ = 0;
  std::uint64_t servo_commands_ = 0;
  bool enabled_ = true;
  int error_ = 0, warning_ = 0, pressed_ = 0;  // pressed_: code of the emergency stop
  Mode mode_ = Mode::position;
  State state_ = State::standing;
  std::uint32_t counter_ = 0, inputs_ = 0, outputs_ = 0, tool_inputs_ = 0, tool_outputs_ = 0;
  std::array<std::uint16_t, 2> analog_out_{};
  Six tcp_offset_{}, world_offset_{};
  std::array<double, 4> load_{};
  std::array<double, 3> gravity_{0, 0, -1};
  int collision_ = 3, teach_ = 3;
  std::vector<std::pair<int, int>> wires_;
};

}  // namespace polyarm::xarm
