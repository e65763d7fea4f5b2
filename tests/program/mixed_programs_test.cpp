/// Statements of all cases put together anew, in blocks of every kind, in cells where anything happens: moves
/// fail, tags change, people stop and step, power goes. Whatever they say, they end without a crash, within
/// their budget, and never leave a task that neither waits nor goes on. POLYARM_MIXED_PROGRAMS says how many
/// (400).
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "fake_host.hpp"
#include "given.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/language/lexer.hpp"
#include "polyarm/language/parser.hpp"
#include "polyarm/program/checker.hpp"

namespace polyarm::program {
namespace {

class Dice {
 public:
  explicit Dice(std::uint32_t seed) : random_{seed} {}
  std::size_t draw(std::size_t below) {
    return std::uniform_int_distribution<std::size_t>(0, below - 1)(random_);
  }
  bool chance(int percent) { return draw(100) < static_cast<std::size_t>(percent); }
  const std::string& one_of(const std::vector<std::string>& from) { return from[draw(from.size())]; }

 private:
  std::mt19937 random_;
};

/// The statements of the cases, each whole with its blocks, and the names that the cases are given.
struct Material {
  std::vector<std::string> statements, lines;
};

void cut(const std::string& text, Material& out) {
  const std::vector<std::string> lines = split_lines(text);
  out.lines.insert(out.lines.end(), lines.begin(), lines.end());
  std::string statement;
  int depth = 0;
  for (const SourceLine& line : read_source(lines)) {
    const BlockRole role = block_role(line);
    if (role == BlockRole::opens) ++depth;
    if (role == BlockRole::closes) --depth;
    statement += std::string(line.raw) + "\n";
    if (depth > 0) continue;
    const bool ends_all = statement.starts_with("stop") || statement.starts_with("include");
    if (depth == 0 && statement.size() < 1500 && !ends_all) out.statements.push_back(statement);
    statement.clear();
    depth = 0;
  }
}

const Material& material() {
  static const Material made = [] {
    Material out;
    std::set<std::filesystem::path> files;
    for (const auto& file : std::filesystem::recursive_directory_iterator(std::string(POLYARM_SOURCE_DIR) +
                                                                          "/tests/program/cases"))
      if (file.path().extension() == ".script") files.insert(file.path());
    for (const auto& file : files) cut(read_file(file), out);
    return out;
  }();
  return made;
}

std::string statements(Dice& dice, std::size_t most, int deep) {
  static const std::vector<std::string> kBlocks = {
      "for i in 1 .. 3\n", "while A_tag\n",        "if A_tag or not Other\n", "try\n",
      "task T\n",          "when A_tag changes\n", "when A_tag do\n",         "together\n",
      "on stop\n",         "lock Place\n",         "func made(n, m = 2)\n",   "use speed 50%\n"};
  std::string out;
  for (std::size_t i = 1 + dice.draw(most); i > 0; --i) {
    if (deep == 0 || !dice.chance(25)) {
      const bool caught = dice.chance(75);  // else the first that fails ends it all
      out += (caught ? "try\n" : "") + dice.one_of(material().statements) + (caught ? "on error\nend\n" : "");
      continue;
    }
    const std::string& block = dice.one_of(kBlocks);
    out += block + statements(dice, 3, deep - 1);
    if (block == "try\n")
      out += "on error e\n" + (dice.chance(50) ? "log(e.text)\n" : statements(dice, 2, 0));
    out += "end\n";
  }
  return out;
}

/// Without the lines in which something is wrong, as often as it takes.
std::optional<Program> repaired(std::string text) {
  for (int tries = 0; tries < 30; ++tries) {
    Problems problems;
    Program program = parse(text, "mixed", problems);
    std::set<int> wrong;
    for (const Problem& problem : problems.list())
      if (problem.severity == Severity::error) wrong.insert(problem.where.line);
    if (wrong.empty()) return program;
    const std::vector<std::string> lines = split_lines(text);
    text.clear();
    for (int i = 1; i <= static_cast<int>(lines.size()); ++i)
      if (!wrong.contains(i)) text += lines[static_cast<std::size_t>(i) - 1] + "\n";
  }
  return std::nullopt;
}

void furnish(FakeHost& host, Dice& dice) {
  host.store.declare_tag("A_tag", dice.chance(50));
  host.store.declare_tag("Other", dice.chance(50));
  for (const char* name : {"A", "B", "P", "Home"}) host.store.declare_tag(name, data::Point{});
  give(host, material().lines);
  host.answers = dice.chance(80);
  host.given_answers = {"4", "yes", "", "2mm", "nonsense"};
  host.room = 1 + dice.draw(6);
}

/// One thing that somebody else does.
void happen(FakeHost& host, Interpreter& interpreter, Dice& dice) {
  const std::vector<std::string> names = host.store.names();
  const std::string& name = dice.one_of(names);
  const data::Value& value = *host.store.find(name);
  const TaskStatus status = interpreter.overview();
  switch (dice.draw(9)) {
    case 0:
    case 1:
    case 2:
      if (value.as_boolean()) host.store.set(name, !*value.as_boolean(), "somebody");
      if (value.as_number()) host.store.set(name, data::Number{1, value.as_number()->dimension}, "somebody");
      return;
    case 3:
      return interpreter.pause();
    case 4:
      if (interpreter.paused()) interpreter.resume_for(static_cast<StepKind>(dice.draw(3)));
      return;
    case 5:
      if (!host.queued.empty()) host.queued[dice.draw(host.queued.size())].fails = true;
      return;
    case 6:
      interpreter.set_breakpoints({{"mixed", static_cast<int>(1 + dice.draw(40)), 1}});
      return;
    case 7:
      interpreter.variables(status.name), interpreter.calls(status.name), interpreter.uses(status.name);
      return;
    default:
      if (dice.chance(3)) host.dropped = true;
      if (dice.chance(2)) interpreter.stop();
  }
}

/// Steps it until it has ended or two minutes of its time have passed; true where it began anything. Now and
/// then `kept` becomes where it stands.
bool live(Interpreter& interpreter, FakeHost& host, Dice& dice, std::optional<SavedState>& kept) {
  constexpr int kBudget = 200, kOvershoot = 400;  // a statement may cost more than is left
  int begun = 0;
  for (int tick = 0; tick < 3000; ++tick) {
    const StepResult result = interpreter.step(kBudget);
    EXPECT_LE(result.executed, kBudget + kOvershoot + 100'000 * (result.executed > 90'000));
    begun += result.executed;
    if (result.state != TaskState::running && result.state != TaskState::waiting) break;
    for (const TaskStatus& task : interpreter.status())
      EXPECT_FALSE(task.state == TaskState::waiting && task.waiting.kind == WaitKind::none && !task.paused);
    host.time += 2'000'000 * static_cast<Nanoseconds>(1 + 50 * (tick > 1500));
    if (dice.chance(10)) happen(host, interpreter, dice);
    if (dice.chance(kept ? 1 : 20) && interpreter.safe()) kept = interpreter.save();
    if (interpreter.paused() && dice.chance(20)) interpreter.resume();
  }
  return begun > 0;
}

int wanted_mixtures() {
  const char* given = std::getenv("POLYARM_MIXED_PROGRAMS");
  return given ? std::atoi(given) : 400;
}

TEST(MixedPrograms, EndOrWaitWhateverHappens) {
  int ran = 0, saved = 0, moved = 0;
  for (int i = 0; i < wanted_mixtures(); ++i) {
    Dice dice(static_cast<std::uint32_t>(i));
    SCOPED_TRACE(i);
    auto program = repaired(statements(dice, 12, 3));
    if (!program) continue;
    KnownNames known;
    FakeHost host, again;
    furnish(host, dice), furnish(again, dice);
    known.add(host.store);
    Problems told;
    check(*program, known, told);  // errors or not: what was parsed may be run
    const auto compiled = std::make_shared<Compiled>(std::move(*program));
    Interpreter interpreter(compiled, host);
    std::optional<SavedState> kept, unused;
    ran += live(interpreter, host, dice, kept);
    moved += static_cast<int>(host.moves.size());
    EXPECT_TRUE(interpreter.state() != TaskState::failed || interpreter.overview().problem);
    if (!kept) continue;
    Interpreter next(compiled, again);  // after a loss of power
    next.restore(*kept);
    live(next, again, dice, unused);
    ++saved;
  }
  EXPECT_GT(ran, wanted_mixtures() / 2);
  EXPECT_GT(moved, wanted_mixtures() / 4);  // few programs make most of the moves
  EXPECT_GT(saved, wanted_mixtures() / 5);  // a loop that never waits is never saved
}

}  // namespace
}  // namespace polyarm::program
