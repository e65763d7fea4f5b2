#pragma once
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "polyarm/cell/cell_file.hpp"
#include "polyarm/cell/data_files.hpp"
#include "polyarm/cell/observer.hpp"
#include "polyarm/motion/robot_motion.hpp"
#include "polyarm/program/host.hpp"

namespace polyarm::cell {

/// Questions of programs and their answers: given in advance, or typed while they wait. Cell thread.
class Answers {
 public:
  void give(std::string text) { given_.push_back(std::move(text)); }
  /// True when somebody can type answers.
  bool somebody_there = false;
  std::deque<std::string>& given() { return given_; }

 private:
  std::deque<std::string> given_;
};

/// What a task of a cell reaches: the store under the task's name, and the motion of its robot if it has one.
class ProgramHost : public program::Host {
 public:
  struct Context {
    std::string task;
    data::DataStore* store = nullptr;
    DataFiles* files = nullptr;
    motion::RobotMotion* motion = nullptr;  ///< null: a task that moves nothing (a PLC)
    MotionEntry pace;
    Answers* answers = nullptr;
    Observer* observer = nullptr;
    const Nanoseconds* now = nullptr;
  };
  explicit ProgramHost(Context context) : c_(std::move(context)) {}

  const data::Value* find(std::string_view name) const override { return c_.store->find(name); }
  std::vector<std::string> names() const override { return c_.store->names(); }
  void set(const std::string& name, data::Value value, const Location& where) override;
  std::uint64_t data_version() const override { return c_.store->version(); }

  program::Handle start_move(const program::Move& move, const Location& where) override;
  program::Progress poll_move(program::Handle handle) override;
  bool room_for_move(const std::string&) override { return !moving_; }
  program::Handle start_arrival(const std::string& robot) override;
  program::Handle start_load(const std::string& name, program::LoadForm form, const Location& where) override;
  program::Progress poll_load(program::Handle handle) override;
  program::Handle start_ask(const std::string& text, const Location& where) override;
  program::Progress poll_ask(program::Handle handle) override;

  Nanoseconds now() const override { return *c_.now; }
  void log(const std::string& text, const Location& where) override {
    c_.observer->on_log(now(), c_.task, text);
  }

  /// True while a move of this task is under way.
  bool moving() const { return moving_; }

 private:
  Context c_;
  std::string target_;  ///< of the move under way
  std::uint64_t last_move_ = 0;
  bool moving_ = false;
};

/// The joint values of `joints` for the robot, by joint name whatever their order. Throws Error naming a
/// joint that the robot does not have, or one that is missing.
std::vector<double> joints_by_name(const description::RobotModel& model, const data::JointState& joints,
                                   const std::string& what);

}  // namespace polyarm::cell
