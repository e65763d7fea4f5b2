/// What `polyarm check` says about the ways of a program's moves.
#include "polyarm/cell/rehearsal.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "polyarm/cell/check.hpp"
#include "polyarm/setup/cell_file.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm::cell {
namespace {

const std::string kBend = "moveto joints(0, -30deg, 60deg, 0, 60deg, 0)\nlet start = here()\n";

void know_the_mock() {
  hardware::register_driver("mock",
                            [] { return std::unique_ptr<hardware::Component>(new drivers::MockComponent); });
}

struct Found {
  CheckResult result;
  std::string texts;
};
Found checked(const std::string& program, const std::string& more = "", const std::string& robots = "",
              const std::string& plc = "") {
  know_the_mock();
  const test::Folder folder;
  folder.write("go.script", program);
  folder.write(
      "tags.yaml",
      "polyarm: signals/1\ntags:\n  Ready: {initial: False}\n  Kind: {initial: 0}\n  Name: {initial: "
      "\"\"}\n  At: {state: arm/joint_1/position, type: number}\n");
  if (!plc.empty()) folder.write("plc.script", plc);
  folder.write("cell.yaml",
               "polyarm: cell/1\nrobots:\n" +
                   (robots.empty() ? "  arm: {model: " + test::kSixAxes + ", hardware: mock}\n" : robots) +
                   "program: go\n" + (plc.empty() ? "" : "plc: plc\n") + more);
  Found out{check(folder.path(), {}, description::Catalogue({}), {}), ""};
  for (const Problem& p : out.result.problems)
    out.texts += (p.severity == Severity::error ? "E" : "W") + std::to_string(p.where.line) + " " + p.code +
                 " " + p.what + "\n";
  return out;
}

TEST(Rehearsal, GoodWaysAreGood) {
  const Found found =
      checked(kBend +
              "for i in 1 .. 3\n  movel offset(start, y = i * 40mm, z = -50mm), blend 10mm\n"
              "  movel offset(start, y = i * 40mm), blend 10mm\nend\nmovel offset(start, x = 20mm)\n");
  EXPECT_EQ(found.texts, "");
  EXPECT_EQ(found.result.moves, 8u);
  EXPECT_TRUE(found.result.reached.file.empty());
}

const std::string kWithoutSensor =
    "  arm: {model: " + std::string(POLYARM_SOURCE_DIR) + "/examples/so101/so101.urdf, hardware: mock}\n";

TEST(Rehearsal, ARobotThatCannotYieldIsAnErrorWhateverTheValues) {
  const std::string program = "let push = ask(\"How hard?\", 10N)\ncomply(\"z\", force = push)\nstiff()\n";
  const Found stiff = checked(program, "", kWithoutSensor);
  EXPECT_EQ(stiff.texts, "E2 signal 'arm' has no force sensor, so it cannot yield to forces\n");
  const Found forward = checked(
      program, "", "  arm: {model: " + test::kSixAxes + ", hardware: mock, parameters: {motion: forward}}\n");
  EXPECT_NE(forward.texts.find("E2 forward-mode 'arm' has `motion: forward`"), std::string::npos)
      << forward.texts;
  const Found caught = checked("try\n  comply(\"z\")\non error e\n  log(e.text)\nend\n", "", kWithoutSensor);
  EXPECT_EQ(caught.texts.find("E"), std::string::npos) << caught.texts;
}

TEST(Rehearsal, SensorsBeltsAndStreamsThatTheCellDoesNotHaveAreErrors) {
  for (const char* call : {"log(force())\n", "zero_force()\n"})
    EXPECT_EQ(checked(call, "", kWithoutSensor).texts, "E1 signal 'arm' has no force sensor\n");
  EXPECT_EQ(checked("wait next_part(\"line\")\n").texts, "E1 unknown-belt the cell has no belt 'line'\n");
  EXPECT_EQ(checked("log(missed_parts(\"line\"))\n").texts, "E1 unknown-belt the cell has no belt 'line'\n");
  const std::string camera = "streams:\n  camera: {connect: \"127.0.0.1:7001\"}\n";
  for (const char* call :
       {"send_text(\"camra\", \"x\")\n", "wait has_line(\"camra\")\n", "log(next_line(\"camra\"))\n"})
    EXPECT_EQ(checked(call, camera).texts,
              "E1 unknown-stream the cell has no stream 'camra'; did you mean 'camera'?\n");
  EXPECT_EQ(checked("wait has_line(\"camera\")\nsend_text(\"camera\", \"x\")\n", camera).texts, "");
  EXPECT_EQ(checked("comply(\"q\")\n").texts.substr(0, 3), "E1 ");
}

TEST(Rehearsal, EveryLineThatCannotBeGoneIsNamed) {
  const Found found = checked(kBend +
                                  "movel offset(start, z = -500mm)\n"  // 3: below the table
                                  "moveto joints(0, -30deg, 60deg, 0, 60deg, 0)\n"
                                  "movel offset(start, z = -50mm)\n"
                                  "movel offset(start, x = 9m)\n"  // 6: out of reach
                                  "movel start\n"
                                  "moveto joints(0, -30deg, 60deg, 0, 60deg, 0)\n"
                                  "movel offset(start, z = -400mm)\n",  // 9
                              "workspace:\n  table: {plane: [0, 0, 1300mm], normal: [0, 0, 1]}\n");
  EXPECT_NE(found.texts.find("E3 workspace"), std::string::npos) << found.texts;
  EXPECT_NE(found.texts.find("crosses 'table'"), std::string::npos) << found.texts;
  EXPECT_NE(found.texts.find("\nE6 "), std::string::npos) << found.texts;
  EXPECT_NE(found.texts.find("\nE9 workspace"), std::string::npos) << found.texts;
  EXPECT_EQ(found.texts.find("E4 "), std::string::npos) << found.texts;
  EXPECT_EQ(found.texts.find("E5 "), std::string::npos) << found.texts;
}

TEST(Rehearsal, ALineThroughASingularityIsJudgedByItsWay) {
  // Both ends are in reach; the straight way between them leads through the robot's own axis.
  const Found found = checked(
      "moveto joints(0, -60deg, 100deg, 0, 60deg, 0)\nlet start = here()\n"
      "movel offset(start, x = -2 * start.x, y = -2 * start.y)\n");
  EXPECT_NE(found.texts.find("E3 "), std::string::npos) << found.texts;
  EXPECT_NE(found.texts.find("joint_"), std::string::npos) << found.texts;
}

const std::string kTags = "signals: tags.yaml\n";
const std::string kTable = kTags + "workspace:\n  table: {plane: [0, 0, 1300mm], normal: [0, 0, 1]}\n";

TEST(Rehearsal, WhatIsWrongWhateverAWaitBringsIsAnErrorBehindItToo) {
  const std::string texts =
      checked("wait Ready\n" + kBend + "wait Ready == False\nmovel offset(start, z = -500mm)\n", kTable)
          .texts;
  EXPECT_EQ(texts.rfind("E5 workspace", 0), 0u) << texts;
  EXPECT_EQ(checked("wait Ready\nmovej joints(9rad, 0, 0, 0, 0, 0)\n", kTags).texts.rfind("E2 ", 0), 0u);
  EXPECT_EQ(checked("wait Ready\nmovej pose(3m, 0, 1m)\n", kTags).texts.rfind("E2 ", 0), 0u);
  const std::string loop =
      checked(
          "let n = 0\nwhile Ready == False\n  set n = n + 1\n  wait Ready\n  movej pose(3m, 0, 1m)\nend\n",
          kTags)
          .texts;
  EXPECT_EQ(loop.rfind("E5 ", 0), 0u) << loop;
}

TEST(Rehearsal, WhatDependsOnWhatAWaitBringsIsAWarning) {
  const auto first = [](const std::string& program) { return checked(program, kTable).texts.substr(0, 3); };
  EXPECT_EQ(first("wait Ready\nlet far = 3m\nif Ready\n  set far = 4m\nend\nmovej pose(far, 0, 1m)\n"), "W6 ")
      << "by a value";
  EXPECT_EQ(first("wait Ready\nmovej pose(1m * At + 5m, 0, 1m)\n"), "W2 ") << "by a measured value";
  EXPECT_EQ(
      first(kBend +
            "let low = offset(start, z = -50mm)\nwait Ready\nif Ready\n"
            "  movej joints(0, -20deg, 60deg, 0, 60deg, 0)\nend\nmovel low\nmovel offset(low, z = -400mm)\n"),
      "W9 ")
      << "by where the robot is then";
}

TEST(Rehearsal, ValuesThatAProgramFailsWithAreErrorsIfNothingElseChangesThem) {
  const auto first = [](const std::string& program) { return checked(program, kTags).texts.substr(0, 3); };
  EXPECT_EQ(first("func f(x)\n  return 1 / x\nend\nlog(f(0))\n"), "E2 ");
  EXPECT_EQ(first("func f(v)\n  movej joints(0, 0, 0, 0, 0, 0), speed v\nend\nf(-20mm/s)\n"), "E2 ");
  EXPECT_EQ(first("for x in [1, 0]\n  log(1 / x)\nend\n"), "E2 ");
  EXPECT_EQ(first("let l = [1, 2, 3]\nfor i in 1 .. 4\n  log(l[i])\nend\n"), "E3 ");
  EXPECT_EQ(first("for v in [10mm/s, 20mm]\n  movej joints(0, 0, 0, 0, 0, 0), speed v\nend\n"), "E2 ");
  EXPECT_EQ(first("let n = 3\nwhile n > -1\n  log(1 / n)\n  set n = n - 1\nend\n"), "E3 ");
  EXPECT_EQ(
      first("func down(n)\n  if n == 0.5\n    return 0\n  end\n  return down(n - 1)\nend\nlog(down(3))\n"),
      "E5 ");
  EXPECT_EQ(first("func f(n)\n  wait Ready\n  return 1 / n\nend\nlog(f(0))\n"), "E3 ") << "behind a wait";
  EXPECT_EQ(first("log(1 / Kind)\n"), "E1 ") << "nobody in the cell changes Kind";
  EXPECT_EQ(first("wait Kind > 2\nlog(1 / (Kind - 3))\n"), "W2 ") << "who ends the wait does";
  EXPECT_EQ(first("log(1 / At)\n"), "W1 ") << "the hardware measures At";
  EXPECT_EQ(first("let l = [1, 2]\nfor i in 1 .. 4\n  if Kind < i\n    break\n  end\n  log(l[i])\nend\n"),
            "");
}

TEST(Rehearsal, WaitsForNumbersAndTextsAreHelped) {
  const auto texts = [](const std::string& program) {
    const Found found = checked(program, kTags);
    return found.texts.substr(0, 3) + found.result.reached.text();
  };
  EXPECT_EQ(texts("wait Kind >= 4\nmovej pose(3m, 0, 1m)\n"), "E2 ");
  EXPECT_EQ(texts("wait Name == \"red\" and At < -0.5\nmovej pose(3m, 0, 1m)\n"), "E2 ");
}

TEST(Rehearsal, BranchesThatOtherValuesLeadToAreGoneThrough) {
  const auto texts = [](const std::string& program, const std::string& plc) {
    return checked(program, kTags, "", plc).texts.substr(0, 3);
  };
  const std::string plc = "wait Ready\nset Name = \"blue\"\nset Kind = 3\n";
  const std::string far = "  movej pose(3m, 0, 1m)\nend\n", near = "  movej joints(0, 0, 0, 0, 0, 0)\n";
  EXPECT_EQ(texts("set Ready = true\nwait Name != \"\"\nif Name == \"red\"\n" + near + "else\n" + far, plc),
            "E6 ");
  EXPECT_EQ(texts("set Ready = true\nif Kind > 2\n" + far, plc), "E3 ");
  EXPECT_EQ(
      texts("func go(p)\n  movej p\nend\nset Ready = true\nif Kind > 2\n  go(pose(3m, 0, 1m))\nend\n", plc),
      "E2 ");
  EXPECT_EQ(texts("if Ready\n" + far, ""), "E2 ") << "a person may set it";
  EXPECT_EQ(texts("set Kind = 1\nif Kind > 2\n" + far, ""), "") << "nobody sets it to that";
  EXPECT_EQ(texts("set Ready = true\nif Kind > 2\n  log(1 / (Kind - 4))\nend\n", plc), "")
      << "4 was only tried";
}

TEST(Rehearsal, WhatIsWrongInAFunctionIsToldWithItsCalls) {
  const std::string moves =
      checked("func inner(p)\n  movej p\nend\nfunc outer(x)\n  inner(pose(x, 0, 1m))\nend\nouter(3m)\n")
          .texts;
  EXPECT_EQ(moves.rfind("E2 ", 0), 0u) << moves;
  EXPECT_NE(moves.find("; called from line 5, from line 7\n"), std::string::npos) << moves;
  const std::string values = checked("func f(x)\n  return 1 / x\nend\nlog(f(0))\n").texts;
  EXPECT_EQ(values, "E2 zero '/' by zero; called from line 4\n");
}

TEST(Rehearsal, WhatAMoveSetsOutsideOfItsWayIsAWarning) {
  const std::string line = "movel offset(start, z = -50mm), at ";
  const auto texts = [&](const std::string& at) {
    return checked(kBend + line + at + " set Ready = true\n", kTags).texts;
  };
  EXPECT_EQ(texts("end - 500mm"), "W3 at-outside the move is 0.05m long: 'Ready' is set where it begins\n");
  EXPECT_EQ(texts("start + 80mm"), "W3 at-outside the move is 0.05m long: 'Ready' is set where it ends\n");
  EXPECT_NE(texts("start + 20s").find("W3 at-outside the move takes "), std::string::npos);
  EXPECT_EQ(texts("end - 40mm"), "");
}

TEST(Rehearsal, BlendsThatAreShrunkAreTold) {
  const std::string texts =
      checked(kBend +
              "movel offset(start, z = -50mm), blend 400mm\nmovel offset(start, z = -50mm, y = 50mm)\n")
          .texts;
  EXPECT_EQ(texts.rfind("W3 blend-shrunk", 0), 0u) << texts;
}

TEST(Rehearsal, ATimeOutIsTakenToo) {
  const auto texts = [](const std::string& program) { return checked(program, kTags).texts.substr(0, 9); };
  const std::string far = "movej pose(3m, 0, 1m)\n";
  EXPECT_EQ(texts("wait Ready timeout 1s else\n  " + far + "end\n").substr(0, 3), "E2 ");
  EXPECT_EQ(texts("try\n  wait Ready timeout 1s\non error e\n  " + far + "end\n").substr(0, 3), "E4 ");
  EXPECT_EQ(texts("let n = 0\nwait Ready timeout 1s else\n  set n = 3\nend\nlog(10 / (n - 3))\n").substr(1),
            "5 zero '");
  EXPECT_EQ(texts("wait Ready timeout 1s else\n  stop\nend\n"), "");
}

TEST(Rehearsal, BehindASearchTheProgramIsFollowed) {
  const std::string search = "movel offset(start, z = -50mm), until Ready else\n  raise \"nothing\"\nend\n";
  EXPECT_EQ(checked(kBend + search + "movel start\n", kTags).texts, "");
  EXPECT_NE(checked(kBend + search + "movel offset(start, x = 9m)\n", kTags).texts.find("E6 "),
            std::string::npos);
  // Where the search ends is not known: a way from there is a warning.
  const Found from_there = checked(kBend + search + "movel offset(here(), x = 9m)\n", kTags);
  EXPECT_NE(from_there.texts.find("W6 "), std::string::npos) << from_there.texts;
  const Found otherwise =
      checked(kBend +
                  "movel offset(start, z = -50mm), until Ready else\n  movel offset(start, x = 9m)\nend\n"
                  "movel offset(start, z = -50mm), until Ready\n"
                  "if met()\n  movel offset(start, x = 9m)\nend\n",
              kTags);
  EXPECT_NE(otherwise.texts.find("4 unreachable"), std::string::npos) << otherwise.texts;
  EXPECT_NE(otherwise.texts.find("8 unreachable"), std::string::npos) << otherwise.texts;
}

TEST(Rehearsal, ALoopIsFollowedUpToTheBreakOfItsCounter) {
  const Found found = checked(kBend +
                              "let n = 0\nwhile true\n  set n = n + 1\n  if n > 10\n    break\n  end\n"
                              "  movel offset(start, z = -n * 1mm)\nend\nlog(10 / (n - 2))\n"
                              "movel offset(start, z = (n - 11) * 1m)\n");
  EXPECT_EQ(found.texts, "");
  const Found otherwise = checked(
      "let n = 0\nwhile true\n  set n = n + 1\n  if n < 11\n    wait 1ms\n  else\n"
      "    break\n  end\nend\nlog(10 / (n - 2))\n");
  EXPECT_EQ(otherwise.texts, "");
}

TEST(Rehearsal, ThePlcIsGoneThrough) {
  const auto texts = [](const std::string& plc) {
    return checked("wait Ready\nset Kind = 2\nmovej joints(0, 0, 0, 0, 0, 0)\n", kTags, "", plc)
        .texts.substr(0, 15);
  };
  EXPECT_EQ(texts("func f(x)\n  return 1 / x\nend\nset Ready = true\nlog(f(0))\n"), "E2 zero '/' by ");
  EXPECT_EQ(texts("set Ready = true\nwait Kind == 2\nlog(1 / (Kind - 2))\n"), "W3 zero '/' by ")
      << "the program sets Kind";
  EXPECT_EQ(texts("set Ready = true\nwait Kind == 2\n"), "");
}

TEST(Rehearsal, ALoopThatOnlyARunShowsToBeEndlessIsAWarning) {
  const std::string texts =
      checked("for i in 1 .. 2\n  let n = 0\n  while n < 3\n    set n = n * 2\n  end\nend\n", kTags).texts;
  EXPECT_EQ(texts.find("busy-loop the program neither waits nor moves here"), 3u) << texts;
}

TEST(Rehearsal, EveryRobotOfTheProgramIsLookedAt) {
  const Found found = checked(
      "moveto joints(0, -30deg, 60deg, 0, 60deg, 0), robot left\n"
      "moveto joints(0, -30deg, 60deg, 0, 60deg, 0), robot right\n"
      "use robot right\nlet start = here()\nmovel offset(start, z = -500mm)\n",
      "",
      "  left: {model: " + test::kSixAxes + ", hardware: mock}\n  right: {model: " + test::kSixAxes +
          ", at: [0, 2, 0], hardware: mock, workspace: {table: {plane: [0, 0, 1300mm], normal: [0, 0, "
          "1]}}}\n");
  EXPECT_NE(found.texts.find("E5 workspace"), std::string::npos) << found.texts;
}

TEST(Rehearsal, AProgramWithoutEndIsLookedAtForTwoPasses) {
  const Found found = checked(kBend + "while True\n  movel offset(start, z = -50mm)\n  movel start\nend\n");
  EXPECT_EQ(found.texts, "");
  EXPECT_EQ(found.result.moves, 5u);
}

const std::string kFar = "  movej pose(3m, 0, 1m)\n", kNear = "  movej joints(0, 0, 0, 0, 0, 0)\n";

TEST(Rehearsal, OtherAnswersToQuestionsAreTried) {
  const auto first = [](const std::string& program) { return checked(program, kTags).texts.substr(0, 3); };
  EXPECT_EQ(first("if ask(\"Far?\", false)\n" + kFar + "end\n"), "E2 ");
  EXPECT_EQ(first("if ask(\"Near?\", true)\n" + kNear + "else\n" + kFar + "end\n"), "E4 ");
  EXPECT_EQ(first("let n = ask(\"How many?\", 4)\nif n + 1 > 6\n" + kFar + "end\n"), "E3 ");
  EXPECT_EQ(first("let far = ask(\"Height?\", 100mm)\nif far >= 2 * 90mm\n" + kFar + "end\n"), "E3 ");
  EXPECT_EQ(first("let c = ask(\"Colour?\", \"red\")\nif c == \"blue\"\n" + kFar + "end\n"), "E3 ");
  EXPECT_EQ(first("let c = ask(\"Colour?\", \"red\")\nif c == \"red\"\n" + kNear + "else\n" + kFar + "end\n"),
            "E5 ");
  EXPECT_EQ(first("if ask(\"One?\", false)\n  if ask(\"Two?\", false)\n  " + kFar + "  end\nend\n"), "")
      << "two other answers at once are not tried";
  EXPECT_EQ(first("if ask(\"One?\", false)\n  if ask(\"Two?\", true)\n  " + kFar + "  end\nend\n"), "E3 ");
  EXPECT_EQ(first("func asks()\n  return ask(\"Far?\", false)\nend\nif asks()\n" + kFar + "end\n"), "E5 ");
  EXPECT_EQ(first("let n = ask(\"How many?\", 4)\nif n < 1\n  raise \"too few\"\nend\n"), "");
}

TEST(Rehearsal, WhatDependsOnAnAnswerIsAWarning) {
  const std::string zero = checked("let n = ask(\"How many?\", 4)\nlog(10 / n)\n", kTags).texts;
  EXPECT_EQ(zero, "W2 zero '/' by zero\n");
  const Found found =
      checked("let n = ask(\"How many?\", 4)\nif n > 9\nmovej pose(n * 1m, 0, 1m)\nend\n", kTags);
  EXPECT_EQ(found.texts.rfind("W3 ", 0), 0u) << found.texts;
}

TEST(Rehearsal, WhatIsLeftOutIsSaid) {
  std::string program;
  for (int i = 0; i < 50; ++i)
    program += "if ask(\"Is it " + std::to_string(i) + "?\", false)\n  log(1)\nend\n";
  const Found found = checked(program, kTags);
  ASSERT_FALSE(found.result.notes.empty());
  EXPECT_NE(
      found.result.notes.back().find("40 other values, answers, time-outs and errors; 10 more were left out"),
      std::string::npos)
      << found.result.notes.back();
  for (const std::string& note : checked("if ask(\"Far?\", false)\n  log(1)\nend\n", kTags).result.notes)
    EXPECT_EQ(note.find("left out"), std::string::npos) << note;
}

TEST(Rehearsal, AnErrorThatTheProgramHandlesIsAWarning) {
  const auto handled = [](const std::string& program) {
    const Found found = checked(program, kTags);
    EXPECT_FALSE(found.result.has_errors()) << found.texts;
    return found.texts.substr(0, 3) + found.texts.substr(found.texts.rfind(';'));
  };
  EXPECT_EQ(handled("try\n" + kFar + "on error e\n  log(e.text)\nend\n"), "W2 ; handled in line 3\n");
  EXPECT_EQ(
      handled("func go(p)\n  movej p\nend\ntry\n  go(pose(3m, 0, 1m))\non error e\n  log(e.text)\nend\n"),
      "W2 ; handled in line 6\n");
  EXPECT_EQ(handled("try\n  movej joints(9rad, 0, 0, 0, 0, 0), blend 10mm\n" + kNear +
                    "on error e\n  log(e.text)\nend\n"),
            "W2 ; handled in line 4\n");
  EXPECT_EQ(handled("try\n  try\n  " + kFar + "  on error e\n    raise\n  end\non error e\n  log(1)\nend\n"),
            "W3 ; handled in line 4\n");
  EXPECT_EQ(handled("wait Ready\ntry\n" + kFar + "on error e\n  log(e.text)\nend\n"),
            "W3 ; handled in line 4\n");
}

TEST(Rehearsal, AWrongValueThatTheProgramHandlesIsAWarningToo) {
  const auto in_try = [](const std::string& line, const std::string& handler = "log(e.text)\n") {
    return checked("func half(a)\n  return a / 2 + 1mm\nend\nlet list = [1, 2]\ntry\n" + line +
                       "on error e\n" + handler + "end\n",
                   kTags)
        .texts;
  };
  EXPECT_EQ(in_try("log(half(2s))\n").rfind("W2 bad-type '+' cannot add", 0), 0u)
      << in_try("log(half(2s))\n");
  EXPECT_NE(in_try("log(half(2s))\n").find("; handled in line 7"), std::string::npos);
  EXPECT_EQ(in_try("log(1 / 0)\n"), "W6 zero '/' by zero; handled in line 7\n");
  EXPECT_EQ(in_try("log(list[3])\n").rfind("W6 no-element", 0), 0u);
  EXPECT_EQ(in_try("log(1 / 0)\n", "raise\n").rfind("E6 zero", 0), 0u) << in_try("log(1 / 0)\n", "raise\n");
  EXPECT_EQ(in_try("log(half(2mm))\n"), "");
  EXPECT_EQ(in_try("log(1 / At)\n").find("W6 zero"), std::string::npos) << "its value comes from elsewhere";
  EXPECT_EQ(in_try("raise \"by hand\"\n"), "");
}

TEST(Rehearsal, AnErrorThatAHandlerPassesOnOrMakesIsAnError) {
  const auto first = [](const std::string& program) { return checked(program, kTags).texts; };
  const auto starts = [&](const std::string& program, const std::string& with) {
    const std::string texts = first(program);
    EXPECT_NE(("\n" + texts).find("\n" + with), std::string::npos) << program << "\n" << texts;
  };
  starts("try\n" + kFar + "on error e\n  retry 2\nend\n", "E2 ");
  starts("try\n" + kFar + "on error e\n  raise\nend\n", "E2 ");
  starts("try\n" + kFar + "on error e\n" + kFar + "end\n", "E4 ");
  starts("try\n" + kNear + "on error e\n" + kFar + "end\n", "E4 ");
  starts("try\n  set Kind = 3\non error e\n" + kFar + "end\n", "E4 ");
  starts("try\n" + kNear + "on error e\n  let n = 0\n  log(1 / n)\nend\n", "E5 zero");
  EXPECT_EQ(first("try\n" + kNear + "on error e\n  raise\nend\n"), "");
  EXPECT_EQ(first("try\n" + kNear + "on error e\n  retry 3\nend\n"), "");
}

TEST(Rehearsal, WhatIsCalculatedFromOutsideValuesDecidesAboutBranches) {
  const std::string live = "signals: tags.yaml\n";
  const auto first = [&](const std::string& program, const std::string& plc = "") {
    return checked(program, live, "", plc).texts.substr(0, 3);
  };
  EXPECT_EQ(first("let left = 12 - At\nif left < 5\n" + kFar + "end\n"), "E3 ");
  EXPECT_EQ(first("if 3 * At - 7 == 2\n" + kFar + "end\n"), "E2 ");
  EXPECT_EQ(first("func left()\n  return 12 - At\nend\nif left() < 5\n" + kFar + "end\n"), "E5 ");
  EXPECT_EQ(first("func go(n)\n  if n > 8\n  " + kFar + "  end\nend\ngo(2 * At)\n"), "E3 ");
  EXPECT_EQ(first("let n = 0\nset n = At / 4\nif n > 2\n" + kFar + "end\n"), "E4 ");
  EXPECT_EQ(first("let many = At * 2 > 30\nif many\n" + kFar + "end\n"), "E3 ");
  EXPECT_EQ(first("while At + 2 < 1\n" + kFar + "  wait 10ms\nend\n"), "E2 ");
  EXPECT_EQ(first("log(1 / (At - 1))\n"), "W1 ");
  EXPECT_EQ(first("if At > 3\n  log(1 / (2 * At - 8))\nend\n"), "W2 ");
  EXPECT_EQ(first("if At != 1\n  log(1 / (At - 1))\nend\n"), "");
  EXPECT_EQ(first("wait At > 3\nlog(10 mod (At - 7))\n"), "W2 ");
  const std::string counts = "set Kind = Kind + 1\n";
  EXPECT_EQ(first("set Ready = true\nlog(1 / (Kind - 4))\n", counts), "W2 ") << "the PLC counts";
  EXPECT_EQ(first("set Ready = true\nlog(1 / (Kind - 4))\n", "set Kind = 3\n"), "")
      << "the PLC never sets it to 4";
}

TEST(Rehearsal, ALoopThatAKeptValueMakesEndlessLeavesRoomForOtherValues) {
  const std::string program =
      "while At < 6\n  for i in 1 .. 10\n    movej joints(0, 0, 0, 0, 0, 0)\n    movej joints(0, 0, 0, 0, 0, "
      "6deg)\n"
      "  end\n  wait 10ms\nend\nif At > 8\n" +
      kFar + "end\n";
  const Found found = checked(program, kTags);
  EXPECT_NE(("\n" + found.texts).find("\nE9 "), std::string::npos) << found.texts;
  for (const std::string& note : found.result.notes)
    EXPECT_EQ(note.find("left out"), std::string::npos) << note;
}

TEST(Rehearsal, ADryRunAnswersQuestionsWithEnter) {
  know_the_mock();
  const test::Folder folder;
  folder.write("go.script", "let n = ask(\"How many?\", 2)\nwait user \"Ready?\"\nlog(n)\n");
  folder.write("cell.yaml",
               "polyarm: cell/1\nrobots:\n  arm: {model: " + test::kSixAxes + ", hardware: mock}\nprogram: go\n");
  const CheckResult result = check(folder.path(), {}, description::Catalogue({}), {.dry = true});
  EXPECT_FALSE(result.has_errors()) << result.problems.front().text();
}

TEST(Rehearsal, APointOutOfReachThatOnlyATryUsesIsAWarning) {
  know_the_mock();
  const auto with_point = [](const std::string& program) {
    const test::Folder folder;
    folder.write("go.script", "load P\n" + program);
    folder.write("P.data", "Name: Away\nPose: RPY\nPoint: 3, 0, 1, 0, 0, 0\n");
    folder.write("cell.yaml", "polyarm: cell/1\nrobots:\n  arm: {model: " + test::kSixAxes +
                                  ", hardware: mock}\nprogram: go\n");
    return check(folder.path(), {}, description::Catalogue({}), {});
  };
  const CheckResult handled = with_point("try\n  movej Away\non error e\n  log(e.text)\nend\n");
  EXPECT_FALSE(handled.has_errors());
  ASSERT_FALSE(handled.problems.empty());
  EXPECT_NE(handled.problems.front().what.find("; handled in line 4"), std::string::npos)
      << handled.problems.front().what;
  EXPECT_TRUE(with_point("try\n  movej Away\non error e\n  log(e.text)\nend\nmovej Away\n").has_errors());
  EXPECT_TRUE(with_point("log(1)\n").has_errors()) << "no line uses it";
}

TEST(Rehearsal, OneRobotIsMovedOnceInTogether) {
  const std::string near = "movej joints(0, 0, 0, 0, 0, 0)";
  const std::string same = checked("together\n  " + near + "\n  " + near + ", robot arm\nend\n").texts;
  EXPECT_EQ(same.rfind("E3 two-moves 'arm' is moved twice in one 'together', here and in line 2", 0), 0u)
      << same;
  const std::string called =
      checked("func go()\n  " + near + "\nend\ntogether\n  go()\n  " + near + "\nend\n").texts;
  EXPECT_EQ(called.rfind("E6 two-moves", 0), 0u) << called;
  EXPECT_EQ(checked("together\n  " + near + "\n  wait 10ms\nend\n").texts, "");
}

TEST(Rehearsal, AMoveOfABaseNeedsWheels) {
  EXPECT_EQ(checked("drive 500mm\n").texts, "E1 no-base no controller of wheels drives 'arm'\n");
}

TEST(Rehearsal, AFrameOnARobotThatHasNotArrivedIsAnError) {
  const std::string moves = "moveto joints(0, -30deg, 60deg, 0, 60deg, 0)\nmovej joints(0, -30deg, 50deg, 0, 60deg, 0)\n";
  const std::string to = "movel pose(0, 0, -50mm), frame \"arm/tcp\"\n";
  EXPECT_EQ(checked(moves + to).texts.rfind("E3 frame-moves the frame 'arm/tcp' is under way", 0), 0u)
      << checked(moves + to).texts;
  EXPECT_EQ(checked(moves + "wait 0s\n" + to).texts, "");
}

TEST(Rehearsal, WaitsOfATogetherAreFollowed) {
  const auto first = [](const std::string& wait) {
    return checked("together\n  " + wait + "\n  wait 2s\nend\nmovej pose(3m, 0, 0)\n", kTags).texts;
  };
  EXPECT_EQ(first("wait 1s").rfind("E5 unreachable", 0), 0u) << first("wait 1s");
  EXPECT_EQ(first("wait Ready").rfind("E5 unreachable", 0), 0u) << first("wait Ready");
}

TEST(Rehearsal, AProgramThatEndsInAPulseIsFollowedToItsEnd) {
  const Found found =
      checked(kBend + "pulse Ready for 500ms\nmovel offset(start, z = -50mm)\npulse Ready for 1s\n",
              "signals: tags.yaml\n");
  EXPECT_EQ(found.texts, "");
  EXPECT_TRUE(found.result.reached.file.empty()) << found.result.reached.text();
}

TEST(Rehearsal, AnErrorThatEveryRunRaisesIsOne) {
  EXPECT_EQ(checked("try\n  raise \"a\"\non error e\n  retry 3\nend\n").texts, "E2 user a\n");
  EXPECT_EQ(checked("together\n  log(1)\n  raise \"b\"\nend\n").texts, "E3 user b\n");
  EXPECT_EQ(checked("if Ready\n  raise \"c\"\nend\n", kTags).texts, "") << "a tag decides";
  EXPECT_EQ(checked("wait Ready\nraise \"d\"\n", kTags).texts, "") << "it may never become true";
}

TEST(Rehearsal, ACountThatNeverEndsIsABusyLoop) {
  const std::string texts = checked("let a = 1\nwhile a > 0\n  set a = a + 1\nend\n").texts;
  EXPECT_NE(texts.find("busy-loop the program neither waits nor moves here"), std::string::npos) << texts;
  EXPECT_EQ(checked("let a = 1\nwhile a < 900\n  set a = a + 1\nend\n").texts, "");
}

TEST(Rehearsal, ADryRunOfACellWithoutAProgramRunsNothing) {
  know_the_mock();
  const test::Folder folder;
  folder.write("cell.yaml",
               "polyarm: cell/1\nrobots:\n  arm: {model: " + test::kSixAxes + ", hardware: mock}\n");
  int ticks = 0;
  const CheckResult result = check(folder.path(), {}, description::Catalogue({}),
                                   {.dry = true, .progress = [&](double) { ++ticks; }});
  EXPECT_FALSE(result.has_errors());
  EXPECT_EQ(ticks, 0);
  EXPECT_NE(std::find(result.notes.begin(), result.notes.end(),
                      "the cell has no program: there is nothing for a dry run"),
            result.notes.end());
}

TEST(Rehearsal, ADryRunResumesAPlannedHold) {
  know_the_mock();
  const test::Folder folder;
  folder.write("go.script", "hold \"look\"\nlog(1)\n");
  folder.write("cell.yaml", "polyarm: cell/1\nrobots:\n  arm: {model: " + test::kSixAxes +
                                ", hardware: mock}\nprogram: go\n");
  const CheckResult result = check(folder.path(), {}, description::Catalogue({}), {.dry = true});
  EXPECT_TRUE(result.problems.empty()) << result.problems.front().text();
}

TEST(Rehearsal, ADeadlockOfTasksIsFoundInBothRehearsals) {
  const std::string program = "task a\n  meet x\nend\ntask b\n  meet x\n  meet x\nend\n";
  const std::string texts = checked(program).texts;
  EXPECT_EQ(texts.rfind("E6 deadlock tasks wait for each other without end: 'b' waits in line 6", 0), 0u) << texts;
}

}  // namespace
}  // namespace polyarm::cell
