#pragma once
/// Requests about the program of a cell: its state; run, step and load it; and events.
#include "polyarm/protocol/facts.hpp"
#include "polyarm/protocol/motion.hpp"
#include "polyarm/protocol/problem.hpp"

namespace polyarm::protocol {

struct FileLine {
  std::string file;
  int line = 0;
  POLYARM_MEMBERS(FileLine, file, line)
};

struct NamedText {
  std::string name, value;
  POLYARM_MEMBERS(NamedText, name, value)
};

enum class FindingSeverity { error, warning };
template <>
struct Words<FindingSeverity> {
  static constexpr const char* kNoun = "severity";
  static constexpr const char* kWords[] = {"error", "warning"};
};

struct TaskFacts {
  std::string name, state;
  FileLine where;
  std::string source, waits_for;
  std::vector<std::string> names;  ///< names that its condition reads
  std::string text;                ///< of its condition or question
  std::uint64_t passes = 0;
  bool paused = false;
  std::vector<FileLine> calls;  ///< outermost first
  std::vector<NamedText> variables;
  std::string robot, tool, frame;
  std::optional<std::string> problem;
  POLYARM_MEMBERS(TaskFacts, name, state, where, source, waits_for, names, text, passes, paused, calls,
                  variables, robot, tool, frame, problem)
};

/// A short status of a program.
struct ProgramOverview {
  std::string state;       ///< none, ready, running, waiting, finished, stopped or failed
  std::string file, name;  ///< path of the script that was read, and its path within the cell's folder
  std::string hash;        ///< of a program that is ready; lets a client start exactly what it has shown
  bool paused = false, ended = false;
  FileLine where;
  std::string source, sentence;  ///< the statement at `where`, and what the program does or waits for
  std::uint64_t passes = 0;      ///< of its outermost loop
  OrNull<double> last_pass_s;    ///< duration of the last complete pass, s of cell time
  OrNull<ProblemFacts> problem;
  POLYARM_MEMBERS(ProgramOverview, state, file, name, hash, paused, ended, where, source, sentence, passes,
                  last_pass_s, problem)
};

/// The full status of the cell's program.
struct ProgramStatus : ProgramOverview {
  std::string control, cause, holder, folder;
  std::vector<std::string> robots, held;
  std::uint64_t events = 0;
  std::vector<FileLine> breakpoints;
  OrNull<std::string> question;
  std::vector<TaskFacts> tasks;
  POLYARM_MORE_MEMBERS(ProgramStatus, ProgramOverview, control, cause, holder, folder, robots, held, events,
                       breakpoints, question, tasks)
};

struct ProgramState {
  static constexpr Facts kFacts{
      .name = "program",
      .role = Role::watch,
      .text =
          "Returns the state of the program (none, ready, running, waiting, finished, stopped or "
          "failed), its tasks, calls, variables and settings of moves. With `data` also every value "
          "that it can read."};
  bool data = false;
  struct Answer : ProgramStatus {
    static constexpr const char* kOf = "ProgramState";
    std::optional<std::map<std::string, std::string>> data;
    POLYARM_MORE_MEMBERS(Answer, ProgramStatus, data)
  };
  POLYARM_MEMBERS(ProgramState, data)
};

struct ProgramWatch {
  static constexpr Facts kFacts{
      .name = "program.watch",
      .role = Role::watch,
      .text = "Returns the same whenever it changes, at most `rate` times a second (10)."};
  std::optional<double> rate;
  using Answer = ProgramStatus;
  POLYARM_MEMBERS(ProgramWatch, rate)
};

struct ProgramPause {
  static constexpr Facts kFacts{
      .name = "program.pause",
      .role = Role::operate,
      .text =
          "Pauses before the next statement; queued motion continues. The answer comes when the program "
          "has paused, or immediately with `at_once`.",
      .moves = true,
      .patient = true};
  bool at_once = false;
  using Answer = ProgramStatus;
  POLYARM_MEMBERS(ProgramPause, at_once)
};

struct ProgramGo {
  static constexpr Facts kFacts{
      .name = "program.go", .role = Role::operate, .text = "Continues after a pause.", .moves = true};
  using Answer = ProgramStatus;
  POLYARM_MEMBERS(ProgramGo)
};

enum class StepHow { into, over, out };
template <>
struct Words<StepHow> {
  static constexpr const char* kNoun = "step";
  static constexpr const char* kWords[] = {"into", "over", "out"};
};

struct ProgramStep {
  static constexpr Facts kFacts{
      .name = "program.step",
      .role = Role::operate,
      .text =
          "Runs one statement of the paused task: `into` functions, `over` them (default), or until the "
          "present function has returned (`out`). The answer comes when the program has paused again, "
          "or immediately with `at_once`.",
      .moves = true,
      .patient = true};
  std::optional<StepHow> how;
  bool at_once = false;
  using Answer = ProgramStatus;
  POLYARM_MEMBERS(ProgramStep, how, at_once)
};

struct BreakpointList {
  std::vector<FileLine> breakpoints;
  POLYARM_MEMBERS(BreakpointList, breakpoints)
};

struct ProgramBreak {
  static constexpr Facts kFacts{
      .name = "program.break",
      .role = Role::program,
      .text =
          "Adds breakpoints before the lines `at` (LINE or FILE:LINE), and removes those at `off`; "
          "`clear` first removes all. A program that has not started keeps its breakpoints for its "
          "start. `text` is the text that the line numbers refer to, if it differs from the text that "
          "the program has read."};
  std::optional<Names> at, off;
  bool clear = false;
  std::optional<std::string> text;
  using Answer = BreakpointList;
  POLYARM_MEMBERS(ProgramBreak, at, off, clear, text)
};

struct ProgramEdited {
  static constexpr Facts kFacts{
      .name = "program.edited",
      .role = Role::program,
      .text =
          "Reports that `text` is the present text of the script `name`, saved or not. Its breakpoints "
          "move with their lines, or are set to `lines`. A running program keeps its text, and pauses "
          "at the same lines there."};
  std::string name, text;
  std::optional<Any> lines;
  using Answer = BreakpointList;
  POLYARM_MEMBERS(ProgramEdited, name, text, lines)
};

struct ProgramFrom {
  static constexpr Facts kFacts{
      .name = "program.from",
      .role = Role::operate,
      .text =
          "Starts a program that has ended or is paused anew at `line` (its first line), read from its "
          "file. The answer lists what the program assumes at that line; it waits for `program.go` "
          "unless `confirmed`. Refused as program-changed if the script `program` does not have the "
          "`hash` that `files.read` reported.",
      .moves = true};
  std::optional<double> line;
  std::optional<std::string> program;
  bool confirmed = false;
  std::optional<std::string> hash;
  struct Answer {
    static constexpr const char* kOf = "ProgramFrom";
    FileLine where;
    std::string source, robot, tool, frame, last_point;
    std::vector<NamedText> sets, reads, variables;
    std::vector<std::string> held;
    std::optional<std::string> next;
    POLYARM_MEMBERS(Answer, where, source, robot, tool, frame, last_point, sets, reads, variables, held, next)
  };
  POLYARM_MEMBERS(ProgramFrom, line, program, confirmed, hash)
};

struct ProgramStop {
  static constexpr Facts kFacts{
      .name = "program.stop",
      .role = Role::operate,
      .text = "Ends the program: moves stop on their paths, and its `on stop` block runs.",
      .moves = true};
  using Answer = ProgramStatus;
  POLYARM_MEMBERS(ProgramStop)
};

struct ProgramLoad {
  static constexpr Facts kFacts{
      .name = "program.load",
      .role = Role::operate,
      .text =
          "Reads and checks a script, or a data file that names one, with its data. Refused while a "
          "program runs. The loaded program is then ready, and the cell keeps running after it has "
          "ended."};
  std::string file;
  struct Answer : ProgramStatus {
    static constexpr const char* kOf = "ProgramLoad";
    std::vector<std::string> warnings;
    POLYARM_MORE_MEMBERS(Answer, ProgramStatus, warnings)
  };
  POLYARM_MEMBERS(ProgramLoad, file)
};

struct ProgramStart {
  static constexpr Facts kFacts{
      .name = "program.start",
      .role = Role::operate,
      .text =
          "Starts the program that is ready. `passes` ends its outermost loop after that many passes; "
          "`paused` pauses before its first line; `as_saved` reads it anew if its file has changed. "
          "Refused as program-changed if the ready program is not `file`, if it does not have the "
          "`hash` that `program` reported, or if its files do not have the hash `saved` (of `program` "
          "or `files.read`).",
      .moves = true};
  std::optional<double> passes;
  bool paused = false, as_saved = false;
  std::optional<std::string> file, hash, saved;
  using Answer = ProgramStatus;
  POLYARM_MEMBERS(ProgramStart, passes, paused, as_saved, file, hash, saved)
};

struct ProgramAnswer {
  static constexpr Facts kFacts{
      .name = "program.answer",
      .role = Role::operate,
      .text = "Answers the question of the program. Refused as answered-already until the program has taken an earlier "
              "answer, and as other-question if the question of the program is not `question` (the first line of the "
              "question that `program` reports).",
      .moves = true};
  std::optional<std::string> text, question;
  using Answer = Asked;
  POLYARM_MEMBERS(ProgramAnswer, text, question)
};

/// An event; `event` decides which members are present.
struct Event {
  std::uint64_t number = 0;  ///< counts up from 1
  std::string event;         ///< note, line, tag, log, state, stop, question or problem
  std::optional<double> time_s;
  std::optional<std::string> text;        ///< note, log, question, stop
  std::optional<std::string> task, file;  ///< line, log
  std::optional<int> line;
  std::optional<std::string> source;
  std::optional<std::string> name, value, by;            ///< tag
  std::optional<std::string> state, cause, cause_code;   ///< state, stop
  std::optional<std::string> code, where, what, advice;  ///< problem
  std::optional<FindingSeverity> severity;
  std::optional<double> at_s;  ///< stop, as in StopFacts
  std::optional<int> category;
  std::optional<std::map<std::string, double>> tcp_m, joints;
  POLYARM_MEMBERS(Event, number, event, time_s, text, task, file, line, source, name, value, by, state, cause,
                  cause_code, code, where, what, advice, severity, at_s, category, tcp_m, joints)
};

struct WatchEvents {
  static constexpr Facts kFacts{
      .name = "events",
      .role = Role::watch,
      .text =
          "Reports events: lines, logs, questions, tags, states, stops, problems and notes. Begins with "
          "those after number `since` (0: all that are kept)."};
  std::optional<double> since;
  using Answer = std::vector<Event>;
  POLYARM_MEMBERS(WatchEvents, since)
};

}  // namespace polyarm::protocol
