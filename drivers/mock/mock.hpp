#pragma once
/// Mock hardware without physics. rad, m, s. read() and write() run on the control thread and allocate
/// nothing.
#include <cstdint>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "drivers/mock/injection.hpp"
#include "drivers/mock/mock_world.hpp"
#include "polyarm/hardware/component.hpp"

namespace polyarm::drivers {

/// Hardware that follows commands immediately, without physics, like mock_components/GenericSystem of
/// ros2_control. Parameters: `calculate_dynamics`, `disable_commands`, `position_state_following_offset`,
/// `custom_interface_with_following_offset` (a state interface that takes the offset instead of the
/// position), `mock_sensor_commands`, `mock_gpio_commands`; and `integrate_velocity`, which ignores position
/// commands and follows the velocity, as the RobotSystem of ros2_control's example 7 does. A robot without
/// <ros2_control> gets a position command and position and velocity states for each actuated joint; the
/// velocity state is then the difference quotient of positions. `inject` injects faults (Injection).
/// MockWorld simulates tools, feeders, outfeeds, movers and parts.
class MockComponent : public hardware::Component {
 public:
  hardware::CallbackReturn on_init(const hardware::ComponentContext& context) override;
  hardware::CallbackReturn on_activate() override;
  std::vector<hardware::InterfaceDescription> state_interfaces() const override;
  std::vector<hardware::InterfaceDescription> command_interfaces() const override;
  /// With dynamics, a joint accepts only one of position, velocity and acceleration at a time.
  hardware::ReturnType prepare_command_mode_switch(std::span<const std::string> start,
                                                   std::span<const std::string> stop) override;
  /// A stopped mode no longer drives its joint, whatever its command is, until it is started again.
  hardware::ReturnType perform_command_mode_switch(std::span<const std::string> start,
                                                   std::span<const std::string> stop) noexcept override;
  hardware::ReturnType read(const hardware::Cycle& cycle, std::span<double> states) noexcept override;
  hardware::ReturnType write(const hardware::Cycle& cycle,
                             std::span<const double> commands) noexcept override;
  const hardware::WorldState* world() const noexcept override { return world_ ? &world_->state() : nullptr; }
  std::vector<std::string> world_names() const override { return {}; }
  std::string reason() const override { return injection_.reason(); }
  const hardware::DriverFacts* facts() const noexcept override;
  std::string summary() const override;

 private:
  /// A joint; the indices refer to the spans of read and write, -1 for none.
  struct Part {
    int position_state = -1, velocity_state = -1, acceleration_state = -1, effort_state = -1;
    int position_command = -1, velocity_command = -1, acceleration_command = -1, effort_command = -1;
    int custom_state = -1;  ///< takes the position with the following offset
    int mimicked = -1;      ///< index of the leading part
    double position = 0, velocity = 0, acceleration = 0, effort = 0;
    double multiplier = 1, offset = 0;
    bool quotient = false;  ///< the velocity state is the difference quotient
  };
  /// Joints with only a position command and position and velocity states, which is nearly every joint.
  struct Followers {
    std::vector<double> position;
    std::vector<std::uint32_t> command, position_state, velocity_state;
  };
  struct Mirror {
    int command = -1, state = -1;
    double value = 0;
  };
  void add_declared(const hardware::RobotInstance& robot, const description::HardwareInfo& info);
  void add_plain(const hardware::RobotInstance& robot);
  void add_component(const hardware::RobotInstance& robot, const description::ComponentInfo& info);
  int state(const std::string& name, double initial);
  int command(const std::string& name);
  void move(Part& part, double dt) noexcept;
  void follow(double dt, std::span<double> states) noexcept;
  void move_parts(double dt, std::span<double> states) noexcept;
  void part_followers();
  int command_named(const std::string& name) const noexcept;
  /// Names of the parts for which `which` is true; only the first few.
  template <class Which>
  std::string names_of(Which which) const;

  std::vector<hardware::InterfaceDescription> states_, commands_;
  std::vector<Part> parts_;
  std::vector<std::string> part_names_;  // names in their robots; first parts_, then followers_
  Followers followers_;
  std::unordered_map<std::string, int> command_places_;
  std::vector<int> part_of_command_;  // the part that a command drives, -1: none
  std::vector<Mirror> mirrors_;
  std::vector<double> asked_;  // the last finite command of each interface, NaN before the first
  std::vector<char> stopped_;  // commands that no longer drive their joint
  bool any_stopped_ = false;
  std::unique_ptr<MockWorld> world_;
  Injection injection_;
  bool dynamics_ = false, disabled_ = false, velocity_leads_ = false, mirror_sensors_ = false,
       mirror_gpios_ = false, broken_ = false;
  double following_offset_ = 0;
  std::string custom_interface_;
};

}  // namespace polyarm::drivers
