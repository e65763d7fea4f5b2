#pragma once
/// Transmissions between actuators and joints. Position, velocity, effort and torque pass both ways; the
/// formulas are those of ros2_control (n: reduction, off: joint offset).
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "hardware_interface/types/hardware_interface_type_values.hpp"
#include "transmission_interface/handle.hpp"
#include "transmission_interface/transmission_interface_exception.hpp"

namespace transmission_interface {

class Transmission {
 public:
  virtual ~Transmission() = default;
  virtual void configure(const std::vector<JointHandle>& joints,
                         const std::vector<ActuatorHandle>& actuators) = 0;
  virtual void actuator_to_joint() = 0;
  virtual void joint_to_actuator() = 0;
  virtual std::size_t num_actuators() const = 0;
  virtual std::size_t num_joints() const = 0;
  virtual std::string get_handles_info() const { return {}; }
};
using TransmissionSharedPtr = std::shared_ptr<Transmission>;

namespace internal {

/// The handles of one quantity, one for each actuator and joint; empty where a side has none.
struct Quantity {
  std::vector<ActuatorHandle> actuators;
  std::vector<JointHandle> joints;
  bool whole(std::size_t n) const { return actuators.size() == n && joints.size() == n; }
};

template <class Handles>
Handles of(const Handles& all, const char* interface) {
  Handles out;
  for (const auto& handle : all)
    if (handle.get_interface_name() == interface) out.push_back(handle);
  return out;
}
template <class Handles>
std::size_t count_names(const Handles& all) {
  std::vector<std::string> names;
  for (const auto& handle : all) {
    bool known = false;
    for (const std::string& name : names) known = known || name == handle.get_prefix_name();
    if (!known) names.push_back(handle.get_prefix_name());
  }
  return names.size();
}

/// Handles and reductions of a transmission of N actuators and N joints.
template <std::size_t N>
class Coupled : public Transmission {
 public:
  void configure(const std::vector<JointHandle>& joints,
                 const std::vector<ActuatorHandle>& actuators) override {
    if (joints.empty() || actuators.empty())
      throw Exception("a transmission needs joint and actuator handles");
    if (count_names(joints) != N || count_names(actuators) != N)
      throw Exception("a transmission of " + std::to_string(N) + " joints has handles of another number");
    const auto quantity = [&](const char* name) { return Quantity{of(actuators, name), of(joints, name)}; };
    position_ = quantity(hardware_interface::HW_IF_POSITION);
    velocity_ = quantity(hardware_interface::HW_IF_VELOCITY);
    effort_ = quantity(hardware_interface::HW_IF_EFFORT);
    torque_ = quantity(hardware_interface::HW_IF_TORQUE);
    if (!position_.whole(N) && !velocity_.whole(N) && !effort_.whole(N) && !torque_.whole(N))
      throw Exception("a transmission's joints and actuators have no interface in common");
  }
  std::size_t num_actuators() const override { return N; }
  std::size_t num_joints() const override { return N; }

 protected:
  Quantity position_, velocity_, effort_, torque_;
};

inline void check_reductions(const std::vector<double>& all, std::size_t count) {
  if (all.size() != count) throw Exception("a transmission has the wrong number of reductions");
  for (const double n : all)
    if (n == 0) throw Exception("Transmission reduction ratio cannot be zero");
}

}  // namespace internal
}  // namespace transmission_interface
