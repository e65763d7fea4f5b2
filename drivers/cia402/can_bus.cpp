#include "drivers/cia402/can_bus.hpp"

#include <algorithm>

#include "drivers/cia402/slcan.hpp"
#include "drivers/cia402/socket_can.hpp"

namespace polyarm::cia402 {

CanFrame frame_of(std::uint16_t id, std::span<const std::uint8_t> bytes) noexcept {
  CanFrame out;
  out.id = id;
  out.size = static_cast<std::uint8_t>(std::min(bytes.size(), out.data.size()));
  std::copy_n(bytes.begin(), out.size, out.data.begin());
  return out;
}

bool is_serial(const std::string& bus) {
  return bus.find('/') != std::string::npos;
}

std::unique_ptr<CanBus> open_bus(const BusOptions& options) {
  if (is_serial(options.bus)) return std::make_unique<SlcanBus>(options);
  return std::make_unique<SocketCanBus>(options);
}

std::unique_ptr<CanBus> take_bus(const std::string& bus, int file, int lock) {
  if (is_serial(bus)) return std::make_unique<SlcanBus>(serial::Port::handed_over(file, lock, bus));
  return std::make_unique<SocketCanBus>(Descriptor(file), Descriptor(lock));
}

}  // namespace polyarm::cia402
