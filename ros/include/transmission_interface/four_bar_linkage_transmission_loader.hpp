#pragma once
#include "transmission_interface/four_bar_linkage_transmission.hpp"
#include "transmission_interface/transmission_loader.hpp"

namespace transmission_interface {
class FourBarLinkageTransmissionLoader : public TransmissionLoader {
 public:
  /// Null where the description does not fit.
  std::shared_ptr<Transmission> load(const hardware_interface::TransmissionInfo& info) override {
    if (info.joints.size() != 2 || info.actuators.size() != 2) return nullptr;
    const auto& a = info.actuators;
    const auto& j = info.joints;
    return std::make_shared<FourBarLinkageTransmission>(
        std::vector<double>{a[0].mechanical_reduction, a[1].mechanical_reduction},
        std::vector<double>{j[0].mechanical_reduction, j[1].mechanical_reduction},
        std::vector<double>{j[0].offset, j[1].offset});
  }
};
}  // namespace transmission_interface
