#include "drivers/pca9685/component.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>

#include "drivers/pca9685/watchdog.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::drivers {

using hardware::CallbackReturn;
using hardware::ReturnType;

namespace {
/// Number of attempts of a stop command before the watchdog takes over.
constexpr int kOffTries = 3;
constexpr double kCheckEvery = 0.1;  // s between two checks of the chip

std::string hex(int value) {
  constexpr char kDigits[] = "0123456789ABCDEF";
  return std::string("0x") + kDigits[(value >> 4) & 15] + kDigits[value & 15];
}

/// Resolves links, because two names of one bus are one device.
std::string device_name(const BoardSettings& settings) {
  std::error_code error;
  const auto whole = std::filesystem::weakly_canonical(settings.bus, error);
  return (error ? settings.bus : whole.string()) + ":" + hex(settings.address);
}
}  // namespace

BoardEnvironment real_board() {
  return {[](const std::string& path, std::uint8_t address, BusFailure& failure) {
            return open_linux_bus(path, address, failure);
          },
          watchdog::find_program(kPca9685Watchdog)};
}

Pca9685Component::~Pca9685Component() {
  const std::lock_guard guard(mutex_);
  close();
}

// --- life cycle

CallbackReturn Pca9685Component::on_init(const hardware::ComponentContext& context) {
  name_ = context.name;
  settings_ = read_settings(context);
  motors_.assign(settings_.wheels.size(), {});
  watchdog_.expect(settings_.watchdog_ms, settings_.period);
  check_every_ =
      static_cast<std::uint64_t>(std::max(1.0, std::floor(kCheckEvery / std::max(settings_.period, 1e-6))));
  return CallbackReturn::success;
}

CallbackReturn Pca9685Component::on_configure() {
  const std::lock_guard guard(mutex_);
  close();
  note(Trouble::none, 0);
  if (configure() == CallbackReturn::success) return CallbackReturn::success;
  close();
  return CallbackReturn::failure;
}

bool Pca9685Component::open() {
  try {
    lock_ = hardware::DeviceLock(device_name(settings_), "component " + name_);
  } catch (const Error& e) {
    lock_refusal_ = e.what();
    note(Trouble::lock, 0);
    return false;
  }
  BusFailure failure;
  bus_ = environment_.open(settings_.bus, settings_.address, failure);
  if (!bus_) {
    note(Trouble::bus, static_cast<std::uint8_t>(failure.step), 0, 0, failure.error);
    return false;
  }
  chip_ = std::make_unique<Pca9685>(*bus_);
  return true;
}

CallbackReturn Pca9685Component::configure() {
  if (!open() || !ok(chip_->identify()) || !ok(chip_->off())) return CallbackReturn::failure;
  const WatchdogSettings watched{settings_.bus, settings_.address, settings_.watchdog_ms,
                                 static_cast<int>(std::ceil(1e6 / frequency_of(settings_.prescale)))};
  if (!ok(watchdog_.start(environment_.watchdog, words_of(watched))) || !ok(chip_->start(settings_.prescale)))
    return CallbackReturn::failure;
  for (Motor& motor : motors_) motor = {{}, 0, motor.position};
  failed_ = false;
  return CallbackReturn::success;
}

CallbackReturn Pca9685Component::on_activate() {
  const std::lock_guard guard(mutex_);
  if (!chip_ || failed_) return CallbackReturn::error;
  if (!ok(watchdog_.listen()) || !ok(chip_->check()) || !all_off() || !ok(watchdog_.arm()))
    return CallbackReturn::error;
  since_check_ = 0;
  driving_ = true;
  return CallbackReturn::success;
}

CallbackReturn Pca9685Component::on_deactivate() {
  const std::lock_guard guard(mutex_);
  driving_ = false;
  if (!chip_ || failed_) return CallbackReturn::success;  // already off
  if (!all_off() || !ok(watchdog_.disarm())) {
    stop_for_failure();
    return CallbackReturn::error;
  }
  return CallbackReturn::success;
}

CallbackReturn Pca9685Component::on_cleanup() {
  const std::lock_guard guard(mutex_);
  close();
  return CallbackReturn::success;
}

CallbackReturn Pca9685Component::on_shutdown() {
  return on_cleanup();
}

CallbackReturn Pca9685Component::on_error() {
  return on_cleanup();  // configuring it again starts with an identification of the chip
}

