#include "polyarm/data/formats.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <random>

namespace polyarm::data {
namespace {

DataSet everything() {
  DataSet set;
  Point pose{pose_xyz_rpy({0.1, -0.2, 0.3}, {0.1, 0.2, 0.3}), false};
  Point quaternion = pose;
  quaternion.quaternion_given = true;
  quaternion.taught = std::make_shared<Taught>(Taught{"table", "cup", "maker/model", {{"a", "b"}, {1, 2}}});
  set.set("flag", true);
  set.set("count", 3);
  set.set("width", Number{0.04, Dimension::length});
  set.set("text", "true, \"quoted\" # and\nmore é");
  set.set("list", List{1, "x", List{false}});
  set.set("record", Record{{"kind", "at"}, {"red", Point{{{1, 2, 3}, {}}, true}}});
  set.set("joints", JointState{{"a", "b"}, {0.5, -0.25}});
  set.set("pose", pose);
  set.set("quaternion", quaternion);
  set.set_group("count", "left, \"front\"");
  set.set_group("pose", "right");
  set.set_group("joints", "right");
  return set;
}

std::string both_ways(const DataSet& set, SetForm form) {
  Problems problems;
  const std::string text = write_form(set, form, "arm", problems);
  const DataSet again = read_form(text, form, "t", problems);
  EXPECT_FALSE(problems.has_errors())
      << text << (problems.list().empty() ? "" : problems.list().front().text());
  EXPECT_EQ(again.names(), set.names());
  for (const Entry& entry : set.entries()) {
    const Value* value = again.value(entry.name);
    if (!value) continue;
    EXPECT_EQ(again.find(entry.name)->group, entry.group) << entry.name << ": " << text;
    if (!entry.value.as_point()) {
      EXPECT_EQ(*value, entry.value) << entry.name << ": " << value->text();
      continue;
    }
    const Point &was = *entry.value.as_point(), *is = value->as_point();
    EXPECT_TRUE(is) << entry.name;
    if (!is) continue;
    EXPECT_LT(norm(was.pose.position - is->pose.position), 1e-12);
    EXPECT_LT(angle_between(was.pose.rotation, is->pose.rotation), 1e-7);
    EXPECT_EQ(was.frame(), is->frame());
    EXPECT_EQ(was.taught != nullptr, is->taught != nullptr);
  }
  return text;
}

TEST(Formats, GoThereAndBackWithEveryKindOfValue) {
  DataSet set = everything();
  for (const SetForm form : {SetForm::text, SetForm::csv, SetForm::json}) both_ways(set, form);
  DataSet plain;  // a YAML text that reads as something else is that
  for (const Entry& entry : set.entries())
    if (entry.name != "record") {
      plain.set(entry.name, entry.value);
      plain.set_group(entry.name, entry.group);
    }
  both_ways(plain, SetForm::yaml);
}

TEST(Formats, SrdfHoldsGroupStates) {
  Problems problems;
  const std::string text = write_form(everything(), SetForm::srdf, "arm", problems);
  EXPECT_EQ(problems.list().size(), 8u) << "what it cannot hold is told";
  const DataSet again = read_form(text, SetForm::srdf, "t", problems);
  EXPECT_EQ(again.names(), std::vector<std::string>{"joints"});
  EXPECT_EQ(*again.value("joints"), *everything().value("joints"));
}

TEST(Formats, ReadWhatPeopleWrite) {
  Problems problems;
  const DataSet csv =
      read_form("Name,X,Y,Z,RX,RY,RZ\nPick,300mm,0,50mm,180deg,0,0\n", SetForm::csv, "t", problems);
  ASSERT_TRUE(csv.value("Pick"));
  EXPECT_NEAR(csv.value("Pick")->as_point()->pose.position.x, 0.3, 1e-12);
  const DataSet json = read_form(
      R"({"a": 1.5e-3, "b": [true], "p": {"x": 1, "y": 2, "z": 3, "rx": 0, "ry": 0, "rz": 0}, "t": "\u00e9"})",
      SetForm::json, "t", problems);
  EXPECT_EQ(*json.value("t"), Value("é"));
  EXPECT_TRUE(json.value("p")->as_point());
  const DataSet yaml =
      read_form("Speed: 0.5m/s\nHome:\n  joints: {a: 1, b: 2}\n", SetForm::yaml, "t", problems);
  EXPECT_EQ(*yaml.value("Speed"), Value(Number{0.5, Dimension::speed}));
  EXPECT_TRUE(yaml.value("Home")->as_joints());
  EXPECT_FALSE(problems.has_errors());
}

TEST(Formats, SayWhatIsWrongAndKeepWhatIsRight) {
  Problems problems;
  const DataSet set =
      read_form("name,type,value,x\ngood,number,1,\nbad,pose,,1\n,,,\n", SetForm::csv, "t.csv", problems);
  EXPECT_EQ(set.names(), std::vector<std::string>{"good"});
  ASSERT_TRUE(problems.has_errors());
  EXPECT_EQ(problems.list().front().where.line, 3);
  for (const auto& [form, text] : {std::pair{SetForm::json, "{\"a\": "},
                                   {SetForm::json, "[1]"},
                                   {SetForm::yaml, "- 1"},
                                   {SetForm::srdf, "<a"},
                                   {SetForm::csv, "x,y\n1,2"},
                                   {SetForm::json, "{\"polyarm\": \"data/9\"}"},
                                   {SetForm::json, "\x80\x04\x95 pickle"},
                                   {SetForm::json, "{\"p\": {\"pose\": [1, 2]}}"}}) {
    Problems found;
    read_form(text, form, "t", found);
    EXPECT_TRUE(found.has_errors()) << text;
  }
}

TEST(Formats, SurviveDamagedFiles) {
  std::mt19937 random(4);
  for (const SetForm form : {SetForm::csv, SetForm::json, SetForm::yaml, SetForm::srdf}) {
    Problems ignored;
    const std::string whole = write_form(everything(), form, "arm", ignored);
    for (int k = 0; k < 400; ++k) {
      std::string text = whole;
      for (int changes = 0; changes < 4; ++changes)
        text[random() % text.size()] = static_cast<char>(random());
      if (k % 3 == 0) text.resize(random() % text.size());
      Problems problems;
      EXPECT_NO_THROW(read_form(text, form, "t", problems));
    }
  }
}

}  // namespace
}  // namespace polyarm::data
