#include "drivers/sensors/serial_imu.hpp"

#include <cmath>

#include "polyarm/base/pose.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::sensors {

namespace {
constexpr const char* kInterfaces[] = {"orientation.x",
                                       "orientation.y",
                                       "orientation.z",
                                       "orientation.w",
                                       "angular_velocity.x",
                                       "angular_velocity.y",
                                       "angular_velocity.z",
                                       "linear_acceleration.x",
                                       "linear_acceleration.y",
                                       "linear_acceleration.z",
                                       "temperature",
                                       "frames",
                                       "bad_frames",
                                       "lost_bytes"};
constexpr std::size_t kFirst[] = {0, 4, 7, 10}, kTemperature = 10, kFrames = 11, kBad = 12, kLost = 13;

constexpr double kGravity = 9.80665, kPi = 3.14159265358979323846;

constexpr hardware::DriverParameter kParameters[] = {
    {"port", hardware::ParameterKind::text, nullptr, "serial port, for example /dev/serial/by-id/usb-…"},
    {"baud", hardware::ParameterKind::number, "9600", "bit/s, as the sensor is set", 1200, 4'000'000},
    {"timeout", hardware::ParameterKind::number, "0.5", "s without a frame until its states are NaN", 0.01,
     3600},
    {"start_timeout", hardware::ParameterKind::number, "3", "s to wait for the first frames", 0.01, 60},
    {"configure", hardware::ParameterKind::boolean, "false",
     "set what the sensor sends, and its rate, until it is switched off; else it is left as it is"},
    {"rate", hardware::ParameterKind::number, "50", "Hz, with configure: 1, 2, 5, 10, 20, 50, 100 or 200", 1,
     200},
};
constexpr hardware::DriverFacts kFacts = {
    "sensor", "inertial sensors of the WIT standard protocol (WT901, HWT905, JY901) on a serial port",
    "frames composed from the public protocol, over a pty; never on hardware", kParameters};

double scaled(std::int16_t value, double full_scale) {
  return value * full_scale / 32768.0;
}
}  // namespace

SerialImu::SerialImu(Clock clock) : SerialSensor(kInterfaces, "imu", clock) {}

const hardware::DriverFacts* SerialImu::facts() const noexcept {
  return &kFacts;
}

void SerialImu::read_parameters(hardware::DriverParameters& parameters) {
  configure_ = parameters.boolean("configure");
  rate_ = parameters.number("rate");
  if (wit_rate_code(rate_) == 0)
    parameters.problems().error("bad-value", parameters.where(),
                                "a WIT sensor has no rate of " + format_number(rate_) + " Hz",
                                "it has 1, 2, 5, 10, 20, 50, 100 and 200 Hz");
  constexpr double kBitsAFrame = 10.0 * kWitFrameSize;
  if (configure_ && rate_ * 3 * kBitsAFrame > baud_)
    parameters.problems().error("bad-value", parameters.where(),
                                "three frames at " + format_number(rate_) + " Hz need " +
                                    format_number(rate_ * 3 * kBitsAFrame) + " bit/s, and the port has " +
                                    std::to_string(baud_),
                                "lower the rate, or set sensor and baud higher");
}

bool SerialImu::wanted(Group group) const {
  for (std::size_t i = kFirst[group]; i < kFirst[group + 1]; ++i)
    if (declared(i)) return true;
  return false;
}

std::string SerialImu::set_up() {
  const std::uint16_t content = kWitContentAcceleration | kWitContentVelocity | kWitContentQuaternion;
  const std::pair<std::uint8_t, std::uint16_t> steps[] = {
      {kWitKey, kWitUnlock}, {kWitContent, content}, {kWitRate, wit_rate_code(rate_)}};
  for (const auto& [address, value] : steps) {
    if (std::string failed = send(wit_write(address, value)); !failed.empty()) return failed;
    constexpr Nanoseconds kPause = 20'000'000;  // the sensor processes one command after the other
    listen(realtime::monotonic_now() + kPause, [] { return false; });
  }
  known_ = {};
  return {};
}

