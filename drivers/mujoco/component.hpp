#pragma once
/// Simulation of a cell with MuJoCo. SI units; poses in the world. read() and write() run on the control
/// thread.
#include <memory>
#include <string>
#include <vector>

#include "drivers/mujoco/contacts.hpp"
#include "drivers/mujoco/first_half.hpp"
#include "drivers/mujoco/grasp.hpp"
#include "drivers/mujoco/machines.hpp"
#include "drivers/mujoco/model_set.hpp"
#include "drivers/mujoco/parts.hpp"
#include "drivers/mujoco/sensor_errors.hpp"
#include "drivers/mujoco/servo.hpp"
#include "polyarm/hardware/component.hpp"

namespace polyarm::drivers {

/// Robots, tools, parts and machines of a cell, simulated by MuJoCo. Offers position, velocity and effort
/// commands and states for each actuated joint, the wrench of force/torque sensors (a force on the robot
/// beyond the sensor, and its weight, in the axes of the sensor's link), and the interfaces of tools and
/// scene (scene.hpp). A control period is divided into steps of at most 1 ms. Deterministic: one thread, no
/// clock, the same inputs give the same bits.
class MujocoComponent : public hardware::Component {
 public:
  hardware::CallbackReturn on_init(const hardware::ComponentContext& context) override;
  hardware::CallbackReturn on_configure() override;
  std::vector<hardware::InterfaceDescription> state_interfaces() const override { return states_; }
  std::vector<hardware::InterfaceDescription> command_interfaces() const override { return commands_; }
  hardware::ReturnType prepare_command_mode_switch(std::span<const std::string> start,
                                                   std::span<const std::string> stop) override;
  hardware::ReturnType perform_command_mode_switch(std::span<const std::string> start,
                                                   std::span<const std::string> stop) noexcept override;
  hardware::ReturnType read(const hardware::Cycle& cycle, std::span<double> states) noexcept override;
  hardware::ReturnType write(const hardware::Cycle& cycle,
                             std::span<const double> commands) noexcept override;
  const hardware::WorldState* world() const noexcept override { return &world_; }
  std::vector<std::string> world_names() const override {
    return models_ ? models_->names() : std::vector<std::string>{};
  }
  const hardware::DriverFacts* facts() const noexcept override;
  std::string summary() const override;

 private:
  struct Robot {
    hardware::RobotInstance facts;
    std::unique_ptr<Servo> servo;
    std::unique_ptr<Gripper> gripper;
    std::size_t joints = 0;
    std::size_t first_state = 0, first_command = 0;  // position, velocity, effort of each joint in turn
    int tool_state = -1, tool_command = -1;
    int base_state = -1;                             // for a free-standing robot: the first of seven
    int force_state = -1;                            // of six for each force sensor
    std::size_t force_sensors = 0;
    std::vector<SensorErrors> errors;                // of each force sensor; none: all are exact
    std::vector<double> position, velocity, effort;  // commands, separated by kind
  };
  ModelView& view() noexcept { return models_->view(active_); }
  void step() noexcept;
  void change_model() noexcept;
  void copy_robots(const ModelView& from, ModelView& to) noexcept;
  void take_commands(std::span<const double> commands) noexcept;
  void publish() noexcept;
  Robot* robot_of(const std::string& interface, std::size_t& joint, JointMode& mode);

  hardware::ComponentContext context_;
  std::vector<hardware::InterfaceDescription> states_, commands_;
  std::vector<Robot> robots_;
  std::unique_ptr<ModelSet> models_;
  std::unique_ptr<Parts> parts_;
  std::unique_ptr<ContactReader> contacts_;
  std::unique_ptr<Machines> machines_;
  std::size_t active_ = 0;
  Known known_ = Known::nothing;  // of view()
  std::vector<mjtNum> places_;    // qpos of the last first half of a step
  int substeps_ = 1;
  double timestep_ = 1e-3;
  std::vector<mjtNum> acceleration_, inertial_force_;
  hardware::WorldState world_;
  Nanoseconds now_ = 0;
  double tracking_error_ = 0;
  bool failed_ = false;
};

}  // namespace polyarm::drivers
