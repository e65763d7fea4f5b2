/// Programs that nobody wrote: what they log and how they fail is the same for the interpreter and for a walk
/// down the tree, in one piece, in small steps, and with a break for a safe point. POLYARM_RANDOM_PROGRAMS
/// says how many (500).
#include <gtest/gtest.h>

#include <cstdlib>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "fake_host.hpp"
#include "parsed.hpp"
#include "polyarm/language/parser.hpp"
#include "tree_evaluator.hpp"

namespace polyarm::program {
namespace {

/// Writes programs that calculate; nearly every line means something, some are wrong when they run.
class Author {
 public:
  explicit Author(std::uint32_t seed) : random_{seed} {}

  std::string program() {
    for (const char* line : {"let n = 3", "let m = 0.5", "let w = 20mm", "let l = [1, 2, 3]", "let t = \"t\"",
                             "let r = {x = 1, y = [1, 2]}", "let ok = True"})
      put(line);
    names_.push_back({"n", "m"});
    for (std::size_t i = draw(3); i > 0; --i) function();
    for (std::size_t i = 4 + draw(12); i > 0; --i) guarded();
    put("log(n, m, w, l, t, r, ok)");
    return text_;
  }

 private:
  std::size_t draw(std::size_t below) {
    return std::uniform_int_distribution<std::size_t>(0, below - 1)(random_);
  }
  bool chance(int percent) { return draw(100) < static_cast<std::size_t>(percent); }
  std::string one_of(const std::vector<std::string>& from) { return from[draw(from.size())]; }

  void put(const std::string& line) { text_ += std::string(depth_ * 2, ' ') + line + "\n"; }

  std::string a_name() {
    std::vector<std::string> all;
    for (const auto& scope : names_) all.insert(all.end(), scope.begin(), scope.end());
    return all.empty() ? "1" : one_of(all);
  }
  /// None that a loop counts with: it would go on from there, maybe for ever.
  std::string a_variable() {
    const std::string name = a_name();
    return name.front() == 'i' || name.starts_with("at") ? "n" : name;
  }
  std::string new_name(const char* like) { return like + std::to_string(++count_); }

  std::string number(int deep = 0) {
    if (deep > 3 || chance(30))
      return one_of({"0", "1", "2", "3", "7", "10", "0.5", "2.25", "100", "5mm", "2s"});
    if (chance(40)) return a_name();
    if (chance(60))
      return number(deep + 1) + one_of({" + ", " - ", " * ", " / ", " mod "}) + number(deep + 1);
    if (chance(20)) return "-(" + number(deep + 1) + ")";
    if (chance(25) && !functions_.empty()) return call(deep);
    if (chance(20)) return "(" + condition(deep + 1) + ")";
    const std::string inner = number(deep + 2);
    return one_of({"abs(" + inner + ")", "floor(" + inner + ")", "max(1, " + inner + ")",
                   "min(3, " + inner + ")", "l[" + inner + "]", "r.y[" + inner + "]",
                   "length(l) + " + inner});
  }

  std::string call(int deep) {
    const auto& [name, parameters] = functions_[draw(functions_.size())];
    std::string out = name + "(";
    for (std::size_t i = 0; i < parameters; ++i) out += (i > 0 ? ", " : "") + number(deep + 2);
    return out + ")";
  }

  std::string condition(int deep = 0) {
    if (deep < 3 && chance(25)) return condition(deep + 1) + one_of({" and ", " or "}) + condition(deep + 1);
    if (deep < 3 && chance(10)) return "not (" + condition(deep + 1) + ")";
    if (chance(5)) return one_of({"ok", "True", "False", "n"});
    return number(2) + one_of({" == ", " != ", " < ", " <= ", " > ", " >= "}) + number(2);
  }

  std::string anything() {
    if (chance(75)) return number();
    if (chance(30)) return "\"<{" + a_name() + "}>\"";
    if (chance(30)) return "[" + number(2) + ", " + number(2) + "]";
    return one_of({"l", "t", "r", "w", "l[n]", "r.y", "l[2]", "r.x"});
  }

  void block(std::size_t most) {
    names_.emplace_back();
    ++depth_;
    for (std::size_t i = 1 + draw(most); i > 0; --i) statement();
    --depth_;
    names_.pop_back();
  }

  void function() {
    const std::string name = new_name("f");
    const std::size_t parameters = draw(3);
    std::string head = "func " + name + "(";
    const auto outside = names_;
    names_ = {{"n", "m"}, {}};
    for (std::size_t i = 0; i < parameters; ++i) {
      names_.back().push_back(new_name("p"));
      head += (i > 0 ? ", " : "") + names_.back().back() + (i + 1 == parameters && chance(50) ? " = 4" : "");
    }
    put(head + ")");
    in_function_ = true;
    block(5);
    in_function_ = false;
    if (chance(90)) put("  return " + number());
    put("end");
    names_ = outside;
    functions_.emplace_back(name, parameters);
  }

  /// Outside of blocks most errors are told, so that the program goes on.
  void guarded() {
    if (chance(20)) return statement();
    put("try");
    block(3);
    put("on error e");
    put("  log(e.line, e.text)");
    put("end");
  }

