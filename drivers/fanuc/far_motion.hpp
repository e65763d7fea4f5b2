#pragma once
/// The queue of instructions of the simulated Remote Motion Interface: motions with FINE and CNT, waits,
/// frames. Degrees, millimetres, seconds; joint 3 as Stream Motion has it. One thread.
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "drivers/fanuc/machine.hpp"
#include "drivers/fanuc/rmi.hpp"

namespace polyarm::fanuc {

/// Runs instructions in their order. With CNT the next motion begins while this one slows down, and both are
/// added: with CNT 100 at the beginning of the slowing down, with CNT 0 at its end. FINE waits until the
/// robot stands. A pause and an end slow down on the path. Poses are reached near the present joints: the
/// turns and the arm's configuration of an instruction are not looked at.
class FarMotion {
 public:
  /// `finished(name, sequence, error)` is called for each instruction when it is done.
  using Finished = std::function<void(const std::string&, int, int)>;
  FarMotion(Machine& machine, Finished finished) : machine_(machine), finished_(std::move(finished)) {}

  /// 0, or the error number that refuses the instruction.
  int add(const RmiMessage& message);
  void cycle(double dt);
  /// The robot slows down on its path, and the instructions are forgotten.
  void clear(bool at_once = false);
  void hold(bool on) { held_ = on; }
  bool held() const { return held_; }
  bool idle() const { return queue_.empty() && active_.empty(); }
  int next_sequence() const { return next_; }
  void begin_again() { next_ = 1; }
  std::uint64_t done() const { return done_; }

 private:
  enum class Kind : std::uint8_t { motion, wait_input, wait_time, set_frame, set_tool, call };
  struct Instruction {
    std::string name;
    Kind kind = Kind::motion;
    int sequence = 0;
    RmiMessage message;
    double left = 0;  ///< s, of a wait
  };
  struct Motion {
    std::string name;
    int sequence = 0;
    std::vector<Six> path;  ///< at equal steps
    double time = 0, total = 0, ramp = 0;
    double blend = -1;  ///< share of the slowing down in which the next motion runs; below 0: FINE
    Six at(double t) const;
  };

  bool set_pace(double dt);
  int check_motion(const RmiMessage& message) const;
  bool begin(Instruction& instruction);
  int plan(const RmiMessage& message, Motion& out) const;
  std::optional<Six> target_of(const RmiMessage& message, const Six& from, const std::string& prefix) const;
  bool joints_of(const RmiMessage& message, const Six& from, Six& out) const;
  bool plan_line(const Six& from, const Six& to, Motion& out) const;
  bool plan_circle(const Six& from, const Pose& via, const Pose& to, Motion& out) const;
  int set_time(const RmiMessage& message, double length, Motion& out) const;
  Pose tool_pose(const RmiMessage& message, const std::string& prefix, const Six& from) const;
  Pose tool() const;
  Pose frame() const;
  Six now() const;
  void finish(const std::string& name, int sequence, int error);

  Machine& machine_;
  Finished finished_;
  std::deque<Instruction> queue_;
  std::deque<Motion> active_;
  Six base_{};
  bool held_ = false, ending_ = false;
  double pace_ = 1;  ///< share of the speed while the robot slows down or speeds up after a pause
  int next_ = 1;
  std::uint64_t done_ = 0;
};

}  // namespace polyarm::fanuc
