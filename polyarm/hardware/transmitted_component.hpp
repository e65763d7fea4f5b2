#pragma once
/// Wraps a component that works with motors so it appears as one that works with joints.
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "polyarm/hardware/component.hpp"
#include "polyarm/hardware/transmission.hpp"

namespace polyarm::hardware {

/// For a component whose `<ros2_control>` blocks have transmissions. The inner component gets actuators
/// instead of the joints that a transmission drives; outside there are joints. Positions, velocities and
/// efforts pass through the transmissions in both directions. Other interfaces (a temperature) pass from
/// actuator k to joint k, and interfaces without a transmission pass unchanged. If only one joint of a pair
/// is commanded, the other one holds: its measured position, zero velocity, zero effort.
class TransmittedComponent : public Component {
 public:
  explicit TransmittedComponent(std::unique_ptr<Component> inside) : inside_(std::move(inside)) {}

  /// Throws Error with the location of a transmission that cannot be built, whose joints are not in its
  /// block, or of whose two joints only one has a command interface.
  CallbackReturn on_init(const ComponentContext& context) override;
  CallbackReturn on_configure() override { return inside_->on_configure(); }
  CallbackReturn on_activate() override { return inside_->on_activate(); }
  CallbackReturn on_deactivate() override { return inside_->on_deactivate(); }
  CallbackReturn on_cleanup() override { return inside_->on_cleanup(); }
  CallbackReturn on_shutdown() override { return inside_->on_shutdown(); }
  CallbackReturn on_error() override { return inside_->on_error(); }

  std::vector<InterfaceDescription> state_interfaces() const override { return states_.outside; }
  std::vector<InterfaceDescription> command_interfaces() const override { return commands_.outside; }
  ReturnType prepare_command_mode_switch(std::span<const std::string> start,
                                         std::span<const std::string> stop) override;
  ReturnType perform_command_mode_switch(std::span<const std::string> start,
                                         std::span<const std::string> stop) noexcept override;
  ReturnType read(const Cycle& cycle, std::span<double> states) noexcept override;
  ReturnType write(const Cycle& cycle, std::span<const double> commands) noexcept override;

  const WorldState* world() const noexcept override { return inside_->world(); }
  std::vector<std::string> world_names() const override { return inside_->world_names(); }
  bool real() const noexcept override { return inside_->real(); }
  bool blocks() const noexcept override { return inside_->blocks(); }
  bool paces() const noexcept override { return inside_->paces(); }
  bool await_cycle(Nanoseconds timeout) noexcept override { return inside_->await_cycle(timeout); }
  std::string reason() const override { return inside_->reason(); }
  const DriverFacts* facts() const noexcept override { return inside_->facts(); }
  std::string summary() const override;

 private:
  struct Pass {
    std::size_t inside, outside;
  };
  /// One quantity of one transmission. -1: no such interface outside.
  struct Link {
    std::size_t transmission;
    Quantity quantity;
    std::array<std::size_t, 2> inside{};
    std::array<int, 2> outside{-1, -1};
    std::array<int, 2> measured{-1, -1};  ///< for commands: outside index of the joint's measured position
  };
  struct Side {
    std::vector<InterfaceDescription> inside, outside;
    std::vector<Pass> passes;
    std::vector<Link> links;
    std::vector<double> values;             ///< inside values
    std::vector<std::vector<int>> reaches;  ///< per outside interface: affected inside ones
  };
  struct Driven {
    std::string robot;
    Transmission transmission;
    std::size_t first_joint;  ///< in `joints_`
  };

  void drive(RobotInstance& robot, description::HardwareInfo& block);
  void connect(Side& side);
  std::size_t translate(const Side& side, std::span<const std::string> names,
                        std::vector<std::string>& scratch) const noexcept;

  std::unique_ptr<Component> inside_;
  std::vector<Driven> driven_;
  std::vector<description::ComponentInfo> joints_;  ///< as in the block
  Side states_, commands_;
  std::vector<double> measured_;                       ///< outside values of the last read
  std::vector<std::string> start_names_, stop_names_;  ///< buffers for the control thread
};

/// Returns the component itself if nothing is transmitted, otherwise its wrapper.
std::unique_ptr<Component> through_transmissions(std::unique_ptr<Component> component,
                                                 const ComponentContext& context);

}  // namespace polyarm::hardware
