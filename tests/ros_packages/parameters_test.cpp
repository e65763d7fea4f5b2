/// Parameter files of generate_parameter_library as headers, and what is refused.
#include <gtest/gtest.h>

#include "polyarm/base/error.hpp"
#include "polyarm/ros_packages/parameter_code.hpp"
#include "tests/support/damaged.hpp"

namespace polyarm::ros_packages {
namespace {

std::string header(const std::string& text) {
  return parameter_header(text, "parameters.yaml", "");
}
void expect_has(const std::string& code, const std::string& part) {
  EXPECT_NE(code.find(part), std::string::npos) << part << "\nis not in\n" << code;
}

TEST(ParameterHeader, TypesAndDefaultsAreThoseOfTheFile) {
  const std::string code = header(
      "drive:\n"
      "  name: {type: string, default_value: 'a \"b\"'}\n"
      "  radius: {type: double, default_value: 1}\n"
      "  open: {type: double, default_value: .nan}\n"
      "  count: {type: int, default_value: 3}\n"
      "  on: {type: bool, default_value: true}\n"
      "  axes: {type: double_array_fixed_6, default_value: [0.5, 2]}\n"
      "  ghost: {type: none}\n");
  expect_has(code, "namespace drive {");
  expect_has(code, "std::string name = \"a \\\"b\\\"\";");
  expect_has(code, "double radius = 1.0;");
  expect_has(code, "double open = std::numeric_limits<double>::quiet_NaN();");
  expect_has(code, "std::int64_t count = 3;");
  expect_has(code, "bool on = true;");
  expect_has(code, "std::vector<double> axes = {0.5, 2.0};");
  EXPECT_EQ(code.find("ghost"), std::string::npos);
}

TEST(ParameterHeader, ValidatorsAreCalledWithTheTypeOfTheParameter) {
  const std::string code = header(
      "drive:\n"
      "  a: {type: double, validation: {gt<>: [0], 'my::rule': null}}\n"
      "  b: {type: string_array, validation: {subset_of<>: [['x', '1']], fixed_size<>: 2}}\n");
  expect_has(code, "gt<double>(p, 0.0)");
  expect_has(code, "namespace drive {\n\nusing ::rsl::bounds;\n");  // a file may name them drive::bounds
  expect_has(code, "my::rule(p)");
  expect_has(code, "subset_of<std::string>(p, {\"x\", ");
  expect_has(code, "fixed_size<std::string>(p, 2)");
}

TEST(ParameterHeader, AMapTakesItsKeysFromTheNearestListOfItsName) {
  const std::string code = header(
      "arm:\n"
      "  joints: {type: string_array}\n"
      "  gains:\n"
      "    __map_joints:\n"
      "      p: {type: double, default_value: 0.0}\n");
  expect_has(code, "struct MapJoints {");
  expect_has(code, "std::map<std::string, MapJoints> joints_map;");
  expect_has(code, ": params.joints)");
}

TEST(ParameterHeader, WhatCannotBeIsRefusedWithItsLine) {
  const auto refusal = [](const std::string& text) -> std::string {
    try {
      header(text);
    } catch (const Error& e) {
      return e.what();
    }
    return {};
  };
  EXPECT_NE(refusal("a:\n  b: {type: tensor}\n").find("parameters.yaml:2"), std::string::npos);
  EXPECT_NE(refusal("a:\n  b: {type: int, default_value: many}\n").find("'many' is no number"),
            std::string::npos);
  EXPECT_NE(refusal("a:\n  1b: {type: int}\n").find("'1b' is no name"), std::string::npos);
  EXPECT_NE(refusal("a:\n  b: 5\n").find("has no type"), std::string::npos);
  EXPECT_NE(refusal("a:\n  __map_k: {p: {type: int}}\n").find("no parameter 'k'"), std::string::npos);
  EXPECT_NE(refusal("a:\n  b: {type: int, validation: {'f(); evil': null}}\n").find("no name of a validator"),
            std::string::npos);
  EXPECT_NE(refusal("[]").find("not one key"), std::string::npos);
  std::string deep = "a:\n";
  for (int i = 1; i < 40; ++i) deep += std::string(static_cast<std::size_t>(i), ' ') + "b:\n";
  deep += std::string(40, ' ') + "c: {type: int}\n";
  EXPECT_NE(refusal(deep).find("too deep"), std::string::npos);
}

TEST(ParameterHeader, ADamagedFileIsReadOrRefused) {
  const std::string good =
      "arm:\n"
      "  joints: {type: string_array, default_value: [a, b], validation: {unique<>: null, size_gt<>: [0]}}\n"
      "  gains:\n"
      "    __map_joints:\n"
      "      p: {type: double, default_value: .inf, validation: {bounds<>: [0.0, 1e3]}}\n"
      "  mode: {type: string, default_value: \"x\", validation: {one_of<>: [[\"x\", \"y\"]]}}\n";
  const std::vector<std::string> pieces = {"__map_", "type: ", "[[[", "{", "<>", "\n  ", "null", "\"", "&a", "*a"};
  std::mt19937 random(28);
  int read = 0, refused = 0;
  for (int i = 0; i < 3000; ++i) {
    try {
      read += header(test::damaged(good, pieces, 12, random)).empty() ? 0 : 1;
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(read, 0);
  EXPECT_GT(refused, 0);
}

}  // namespace
}  // namespace polyarm::ros_packages
