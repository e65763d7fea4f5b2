#include "polyarm/language/words.hpp"

#include <algorithm>
#include <unordered_set>
#include <utility>

namespace polyarm::program {

namespace {
constexpr auto kStatement = WordRole::statement;
constexpr auto kBranch = WordRole::branch;
constexpr auto kCloser = WordRole::closer;
constexpr auto kClause = WordRole::clause;
constexpr auto kReserved = WordRole::reserved;

std::vector<Word> data_words() {
  return {
      {"load", kStatement, "load NAME", "The data set of that file and its points, as the file is now.",
       "# given Repeat: False\nload cycledata\nlog(Repeat)                              # expect: True", ""},
      {"import", kStatement, "import NAME", "The same as `load`.",
       "# given GripperActive: True\nimport cycledata\nlog(GripperActive)                       # expect: "
       "False",
       ""},
      {"set", kStatement, "set NAME = EXPR, set NAME True",
       "Changes a value, which keeps its type and unit; without `=` it takes True, False, a number or a "
       "text.",
       "# given Repeat: True\nlet sizes = [20mm, 40mm]\nset sizes[2] = 50mm\nset Repeat False\n"
       "log(sizes, Repeat)                       # expect: [0.02m, 0.05m] False",
       ""},
      {"let", kStatement, "let NAME = EXPR", "A new name, to the end of its block.",
       "let height = 80mm\nlet bins = {red = 1, blue = 2}\n"
       "log(height + 2cm, bins.blue)             # expect: 0.1m 2",
       ""},
      {"include", kStatement, "include \"FILE\"",
       "Includes the functions and names of another file; its name is relative to this one.",
       "include \"../tests/program/cases/included/tools.script\"\n"
       "log(twice(4), height)                    # expect: 8 0.1m",
       ""},
      {"log", kStatement, "log EXPR, log(EXPR, …)",
       "Prints a line for the operator; it does not wait for motion.",
       "log \"three\"                              # expect: three\n"
       "log(1 + 1, 20mm < 3cm)                   # expect: 2 True",
       ""},
  };
}

std::vector<Word> motion_words() {
  return {
      {"moveto", kStatement, "moveto P {clause}", "Joint move; the program continues when it has arrived.",
       "# given Home: joints\n# given Ready: False\nmoveto Home                              "
       "# expect move: joint Home exact waits\nset Ready = true",
       ""},
      {"movej", kStatement, "movej P {clause}", "Joint move to a point, or through a list of them.",
       "# given Home: joints\n# given Over: point 0.4 0 0.3\n"
       "movej [Home, Over], blend 20mm, exact    # expect move: joint Home Over blend 0.02m exact",
       ""},
      {"movel", kStatement, "movel P {clause}",
       "Straight line of the tool to a point, or through a list of them.",
       "# given Over: point 0.4 0 0.3\nmovel offset(Over, z = -50mm)            "
       "# expect move: line offset(Over, …) exact",
       ""},
      {"movec", kStatement, "movec VIA, P {clause}", "Arc through a point on the way.",
       "# given Via: point 0.4 0.1 0.3\n# given End: point 0.5 0 0.3\n"
       "movec Via, End, speed 100mm/s            # expect move: arc Via End speed 0.1m/s exact",
       ""},
      {"speedj", kStatement, "speedj {JOINT = V, …}, duration T {clause}",
       "Joints move at these velocities for this duration, or until a condition ends the move. Then they "
       "come to rest.",
       "speedj {elbow = 0.2rad/s}, duration 2s   # expect move: joint speedj … speed 0.2rad/s exact", ""},
      {"speedl", kStatement, "speedl {z = V, rx = W, …}, duration T {clause}",
       "The tool moves at this velocity along the frame's axes, and turns about them, for this duration, or "
       "until a condition ends the move. Then it comes to rest.",
       "# given Contact: False\n# after 50ms Contact: True\n"
       "speedl {z = -20mm/s}, duration 3s, until Contact\nlog(\"down\")                              "
       "# expect: down",
       ""},
      {"drive", kStatement, "drive D {clause}, drive P {clause}",
       "A base with wheels drives this distance ahead, or back, and stops; or it goes to a pose, around "
       "obstacles.",
       "# given Dock: point 2 1 0\ndrive 500mm, speed 100mm/s\ndrive -500mm\ndrive Dock, speed 0.2m/s", ""},
      {"turn", kStatement, "turn A {clause}", "A base with wheels turns by this angle to the left and stops.",
       "turn 90deg", ""},
      {"use", kStatement, "use clause, clause, …",
       "Defaults for moves without these clauses, to the end of the block and in the functions that it "
       "calls.",
       "# given P: point 0.4 0 0.3\nif true\n  use tool gripper, speed 50%\n  movel P                        "
       "        "
       "# expect move: line P speed 0.5 tool gripper exact\nend\nmovel P                                  # "
       "expect "
       "move: line P exact",
       ""},
      {"robot", kClause, "robot NAME", "Which robot moves, in a cell of several.",
       "# given P: point 0.4 0 0.3\nmovel P, robot left                      # expect move: line P robot "
       "left exact",
       ""},
      {"tool", kClause, "tool NAME", "Whose tip goes to the point: a tool of the data, or the robot's own.",
       "# given P: point 0.4 0 0.3\nmovel P, tool gripper                    # expect move: line P tool "
       "gripper exact",
       ""},
      {"frame", kClause, "frame NAME, frame POSE", "What the point is relative to.",
       "# given P: point 0.1 0 0\nmovel P, frame table                     # expect move: line P frame table "
       "exact",
       ""},
      {"payload", kClause, "payload MASS",
       "What the gripper holds; more than the robot may carry is an error that can be caught.",
       "# given P: point 0.4 0 0.3\nmovel P, payload 2kg                     # expect move: line P payload "
       "2kg exact",
       ""},
      {"near", kClause, "near JOINTS",
       "Of the configurations that reach the point, the one nearest to these joints; only of joint moves.",
       "# given P: point 0.4 0 0.3\n# given Home: joints\n"
       "movej P, near Home                       # expect move: joint P near {elbow: 0.5} exact",
       ""},
      {"around", kClause, "around true, around false",
       "A joint move goes around obstacles; a line or an arc stays as it is, and is refused before it hits "
       "one.",
       "# given P: point 0.4 0 0.3\nmovej P, around true                     # expect move: joint P around "
       "true "
       "exact",
       ""},
      {"speed", kClause, "speed 500mm/s, 30deg/s, 50%",
       "Of the tool, of its turning or of the joints, or a share of what the robot can.",
       "# given P: point 0.4 0 0.3\nmovel P, speed 50%                       # expect move: line P speed 0.5 "
       "exact",
       ""},
      {"accel", kClause, "accel 2m/s2, 200deg/s2, 50%", "Likewise for the acceleration.",
       "# given P: point 0.4 0 0.3\nmovel P, accel 2m/s2                     # expect move: line P accel "
       "2m/s2 exact",
       ""},
      {"blend", kClause, "blend LENGTH",
       "The path may leave the point by this length, and the robot continues into the next move without a "
       "stop.",
       "# given P: point 0.4 0 0.3\n# given Q: point 0.4 0.2 0.3\nmovel P, blend 20mm                      "
       "# expect move: line P blend 0.02m\nmovel Q, exact                           # expect move: line Q "
       "exact",
       ""},
      {"duration", kClause, "duration TIME", "It takes at least that long.",
       "# given P: point 0.4 0 0.3\nmovel P, duration 2s                     # expect move: line P duration "
       "2s exact",
       ""},
      {"exact", kClause, "exact", "It comes to rest at the point; so does a move without a blend.", "",
       "blend"},
      {"smooth", kClause, "movel [P, Q, R], smooth",
       "One curve through all points instead of lines between them.",
       "# given P: point 0.4 0 0.3\n# given Q: point 0.4 0.2 0.3\n"
       "movel [P, Q], smooth                     # expect move: line P Q smooth exact",
       ""},
      {"touch", kClause, "touch",
       "The tool is meant to touch something in this move; a contact of any other part still stops the "
       "robot.",
       "# given P: point 0.4 0 0.1\nmovel P, speed 10mm/s, touch, until force() > 20N\n"
       "log(met(), travelled() < 1m)             # expect: True True",
       ""},
      {"until", kClause, "until C [else … end]",
       "The move ends where C becomes true; `else` is done when it came to its end without that.",
       "# given P: point 0.4 0 0.1\n# given Contact: False\n# after 50ms Contact: True\n"
       "movel P, speed 20mm/s, until Contact else\n  raise \"nothing was touched\"\nend\n"
       "log(\"touched\")                           # expect: touched",
       ""},
      {"at", kClause, "at end - 20mm set NAME = V, at start + 1s set …",
       "Sets a tag or data on the way, by length or time.",
       "# given P: point 0.4 0 0.1\n# given Open: False\nmovel P, at end - 20mm set Open = true\n"
       "wait Open\nlog(\"open\")                              # expect: open",
       ""},
  };
}

std::vector<Word> flow_words() {
  return {
      {"wait", kStatement, "wait C [timeout T [else … end]], wait T, wait time S, wait user [\"TEXT\"]",
       "Until C is true, that long, that many seconds, or until a person answers. A time-out without `else` "
       "is an "
       "error that can be caught.",
       "# given PartThere: False\nwait 500ms\nwait PartThere timeout 2s else\n"
       "  log(\"no part\")                         # expect: no part\nend",
       ""},
      {"while", kStatement, "while C … end", "Again and again while C is true.",
       "let n = 3\nwhile n > 0\n  set n = n - 1\nend\nlog(n)                                   # expect: 0",
       ""},
      {"if", kStatement, "if C … [elif C …] [else …] end", "One of several blocks.",
       "let kind = \"blue\"\nif kind == \"red\"\n  log(1)\nelif kind == \"blue\"\n"
       "  log(2)                                 # expect: 2\nelse\n  log(3)\nend",
       ""},
      {"elif", kBranch, "elif C", "The next branch of an `if`.", "", "if"},
      {"else", kBranch, "else", "What is done when nothing before it was true.", "", "if"},
      {"for", kStatement, "for I in A .. B … end, for X in LIST, for I, X in LIST",
       "Once for each number or value; I counts from 1.",
       "for i, size in [20mm, 30mm]\n  log(i, size)                           # expect: 1 0.02m | 2 "
       "0.03m\nend",
       ""},
      {"break", kStatement, "break", "Leaves the loop.",
       "for i in 1 .. 9\n  if i == 3\n    break\n  end\n  log(i)                                 # expect: 1 "
       "| 2\nend",
       ""},
      {"continue", kStatement, "continue", "On with the next turn of the loop.",
       "for i in 1 .. 3\n  if i == 2\n    continue\n  end\n  log(i)                                 # "
       "expect: 1 | 3\nend",
       ""},
      {"stop", kStatement, "stop", "Ends the program when its robots have arrived; `on stop` is done.",
       "log(1)                                   # expect: 1\nif true\n  stop\nend\nlog(2)", ""},
      {"hold", kStatement, "hold [TEXT]", "Holds the cell; only a person resumes it.",
       "hold \"look at the gripper\"\nlog(\"resumed\")                           # expect: resumed", ""},
      {"func", kStatement, "func NAME(A, B = EXPR) … end",
       "A function; parameters with a value may be left out, and named in the call.",
       "func area(width, height = 2m)\n  return width * 3 + height\nend\n"
       "log(area(1m), area(height = 1m, width = 1m)) # expect: 5m 4m",
       ""},
      {"return", kStatement, "return [EXPR]", "Leaves the function, with its value.", "", "func"},
      {"try", kStatement, "try … on error [E] … end",
       "What goes wrong in its first part is handled in its second: E is {kind, text, line, robot}.",
       "# given Ready: False\ntry\n  wait Ready timeout 100ms\non error e\n"
       "  log(e.kind, e.line)                    # expect: timeout 3\nend",
       ""},
      {"on", kStatement, "on stop … end, on error E",
       "Statements that run once when the program has ended for any reason and its robots are at rest; or "
       "the second part of a `try`.",
       "# given Belt: True\nlog(\"at work\")                           # expect: at work\non stop\n  set "
       "Belt = false\n"
       "  log(\"stopped\")                         # expect: stopped\nend",
       ""},
      {"raise", kStatement, "raise TEXT, raise",
       "Raises an error; alone in a handler it passes the error on.",
       "try\n  raise \"no part\"\non error e\n  log(e.kind, e.text)                    # expect: user no "
       "part\nend",
       ""},
      {"retry", kStatement, "retry [N]",
       "In a handler: again from the top of its `try`, at most N times (1).",
       "let tries = 0\ntry\n  set tries = tries + 1\n  if tries < 3\n    raise \"again\"\n  end\n"
       "  log(tries)                             # expect: 3\non error e\n  retry 5\nend",
       ""},
      {"task", kStatement, "task NAME … end",
       "Runs side by side with other tasks, after the lines outside of them.",
       "# given Ready: False\ntask one\n  wait Ready\n  log(\"second\")                          # expect: "
       "second\nend\n"
       "task two\n  log(\"first\")                           # expect: first\n  set Ready = true\nend",
       ""},
      {"together", kStatement, "together … end",
       "Starts each of its statements at once, and ends when all have; moves go in step.",
       "# given A: point 0.4 0 0.3\n# given B: point 0.4 0.5 0.3\ntogether\n"
       "  movel A, robot left                    # expect move: line A robot left exact\n"
       "  movel B, robot right                   # expect move: line B robot right exact\nend",
       ""},
      {"meet", kStatement, "meet NAME [timeout T [else … end]]",
       "Is passed when as many tasks as mention NAME have come to it.",
       "task giver\n  wait 20ms\n  log(\"offered\")                         # expect: offered\n  meet "
       "handover\nend\n"
       "task taker\n  meet handover\n  log(\"taken\")                           # expect: taken\nend",
       ""},
      {"lock", kStatement, "lock NAME [timeout T] … end",
       "For one task at a time: a place that several robots use.",
       "task one\n  lock press\n    wait 20ms\n    log(1)                               # expect: 1\n  "
       "end\nend\n"
       "task two\n  lock press\n    log(2)                               # expect: 2\n  end\nend",
       ""},
      {"when", kStatement, "when C … end",
       "Runs its block each time C becomes true, from this line on and within one cycle: nothing in it moves "
       "or waits.",
       "# given Door: False\n# after 20ms Door: True\nwhen Door\n"
       "  log(\"the door is open\")                # expect: the door is open\nend\nwait 100ms",
       ""},
  };
}

std::vector<Word> event_words() {
  return {
      {"trap", kStatement, "trap [when] C … end",
       "Each time C becomes true, the robot stops on its path, the block runs, which may move and wait, and the "
       "interrupted motion goes on from its place.",
       "# given P: point 0.4 0 0.3\n# given Aside: point 0.4 0.3 0.3\n# given Door: False\n# after 20ms Door: True\n"
       "trap when Door\n  movel Aside                            # expect move: line Aside exact\nend\nmovel P   "
       "                               # expect move: line P exact\nwait 100ms\nlog(\"end\")                            "
       "   # expect: end",
       ""},
      {"every", kStatement, "every T … end",
       "Runs its block each time T has passed, from this line on and within one cycle: nothing in it moves or waits.",
       "# given Life: False\nlet n = 0\nevery 100ms\n  set Life = not Life\n  set n = n + 1\nend\nwait 350ms\n"
       "log(n)                                   # expect: 3",
       ""},
      {"pulse", kStatement, "pulse NAME for T",
       "Sets a tag to True, and to False when T has passed; the program goes on. It ends in time even while the cell "
       "is held.",
       "# given Blow: False\npulse Blow for 200ms\nlog(Blow)                                # expect: True\nwait 250ms\n"
       "log(Blow)                                # expect: False",
       ""},
  };
}

std::vector<Word> test_words() {
  return {
      {"test", kStatement, "test \"WHAT\" … end",
       "A test in a file of tests; it runs beside the program, on the same tags.",
       "# given Ready: False\n# after 50ms Ready: True\ntest \"it gets ready\"\n  run\n  expect Ready "
       "timeout 1s\n"
       "  log(\"well\")                            # expect: well\nend",
       "", true},
      {"run", kStatement, "run [\"PROGRAM\"]",
       "Starts the program of the cell, or another one, and continues.", "", "test", true},
      {"expect", kStatement, "expect C [timeout T]",
       "The test fails unless C is true, now or before T has passed; the message has the values of its "
       "parts.",
       "# given Placed: 2\ntest \"counts\"\n  expect Placed == 3                     # expect failure: "
       "Placed is 2\nend",
       "", true},
  };
}

std::vector<Word> other_words() {
  std::vector<Word> out = {
      {"end", kCloser, "any block", "Ends the block that is open.", "", "while"},
  };
  for (const auto& [name, block] : {std::pair{"endwhile", "while"},
                                    {"endif", "if"},
                                    {"endfor", "for"},
                                    {"endfunc", "func"},
                                    {"endtry", "try"},
                                    {"endtask", "task"},
                                    {"endtogether", "together"},
                                    {"endlock", "lock"},
                                    {"endwhen", "when"},
                                    {"endtrap", "trap"},
                                    {"endevery", "every"},
                                    {"endon", "on"},
                                    {"endwait", "wait"},
                                    {"endmeet", "meet"},
                                    {"endmove", "until"},
                                    {"endtest", "test"}})
    out.push_back({name, kCloser, block, "The same, and only of that block.", "", block});
  const auto reserved = [&](std::string_view name, std::string_view form, std::string_view meaning,
                            std::string_view example) {
    out.push_back({name, kReserved, form, meaning, example, ""});
  };
  reserved("and", "A and B", "Both; B is not evaluated if A is false.",
           "log(1 < 2 and 2 < 3)                     # expect: True");
  reserved("or", "A or B", "One of them; B is not evaluated if A is true.",
           "log(1 > 2 or 2 < 3)                      # expect: True");
  reserved("not", "not A", "The opposite.", "log(not 1 > 2)                           # expect: True");
  reserved("mod", "A mod B", "The remainder of a division; it has the sign of B.",
           "log(7 mod 3)                             # expect: 1");
  reserved("true", "true", "A boolean.",
           "let open = true\nlog(open)                                # expect: True");
  reserved("false", "false", "A boolean.",
           "let open = false\nlog(open)                                # expect: False");
  return out;
}
}  // namespace

const std::vector<Word>& words() {
  static const std::vector<Word> all = [] {
    std::vector<Word> out = data_words();
    for (const auto& more : {motion_words(), flow_words(), event_words(), test_words(), other_words()})
      out.insert(out.end(), more.begin(), more.end());
    return out;
  }();
  return all;
}

const std::vector<std::string>& statement_words() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> out;
    for (const Word& word : words())
      if (word.role != WordRole::clause && word.role != WordRole::reserved) out.emplace_back(word.name);
    return out;
  }();
  return names;
}

bool is_statement_word(const std::string& word) {
  static const std::unordered_set<std::string> all(statement_words().begin(), statement_words().end());
  return all.contains(word);
}

const Word* statement_named(std::string_view name) {
  for (const Word& word : words())
    if (word.role == WordRole::statement && word.name == name) return &word;
  return nullptr;
}

bool is_closer(std::string_view name) {
  return name.starts_with("end") && std::any_of(words().begin(), words().end(), [&](const Word& word) {
           return word.role == WordRole::closer && word.name == name;
         });
}

}  // namespace polyarm::program
