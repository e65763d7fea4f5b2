#include "polyarm/shapes/robot_shapes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <unordered_set>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/description/look.hpp"
#include "polyarm/description/urdf.hpp"
#include "polyarm/shapes/render.hpp"
#include "polyarm/shapes/skeleton.hpp"
#include "polyarm/shapes/style.hpp"

namespace polyarm::shapes {
namespace {

using description::Joint;
using description::JointType;
using description::RobotModel;

const description::Catalogue& catalogue() {
  static const description::Catalogue out({POLYARM_SOURCE_DIR "/robots"});
  return out;
}

Vec3 vec(const std::array<float, 3>& p) {
  return {p[0], p[1], p[2]};
}

std::vector<LinkShape> shapes_of(const RobotModel& model) {
  Problems problems;
  std::vector<LinkShape> out = robot_shapes(model, problems);
  for (const Problem& each : problems.list()) ADD_FAILURE() << each.text();
  return out;
}

/// Poses of all links at a joint state.
std::vector<Pose> poses(const RobotModel& model, const std::vector<double>& q) {
  std::vector<double> values(model.joints.size(), 0);
  for (std::size_t k = 0; k < q.size(); ++k) values[static_cast<std::size_t>(model.actuated[k])] = q[k];
  std::vector<Pose> out(model.links.size());
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const Joint& joint = model.joints[j];
    if (joint.mimic)
      values[j] = joint.mimic->multiplier * values[static_cast<std::size_t>(joint.mimic->joint)] +
                  joint.mimic->offset;
    Pose motion;
    if (joint.type == JointType::prismatic)
      motion.position = values[j] * joint.axis;
    else if (joint.moves())
      motion.rotation = from_axis_angle(joint.axis, values[j]);
    out[static_cast<std::size_t>(joint.child_link)] =
        out[static_cast<std::size_t>(joint.parent_link)] * joint.origin * motion;
  }
  return out;
}

std::vector<double> random_state(const RobotModel& model, std::mt19937& random) {
  std::vector<double> out;
  for (const int j : model.actuated) {
    const auto& limits = model.joints[static_cast<std::size_t>(j)].limits;
    out.push_back(
        std::uniform_real_distribution<>(limits.lower.value_or(-3), limits.upper.value_or(3))(random));
  }
  return out;
}

/// Points on the surface at most `step` apart, those within `far` of `near`.
std::vector<Vec3> samples(const meshes::Mesh& mesh, const Pose& pose, double step, const Vec3& near = {},
                          double far = 1e9) {
  std::vector<Vec3> out;
  for (const meshes::MeshPart& part : mesh)
    for (std::size_t t = 0; t + 2 < part.triangles.size(); t += 3) {
      const Vec3 a = pose * vec(part.positions[part.triangles[t]]),
                 b = pose * vec(part.positions[part.triangles[t + 1]]),
                 c = pose * vec(part.positions[part.triangles[t + 2]]);
      const double longest = std::max({norm(b - a), norm(c - b), norm(a - c)});
      if (norm(a - near) > far + longest) continue;
      const int n = std::clamp(static_cast<int>(longest / step), 1, 40);
      for (int i = 0; i <= n; ++i)
        for (int k = 0; k <= n - i; ++k)
          out.push_back(a + (static_cast<double>(i) / n) * (b - a) + (static_cast<double>(k) / n) * (c - a));
    }
  return out;
}

/// True if points of both surfaces are closer than about `step`.
bool touch(const std::vector<Vec3>& a, const std::vector<Vec3>& b, double step) {
  const auto cell = [&](const Vec3& p) {
    const auto index = [&](double x) { return static_cast<std::int64_t>(std::floor(x / step)) + (1 << 20); };
    return std::array{index(p.x), index(p.y), index(p.z)};
  };
  const auto key = [](std::int64_t x, std::int64_t y, std::int64_t z) { return (x << 42) ^ (y << 21) ^ z; };
  std::unordered_set<std::int64_t> cells;
  for (const Vec3& p : a) {
    const auto [x, y, z] = cell(p);
    cells.insert(key(x, y, z));
  }
  for (const Vec3& p : b) {
    const auto [x, y, z] = cell(p);
    for (int i = -1; i <= 1; ++i)
      for (int k = -1; k <= 1; ++k)
        for (int l = -1; l <= 1; ++l)
          if (cells.contains(key(x + i, y + k, z + l))) return true;
  }
  return false;
}

TEST(RobotShapes, EveryRobotOfTheCatalogueHasFiniteShapesOfItsSize) {
  std::size_t robots = 0, most = 0;
  for (const std::string& name : catalogue().names()) {
    const RobotModel model = catalogue().load(name);
    ASSERT_TRUE(has_no_look(model)) << name;
    const Skeleton skeleton = skeleton_of(model, true);
    const std::vector<LinkShape> shapes = shapes_of(model);
    EXPECT_EQ(shapes.size(), skeleton.bodies.size()) << name << ": a body has no shape";
    std::size_t triangles = 0;
    for (const LinkShape& shape : shapes)
      for (const meshes::MeshPart& part : shape.mesh) {
        ASSERT_EQ(part.positions.size(), part.normals.size()) << name;
        triangles += part.triangles.size() / 3;
        for (std::size_t i = 0; i < part.positions.size(); ++i) {
          const double n = norm(vec(part.normals[i])), far = norm(vec(part.positions[i]));
          ASSERT_TRUE(std::isfinite(n) && std::abs(n - 1) < 1e-3) << name;
          ASSERT_LT(far, 1.6 * skeleton.reach + 1.0) << name;
        }
        for (const std::uint32_t corner : part.triangles) ASSERT_LT(corner, part.positions.size()) << name;
      }
    most = std::max(most, triangles);
    EXPECT_GT(triangles, 1000u) << name;
    ++robots;
  }
  EXPECT_EQ(robots, 365u);
  EXPECT_LT(most, 30'000u);
}

TEST(RobotShapes, NeighboursTouchInEveryPose) {
  std::mt19937 random(7);
  for (const std::string& name : catalogue().names()) {
    const RobotModel model = catalogue().load(name);
    const std::vector<LinkShape> shapes = shapes_of(model);
    const Skeleton skeleton = skeleton_of(model, true);
    std::map<int, const LinkShape*> by_link;
    for (const LinkShape& each : shapes) by_link[each.link] = &each;
    std::map<int, int> owner;  // of each link: the link that carries its body's shape
    for (const RigidBody& body : skeleton.bodies)
      for (const End& end : body.out)
        if (end.joint >= 0) owner[end.joint] = body.link;
    const double step = 0.004 * std::max(0.25, skeleton.reach);
    for (int pose = 0; pose < 2; ++pose) {
      const std::vector<Pose> at = poses(model, pose == 0 ? model.start() : random_state(model, random));
      for (const RigidBody& body : skeleton.bodies) {
        if (!body.has_in || (body.in.slides && !body.has_flange))
          continue;  // fingers slide with air between them
        const int parent = owner.at(body.in.joint);
        const Pose& child_at = at[static_cast<std::size_t>(body.link)];
        const Vec3 joint = child_at * body.in.at(body.in.middle());
        const double far = 2 * (body.in.radius + body.in.to - body.in.from);
        const auto a =
            samples(by_link.at(parent)->mesh, at[static_cast<std::size_t>(parent)], step, joint, far);
        const auto b = samples(by_link.at(body.link)->mesh, child_at, step, joint, far);
        EXPECT_TRUE(touch(a, b, step))
            << name << ": a gap at " << model.joints[static_cast<std::size_t>(body.in.joint)].name
            << " in pose " << pose;
      }
    }
  }
}

TEST(RobotShapes, TheFlangeEndsWhereToolsBegin) {
  for (const char* name : {"universal_robots/ur5e", "fanuc/lr_mate_200id", "kuka/lbr_iiwa_7_r800",
                           "abb/irb_120", "the_robot_studio/so_101"}) {
    const RobotModel model = catalogue().load(name);
    const std::vector<Pose> at = poses(model, model.start());
    const Pose& tool = at[static_cast<std::size_t>(model.tool_link())];
    double highest = -1;
    const std::vector<LinkShape> shapes = shapes_of(model);
    const LinkShape& last = shapes.back();
    for (const Vec3& p : samples(last.mesh, at[static_cast<std::size_t>(last.link)], 0.005)) {
      const Vec3 in_tool = inverse(tool.rotation) * (p - tool.position);
      highest = std::max(highest, in_tool.z);
    }
    // A real flange may have a rim or a pin that reaches into the tool.
    const bool measured = model.look.contains(description::kMeasuredLook);
    EXPECT_NEAR(highest, 0, measured ? 0.01 : 0.002) << name;
  }
}

TEST(RobotShapes, ARodIsWhereItsBodyIsWhereverTheJointHasItsFrame) {
  // The frames of the sliding joint are on the first axis, 0.65 m from the spindle.
  const RobotModel model = catalogue().load("denso/hsr065a1_n32");
  const std::vector<Pose> at = poses(model, model.start());
  const Vec3 tool = at[static_cast<std::size_t>(model.tool_link())].position;
  for (const LinkShape& each : shapes_of(model)) {
    if (model.links[static_cast<std::size_t>(each.link)].name != "J3") continue;
    for (const Vec3& p : samples(each.mesh, at[static_cast<std::size_t>(each.link)], 0.01))
      EXPECT_LT(std::hypot(p.x - tool.x, p.y - tool.y), 0.06);
  }
}

TEST(RobotShapes, MakersDifferInColour) {
  const auto color = [](const char* name) {
    Problems problems;
    return style_of(catalogue().load(name), problems).body.color;
  };
  EXPECT_GT(color("fanuc/lr_mate_200id")[0], 0.9f);
  EXPECT_LT(color("fanuc/lr_mate_200id")[2], 0.2f) << "yellow";
  EXPECT_GT(color("yaskawa/gp7")[2], color("yaskawa/gp7")[0]) << "blue";
  const auto style = [](const char* name) {
    Problems problems;
    return style_of(catalogue().load(name), problems);
  };
  EXPECT_LT(style("universal_robots/ur5e").housing->color[0], style("universal_robots/ur5e").body.color[0])
      << "dark joints between light tubes";
  EXPECT_TRUE(style("universal_robots/ur3").housing);
  EXPECT_FALSE(style("universal_robots/ur30").housing) << "light, as the UR20";
  EXPECT_FALSE(style("abb/irb_120").housing) << "one paint for joints and links";
  EXPECT_GT(style("fanuc/crx_10ia").joint.color[1], style("fanuc/crx_10ia").joint.color[0]) << "green rings";
  EXPECT_NE(color("abb/irb_120"), color("abb/irb_6640_185_2_8")) << "white, and the older orange";
}

TEST(RobotShapes, ARobotFileMayChangeItsLook) {
  RobotModel model = catalogue().load("universal_robots/ur5e");
  const std::string before = shapes_hash(model);
  model.look = {{"style", "fanuc"}, {"base", "#102030"}};
  Problems problems;
  const Style style = style_of(model, problems);
  EXPECT_TRUE(problems.list().empty());
  EXPECT_EQ(style.build, Build::cast);
  EXPECT_NEAR(style.base.color[2], 0x30 / 255.0, 1e-6);
  EXPECT_NE(shapes_hash(model), before);
  EXPECT_FALSE(style.housing);
  model.look = {{"housings", "#f0f0f0"}};
  EXPECT_NEAR(style_of(model, problems).housing->color[0], 0xf0 / 255.0, 1e-6);
  EXPECT_TRUE(problems.list().empty());
  model.look = {{"style", "fanux"}, {"base", "red"}, {"hat", "#000000"}};
  style_of(model, problems);
  ASSERT_EQ(problems.list().size(), 3u);
  EXPECT_NE(problems.list()[2].what.find("fanuc"), std::string::npos) << problems.list()[2].text();
}

TEST(RobotShapes, LeavesARobotWithALookOfItsOwnAlone) {
  const std::string urdf = R"(<robot name="r"><link name="a">VISUAL</link><link name="b"/>
<joint name="j" type="revolute"><parent link="a"/><child link="b"/><origin xyz="0 0 0.3"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" velocity="1" effort="1"/></joint></robot>)";
  const auto with = [&](const std::string& visual) {
    std::string text = urdf;
    text.replace(text.find("VISUAL"), 6, visual);
    Problems found;
    return description::read_urdf(text, "r.urdf", found);
  };
  const RobotModel bare = with("");
  EXPECT_TRUE(has_no_look(bare));
  EXPECT_EQ(shapes_of(bare).size(), 2u);
  EXPECT_FALSE(has_no_look(with("<visual><geometry><box size=\"1 1 1\"/></geometry></visual>")));
}

TEST(RobotShapes, TheSameRobotGivesTheSameBytes) {
  const RobotModel model = catalogue().load("universal_robots/ur5e");
  const std::string glb = robot_glb(model);
  EXPECT_EQ(glb, robot_glb(model));
  EXPECT_TRUE(glb.starts_with("glTF"));
  EXPECT_LT(glb.size(), 400'000u);
}

TEST(Render, ShowsTheRobotAndItsShadowOnNothing) {
  const RobotModel model = catalogue().load("fanuc/lr_mate_200id");
  const std::vector<LinkShape> shapes = shapes_of(model);
  const std::vector<Pose> at = poses(model, model.start());
  std::vector<Placed> placed;
  for (const LinkShape& each : shapes)
    placed.push_back({&each.mesh, at[static_cast<std::size_t>(each.link)]});
  View view;
  view.size = 120;
  const Picture picture = draw(placed, view);
  ASSERT_EQ(picture.rgba.size(), static_cast<std::size_t>(4 * picture.width * picture.height));
  EXPECT_EQ(std::max(picture.width, picture.height), 120);
  std::size_t solid = 0, soft = 0, clear = 0, yellow = 0;
  for (std::size_t i = 0; i < picture.rgba.size(); i += 4) {
    const int alpha = picture.rgba[i + 3];
    solid += alpha == 255;
    soft += alpha > 0 && alpha < 200;
    clear += alpha == 0;
    yellow += alpha == 255 && picture.rgba[i] > 150 && picture.rgba[i + 2] < 90;
  }
  EXPECT_GT(solid, 1000u);
  EXPECT_GT(soft, 100u);
  EXPECT_GT(clear, 500u);
  EXPECT_GT(yellow, solid / 3);
  EXPECT_TRUE(png(picture).starts_with("\x89PNG"));
  EXPECT_TRUE(draw({}, view).rgba.empty());
}

}  // namespace
}  // namespace polyarm::shapes
