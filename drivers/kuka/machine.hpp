#pragma once
/// A simulated robot behind a simulated KUKA controller: panel, program, RSI, signals. It has no sockets;
/// far_side.hpp gives it some. Degrees, millimetres, seconds, as the controller has them. One thread.
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "drivers/kuka/eki.hpp"
#include "drivers/kuka/rsi.hpp"
#include "polyarm/base/pose.hpp"
#include "polyarm/description/robot_model.hpp"
#include "polyarm/kinematics/chain.hpp"

namespace polyarm::kuka {

/// What the robot's type fixes.
struct MachineFacts {
  std::string model = "KR 10 R1100-3";
  Six lower{}, upper{}, velocity{};
  std::shared_ptr<const kinematics::Chain> chain, tool_flange;  ///< tool_flange: what $TOOL counts from
};
/// From a model of six revolute joints in a chain. Throws Error("bad-model").
MachineFacts facts_of(const description::RobotModel& model);

struct MachineOptions {
  MachineFacts facts;
  Six start{0, -90, 90, 0, 45, 0};
  EkiIdentity identity;  ///< of the program there; axes and limits come from `facts`
  double begin = 0.1;    ///< s, from the program's start until RSI runs
};

class Machine {
 public:
  using Mode = OperatingMode;
  explicit Machine(MachineOptions options);
  /// One cycle of RSI.
  void step();
  double period() const { return options_.identity.cycle_ms / 1000.0; }

  // What people do at the controller.
  void emergency(bool on);
  void guard(bool open);
  void set_mode(Mode mode);
  void switch_drives(bool on);
  void stop_program();
  void cancel_program();
  void end_rsi();            ///< as RSI_OFF elsewhere; the program goes on
  void stop_with_message();  ///< a collision, a torque, a limit
  void acknowledge();
  void push_by_hand(const Six& change);

  // What our program does for EthernetKRL.
  EkiResult start();
  void stop() { end_rsi(); }
  EkiResult drives_on();
  EkiResult set_override(int percent);
  EkiResult set_output(int number, bool on);

  // Moves of our program PolyarmMoves; far_moves.hpp makes them.
  EkiResult begin_moves();
  /// The setpoint after the next step.
  void drive(const Six& next) { next_ = next; }
  /// The robot comes to rest on a straight ramp.
  void stop_moves();
  bool still() const;
  bool may_move() const { return program_runs() && drives_ && !emergency_ && !guard_ && !message_; }
  bool program_is_free() const { return program_ == ProgramState::free; }
  int speed_override() const { return override_; }
  const Six& setpoint() const { return setpoint_; }
  void press_start();  ///< of the program that is selected

  /// An answer for the newest packet.
  void take(const RsiSensor& answer);
  /// What RSI sends in this cycle.
  RsiRobot packet() const;
  std::uint64_t ipoc() const { return ipoc_; }
  bool rsi() const { return rsi_ == Rsi::running; }
  std::uint64_t sessions() const { return sessions_; }  ///< of RSI

  EkiReply reply() const;
  bool program_runs() const { return program_ == ProgramState::active; }

  MachineOptions& options() { return options_; }
  const Six& q() const { return q_; }
  /// The largest difference of two setpoints in a row. Degrees.
  double largest_jump() const { return jump_; }
  void forget_jumps() { jump_ = 0; }
  /// The largest speed of an axis since the last call, degrees/s.
  double take_fastest() { return std::exchange(fastest_, 0.0); }

  void wire_output(int output, int input) { wires_.emplace_back(output, input); }
  void set_input(int number, bool on);
  bool locked_outputs = false;  ///< our program may not write them
  bool refuse_start = false, refuse_drives = false;
  int rsi_error = 0;         ///< what RSI_CREATE returns; 0: RSIOK
  double hidden_limit = 0;   ///< degrees that the context of RSI allows less than it says
  std::uint64_t skip = 0;    ///< ms that the clock jumps ahead once
  bool slow = false;         ///< the clock makes steps of the other cycle
  bool renew_clock = false;  ///< the clock begins anew
  bool no_stop = false;      ///< the context of RSI does not end at the Stop of an answer

 private:
  enum class Rsi : std::uint8_t { off, beginning, running, braking };
  std::optional<Six> flange(const Six& joints) const;
  EkiResult ready() const;
  void stop_motion();
  bool follow_move();
  void follow();
  void judge();

  MachineOptions options_;
  Six q_, setpoint_, velocity_{}, base_{}, correction_{};
  std::optional<Six> next_;  ///< of a move
  bool driving_ = false;     ///< a move is under way
  double jump_ = 0, fastest_ = 0, since_begin_ = 0, ramp_ = 0;
  std::uint64_t ipoc_ = 4'208'000, sessions_ = 0;
  bool emergency_ = false, guard_ = false, drives_ = true, message_ = false, answered_ = true;
  int late_ = 0, rsi_return_ = 0, override_ = 100;
  std::uint32_t inputs_ = 0, outputs_ = 0;
  Mode mode_ = Mode::external;
  ProgramState program_ = ProgramState::free;
  Rsi rsi_ = Rsi::off;
  std::vector<std::pair<int, int>> wires_;
};

}  // namespace polyarm::kuka
