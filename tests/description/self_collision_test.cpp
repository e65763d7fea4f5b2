#include "polyarm/description/self_collision.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "polyarm/description/plain_urdf.hpp"
#include "polyarm/description/srdf.hpp"
#include "polyarm/description/urdf.hpp"

namespace polyarm::description::self_collision_test {
namespace {

/// Two links side by side on a base, of which the second hangs on three sliding joints.
RobotModel two(const Shape& first, const Shape& second) {
  RobotModel model;
  model.name = "two";
  model.links = {{"base", {}, {}, {first}, -1, {}},
                 {"x", {}, {}, {}, 0, {}},
                 {"y", {}, {}, {}, 1, {}},
                 {"z", {}, {}, {second}, 2, {}}};
  const Vec3 axes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (int i = 0; i < 3; ++i) {
    Joint joint;
    joint.name = std::string(1, static_cast<char>('x' + i));
    joint.type = JointType::prismatic;
    joint.parent_link = i;
    joint.child_link = i + 1;
    joint.axis = axes[i];
    model.joints.push_back(joint);
    model.actuated.push_back(i);
  }
  return model;
}

Shape shape(ShapeKind kind, double radius, double length = 0, Vec3 size = {}) {
  Shape out;
  out.kind = kind;
  out.radius = radius;
  out.length = length;
  out.size = size;
  return out;
}

double clamped(double value, double most) {
  return std::clamp(value, -most, most);
}

TEST(LinksTouch, ASphereTouchesWhatItsDistanceSays) {
  std::mt19937 random(3);
  const auto draw = [&] { return 2.0 * (static_cast<double>(random()) / 4294967296.0) - 1.0; };
  struct Case {
    Shape other;
    double (*distance)(const Vec3&);
  };
  const Case cases[] = {{shape(ShapeKind::sphere, 0.3), [](const Vec3& p) { return norm(p) - 0.3; }},
                        {shape(ShapeKind::capsule, 0.1, 0.6),
                         [](const Vec3& p) {
                           return norm(p - Vec3{0, 0, clamped(p.z, 0.3)}) - 0.1;
                         }},
                        {shape(ShapeKind::box, 0, 0, {0.4, 0.6, 0.2}), [](const Vec3& p) {
                           return norm(p - Vec3{clamped(p.x, 0.2), clamped(p.y, 0.3), clamped(p.z, 0.1)});
                         }}};
  for (const Case& each : cases) {
    const RobotModel model = two(each.other, shape(ShapeKind::sphere, 0.2));
    int touching = 0;
    for (int i = 0; i < 3000; ++i) {
      const std::vector<double> q{draw(), draw(), draw()};
      const double gap = each.distance({q[0], q[1], q[2]}) - 0.2;
      if (std::abs(gap) < 1e-6) continue;
      const auto found = links_touch(model, 0, 3, q);
      ASSERT_TRUE(found.has_value());
      ASSERT_EQ(*found, gap < 0) << name(PairReason::never) << " " << gap;
      touching += *found ? 1 : 0;
    }
    EXPECT_GT(touching, 20);
  }
}

TEST(LinksTouch, ACylinderIsNeverTakenForLessThanItIs) {
  const RobotModel model = two(shape(ShapeKind::cylinder, 0.3, 0.4), shape(ShapeKind::sphere, 0.1));
  for (int i = 0; i < 360; ++i) {
    const double angle = i * 0.0174532925;
    EXPECT_TRUE(*links_touch(model, 0, 3,
                             std::vector<double>{0.399 * std::cos(angle), 0.399 * std::sin(angle), 0.1}));
    EXPECT_FALSE(
        *links_touch(model, 0, 3, std::vector<double>{0.41 * std::cos(angle), 0.41 * std::sin(angle), 0}));
  }
  EXPECT_FALSE(*links_touch(model, 0, 3, std::vector<double>{0, 0, 0.301}));
}

TEST(LinksTouch, AMeshIsItsConvexPieces) {
  Shape mesh = shape(ShapeKind::mesh, 0);
  const auto cube = [](double x) {
    std::vector<Vec3> out;
    for (int i = 0; i < 8; ++i) out.push_back({x + (i & 1 ? 0.1 : -0.1), i & 2 ? 0.1 : -0.1, i & 4 ? 0.1 : -0.1});
    return out;
  };
  mesh.pieces = {cube(-0.5), cube(0.5)};
  const RobotModel model = two(mesh, shape(ShapeKind::sphere, 0.1));
  EXPECT_TRUE(*links_touch(model, 0, 3, std::vector<double>{0.69, 0, 0}));
  EXPECT_TRUE(*links_touch(model, 0, 3, std::vector<double>{-0.5, 0.19, 0}));
  EXPECT_FALSE(*links_touch(model, 0, 3, std::vector<double>{0.71, 0, 0}));
  EXPECT_FALSE(*links_touch(model, 0, 3, std::vector<double>{0, 0, 0})) << "between the pieces";
}

TEST(LinksTouch, OfAMeshThatIsNotThereNothingIsSaid) {
  const RobotModel model = two(shape(ShapeKind::mesh, 0), shape(ShapeKind::sphere, 0.1));
  EXPECT_EQ(links_touch(model, 0, 3, std::vector<double>{9, 9, 9}), std::nullopt);
}

/// Three balls on one rail: neighbours, one far away, one that never leaves.
TEST(NeedlessPairs, HaveTheReasonThatSamplingFinds) {
  Problems problems;
  RobotModel model = read_urdf(R"(<robot name="r">
    <link name="a"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
    <link name="b"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
    <link name="near"><collision><geometry><sphere radius="0.3"/></geometry></collision></link>
    <link name="far"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
    <link name="swinging"><collision><origin xyz="0.4 0 0"/><geometry><sphere radius="0.1"/></geometry></collision></link>
    <joint name="ab" type="fixed"><parent link="a"/><child link="b"/><origin xyz="0.15 0 0"/></joint>
    <joint name="bn" type="fixed"><parent link="b"/><child link="near"/><origin xyz="0.1 0 0"/></joint>
    <joint name="bf" type="fixed"><parent link="b"/><child link="far"/><origin xyz="0 0 3"/></joint>
    <joint name="fs" type="revolute"><parent link="b"/><child link="swinging"/><origin xyz="0 0.25 0"/><axis xyz="0 0 1"/>
      <limit lower="-3.1" upper="3.1" velocity="1" effort="1"/></joint>
    </robot>)",
                               "r.urdf", problems);
  const auto pairs = needless_pairs(model, 2000);
  const auto reason = [&](const char* first, const char* second) -> std::string {
    for (const LinkPair& pair : pairs)
      if ((pair.first == model.find_link(first) && pair.second == model.find_link(second)) ||
          (pair.first == model.find_link(second) && pair.second == model.find_link(first)))
        return std::string(name(pair.reason));
    return "compared";
  };
  EXPECT_EQ(reason("a", "b"), "Adjacent");
  EXPECT_EQ(reason("a", "near"), "Default");
  EXPECT_EQ(reason("a", "far"), "Never");
  EXPECT_EQ(reason("a", "swinging"), "compared") << "it comes by";
  const std::string srdf = write_srdf(model, pairs);
  RobotModel read = model;
  read_srdf(srdf, "r.srdf", read, problems);
  EXPECT_EQ(read.allowed_collisions.size(), pairs.size());
  EXPECT_FALSE(problems.has_errors());
}

TEST(PlainUrdf, HasNothingThatOthersDoNotRead) {
  Problems problems;
  RobotModel model = two(shape(ShapeKind::capsule, 0.1, 0.4), shape(ShapeKind::capsule, 0.05, 0.2));
  model.named_states["home"] = {0, 0, 0};
  const std::string text = write_plain_urdf(model);
  EXPECT_EQ(text.find("capsule"), std::string::npos);
  EXPECT_EQ(text.find("home"), std::string::npos);
  const RobotModel read = read_urdf(text, "two.urdf", problems);
  ASSERT_EQ(read.links[0].collisions.size(), 3u);
  EXPECT_EQ(read.links[0].collisions[0].kind, ShapeKind::cylinder);
  EXPECT_EQ(read.links[0].collisions[2].pose.position.z, 0.2);
  for (const std::vector<double>& q : {std::vector<double>{0, 0, 0.44}, {0.14, 0, 0.2}, {0, 0, 0.5}})
    EXPECT_EQ(links_touch(read, 0, 3, q), links_touch(model, 0, 3, q)) << q[2];
}

}  // namespace
}  // namespace polyarm::description::self_collision_test
