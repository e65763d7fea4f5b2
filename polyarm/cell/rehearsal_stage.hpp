#pragma once
/// The simulated host of a program in a rehearsal. Private to the rehearsal's files.
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/cell/prompter.hpp"
#include "polyarm/cell/rehearsal.hpp"
#include "polyarm/machine/around.hpp"
#include "polyarm/program/certainty.hpp"
#include "polyarm/tasks/program_moves.hpp"
#include "polyarm/vm/interpreter.hpp"

namespace polyarm::cell {

/// A program line that requests something, with the function calls that lead to it.
struct Asked {
  Location where;
  std::vector<Location> calls;
  std::string called;               ///< the calls as text, for messages
  std::optional<Location> handler;  ///< the `on error` that catches errors of this line
};

/// Assumptions of one pass through the program.
struct Supposition {
  std::optional<NamedValue> kept = {};    ///< a name that keeps one value during the pass
  bool only_tried = false;                ///< the value is only a guess; nothing in the cell states it
  std::optional<NamedValue> answer = {};  ///< answer to a question, by answer_name()
  std::string late = {};                  ///< location of a wait that times out
  std::string until = {};                 ///< location of a move whose `until` ends otherwise than usual
  std::string fails = {};                 ///< location of an `on error`; something before it fails once
};

/// A question asked by the program.
struct Question {
  std::string text;
  data::Value usual;  ///< the answer that Enter gives
};

/// Plans the program's moves, keeps the values that it sets, and tracks which values others may change. Cell
/// thread.
class Stage : public program::Host {
 public:
  static constexpr std::size_t kMostMoves = 500;

  /// `others` is a program that runs in parallel; null if there is none. `moves` is null if the program moves
  /// nothing.
  Stage(CellInside& cell, const program::Program& program, const program::Program* others,
        ProgramMoves* moves, bool with_paths);
  /// Restores the cell's values.
  ~Stage() override;
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;

  /// Sets the interpreter that runs the program. It must outlive the pass.
  void attend(const program::Interpreter* interpreter) { interpreter_ = interpreter; }
  /// Call before the program begins.
  void suppose(const Supposition& supposed);
  void wait_until(Nanoseconds time);
  /// Sets a name to a value that ends a wait. In the real cell others may or may not do that, so the name
  /// counts as unknown from then on.
  void help(const std::string& name, const data::Value& value);
  /// Reports that the program failed with the present values. If the line reads values that others may have
  /// changed, this is a warning; an error from `raise` stays an error if every run raises it.
  void report_failure(const program::TaskStatus& status);
  /// Reports that the program neither waited nor moved at this line for `statements` statements.
  void report_endless(const Location& where, int statements);
  /// Number of waits and moves so far.
  std::uint64_t events() const { return events_; }
  bool enough() const { return out_.moves >= kMostMoves; }
  /// Records where the program could not be followed further.
  void tell_reached(const Location& where) { out_.reached = where; }
  /// The findings; call once, at the end.
  Rehearsal take_result();
  /// The questions asked so far, by answer_name().
  const std::map<std::string, Question>& questions() const { return questions_; }

  // program::Host.
  const data::Value* find(std::string_view name) const override;
  std::vector<std::string> names() const override;
  void set(const std::string& name, data::Value value, const Location& where) override;
  std::uint64_t data_version() const override;
  program::Handle start_move(const program::Move& move, const Location& where) override;
  program::Progress poll_move(program::Handle) override;
  bool room_for_move(const std::string&) override { return true; }
  program::Handle start_arrival(const std::string& robot) override;
  void end_move(program::Handle, const Location&) override {}
  program::Handle suspend(const std::vector<std::string>& robots) override;
  program::Handle resume(const std::vector<std::string>& robots) override;
  program::Travel travel(program::Handle handle) const override;
  data::Value here(const std::string& robot, const std::string& tool,
                   const std::string& frame) const override;
  data::JointState here_joints(const std::string& robot) const override;
  data::JointState joints_at(const data::Value& place, const data::JointState* near, const std::string& robot,
                             const std::string& tool, const std::string& frame) const override;
  data::Point in_world(const data::Point& point) const override {
    return moves_ ? moves_->in_world(point) : point;
  }
  data::Value pose_at(const data::JointState& joints, const std::string& robot, const std::string& tool,
                      const std::string& frame) const override;
  /// Nothing touches here: until conditions of force do not come.
  std::array<double, 6> wrench(const std::string& robot) override;
  void zero_force(const std::string& robot) override { wrench(robot); }
  /// With an `else` it is usually met, without one not; the other case is another pass.
  bool supposes_met(const Location& where, bool has_else) override;
  /// A robot without a sensor cannot yield.
  void comply(const std::string& robot, const program::Compliance& how) override;
  void stiff(const std::string&) override {}
  /// A part is always there, where robots begin to follow it.
  bool next_part(const std::string& belt, const std::string& robot) override;
  double waiting_parts(const std::string& belt) override;
  double missed_parts(const std::string& belt) override;
  void add_part(const std::string& belt, const Pose&) override { waiting_parts(belt); }
  data::List rows_of(const std::string& file) override;
  /// Nobody knows what a device would send: the walk ends where the program takes a line.
  bool is_connected(const std::string& stream) override;
  bool has_line(const std::string& stream) override { return is_connected(stream); }
  std::string next_line(const std::string& stream) override;
  void send_text(const std::string& stream, const std::string&) override { is_connected(stream); }
  std::uint64_t seed() const override;
  void caught(const Problem& problem) override;
  program::Handle start_load(const std::string&, program::LoadForm, const Location& where) override;
  program::Progress poll_load(program::Handle) override { return program::Progress::done(); }
  program::Handle start_ask(const std::string& text, const Location& where) override;
  program::Progress poll_ask(program::Handle) override { return program::Progress::done(); }
  std::string answer(const data::Value& usual) const override;
  Nanoseconds now() const override { return now_; }
  void hold(const std::string&, const Location&) override {}
  void log(const std::string&, const Location&) override {}

