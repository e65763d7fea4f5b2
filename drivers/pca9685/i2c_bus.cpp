#include "drivers/pca9685/i2c_bus.hpp"

#include <fcntl.h>
#include <linux/i2c-dev.h>
#include <linux/i2c.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>

namespace polyarm::drivers {

namespace {
/// Repeats a transaction that lost arbitration to another master or was interrupted by a signal.
constexpr int kTries = 3;

class LinuxBus : public I2cBus {
 public:
  LinuxBus(int file, std::uint8_t address, const BusCalls& calls)
      : file_(file), address_(address), calls_(calls) {}
  ~LinuxBus() override { calls_.close(file_); }

  int write(std::span<const std::uint8_t> bytes) noexcept override {
    i2c_msg message{address_, 0, static_cast<__u16>(bytes.size()), const_cast<__u8*>(bytes.data())};
    return transfer({&message, 1});
  }
  int read(std::uint8_t first_register, std::span<std::uint8_t> into) noexcept override {
    i2c_msg messages[2] = {{address_, 0, 1, &first_register},
                           {address_, I2C_M_RD, static_cast<__u16>(into.size()), into.data()}};
    return transfer(messages);
  }

 private:
  int transfer(std::span<i2c_msg> messages) noexcept {
    i2c_rdwr_ioctl_data all{messages.data(), static_cast<__u32>(messages.size())};
    for (int tries = 1;; ++tries) {
      const int done = calls_.ioctl(file_, I2C_RDWR, &all);
      if (done == static_cast<int>(messages.size())) return 0;
      const int error = done < 0 ? errno : EIO;  // fewer messages than requested
      if ((error != EINTR && error != EAGAIN) || tries == kTries) return error;
    }
  }

  int file_;
  std::uint8_t address_;
  BusCalls calls_;
};
}  // namespace

BusCalls linux_calls() {
  return {[](const char* path, int flags) { return ::open(path, flags); },
          [](int file, unsigned long request, void* argument) { return ::ioctl(file, request, argument); },
          [](int file) { return ::close(file); }};
}

std::unique_ptr<I2cBus> open_linux_bus(const std::string& path, std::uint8_t address, BusFailure& failure,
                                       const BusCalls& calls) {
  using Step = BusFailure::Step;
  failure = {};
  const int file = calls.open(path.c_str(), O_RDWR | O_CLOEXEC);
  if (file < 0) {
    failure = {Step::open, errno};
    return nullptr;
  }
  const auto refuse = [&](Step step, int error) -> std::unique_ptr<I2cBus> {
    calls.close(file);
    failure = {step, error};
    return nullptr;
  };
  unsigned long functions = 0;
  if (calls.ioctl(file, I2C_FUNCS, &functions) < 0) return refuse(Step::functions, errno);
  if ((functions & I2C_FUNC_I2C) == 0) return refuse(Step::not_plain, EOPNOTSUPP);
  // Not needed for transactions, but returns EBUSY if a kernel driver uses the device.
  if (calls.ioctl(file, I2C_SLAVE, reinterpret_cast<void*>(static_cast<std::uintptr_t>(address))) < 0)
    return refuse(Step::address, errno);
  return std::make_unique<LinuxBus>(file, address, calls);
}

}  // namespace polyarm::drivers