/// Switches motors off; if the chip does not accept that, the watchdog keeps trying.
void Pca9685Component::close() noexcept {
  driving_ = false;
  if (chip_) {
    const std::uint64_t before = trouble_.load(std::memory_order_relaxed);
    const bool off = all_off();
    if (before != 0) trouble_.store(before, std::memory_order_relaxed);  // the first failure is the reason
    if (!off) watchdog_.abandon();
  }
  watchdog_.stop();
  chip_.reset();
  bus_.reset();
  lock_ = hardware::DeviceLock();
}

// --- cycles

ReturnType Pca9685Component::read(const hardware::Cycle& cycle, std::span<double> states) noexcept {
  const std::lock_guard guard(mutex_);
  for (Motor& motor : motors_) motor.position += motor.velocity * seconds(cycle.period);
  for (std::size_t k = 0; k < states.size(); ++k) {
    const Motor& motor = motors_[settings_.state_of[k].wheel];
    states[k] = settings_.state_of[k].position ? motor.position : motor.velocity;
  }
  if (failed_) return ReturnType::error;
  if (!chip_ || ++since_check_ < check_every_) return ReturnType::ok;
  since_check_ = 0;
  return ok(watchdog_.listen()) && ok(chip_->check()) ? ReturnType::ok : stop_for_failure();
}

ReturnType Pca9685Component::write(const hardware::Cycle&, std::span<const double> commands) noexcept {
  const std::lock_guard guard(mutex_);
  if (failed_) return ReturnType::error;
  if (!driving_) return ReturnType::ok;
  // First checks the watchdog: after a hang the commands are old.
  const bool fine = ok(watchdog_.listen()) && drive_all(commands) && ok(watchdog_.beat());
  return fine ? ReturnType::ok : stop_for_failure();
}

bool Pca9685Component::drive_all(std::span<const double> commands) noexcept {
  for (std::size_t k = 0; k < commands.size(); ++k) {
    const std::size_t wheel = settings_.wheel_of_command[k];
    if (std::isinf(commands[k])) {
      note(Trouble::command, static_cast<std::uint8_t>(wheel));
      return false;
    }
    const MotorOutput output =
        std::isnan(commands[k]) ? release_now() : drive_at(settings_.wheels[wheel].motor, commands[k]);
    if (!ok(apply(wheel, output.drive))) return false;
    motors_[wheel].velocity = output.velocity;
  }
  return true;
}

/// Sends only changes. Directions change while the motor is off.
ChipFailure Pca9685Component::apply(std::size_t wheel, const MotorDrive& drive) noexcept {
  const MotorSettings& pins = settings_.wheels[wheel].motor;
  MotorDrive& now = motors_[wheel].applied;
  if (drive == now) return {};
  const bool turns = drive.positive != now.positive || drive.negative != now.negative;
  if (turns && now.enable != 0) {
    if (const ChipFailure f = chip_->set(pins.enable, 0)) return f;
    now.enable = 0;
  }
  if (turns) {
    if (const ChipFailure f = chip_->set(pins.positive, drive.positive)) return f;
    if (const ChipFailure f = chip_->set(pins.negative, drive.negative)) return f;
  }
  if (drive.enable != now.enable)
    if (const ChipFailure f = chip_->set(pins.enable, drive.enable)) return f;
  now = drive;
  return {};
}

bool Pca9685Component::all_off() noexcept {
  ChipFailure failure;
  for (int tries = 0; tries < kOffTries; ++tries) {
    failure = chip_->off();
    if (failure) continue;
    for (Motor& motor : motors_) motor = {{}, 0, motor.position};
    return true;
  }
  return ok(failure);
}

ReturnType Pca9685Component::stop_for_failure() noexcept {
  driving_ = false;
  failed_ = true;
  const std::uint64_t before = trouble_.load(std::memory_order_relaxed);
  const bool off = all_off();
  if (before != 0) trouble_.store(before, std::memory_order_relaxed);
  if (!off) watchdog_.abandon();
  for (Motor& motor : motors_) motor.velocity = 0;
  return ReturnType::error;
}

// --- what went wrong

void Pca9685Component::note(Trouble trouble, std::uint8_t step, std::uint8_t where, std::uint8_t value,
                            int error) noexcept {
  trouble_.store(static_cast<std::uint64_t>(trouble) | static_cast<std::uint64_t>(step) << 8 |
                     static_cast<std::uint64_t>(where) << 16 | static_cast<std::uint64_t>(value) << 24 |
                     static_cast<std::uint64_t>(static_cast<std::uint32_t>(error)) << 32,
                 std::memory_order_relaxed);
}

bool Pca9685Component::ok(const ChipFailure& failure) noexcept {
  if (!failure) return true;
  note(Trouble::chip, static_cast<std::uint8_t>(failure.step), failure.where, failure.value, failure.error);
  return false;
}

