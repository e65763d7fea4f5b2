#include <gtest/gtest.h>

#include <random>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/launch/launch_substitution.hpp"
#include "tests/ros_files/launch_pieces.hpp"
#include "tests/support/damaged.hpp"

namespace polyarm::ros_files {
namespace {

std::string evaluated(const std::string& expression) {
  Substitution with;
  with.args = {{"n", "3"}, {"x", "0.5"}, {"on", "true"}, {"name", "ur3"}, {"one", "1.0"}};
  with.folder = "/here";
  try {
    return evaluate_launch_expression(expression, with);
  } catch (const Error& error) {
    return std::string("! ") + error.problems().front().what;
  }
}

TEST(LaunchExpression, GivesWhatPythonGives) {
  const std::pair<const char*, const char*> cases[] = {
      {"1 + 2 * 3", "7"},
      {"(1 + 2) * 3", "9"},
      {"7 / 2", "3.5"},
      {"7 // 2", "3"},
      {"-7 // 2", "-4"},
      {"-7 % 3", "2"},
      {"2 ** 10", "1024"},
      {"4 / 2", "2.0"},
      {"n + 1", "4"},
      {"n * x", "1.5"},
      {"one", "1.0"},
      {"arg('n') == 3", "True"},
      {"not on", "False"},
      {"on and n > 2", "True"},
      {"n if on else x", "3"},
      {"'a' + \"b\"", "ab"},
      {"'u' in name", "True"},
      {"'z' not in name", "True"},
      {"name == 'ur3'", "True"},
      {"name == 3", "False"},
      {"str(n) + 'x'", "3x"},
      {"int('12') + 1", "13"},
      {"float(n)", "3.0"},
      {"len(name)", "3"},
      {"max(1, n, 2)", "3"},
      {"min(1, x)", "0.5"},
      {"abs(-2)", "2"},
      {"round(2.6)", "3"},
      {"dirname() + '/a'", "/here/a"},
      {"optenv('POLYARM_NEVER_SET', 'd')", "d"},
      {"1e3", "1000.0"},
      {"name or 'y'", "ur3"},
      {"'' or 'y'", "y"},
      {"true", "True"},
      {"None", ""},
      {"bool('')", "False"},
      {"2*3**2", "18"},
      {"2**3**2", "512"},
      {"-2**2", "-4"},
      {"2**-1", "0.5"},
      {"name not in ['ompl', 'chomp', 'ur3']", "False"},
      {"arg('name') not in ['ompl', 'chomp']", "True"},
      {"name in ('ur3', 'ur5')", "True"},
      {"name in ()", "False"},
      {"n in [1, 2, 3]", "True"},
      {"1 < n < 3", "False"},
      {"3 >= n > 2 != 1", "True"},
      {"[1]", "[1]"},
      {"'a' * 3", "aaa"},
      {"name.upper()", "UR3"},
      {"name[0:2]", "ur"},
      {"unknown if False else 1", "1"},
  };
  for (const auto& [expression, result] : cases) EXPECT_EQ(evaluated(expression), result) << expression;
}

TEST(LaunchExpression, RefusesTheRestInOneSentence) {
  for (const char* expression :
       {"",          "1 +",  "(1",      "1 2",       "'a",        "unknown",  "1 if 2",
        "a.b",       "[1",   "f(",      "1 < 'a'",   "'a' * 'b'", "1 in 'a'", "'a' * 100000",
        "2 ** 5000", "-'a'", "1 not 2", "exec('x')", "a__b",      "1 % 0",    "@"})
    EXPECT_TRUE(evaluated(expression).starts_with("! ")) << expression << " gives " << evaluated(expression);
  EXPECT_TRUE(evaluated(std::string(100000, '(')).starts_with("! "));
  EXPECT_TRUE(evaluated(std::string(100000, '-') + "1").starts_with("! "));
}

TEST(LaunchExpression, AnUnknownArgIsNamedWithTheLikelyOne) {
  EXPECT_TRUE(
      evaluated("nam == 'ur3'").find("no arg 'nam' is declared before this line; did you mean 'name'?") !=
      std::string::npos)
      << evaluated("nam == 'ur3'");
}

TEST(ShellWords, FollowQuotes) {
  EXPECT_EQ(shell_words("a 'b c' d\"e f\" g\\ h ''"),
            (std::vector<std::string>{"a", "b c", "de f", "g h", ""}));
  EXPECT_TRUE(shell_words("  \n").empty());
  EXPECT_EQ(shell_words(R"("a\"b" "c\\d" "e\f" 'g\h')"),
            (std::vector<std::string>{"a\"b", "c\\d", "e\\f", "g\\h"}))
      << "within quotes a backslash escapes only quotes and itself";
}

TEST(DamagedLaunchExpressions, EndInAResultOrASentence) {
  std::mt19937 random(7);
  int results = 0;
  for (int i = 0; i < 20000; ++i) {
    const std::string text = test::damaged(
        "n + 2 * (x - 1) if on and name == 'ur3' else max(1, int('4')) // 3", kLaunchPieces, 14, random);
    results += evaluated(text).starts_with("! ") ? 0 : 1;
  }
  EXPECT_GT(results, 300);
}

}  // namespace
}  // namespace polyarm::ros_files
