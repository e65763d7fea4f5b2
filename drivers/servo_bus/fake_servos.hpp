#pragma once
/// A driver with its own far side: `hardware: feetech_fake` drives an arm that is not there, over the real
/// wire.
#include <memory>

#include "drivers/servo_bus/component.hpp"
#include "drivers/servo_bus/fake_bus.hpp"

namespace polyarm::servo_bus {

/// `Real` is the component of a driver. Its parameters hold, but `port` and `calibration`: the servos are
/// here, their zero is in the middle, and they stand where the robot starts.
template <typename Real, Wire wire>
class FakeServos : public Real {
 public:
  hardware::CallbackReturn on_init(const hardware::ComponentContext& context) override {
    hardware::ComponentContext own = context;
    own.parameters["port"] = "fake";
    own.parameters.erase("calibration");
    own.parameters.try_emplace("watchdog", "off");           // the servos end with the process
    own.parameters.try_emplace("answer_timeout_ms", "200");  // a thread answers, not a chip
    const hardware::CallbackReturn done = Real::on_init(own);
    std::vector<int> ids;
    for (const JointSetup& joint : this->setup().joints) ids.push_back(joint.id);
    fake_ = std::make_unique<FakeBus>(wire, ids);
    this->setup().port = fake_->path();
    for (const hardware::RobotInstance& robot : context.robots) place(robot);
    return done;
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
};

}  // namespace polyarm::servo_bus
