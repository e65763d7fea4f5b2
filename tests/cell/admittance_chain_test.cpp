/// A trajectory controller, an admittance controller behind it and a sensor, as one cell in lock-step.
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "polyarm/setup/cell_file.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm::cell {
namespace {

using test::Folder;
using test::LockStepCell;

/// Two axes that slide along x and z, and a sensor that measures 5 N along z all the time.
constexpr const char* kRobot = R"(<robot name="gantry">
  <link name="base_link"/><link name="carriage"/><link name="column"/><link name="pad"/>
  <joint name="x" type="prismatic"><parent link="base_link"/><child link="carriage"/><axis xyz="1 0 0"/>
    <limit lower="-1" upper="1" velocity="1" effort="100"/></joint>
  <joint name="z" type="prismatic"><parent link="carriage"/><child link="column"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" velocity="1" effort="100"/></joint>
  <joint name="flange" type="fixed"><parent link="column"/><child link="pad"/></joint>
  <ros2_control name="gantry" type="system">
    <hardware><plugin>mock_components/GenericSystem</plugin></hardware>
    <joint name="x"><command_interface name="position"/><state_interface name="position"/></joint>
    <joint name="z"><command_interface name="position"/><state_interface name="position"/></joint>
    <sensor name="fts">
      <state_interface name="force.x"><param name="initial_value">0</param></state_interface>
      <state_interface name="force.y"><param name="initial_value">0</param></state_interface>
      <state_interface name="force.z"><param name="initial_value">5</param></state_interface>
      <state_interface name="torque.x"><param name="initial_value">0</param></state_interface>
      <state_interface name="torque.y"><param name="initial_value">0</param></state_interface>
      <state_interface name="torque.z"><param name="initial_value">0</param></state_interface>
    </sensor>
  </ros2_control></robot>)";

constexpr const char* kAdmittanceControllers = R"(controller_manager:
  ros__parameters:
    update_rate: 500
    admittance: {type: admittance_controller/AdmittanceController}
    arm: {type: joint_trajectory_controller/JointTrajectoryController}
arm:
  ros__parameters:
    joints: [x, z]
    command_joints: [admittance/x, admittance/z]
    command_interfaces: [position]
    state_interfaces: [position]
admittance:
  ros__parameters:
    joints: [x, z]
    command_interfaces: [position]
    state_interfaces: [position]
    chainable_command_interfaces: [position]
    kinematics: {base: base_link, tip: pad, alpha: 0.0}
    ft_sensor: {name: fts, frame: {id: pad}, filter_coefficient: 1.0}
    control: {frame: {id: base_link}}
    fixed_world_frame: {frame: {id: world}}
    gravity_compensation: {frame: {id: pad}, CoG: {pos: [0.0, 0.0, 0.0]}}
    admittance:
      selected_axes: [true, false, true, false, false, false]
      mass: [2.0, 2.0, 2.0, 1.0, 1.0, 1.0]
      damping_ratio: [1.0, 1.0, 1.0, 1.0, 1.0, 1.0]
      stiffness: [500.0, 500.0, 500.0, 1.0, 1.0, 1.0]
)";

TEST(AdmittanceInACell, AddsItsOffsetToTheMovesOfAProgram) {
  const Folder folder;
  folder.write("gantry.urdf", kRobot);
  folder.write("controllers.yaml", kAdmittanceControllers);
  folder.write("there.points", "JS: x z\nName: There\nPoint: 0.3, -0.2\n");
  folder.write("go.script", "movej There, exact\nwait 2s\n");
  folder.write("job.data", "Name: PointFile\nText: there\nName: ScriptFile\nText: go\n");
  folder.write("cell.yaml",
               "polyarm: cell/1\nrobots:\n  arm: {model: gantry.urdf, hardware: mock}\n"
               "controllers: controllers.yaml\nprogram: job\n");
  LockStepCell cell(read_cell_file(folder.path()));
  while (!cell.cell().program()->ended() && seconds(cell.cell().loop().cycle().time) < 60) cell.tick();
  ASSERT_TRUE(cell.cell().program()->ended());
  ASSERT_FALSE(cell.cell().program()->failed())
      << cell.cell().program()->status().problem.value_or(Problem{}).text();
  const auto state = [&](const char* name) {
    return cell.cell().snapshot().states[*cell.cell().loop().table().find_state(name)];
  };
  EXPECT_NEAR(state("arm/x/position"), 0.3, 1e-6);
  EXPECT_NEAR(state("arm/z/position"), -0.2 + 5 / 500.0, 1e-5);
}

}  // namespace
}  // namespace polyarm::cell
