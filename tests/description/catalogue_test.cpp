#include "polyarm/catalogue/catalogue.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <set>

#include "polyarm/base/file.hpp"
#include "polyarm/description/self_collision.hpp"
#include "polyarm/description/urdf.hpp"
#include "polyarm/xacro/packages.hpp"
#include "tests/description/support.hpp"
#include "tests/support/folder.hpp"

namespace polyarm::description::catalogue_test {
namespace {

namespace fs = std::filesystem;
using test::has;

const Catalogue& catalogue() {
  static const Catalogue out({POLYARM_SOURCE_DIR "/robots"});
  return out;
}

std::vector<Pose> at_home(const RobotModel& model) {
  return test::walk(model, model.named_states.at("home"));
}

Pose pose_of(const RobotModel& model, const std::vector<Pose>& poses, const char* link) {
  return poses.at(static_cast<std::size_t>(model.find_link(link)));
}

/// The lowest point of a capsule, in the frame that `pose` leads to.
double lowest(const Shape& capsule, const Pose& pose) {
  const Pose center = pose * capsule.pose;
  const Vec3 half = center.rotation * Vec3{0, 0, capsule.length / 2};
  return center.position.z - std::abs(half.z) - capsule.radius;
}

/// How many moving joints lie between the root and the link.
int moving_joints_before(const RobotModel& model, int link) {
  int out = 0;
  for (int j = model.links[static_cast<std::size_t>(link)].parent_joint; j >= 0;) {
    const Joint& joint = model.joints[static_cast<std::size_t>(j)];
    out += joint.moves();
    j = model.links[static_cast<std::size_t>(joint.parent_link)].parent_joint;
  }
  return out;
}

// --- every robot

void expect_provenance(const RobotModel& model) {
  EXPECT_FALSE(model.provenance.source.empty());
  EXPECT_FALSE(model.provenance.licence.empty());
  EXPECT_FALSE(model.provenance.maker.empty());
  EXPECT_FALSE(model.provenance.model.empty());
}

/// Flange and tool0 have their z out of the flange, along the last axis. Small arms of up to four axes may
/// end in a joint that pitches: then it is square to it.
void expect_tool_frames(const RobotModel& model) {
  ASSERT_GE(model.find_link("flange"), 0);
  ASSERT_GE(model.find_link("tool0"), 0);
  EXPECT_EQ(model.tool_link(), model.find_link("tool0"));
  const std::vector<Pose> poses = at_home(model);
  const Pose flange = pose_of(model, poses, "flange"), tool = pose_of(model, poses, "tool0");
  const Joint& last = model.joints[static_cast<std::size_t>(model.actuated.back())];
  const Pose wrist = poses[static_cast<std::size_t>(last.child_link)];
  const Vec3 out = flange.rotation * Vec3{0, 0, 1};
  EXPECT_NEAR(dot(out, tool.rotation * Vec3{0, 0, 1}), 1, 1e-9);
  const double along = std::abs(dot(out, wrist.rotation * last.axis));
  EXPECT_NEAR(along, model.actuated.size() <= 4 && along < 0.5 ? 0 : 1, 1e-6);
  EXPECT_GE(dot(flange.position - wrist.position, out), -1e-9);
}

void expect_home_inside_limits(const RobotModel& model) {
  const std::vector<double>& home = model.named_states.at("home");
  ASSERT_EQ(home.size(), model.actuated.size());
  for (std::size_t i = 0; i < home.size(); ++i) {
    const Joint& joint = model.joints[static_cast<std::size_t>(model.actuated[i])];
    SCOPED_TRACE(joint.name);
    EXPECT_TRUE(std::isfinite(home[i]));
    EXPECT_GT(home[i], joint.limits.lower.value_or(-1e9));
    EXPECT_LT(home[i], joint.limits.upper.value_or(1e9));
  }
}

/// Speed limits are there and positive. Many sources state no effort; then a note has to say so.
void expect_dynamic_limits(const RobotModel& model) {
  const std::vector<std::string>& notes = model.provenance.notes;
  const bool effort_noted = std::any_of(notes.begin(), notes.end(),
                                        [](const std::string& n) { return n.find("effort") != n.npos; });
  for (const int j : model.actuated) {
    const Joint& joint = model.joints[static_cast<std::size_t>(j)];
    SCOPED_TRACE(joint.name);
    const JointLimits& l = joint.limits;
    for (const auto& value : {l.velocity, l.acceleration, l.jerk}) EXPECT_GT(value.value_or(0), 0);
    EXPECT_TRUE(l.effort ? *l.effort > 0 : effort_noted);
    EXPECT_EQ(l.lower.has_value() && l.upper.has_value(), joint.type != JointType::continuous);
    EXPECT_NEAR(norm(joint.axis), 1, 1e-12);
  }
}

/// The capsules beyond the first two moving links lie above the table; returns how many there are.
int expect_clear_of_the_table(const RobotModel& model) {
  const std::vector<Pose> poses = at_home(model);
  int compared = 0;
  for (std::size_t i = 0; i < model.links.size(); ++i) {
    if (moving_joints_before(model, static_cast<int>(i)) <= 2) continue;
    for (const Shape& shape : model.links[i].collisions) {
      EXPECT_EQ(shape.kind, ShapeKind::capsule);
      EXPECT_GT(lowest(shape, poses[i]), 0) << model.links[i].name;
      ++compared;
    }
  }
  return compared;
}

void expect_masses(const RobotModel& model) {
  for (const Link& link : model.links) {
    if (!link.inertial) continue;
    SCOPED_TRACE(link.name);
    const auto& i = link.inertial->inertia;
    EXPECT_GT(link.inertial->mass, 0);
    EXPECT_GT(std::min({i[0], i[3], i[5]}), 0);
  }
}

/// The first of the links that are fixed to each other.
int body_of(const RobotModel& model, int link) {
  for (const Joint& joint : model.joints)
    if (joint.child_link == link && joint.type == JointType::fixed) return body_of(model, joint.parent_link);
  return link;
}

/// The list of pairs that need no check is right where it counts: at home no other pair touches, and links
/// that are joined by a joint are on it if they touch there. Links that are fixed to each other are one body.
void expect_listed_contacts(const RobotModel& model) {
  const std::vector<double> home = model.start();
  std::set<std::array<int, 2>> listed(model.allowed_collisions.begin(), model.allowed_collisions.end());
  for (int a = 0; a < static_cast<int>(model.links.size()); ++a)
    for (int b = a + 1; b < static_cast<int>(model.links.size()); ++b) {
      const Link &one = model.links[static_cast<std::size_t>(a)],
                 &other = model.links[static_cast<std::size_t>(b)];
      if (one.collisions.empty() || other.collisions.empty() || listed.contains({a, b})) continue;
      if (body_of(model, a) == body_of(model, b)) continue;
      EXPECT_FALSE(links_touch(model, a, b, home).value_or(false))
          << one.name << " and " << other.name << " touch at home";
    }
}

/// Next to none of the links of these have a shape, so that collisions of theirs go unseen.
bool barely_shaped(const std::string& robot) {
  return robot == "elephant_robotics/mycobot_320_pi" || robot == "elephant_robotics/mycobot_pro_600";
}

/// Arms that cannot point their tool down with room around them, or whose home is that of an example.
bool tool_down_at_home(const std::string& robot) {
  return robot != "demo/r6bot" && robot != "elephant_robotics/ultraarm_p340";
}

class EveryRobot : public ::testing::TestWithParam<std::string> {};

TEST_P(EveryRobot, IsWholeStandsWellAtHomeAndReadsBackEqual) {
  const RobotModel model = catalogue().load(GetParam());
  ASSERT_FALSE(model.actuated.empty());
  ASSERT_TRUE(model.named_states.contains("home"));
  expect_provenance(model);
  expect_tool_frames(model);
  expect_home_inside_limits(model);
  expect_dynamic_limits(model);
  expect_masses(model);
  expect_listed_contacts(model);
  const int shaped = expect_clear_of_the_table(model);
  if (model.actuated.size() >= 5) {
    EXPECT_EQ(shaped < 2, barely_shaped(GetParam())) << shaped << " shapes";
  }
  if (tool_down_at_home(GetParam())) {
    const Pose tool = pose_of(model, at_home(model), "tool0");
    test::expect_near(tool.rotation * Vec3{0, 0, 1}, {0, 0, -1}, 1e-4);
  }
  Problems warnings;
  test::expect_equal(model, read_urdf(write_urdf(model), "again.urdf", warnings));
  EXPECT_TRUE(warnings.list().empty());
}

std::vector<std::string> robots_on_disk() {
  std::vector<std::string> out;
  for (const auto& maker : fs::directory_iterator(POLYARM_SOURCE_DIR "/robots"))
    if (maker.is_directory())
      for (const auto& file : fs::directory_iterator(maker.path()))
        if (file.path().extension() == ".yaml")
          out.push_back(maker.path().filename().string() + "/" + file.path().stem().string());
  std::sort(out.begin(), out.end());
  return out;
}

INSTANTIATE_TEST_SUITE_P(Catalogue, EveryRobot, ::testing::ValuesIn(robots_on_disk()), [](const auto& test) {
  std::string out = test.param;
  std::replace_if(
      out.begin(), out.end(), [](unsigned char c) { return !std::isalnum(c); }, '_');
  return out;
});

// --- the four robots that run the same cells

class OneOfFour : public ::testing::TestWithParam<const char*> {};

TEST_P(OneOfFour, HoldsItsToolAtTheSamePlaceAtHome) {
  const RobotModel model = catalogue().load(GetParam());
  const Pose tool = pose_of(model, at_home(model), "tool0");
  test::expect_near(tool.position, {0.30, 0, 0.32}, 1e-4);
}

INSTANTIATE_TEST_SUITE_P(Catalogue, OneOfFour,
                         ::testing::Values("universal_robots/ur3", "universal_robots/ur5e",
                                           "fanuc/lr_mate_200id", "abb/irb_120"),
                         [](const auto& test) {
                           const std::string name = test.param;
                           return name.substr(name.find('/') + 1);
                         });

// --- what the makers' controllers show

/// Joint values and pendant values of one posture, read off an R-1000iA (ros-industrial/fanuc_experimental
/// issue 17); the rule is the same for all of FANUC's arms whose joint 3 turns against joint 2.
TEST(ControllerAxes, FanucShowsJoint3AgainstTheHorizontal) {
  const RobotModel model = catalogue().load("fanuc/lr_mate_200id");
  const std::vector<double> q{0.2743533253669739, 0.5467115640640259,  -0.035214900970458984,
                              1.2852824926376343, -1.7649667263031006, -0.5436538457870483};
  const std::vector<double> shown = model.displayed(q);
  ASSERT_EQ(shown.size(), 6u);
  EXPECT_NEAR(shown[2] * 180 / M_PI, -33.342, 0.001);
  for (const std::size_t i : {0u, 1u, 3u, 4u, 5u}) EXPECT_EQ(shown[i], q[i]);
}

TEST(ControllerAxes, AreAbsentWhereTheyAreNotKnown) {
  EXPECT_TRUE(catalogue().load("abb/irb_120").displayed(std::vector<double>(6, 0.1)).empty());
  const std::vector<double> q{1, 2, 3, 4, 5, 6};
  EXPECT_EQ(catalogue().load("universal_robots/ur5e").displayed(q), q);
}

// --- the catalogue

TEST(Catalogue, ListsEveryFileOnDisk) {
  EXPECT_EQ(catalogue().names(), robots_on_disk());
  const std::vector<CatalogueEntry> entries = catalogue().entries();
  ASSERT_EQ(entries.size(), robots_on_disk().size());
  for (const CatalogueEntry& entry : entries) {
    EXPECT_GE(entry.axes, 3) << entry.name;
    EXPECT_LE(entry.axes, 8) << entry.name;
  }
}

TEST(Catalogue, Has365RobotsOf30MakersFromThreeAxesOn) {
  std::set<std::string> makers;
  std::map<int, int> by_axes;
  for (const CatalogueEntry& entry : catalogue().entries()) {
    makers.insert(entry.maker);
    ++by_axes[entry.axes];
  }
  EXPECT_EQ(catalogue().names().size(), 365u);
  EXPECT_EQ(makers.size(), 30u);
  for (const int axes : {3, 4, 5, 6, 7}) EXPECT_GT(by_axes[axes], 0) << axes << " axes";
}

TEST(Catalogue, TakesABareModelWhereItIsClear) {
  EXPECT_EQ(catalogue().load("UR3").provenance.model,
            catalogue().load("universal_robots/ur3").provenance.model);
}

TEST(Catalogue, FindsOneRobotWithoutReadingAny) {
  const polyarm::test::Folder mine, theirs;
  const std::string own = mine.write("acme/one.yaml", "no robot file at all");
  theirs.write("acme/one.urdf", ""), theirs.write("acme/two.urdf", "");
  theirs.write("other/two.yaml", ""), theirs.write("beside.yaml", "");
  const Catalogue both({mine.path(), theirs.path()});
  EXPECT_EQ(both.find("acme/one"), own) << "an earlier folder hides a later one";
  EXPECT_EQ(both.find("ONE"), own) << "a model alone";
  EXPECT_EQ(both.find("acme/two"), theirs.path() / "acme/two.urdf");
  for (const char* name : {"two", "acme", "acme/three", "Acme/one", "", "/", "acme/", "/one", "acme//one",
                           "acme/one.yaml", "../acme/one", "acme/..", "./beside", "acme/one/"})
    EXPECT_FALSE(both.find(name)) << name;
}

TEST(Catalogue, NamesTheNearestRobot) {
  try {
    catalogue().load("universal_robots/ur3x");
    FAIL() << "was found";
  } catch (const Error& e) {
    EXPECT_EQ(e.problems().at(0).code, "unknown-robot");
    EXPECT_TRUE(has(e.what(), "did you mean 'universal_robots/ur3"));
  }
}

TEST(Catalogue, SaysWhereToLookWhenItIsNotThere) {
  try {
    Catalogue({"/nowhere/at/all"}).load("ur3");
    FAIL() << "was found";
  } catch (const Error& e) {
    EXPECT_TRUE(has(e.what(), "POLYARM_ROBOTS"));
  }
}

using polyarm::test::Folder;

const char* const kSmall = R"(polyarm: robot/1
maker: Acme
model: "One"
source: "drawn for this test"
licence: "none"
joints:
  - {name: lift, type: prismatic, parent: base, child: tool0, axis: [0, 0, 2], lower: 0, upper: 50mm, velocity: 1}
links:
  - {name: base}
  - {name: tool0}
named_states:
  home: {lift: 0.02}
)";

std::string small_with(const std::string& from, const std::string& to) {
  std::string text = kSmall;
  text.replace(text.find(from), from.size(), to);
  return text;
}

TEST(Catalogue, FoldersNamedFirstHideLaterOnes) {
  const Folder mine;
  mine.write("universal_robots/ur3.yaml", kSmall);
  const Catalogue both({mine.path(), POLYARM_SOURCE_DIR "/robots"});
  EXPECT_EQ(both.load("universal_robots/ur3").provenance.maker, "Acme");
  EXPECT_EQ(both.names(), robots_on_disk());
}

TEST(Catalogue, LoadsRobotsByNameAndByPath) {
  const Folder mine;
  Problems warnings;
  const std::string yaml = mine.write("one.yaml", kSmall);
  const RobotModel model = load_robot(yaml, catalogue(), warnings);
  EXPECT_EQ(model.provenance.maker, "Acme");
  const std::string urdf = mine.write("one.urdf", write_urdf(model));
  test::expect_equal(load_robot(urdf, catalogue(), warnings), model);
  EXPECT_EQ(load_robot("abb/irb_120", catalogue(), warnings).actuated.size(), 6u);
  EXPECT_THROW(load_robot((mine.path() / "none.urdf").string(), catalogue(), warnings), Error);
}

TEST(Catalogue, AnswersALaunchFileWithTheVerbThatReadsIt) {
  const Folder mine;
  Problems warnings;
  const std::string launch = mine.write("arm.launch.py", "urdf = 'arm.urdf'\nctl = 'arm_controllers.yaml'\n");
  try {
    load_robot(launch, catalogue(), warnings);
    FAIL() << "was read";
  } catch (const Error& e) {
    EXPECT_TRUE(has(e.what(), "polyarm run " + launch));
  }
}

TEST(Catalogue, OfAFileThatOnlyDefinesMacrosItNamesWhatIncludesIt) {
  const Folder mine;
  const std::string macro = mine.write(
      "urdf/arm_macro.xacro",
      "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\"><xacro:macro name=\"arm\"><link name=\"a\"/>"
      "</xacro:macro></robot>");
  const std::string whole =
      mine.write("urdf/arm.urdf.xacro",
                 "<robot name=\"r\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\"><xacro:include "
                 "filename=\"arm_macro.xacro\"/><xacro:arm/></robot>");
  Problems warnings;
  EXPECT_EQ(load_robot(whole, catalogue(), warnings).links.size(), 1u);
  try {
    load_robot(macro, catalogue(), warnings);
    FAIL() << "was read";
  } catch (const Error& e) {
    EXPECT_EQ(e.problems().front().code, "only-macros");
    EXPECT_TRUE(has(e.what(), "arm")) << e.what();
    EXPECT_TRUE(has(e.what(), "arm.urdf.xacro")) << e.what();
  }
}

TEST(Catalogue, OfAPartOfADescriptionItNamesWhatIncludesIt) {
  const Folder mine;
  const std::string part = mine.write(
      "parts/camera.xacro",
      "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\"><link name=\"camera\"/><joint name=\"c\" "
      "type=\"fixed\"><parent link=\"arm\"/><child link=\"camera\"/></joint></robot>");
  mine.write(
      "robot.urdf.xacro",
      "<robot name=\"r\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\"><link name=\"arm\"/><xacro:include "
      "filename=\"parts/camera.xacro\"/></robot>");
  Problems warnings;
  try {
    load_robot(part, catalogue(), warnings);
    FAIL() << "was read";
  } catch (const Error& e) {
    EXPECT_TRUE(has(e.what(), "robot.urdf.xacro")) << e.what();
  }
}

TEST(Catalogue, FaultsOfAnSrdfBesideADescriptionAreLeftOut) {
  const Folder mine;
  const std::string urdf =
      mine.write("arm.urdf", write_urdf(read_robot_file(mine.write("one.yaml", kSmall))));
  for (const char* srdf : {"<robot><group_state name=\"s\" group=\"none\"/></robot>", "<robot>", "no XML",
                           "<robot><group name=\"g\"><joint name=\"elbw\"/></group></robot>"}) {
    mine.write("arm.srdf", srdf);
    Problems warnings;
    EXPECT_EQ(load_robot(urdf, catalogue(), warnings).actuated.size(), 1u) << srdf;
    EXPECT_FALSE(warnings.has_errors()) << srdf;
    EXPECT_TRUE(std::any_of(warnings.list().begin(), warnings.list().end(), [](const Problem& p) {
      return has(p.what, "is left out");
    })) << srdf;
  }
}

/// As colcon finds them: workspaces hold repositories, and these hold packages.
TEST(LoadRobot, FindsTheMeshesOfAPackageNearTheFile) {
  const polyarm::test::Folder folder;
  const auto file = [&](const std::string& name, const std::string& text) { return folder.write(name, text); };
  file("arms/package.xml", "<package><name>my_arms</name></package>");
  const std::string mesh = file("arms/meshes/one.stl", "solid one\nendsolid one\n");
  file("outside.stl", "solid two\nendsolid two\n");
  const auto mesh_of = [&](const std::string& uri) {
    const std::string urdf =
        file("arms/urdf/arm.urdf", "<robot name=\"a\"><link name=\"base\"><collision><geometry><mesh filename=\"" + uri +
                                       "\"/></geometry></collision></link></robot>");
    Problems warnings;
    return load_robot(urdf, catalogue(), warnings).links[0].collisions[0].mesh_path;
  };
  EXPECT_TRUE(std::filesystem::equivalent(mesh_of("package://my_arms/meshes/one.stl"), mesh));
  EXPECT_TRUE(std::filesystem::equivalent(mesh_of("../meshes/one.stl"), mesh));
  for (const char* missing : {"package://my_arms/meshes/two.stl", "package://other/meshes/one.stl", "package://my_arms",
                              "package://", "package:///meshes/one.stl"})
    EXPECT_EQ(mesh_of(missing), "") << missing;
}

TEST(Packages, AreFoundDeepBelowTheFoldersOfPackagePaths) {
  const Folder workspace;
  const auto manifest = [](const std::string& name) {
    return "<package><name>" + name + "</name></package>";
  };
  workspace.write("src/vendor/arms/arm_description/package.xml", manifest("arm_description"));
  workspace.write("src/vendor/arms/arm_description/test/inner/package.xml", manifest("inside_a_package"));
  workspace.write("src/other/COLCON_IGNORE", "");
  workspace.write("src/other/ignored/package.xml", manifest("ignored"));
  workspace.write("src/folder_of_another_name/package.xml", manifest("renamed"));
  workspace.write("src/.hidden/secret/package.xml", manifest("secret"));
  std::filesystem::create_directory_symlink(workspace.path(), workspace.path() / "src" / "circle");
  const char* before = std::getenv("ROS_PACKAGE_PATH");
  const std::string kept = before ? before : "";
  ::setenv("ROS_PACKAGE_PATH", workspace.path().c_str(), 1);
  const PackageSearch find = packages_near("/nowhere/robot.urdf");
  EXPECT_EQ(find("arm_description").filename(), "arm_description");
  EXPECT_EQ(find("renamed").filename(), "folder_of_another_name");
  for (const char* name : {"inside_a_package", "ignored", "secret", "not_there"})
    EXPECT_TRUE(find(name).empty()) << name;
  before ? ::setenv("ROS_PACKAGE_PATH", kept.c_str(), 1) : ::unsetenv("ROS_PACKAGE_PATH");
}

TEST(RobotModel, StartsAtHomeElseWhereItsHardwareSaysElseNearZeroWithinLimits) {
  Problems warnings;
  const auto joint = [](const char* name, const char* parent, const char* child, const char* limits) {
    return std::string("<joint name=\"") + name + "\" type=\"revolute\"><parent link=\"" + parent +
           "\"/><child link=\"" + child + "\"/><limit effort=\"1\" velocity=\"1\" " + limits + "/></joint>";
  };
  const std::string text =
      "<robot name=\"r\"><link name=\"a\"/><link name=\"b\"/><link name=\"c\"/><link name=\"d\"/>" +
      joint("one", "a", "b", "lower=\"0.5\" upper=\"1\"") +
      joint("two", "b", "c", "lower=\"-2\" upper=\"-1\"") +
      joint("three", "c", "d", "lower=\"-2\" upper=\"2\"") +
      "<ros2_control name=\"h\" type=\"system\"><hardware><plugin>p</plugin></hardware><joint name=\"three\">"
      "<state_interface name=\"position\"><param name=\"initial_value\">0.7</param></state_interface></joint>"
      "</ros2_control></robot>";
  RobotModel model = read_urdf(text, "r.urdf", warnings);
  EXPECT_EQ(model.start(), (std::vector<double>{0.5, -1, 0.7}));
  model.named_states["home"] = {0.6, -1.5, 0};
  EXPECT_EQ(model.start(), (std::vector<double>{0.6, -1.5, 0}));
}

TEST(RobotFile, ReadsUnitsAndNormalisesAxes) {
  const Folder mine;
  const RobotModel model = read_robot_file(mine.write("one.yaml", kSmall));
  EXPECT_EQ(model.joints.at(0).axis, (Vec3{0, 0, 1}));
  EXPECT_NEAR(model.joints[0].limits.upper.value(), 0.05, 1e-15);
  EXPECT_EQ(model.named_states.at("home"), (std::vector<double>{0.02}));
}

struct Bad {
  const char* name;
  std::string from, to;
  int line;
  std::string piece;
};

void PrintTo(const Bad& bad, std::ostream* out) {
  *out << bad.name;
}

class BadRobotFile : public ::testing::TestWithParam<Bad> {};

TEST_P(BadRobotFile, IsRefusedWithLineAndReason) {
  const Folder mine;
  const std::string path = mine.write("bad.yaml", small_with(GetParam().from, GetParam().to));
  try {
    read_robot_file(path);
    FAIL() << "was accepted";
  } catch (const Error& e) {
    const Problem& first = e.problems().at(0);
    EXPECT_EQ(first.where.file, path);
    EXPECT_EQ(first.where.line, GetParam().line) << first.text();
    EXPECT_TRUE(has(first.text(), GetParam().piece));
  }
}

INSTANTIATE_TEST_SUITE_P(
    Table, BadRobotFile,
    ::testing::Values(
        Bad{"OtherKind", "robot/1", "scene/1", 1, "scene/1"},
        Bad{"UnknownKey", "maker:", "makr:", 2, "did you mean 'maker'"},
        Bad{"UnknownJointKey", "velocity: 1", "velocty: 1", 7, "did you mean 'velocity'"},
        Bad{"UnknownType", "prismatic", "sliding", 7, "'sliding' is not a joint type"},
        Bad{"UnknownLink", "child: tool0", "child: tol0", 7, "did you mean 'tool0'"},
        Bad{"WrongUnit", "50mm", "50deg", 7, "50deg"},
        Bad{"NoNumber", "upper: 50mm", "upper: .nan", 7, "nan"},
        Bad{"UnknownHomeJoint", "{lift:", "{lfit:", 12, "did you mean 'lift'"},
        Bad{"ZeroAxis", "axis: [0, 0, 2]", "axis: [0, 0, 0]", 7, "has no direction"},
        Bad{"EndlessAxis", "axis: [0, 0, 2]", "axis: [0, 1e308, 1.7e308]", 7, "has no direction"},
        Bad{"LimitsSwapped", "lower: 0", "lower: 60mm", 7, "is not below the upper limit"},
        Bad{"NoVelocity", "velocity: 1", "velocity: 0", 7, "above zero"},
        Bad{"Far", "axis: [0, 0, 2]", "xyz: [0, 0, 1e6]", 7, "far outside of any cell"},
        Bad{"NegativeMass", "{name: tool0}", "{name: tool0, mass: -1}", 10, "above zero"},
        Bad{"ShortInertia", "{name: tool0}", "{name: tool0, mass: 1, inertia: [1, 1, 1]}", 10,
            "six numbers, here are 3"},
        Bad{"FlatCapsule", "{name: tool0}",
            "{name: tool0, capsule: {from: [0, 0, 0], to: [0, 0, 1], radius: 0}}", 10, "above zero"},
        Bad{"TurnedBox", "{name: tool0}", "{name: tool0, box: {from: [0, 0, 0.1], to: [0, 0, 0]}}", 10,
            "ends before it begins"},
        Bad{"HomeBeyondLimit", "{lift: 0.02}", "{lift: 51mm}", 12, "beyond the joint's limits"},
        Bad{"ShownJointUnknown", "named_states:",
            "controller_axes:\n  source: a\n  display: {lfit: {sign: -1}}\nnamed_states:", 13,
            "did you mean 'lift'"},
        Bad{"ShownSign", "named_states:",
            "controller_axes:\n  source: a\n  display: {lift: {sign: 2}}\nnamed_states:", 13, "1 or -1"},
        Bad{"CoupledJointUnknown", "named_states:",
            "controller_axes:\n  source: a\n  display: {lift: {coupling: {lfit: 1}}}\nnamed_states:", 13,
            "did you mean 'lift'"},
        Bad{"LimitTwice", "upper: 50mm", "upper: 50mm, upper: 60mm", 7, "'upper' is defined twice"},
        Bad{"Syntax", "links:", "links: [", 9, "not valid YAML"}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(RobotFile, ReportsEverythingThatIsWrongAtOnce) {
  const Folder mine;
  std::string text = small_with("prismatic", "sliding");
  text.replace(text.find("- {name: base}"), 14, "- {nme: base}");
  try {
    read_robot_file(mine.write("bad.yaml", text));
    FAIL() << "was accepted";
  } catch (const Error& e) {
    EXPECT_TRUE(has(e.what(), "'sliding'"));
    EXPECT_TRUE(has(e.what(), "'nme'"));
  }
}

TEST(RobotFileFuzz, DamagedTextEndsInAModelOrAnError) {
  const Folder mine;
  const std::string good = read_file(POLYARM_SOURCE_DIR "/robots/universal_robots/ur3.yaml");
  test::Mutator mutate(7);
  int refused = 0, accepted = 0;
  for (int i = 0; i < 2000; ++i) {
    const std::string text = mutate(i % 2 ? good : kSmall);
    const std::string path = mine.write("damaged.yaml", text);
    try {
      const RobotModel model = read_robot_file(path);
      ++accepted;
      EXPECT_EQ(model.joints.size() + 1, model.links.size()) << text;
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 200);
  EXPECT_GT(accepted, 20);
}

}  // namespace
}  // namespace polyarm::description::catalogue_test
