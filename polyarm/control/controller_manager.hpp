#pragma once
#include <memory>
#include <string>
#include <vector>

#include "polyarm/controllers/controller.hpp"
#include "polyarm/hardware/hardware.hpp"

namespace polyarm::control {

/// Keeps the controllers of one loop: configures them, resolves their names, grants claims (commands to one
/// controller at a time, states to all), and updates them in order. Building and switching: with the loop
/// stopped.
class ControllerManager {
 public:
  ControllerManager(hardware::InterfaceTable& table, hardware::Hardware& hardware)
      : table_(table), hardware_(hardware) {}

  /// Configures the controller and resolves its interfaces; updates happen every `divisor` cycles. Throws
  /// Error naming the interface that does not exist.
  void add(std::unique_ptr<controllers::Controller> controller, const controllers::ControllerContext& context,
           unsigned divisor = 1);
  /// Claims its commands, tells the hardware, starts it. Throws Error naming who holds a command already.
  void activate(const std::string& name, const hardware::Cycle& cycle);
  void deactivate(const std::string& name, const hardware::Cycle& cycle);

  void update(const hardware::Cycle& cycle, const controllers::Verdict& verdict) noexcept;
  /// True when no active controller asks for motion.
  bool standing() const noexcept;
  /// Index of the controller whose update failed in this cycle, else -1; it has been deactivated.
  int failed() const noexcept { return failed_; }

  controllers::Controller* find(const std::string& name) const;
  struct Listed {
    std::string name, type;
    hardware::LifecycleState state;
  };
  std::vector<Listed> list() const;
  const std::string& name_of(int index) const { return slots_[static_cast<std::size_t>(index)].name; }

 private:
  struct Slot {
    std::string name;
    std::unique_ptr<controllers::Controller> controller;
    std::vector<std::string> command_names;
    std::vector<std::size_t> commands;
    unsigned divisor = 1;
    hardware::LifecycleState state = hardware::LifecycleState::inactive;
  };
  Slot& slot(const std::string& name);

  hardware::InterfaceTable& table_;
  hardware::Hardware& hardware_;
  std::vector<Slot> slots_;
  int failed_ = -1;
};

}  // namespace polyarm::control
