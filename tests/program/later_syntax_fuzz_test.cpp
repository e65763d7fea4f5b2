/// Random programs of traps, timers, pulses, `until`, `with`, formatted texts, lists by formula, includes and
/// belts, some of them damaged. Whatever they say, they are parsed, formatted and checked without a crash,
/// and end within their time. POLYARM_LATER_SYNTAX says how many (600).
#include <gtest/gtest.h>

#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include "fake_host.hpp"
#include "given.hpp"
#include "polyarm/language/format.hpp"
#include "polyarm/language/parser.hpp"
#include "polyarm/program/checker.hpp"

namespace polyarm::program {
namespace {

class Author {
 public:
  explicit Author(std::uint32_t seed) : random_{seed} {}

  std::string program() {
    for (const char* line : {"let n = 3", "let w = 20mm", "let l = [1, 2, 3]", "let t = \"a;b\"",
                             "let p = pose(400mm, 0, 100mm)", "let r = {x = 1}"})
      put(line);
    if (chance(30)) put(one_of({"include \"polyarm:search\"", "include \"nothing.script\"", "include \"\""}));
    for (std::size_t i = draw(3); i > 0; --i) handler();
    for (std::size_t i = 3 + draw(10); i > 0; --i) statement();
    return text_;
  }

  std::string damaged() {
    static const std::string kBytes = "()[]{}\"`#=.,:;%<>|\n\t \\0189ae\x80\xFF";
    std::string out = program();
    for (std::size_t changes = 1 + draw(5); changes > 0 && !out.empty(); --changes) {
      const std::size_t at = draw(out.size());
      if (chance(40))
        out[at] = kBytes[draw(kBytes.size())];
      else if (chance(50))
        out.erase(at, 1 + draw(12));
      else
        out.insert(at, out.substr(draw(out.size()), draw(30)));
    }
    return out;
  }

 private:
  std::size_t draw(std::size_t below) {
    return std::uniform_int_distribution<std::size_t>(0, below - 1)(random_);
  }
  bool chance(int percent) { return draw(100) < static_cast<std::size_t>(percent); }
  std::string one_of(const std::vector<std::string>& from) { return from[draw(from.size())]; }
  void put(const std::string& line) { text_ += std::string(2 * depth_, ' ') + line + "\n"; }

  std::string number() {
    return one_of({"n", "0", "2", "-1", "1e300", "length(l)", "number(t)", "number(\"1.5\")",
                   "find(t, \";\")", "l[n]", "waiting_parts(\"line\")", "missed_parts(n)", "random()",
                   "random(3, 1)"});
  }
  std::string condition() {
    return one_of({"A", "B", "not A", "n > 2", "force() > 20N", "met()", "travelled() > 2mm", "is_number(t)",
                   "next_part(\"line\")", "next_part(t)", "add_part(\"line\", p)", "true", "false", "n",
                   "clock() > 1s"});
  }
  std::string place() {
    return one_of({"p", "p with z = " + one_of({"w", "3", "10mm"}), "p with x = w with rz = 10deg", "here()",
                   "offset(p, x = w)", "p with q = 1", "r with x = 2", "pose(0, 0, w)",
                   "[" + series() + "]"});
  }
  std::string series() {
    return one_of({"i * w", "offset(p, x = i * w)", "i", "text(i)", "1 / i", "p with x = i * 1mm"}) +
           " for i in " + one_of({"1 .. n", "l", "0 .. -1", "1 .. 1000000000", "split(t, \";\")", "t"});
  }
  std::string text() {
    return one_of({"\"{n:.1f} {t:>8}\"", "\"{w:.1mm}\"", "\"{w:.1kg}\"", "\"{n:.999f}\"", "\"{n:}\"",
                   "\"{n\"", "\"}\"", "format(\"{:06.2f} {}\", n, t)", "format(\"{:^9}\", t)",
                   "format(\"{}\")", "format(t, n)", "join(split(t, \";\"), n)", "slice(t, -2)",
                   "upper(t) + \"{l}\"", "replace(t, \"\", \"x\")"});
  }

  void block(const std::string& head, std::size_t lines) {
    put(head);
    ++depth_;
    while (lines-- > 0) statement();
    --depth_;
    put("end");
  }
  void handler() {
    if (chance(40)) return block("trap when " + condition(), 1 + draw(2));
    if (chance(50)) return block("when " + condition(), 1);
    block("every " + one_of({"5ms", "0s", "n", "1s", "-1s"}), 1);
  }
  void statement() {
    switch (draw(depth_ > 3 ? 9 : 14)) {
      case 0:
        return put("log(" + text() + ")");
      case 1:
        return put("let v" + std::to_string(++count_) + " = [" + series() + "]");
      case 2:
        return put("set n = " + number());
      case 3:
        return put("pulse " + one_of({"B", "n", "nobody"}) + " for " +
                   one_of({"10ms", "0s", "n", "1000000s"}));
      case 4:
        return put("movel " + place() +
                   one_of({"", ", until " + condition(), ", touch", ", frame \"line\"",
                           ", at end - 5mm set B = true", ", blend w"}));
      case 5:
        return put("wait " + condition() + " timeout 20ms else\nend");
      case 6:
        return put("set r.x = " + number());
      case 7:
        return put("let v" + std::to_string(++count_) + " = " + place());
      case 8:
        return put("wait 5ms");
      case 9:
        return handler();
      case 10:
        return block("if " + condition(), 1 + draw(2));
      case 11:
        return block("for i" + std::to_string(++count_) + " in [" + series() + "]", 1);
      case 12:
        put("movel " + place() + ", until " + condition() + " else");
        ++depth_, statement(), --depth_;
        return put("end");
      default:
        put("try");
        ++depth_, statement(), --depth_;
        put("on error e");
        put("  log(\"{e.kind}\")");
        return put("end");
    }
  }

  std::mt19937 random_;
  std::string text_;
  std::size_t depth_ = 0;
  int count_ = 0;
};

/// Parses, formats, checks and runs it for a tenth of a second. True if it could run.
bool survives(const std::string& text) {
  Problems problems;
  Program program = parse(text, "t", problems);
  for (const Problem& problem : problems.list()) EXPECT_FALSE(problem.what.empty()) << text;
  const bool runs = !problems.has_errors();
  if (runs) {
    const std::string once = format(text);
    Problems again;
    parse(once, "t", again);
    EXPECT_FALSE(again.has_errors()) << text << "\n---\n" << once;
    EXPECT_EQ(format(once), once) << text;
  }
  check(program, {}, problems);
  if (!runs) return false;
  FakeHost host;
  host.store.declare_tag("A", true);
  host.store.declare_tag("B", false);
  Interpreter interpreter(std::move(program), host);
  run(interpreter, host, nanoseconds(0.1));
  return true;
}

TEST(LaterSyntax, RandomAndDamagedProgramsDoNoHarm) {
  const char* given = std::getenv("POLYARM_LATER_SYNTAX");
  const int wanted = given ? std::atoi(given) : 600;
  int ran = 0;
  for (int i = 0; i < wanted && !testing::Test::HasFailure(); ++i) {
    SCOPED_TRACE(i);
    ran += survives(Author(static_cast<std::uint32_t>(i)).program());
    survives(Author(static_cast<std::uint32_t>(i)).damaged());
  }
  EXPECT_GT(ran, wanted / 4);
}

}  // namespace
}  // namespace polyarm::program
