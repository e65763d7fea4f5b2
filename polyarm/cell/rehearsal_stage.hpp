#pragma once
/// What a program that is rehearsed takes for its cell; for the rehearsal's own files.
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/cell/prompter.hpp"
#include "polyarm/cell/rehearsal.hpp"
#include "polyarm/program/certainty.hpp"
#include "polyarm/tasks/program_moves.hpp"
#include "polyarm/vm/interpreter.hpp"

namespace polyarm::cell {

/// A line of the program, with the calls of functions that lead to it.
struct Asked {
  Location where;
  std::vector<Location> calls;
  std::string called;               ///< the same for messages
  std::optional<Location> handler;  ///< the `on error` that catches an error of this line
};

/// What one pass through the program supposes.
struct Supposition {
  std::optional<NamedValue> kept = {};    ///< a name that has one value all the time
  bool only_tried = false;                ///< nobody has said that it has this value
  std::optional<NamedValue> answer = {};  ///< to a question, by answer_name()
  std::string late = {};                  ///< the place of a wait that times out
  std::string fails = {};                 ///< the place of an `on error`: something before it fails once
};

/// A question that the program has asked.
struct Question {
  std::string text;
  data::Value usual;  ///< the answer that Enter gives
};

/// Plans the moves that the program asks for, keeps the values that it sets, and knows which of them others
/// may change. Cell thread.
class Stage : public program::Host {
 public:
  static constexpr std::size_t kMostMoves = 500;

  /// `others`: a program that runs beside it; null: none. `moves`: null where it moves nothing.
  Stage(CellInside& cell, const program::Program& program, const program::Program* others,
        ProgramMoves* moves, bool with_paths);
  /// The cell has the values that it had before.
  ~Stage() override;
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;

  /// The interpreter that goes through the program. It outlives the going.
  void attend(const program::Interpreter* interpreter) { interpreter_ = interpreter; }
  /// Before the program begins.
  void suppose(const Supposition& supposed);
  void wait_until(Nanoseconds time);
  /// Sets a name to what ends a wait. In the cell others do that, or do not, and later it has any value.
  void help(const std::string& name, const data::Value& value);
  /// The program has failed with the values that there are. Where it reads what others may have changed by
  /// then, this is a warning; what the program raises
  /// itself is an error if every run raises it.
  void tell_failure(const program::TaskStatus& status);
  /// The program neither waits nor moves in this line, for so many statements.
  void tell_endless(const Location& where, int statements);
  /// Grows with every wait and every move.
  std::uint64_t events() const { return events_; }
  bool enough() const { return out_.moves >= kMostMoves; }
  /// The program could not be followed any further.
  void tell_reached(const Location& where) { out_.reached = where; }
  /// What was found, at the end.
  Rehearsal take_result();
  /// That were asked, by answer_name().
  const std::map<std::string, Question>& questions() const { return questions_; }

  // As of program::Host.
  const data::Value* find(std::string_view name) const override;
  std::vector<std::string> names() const override;
  void set(const std::string& name, data::Value value, const Location& where) override;
  std::uint64_t data_version() const override;
  program::Handle start_move(const program::Move& move, const Location& where) override;
  program::Progress poll_move(program::Handle) override;
  bool room_for_move(const std::string&) override { return true; }
  program::Handle start_arrival(const std::string& robot) override;
  void end_move(program::Handle, const Location&) override {}
  program::Travel travel(program::Handle handle) const override;
  data::Value here(const std::string& robot, const std::string& tool,
                   const std::string& frame) const override;
  program::Handle start_load(const std::string&, program::LoadForm, const Location& where) override;
  program::Progress poll_load(program::Handle) override { return program::Progress::done(); }
  program::Handle start_ask(const std::string& text, const Location& where) override;
  program::Progress poll_ask(program::Handle) override { return program::Progress::done(); }
  std::string answer(const data::Value& usual) const override;
  Nanoseconds now() const override { return now_; }
  void hold(const std::string&, const Location&) override {}
  void log(const std::string&, const Location&) override {}

 private:
  /// A move that was made.
  struct Went {
    Asked asked;
    bool to_joints = false;  ///< it ended at a joint state, wherever it came from
    bool guessed = false;    ///< it cannot be made, and counts as if it had been
  };
  struct Arm {
    const CellRobot* robot;
    std::vector<double> at;  ///< after all moves planned so far
    std::vector<std::pair<moves::Move, Asked>> waiting;
    std::shared_ptr<const moves::RobotFacts> with;
    bool lost;               ///< nobody knows where it is
    bool busy = false;       ///< the program has not waited for its latest move to arrive
    std::vector<Went> went;  ///< every move that it has made
  };

  program::Move from_now(const program::Move& move);
  void arrive();
  void have_arrived();
  ProgramMoves::Prepared prepare(const program::Move& move, const Location& where);
  bool is_raised_in_every_run(const Problem& problem) const;
  /// An error that an `on error` of the program catches, and its message.
  struct Caught {
    Problem problem;
    std::string raised;  ///< the text that the program sees
    Location handler;
  };

  void queue(ProgramMoves::Prepared move, const Asked& asked);
  void plan(Arm& arm);
  std::shared_ptr<moves::Obstacles> obstacles(const Arm& arm, const std::vector<moves::Move>& moves);
  static std::vector<double> end_of(const Arm& arm, std::size_t count);
  void stay(Arm& arm, std::vector<double> at);
  void fail_as_supposed(const Location& where);
  void raise_pending();
  bool tell_passed_on(const Problem& problem);
  bool supposes() const { return !helped_.empty() || supposed_.answer || !supposed_.fails.empty(); }
  void check_on_the_way(const Arm& arm, const moves::RobotFacts& facts, const moves::PlannedMotion& motion);
  void keep_paths(const Arm& arm, const moves::RobotFacts& facts, const moves::MovePlan& plan);
  static void note_made(Arm& arm, std::size_t count);
  void find_again(Arm& arm);
  static std::vector<double> joints_at(const Arm& arm, const moves::MoveTarget& end,
                                       const std::vector<double>& seed);
  static bool is_out_of_reach(const Arm& arm, const moves::Move& move);
  bool start_known(const Arm& arm, Location where) const;
  bool values_known(const Asked& asked) const;
  std::vector<Location> calls_at(const Location& where) const;
  const program::Certainty& certainty() const;
  void tell_where(const Arm& arm);
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
  bool has_failed_ = false;         ///< as supposed
  std::optional<Problem> pending_;  ///< an error of a move, for the program to catch
  std::vector<Caught> caught_;
  mutable std::map<std::string, Question> questions_;
  std::string asked_, asked_text_;  ///< the last question
  bool with_paths_ = false;
  mutable bool here_known_ = true;  ///< each here() was where the robot is in every run
  mutable std::optional<program::Certainty> certainty_;
  std::set<std::pair<std::string, std::string>> told_;
  mutable std::map<std::string, data::Value, std::less<>> in_world_;  ///< of points that name a frame
  description::Scene fixed_scene_;
  std::shared_ptr<SharedBodies> fixed_;  ///< of the robots and `fixed_scene_`
  Rehearsal out_;
};

}  // namespace polyarm::cell
