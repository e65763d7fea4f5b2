#pragma once
/// A simulated robot behind a simulated ABB controller: panel, program, EGM, event log, signals. It has no
/// sockets; far_side.hpp gives it some. Degrees, millimetres, seconds, as the controller has them. One
/// thread.
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "drivers/abb/egm.hpp"
#include "drivers/abb/rapid.hpp"
#include "drivers/abb/rws.hpp"
#include "drivers/wire/shaper.hpp"
#include "polyarm/base/pose.hpp"
#include "polyarm/description/robot_model.hpp"
#include "polyarm/kinematics/chain.hpp"

namespace polyarm::abb {

using wire::Six;

/// What the robot's type fixes.
struct MachineFacts {
  std::string model = "IRB 120";
  Six lower{}, upper{}, velocity{};
  std::shared_ptr<const kinematics::Chain> chain, tool_flange;  ///< tool_flange: of tool0
};
/// From a model of six revolute joints in a chain. Throws Error("bad-model").
MachineFacts facts_of(const description::RobotModel& model);

struct MachineOptions {
  MachineFacts facts;
  Six start{0, 0, 0, 0, 30, 0};
  RapidSettings rapid;  ///< what the RAPID module asks of EGM
  double gain = 5;      ///< 1/s, of the position loop ("Default proportional Position Gain")
  double begin = 0.1;   ///< s, from the program's start until EGM follows
  std::string software = "7.10.0";
  std::set<std::string> modules{kModuleName};
  std::map<std::string, bool> signals;  ///< names and states
};

class Machine {
 public:
  enum class Mode : std::uint8_t { automatic, manual, manual_full };
  enum class Egm : std::uint8_t { none, beginning, running, ending };

  explicit Machine(MachineOptions options);
  void step(double dt);

  // What people do at the controller.
  void emergency(bool on);
  void guard(bool open);
  void set_mode(Mode mode);
  void fail();     ///< system failure
  void restart();  ///< ends that, and everything that runs
  void collide();
  void stop_egm();  ///< as EGMStop in a trap; the program goes on
  void stop_with(int code, const std::string& title);
  void push_by_hand(const Six& change);

  // What Robot Web Services and the panel do. Each returns what is wrong; empty: done.
  std::string switch_motors(bool on);
  std::string reset_pointer();
  /// `once`: its main is run a single time.
  std::string start_program(bool once = false);
  void stop_program(const std::string& why = "");
  std::string set_signal(const std::string& name, bool on);

  // Moves of our program PolyarmMoves; far_moves.hpp makes them.
  /// The setpoint after the next step.
  void drive(const Six& next) { next_ = next; }
  /// The robot comes to rest on a straight ramp.
  void brake_moves();
  bool still() const;
  bool may_move() const { return running_ && moves_; }
  /// The program that runs, or ran last, is PolyarmMoves.
  bool makes_moves() const { return moves_; }
  /// Somebody presses Start at the FlexPendant: a program that was stopped goes on, with its path.
  void press_start();
  /// main ended, by itself or by ExitCycle.
  void end_cycle();
  bool runs_once() const { return once_; }

  /// A message of EGM for the robot.
  void take(const EgmSensor& message);

  std::string control() const;  ///< in the controller's words, as RwsState has them
  std::string mode_text() const;
  bool program_runs() const { return running_; }
  std::uint64_t starts() const { return starts_; }  ///< of the program
  bool motors() const { return motors_; }
  Egm egm() const { return egm_; }
  EgmState egm_state() const;
  bool converged() const { return egm_ == Egm::running && converged_; }
  bool collided() const { return collided_; }
  double utilization() const;
  const std::deque<RwsEvent>& events() const { return events_; }
  void event(int code, int kind, const std::string& title);

  MachineOptions& options() { return options_; }
  const MachineOptions& options() const { return options_; }
  const Six& q() const { return q_; }
  const Six& reference() const { return reference_; }
  double time() const { return time_; }
  /// The largest difference of two references in a row, or of the first one and the robot. Degrees.
  double largest_jump() const { return jump_; }
  void forget_jumps() { jump_ = 0; }
  /// The largest speed of a joint since the last call, degrees/s.
  double take_fastest() { return std::exchange(fastest_, 0.0); }
  double speed_ratio = 1;

  const std::map<std::string, bool>& signals() const { return options_.signals; }
  void wire_output(const std::string& output, const std::string& input) {
    wires_.emplace_back(output, input);
  }
  void set_input(const std::string& name, bool on) { options_.signals[name] = on; }
  bool locked_signals = false;  ///< Robot Web Services may not write them
  Pose flange() const;
  Pose tool0() const;

 private:
  void follow(double dt);
  void move(double dt);
  void stop_motion(double ramp);
  void judge_range();
  void judge_speed();
  bool egm_moves() const { return egm_ == Egm::running; }
  bool begin_at_main();
  Pose pose_of(const kinematics::Chain* chain) const;

  MachineOptions options_;
  Six q_, v_{}, reference_{}, speed_{};
  double time_ = 0, jump_ = 0, fastest_ = 0, since_begin_ = 0, since_message_ = 0, since_run_ = 0, ramp_ = 0;
  std::optional<Six> next_;
  bool moves_ = false, once_ = false;
  bool motors_ = true, emergency_ = false, guard_ = false, failed_ = false, running_ = false;
  bool referenced_ = false, converged_ = false, collided_ = false, pointer_at_main_ = true;
  Mode mode_ = Mode::automatic;
  Egm egm_ = Egm::none;
  std::deque<RwsEvent> events_;
  long sequence_ = 0;
  std::uint64_t starts_ = 0;
  std::vector<std::pair<std::string, std::string>> wires_;
};

}  // namespace polyarm::abb
