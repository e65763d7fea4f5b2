#include "polyarm/surroundings/at_start.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "polyarm/collision/separation.hpp"
#include "polyarm/description/shape_bounds.hpp"

namespace polyarm::surroundings {

namespace {

using collision::ConvexBody;
using description::Bounds;

constexpr double kAllowed = 0.002;

/// Something with a place, made once for all comparisons.
struct Placed {
  std::string name;
  std::vector<ConvexBody> bodies;
  Pose pose;
  Bounds around;
};

Placed placed(std::string name, const std::vector<description::Shape>& shapes, const Pose& pose) {
  Placed out{std::move(name), {}, pose, {}};
  bool first = true;
  for (const description::Shape& shape : shapes) {
    for (ConvexBody& body : collision::bodies_of(shape)) out.bodies.push_back(std::move(body));
    const Bounds box = description::bounds_of(shape, pose);
    for (double Vec3::*axis : {&Vec3::x, &Vec3::y, &Vec3::z}) {
      out.around.lower.*axis = first ? box.lower.*axis : std::min(out.around.lower.*axis, box.lower.*axis);
      out.around.upper.*axis = first ? box.upper.*axis : std::max(out.around.upper.*axis, box.upper.*axis);
    }
    first = false;
  }
  return out;
}

double depth(const Placed& a, const Placed& b) {
  double out = 0;
  const Pose T_b_a = inverse(b.pose) * a.pose;
  for (const ConvexBody& one : a.bodies)
    for (const ConvexBody& other : b.bodies)
      if (collision::separation(one, T_b_a, other).distance <= 0)
        out = std::max(out, collision::overlap(one, T_b_a, other).depth);
  return out;
}

class Search {
 public:
  explicit Search(const description::Scene& scene) : scene_(scene) {
    for (const description::Fixture& fixture : scene.fixtures) {
      const bool has_mesh = std::any_of(fixture.shapes.begin(), fixture.shapes.end(), [](const auto& shape) {
        return shape.kind == description::ShapeKind::mesh;
      });
      others_.push_back(placed("fixture " + fixture.name, fixture.shapes, fixture.pose));
      if (has_mesh) others_.back().around = {{-1e9, -1e9, -1e9}, {1e9, 1e9, 1e9}};
    }
  }

  std::vector<Problem> take() {
    for (const description::Part& part : scene_.parts)
      if (part.feeder.empty()) {
        Placed one = placed("part " + part.name, {part.shape}, part.start);
        compare(one, " where it starts");
        others_.push_back(std::move(one));
      }
    for (const description::Feeder& feeder : scene_.feeders) {
      const auto first = std::find_if(scene_.parts.begin(), scene_.parts.end(),
                                      [&](const auto& part) { return part.feeder == feeder.name; });
      if (first != scene_.parts.end())
        compare(placed("part " + first->name, {first->shape}, feeder.pose),
                " where the feeder " + feeder.name + " brings it");
    }
    return std::move(out_);
  }

 private:
  void compare(const Placed& part, const std::string& when) {
    if (scene_.floor) report(part, "floor", scene_.floor_height - part.around.lower.z, when);
    for (const Placed& other : others_)
      if (part.around.near(other.around, -kAllowed)) report(part, other.name, depth(part, other), when);
  }

  void report(const Placed& part, const std::string& other, double depth, const std::string& when) {
    if (!(depth > kAllowed)) return;
    out_.push_back({"part-in-contact",
                    {},
                    fmt::format("{} is {:.1f} mm inside {}{}: physics pushes it out", part.name, 1e3 * depth,
                                other, when),
                    "correct the place or the size of one of them in the scene file",
                    Severity::warning,
                    {{"part", part.name}, {"other", other}, {"depth_m", depth}}});
  }

  const description::Scene& scene_;
  std::vector<Placed> others_;
  std::vector<Problem> out_;
};

}  // namespace

std::vector<Problem> parts_inside(const description::Scene& scene) {
  return Search(scene).take();
}

namespace {
/// How deep shapes of a fixture that rise above the surface of a belt are inside it; 0: none.
double blocks(const description::Fixture& fixture, const description::Fixture& belt) {
  double out = 0;
  const Placed body = placed({}, belt.shapes, belt.pose);
  const Pose T_belt_fixture = inverse(belt.pose) * fixture.pose;
  for (const description::Shape& shape : fixture.shapes)
    if (description::bounds_of(shape, T_belt_fixture).upper.z > kAllowed)
      out = std::max(out, depth(placed({}, {shape}, fixture.pose), body));
  return out > kAllowed ? out : 0;
}
}  // namespace

std::vector<Problem> belts_blocked(const description::Scene& scene) {
  std::vector<Problem> out;
  const auto is_bin = [&](const std::string& name) {
    return std::any_of(scene.bins.begin(), scene.bins.end(),
                       [&](const auto& bin) { return bin.name == name; });
  };
  for (const description::Fixture& belt : scene.fixtures)
    for (const description::Fixture& fixture : scene.fixtures) {
      if (belt.belt.empty() || &fixture == &belt || !fixture.mover.empty()) continue;
      const double deep = blocks(fixture, belt);
      if (deep <= 0) continue;
      const std::string what = is_bin(fixture.name) ? "bin " : !fixture.belt.empty() ? "belt " : "fixture ";
      out.push_back(
          {"belt-blocked",
           {},
           fmt::format(
               "{}{} stands {:.1f} mm deep in belt {}, and rises above its surface: parts cannot pass", what,
               fixture.name, 1e3 * deep, belt.name),
           "correct the place or the size of one of them in the scene file",
           Severity::warning,
           {{"fixture", fixture.name}, {"belt", belt.name}, {"depth_m", deep}}});
    }
  return out;
}

}  // namespace polyarm::surroundings
