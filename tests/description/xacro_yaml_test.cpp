#include "polyarm/xacro/xacro_yaml.hpp"

#include <gtest/gtest.h>

#include "polyarm/base/error.hpp"
#include "tests/description/support.hpp"

namespace polyarm::description::xacro_yaml_test {
namespace {

using test::has;

XacroValue read(const std::string& text) {
  XacroNames none;
  none.property = [](const std::string&, XacroValue&) { return false; };
  none.function = [](const std::string&, const XacroList&, XacroValue&) { return false; };
  none.member = [](const XacroScope*, const std::string&, XacroValue&) { return false; };
  return read_yaml(text, "a.yaml", [&](const std::string& e) { return evaluate_expression(e, none); });
}

std::string refusal(const std::string& text) {
  try {
    read(text);
  } catch (const Error& e) {
    return e.what();
  }
  return "taken";
}

TEST(XacroYaml, PlainWordsAreWhatYaml11TakesThemFor) {
  for (const auto& [word, wanted] :
       std::vector<std::pair<const char*, const char*>>{{"1", "1"},
                                                        {"-1_000", "-1000"},
                                                        {"0x1F", "31"},
                                                        {"0b101", "5"},
                                                        {"017", "15"},
                                                        {"08", "'08'"},
                                                        {"+3", "3"},
                                                        {"--3", "'--3'"},
                                                        {"0.5", "0.5"},
                                                        {"-.5", "-0.5"},
                                                        {"1.", "1.0"},
                                                        {"1.0e+5", "100000.0"},
                                                        {"1.0e5", "'1.0e5'"},
                                                        {"1e-5", "'1e-5'"},
                                                        {".inf", "inf"},
                                                        {"-.Inf", "-inf"},
                                                        {"nan", "'nan'"},
                                                        {"yes", "True"},
                                                        {"Off", "False"},
                                                        {"yEs", "'yEs'"},
                                                        {"y", "'y'"},
                                                        {"~", "None"},
                                                        {"Null", "None"},
                                                        {"'1'", "'1'"},
                                                        {"\"yes\"", "'yes'"},
                                                        {"!!str 5", "'5'"},
                                                        {"1.2.3.4", "'1.2.3.4'"},
                                                        {"99999999999999999999", "'99999999999999999999'"}})
    EXPECT_EQ(repr_of(read(word)), wanted) << word;
}

TEST(XacroYaml, UnitsBecomeRadiansAndMetres) {
  EXPECT_EQ(repr_of(read("!degrees 180")), "3.141592653589793");
  EXPECT_EQ(repr_of(read("!radians 2 * pi")), "6.283185307179586");
  EXPECT_EQ(repr_of(read("!millimeters 250")), "0.25");
  EXPECT_EQ(repr_of(read("!inches 10 - 9")), "0.0254");
  EXPECT_TRUE(has(refusal("a: 1\nb: !degrees x"), "a.yaml:2"));
}

TEST(XacroYaml, OfAKeyThatStandsTwiceTheLastValueHolds) {
  EXPECT_EQ(repr_of(read("inertia:\nmass: 1\ninertia: {xx: 2}\n")), "{'inertia': {'xx': 2}, 'mass': 1}");
}

TEST(XacroYaml, MapsTakeOverOthers) {
  EXPECT_EQ(repr_of(read("base: &b {x: 1, y: 2}\narm: {<<: *b, y: 3}\n")),
            "{'base': {'x': 1, 'y': 2}, 'arm': {'x': 1, 'y': 3}}");
  EXPECT_EQ(repr_of(read("- &a {x: 1}\n- &b {x: 2, z: 3}\n- {<<: [*a, *b]}\n")),
            "[{'x': 1}, {'x': 2, 'z': 3}, {'x': 1, 'z': 3}]");
  EXPECT_TRUE(has(refusal("<<: 5"), "takes over maps only"));
}

TEST(XacroYaml, WhatIsNoYamlIsRefusedWithItsLine) {
  EXPECT_TRUE(has(refusal("a: 1\nb: [1, 2\nc: 3\n"), "a.yaml:"));
  EXPECT_TRUE(has(refusal(std::string(100, '[') + std::string(100, ']')), "too deeply"));
}

TEST(XacroYamlFuzz, DamagedTextEndsInAValueOrAnError) {
  const std::string good =
      "a: &a {x: 1.5, y: [yes, ~, 0x1F]}\nb: {<<: *a, z: !degrees 90}\nc: ['q', \"r\", s]\nd: |\n  text\n";
  test::Mutator mutate(5);
  int taken = 0, refused = 0;
  for (int i = 0; i < 3000; ++i) try {
      (void)repr_of(read(mutate(good)));
      ++taken;
    } catch (const Error&) {
      ++refused;
    }
  EXPECT_GT(taken, 200);
  EXPECT_GT(refused, 200);
}

}  // namespace
}  // namespace polyarm::description::xacro_yaml_test
