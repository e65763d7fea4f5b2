#pragma once
#include <atomic>

#include "polyarm/controllers/controller.hpp"
#include "polyarm/realtime/latest.hpp"

namespace polyarm::controllers {

/// Writes and tells the values of GPIOs, as ros2_control's GpioCommandController does. Parameters: `gpios`,
/// `command_interfaces.<gpio>.interfaces`, `state_interfaces.<gpio>.interfaces` (where none is named: every
/// state of these gpios). Input `commands`: values by name ("gpio/interface"); what is not named, or is NaN,
/// stays as it was commanded last. Output `gpio_states`. Until something is sent it commands nothing, and a
/// stop of motion leaves outputs as they are. With `command_timeout` (s) what was sent ends when nothing more
/// comes: everything that was commanded becomes 0.
class GpioCommandController : public Controller {
 public:
  CallbackReturn on_configure(ControllerContext& context) override;
  CallbackReturn on_activate(const Cycle& cycle) noexcept override;
  ReturnType update(const Cycle& cycle, const Verdict& verdict) noexcept override;
  std::vector<InputPort> inputs() const override;
  std::uint64_t receive(const std::string& port, const Input& message, bool goal) override;

 private:
  struct Asked {
    std::uint32_t activation = 0;
    std::vector<double> values;
  };
  void read_commands(ControllerContext& context, const std::vector<std::string>& gpios);
  void read_states(ControllerContext& context, const std::vector<std::string>& gpios);

  std::vector<std::string> command_names_, state_names_;  // as the file has them
  std::vector<std::size_t> command_places_, state_places_;
  Output* states_ = nullptr;
  Asked asked_;  // cell thread: everything sent since the activation
  realtime::Latest<Asked> inbox_;
  std::atomic<std::uint32_t> activation_{0};
};

}  // namespace polyarm::controllers
