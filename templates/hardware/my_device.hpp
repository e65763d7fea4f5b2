#pragma once
/// Hardware of your own: every callback of a component, with a device that is only pretended. Replace Wire.
#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "polyarm/hardware/component.hpp"

namespace my_device_plugin {

namespace hw = polyarm::hardware;

/// What is asked of the device. Keep it this narrow: tests put a device of their own behind it. All positions
/// in rad. Nothing here may throw or allocate but open().
class Wire {
 public:
  virtual ~Wire() = default;
  /// Opens the port and finds out whether the device is there. Moves nothing.
  virtual bool open(const std::string& port, std::size_t joints) = 0;
  virtual void close() noexcept = 0;
  virtual bool enable(bool on) noexcept = 0;
  virtual bool read(std::size_t joint, double& position) noexcept = 0;
  virtual bool write(std::size_t joint, double position) noexcept = 0;
};

class MyDevice : public hw::Component {
 public:
  MyDevice();  ///< on a pretended device
  explicit MyDevice(std::unique_ptr<Wire> wire);

  // Building and switching: may take their time, may throw polyarm::Error in on_init.
  hw::CallbackReturn on_init(const hw::ComponentContext& context) override;
  hw::CallbackReturn on_configure() override;
  hw::CallbackReturn on_activate() override;
  hw::CallbackReturn on_deactivate() override;
  hw::CallbackReturn on_cleanup() override;
  hw::CallbackReturn on_shutdown() override;
  hw::CallbackReturn on_error() override;
  std::vector<hw::InterfaceDescription> state_interfaces() const override;
  std::vector<hw::InterfaceDescription> command_interfaces() const override;
  hw::ReturnType prepare_command_mode_switch(std::span<const std::string> start,
                                             std::span<const std::string> stop) override;

  // The control thread, once each cycle: never block, allocate, throw or log.
  hw::ReturnType perform_command_mode_switch(std::span<const std::string> start,
                                             std::span<const std::string> stop) noexcept override;
  hw::ReturnType read(const hw::Cycle& cycle, std::span<double> states) noexcept override;
  hw::ReturnType write(const hw::Cycle& cycle, std::span<const double> commands) noexcept override;

  bool real() const noexcept override { return false; }    // true as soon as something moves
  bool blocks() const noexcept override { return false; }  // true when read and write wait for the device
  std::string reason() const override;
  std::string summary() const override;

 private:
  enum class Failure : int { none, no_device, not_enabled, no_answer, not_taken };
  bool note(Failure failure, std::size_t joint = 0) noexcept;

  std::unique_ptr<Wire> wire_;
  std::string port_;
  std::vector<std::string> joints_;  ///< "arm/joint_1"
  std::atomic<Failure> failure_{Failure::none};
  std::atomic<std::size_t> failed_joint_{0};
};

}  // namespace my_device_plugin
