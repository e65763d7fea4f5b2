#pragma once
/// A driver with its own simulated far side: `hardware: feetech_fake` drives a simulated arm over the real
/// protocol.
#include <memory>

#include "drivers/dynamixel/family.hpp"
#include "drivers/feetech/family.hpp"
#include "drivers/servo_bus/component.hpp"
#include "drivers/servo_bus/fake_bus.hpp"
#include "drivers/servo_bus/fake_faults.hpp"

namespace polyarm::servo_bus {

/// `Real` is the component of a driver. Its parameters apply, except `port` and `calibration`: the servos are
/// simulated, their zero is in the middle, and they start at the robot's start position. `wire_faults`
/// injects faults on the wire, see FakeFaults.
template <typename Real, Wire wire>
class FakeServos : public Real {
 public:
  hardware::CallbackReturn on_init(const hardware::ComponentContext& context) override {
    hardware::ComponentContext own = context;
    own.parameters["port"] = "fake";
    own.parameters.erase("calibration");
    own.parameters.erase("wire_faults");
    own.parameters.try_emplace("watchdog", "off");           // the servos end with the process
    own.parameters.try_emplace("answer_timeout_ms", "200");  // a thread answers instead of a chip
    const hardware::CallbackReturn done = Real::on_init(own);
    std::vector<int> ids;
    for (const JointSetup& joint : this->setup().joints) ids.push_back(joint.id);
    fake_ = std::make_unique<FakeBus>(wire, ids);
    this->setup().port = fake_->path();
    for (const hardware::RobotInstance& robot : context.robots) place(robot);
    if (const auto faults = context.parameters.find("wire_faults"); faults != context.parameters.end())
      faults_.parse(faults->second, this->setup().joints);
    return done;
  }
  hardware::CallbackReturn on_activate() override {
    faults_.begin();
    return Real::on_activate();
  }
  hardware::ReturnType read(const hardware::Cycle& cycle, std::span<double> states) noexcept override {
    faults_.next(*fake_, wire == Wire::feetech ? feetech::sts_family().present_position
                                               : dynamixel::x_family().present_position);
    return Real::read(cycle, states);
  }
  bool real() const noexcept override { return false; }

 private:
  void place(const hardware::RobotInstance& robot) {
    if (!robot.model) return;
    const std::vector<std::string> names = robot.model->joint_names();
    for (std::size_t j = 0; j < names.size() && j < robot.initial_positions.size(); ++j)
      for (const JointSetup& joint : this->setup().joints)
        if (joint.interface == robot.name + "/" + names[j])
          fake_->move_by_hand(joint.id,
                              joint.zero + static_cast<int>(joint.direction * 4096 / 6.283185307179586 *
                                                            (robot.initial_positions[j] - joint.offset)));
  }
  std::unique_ptr<FakeBus> fake_;
  FakeFaults faults_;
};

}  // namespace polyarm::servo_bus
