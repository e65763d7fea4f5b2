#pragma once
/// Driver for DC motors on a PCA9685 board. rad, rad/s, s.
#include <atomic>
#include <memory>
#include <mutex>
#include <vector>

#include "drivers/pca9685/chip.hpp"
#include "drivers/pca9685/settings.hpp"
#include "drivers/watchdog/link.hpp"
#include "polyarm/hardware/component.hpp"
#include "polyarm/hardware/device_lock.hpp"

namespace polyarm::drivers {

/// The environment of the component; tests replace it by a simulated chip.
struct BoardEnvironment {
  BusOpener open;
  std::string watchdog;  ///< path of the program
};
BoardEnvironment real_board();

/// DC motors on a board with a PCA9685 (Adafruit's motor HAT and FeatherWing, the JetBot): one velocity
/// command for each wheel, rad/s. There is no encoder: the velocity state is the command after dead band and
/// clamp, and the position state is its integral over the cycles; neither is measured.
///
/// Motors are off after on_configure, on_activate, on_deactivate, on_error, on_shutdown and destruction, and
/// while a wheel has no command (NaN). If this process dies or hangs, the watchdog process turns them off.
/// After any failure nothing moves until on_activate.
///
/// Reads and writes wait for the bus. The on_… calls may come from another thread than read and write.
class Pca9685Component : public hardware::Component {
 public:
  explicit Pca9685Component(BoardEnvironment environment = real_board())
      : environment_(std::move(environment)) {}
  ~Pca9685Component() override;

  hardware::CallbackReturn on_init(const hardware::ComponentContext& context) override;
  hardware::CallbackReturn on_configure() override;
  hardware::CallbackReturn on_activate() override;
  hardware::CallbackReturn on_deactivate() override;
  hardware::CallbackReturn on_cleanup() override;
  hardware::CallbackReturn on_shutdown() override;
  hardware::CallbackReturn on_error() override;

  std::vector<hardware::InterfaceDescription> state_interfaces() const override { return settings_.states; }
  std::vector<hardware::InterfaceDescription> command_interfaces() const override {
    return settings_.commands;
  }
  hardware::ReturnType read(const hardware::Cycle& cycle, std::span<double> states) noexcept override;
  hardware::ReturnType write(const hardware::Cycle& cycle,
                             std::span<const double> commands) noexcept override;
  bool real() const noexcept override { return true; }
  bool blocks() const noexcept override { return true; }
  std::string reason() const override;
  const hardware::DriverFacts* facts() const noexcept override;
  std::string summary() const override;

  int watchdog_process() const noexcept { return watchdog_.process(); }

 private:
  /// The last failure, packed into 64 bits so that another thread can read it at any time.
  enum class Trouble : std::uint8_t { none, lock, bus, chip, watchdog, command };
  struct Motor {
    MotorDrive applied;
    double velocity = 0, position = 0;  // rad/s, rad
  };
  void note(Trouble trouble, std::uint8_t step, std::uint8_t where = 0, std::uint8_t value = 0,
            int error = 0) noexcept;
  bool ok(const ChipFailure& failure) noexcept;
  bool ok(watchdog::Health health) noexcept;
  hardware::CallbackReturn configure();
  bool open();
  void close() noexcept;
  bool all_off() noexcept;
  hardware::ReturnType stop_for_failure() noexcept;
  ChipFailure apply(std::size_t wheel, const MotorDrive& drive) noexcept;
  bool drive_all(std::span<const double> commands) noexcept;
  std::string bus_reason(std::uint8_t step, int error) const;
  std::string chip_reason(std::uint8_t step, std::uint8_t where, std::uint8_t value, int error) const;
  std::string watchdog_reason(std::uint8_t step) const;
  std::string place() const;  ///< "the motor board at /dev/i2c-1 0x60"

  BoardEnvironment environment_;
  std::string name_, lock_refusal_;
  BoardSettings settings_;
  std::mutex mutex_;  // guards everything below
  hardware::DeviceLock lock_;
  std::unique_ptr<I2cBus> bus_;
  std::unique_ptr<Pca9685> chip_;
  watchdog::Link watchdog_;
  std::vector<Motor> motors_;
  bool driving_ = false, failed_ = false;
  std::uint64_t since_check_ = 0, check_every_ = 1;  // cycles
  std::atomic<std::uint64_t> trouble_{0};
};

}  // namespace polyarm::drivers
