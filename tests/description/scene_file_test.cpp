#include "polyarm/description/scene_file.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "polyarm/base/file.hpp"
#include "tests/description/support.hpp"

namespace polyarm::description::scene_file_test {
namespace {

using test::has;

Scene read(const std::string& body) {
  return read_scene(Yaml::parse("polyarm: scene/1\n" + body, "scene.yaml"));
}

template <typename Named>
const Named& named(const std::vector<Named>& list, const std::string& name) {
  const auto found = std::find_if(list.begin(), list.end(), [&](const Named& n) { return n.name == name; });
  if (found == list.end()) throw Error("test", "nothing is called " + name);
  return *found;
}

/// "line code" of everything that is wrong, in the order reported.
std::vector<std::string> findings(const std::string& body) {
  std::vector<std::string> out;
  try {
    read(body);
  } catch (const Error& e) {
    for (const Problem& p : e.problems()) {
      EXPECT_EQ(p.where.file, "scene.yaml");
      out.push_back(std::to_string(p.where.line) + " " + p.code);
    }
  }
  return out;
}

std::string complaint(const std::string& body) {
  try {
    read(body);
  } catch (const Error& e) {
    return e.what();
  }
  return "accepted";
}

TEST(SceneFile, IsAnEmptyWorldWithAFloorWhereNothingIsSaid) {
  const Scene scene = read("");
  EXPECT_TRUE(scene.floor);
  EXPECT_EQ(scene.floor_height, 0);
  EXPECT_TRUE(scene.parts.empty());
  EXPECT_EQ(scene.gravity, (Vec3{0, 0, -9.81}));
}

TEST(SceneFile, UnderstandsUnits) {
  const Scene scene = read(
      "floor: {height: -75cm}\n"
      "fixtures: {post: {cylinder: {radius: 20mm, height: 0.5m}, at: [10cm, 0, 250mm], rpy: [0, 0, 90deg]}}\n"
      "movers: {door: {axis: [0, 0, 3], upper: 100mm, speed: 50mm/s}}\n"
      "parts: {cube: {box: [40mm, 4cm, 0.04], mass: 80g, at: [0.3, 0, 20mm]}}\n");
  EXPECT_NEAR(scene.floor_height, -0.75, 1e-12);
  const Fixture& post = named(scene.fixtures, "post");
  EXPECT_NEAR(post.shapes.at(0).radius, 0.02, 1e-12);
  EXPECT_NEAR(post.shapes[0].length, 0.5, 1e-12);
  test::expect_near(post.pose.position, {0.1, 0, 0.25});
  test::expect_near(post.pose.rotation * Vec3{1, 0, 0}, {0, 1, 0});
  const Mover& door = named(scene.movers, "door");
  EXPECT_EQ(door.axis, (Vec3{0, 0, 1}));
  EXPECT_NEAR(door.upper, 0.1, 1e-12);
  EXPECT_NEAR(door.speed, 0.05, 1e-12);
  const Part& cube = named(scene.parts, "cube");
  test::expect_near(cube.shape.size, {0.04, 0.04, 0.04});
  EXPECT_NEAR(cube.mass, 0.08, 1e-12);
  EXPECT_NEAR(cube.start.position.z, 0.02, 1e-12);
}

TEST(SceneFile, WeighsAPartThatStatesNoMassByItsVolume) {
  const Scene scene =
      read("parts: {a: {box: [0.1, 0.1, 0.1], at: [0, 0, 0]}, b: {box: [0.1, 0.1, 0.2], at: [1, 0, 0]}}\n");
  EXPECT_GT(scene.parts.at(0).mass, 0);
  EXPECT_NEAR(scene.parts.at(1).mass, 2 * scene.parts[0].mass, 1e-12);
}

TEST(SceneFile, BuildsFourWallsAroundABin) {
  const Scene scene = read("bins: {tray: {at: [0.3, 0.1, 0.02], inner: [0.2, 0.1, 0.05], wall: 4mm}}\n");
  const Bin& bin = named(scene.bins, "tray");
  EXPECT_NEAR(bin.lower.x, 0.2, 1e-12);
  EXPECT_NEAR(bin.upper.x, 0.4, 1e-12);
  EXPECT_NEAR(bin.lower.y, 0.05, 1e-12);
  EXPECT_NEAR(bin.upper.y, 0.15, 1e-12);
  EXPECT_LE(bin.lower.z, 0.02);
  EXPECT_GE(bin.upper.z, 0.07);
  const Fixture& walls = named(scene.fixtures, "tray");
  ASSERT_EQ(walls.shapes.size(), 4u);
  test::expect_near(walls.pose.position, {0.3, 0.1, 0.02});
  double volume = 0;
  for (const Shape& wall : walls.shapes) {
    EXPECT_NEAR(wall.pose.position.z - wall.size.z / 2, 0, 1e-12);
    EXPECT_NEAR(wall.size.z, 0.05, 1e-12);
    // Every wall lies outside the inner area and touches it.
    EXPECT_NEAR(std::max(std::abs(wall.pose.position.x) - wall.size.x / 2 - 0.1,
                         std::abs(wall.pose.position.y) - wall.size.y / 2 - 0.05),
                0, 1e-12);
    volume += wall.size.x * wall.size.y * wall.size.z;
  }
  // The ring closes without overlap at its corners.
  EXPECT_NEAR(volume, (0.208 * 0.108 - 0.2 * 0.1) * 0.05, 1e-12);
}

TEST(SceneFile, BuildsNoWallsWhereABinWantsNone) {
  const Scene scene = read("bins: {tray: {at: [0, 0, 0], inner: [0.2, 0.1, 0.05], walls: false}}\n");
  EXPECT_EQ(scene.bins.size(), 1u);
  EXPECT_TRUE(scene.fixtures.empty());
}

TEST(SceneFile, TakesRegionsByCornersOrByCentreAndSize) {
  const Scene scene = read(
      "sensors:\n"
      "  one: {lower: [0, 0, 0], upper: [0.1, 0.2, 0.3]}\n"
      "  two: {at: [0.05, 0.1, 0.15], size: [0.1, 0.2, 0.3]}\n"
      "cameras: {eye: {at: [1, 2, 3], size: [1, 1, 1]}}\n");
  test::expect_near(scene.sensors.at(0).lower, scene.sensors.at(1).lower);
  test::expect_near(scene.sensors[0].upper, scene.sensors[1].upper);
  test::expect_near(scene.cameras.at(0).eye, {1, 2, 3.8});
}

TEST(SceneFile, CountsPartsOfOneKindForAFeeder) {
  const Scene scene = read(
      "feeders: {chute: {at: [0.3, 0.1, 0.02]}}\n"
      "parts:\n"
      "  cube: {count: 3, kind: red, box: [0.04, 0.04, 0.04], feeder: chute}\n"
      "  ball: {sphere: {radius: 0.02}, feeder: chute}\n");
  std::vector<std::string> names;
  for (const Part& part : scene.parts) names.push_back(part.name);
  EXPECT_EQ(names, (std::vector<std::string>{"cube_1", "cube_2", "cube_3", "ball"}));
  EXPECT_EQ(scene.kinds, (std::vector<std::string>{"red", "ball"}));
  for (const Part& part : scene.parts) EXPECT_EQ(part.feeder, "chute");
}

TEST(SceneFile, RefusesCountsThatMakeNoSense) {
  for (const char* count : {"0", "-2", "1.5", "1001", "many", ".nan"})
    EXPECT_NE(complaint("feeders: {f: {at: [0, 0, 0]}}\nparts: {a: {count: " + std::string(count) +
                        ", box: [1, 1, 1], feeder: f}}\n"),
              "accepted")
        << count;
  EXPECT_TRUE(has(complaint("parts: {a: {count: 2, box: [1, 1, 1], at: [0, 0, 0]}}\n"), "at the same place"));
}

TEST(SceneFile, ChecksNamesAgainstEachOtherAndNamesTheNearest) {
  const std::string rest =
      "bins: {tray: {at: [0, 0, 0], inner: [1, 1, 1]}}\n"
      "feeders: {chute: {at: [0, 0, 0]}}\n"
      "movers: {door: {axis: [0, 0, 1]}}\n";
  EXPECT_TRUE(has(complaint(rest + "parts: {a: {box: [1, 1, 1], feeder: chut}}\n"), "did you mean 'chute'"));
  EXPECT_TRUE(
      has(complaint(rest + "parts: {a: {box: [1, 1, 1], feeder: chute, goal: {at: [0, 0, 0], bin: tary}}}\n"),
          "did you mean 'tray'"));
  EXPECT_TRUE(
      has(complaint(rest + "fixtures: {leaf: {box: [1, 1, 1], mover: dor}}\n"), "did you mean 'door'"));
  EXPECT_TRUE(has(complaint("fixtures: {leaf: {box: [1, 1, 1], mover: dor}}\n"), "the scene has no movers"));
  EXPECT_EQ(complaint(rest + "parts: {a: {box: [1, 1, 1], feeder: chute, goal: {at: [0, 0, 0], bin: tray}}}\n"
                             "fixtures: {leaf: {box: [1, 1, 1], mover: door}}\n"),
            "accepted");
}

TEST(SceneFile, FindsNamesThatStandFurtherDown) {
  EXPECT_EQ(complaint("parts: {a: {box: [1, 1, 1], feeder: chute, goal: {at: [0, 0, 0], bin: tray}}}\n"
                      "fixtures: {leaf: {box: [1, 1, 1], mover: door}}\n"
                      "movers: {door: {axis: [0, 0, 1]}}\n"
                      "feeders: {chute: {at: [0, 0, 0]}}\n"
                      "bins: {tray: {at: [0, 0, 0], inner: [1, 1, 1]}}\n"),
            "accepted");
}

TEST(SceneFile, ReportsEverythingThatIsWrongAtOnceWithItsLine) {
  auto found = findings(
      "fixtrues: {}\n"                                         // 2: unknown key
      "fixtures:\n"                                            //
      "  wall: {box: [1, -1, 1]}\n"                            // 4: not above zero
      "  leaf: {box: [1, 1, 1], mover: dor}\n"                 // 5: no such mover
      "movers:\n"                                              //
      "  door: {axis: [0, 0, 0]}\n"                            // 7: no direction
      "bins:\n"                                                //
      "  tray: {at: [0, 0, 0]}\n"                              // 9: no inner
      "sensors:\n"                                             //
      "  eye: {lower: [0, 0, 0], upper: [1, 0, 1]}\n"          // 11: empty region
      "parts:\n"                                               //
      "  a: {box: [1, 1, 1], at: [0, 0, 0], mass: 3mm}\n"      // 13: a mass in millimetres
      "  b: {box: [1, 1, 1]}\n"                                // 14: neither place nor feeder
      "  c: {box: [1, 1, 1], at: [0, 0, 0], feeder: chute}\n"  // 15: no such feeder
      "  d: {box: [1, 1], at: [0, 0, 0]}\n"                    // 16: a box of two edges
      "  e: {box: [1, 1, 1], at: [0, 0, 0], colour: red}\n");  // 17: unknown key
  std::vector<int> lines;
  for (const std::string& text : found) lines.push_back(std::stoi(text));
  std::sort(lines.begin(), lines.end());
  EXPECT_EQ(lines, (std::vector<int>{2, 4, 5, 7, 9, 11, 13, 14, 15, 16, 17}));
}

TEST(SceneFile, RefusesNamesThatStandTwice) {
  const std::string doors = "movers:\n  door: {axis: [0, 0, 1]}\n  door: {axis: [1, 0, 0]}\n";
  EXPECT_EQ(findings(doors), (std::vector<std::string>{"4 duplicate-name"}));
  EXPECT_TRUE(has(complaint(doors), "'door' is defined twice, here and in line 3"));
  EXPECT_TRUE(has(complaint("feeders: {chute: {at: [0, 0, 0]}}\n"
                            "parts:\n"
                            "  cube_2: {box: [1, 1, 1], at: [0, 0, 0]}\n"
                            "  cube: {count: 3, box: [1, 1, 1], feeder: chute}\n"),
                  "two parts are called 'cube_2', here and in line "));
}

TEST(SceneFile, RefusesNumbersThatNoThingHas) {
  for (const char* body :
       {"bins: {tray: {at: [0, 0, 0], inner: [1, -1, 1]}}\n",
        "bins: {tray: {at: [0, 0, 0], inner: [1, 1, 1], wall: 0mm}}\n",
        "parts: {a: {box: [1, 1, 1], at: [0, 0, 0], friction: -0.1}}\n",
        "parts: {a: {box: [1, 1, 1], at: [0, 0, 0], goal: {at: [0, 0, 0], tolerance: 0}}}\n"})
    EXPECT_EQ(findings(body), (std::vector<std::string>{"2 bad-value"})) << body;
}

TEST(SceneFile, RefusesWhatIsLargerOrFasterThanAnyScene) {
  for (const char* body :
       {"movers: {m: {axis: [1, 0, 0], upper: 1e30}}\n", "movers: {m: {axis: [1, 0, 0], lower: -1e30}}\n",
        "movers: {m: {axis: [1, 0, 0], speed: 1e30}}\n",
        "movers: {m: {axis: [1, 0, 0], acceleration: 1e30}}\n",
        "bins: {b: {at: [1e30, 0, 0], inner: [1, 1, 1]}}\n",
        "bins: {b: {lower: [0, 0, -1e30], upper: [1, 1, 1]}}\n",
        "outfeeds: {o: {at: [0, 0, 0], size: [1, 1e30, 1]}}\n",
        "cameras: {c: {at: [0, 0, 0], size: [1, 1, 1], eye: [0, 0, 1e30]}}\n",
        "fixtures: {f: {box: [1, 1, 1e30], at: [0, 0, 0]}}\n",
        "fixtures: {f: {sphere: {radius: 1e30}, at: [0, 0, 0]}}\n",
        "parts: {p: {box: [1, 1, 1], at: [0, 0, 1e30m]}}\n",
        "parts: {p: {box: [1, 1, 1], at: [0, 0, 0], mass: 1e30}}\n",
        "parts: {p: {box: [1, 1, 1], at: [0, 0, 0], goal: {at: [0, 1e30, 0]}}}\n"})
    EXPECT_EQ(findings(body), (std::vector<std::string>{"2 bad-value"})) << body;
  EXPECT_NE(complaint("gravity: [0, 0, -1e30]\n"), "accepted");
  EXPECT_NE(complaint("floor: {height: 1e30}\n"), "accepted");
  EXPECT_TRUE(has(complaint("movers: {m: {axis: [1, 0, 0], speed: 500}}\n"), "100 m/s at most"));
  EXPECT_EQ(complaint("movers: {m: {axis: [1, 0, 0], upper: 1000, speed: 100}}\n"), "accepted");
}

TEST(SceneFile, SaysWhatFileItIsNot) {
  for (const char* text : {"", "robot: 1\n", "polyarm: robot/1\n", "[1, 2]\n", "just words\n"})
    EXPECT_THROW(read_scene(Yaml::parse(text, "scene.yaml")), Error) << text;
  EXPECT_TRUE(has(complaint("parts: [1, 2]\n"), "must be a map"));
  EXPECT_THROW(read_scene("/nowhere/scene.yaml"), Error);
}

// --- the scenes that come along

class ExampleScene : public ::testing::TestWithParam<const char*> {
 protected:
  std::string path() const {
    return std::string(POLYARM_SOURCE_DIR "/examples/") + GetParam() + "/scene.yaml";
  }
};

TEST_P(ExampleScene, GivesEveryPartAGoalInABin) {
  const Scene scene = read_scene(path());
  EXPECT_FALSE(scene.parts.empty());
  for (const Part& part : scene.parts) {
    SCOPED_TRACE(part.name);
    ASSERT_TRUE(part.goal);
    const Bin& bin = named(scene.bins, part.goal->bin);
    const Vec3& at = part.goal->at;
    EXPECT_TRUE(at.x > bin.lower.x && at.x < bin.upper.x);
    EXPECT_TRUE(at.y > bin.lower.y && at.y < bin.upper.y);
    EXPECT_TRUE(at.z > bin.lower.z && at.z < bin.upper.z);
  }
}

TEST_P(ExampleScene, DamagedEndsInASceneOrAnError) {
  const std::string good = read_file(path());
  test::Mutator mutate(99);
  int refused = 0, accepted = 0;
  for (int i = 0; i < 2000; ++i) {
    const std::string text = mutate(good);
    try {
      read_scene(Yaml::parse(text, "damaged.yaml"));
      ++accepted;
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 200);
  EXPECT_GT(accepted, 20);
}

INSTANTIATE_TEST_SUITE_P(Examples, ExampleScene,
                         ::testing::Values("pick_and_place", "sorting", "bin_picking"),
                         [](const auto& test) { return std::string(test.param); });

TEST(SceneFile, APartWithoutAMassIsSaidAndNoOther) {
  Problems warnings;
  const Scene scene = read_scene(Yaml::parse("polyarm: scene/1\nfeeders:\n  f: {at: [0, 0, 0]}\nparts:\n"
                                             "  known: {box: [40mm, 40mm, 40mm], mass: 80g, at: [0, 0, 1]}\n"
                                             "  guessed: {box: [40mm, 40mm, 40mm], feeder: f, count: 2}\n",
                                             "scene.yaml"),
                                 warnings);
  ASSERT_EQ(scene.parts.size(), 3u);
  ASSERT_EQ(warnings.list().size(), 1u);
  EXPECT_EQ(warnings.list()[0].where.line, 6);
  EXPECT_EQ(warnings.list()[0].severity, Severity::warning);
  EXPECT_NE(warnings.list()[0].what.find("'guessed' states no mass: 0.032 kg"), std::string::npos)
      << warnings.list()[0].what;
}

TEST(ExampleScenes, StateEveryMass) {
  for (const char* name : {"pick_and_place", "sorting", "bin_picking", "two_robots", "carrier"}) {
    Problems warnings;
    read_scene(std::string(POLYARM_SOURCE_DIR) + "/examples/" + name + "/scene.yaml", warnings);
    EXPECT_TRUE(warnings.list().empty()) << name << ": " << warnings.list()[0].text();
  }
}

TEST(ExampleScenes, HoldAsManyPartsAsTheyDescribe) {
  EXPECT_EQ(read_scene(POLYARM_SOURCE_DIR "/examples/pick_and_place/scene.yaml").parts.size(), 3u);
  EXPECT_EQ(read_scene(POLYARM_SOURCE_DIR "/examples/sorting/scene.yaml").kinds,
            (std::vector<std::string>{"green", "red", "blue"}));
  EXPECT_EQ(read_scene(POLYARM_SOURCE_DIR "/examples/bin_picking/scene.yaml").parts.size(), 6u);
}

}  // namespace
}  // namespace polyarm::description::scene_file_test
