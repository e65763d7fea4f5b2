#include <gtest/gtest.h>

#include <filesystem>
#include <numbers>
#include <random>

#include "polyarm/base/error.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/pose.hpp"
#include "polyarm/base/quantity.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/yaml/yaml.hpp"
#include "tests/support/folder.hpp"

namespace polyarm {
namespace {

constexpr double kPi = std::numbers::pi;

TEST(Pose, RpyGoesThereAndBack) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> angle(-3.1, 3.1), half(-1.5, 1.5);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 rpy{angle(random), half(random), angle(random)};
    const Vec3 back = to_rpy(from_rpy(rpy.x, rpy.y, rpy.z));
    EXPECT_NEAR(back.x, rpy.x, 1e-9);
    EXPECT_NEAR(back.y, rpy.y, 1e-9);
    EXPECT_NEAR(back.z, rpy.z, 1e-9);
  }
}

TEST(Pose, RpyAtTheEndOfPitchIsTheSameRotation) {
  for (const double pitch : {kPi / 2, -kPi / 2})
    for (const double yaw : {-2.0, 0.3, 1.0}) {
      const Quaternion q = from_rpy(0.7, pitch, yaw);
      const Vec3 rpy = to_rpy(q);
      EXPECT_LT(angle_between(q, from_rpy(rpy.x, rpy.y, rpy.z)), 1e-6);
    }
}

TEST(Pose, InverseUndoesAndComposesInOrder) {
  const Pose a = pose_xyz_rpy({1, 2, 3}, {0.1, 0.2, 0.3}), b = pose_xyz_rpy({-1, 0.5, 0}, {1, 0, 0});
  const Vec3 p{0.3, -0.2, 0.9};
  EXPECT_LT(norm((a * b) * p - a * (b * p)), 1e-12);
  EXPECT_LT(norm(inverse(a) * (a * p) - p), 1e-12);
}

TEST(Pose, RotationBetweenTurnsOneIntoTheOther) {
  for (const Vec3 to : {Vec3{0, 0, 1}, Vec3{0, 0, -1}, Vec3{1, 0, 0}, normalized(Vec3{1, 2, -3})})
    EXPECT_LT(norm(rotation_between({0, 0, 1}, to) * Vec3{0, 0, 1} - to), 1e-9);
}

TEST(Quantity, ReadsUnitsAndRefusesWrongOnes) {
  EXPECT_DOUBLE_EQ(*parse_quantity("40mm", Dimension::length), 0.04);
  EXPECT_DOUBLE_EQ(*parse_quantity("180deg", Dimension::angle), kPi);
  EXPECT_DOUBLE_EQ(*parse_quantity("1.5 m/s2", Dimension::acceleration), 1.5);
  EXPECT_DOUBLE_EQ(*parse_quantity("-.5", Dimension::length), -0.5);
  EXPECT_FALSE(parse_quantity("40mm", Dimension::angle));
  EXPECT_FALSE(parse_quantity("mm", Dimension::length));
  EXPECT_FALSE(parse_quantity("1e999", Dimension::none));
  EXPECT_FALSE(parse_quantity("", Dimension::none));
}

TEST(Text, NearestNameForgivesSmallSlips) {
  const std::vector<std::string> names{"GripperActive", "GripperInactive", "Repeat"};
  EXPECT_EQ(nearest_name("GriperActive", names), "GripperActive");
  EXPECT_EQ(nearest_name("repaet", names), "Repeat");
  EXPECT_EQ(nearest_name("Conveyor", names), std::nullopt);
}

TEST(Text, NobodyIsAskedWhetherTheyMeantWhatTheyWrote) {
  const std::vector<std::string> names{"mock", "mujoco"};
  EXPECT_EQ(did_you_mean("mujoco", names), "");
  EXPECT_EQ(did_you_mean("mujco", names), "; did you mean 'mujoco'?");
}

TEST(Text, NearestNameLooksAtTheWholeNameAndAtBeginnings) {
  const std::vector<std::string> robots{"fanuc/cr_7ia", "fanuc/lr_mate_200id_7l", "fanuc/lr_mate_200id",
                                        "universal_robots/ur5", "universal_robots/ur5e"};
  EXPECT_EQ(nearest_name("fanuc/lr_mat", robots), "fanuc/lr_mate_200id");
  EXPECT_EQ(nearest_name("fanuc/lr_mate_200di", robots), "fanuc/lr_mate_200id");
  EXPECT_EQ(nearest_name("ur5e", robots), "universal_robots/ur5e") << "the maker is left out";
  const std::vector<std::string> arms = {"ufactory/xarm5", "ufactory/xarm_6"};
  EXPECT_EQ(nearest_name("ufactory/xarm6", arms), "ufactory/xarm_6") << "nearer than another digit";
  EXPECT_EQ(nearest_name("xArm-6", arms), "ufactory/xarm_6");
  EXPECT_EQ(nearest_name("universal_robots/ru5", robots), "universal_robots/ur5");
  const std::vector<std::string> options{"--fast", "--seconds", "--fault"};
  EXPECT_EQ(nearest_name("--fst", options), "--fast");
  EXPECT_EQ(nearest_name("--sec", options), "--seconds");
  const std::vector<std::string> words{"time", "var", "user"};
  EXPECT_EQ(nearest_name("tme", words), "time");
  EXPECT_EQ(nearest_name("tiem", words), "time") << "swapped neighbours count as one";
}

