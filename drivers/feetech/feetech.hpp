#pragma once
/// Driver for Feetech servos on a serial line. See servo_bus/component.hpp for interfaces and units.
#include "drivers/feetech/family.hpp"
#include "drivers/feetech/protocol0.hpp"
#include "drivers/servo_bus/component.hpp"

namespace polyarm::feetech {

/// STS3215 and similar with Feetech's protocol.
class FeetechComponent : public servo_bus::ServoComponent {
 public:
  FeetechComponent() : ServoComponent(sts_family(), std::make_unique<Protocol0>()) {}
  explicit FeetechComponent(std::string watchdog)
      : ServoComponent(sts_family(), std::make_unique<Protocol0>(), std::move(watchdog)) {}
};

}  // namespace polyarm::feetech
