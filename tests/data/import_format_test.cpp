#include "polyarm/data/import_format.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>

#include "polyarm/base/file.hpp"

namespace polyarm::data {
namespace {

ImportFile parsed(const std::string& text) {
  Problems problems;
  ImportFile file = ImportFile::parse(text, "t", problems);
  problems.throw_if_errors();
  return file;
}

std::vector<Problem> problems_of(const std::string& text) {
  Problems problems;
  ImportFile::parse(text, "t", problems);
  return problems.list();
}

TEST(ImportFormat, ReadsTheThesissExample) {
  const ImportFile file = ImportFile::load(POLYARM_SOURCE_DIR "/tests/data/import_listing_1.txt");
  const DataSet& set = file.values();
  EXPECT_EQ(set.names(), (std::vector<std::string>{"ScriptFile", "Repetitions", "GripperActive",
                                                   "GripperInactive", "Home", "DropPoint", "PickPoint"}));
  EXPECT_EQ(*set.value("ScriptFile"), Value("cycle"));
  EXPECT_EQ(*set.value("Repetitions"), Value(10));
  EXPECT_EQ(*set.value("GripperInactive"), Value(true));
  const JointState& drop = *set.value("DropPoint")->as_joints();
  EXPECT_EQ(*drop.find("elbow_joint"), 0.5);
  EXPECT_EQ(*drop.find("shoulder_pan_joint"), 2.0);
  EXPECT_EQ(set.value("PickPoint")->as_point()->pose.position, (Vec3{5, 3, 2}));
  EXPECT_EQ(script_information(set)->script_file, "cycle");
}

TEST(ImportFormat, KeysAreReadInAnyCase) {
  const ImportFile file =
      parsed("NAME: a\nbool: TRUE\nname: b\nNUM: 1e3\nPOSE: rpy\nName: c\npoint: 1,2,3,0,0,0\n");
  EXPECT_EQ(*file.values().value("a"), Value(true));
  EXPECT_EQ(*file.values().value("b"), Value(1000));
  EXPECT_TRUE(file.values().value("c")->as_point());
}

TEST(ImportFormat, AValueWithoutANewNameOverwritesAndSoDoesARepeatedName) {
  const ImportFile file = parsed("Name: a\nNum: 1\nNum: 2\nName: b\nNum: 3\nName: a\nText: last\n");
  EXPECT_EQ(*file.values().value("a"), Value("last"));
  EXPECT_EQ(file.values().size(), 2u);
}

TEST(ImportFormat, JointsAreMeantByNameNotByPlace) {
  EXPECT_EQ(*parsed("JS: a b\nName: p\nPoint: 1, 2\n").values().value("p"),
            *parsed("JS: b a\nName: p\nPoint: 2, 1\n").values().value("p"));
}

TEST(ImportFormat, ReadsQuaternionsAndUnits) {
  const ImportFile file = parsed(
      "Pose: Quaternion\nName: q\nPoint: 1, 2, 3, 0, 0, 0, 2\nPose: RPY\nName: r\nPoint: 40mm, 0, 0, 0, 0, "
      "90deg\n");
  EXPECT_EQ(file.values().value("q")->as_point()->pose.rotation, Quaternion{});
  EXPECT_TRUE(file.values().value("q")->as_point()->quaternion_given);
  EXPECT_NEAR(file.values().value("r")->as_point()->pose.position.x, 0.04, 1e-15);
  EXPECT_NEAR(to_rpy(file.values().value("r")->as_point()->pose.rotation).z, 1.5707963267948966, 1e-12);
}

TEST(ImportFormat, FindsEveryErrorAtOnceWithPlaceAndNearestKey) {
  const auto problems = problems_of(
      "Bool: True\nNmae: a\nName: b\nBool: Ture\nNum: ten\nName: p\nPoint: 1\nJS: j k\nPoint: 1\nPoint: 1, "
      "x\nPose: XYZ\njust text\n");
  std::vector<std::string> places, codes;
  for (const Problem& problem : problems)
    places.push_back(problem.where.text()), codes.push_back(problem.code);
  EXPECT_EQ(places, (std::vector<std::string>{"t:1:1", "t:2:1", "t:4:7", "t:5:6", "t:7:8", "t:9:8", "t:10:11",
                                              "t:11:7", "t:12:1"}));
  EXPECT_NE(problems[1].what.find("did you mean 'Name'?"), std::string::npos);
  EXPECT_NE(problems[2].what.find("did you mean 'True'?"), std::string::npos);
}

TEST(ImportFormat, WarnsOfWhatLooksLikeDegreesAndOfNamesWithoutValue) {
  const auto problems =
      problems_of("Name: empty\nJS: j\nName: p\nPoint: 90\nName: q\nPoint: 90deg\nName: last\n");
  ASSERT_EQ(problems.size(), 3u);
  EXPECT_EQ(problems[0].code, "no-value");
  EXPECT_EQ(problems[1].code, "looks-like-degrees");
  EXPECT_EQ(problems[1].where.line, 4);
  EXPECT_EQ(problems[2].code, "no-value");
}

TEST(ImportFormat, RefusesPicklesAndOtherBinaryFilesWithASentence) {
  EXPECT_NE(problems_of("\x80\x04\x95stuff").at(0).what.find("pickle"), std::string::npos);
  EXPECT_EQ(problems_of(std::string("Name\0: a", 8)).at(0).code, "not-text");
  EXPECT_EQ(problems_of("\xFF\xFEN").at(0).code, "not-text");
}

constexpr const char* kFile =
    "\xEF\xBB\xBF# head\r\n\r\n  Name: a   \r\n  Num: 1   # why\r\n\r\nJS: x y\r\nName: p\r\nPoint: 1, "
    "2\r\n# tail";

TEST(ImportFormat, UnchangedValuesLeaveEveryByteAsItWas) {
  ImportFile file = parsed(kFile);
  file.set("a", 1);
  file.set("p", JointState{{"y", "x"}, {2, 1}});
  EXPECT_EQ(file.text(), kFile);
}

TEST(ImportFormat, AChangedValueChangesOnlyItsLine) {
  ImportFile file = parsed(kFile);
  file.set("a", 2.5);
  file.set("p", JointState{{"y", "x"}, {20, 10}});
  EXPECT_EQ(file.text(),
            "\xEF\xBB\xBF# head\r\n\r\n  Name: a   \r\n  Num: 2.5   # why\r\n\r\nJS: x y\r\nName: "
            "p\r\nPoint: 10, 20\r\n# tail");
}

TEST(ImportFormat, ANewNameIsAppended) {
  ImportFile file = parsed(kFile);
  file.set("new", true);
  EXPECT_EQ(file.text(), std::string(kFile) + "\r\nName: new\r\nBool: True\r\n");
}

TEST(ImportFormat, APointOfAnotherFormDoesNotDisturbThoseBehindIt) {
  ImportFile file = parsed("JS: x y\nName: p\nPoint: 1, 2\nName: q\nPoint: 3, 4\n");
  const Value pose = Point{{{0.5, 0, 0}, {}}, false};
  file.set("p", pose);
  const ImportFile again = parsed(file.text());
  EXPECT_EQ(*again.values().value("p"), pose);
  EXPECT_EQ(*again.values().value("q"), Value(JointState{{"x", "y"}, {3, 4}}));
  file.set("p", JointState{{"z"}, {7}});
  EXPECT_EQ(parsed(file.text()).values(), file.values());
}

TEST(ImportFormat, RefusesWhatItCannotKeepAndStaysAsItWas) {
  ImportFile file = parsed(kFile);
  for (const Value& value :
       {Value(std::nan("")), Value(List{1, std::nan("")}), Value(JointState{{"a", "b"}, {1}}),
        Value(Point{{{std::nan(""), 0, 0}, {}}, false})})
    EXPECT_THROW(file.set("a", value), Error);
  EXPECT_THROW(file.set(" x", true), Error);
  EXPECT_EQ(file.text(), kFile);
}

TEST(ImportFormat, ValuesOfEveryKindHaveALine) {
  ImportFile file = parsed(kFile);
  Point taught{pose_xyz_rpy({0.1, 0.2, 0.3}, {0, 0, 1}), false};
  taught.taught = std::make_shared<Taught>(Taught{"table", "cup", "maker/model", {{"a", "b c"}, {1, 2}}});
  const std::pair<const char*, Value> values[] = {
      {"list", List{1, Number{0.04, Dimension::length}, "a # \"text\"", List{}, true}},
      {"record", Record{{"kind", "odd name"}, {"red", List{taught}}}},
      {"lines", "two\nlines"},
      {"blank", " blank "},
      {"unnamed", JointState{{}, {1, 2}}},
      {"odd", JointState{{"a b"}, {1}}},
      {"point", taught}};
  for (const auto& [name, value] : values) file.set(name, value);
  const ImportFile again = parsed(file.text());
  for (const auto& [name, value] : values) EXPECT_EQ(*again.values().value(name), value) << file.text();
  const Point& point = *again.values().value("point")->as_point();
  EXPECT_EQ(point.taught->frame, "table");
  EXPECT_EQ(point.taught->joints.positions.size(), 2u);
}

TEST(ImportFormat, WhatAPointRemembersStandsBehindItsNumbersAndIsChecked) {
  const ImportFile file = parsed("Pose: RPY\nName: p\nPoint: 1, 2, 3, 0, 0, 0; frame = \"table\"  # why\n");
  EXPECT_EQ(file.values().value("p")->as_point()->frame(), "table");
  Problems problems;
  ImportFile::parse("Pose: RPY\nName: p\nPoint: 1, 2, 3, 0, 0, 0; farme = \"table\"\n", "t", problems);
  EXPECT_TRUE(problems.has_errors());
}

TEST(ImportFormat, AGroupIsALineOfItsName) {
  const std::string text =
      "Name: a\nGroup: table # left\nNum: 1\nPose: RPY\n  Name: p\n  Point: 1, 2, 3, 0, 0, 0\nGroup: far "
      "one\n";
  ImportFile file = parsed(text);
  EXPECT_EQ(file.values().find("a")->group, "table");
  EXPECT_EQ(file.values().find("p")->group, "far one");
  file.set_group("a", "table");
  EXPECT_EQ(file.text(), text) << "nothing changes where it is the same";
  file.set_group("a", "bench");
  file.set_group("p", "");
  EXPECT_EQ(file.text(),
            "Name: a\nGroup: bench # left\nNum: 1\nPose: RPY\n  Name: p\n  Point: 1, 2, 3, 0, 0, 0\n");
  file.set_group("p", "near");
  file.set("p", Value(2));
  file.set("a", Value(true));
  EXPECT_EQ(file.text(),
            "Name: a\nGroup: bench # left\nBool: True\nPose: RPY\n  Name: p\n  Group: near\n  Num: 2\n");
  EXPECT_EQ(parsed(file.text()).values(), file.values());
}

TEST(ImportFormat, OneOfSeveralGroupsOfANameCountsTheLast) {
  ImportFile file = parsed("Name: a\nGroup: x\nNum: 1\nName: b\nNum: 2\nName: a\nNum: 3\nGroup: y\n");
  EXPECT_EQ(file.values().find("a")->group, "y");
  file.set_group("a", "z");
  EXPECT_EQ(file.text(), "Name: a\nGroup: z\nNum: 1\nName: b\nNum: 2\nName: a\nNum: 3\n");
  EXPECT_EQ(parsed(file.text()).values(), file.values());
  file.set("b", Value(5));
  EXPECT_EQ(file.text(), "Name: a\nGroup: z\nNum: 1\nName: b\nNum: 5\nName: a\nNum: 3\n");
}

TEST(ImportFormat, AGroupNeedsANameAndIsOneLine) {
  EXPECT_EQ(problems_of("Group: x\n").at(0).code, "no-name");
  ImportFile file = parsed("Name: a\nNum: 1\n");
  for (const char* bad : {"a\nb", "a # b", " a"}) EXPECT_THROW(file.set_group("a", bad), Error) << bad;
  EXPECT_THROW(file.set_group("a", std::string(65, 'x')), Error);
  EXPECT_THROW(file.set_group("b", "x"), Error);
  EXPECT_EQ(file.text(), "Name: a\nNum: 1\n");
}

/// Whatever is set, the text reads back as the same values.
TEST(ImportFormat, WritingAndReadingAgainGivesTheSameValues) {
  std::mt19937 random(9);
  const auto draw = [&](int below) { return std::uniform_int_distribution(0, below - 1)(random); };
  const auto real = [&] { return std::uniform_real_distribution(-3.0, 3.0)(random); };
  const auto value = [&]() -> Value {
    switch (draw(8)) {
      case 0:
        return draw(2) == 0;
      case 1:
        return real() * 1e-9;
      case 2:
        return Number{real(), static_cast<Dimension>(draw(12))};
      case 3:
        return std::string(draw(2) ? "" : "text # with: colon");
      case 4:
        return draw(2) ? JointState{{"x", "y"}, {real(), real()}}
                       : JointState{{"y", "z", "x"}, {real(), real(), real()}};
      case 5:
        return List{real(), "a\n\"b\" # c", Record{{"x"}, {Number{real(), Dimension::angle}}}};
      case 6: {
        Point point{pose_xyz_rpy({real(), real(), real()}, {real(), real() / 2, real()}), draw(2) == 0};
        point.taught = std::make_shared<Taught>(Taught{"t # \"", "", "r/m", {{"x"}, {real()}}});
        return point;
      }
      default:
        return Point{pose_xyz_rpy({real(), real(), real()}, {real(), real() / 2, real()}), draw(2) == 0};
    }
  };
  for (int round = 0; round < 200; ++round) {
    ImportFile file = parsed(draw(2) ? "# start\nPose: Quaternion\nName: n1\nNum: 1\n" : "");
    for (int change = 0; change < 30; ++change) {
      file.set("n" + std::to_string(draw(8)), value());
      const std::string grouped = "n" + std::to_string(draw(8));
      if (file.values().find(grouped)) file.set_group(grouped, draw(3) ? "g" + std::to_string(draw(3)) : "");
      Problems problems;
      const ImportFile again = ImportFile::parse(file.text(), "t", problems);
      ASSERT_FALSE(problems.has_errors()) << file.text();
      ASSERT_EQ(again.values(), file.values()) << file.text();
    }
  }
}

TEST(ImportFormat, SurvivesFiveThousandDamagedFiles) {
  std::mt19937 random(3);
  const auto draw = [&](std::size_t below) {
    return std::uniform_int_distribution<std::size_t>(0, below - 1)(random);
  };
  const std::string whole = read_file(POLYARM_SOURCE_DIR "/tests/data/import_listing_1.txt");
  static const std::string kBytes = ":,#\n\r\t .-e0999mdegNJPBTGroup\x80\xC3\xEF";
  for (int i = 0; i < 5000; ++i) {
    std::string text = whole;
    for (std::size_t changes = 1 + draw(8); changes > 0 && !text.empty(); --changes) {
      const std::size_t at = draw(text.size());
      if (draw(2))
        text[at] = kBytes[draw(kBytes.size())];
      else
        text.erase(at, 1 + draw(30));
    }
    Problems problems;
    ImportFile file = ImportFile::parse(text, "t", problems);
    ASSERT_EQ(file.text(), text);
    file.set("Home", Value(3));
    ASSERT_EQ(*file.values().value("Home"), Value(3));
    file.set_group("Home", "g");
    Problems later;
    const ImportFile again = ImportFile::parse(file.text(), "t", later);
    ASSERT_EQ(again.values().find("Home")->group, "g") << file.text();
  }
}

TEST(ImportFormat, ANameThatComesTwiceIsAWarningWithBothLines) {
  Problems problems;
  const ImportFile file = ImportFile::parse(
      "Name: Pick\nNum: 1\nNum: 2\n\nName: Place\nNum: 3\nName: Pick\nNum: 4\n", "d.data", problems);
  ASSERT_EQ(problems.list().size(), 1u) << "a second value below the same name replaces the first";
  EXPECT_EQ(problems.list()[0].text().substr(0, 67),
            "d.data:7:1: warning: 'Pick' is defined twice, here and in line 1; t");
  EXPECT_EQ(file.values().value("Pick")->as_number()->value, 4);
}

}  // namespace
}  // namespace polyarm::data
