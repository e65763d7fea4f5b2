#pragma once
/// Stages for tests of physics: the gantry with a tool above a cube, or parts alone.
#include <limits>
#include <memory>
#include <string>

#include "drivers/mujoco/component.hpp"
#include "polyarm/catalogue/catalogue.hpp"
#include "tests/drivers/rig.hpp"

namespace polyarm::test::mujoco_test {

inline constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kTcpAtZero = 0.4;  // height of the cup's lip when the gantry stands at zero
inline constexpr double kOnCube = 0.04 - kTcpAtZero;

inline Rig simulate(const Stage& stage, Nanoseconds period = 1'000'000) {
  return Rig(std::make_unique<drivers::MujocoComponent>(), stage.context(period));
}

inline Stage parts_only() {
  Stage out;
  out.robot = false;
  out.scene = table();
  return out;
}

/// The gantry with a tool above a cube of 40 mm that lies at the origin.
inline Stage cell(const std::string& tool = "suction_cup", double mass = 0.08) {
  Stage out;
  out.model = gantry();
  out.tool = description::find_tool(tool, ".");
  out.scene = table();
  out.scene.parts = {cube("cube", {0, 0, 0.02}, 0.04, mass)};
  return out;
}

inline description::Fixture block(const std::string& name, const Vec3& size, const Vec3& at) {
  description::Fixture out;
  out.name = name;
  out.shapes = {box(size)};
  out.pose.position = at;
  return out;
}

/// Lowers the cup onto the cube and switches it on.
inline void grasp(Rig& rig) {
  rig.move({{"arm/z/position", kOnCube + 0.0005}}, 0.5);
  rig.command("arm/tool/vacuum") = 1;
  rig.run(0.2);
}

}  // namespace polyarm::test::mujoco_test