std::string SerialImu::what_is_missing() const {
  const std::string device = "the inertial sensor on " + path();
  if (bytes_received_ == 0)
    return device + " sends nothing: check its power, and that its TX goes to RX of the port";
  if (reader_.counts().frames == 0)
    return device + " sends bytes that are no WIT frames: is its rate " + std::to_string(baud_) +
           " bit/s? Most are set to 9600 or 115200";
  std::string missing;
  const char* names[] = {"orientation", "angular velocity", "linear acceleration"};
  for (int group = 0; group < group_count; ++group)
    if (wanted_[static_cast<std::size_t>(group)] && !known_[static_cast<std::size_t>(group)])
      missing += (missing.empty() ? "" : " and ") + std::string(names[group]);
  return device + " sends no " + missing +
         ": set configure to true, or its output content with the maker's program";
}

std::string SerialImu::identify() {
  for (const Group group : {orientation, velocity, acceleration}) wanted_[group] = wanted(group);
  if (configure_)
    if (std::string failed = set_up(); !failed.empty()) return failed;
  const bool all = listen(start_deadline(), [this] {
    for (std::size_t g = 0; g < group_count; ++g)
      if (wanted_[g] && !known_[g]) return false;
    return reader_.counts().frames > 0;
  });
  if (!all) return what_is_missing();
  summary_ = "WIT inertial sensor on " + path() + (quaternions_ ? "" : ", orientation from its angles");
  return {};
}

void SerialImu::heard(Group group) noexcept {
  known_[group] = true;
  heard_[group] = now();
}

void SerialImu::set_orientation(double x, double y, double z, double w) noexcept {
  const double norm = std::sqrt(x * x + y * y + z * z + w * w);
  if (norm < 0.5) return;  // no rotation: the sensor is starting
  const double values[] = {x, y, z, w};
  for (std::size_t i = 0; i < 4; ++i) value(i) = values[i] / norm;
  heard(orientation);
}

void SerialImu::set_three(Group group, const WitFrame& frame, double full_scale) noexcept {
  for (std::size_t i = 0; i < 3; ++i) value(kFirst[group] + i) = scaled(frame.values[i], full_scale);
  heard(group);
}

void SerialImu::take(const WitFrame& frame) noexcept {
  switch (frame.type) {
    case WitType::acceleration:
      set_three(acceleration, frame, 16 * kGravity);
      value(kTemperature) = frame.values[3] / 100.0;
      break;
    case WitType::angular_velocity:
      set_three(velocity, frame, 2000 * kPi / 180);
      break;
    case WitType::quaternion: {
      quaternions_ = true;
      const auto q = [&](std::size_t i) { return scaled(frame.values[i], 1); };
      set_orientation(q(1), q(2), q(3), q(0));
      break;
    }
    case WitType::angle: {
      if (quaternions_) break;  // redundant and less exact
      const auto angle = [&](std::size_t i) { return scaled(frame.values[i], kPi); };
      const Quaternion q = from_rpy(angle(0), angle(1), angle(2));
      set_orientation(q.x, q.y, q.z, q.w);
      break;
    }
    default:
      break;
  }
}

void SerialImu::take(std::span<const std::uint8_t> bytes) noexcept {
  reader_.take(bytes, [this](const WitFrame& frame) { take(frame); });
  const WitReader::Counts& counts = reader_.counts();
  value(kFrames) = static_cast<double>(counts.frames);
  value(kBad) = static_cast<double>(counts.bad_sums);
  value(kLost) = static_cast<double>(counts.skipped_bytes);
}

bool SerialImu::expire(Nanoseconds now) noexcept {
  bool any = false;
  for (std::size_t g = 0; g < group_count; ++g) {
    if (known_[g] && now - heard_[g] > timeout_) {
      known_[g] = false;
      for (std::size_t i = kFirst[g]; i < kFirst[g + 1]; ++i) value(i) = kUnknown;
      if (g == acceleration) value(kTemperature) = kUnknown;
    }
    any = any || (wanted_[g] && !known_[g]);
  }
  return any;
}

void SerialImu::forget() noexcept {
  reader_ = {};
  known_ = {};
  quaternions_ = false;
  for (std::size_t i = 0; i < std::size(kInterfaces); ++i) value(i) = kUnknown;
}

}  // namespace polyarm::sensors
