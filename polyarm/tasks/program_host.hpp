#pragma once
/// The environment of a task: connects the interpreter to the cell's data, motion, files and people.
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "polyarm/io/data_files.hpp"
#include "polyarm/io/streams.hpp"
#include "polyarm/setup/cell_file.hpp"
#include "polyarm/setup/observer.hpp"
#include "polyarm/tasks/force_readings.hpp"
#include "polyarm/tasks/program_moves.hpp"
#include "polyarm/vm/host.hpp"

namespace polyarm::cell {

/// Answers to the questions of programs: given in advance, or typed while a program waits. Cell thread.
class Answers {
 public:
  /// Adds an answer in advance, for the present or a later question.
  void give(std::string text) { given_.push_back(std::move(text)); }
  /// Answers the present question. False if it is answered already.
  bool answer(std::string text) {
    if (present_) return false;
    present_ = std::move(text);
    return true;
  }
  /// A new question was asked. What answered the one before does not answer it.
  void begin() { present_.reset(); }
  bool none() const { return !present_ && given_.empty(); }
  /// The next answer, if there is one.
  std::optional<std::string> take() {
    if (present_) return std::exchange(present_, std::nullopt);
    if (given_.empty()) return std::nullopt;
    std::string out = std::move(given_.front());
    given_.pop_front();
    return out;
  }
  /// True if a person can type answers.
  bool can_answer = false;

 private:
  std::deque<std::string> given_;
  std::optional<std::string> present_;
};

/// Implements program::Host for a task of the cell: data under the task's name, and motion of its robots if
/// it has any.
class ProgramHost : public program::Host {
 public:
  struct Context {
    std::string task;
    data::DataStore* store = nullptr;
    DataFiles* files = nullptr;
    ProgramMoves* moves = nullptr;  ///< null: the task moves nothing (a PLC)
    /// Without moves: a point of a frame, in the world as it is now; null: such points stay in their frames.
    std::function<data::Point(const data::Point&)> in_world;
    /// standing: true if every robot is at rest; null if unknown. hold: holds the robots.
    std::function<bool()> standing;
    std::function<void(const std::string&, const Location&)> hold;
    /// For a test only: starts a program, and calls the functions of tests; otherwise null.
    std::function<void(const std::string&, const Location&)> run_program;
    std::function<data::Value(std::string_view, std::span<const data::Value>, const Location&)> call;
    /// True if others read the name: from a user's own file, or over a link; null: nobody does.
    std::function<bool(const std::string& name)> seen_outside;
    Answers* answers = nullptr;
    Observer* observer = nullptr;
    const Nanoseconds* now = nullptr;
    std::uint64_t seed = 0;  ///< of random()
    bool keeps_events = false;  ///< a PLC
    ForceReadings* force = nullptr;
    Belts* belts = nullptr;
    Streams* streams = nullptr;
    std::filesystem::path folder;  ///< of the cell
  };
  explicit ProgramHost(Context context) : c_(std::move(context)) {}

  /// A point in a frame is returned in the world, by the present pose of the frame.
  const data::Value* find(std::string_view name) const override;
  std::vector<std::string> names() const override { return c_.store->names(); }
  void set(const std::string& name, data::Value value, const Location& where) override;
  void end_loop(const std::string& name, const Location& where) override {
    if (!c_.seen_outside || !c_.seen_outside(name)) set(name, false, where);
  }
  std::uint64_t data_version() const override { return c_.store->version(); }

  program::Handle start_move(const program::Move& move, const Location& where) override;
  program::Progress poll_move(program::Handle handle) override;
  bool room_for_move(const std::string& robot) override { return !c_.moves || c_.moves->has_room(robot); }
  bool ready_for(const program::Move& move, const Location& where) override {
    return !c_.moves || c_.moves->ready_for(move, where);
  }
  bool under_way(program::Handle handle) const override { return c_.moves && c_.moves->under_way(handle); }
  bool given_up(program::Handle handle) const override { return c_.moves && c_.moves->given_up(handle); }
  program::Handle start_arrival(const std::string& robot) override;
  void end_move(program::Handle handle, const Location&) override { c_.moves->end(handle); }
  program::Handle suspend(const std::vector<std::string>& robots) override;
  program::Handle resume(const std::vector<std::string>& robots) override;
  void abandon(const std::vector<std::string>& robots) override;
  program::Travel travel(program::Handle handle) const override { return c_.moves->travel(handle); }
  data::Value here(const std::string& robot, const std::string& tool,
                   const std::string& frame) const override;
  data::JointState here_joints(const std::string& robot) const override;
  data::JointState joints_at(const data::Value& place, const data::JointState* near, const std::string& robot,
                             const std::string& tool, const std::string& frame) const override;
  data::Point in_world(const data::Point& point) const override {
    return c_.moves ? c_.moves->in_world(point) : c_.in_world ? c_.in_world(point) : point;
  }
  data::Value pose_at(const data::JointState& joints, const std::string& robot, const std::string& tool,
                      const std::string& frame) const override;
  std::array<double, 6> wrench(const std::string& robot) override;
  void zero_force(const std::string& robot) override;
  void comply(const std::string& robot, const program::Compliance& how) override;
  void stiff(const std::string& robot) override;
  bool next_part(const std::string& belt, const std::string& robot) override;
  double waiting_parts(const std::string& belt) override;
  double missed_parts(const std::string& belt) override;
  void add_part(const std::string& belt, const Pose& at) override;
  data::List rows_of(const std::string& file) override;
  bool is_connected(const std::string& stream) override;
  bool has_line(const std::string& stream) override { return used(stream).has_line(); }
  std::string next_line(const std::string& stream) override { return used(stream).next_line(); }
  void send_text(const std::string& stream, const std::string& text) override { used(stream).send(text); }
  std::uint64_t seed() const override { return c_.seed; }
  program::Handle start_load(const std::string& name, program::LoadForm form, const Location& where) override;
  program::Progress poll_load(program::Handle handle) override;
  program::Handle start_ask(const std::string& text, const Location& where) override;
  program::Progress poll_ask(program::Handle handle) override;
  std::string answer(const data::Value&) const override { return answer_; }
  void run_program(const std::string& name, const Location& where) override;
  data::Value call(std::string_view function, std::span<const data::Value> arguments,
                   const Location& where) override;

  Nanoseconds now() const override { return *c_.now; }
  void log(const std::string& text, const Location& where) override {
    c_.observer->on_log(now(), c_.task, text);
  }

  bool keeps_events() const override { return c_.keeps_events; }
  bool standing() const override { return !c_.standing || c_.standing(); }
  void hold(const std::string& reason, const Location& where) override;

  /// True while a move of this task is running.
  bool moving() const { return c_.moves && c_.moves->moving(); }

 private:
  ProgramMoves& moves() const;
  /// `wanted`: of the message, if the cell has none.
  Streams& streams(const std::string& wanted) const;
  Stream& used(const std::string& stream);

  Context c_;
  mutable std::map<std::string, data::Value, std::less<>> in_world_;  ///< points that are given in a frame
  std::string answer_;
};

/// The rows of a table in the folder of the cell, or where the cell may read. Throws Error.
data::List rows_in(const std::filesystem::path& folder, const std::string& file);

/// The joint values for the robot, in its order; `joints` may have any order. Throws Error that names an
/// unknown or a missing joint, or one whose position was given in the unit of another kind of joint.
std::vector<double> joints_by_name(const description::RobotModel& model, const data::JointState& joints,
                                   const std::string& what);

}  // namespace polyarm::cell
