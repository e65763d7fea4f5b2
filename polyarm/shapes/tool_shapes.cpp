#include "polyarm/shapes/tool_shapes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <initializer_list>
#include <iterator>

#include "polyarm/description/tools.hpp"
#include "polyarm/meshes/glb_writer.hpp"
#include "polyarm/shapes/solid.hpp"

namespace polyarm::shapes {

using description::GripperKind;
using description::Shape;
using description::ShapeKind;
using description::Tool;

namespace {

/// Change this whenever the shapes change, so that browsers load them again.
constexpr const char* kToolFormat = "tools/1";

constexpr Paint kMetal{{0.79f, 0.8f, 0.82f}, 0.3f, 0.8f}, kCharcoal{{0.165f, 0.176f, 0.192f}, 0.5f, 0},
    kJet{{0.09f, 0.094f, 0.102f}, 0.45f, 0}, kRubber{{0.12f, 0.125f, 0.14f}, 0.85f, 0},
    kSteel{{0.62f, 0.64f, 0.67f}, 0.35f, 0.9f};

Pose up_to(double z) {
  return {{0, 0, z}, {}};
}

/// The end of the body along the tool's axis, measured from the flange.
double end_of(const Tool& tool) {
  double out = 0;
  for (const Shape& shape : tool.body) {
    const double half = shape.kind == ShapeKind::box        ? shape.size.z / 2
                        : shape.kind == ShapeKind::cylinder ? shape.length / 2
                        : shape.kind == ShapeKind::capsule  ? shape.length / 2 + shape.radius
                                                            : shape.radius;
    out = std::max(out, shape.pose.position.z + half);
  }
  return out;
}

// --- vacuum

/// A cup with bellows on z of `lip`, whose origin is the middle of the lip. `tall`: from its fitting to the
/// lip.
void cup(Solid& solid, const Pose& lip, double radius, double tall) {
  const std::array<Ring, 11> rings{{{0, -tall},
                                    {0.5 * radius, -tall},
                                    {0.55 * radius, -0.82 * tall},
                                    {0.85 * radius, -0.68 * tall},
                                    {0.6 * radius, -0.54 * tall},
                                    {0.9 * radius, -0.38 * tall},
                                    {0.62 * radius, -0.24 * tall},
                                    {radius, -0.02 * tall},
                                    {radius, 0},
                                    {0.8 * radius, -0.03 * tall},
                                    {0, -0.14 * tall}}};
  solid.turn(lip, rings, kRubber);
}

/// A flange plate, a tube with its fittings, and the cup.
meshes::Mesh vacuum_cup(const Tool& tool) {
  Solid solid;
  const double length = tool.tcp.position.z, radius = tool.cup_radius,
               tall = std::min(2.4 * radius, 0.4 * length);
  const double top = length - tall, tube = std::max(0.6 * radius, 0.0065);
  solid.drum({}, 0, 0.012, 0.0315, 0.0008, 0.0015, kMetal);
  solid.drum({}, 0.012, 0.02, 0.022, 0, 0.002, kCharcoal);
  solid.drum({}, 0.02, 0.55 * top, 1.6 * tube, 0, 0.001, kCharcoal);
  solid.drum({}, 0.55 * top, top - 0.006, tube, 0, 0, kSteel);
  solid.drum({}, top - 0.01, top + 0.001, 1.25 * tube, 0.001, 0.001, kSteel);
  // The fitting of the hose.
  const Pose side = frame_along({0, 0, 0.36 * top}, {0, 1, 0});
  solid.drum(side, 0, 1.6 * tube + 0.012, 0.0045, 0, 0.0008, kSteel);
  solid.drum(side, 1.6 * tube + 0.004, 1.6 * tube + 0.009, 0.006, 0.0008, 0.0008, kJet);
  cup(solid, tool.tcp, radius, tall);
  return solid.take();
}

// --- jaws

/// One jaw of a parallel gripper with closed pads: the pad, and what carries it from z = `from` on.
/// `side`: 1 for the jaw on +y of the TCP, -1 for the other one.
struct Jaw {
  const Tool& tool;
  double side = 1;
  double from = 0;  ///< in the frame of the TCP, z below zero

