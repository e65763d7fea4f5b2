#pragma once
#include "drivers/feetech/family.hpp"
#include "drivers/feetech/protocol0.hpp"
#include "drivers/servo_bus/component.hpp"

namespace polyarm::feetech {

/// STS3215 and alike on Feetech's wire.
class FeetechComponent : public servo_bus::ServoComponent {
 public:
  FeetechComponent() : ServoComponent(sts_family(), std::make_unique<Protocol0>()) {}
  explicit FeetechComponent(std::string watchdog)
      : ServoComponent(sts_family(), std::make_unique<Protocol0>(), std::move(watchdog)) {}
};

}  // namespace polyarm::feetech
