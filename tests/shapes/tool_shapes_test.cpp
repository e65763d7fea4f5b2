#include "polyarm/shapes/tool_shapes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "polyarm/description/tools.hpp"

namespace polyarm::shapes {
namespace {

using description::Tool;

Tool built_in(const std::string& name) {
  return description::find_tool(name, ".");
}

Tool from_file(const std::string& text) {
  return description::read_tool(Yaml::parse(text, "tool.yaml"), "mine");
}

/// Calls `visit` with each corner of a shape in the flange's frame, at a width between the pads.
template <typename Visit>
void corners(const ToolShape& shape, double width, Visit visit) {
  for (const meshes::MeshPart& part : shape.mesh)
    for (const auto& p : part.positions) visit(width * shape.slide + Vec3{p[0], p[1], p[2]});
}

/// The largest height above the flange.
double end_of(const std::vector<ToolShape>& shapes, double width) {
  double out = -1;
  for (const ToolShape& each : shapes) corners(each, width, [&](const Vec3& p) { out = std::max(out, p.z); });
  return out;
}

TEST(ToolShapes, EveryBuiltInGripperEndsAtItsTcp) {
  for (const std::string& name : description::built_in_tools()) {
    if (name == "none") continue;
    const Tool tool = built_in(name);
    const std::vector<ToolShape> shapes = tool_shapes(tool);
    ASSERT_FALSE(shapes.empty()) << name;
    EXPECT_EQ(shapes.size(), tool.gripper == description::GripperKind::parallel ? 3u : 1u) << name;
    for (const double width : {0.0, tool.stroke})
      EXPECT_NEAR(end_of(shapes, width), tool.tcp.position.z, 1e-6) << name;
    std::size_t triangles = 0;
    for (const ToolShape& each : shapes) {
      triangles += meshes::triangles_of(each.mesh);
      corners(each, 0, [&](const Vec3& p) { ASSERT_TRUE(std::isfinite(norm(p))) << name; });
    }
    EXPECT_LT(triangles, 12'000u) << name;
  }
}

TEST(ToolShapes, BetweenThePadsIsAsMuchRoomAsTheGripperSays) {
  for (const char* name : {"parallel_gripper", "robotiq_2f_85", "robotiq_hand_e"}) {
    const Tool tool = built_in(name);
    for (const double width : {0.0, 0.5 * tool.stroke, tool.stroke}) {
      double left = 1, right = -1;  // the inner faces of the pads
      for (const ToolShape& each : tool_shapes(tool))
        corners(each, width, [&](const Vec3& p) {
          if (p.z < tool.tcp.position.z - 0.001) return;
          if (each.name == "finger_left") left = std::min(left, p.y);
          if (each.name == "finger_right") right = std::max(right, p.y);
        });
      EXPECT_NEAR(left - right, width, 0.002) << name;
    }
  }
}

TEST(ToolShapes, AGripperOfAFileGetsTheCupOrTheJawsThatItsBodyLeavesOut) {
  const std::string body =
      "mass: 0.3kg\nbody: [{cylinder: {radius: 20mm, height: 60mm}, at: [0, 0, 30mm]}]\n";
  const Tool cup = from_file("tcp: {xyz: [0, 0, 0.08]}\ngripper: suction\ncup_radius: 15mm\n" + body);
  EXPECT_NEAR(end_of(tool_shapes(cup), 0), 0.08, 1e-6);
  const Tool jaws = from_file("tcp: {xyz: [0, 0, 0.1]}\ngripper: parallel\nstroke: 30mm\n" + body);
  EXPECT_EQ(tool_shapes(jaws).size(), 3u);
  EXPECT_NEAR(end_of(tool_shapes(jaws), 0.03), 0.1, 1e-6);
  EXPECT_TRUE(tool_shapes(from_file(body)).empty()) << "it grips nothing: its own shapes are its look";
}

TEST(ToolShapes, TheJawsOfATurnedTcpMoveInItsFrame) {
  const Tool tool = from_file(
      "mass: 0.3kg\ntcp: {xyz: [0.05, 0, 0.1], rpy: [0, 0, 90deg]}\ngripper: parallel\nstroke: 40mm\n"
      "body: [{cylinder: {radius: 20mm, height: 40mm}, at: [0, 0, 20mm]}]\n");
  for (const ToolShape& each : tool_shapes(tool))
    EXPECT_NEAR(std::abs(each.slide.x), each.name == "body" ? 0 : 0.5, 1e-9) << each.name;
}

TEST(ToolShapes, TheAddressChangesWithTheTool) {
  Tool tool = built_in("parallel_gripper");
  const std::string before = tool_shapes_hash(tool);
  EXPECT_EQ(tool_glb(tool), tool_glb(tool));
  EXPECT_TRUE(tool_glb(tool).starts_with("glTF"));
  tool.finger_length += 0.01;
  EXPECT_NE(tool_shapes_hash(tool), before);
}

}  // namespace
}  // namespace polyarm::shapes
