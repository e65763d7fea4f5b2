#pragma once
/// Base class of drivers for sensors on a serial port.
#include <array>
#include <atomic>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "drivers/serial/port.hpp"
#include "polyarm/hardware/component.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::sensors {

inline constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// Shared behaviour of sensors on a serial port: each component has one sensor, with states only, and NaN for
/// unknown values. on_configure opens the port and waits until the device has identified itself; on_activate
/// reopens a lost port; read() takes what has arrived and never waits. A lost port is an error. A silent
/// device is not an error: its states become NaN, and reason() reports it.
class SerialSensor : public hardware::Component {
 public:
  hardware::CallbackReturn on_init(const hardware::ComponentContext& context) override;
  hardware::CallbackReturn on_configure() override { return open(); }
  hardware::CallbackReturn on_activate() override;
  hardware::CallbackReturn on_cleanup() override { return close(); }
  hardware::CallbackReturn on_shutdown() override { return close(); }
  hardware::CallbackReturn on_error() override { return close(); }
  std::vector<hardware::InterfaceDescription> state_interfaces() const override;
  std::vector<hardware::InterfaceDescription> command_interfaces() const override { return {}; }
  hardware::ReturnType read(const hardware::Cycle& cycle, std::span<double> states) noexcept override;
  hardware::ReturnType write(const hardware::Cycle&, std::span<const double>) noexcept override {
    return hardware::ReturnType::ok;
  }
  bool blocks() const noexcept override { return true; }
  std::string reason() const override;
  std::string summary() const override { return summary_; }

 protected:
  using Clock = Nanoseconds (*)() noexcept;
  /// `interfaces`: all states of the device, without the sensor's name; `sensor`: its name without a
  /// description.
  SerialSensor(std::span<const char* const> interfaces, const char* sensor, Clock clock);

  /// Reads the device's own parameters; problems are collected.
  virtual void read_parameters(hardware::DriverParameters& parameters) = 0;
  /// Identifies and sets up the device; the port is open. Returns the reason of a failure, or "".
  virtual std::string identify() = 0;
  /// Processes bytes that have arrived. Real-time.
  virtual void take(std::span<const std::uint8_t> bytes) noexcept = 0;
  /// Sets values older than the timeout to unknown; true if there are any. Real-time.
  virtual bool expire(Nanoseconds now) noexcept = 0;
  /// Sets all values to unknown, and drops a partial message. Real-time.
  virtual void forget() noexcept = 0;

  /// Processes input until `done()` or the deadline (of monotonic_now()); true if done.
  template <typename Done>
  bool listen(Nanoseconds deadline, Done done) {
    while (!done()) {
      const serial::Transfer got = port_.read(buffer_, deadline);
      if (!got) return false;
      bytes_received_ += got.count;
      take(std::span(buffer_).first(got.count));
    }
    return true;
  }
  /// Sends bytes; returns the reason of a failure, or "".
  std::string send(std::span<const std::uint8_t> bytes);
  bool declared(std::size_t interface) const;  ///< True if the state is among the offered ones.
  double& value(std::size_t interface) noexcept { return values_[interface]; }
  Nanoseconds now() const noexcept { return clock_(); }
  Nanoseconds start_deadline() const noexcept { return realtime::monotonic_now() + start_timeout_; }
  const std::string& path() const noexcept { return path_; }
  const std::string& sensor() const noexcept { return sensor_; }

  int baud_ = 0;
  Nanoseconds timeout_ = 0, start_timeout_ = 0;
  std::uint64_t bytes_received_ = 0;  ///< since the port was opened
  std::string summary_;

 private:
  enum class Fault : std::uint32_t { none, gone, failed, silent };
  hardware::CallbackReturn open();
  hardware::CallbackReturn close();
  serial::Transfer drain() noexcept;
  void find_sensor(const hardware::ComponentContext& context, Problems& problems);
  void note(Fault fault, int error = 0) noexcept {
    fault_.store(static_cast<std::uint32_t>(fault) | static_cast<std::uint32_t>(error) << 8,
                 std::memory_order_relaxed);
  }

  std::span<const char* const> interfaces_;
  Clock clock_;
  std::string component_, robot_, sensor_, path_;
  std::vector<std::size_t> offered_;  ///< indices into interfaces_, in the order of the states
  std::vector<double> values_;        ///< one for each entry of interfaces_
  serial::Port port_;
  std::array<std::uint8_t, 512> buffer_{};
  std::atomic<std::uint32_t> fault_{0};  ///< Fault, and the errno above it
  std::string last_text_;                     ///< why opening the port failed
};

}  // namespace polyarm::sensors
