#include <map>

#include "polyarm/language/functions.hpp"
#include "polyarm/language/words.hpp"

namespace polyarm::program {

namespace {
/// An example program for every function.
const std::map<std::string_view, std::string_view>& function_examples() {
  static const std::map<std::string_view, std::string_view> examples = {
      {"length", "log(length([1, 2, 3]), length(\"abc\"))    # expect: 3 3"},
      {"abs", "log(abs(-20mm))                          # expect: 0.02m"},
      {"min", "log(min(3mm, 1mm, 2mm))                  # expect: 0.001m"},
      {"max", "log(max(1, 3, 2))                        # expect: 3"},
      {"round", "log(round(2.6))                          # expect: 3"},
      {"floor", "log(floor(2.6))                          # expect: 2"},
      {"ceil", "log(ceil(2.2))                           # expect: 3"},
      {"sqrt", "log(sqrt(16))                            # expect: 4"},
      {"sin", "log(round(sin(90deg)))                   # expect: 1"},
      {"cos", "log(cos(0deg))                           # expect: 1"},
      {"tan", "log(tan(0deg))                           # expect: 0"},
      {"asin", "log(asin(0))                             # expect: 0rad"},
      {"acos", "log(acos(1))                             # expect: 0rad"},
      {"atan", "log(atan(0))                             # expect: 0rad"},
      {"atan2", "log(atan2(0mm, 1mm))                     # expect: 0rad"},
      {"pose", "log(pose(100mm, z = 50mm).z)             # expect: 0.05m"},
      {"quat", "log(quat(0, 0, 0, 1, x = 5mm).x)         # expect: 0.005m"},
      {"joints", "movej joints(0deg, -90deg, 0deg)         # expect move: joint joints(0rad, …) exact"},
      {"offset", "log(offset(pose(1m), x = 500mm).x)       # expect: 1.5m"},
      {"tool_offset", "log(tool_offset(pose(z = 1m), z = 500mm).z) # expect: 1.5m"},
      {"inverse", "log((inverse(pose(10mm)) * pose(10mm)).x) # expect: 0m"},
      {"distance", "log(distance(pose(1m), pose(3m)))        # expect: 2m"},
      {"interpolate", "log(interpolate(pose(0mm), pose(10mm), 50%).x) # expect: 0.005m"},
      {"pallet",
       "let slots = pallet(pose(), pose(x = 200mm), pose(y = 100mm), rows = 2, cols = 3)\n"
       "log(length(slots), slots[2].x)           # expect: 6 0.1m"},
      {"here",
       "# given P: point 0.4 0 0.3\nmovel P\nlog(here().z)                            # expect: 0.3m"},
      {"ask",
       "# answer 4\n# answer\nlet count = ask(\"How many?\", 1)\nlet name = ask(\"Who are you?\")\n"
       "log(count + 1)                           # expect: 5"},
      {"with",
       "# given P: point 0.4 0 0.3\nlet above = P with z = 400mm\nlog(above.x, above.z)                    # "
       "expect: "
       "0.4m 0.4m"},
      {"here_joints",
       "let before = here_joints()\nmovej before                             # expect move: joint before "
       "exact"},
      {"ik",
       "# given P: point 0.4 0 0.3\nlet there = ik(P)\nmovej there, speed 20%                   # expect "
       "move: joint "
       "there speed 0.2 exact"},
      {"fk", "# given Home: joints\nlog(fk(Home).z)                          # expect: 0m"},
      {"random", "let weight = random(1kg, 2kg)\nlog(weight >= 1kg and weight < 2kg)      # expect: True"},
      {"clock", "let begin = clock()\nwait 200ms\nlog(round((clock() - begin) / 100ms))    # expect: 2"},
      {"force",
       "# given P: point 0.4 0 0.1\nmovel P, touch, until force() > 20N\nlog(force() > 20N)                  "
       "     # expect: "
       "True"},
      {"wrench", "log(wrench().z)                          # expect: 30N"},
      {"zero_force", "zero_force()\nlog(force())                             # expect: 0N"},
      {"met",
       "# given P: point 0.4 0 0.1\nmovel P, until false\nlog(met())                               # expect: "
       "False"},
      {"travelled",
       "# given P: point 0.4 0 0.1\nmovel P, until false\nlog(travelled())                         # expect: "
       "1m"},
      {"comply",
       "# given P: point 0.4 0 0.1\ncomply(\"z\", force = 20N)                # the tool presses with 20 N\n"
       "movel P, speed 20mm/s, touch             # expect move: line P speed 0.02m/s touch exact\nstiff()"},
      {"stiff",
       "comply(\"x y\", stiffness = 500)           # N/m\nlog(stiff())                              # "
       "expect: True"},
      {"next_part",
       "wait next_part(\"line\")\nmovel pose(0, 0, 5mm), frame \"line\"      # expect move: line pose(0, …) "
       "frame line "
       "exact"},
      {"waiting_parts", "log(waiting_parts(\"line\"))               # expect: 1"},
      {"missed_parts", "log(missed_parts(\"line\"))                # expect: 0"},
      {"add_part", "log(add_part(\"line\", pose(0, 20mm, 0)))   # expect: True"},
      {"rows_of",
       "let rows = rows_of(\"parts.csv\")\nlog(rows[1].name, length(rows))           # expect: lid 1"},
      {"is_connected", "wait is_connected(\"scanner\") timeout 5s"},
      {"has_line", "wait has_line(\"scanner\") timeout 5s"},
      {"next_line", "log(split(next_line(\"scanner\"), \";\"))    # expect: [12, ok]"},
      {"send_text", "send_text(\"scanner\", \"TRIGGER\\n\")"},
      {"format", "log(format(\"{:.2f} {:>4} {:.1mm}\", 2.0 / 3, 7, 12mm)) # expect: 0.67    7 12.0mm"},
      {"text", "log(text(1.5) + text(true))              # expect: 1.5True"},
      {"number", "log(number(\" 2.5mm\") * 2)               # expect: 0.005m"},
      {"is_number", "log(is_number(\"12\"), is_number(\"twelve\")) # expect: True False"},
      {"split", "log(split(\"a,b,,c\", \",\"))                # expect: [a, b, , c]"},
      {"join", "log(join([1, \"b\", 3], \";\"))              # expect: 1;b;3"},
      {"trim", "log(\"<\" + trim(\" a b \") + \">\")           # expect: <a b>"},
      {"upper", "log(upper(\"ok 1\"))                       # expect: OK 1"},
      {"lower", "log(lower(\"OK 1\"))                       # expect: ok 1"},
      {"find", "log(find(\"abcb\", \"b\"), find([3, 5], 5), find(\"a\", \"x\")) # expect: 2 2 0"},
      {"replace", "log(replace(\"1,5\", \",\", \".\"))           # expect: 1.5"},
      {"slice", "log(slice(\"abcdef\", 2, 3), slice([1, 2, 3], -2)) # expect: bc [2, 3]"},
      {"fault",
       "# given HasPart: False\ntest \"suction fails\"\n  fault(\"arm/tool/vacuum\", false)\n"
       "  expect not HasPart\n  log(\"seen\")                            # expect: seen\nend"},
      {"heal", "test \"suction comes back\"\n  heal(\"arm/tool/vacuum\")\nend"},
      {"person", "test \"goes on\"\n  person(\"hold\")\n  person(\"resume\")\nend"},
      {"part", "test \"the part has been moved\"\n  expect part(\"part1\").z == 0m\nend"},
  };
  return examples;
}

void add_program(std::string& out, std::string_view example) {
  out += "\n```\n" + std::string(example) + "\n```\n\n";
}

void add_words(std::string& out, std::string_view title, WordRole role, bool in_tests) {
  out += "## " + std::string(title) + "\n\n";
  for (const Word& word : words()) {
    if (word.role != role || word.in_tests != in_tests) continue;
    out += "**" + std::string(word.name) + "** — `" + std::string(word.form) + "`  \n" +
           std::string(word.meaning) + "\n";
    if (!word.example.empty()) {
      add_program(out, word.example);
    } else {
      out += "For an example, see **" + std::string(word.shown_by) + "**.\n\n";
    }
  }
}

void add_closers(std::string& out) {
  out += "## Ends of blocks\n\nEvery block ends with `end`. You may also write what ends: ";
  bool first = true;
  for (const Word& word : words()) {
    if (word.role != WordRole::closer || word.name == "end") continue;
    out += (first ? "`" : ", `") + std::string(word.name) + "`";
    first = false;
  }
  out += ".\n\n";
}

void add_functions(std::string& out, std::string_view title, bool in_tests) {
  out += "## " + std::string(title) + "\n\n";
  for (const Function& function : functions()) {
    if (function.in_tests != in_tests) continue;
    out += "**" + std::string(function.name) + "** — `" + std::string(function.signature) + "`  \n" +
           std::string(function.meaning) + "\n";
    const auto example = function_examples().find(function.name);
    if (example != function_examples().end()) add_program(out, example->second);
  }
}

constexpr std::string_view kGrammar = R"(## Grammar

```text
program   = { statement }
block     = { statement } ( end | end + the word that opened it )
statement = ( load | import ) NAME | include TEXT | log EXPR | CALL
          | let NAME = EXPR | set NAME { .NAME | [EXPR] } = EXPR | set NAME LITERAL
          | ( moveto | movej | movel | drive | turn ) EXPR { clause } | movec EXPR , EXPR { clause }
          | ( speedj | speedl ) EXPR { clause } | use clause { , clause }
          | wait time EXPR | wait [var] EXPR [timeout EXPR [else block]] | wait (user | input) [TEXT]
          | while EXPR block | for NAME [, NAME] in EXPR [.. EXPR] block
          | if EXPR { statement } { elif EXPR { statement } } [ else { statement } ] end
          | func NAME ( [ NAME [= EXPR] { , … } ] ) block | return [EXPR] | break | continue | stop | hold [EXPR]
          | try { statement } on error [NAME] block | raise [EXPR] | retry [EXPR]
          | task NAME block | together block | when EXPR block | trap [when] EXPR block | every EXPR block
          | on stop block | pulse NAME for EXPR
          | meet NAME [timeout EXPR [else block]] | lock NAME [timeout EXPR] block
          | test TEXT block | run [TEXT] | expect EXPR [timeout EXPR]
clause    = [,] ( robot | tool | frame | payload | near | around | speed | accel | blend | duration ) EXPR | exact | smooth | touch
          | until EXPR [else block] | at ( start [+ EXPR] | end [- EXPR] ) set NAME = EXPR
EXPR      = or < and < not < ( == != < <= > >= ) < ( + - ) < ( * / mod ) < unary - < ^ < .NAME (…) […] with NAME = EXPR
primary   = NUMBER[UNIT] | TEXT | true | false | NAME | ( EXPR ) | [ EXPR, … ] | { NAME = EXPR, … }
          | [ EXPR for NAME [, NAME] in EXPR [.. EXPR] ]
```

)";
}  // namespace

std::string language_reference() {
  std::string out =
      "# Reference of the language\n\nWritten by `polyarm language page` from the lists that the parser "
      "itself "
      "uses; every program on this page\nruns in the tests, with the results that its comments state. "
      "[The language](language.md) explains it in order.\n\n";
  out += kGrammar;
  add_words(out, "Statements", WordRole::statement, false);
  add_words(out, "Branches", WordRole::branch, false);
  add_closers(out);
  add_words(out, "Clauses of moves", WordRole::clause, false);
  add_words(out, "Reserved words", WordRole::reserved, false);
  add_functions(out, "Functions", false);
  add_words(out, "Statements of tests", WordRole::statement, true);
  add_functions(out, "Functions of tests", true);
  while (out.ends_with("\n\n")) out.pop_back();
  return out;
}

}  // namespace polyarm::program
