#pragma once
/// Joints driven by servos on a serial line, for any family.
#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "drivers/servo_bus/bus.hpp"
#include "drivers/servo_bus/setup.hpp"
#include "drivers/servo_bus/watchdog.hpp"
#include "drivers/watchdog/link.hpp"
#include "polyarm/hardware/component.hpp"

namespace polyarm::servo_bus {

/// States of each joint, as declared: position (rad), velocity (rad/s), effort (fraction of full load, or A,
/// times `effort_scale`), current (A), temperature (°C), voltage (V). One command for each: position,
/// velocity or current, by its mode.
///
/// Activation starts from the present positions: goal = measured, then torque on. Deactivation stops and
/// holds: torque stays on. Torque goes off only at shutdown, only with `torque_off: on_shutdown`, and slowly.
/// After an error the joints are commanded to hold their positions, as far as they can be reached.
///
/// With `by_hand: true` it has no commands: activation switches the torque off, slowly if it was on, and the
/// joints are only measured.
///
/// If joints would keep turning without a master, and wherever `watchdog: on` is set, a separate process
/// stops them when this one dies or hangs. After a hang nothing is sent until on_activate.
class ServoComponent : public hardware::Component {
 public:
  /// `watchdog`: the path of the program.
  ServoComponent(const Family& family, std::unique_ptr<Protocol> protocol,
                 std::string watchdog = watchdog::find_program(kServoWatchdog))
      : family_(family), bus_(family, std::move(protocol)), program_(std::move(watchdog)) {}
  ~ServoComponent() override;

  hardware::CallbackReturn on_init(const hardware::ComponentContext& context) override;
  hardware::CallbackReturn on_configure() override;
  hardware::CallbackReturn on_activate() override;
  hardware::CallbackReturn on_deactivate() override;
  hardware::CallbackReturn on_cleanup() override;
  hardware::CallbackReturn on_shutdown() override;
  hardware::CallbackReturn on_error() override;
  std::vector<hardware::InterfaceDescription> state_interfaces() const override;
  std::vector<hardware::InterfaceDescription> command_interfaces() const override;
  hardware::ReturnType read(const hardware::Cycle& cycle, std::span<double> states) noexcept override;
  hardware::ReturnType write(const hardware::Cycle& cycle,
                             std::span<const double> commands) noexcept override;
  bool real() const noexcept override { return true; }
  bool blocks() const noexcept override { return true; }
  std::string reason() const override;
  const hardware::DriverFacts* facts() const noexcept override;
  std::string summary() const override;

  const LineCounters& counters() const noexcept { return bus_.counters(); }
  int watchdog_process() const noexcept { return watchdog_.process(); }

 protected:
  BusSetup& setup() noexcept { return setup_; }

 private:
  static constexpr std::size_t kMost = ServoBus::kMostServos;
  enum class Quantity : std::uint8_t { position, velocity, effort, current, temperature, voltage };
  struct Place {
    std::size_t joint;
    Quantity quantity;
  };
  /// The data of a joint's servo.
  struct Servo {
    int model = 0, firmware = 0;
    int min = 0, max = 0;        ///< steps
    double current_unit = 0;     ///< A; 0: it reports load
    double velocity_unit = 0;    ///< rad/s
    double max_temperature = 0;  ///< °C
    double min_voltage = 0, max_voltage = 0;
    double stall_effort = 0;
    int soft_limit = 0;  ///< as found or set at activation
    // measured values
    int steps = 0;
    std::array<double, 6> values{};
    unsigned status = 0;
    // of the present cycle
    int lost = 0;
    int goal = 0;
    double stalled_for = 0;
  };
  enum class FaultKind : std::uint8_t {
    none,
    lost,
    gone,
    failed,
    alarm,
    hot,
    stalled,
    watchdog,
    stood_still
  };

  bool fetch(std::size_t joint, const Register& reg, std::int32_t& value);
  bool identify(std::size_t joint, Problems& problems);
  void find_limits(std::size_t joint, Problems& problems);
  bool measure_all();
  void check_before_torque(std::size_t joint, Problems& problems) const;
  bool enable(std::size_t joint, Problems& problems);
  bool set_mode(std::size_t joint, Problems& problems);
  hardware::CallbackReturn let_go(Problems& problems);
  bool hold() noexcept;
  bool start_watchdog(Problems& problems);
  bool fine(watchdog::Health health) noexcept;
  bool servos_have_waited() noexcept;
  bool send_goals(std::span<const double> commands) noexcept;
  void leave_watchdog() noexcept;
  watchdog::Names watchdog_names() const;
  void lower() noexcept;
  void take(std::size_t joint, Bytes block, std::uint8_t error) noexcept;
  void watch(std::size_t joint, double dt) noexcept;
  void fault(FaultKind kind, std::uint32_t joints, unsigned detail) noexcept;
  int goal_of(std::size_t joint, double command) const noexcept;
  std::string who(std::size_t joint) const;
  hardware::CallbackReturn refuse(const Problems& problems);

  const Family& family_;
  std::mutex mutex_;  // guards the bus and the data of its servos
  ServoBus bus_;
  std::string name_;
  BusSetup setup_;
  std::vector<Servo> servos_;
  std::vector<std::uint8_t> ids_;
  std::vector<Place> places_;
  std::vector<std::uint8_t> block_;
  std::array<Reply, kMost> replies_{};
  bool active_ = false;
  std::string program_;
  watchdog::Link watchdog_;
  bool held_ = true;                     ///< after the last hold(): all joints have confirmed it
  Nanoseconds last_written_ = 0;         ///< of monotonic_now(); 0: never
  std::string refusal_;                  ///< of the last callback
  std::atomic<std::uint64_t> fault_{0};  ///< kind, detail, joints
};

}  // namespace polyarm::servo_bus