bool Pca9685Component::ok(watchdog::Health health) noexcept {
  if (health == watchdog::Health::fine) return true;
  note(Trouble::watchdog, static_cast<std::uint8_t>(health));
  return false;
}

std::string Pca9685Component::place() const {
  return "the motor board at " + settings_.bus + " " + hex(settings_.address);
}

std::string Pca9685Component::bus_reason(std::uint8_t step, int error) const {
  using Step = BusFailure::Step;
  const std::string why = std::strerror(error);
  switch (static_cast<Step>(step)) {
    case Step::open:
      if (error == EACCES)
        return settings_.bus + " may not be opened: " + why +
               "; join the group: sudo usermod -aG i2c $USER, "
               "and log in again";
      return settings_.bus + " cannot be opened: " + why +
             "; switch I2C on (raspi-config, or the device tree) "
             "and see `ls /dev/i2c-*`";
    case Step::functions:
      return settings_.bus + " is no I2C bus: " + why + "; see `ls /dev/i2c-*`";
    case Step::not_plain:
      return settings_.bus + " knows SMBus alone, the board needs plain I2C; use another bus";
    case Step::address:
      if (error == EBUSY)
        return "a driver of the kernel has " + hex(settings_.address) + " at " + settings_.bus +
               "; unbind it (pwm-pca9685)";
      return settings_.bus + " does not take the address " + hex(settings_.address) + ": " + why;
    case Step::none:
      break;
  }
  return settings_.bus + " cannot be opened";
}

std::string Pca9685Component::chip_reason(std::uint8_t step, std::uint8_t where, std::uint8_t value,
                                          int error) const {
  using Step = ChipFailure::Step;
  if (error != 0) {
    std::string doing = "did not answer";
    if (static_cast<Step>(step) == Step::off) doing = "did not accept the command to turn all motors off";
    for (const Wheel& wheel : settings_.wheels)
      for (const int channel : {wheel.motor.enable, wheel.motor.positive, wheel.motor.negative})
        if (static_cast<Step>(step) == Step::drive && where == pca9685::kLed0 + 4 * channel)
          doing = "did not take a command for " + wheel.joint;
    return place() + " " + doing + " (register " + hex(where) + ": " + std::strerror(error) +
           "); check its power and the two wires, `i2cdetect -y` shows which devices answer";
  }
  const std::string found = "(register " + hex(where) + " reads " + hex(value) + ")";
  if (static_cast<Step>(step) == Step::check)
    return place() + " has lost its settings " + found +
           ": its power failed, or something else speaks to it; "
           "correct that, then activate it again";
  if (static_cast<Step>(step) == Step::identify)
    return "what answers at " + settings_.bus + " " + hex(settings_.address) + " is no PCA9685 " + found +
           "; check the address";
  return place() + " did not keep what was written " + found + "; check its power and the two wires";
}

std::string Pca9685Component::watchdog_reason(std::uint8_t step) const {
  return watchdog::sentence(static_cast<watchdog::Health>(step),
                            {kPca9685Watchdog, place(), settings_.bus, "motors are off",
                             "turned the motors of " + place() + " off", settings_.watchdog_ms});
}

std::string Pca9685Component::reason() const {
  const std::uint64_t word = trouble_.load(std::memory_order_relaxed);
  const auto byte = [&](int k) { return static_cast<std::uint8_t>(word >> (8 * k)); };
  const int error = static_cast<int>(word >> 32);
  switch (static_cast<Trouble>(byte(0))) {
    case Trouble::none:
      return {};
    case Trouble::lock:
      return lock_refusal_;
    case Trouble::bus:
      return bus_reason(byte(1), error);
    case Trouble::chip:
      return chip_reason(byte(1), byte(2), byte(3), error);
    case Trouble::watchdog:
      return watchdog_reason(byte(1));
    case Trouble::command:
      return "the command for " + settings_.wheels[byte(1)].joint +
             " was infinite; motors are off; correct the controller";
  }
  return {};
}

const hardware::DriverFacts* Pca9685Component::facts() const noexcept {
  return &board_facts();
}

std::string Pca9685Component::summary() const {
  return place() + ": " + std::to_string(settings_.wheels.size()) + " motors, pulses at " +
         std::to_string(std::lround(frequency_of(settings_.prescale))) + " Hz, watchdog after " +
         std::to_string(settings_.watchdog_ms) + " ms; velocities are those commanded, there is no encoder";
}

}  // namespace polyarm::drivers