 private:
  /// A move that counts as made.
  struct Went {
    Asked asked;
    bool to_joints = false;  ///< it ends at a joint state, or a base at a pose, independent of its start
    bool guessed = false;    ///< it cannot be made, but counts as made
  };
  struct Arm {
    const CellRobot* robot;
    std::vector<double> at;  ///< joints after all moves planned so far
    std::vector<std::pair<moves::Move, Asked>> waiting;
    std::shared_ptr<const moves::RobotFacts> with;
    bool lost;               ///< its position is unknown
    bool busy = false;       ///< the program has not waited for its latest move
    std::vector<Went> went;  ///< all moves made so far
    Pose base = {};          ///< T_world_base of a base with wheels, after all moves made so far
    std::vector<Went> driven = {};  ///< all moves of the base made so far
  };

  ProgramMoves& moves_of_program() const;
  std::vector<double> joints_now(std::size_t arm) const;
  program::Move from_now(const program::Move& move);
  void arrive();
  void have_arrived();
  ProgramMoves::Prepared prepare(const program::Move& move, const Location& where);
  bool is_raised_in_every_run(const Problem& problem) const;
  /// An error that an `on error` of the program catches, with its message.
  struct Caught {
    Problem problem;
    std::string raised;  ///< the text that the program sees
    Location handler;
  };

  void drive(const program::Move& move, const Asked& asked);
  void drive_to(std::size_t index, const Pose& goal, const Asked& asked);
  Pose root_of(std::size_t robot) const;
  surroundings::Moment moment() const;
  const std::shared_ptr<SharedBodies>& fixed_bodies();
  void queue(ProgramMoves::Prepared move, const Asked& asked);
  void plan(Arm& arm);
  std::shared_ptr<moves::Obstacles> obstacles(const Arm& arm, const std::vector<moves::Move>& moves);
  static std::vector<double> end_of(const Arm& arm, std::size_t count);
  void stay(Arm& arm, std::vector<double> at);
  void fail_as_supposed(const Location& where);
  void require_belt(const std::string& belt);
  void by_cell(const std::function<void()>& check);
  void raise_pending();
  bool report_passed_on(const Problem& problem);
  bool supposes() const {
    return !helped_.empty() || supposed_.answer || !supposed_.fails.empty() || !supposed_.until.empty() ||
           supposed_met_;
  }
  void check_on_the_way(const Arm& arm, const moves::RobotFacts& facts, const moves::PlannedMotion& motion);
  void keep_paths(const Arm& arm, const moves::RobotFacts& facts, const moves::MovePlan& plan);
  static void note_made(Arm& arm, std::size_t count);
  void find_again(Arm& arm);
  static std::vector<double> joints_at(const Arm& arm, const moves::MoveTarget& end,
                                       const std::vector<double>& seed);
  static bool is_out_of_reach(const Arm& arm, const moves::Move& move);
  bool start_known(const std::vector<Went>& made, Location where) const;
  bool values_known(const Asked& asked) const;
  std::vector<Location> calls_at(const Location& where) const;
  const program::Certainty& certainty() const;
  void report_where(const Arm& arm);
  void tell(Problem problem, const Asked& asked, bool known);

  CellInside& cell_;
  const program::Program& program_;
  const program::Interpreter* interpreter_ = nullptr;
  ProgramMoves* moves_;
  std::vector<Arm> arms_;
  Nanoseconds now_ = 0;
  std::uint64_t events_ = 0;
  std::set<std::string> open_;    ///< names whose values others change
  std::set<std::string> helped_;  ///< names that were set to end a wait
  std::map<std::string, data::Value> before_;
  Supposition supposed_;
  bool has_failed_ = false;         ///< the supposed error was raised
  bool supposed_met_ = false;  ///< an `until` counted as met: the robot is not certainly where it is planned
  std::set<std::string> of_cell_;   ///< texts of errors that follow from the files of the cell
  std::optional<Problem> pending_;  ///< an error of a move, to be raised in the program
  std::vector<Caught> caught_;
  mutable std::map<std::string, Question> questions_;
  std::string asked_, requested_text_;  ///< the last question
  bool with_paths_ = false;
  mutable bool here_known_ = true;  ///< false if a here() returned a position that may differ between runs
  mutable std::optional<program::Certainty> certainty_;
  std::set<std::pair<std::string, std::string>> announced_;
  std::vector<std::vector<double>> held_;  ///< where a trap stopped each arm
  mutable std::map<std::string, data::Value, std::less<>> in_world_;  ///< of points that name a frame
  description::Scene fixed_scene_;
  std::shared_ptr<SharedBodies> fixed_;  ///< of the robots and `fixed_scene_`
  Rehearsal out_;
};

}  // namespace polyarm::cell