  ToolShape with(Solid& solid) const {
    return {side > 0 ? "finger_left" : "finger_right", solid.take(),
            tool.tcp.rotation * Vec3{0, side / 2, 0}};
  }
  Pose at(double y, double z) const { return tool.tcp * Pose{{0, side * y, z}, {}}; }
  void pad(Solid& solid, const Paint& paint) const {
    const double thick = description::kFingerThickness;
    solid.box(at(thick / 2, -tool.finger_length / 2), {tool.finger_width, thick, tool.finger_length},
              0.08 * thick, paint);
  }
};

/// A pad on a carriage that runs in the body.
ToolShape plain_jaw(const Jaw& jaw) {
  Solid solid;
  jaw.pad(solid, kMetal);
  const double thick = description::kFingerThickness, top = -jaw.tool.finger_length;
  const double tall = top + 0.006 - jaw.from;
  if (tall > 0.002)
    solid.box(jaw.at(0.95 * thick, (jaw.from + top + 0.006) / 2),
              {1.1 * jaw.tool.finger_width, 1.8 * thick, tall}, 0.001, kSteel);
  return jaw.with(solid);
}

std::vector<ToolShape> jaws(const Tool& tool, double from, ToolShape (*make)(const Jaw&)) {
  return {make({tool, 1, from}), make({tool, -1, from})};
}

/// A housing on a flange plate, with a rail for the carriages.
meshes::Mesh jaw_body(const Tool& tool) {
  Solid solid;
  const double tall = std::max(0.02, std::min(end_of(tool), tool.tcp.position.z - tool.finger_length));
  const double wide = std::max(0.058, tool.stroke + 0.02), deep = std::max(0.036, 1.6 * tool.finger_width);
  solid.drum({}, 0, 0.009, 0.0315, 0.0008, 0.001, kMetal);
  solid.box(up_to((0.009 + tall - 0.006) / 2), {deep, wide, tall - 0.015}, 0.004, kCharcoal);
  solid.box(up_to(tall - 0.004), {0.62 * deep, wide, 0.008}, 0.0008, kSteel);
  return solid.take();
}

/// A section at a height above the flange: its half sizes along x and y, and the radius of its corners.
struct Level {
  double z = 0, x = 0, y = 0, corner = 0;
};

void rise(Solid& solid, std::initializer_list<Level> levels, const Paint& paint) {
  std::vector<Section> sections;
  for (const Level& each : levels) sections.push_back({up_to(each.z), each.x, each.y, each.corner});
  solid.loft(sections, paint);
}

/// Robotiq Hand-E: a round housing that becomes flat towards the rail, and fingers as angles.
meshes::Mesh hand_e_body() {
  Solid solid;
  solid.drum({}, 0, 0.0135, 0.0375, 0.0008, 0.001, kMetal);
  rise(solid,
       {{0.0135, 0.0365, 0.0365, 0.0365},
        {0.05, 0.0365, 0.0365, 0.0365},
        {0.075, 0.033, 0.0375, 0.026},
        {0.098, 0.0225, 0.0375, 0.012},
        {0.112, 0.0215, 0.037, 0.008}},
       kCharcoal);
  solid.drum({}, 0.03, 0.034, 0.0369, 0, 0, kMetal);
  solid.box(up_to(0.113), {0.026, 0.073, 0.006}, 0.001, kJet);
  return solid.take();
}

/// Robotiq 2F-85: the palm with the knuckles' pivots.
meshes::Mesh two_finger_body() {
  Solid solid;
  solid.drum({}, 0, 0.0135, 0.0375, 0.0008, 0.001, kMetal);
  rise(solid,
       {{0.0135, 0.0375, 0.0375, 0.0375},
        {0.032, 0.0375, 0.0375, 0.0375},
        {0.052, 0.03, 0.041, 0.022},
        {0.078, 0.019, 0.043, 0.01},
        {0.092, 0.017, 0.04, 0.008},
        {0.1, 0.016, 0.03, 0.008}},
       kCharcoal);
  solid.drum({}, 0.02, 0.023, 0.0379, 0, 0, kMetal);
  for (const double y : {-0.0305, 0.0305})
    solid.drum(frame_along({0, y, 0.08}, {1, 0, 0}), -0.0215, 0.0215, 0.008, 0.001, 0.001, kSteel);
  return solid.take();
}

/// A straight bar of the linkage in the plane of the fingers, from (y, z) to (y, z), on both sides of the
/// gripper.
void bars(Solid& solid, const Jaw& jaw, std::array<double, 2> from, std::array<double, 2> to, double wide,
          const Paint& paint) {
  const Vec3 a = jaw.at(from[0], from[1]).position, b = jaw.at(to[0], to[1]).position;
  const Vec3 x = jaw.tool.tcp.rotation * Vec3{1, 0, 0};
  for (const double side : {-1.0, 1.0}) {
    const Vec3 out = side * 0.0125 * x;
    const Section ends[] = {{frame_along(a + out, b - a, x), 0.003, wide, 0.0028},
                            {frame_along(b + out, b - a, x), 0.003, wide, 0.0028}};
    solid.loft(ends, paint);
    const double from = std::min(side * 0.009, side * 0.0165), to = std::max(side * 0.009, side * 0.0165);
    const std::array<Ring, 4> pivot{{{0, from}, {1.05 * wide, from}, {1.05 * wide, to}, {0, to}}};
    for (const Vec3& at : {a, b}) solid.turn(frame_along(at, x), pivot, kSteel);
  }
}

/// The linkage moves with the fingertip; the palm hides its other end.
ToolShape two_finger_jaw(const Jaw& jaw) {
  Solid solid;
  jaw.pad(solid, kJet);
  bars(solid, jaw, {0.006, jaw.from}, {0.034, -0.062}, 0.0075, kMetal);           // outer knuckle
  bars(solid, jaw, {0.004, jaw.from + 0.008}, {0.016, -0.04}, 0.005, kCharcoal);  // inner knuckle
  bars(solid, jaw, {0.034, -0.062}, {0.016, -0.03}, 0.0075, kCharcoal);           // finger
  solid.box(jaw.at(0.0125, -0.022), {0.02, 0.009, 0.04}, 0.0015, kCharcoal);
  return jaw.with(solid);
}

ToolShape hand_e_jaw(const Jaw& jaw) {
  Solid solid;
  jaw.pad(solid, kJet);
  const double top = -jaw.tool.finger_length;
  solid.box(jaw.at(0.009, (jaw.from + top + 0.01) / 2), {0.0235, 0.016, top + 0.01 - jaw.from}, 0.0012,
            kMetal);
  return jaw.with(solid);
}

// --- tools of files

/// The shapes of the file, with the cup or the jaws that they leave out.
meshes::Mesh own_body(const Tool& tool) {
  Solid solid;
  const double gap = tool.tcp.position.z - end_of(tool);
  if (tool.gripper == GripperKind::suction && gap >= 0)
    cup(solid, tool.tcp, tool.cup_radius, std::clamp(gap, 0.6 * tool.cup_radius, 3 * tool.cup_radius));
  meshes::Mesh out = solid.take();
  for (const Shape& shape : tool.body) {
    meshes::Mesh one = meshes::mesh_of_shape(shape);
    meshes::place(one, shape);
    for (meshes::MeshPart& part : one) {
      std::copy(kCharcoal.color.begin(), kCharcoal.color.end(), part.color.begin());
      part.colored = true;
    }
    out.insert(out.end(), std::make_move_iterator(one.begin()), std::make_move_iterator(one.end()));
  }
  return out;
}

meshes::Mesh body_of(const Tool& tool) {
  if (tool.name == "suction_cup") return vacuum_cup(tool);
  if (tool.name == "parallel_gripper") return jaw_body(tool);
  if (tool.name == "robotiq_2f_85") return two_finger_body();
  if (tool.name == "robotiq_hand_e") return hand_e_body();
  return own_body(tool);
}

std::vector<ToolShape> jaws_of(const Tool& tool) {
  const double length = tool.tcp.position.z;
  if (tool.name == "robotiq_2f_85") return jaws(tool, 0.08 - length, two_finger_jaw);
  if (tool.name == "robotiq_hand_e") return jaws(tool, 0.112 - length, hand_e_jaw);
  return jaws(tool, std::min(end_of(tool) - length - 0.001, -tool.finger_length), plain_jaw);
}

}  // namespace

std::vector<ToolShape> tool_shapes(const Tool& tool) {
  const auto is_mesh = [](const Shape& shape) { return shape.kind == ShapeKind::mesh; };
  if (tool.gripper == GripperKind::none || std::any_of(tool.body.begin(), tool.body.end(), is_mesh))
    return {};
  std::vector<ToolShape> out;
  if (meshes::Mesh body = body_of(tool); !body.empty()) out.push_back({"body", std::move(body), {}});
  if (tool.gripper == GripperKind::parallel)
    for (ToolShape& each : jaws_of(tool)) out.push_back(std::move(each));
  return out;
}

std::string tool_glb(const Tool& tool) {
  std::vector<meshes::GlbNode> nodes;
  for (ToolShape& each : tool_shapes(tool)) nodes.push_back({each.name, std::move(each.mesh)});
  return meshes::write_glb(nodes, meshes::Precision::compact);
}

std::string tool_shapes_hash(const Tool& tool) {
  std::uint64_t h = 0xcbf29ce484222325u;
  const auto add = [&](const std::string& text) {
    for (const char c : text + '\n') h = (h ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  };
  const auto pose = [&](const Pose& at) {
    const auto& [p, q] = at;
    add(fmt::format("{} {} {} {} {} {} {}", p.x, p.y, p.z, q.x, q.y, q.z, q.w));
  };
  add(kToolFormat);
  add(tool.name);
  pose(tool.tcp);
  add(fmt::format("{} {} {} {} {}", static_cast<int>(tool.gripper), tool.cup_radius, tool.stroke,
                  tool.finger_length, tool.finger_width));
  for (const Shape& shape : tool.body) {
    add(fmt::format("{} {} {} {} {} {}", static_cast<int>(shape.kind), shape.radius, shape.length,
                    shape.size.x, shape.size.y, shape.size.z));
    pose(shape.pose);
  }
  return fmt::format("{:016x}", h);
}

}  // namespace polyarm::shapes
