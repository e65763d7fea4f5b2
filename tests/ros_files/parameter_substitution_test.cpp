#include "polyarm/ros_files/parameter_substitution.hpp"

#include <gtest/gtest.h>

#include <random>

#include "polyarm/ros_files/controllers_file.hpp"
#include "tests/support/folder.hpp"

namespace polyarm::ros_files {
namespace {

ParameterSubstitution named() {
  return {[](const std::string& name) -> std::optional<std::string> {
            if (name == "tf_prefix") return "left_";
            if (name == "which") return "tf_prefix";
            if (name == "empty") return "";
            if (name == "lines") return "1\nevil: 2";
            return std::nullopt;
          },
          [](const std::string& package) -> std::filesystem::path {
            return package == "my_robot" ? "/share/my_robot" : "";
          }};
}

std::string replaced(const std::string& text, Problems& problems) {
  return substitute_parameters(text, "/config/controllers.yaml", named(), problems);
}

TEST(ParameterSubstitution, PutsValuesInThePlaceOfNames) {
  Problems problems;
  EXPECT_EQ(replaced("joints:\n  - $(var tf_prefix)shoulder\n  - \"$(var empty)elbow\"\n", problems),
            "joints:\n  - left_shoulder\n  - \"elbow\"\n");
  EXPECT_EQ(replaced("$(var $(var which))a", problems), "left_a");
  EXPECT_EQ(replaced("file: $(find-pkg-share my_robot)/a.yaml, beside: $(dirname)/b.yaml", problems),
            "file: /share/my_robot/a.yaml, beside: /config/b.yaml");
  EXPECT_EQ(replaced("a: $(var other 'x') (and more)", problems), "a: x (and more)");
  EXPECT_EQ(replaced("a: $(env POLYARM_SURELY_NOT_SET 7)", problems), "a: 7");
  EXPECT_EQ(replaced("a: 1  # not $(command rm)\n'b # $(var tf_prefix)': 2", problems),
            "a: 1  # not $(command rm)\n'b # left_': 2");
  EXPECT_TRUE(problems.list().empty()) << problems.list().front().what;
}

TEST(ParameterSubstitution, WhatHasNoValueIsToldWithItsPlaceAndStays) {
  for (const auto& [text, code] : {std::pair{"a: 1\nb: $(var missing)", "unknown-arg"},
                                   {"a: 1\nb: $(command rm -r x)", "bad-substitution"},
                                   {"a: 1\nb: $(find-pkg-share nowhere)", "no-package"},
                                   {"a: 1\nb: $(env POLYARM_SURELY_NOT_SET)", "no-variable"},
                                   {"a: 1\nb: $()", "bad-substitution"},
                                   {"a: 1\nb: $(var tf_prefix", "bad-substitution"},
                                   {"a: 1\nb: $(var $(var which)", "bad-substitution"},
                                   {"a: 1\nb: $(var lines)", "bad-substitution"}}) {
    Problems problems;
    EXPECT_EQ(replaced(text, problems), text);
    ASSERT_EQ(problems.list().size(), 1u) << text;
    EXPECT_EQ(problems.list()[0].code, code) << text;
    EXPECT_EQ(problems.list()[0].where.line, 2);
    EXPECT_EQ(problems.list()[0].where.column, 4);
  }
}

TEST(ParameterSubstitution, ReplacementsThatMakeMoreOfThemEnd) {
  Problems problems;
  const ParameterSubstitution endless{
      [](const std::string&) { return std::optional<std::string>("$(var a)$(var a)"); }, {}};
  EXPECT_EQ(substitute_parameters("a: $(var a)", "f.yaml", endless, problems), "a: $(var a)");
  ASSERT_EQ(problems.list().size(), 1u);
  EXPECT_EQ(problems.list()[0].code, "bad-substitution");
}

TEST(ParameterSubstitution, AnyTextEnds) {
  std::mt19937 random(7);
  const std::vector<std::string> pieces{"$(",
                                        ")",
                                        "var ",
                                        "tf_prefix",
                                        "env ",
                                        "dirname",
                                        "\n",
                                        " ",
                                        "'",
                                        "\"",
                                        "# ",
                                        "$",
                                        "(",
                                        "\\",
                                        "a: ",
                                        "which",
                                        "find-pkg-share my_robot"};
  for (int i = 0; i < 20000; ++i) {
    std::string text;
    for (std::size_t n = random() % 12; n > 0; --n) text += pieces[random() % pieces.size()];
    Problems problems;
    const std::string out = replaced(text, problems);
    EXPECT_EQ(std::count(out.begin(), out.end(), '\n'), std::count(text.begin(), text.end(), '\n')) << text;
  }
}

TEST(ParameterSubstitution, AControllersFileIsReadWithIt) {
  const test::Folder folder;
  const std::string file = folder.write("controllers.yaml", R"(controller_manager:
  ros__parameters:
    arm: {type: forward_command_controller/ForwardCommandController}
arm:
  ros__parameters:
    joints: [$(var tf_prefix)a, $(var tf_prefix)b]
    interface_name: position
)");
  Problems problems;
  const ControllersFile read = read_controllers_files({file}, problems, named());
  ASSERT_EQ(read.controllers.size(), 1u);
  EXPECT_EQ(read.controllers[0].parameters.entries.at("joints").values,
            (std::vector<std::string>{"left_a", "left_b"}));
  EXPECT_TRUE(problems.list().empty());
  read_controllers_files({file}, problems);
  ASSERT_EQ(problems.list().size(), 1u);
  EXPECT_EQ(problems.list()[0].where.line, 6);
}

}  // namespace
}  // namespace polyarm::ros_files
