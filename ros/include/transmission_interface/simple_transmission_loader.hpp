#pragma once
#include "transmission_interface/simple_transmission.hpp"
#include "transmission_interface/transmission_loader.hpp"

namespace transmission_interface {
class SimpleTransmissionLoader : public TransmissionLoader {
 public:
  /// Null where the description does not fit.
  std::shared_ptr<Transmission> load(const hardware_interface::TransmissionInfo& info) override {
    if (info.joints.empty()) return nullptr;
    return std::make_shared<SimpleTransmission>(info.joints[0].mechanical_reduction, info.joints[0].offset);
  }
};
}  // namespace transmission_interface