TEST(Yaml, SaysTheKeyWhatIsThereAndWhatWasExpected) {
  const Yaml yaml = Yaml::parse("hardware: [1, 2]\nmass: heavy\nfast: {a: 1}\non: perhaps\n", "cell.yaml");
  const auto said = [](const auto& read) -> std::string {
    try {
      read();
      return "nothing";
    } catch (const Error& e) {
      return e.what();
    }
  };
  EXPECT_NE(said([&] {
              yaml["hardware"].text();
            }).find("cell.yaml:1:11: error: 'hardware' is a list of 2 values, a single value was expected"),
            std::string::npos);
  EXPECT_NE(
      said([&] { yaml["mass"].number(Dimension::mass); }).find("'mass' is 'heavy', a mass was expected"),
      std::string::npos);
  EXPECT_NE(said([&] { yaml["mass"].number(Dimension::mass); }).find("80g"), std::string::npos);
  EXPECT_NE(said([&] { yaml["fast"].text(); }).find("'fast' is a map of keys"), std::string::npos);
  EXPECT_NE(said([&] { yaml["on"].boolean(); }).find("'on' is 'perhaps', true or false was expected"),
            std::string::npos);
}

TEST(Text, NumbersGoThereAndBackExactly) {
  std::mt19937_64 random(7);
  for (int i = 0; i < 10000; ++i) {
    const double value = std::ldexp(static_cast<double>(random()), static_cast<int>(random() % 200) - 100);
    EXPECT_EQ(parse_number(format_number(value)), value);
  }
}

TEST(Text, NumbersHaveAnExponentOnlyWhereDigitsWouldBeMany) {
  for (const auto& [value, text] :
       std::initializer_list<std::pair<double, const char*>>{{100000, "100000"},
                                                             {-300000, "-300000"},
                                                             {1e9, "1000000000"},
                                                             {123456789012345, "123456789012345"},
                                                             {0.0001, "0.0001"},
                                                             {0.00015, "0.00015"},
                                                             {1e15, "1e+15"},
                                                             {1e-5, "1e-05"},
                                                             {0, "0"}})
    EXPECT_EQ(format_number(value), text);
}

TEST(File, IsReplacedWholeAndLeavesNothingBeside) {
  const auto folder =
      std::filesystem::temp_directory_path() / ("polyarm_file_test" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  write_file_atomically(folder / "a", "one");
  write_file_atomically(folder / "a", "two");
  EXPECT_EQ(read_file(folder / "a"), "two");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 1);
  EXPECT_THROW(write_file_atomically(folder / "missing" / "a", "x"), Error);
  EXPECT_THROW(read_file(folder / "b"), Error);
  std::filesystem::remove_all(folder);
}

TEST(Yaml, PairsKeepTheirOrderAndPlacesAlsoOfKeysThatStandTwice) {
  const Yaml yaml = Yaml::parse("b: 1\na:\nb: 2\n", "x.yaml");
  const std::vector<Yaml::Entry> entries = yaml.entries();
  ASSERT_EQ(entries.size(), 3u);
  EXPECT_EQ(entries[0].key + entries[1].key + entries[2].key, "bab");
  EXPECT_EQ(entries[2].where.text(), "x.yaml:3:1");
  EXPECT_EQ(entries[2].value.text(), "2");
  EXPECT_FALSE(entries[1].value.defined());
  EXPECT_TRUE(entries[0].value.entries().empty());
}

TEST(YamlFile, WithAKeyThatIsDefinedTwiceIsRefused) {
  const test::Folder folder;
  const std::string path =
      folder.write("arm.yaml", "joints:\n  a: {zero: 1}\n  b: {zero: 2, zero: 3}\n  a: {}\n");
  try {
    Yaml::load(path);
    FAIL() << "was accepted";
  } catch (const Error& e) {
    ASSERT_EQ(e.problems().size(), 2u);
    EXPECT_EQ(e.problems()[0].where.line, 3);
    EXPECT_EQ(e.problems()[1].text(), path + ":4:3: error: 'a' is defined twice, here and in line 2 " +
                                          "(rename one of them, or take it away)");
  }
}

TEST(YamlFile, NamesThePlaceOfWhatIsWrong) {
  const Yaml yaml = Yaml::parse("rate: 1000\nrobots:\n  arm: {model: ur3, at: [0, x, 0]}\n", "cell.yaml");
  try {
    yaml["robots"]["arm"]["at"].vec3();
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.problems().front().where.line, 3);
    EXPECT_NE(std::string(e.what()).find("is 'x', a length was expected"), std::string::npos);
  }
  Problems problems;
  yaml.check_keys({"rate", "robot"}, problems);
  ASSERT_EQ(problems.list().size(), 1u);
  EXPECT_NE(problems.list()[0].what.find("did you mean 'robot'"), std::string::npos);
}

TEST(YamlFile, SurvivesGarbage) {
  std::mt19937 random(3);
  const std::string valid = "a: {b: [1, 2mm, {c: d}], e: 'f'}\nlist:\n  - 1\n  - x: y\n";
  for (int i = 0; i < 3000; ++i) {
    std::string text = valid;
    for (int k = 0; k < 4; ++k) text[random() % text.size()] = static_cast<char>(random() % 256);
    try {
      const Yaml yaml = Yaml::parse(text, "x");
      for (const std::string& key : yaml.keys()) (void)yaml[key].pose();
    } catch (const Error&) {
    }
  }
  EXPECT_THROW(Yaml::parse(std::string(100000, '['), "x"), Error);
}

}  // namespace
}  // namespace polyarm
