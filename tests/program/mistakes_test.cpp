/// What `check` says of units that are missing or wrong, and of statements that cannot run together: in each
/// line the text that a person needs.
#include <gtest/gtest.h>

#include <string>

#include "polyarm/language/parser.hpp"
#include "polyarm/program/checker.hpp"

namespace polyarm::program {
namespace {

/// "LINE: what (advice)" of each finding.
std::string findings(const std::string& text) {
  KnownNames known;
  for (const char* point : {"A", "B"}) known.names[point] = type_of(data::Value(data::Point{}));
  Problems found;
  const Program program = parse(text, "job.script", found);
  check(program, known, found);
  std::string out;
  for (const Problem& p : found.list())
    out += std::to_string(p.where.line) + ": " + p.what + " (" + p.advice + ")\n";
  return out;
}

TEST(ProgramMistakes, AMissingOrWrongUnitIsShownAsItShouldBe) {
  struct Row {
    const char *line, *advice;
  };
  for (const Row& row :
       {Row{"log(offset(A, z = 200))", "(a length needs a unit: write 200mm)"},
        Row{"log(offset(A, x = -0.2))", "(a length needs a unit: write -0.2m)"},
        Row{"log(offset(A, rz = 90))", "(an angle needs a unit: write 90deg)"},
        Row{"log(offset(A, rz = 20mm))", "(write an angle such as 30deg)"},
        Row{"log(pose(400, 0, 0))", "(a length needs a unit: write 400mm)"},
        Row{"movel A, blend 20", "(a length needs a unit: write 20mm)"},
        Row{"movel A, duration 2", "(a time needs a unit: write 2s)"},
        Row{"movel A, payload 3", "(a mass needs a unit: write 3kg)"},
        Row{"movel A, around 3", "(write `around true`)"},
        Row{"movel A, payload 3mm", "(write a mass such as 2kg)"},
        Row{"drive 500", "(a length needs a unit: write 500mm)"},
        Row{"turn 90", "(an angle needs a unit: write 90deg)"},
        Row{"log(20mm + 5)", "(a length needs a unit: write 5mm)"},
        Row{"log(5 < 20deg)", "(an angle needs a unit: write 5deg)"},
        Row{"log(20mm + 5deg)", "(give both the same kind of unit)"},
        Row{"log(20mm * 5mm)", "divide by a unit first, such as d / 1mm"},
        Row{"wait 5", "(write `wait time 5` or `wait 5s`)"},
        Row{"let n = 2\nwait n", "(write `wait 1s`, or `wait n > 0` for a condition)"},
        Row{"let A = 2", "(it belongs to the data, the tags or the named states of the robot; "},
        Row{"log(1) // note", "(a comment begins with #)"},
        Row{"let n = 2\nset n = n++", "(count with `set N = N + 1`)"},
        Row{"wait 1 < 2 timeout 3", "(a time needs a unit: write 3s)"},
        Row{"for i in 1 .. 50mm\nend", "(write such as 1 .. 5)"},
        Row{"let far = 20mm\nset far = 3", "write a length such as 200mm)"}})
    EXPECT_NE(findings(row.line).find(row.advice), std::string::npos) << row.line << "\n"
                                                                      << findings(row.line);
}

TEST(ProgramMistakes, WordsOfOtherRobotLanguagesAreAnsweredWithOurs) {
  struct Row {
    const char *line, *advice;
  };
  for (const Row& row :
       {Row{"MODULE cell", "a file is a program; leave this line out"},
        Row{"VAR num k := 3", "(a new name is made with `let n = 3`"},
        Row{"def pick(p):\n  movel p\nend", "no statement begins with 'def' (a function is `func"},
        Row{"PROC place(p)\nENDPROC", "no statement begins with 'ENDPROC' (a block ends with `end`)"},
        Row{"PTP A", "(a joint move is `movej P`)"}, Row{"LIN A C_DIS", "(a straight line is `movel P`)"},
        Row{"MoveL A, v200", "(write `speed 200mm/s`)"}, Row{"MoveL A, z50", "(write `blend 50mm`)"},
        Row{"MoveL A, fine", "(write `exact`, or no blend)"},
        Row{"movel A, r = 0.02", "(write such as `blend 20mm`)"},
        Row{"movel(A, v = 0.25)", "clauses of a move follow its point without brackets"},
        Row{"movel p[0, 0, 0.1]", "an index is one number"},
        Row{"SetDO do1, 1", "outputs are tags of signals.yaml"},
        Row{"set_digital_out(1, true)", "outputs are tags of signals.yaml"},
        Row{"WaitTime 0.5", "(a time is waited with `wait 500ms`)"},
        Row{"WAIT SEC 0.5", "(write `wait 500ms`"},
        Row{"IF 1 > 2 THEN\nENDIF", "the block begins on the next line"},
        Row{"$OUT[1] = TRUE", "inputs and outputs are tags of signals.yaml"},
        Row{"socket_open(1)", "a socket is a stream of cell.yaml"}})
    EXPECT_NE(findings(row.line).find(row.advice), std::string::npos) << row.line << "\n"
                                                                      << findings(row.line);
}

TEST(ProgramMistakes, OneMistakeBringsOneError) {
  EXPECT_EQ(findings("func movej(a)\n  return a\nend\nlog(movej(1))\n"),
            "1: a function cannot be called 'movej': a statement begins with that word ()\n");
  const std::string lacking = findings("log(f())\n");
  EXPECT_EQ(lacking.find("fault"), std::string::npos) << "only tests have it: " << lacking;
  EXPECT_EQ(findings("log(M)\n").find("did you mean"), std::string::npos)
      << "one letter is not a misspelling";
  EXPECT_EQ(findings("movel A, speed 150%\n")
                .rfind("1: 'speed' as a percentage is at most 100%, here it is 150%", 0),
            0u);
  EXPECT_EQ(findings("include \"job.script\"\n").rfind("1: 'job.script' includes itself", 0), 0u);
}

TEST(ProgramMistakes, AnErrorHasFourFields) {
  const std::string found = findings("try\n  log(1)\non error e\n  log(e.knd, e.text)\nend\n");
  EXPECT_EQ(found, "4: there is no 'knd' in this record; did you mean 'kind'? (it has kind, text, line, robot)\n");
  EXPECT_EQ(findings("try\n  log(1)\non error e\n  set e = {code = 1}\n  log(e.code)\nend\n"), "");
}

TEST(ProgramMistakes, StatementsOfOneTogetherMoveRobotsOfTheirOwn) {
  const std::string twice = " is moved twice in one 'together', here and in line ";
  EXPECT_EQ(findings("together\n  movel A, robot left\n  movel B, robot left\nend\n")
                .rfind("3: 'left'" + twice + "2", 0),
            0u);
  EXPECT_EQ(
      findings("use robot right\ntogether\n  movel A\n  if 1 < 2\n    movel B, robot right\n  end\nend\n")
          .rfind("5: 'right'" + twice + "3", 0),
      0u);
  EXPECT_EQ(findings("together\n  movel A\n  movel B\nend\n").rfind("3: one robot" + twice + "2", 0), 0u);
  EXPECT_EQ(findings("together\n  movel A, robot left\n  movel A, robot right\nend\n"), "");
  EXPECT_EQ(
      findings(
          "together\n  lock table\n    movel A, robot left\n  end\n  lock table\n    movel B, robot left\n"
          "  end\nend\n"),
      "");
}

}  // namespace
}  // namespace polyarm::program
