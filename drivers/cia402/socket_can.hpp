#pragma once
/// A CAN interface of Linux (`can0`). Its bit rate and its state are the system's (`ip link`). One thread.
#include "drivers/cia402/can_bus.hpp"
#include "polyarm/base/descriptor.hpp"
#include "polyarm/hardware/device_lock.hpp"

namespace polyarm::cia402 {

class SocketCanBus : public CanBus {
 public:
  /// Throws Error: "no-such-port", "port-not-permitted", "device-in-use", "port-failed".
  explicit SocketCanBus(const BusOptions& options);
  /// A socket that is open, in another process or in a test.
  explicit SocketCanBus(Descriptor socket, Descriptor lock = Descriptor()) noexcept
      : socket_(std::move(socket)), foreign_lock_(std::move(lock)) {}

  BusState send(const CanFrame& frame) noexcept override;
  BusState receive(CanFrame& frame, Nanoseconds deadline) noexcept override;
  std::array<int, 2> descriptors() const noexcept override { return {socket_.number(), lock_.descriptor()}; }
  std::uint64_t refused() const noexcept override { return refused_; }
  std::uint64_t garbage() const noexcept override { return garbage_; }

 private:
  hardware::DeviceLock lock_;
  Descriptor socket_, foreign_lock_;
  bool off_ = false;
  std::uint64_t refused_ = 0, garbage_ = 0;
};

}  // namespace polyarm::cia402
