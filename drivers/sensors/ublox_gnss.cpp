#include "drivers/sensors/ublox_gnss.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "polyarm/base/text.hpp"

namespace polyarm::sensors {

namespace {
enum Interface : std::size_t {
  kStatus,
  kService,
  kLatitude,
  kLongitude,
  kAltitude,
  kLatitudeCovariance,
  kLongitudeCovariance,
  kAltitudeCovariance,
  kEast,
  kNorth,
  kUp,
  kSpeedAccuracy,
  kSatellites,
  kFixType,
  kFrames,
  kBad,
  kLost,
  kCount
};
constexpr const char* kInterfaces[kCount] = {"status",
                                             "service",
                                             "latitude",
                                             "longitude",
                                             "altitude",
                                             "latitude_covariance",
                                             "longitude_covariance",
                                             "altitude_covariance",
                                             "velocity.east",
                                             "velocity.north",
                                             "velocity.up",
                                             "speed_accuracy",
                                             "satellites",
                                             "fix_type",
                                             "frames",
                                             "bad_frames",
                                             "lost_bytes"};
// sensor_msgs/NavSatStatus
constexpr double kNoFix = -1, kFix = 0, kSatelliteAugmented = 1, kGroundAugmented = 2;
// The first protocol version whose receivers are configured by keys only; CFG-RATE and CFG-MSG were removed.
constexpr double kKeysFrom = 27;

constexpr hardware::DriverParameter kParameters[] = {
    {"port", hardware::ParameterKind::text, nullptr, "serial port, for example /dev/serial/by-id/usb-…"},
    {"baud", hardware::ParameterKind::number, "38400",
     "bit/s, as the receiver is set (9600 up to generation 8, 38400 since 9); over its own USB any", 1200,
     4'000'000},
    {"rate", hardware::ParameterKind::number, "5", "Hz, fixes", 0.1, 40},
    {"configure", hardware::ParameterKind::text, "auto",
     "how rate and messages are set, until the receiver is switched off: auto (by its protocol version), "
     "valset, legacy, none",
     0, 0, "auto valset legacy none"},
    {"receiver_port", hardware::ParameterKind::text, "auto",
     "with valset, the receiver's own port that the cable is on: auto (usb for /dev/ttyACM, else uart1), "
     "uart1, "
     "uart2, usb",
     0, 0, "auto uart1 uart2 usb"},
    {"timeout", hardware::ParameterKind::number, "2", "s without a message until there is no fix", 0.05,
     3600},
    {"start_timeout", hardware::ParameterKind::number, "3", "s to wait for each answer", 0.01, 60},
    {"service", hardware::ParameterKind::number, "1",
     "which systems the receiver uses, as NavSatStatus has it: GPS 1, GLONASS 2, BeiDou 4, Galileo 8, added",
     0, 15},
};
constexpr hardware::DriverFacts kFacts = {
    "sensor", "u-blox satellite receivers (generation 7 and later) on a serial port or USB",
    "messages composed from the public protocol, over a pty; never on hardware", kParameters};
}  // namespace

UbloxGnss::UbloxGnss(Clock clock) : SerialSensor(kInterfaces, "gps", clock) {}

const hardware::DriverFacts* UbloxGnss::facts() const noexcept {
  return &kFacts;
}

void UbloxGnss::read_parameters(hardware::DriverParameters& parameters) {
  rate_ = parameters.number("rate");
  configure_ = parameters.text("configure");
  receiver_port_ = parameters.text("receiver_port");
  service_ = parameters.number("service");
  constexpr double kBits = 10.0 * 100;  // size of a NAV-PVT
  if (!over_usb() && rate_ * kBits > baud_)
    parameters.problems().error("bad-value", parameters.where(),
                                format_number(rate_) + " fixes a second need " +
                                    format_number(rate_ * kBits) + " bit/s, and the port has " +
                                    std::to_string(baud_),
                                "lower the rate, or set receiver and baud higher");
  if (seconds(timeout_) * rate_ < 1)
    parameters.problems().error("bad-value", parameters.where(),
                                "the timeout of " + format_number(seconds(timeout_)) +
                                    " s ends before the next fix at " + format_number(rate_) + " Hz",
                                "give it the time of two fixes or more");
}

bool UbloxGnss::over_usb() const {
  if (receiver_port_ != "auto") return receiver_port_ == "usb";
  std::error_code error;
  const auto real = std::filesystem::weakly_canonical(path(), error);
  return real.filename().string().starts_with("ttyACM");
}

bool UbloxGnss::ask_version() {
  const auto poll = ubx_message(kMonVer, {});
  const Nanoseconds deadline = start_deadline();
  for (int tries = 0; tries < 3 && !has_version_;
       ++tries) {  // the receiver may be busy with another task, so retries
    if (!send(poll).empty()) return false;
    listen(tries == 2 ? deadline : std::min(deadline, realtime::monotonic_now() + start_timeout_ / 3),
           [this] { return has_version_; });
  }
  return has_version_;
}

std::string UbloxGnss::no_answer() const {
  const std::string device = "the satellite receiver on " + path();
  if (bytes_received_ == 0)
    return device + " sends nothing: check its power, and that TX goes to RX in both directions";
  if (reader_.counts().messages == 0 && reader_.counts().skipped_bytes > 0)
    return device + " does not answer in UBX: is its rate " + std::to_string(baud_) +
           " bit/s (9600 up to generation 8, 38400 since 9), and is RX connected?";
  return device + " sends, but does not answer: is its RX connected to TX of the port?";
}

std::string UbloxGnss::command(UbxId id, std::span<const std::uint8_t> message) {
  for (int tries = 0; tries < 2; ++tries) {
    asked_ = id;
    answer_ = Answer::none;
    if (std::string failed = send(message); !failed.empty()) return failed;
    listen(start_deadline(), [this] { return answer_ != Answer::none; });
    if (answer_ == Answer::accepted) return {};
    if (answer_ == Answer::refused) break;
  }
  const std::string device = "the satellite receiver on " + path();
  if (answer_ == Answer::none)
    return device + " does not answer when its rate is set; switch it off and on, or set configure to none";
  return device + " refused " + format_number(rate_) + " fixes a second on its port" +
         (id == kCfgValset
              ? std::string(over_usb() ? " usb" : " uart") + ": lower the rate, or set receiver_port"
              : std::string(": lower the rate")) +
         ", or set configure to none";
}

std::string UbloxGnss::set_up(bool by_keys) {
  const auto period = static_cast<std::uint16_t>(std::lround(1000 / rate_));
  if (by_keys) {
    ReceiverPort port = over_usb() ? ReceiverPort::usb : ReceiverPort::uart1;
    if (receiver_port_ == "uart2") port = ReceiverPort::uart2;
    return command(kCfgValset, cfg_valset(period, port));
  }
  if (std::string failed = command(kCfgRate, cfg_rate(period)); !failed.empty()) return failed;
  return command(kCfgMsg, cfg_msg(kNavPvt, 1));
}

std::string UbloxGnss::identify() {
  struct During {
    bool& flag;
    ~During() { flag = false; }
  } during{identifying_};
  identifying_ = true;
  has_version_ = false;
  version_ = {};
  heard_ = now();
  if (!ask_version()) return no_answer();
  const double protocol = parse_number(version_.protocol).value_or(0);
  if (configure_ != "none") {
    const bool by_keys = configure_ == "valset" || (configure_ == "auto" && protocol >= kKeysFrom);
    if (std::string failed = set_up(by_keys); !failed.empty()) return failed;
  }
  heard_ = now();
  summary_ = "u-blox receiver on " + path() + ", firmware " + version_.software +
             (version_.protocol.empty() ? "" : ", protocol " + version_.protocol);
  return {};
}

void UbloxGnss::no_fix() noexcept {
  for (std::size_t i = 0; i < kFrames; ++i) value(i) = kUnknown;
  value(kStatus) = kNoFix;
  value(kService) = service_;
}

void UbloxGnss::take(const NavPvt& fix) noexcept {
  fixes_ = true;
  heard_ = now();
  no_fix();
  value(kSatellites) = fix.satellites;
  value(kFixType) = fix.fix_type;
  // Dead reckoning counts: within the accuracy limits it is a valid position.
  if (!fix.fix_ok || fix.invalid_position || fix.fix_type < 1 || fix.fix_type > 4) return;
  value(kStatus) = fix.carrier > 0 ? kGroundAugmented : fix.differential ? kSatelliteAugmented : kFix;
  value(kLatitude) = fix.latitude;
  value(kLongitude) = fix.longitude;
  value(kLatitudeCovariance) = value(kLongitudeCovariance) =
      fix.horizontal_accuracy * fix.horizontal_accuracy;
  value(kEast) = fix.velocity_east;
  value(kNorth) = fix.velocity_north;
  value(kSpeedAccuracy) = fix.speed_accuracy;
  if (fix.fix_type == 2) return;  // the height is assumed, not measured
  value(kAltitude) = fix.height;
  value(kAltitudeCovariance) = fix.vertical_accuracy * fix.vertical_accuracy;
  value(kUp) = -fix.velocity_down;
}

void UbloxGnss::take(const UbxMessage& message) noexcept {
  if (message.id == kNavPvt) {
    if (const auto fix = read_nav_pvt(message.payload)) take(*fix);
    return;
  }
  if (!identifying_) return;  // the following code may allocate
  if (message.id == kMonVer && message.payload.size() >= 40) {
    version_ = read_mon_ver(message.payload);
    has_version_ = true;
  } else if ((message.id == kAckAck || message.id == kAckNak) && message.payload.size() == 2 &&
             asked_ == UbxId{message.payload[0], message.payload[1]}) {
    answer_ = message.id == kAckAck ? Answer::accepted : Answer::refused;
  }
}

void UbloxGnss::take(std::span<const std::uint8_t> bytes) noexcept {
  reader_.take(bytes, [this](const UbxMessage& message) { take(message); });
  const UbxReader::Counts& counts = reader_.counts();
  value(kFrames) = static_cast<double>(counts.messages);
  value(kBad) = static_cast<double>(counts.bad_sums);
  value(kLost) = static_cast<double>(counts.skipped_bytes);
}

bool UbloxGnss::expire(Nanoseconds now) noexcept {
  if (now - heard_ <= timeout_) return false;
  if (fixes_) no_fix();
  fixes_ = false;
  return true;
}

void UbloxGnss::forget() noexcept {
  reader_ = {};
  fixes_ = false;
  no_fix();
  value(kFrames) = value(kBad) = value(kLost) = kUnknown;
}

}  // namespace polyarm::sensors
