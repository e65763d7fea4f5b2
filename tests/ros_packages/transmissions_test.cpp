/// Transmissions as plugins of ros2_control use them.
#include <gtest/gtest.h>

#include "transmission_interface/differential_transmission_loader.hpp"
#include "transmission_interface/four_bar_linkage_transmission_loader.hpp"
#include "transmission_interface/simple_transmission_loader.hpp"

namespace transmission_interface {
namespace {

/// Two actuators and two joints with one quantity.
struct Pair {
  double actuators[2] = {3, 5}, joints[2] = {0, 0};
  void connect(Transmission& t, const char* quantity) {
    t.configure(
        {JointHandle("j1", quantity, &joints[0]), JointHandle("j2", quantity, &joints[1])},
        {ActuatorHandle("a1", quantity, &actuators[0]), ActuatorHandle("a2", quantity, &actuators[1])});
  }
};

TEST(Transmissions, DifferentialHasThePublishedNumbers) {
  for (const auto& [quantity, first, second] :
       {std::tuple{"effort", 140.0, 520.0}, std::tuple{"velocity", -0.0125, 0.06875},
        std::tuple{"position", -2.0125, 4.06875}}) {
    Pair pair;
    DifferentialTransmission t({10, -20}, {-2, 4}, {-2, 4});
    pair.connect(t, quantity);
    t.actuator_to_joint();
    EXPECT_NEAR(pair.joints[0], first, 1e-12) << quantity;
    EXPECT_NEAR(pair.joints[1], second, 1e-12) << quantity;
  }
}

TEST(Transmissions, GoBackToWhereTheyCameFrom) {
  DifferentialTransmission differential({10, -20}, {-2, 4}, {-2, 4});
  FourBarLinkageTransmission four_bar({50, -50}, {2, -2}, {1, -1});
  for (Transmission* t : {static_cast<Transmission*>(&differential), static_cast<Transmission*>(&four_bar)})
    for (const char* quantity : {"position", "velocity", "effort", "torque"}) {
      Pair pair;
      pair.connect(*t, quantity);
      t->actuator_to_joint();
      pair.actuators[0] = pair.actuators[1] = 0;
      t->joint_to_actuator();
      EXPECT_NEAR(pair.actuators[0], 3, 1e-12) << quantity;
      EXPECT_NEAR(pair.actuators[1], 5, 1e-12) << quantity;
    }
}

TEST(Transmissions, RefuseAReductionOfZero) {
  EXPECT_THROW(SimpleTransmission(0), Exception);
  EXPECT_THROW(DifferentialTransmission({0, 1}, {1, 1}), Exception);
}

TEST(Transmissions, AreLoadedFromADescription) {
  hardware_interface::TransmissionInfo info;
  info.joints.resize(1);
  info.joints[0].mechanical_reduction = 10, info.joints[0].offset = 1;
  double actuator = 1, joint = 0;
  const auto t = SimpleTransmissionLoader().load(info);
  t->configure({JointHandle("j", "position", &joint)}, {ActuatorHandle("a", "position", &actuator)});
  t->actuator_to_joint();
  EXPECT_DOUBLE_EQ(joint, 1.1);
}

}  // namespace
}  // namespace transmission_interface
