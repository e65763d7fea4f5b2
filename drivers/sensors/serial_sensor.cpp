#include "drivers/sensors/serial_sensor.hpp"

#include <algorithm>

#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::sensors {

using hardware::CallbackReturn;
using hardware::ReturnType;

SerialSensor::SerialSensor(std::span<const char* const> interfaces, const char* sensor, Clock clock)
    : interfaces_(interfaces), clock_(clock), sensor_(sensor), values_(interfaces.size(), kUnknown) {}

void SerialSensor::find_sensor(const hardware::ComponentContext& context, Problems& problems) {
  if (context.robots.size() != 1) {
    problems.error("bad-hardware", {}, "'" + context.name + "' needs one robot that carries it",
                   "name the driver in one <ros2_control> block");
    return;
  }
  robot_ = context.robots.front().name;
  offered_.clear();
  const description::ComponentInfo* found = nullptr;
  for (const description::HardwareInfo& block : context.robots.front().hardware)
    for (const description::ComponentInfo& part : block.components) {
      if (part.kind != "sensor" || found)
        problems.error(
            "bad-hardware", part.where,
            "'" + context.name + "' is one sensor, it has no " + part.kind + " '" + part.name + "'",
            "give each device a <ros2_control> block of its own");
      else
        found = &part;
    }
  if (!found) {
    for (std::size_t i = 0; i < interfaces_.size(); ++i) offered_.push_back(i);
    return;
  }
  sensor_ = found->name;
  const std::vector<std::string> known(interfaces_.begin(), interfaces_.end());
  for (const description::InterfaceInfo& state : found->state_interfaces) {
    const auto at = std::find(known.begin(), known.end(), state.name);
    if (at != known.end())
      offered_.push_back(static_cast<std::size_t>(at - known.begin()));
    else
      problems.error("unknown-interface", state.where,
                     "'" + sensor_ + "' has no state '" + state.name + "'" + did_you_mean(state.name, known),
                     "it has: " + join(known, ", "));
  }
  for (const description::InterfaceInfo& command : found->command_interfaces)
    problems.error("unknown-interface", command.where, "'" + sensor_ + "' takes no commands, it measures",
                   "remove the command interface '" + command.name + "'");
}

CallbackReturn SerialSensor::on_init(const hardware::ComponentContext& context) {
  component_ = context.name;
  hardware::DriverParameters parameters(*facts(), context);
  path_ = parameters.text("port");
  baud_ = static_cast<int>(parameters.number("baud"));
  timeout_ = nanoseconds(parameters.number("timeout"));
  start_timeout_ = nanoseconds(parameters.number("start_timeout"));
  read_parameters(parameters);
  find_sensor(context, parameters.problems());
  parameters.problems().throw_if_errors();
  return CallbackReturn::success;
}

std::vector<hardware::InterfaceDescription> SerialSensor::state_interfaces() const {
  std::vector<hardware::InterfaceDescription> out;
  for (const std::size_t i : offered_) out.push_back({robot_ + "/" + sensor_ + "/" + interfaces_[i]});
  return out;
}

bool SerialSensor::declared(std::size_t interface) const {
  return std::find(offered_.begin(), offered_.end(), interface) != offered_.end();
}

CallbackReturn SerialSensor::open() {
  port_.close();
  note(Fault::none);
  last_text_.clear();
  bytes_received_ = 0;
  forget();
  try {
    serial::PortOptions options;
    options.path = path_;
    options.baud = baud_;
    options.holder = "component " + component_;
    port_ = serial::Port(options);
    last_text_ = identify();
  } catch (const Error& e) {
    last_text_ = e.what();
  }
  if (last_text_.empty()) return CallbackReturn::success;
  port_.close();
  return CallbackReturn::failure;
}

CallbackReturn SerialSensor::close() {
  port_.close();
  forget();
  return CallbackReturn::success;
}

CallbackReturn SerialSensor::on_activate() {
  return port_.is_open() ? CallbackReturn::success : open();
}

std::string SerialSensor::send(std::span<const std::uint8_t> bytes) {
  const serial::Transfer sent = port_.write(bytes, realtime::monotonic_now() + 1'000'000'000);
  return sent ? std::string() : path_ + ": " + serial::explain(sent.status, sent.error);
}

/// Reads all pending input, up to more than any sensor sends in a cycle.
serial::Transfer SerialSensor::drain() noexcept {
  for (int rounds = 0; rounds < 64; ++rounds) {
    const serial::Transfer got = port_.read(buffer_, 0);
    if (got.status == serial::Status::timeout) return {};
    if (!got) return got;
    bytes_received_ += got.count;
    take(std::span(buffer_).first(got.count));
  }
  return {};
}

ReturnType SerialSensor::read(const hardware::Cycle&, std::span<double> states) noexcept {
  const serial::Transfer got = port_.is_open() ? drain() : serial::Transfer{serial::Status::gone, 0, 0};
  if (!got) {
    forget();
    note(got.status == serial::Status::gone ? Fault::gone : Fault::failed, got.error);
  } else {
    note(expire(now()) ? Fault::silent : Fault::none);
  }
  for (std::size_t i = 0; i < offered_.size(); ++i) states[i] = values_[offered_[i]];
  return got ? ReturnType::ok : ReturnType::error;
}

std::string SerialSensor::reason() const {
  const std::uint32_t word = fault_.load(std::memory_order_relaxed);
  const int error = static_cast<int>(word >> 8);
  const std::string device = "the sensor '" + sensor_ + "' on " + path_;
  switch (static_cast<Fault>(word & 0xFF)) {
    case Fault::none:
      return last_text_;
    case Fault::gone:
      return device + ": " + serial::explain(serial::Status::gone, error);
    case Fault::failed:
      return device + ": " + serial::explain(serial::Status::failed, error);
    case Fault::silent:
      return device + " has been silent for " + format_number(seconds(timeout_)) +
             " s: check its power and its wires";
  }
  return {};
}

}  // namespace polyarm::sensors
