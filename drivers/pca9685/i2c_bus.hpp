#pragma once
/// Access to one device on an I2C bus.
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

namespace polyarm::drivers {

/// Complete transactions with one device; each call may wait for the bus. Any thread, one at a time.
class I2cBus {
 public:
  virtual ~I2cBus() = default;
  /// START, address, `bytes`, STOP. Returns 0 or an errno.
  virtual int write(std::span<const std::uint8_t> bytes) noexcept = 0;
  /// Writes the register number, then reads from there with a repeated START. Returns 0 or an errno.
  virtual int read(std::uint8_t first_register, std::span<std::uint8_t> into) noexcept = 0;
};

/// The failed step of opening a bus.
struct BusFailure {
  enum class Step : std::uint8_t { none, open, functions, not_plain, address };
  Step step = Step::none;
  int error = 0;  ///< errno
};

/// Opens the device at a 7-bit address. If that fails, returns null and fills in `failure`. Sends nothing on
/// the bus.
using BusOpener = std::function<std::unique_ptr<I2cBus>(const std::string& path, std::uint8_t address,
                                                        BusFailure& failure)>;

/// The system calls; a test replaces them.
struct BusCalls {
  int (*open)(const char* path, int flags);
  int (*ioctl)(int file, unsigned long request, void* argument);
  int (*close)(int file);
};
BusCalls linux_calls();

/// A Linux bus, /dev/i2c-N.
std::unique_ptr<I2cBus> open_linux_bus(const std::string& path, std::uint8_t address, BusFailure& failure,
                                       const BusCalls& calls = linux_calls());

}  // namespace polyarm::drivers