  void statement() {
    const std::size_t which = draw(100);
    if (which < 18) {
      const std::string name = new_name("v"), value = number();
      put("let " + name + " = " + value);
      return names_.back().push_back(name);
    }
    if (which < 34) return put("set " + a_variable() + " = " + number());
    if (which < 38) return put("set n = n + 1");
    if (which < 43) return put("set l[" + one_of({"1", "2", "3", "n", number(3)}) + "] = " + anything());
    if (which < 46) return put("set l = l + [" + number() + (chance(30) ? ", " + number() + "]" : "]"));
    if (which < 49) return put("set r.x = " + anything());
    if (which < 51) return put("set r.y[" + number(3) + "] = " + anything());
    if (which < 54) return put("set t = t + " + one_of({"\"{n}\"", "\"x\"", "n"}));
    if (which < 57) return put("set w = w " + one_of({"+ 5mm", "* 2", "+ 1", "- w / 2"}));
    if (which < 60) return put("set ok = " + condition());
    if (which < 70) return put("log(" + anything() + ", " + (chance(50) ? anything() : condition()) + ")");
    if (depth_ > 4) return put("log(" + a_name() + ")");
    if (which < 80) return branch();
    if (which < 92) return loop();
    if (which < 94 && !functions_.empty()) return put(call(1));
    if (which < 96 && in_function_) return put("return " + number());
    if (which < 98 && loops_ > 0) return put(one_of({"break", "continue"}));
    put("try");
    block(2);
    put("on error e");
    block(2);
    put("end");
  }

  void branch() {
    put("if " + condition());
    block(3);
    if (chance(40)) put("elif " + condition()), block(2);
    if (chance(40)) put("else"), block(2);
    put("end");
  }

  void loop() {
    ++loops_;
    const std::string name = new_name("i");
    if (chance(25)) {
      const std::string turns = new_name("k");
      put("let " + turns + " = 0");
      put("while " + turns + " < " + std::to_string(1 + draw(4)) +
          (chance(30) ? " and " + condition(1) : ""));
      put("  set " + turns + " = " + turns + " + 1");
      block(3);
    } else {
      const bool places = chance(25);
      const std::string place = new_name("at");
      put("for " + (places ? place + ", " : "") + name + " in " +
          one_of({"1 .. 3", "0 .. n mod 5", "l", "[1, 5mm]", "1mm .. 3mm", "2 .. 1", "r.y"}));
      names_.push_back({name});
      if (places) names_.back().push_back(place);
      block(4);
      names_.pop_back();
    }
    put("end");
    --loops_;
  }

  std::mt19937 random_;
  std::string text_;
  std::vector<std::vector<std::string>> names_;
  std::vector<std::pair<std::string, std::size_t>> functions_;
  std::size_t depth_ = 0;
  int count_ = 0, loops_ = 0;
  bool in_function_ = false;
};

struct Outcome {
  std::vector<std::pair<int, std::string>> logs;
  std::string failure;
  bool operator==(const Outcome&) const = default;
};

Outcome outcome(const FakeHost& host, const Interpreter& interpreter) {
  Outcome out{host.logs, {}};
  const TaskStatus status = interpreter.overview();
  if (status.problem) out.failure = std::to_string(status.problem->where.line) + ": " + status.problem->what;
  return out;
}

/// Nothing where it is too long to wait for.
std::optional<Outcome> by_tree(const std::string& text) {
  const Program program = parsed(text);
  TreeEvaluator tree(program);
  tree.run();
  if (tree.too_long) return std::nullopt;
  Outcome out{tree.logs, {}};
  if (tree.failure) out.failure = std::to_string(tree.failure->line) + ": " + tree.failure->what;
  return out;
}

Outcome by_interpreter(const std::string& text, int budget) {
  FakeHost host;
  Interpreter interpreter(parsed(text), host);
  for (int i = 0; i < 2'000'000 && interpreter.state() == TaskState::running; ++i) interpreter.step(budget);
  EXPECT_EQ(interpreter.state() == TaskState::failed, interpreter.overview().problem.has_value());
  return outcome(host, interpreter);
}

/// The program is taken down after some steps and goes on in another interpreter.
Outcome in_two_pieces(const std::string& text, int steps) {
  FakeHost host;
  SavedState state;
  {
    Interpreter first(parsed(text), host);
    first.step(steps);
    if (first.state() != TaskState::running || !first.safe()) return outcome(host, first);
    state = first.save();
  }
  Interpreter second(parsed(text), host);
  second.restore(state);
  while (second.state() == TaskState::running) second.step(100);
  return outcome(host, second);
}

/// A failure without the calls that led to it, which the tree does not know.
std::string without_calls(const std::string& failure) {
  return failure.substr(0, failure.find("; called from line "));
}

int wanted_programs() {
  const char* given = std::getenv("POLYARM_RANDOM_PROGRAMS");
  return given ? std::atoi(given) : 500;
}

TEST(RandomPrograms, DoTheSameAsTheirTree) {
  int finished = 0, said = 0;
  for (int i = 0; i < wanted_programs(); ++i) {
    const std::string text = Author(static_cast<std::uint32_t>(i)).program();
    const std::optional<Outcome> expected = by_tree(text);
    if (!expected) continue;
    const Outcome found = by_interpreter(text, 1000);
    ASSERT_EQ(found.logs, expected->logs) << i << "\n" << text;
    ASSERT_EQ(without_calls(found.failure), expected->failure) << i << "\n" << text;
    ASSERT_EQ(by_interpreter(text, 1), found) << i << "\n" << text;
    ASSERT_EQ(in_two_pieces(text, 1 + i % 60), found) << i << "\n" << text;
    finished += found.failure.empty();
    said += static_cast<int>(found.logs.size());
  }
  EXPECT_GT(finished, wanted_programs() / 4);
  EXPECT_GT(said, wanted_programs() * 3);
}

}  // namespace
}  // namespace polyarm::program
