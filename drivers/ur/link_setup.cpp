/// How a link begins: connections, protocol version, recipes, remote control.
#include <algorithm>
#include <cmath>
#include <limits>

#include "drivers/ur/link.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::ur {

namespace {

struct FieldRow {
  const char* name;
  std::size_t elements;
  bool optional;
};
constexpr FieldRow kRows[kFields] = {{"timestamp", 1, false},
                                     {"actual_q", 6, false},
                                     {"actual_qd", 6, false},
                                     {"actual_current", 6, false},
                                     {"actual_TCP_pose", 6, false},
                                     {"actual_TCP_force", 6, false},
                                     {"speed_scaling", 1, false},
                                     {"target_speed_fraction", 1, false},
                                     {"robot_mode", 1, false},
                                     {"safety_mode", 1, false},
                                     {"runtime_state", 1, false},
                                     {"actual_digital_input_bits", 1, false},
                                     {"actual_digital_output_bits", 1, false},
                                     {"standard_analog_input0", 1, false},
                                     {"standard_analog_input1", 1, false},
                                     {"standard_analog_output0", 1, false},
                                     {"standard_analog_output1", 1, false},
                                     {"output_int_register_24", 1, false},
                                     {"output_int_register_25", 1, false},
                                     {"output_int_register_26", 1, false},
                                     {"output_int_register_27", 1, false},
                                     {"actual_current_as_torque", 6, true},
                                     {"payload", 1, true}};

constexpr auto kPlaces = [] {
  std::array<std::size_t, kFields + 1> out{};
  for (std::size_t i = 0; i < kFields; ++i) out[i + 1] = out[i] + kRows[i].elements;
  return out;
}();
static_assert(kPlaces[kFields] <= kMostElements);

constexpr const char* kInputs =
    "speed_slider_mask,speed_slider_fraction,standard_digital_output_mask,standard_digital_output,"
    "configurable_digital_output_mask,configurable_digital_output,tool_digital_output_mask,tool_digital_"
    "output,"
    "standard_analog_output_mask,standard_analog_output_type,standard_analog_output_0,standard_analog_output_"
    "1";

}  // namespace

std::size_t place_of(Field field) noexcept {
  return kPlaces[field];
}

Link::Link(LinkSettings settings)
    : LinkBase("the controller at " + settings.host), settings_(std::move(settings)), pacer_(0) {
  if (settings_.forward) moves_ = std::make_unique<MoveQueue>(*settings_.forward, kMoveSlots);
}

void Link::drop() {
  for (Descriptor* one : {&rtde_, &primary_, &listener_, &stream_}) *one = Descriptor();
}

bool Link::connect(int port, Descriptor& socket) {
  std::string why;
  socket = wire::connect_tcp(settings_.host, port, settings_.connect_timeout, why);
  return socket ? true : refuse(Cause::unreachable, port, why);
}

/// Sends a request of RTDE and waits for its answer; text messages in between are kept for the reason.
std::optional<std::vector<std::uint8_t>> Link::ask(PackageType type, const wire::Writer& payload) {
  if (!wire::send_frame(rtde_.number(), frame(type, payload))) return std::nullopt;
  const Nanoseconds deadline = realtime::monotonic_now() + settings_.connect_timeout;
  std::optional<std::vector<std::uint8_t>> answer;
  std::array<std::uint8_t, 4096> bytes;
  while (!answer) {
    const Nanoseconds left = deadline - realtime::monotonic_now();
    if (left <= 0 || !wire::wait_readable(rtde_.number(), left)) return std::nullopt;
    const wire::Received got = wire::receive(rtde_.number(), bytes);
    if (got.got == wire::Got::nothing) continue;
    if (got.got != wire::Got::bytes) return std::nullopt;
    const bool whole = frames_.feed(Bytes(bytes).first(got.count), [&](PackageType came, Bytes body) {
      if (came == type && !answer) answer.emplace(body.begin(), body.end());
    });
    if (!whole) return std::nullopt;
  }
  return answer;
}

bool Link::negotiate() {
  for (protocol_ = 2; protocol_ >= 1; --protocol_) {
    wire::Writer version;
    version.u16(static_cast<std::uint64_t>(protocol_));
    const auto answer = ask(PackageType::protocol_version, version);
    if (!answer) return refuse(frames_.feed({}, [](auto, auto) {}) ? Cause::rtde_silent : Cause::bad_data);
    if (answer->size() == 1 && answer->front() == 1) break;
  }
  if (protocol_ == 0) return refuse(Cause::wrong_version);
  const auto answer = ask(PackageType::controller_version, {});
  if (!answer || answer->size() < 12) return refuse(Cause::bad_data);
  wire::Reader in(*answer);
  const std::uint32_t major = in.u32(), minor = in.u32(), bugfix = in.u32();
  version_ = std::to_string(major) + "." + std::to_string(minor) + "." + std::to_string(bugfix);
  if (major < 3 || (major == 3 && minor < 5)) return refuse(Cause::too_old, 0, version_);
  rate_ = settings_.rate > 0 ? settings_.rate : major >= 5 ? 500 : 125;
  return true;
}

bool Link::set_up_outputs() {
  std::array<bool, kFields> left_out{};
  for (int attempt = 0; attempt < 2; ++attempt) {
    wire::Writer request;
    if (protocol_ >= 2) request.f64(rate_);
    fields_.clear();
    std::string names;
    for (std::size_t i = 0; i < kFields; ++i)
      if (!left_out[i]) {
        fields_.push_back(static_cast<Field>(i));
        names += (names.empty() ? "" : ",") + std::string(kRows[i].name);
      }
    const auto answer = ask(PackageType::setup_outputs, request.text(names));
    if (!answer) return refuse(Cause::rtde_silent);
    wire::Reader in(*answer);
    recipe_ = {};
    if (protocol_ >= 2) recipe_.id = in.u8();
    const std::vector<std::string> types = split_names(in.text(in.left()));
    if (types.size() != fields_.size())
      return refuse(Cause::bad_data, 0, "an answer with other values than asked");
    bool all = true;
    for (std::size_t i = 0; i < types.size(); ++i) {
      const FieldRow& row = kRows[fields_[i]];
      const FieldType* type = find_type(types[i]);
      if (!type && row.optional) left_out[fields_[i]] = true;
      if (!type && !row.optional) return refuse(Cause::missing_value, 0, row.name);
      if (type && type->elements != row.elements)
        return refuse(Cause::bad_data, 0, std::string("type of ") + row.name);
      all = all && type;
      if (type) recipe_.add(*type);
    }
    if (all) return true;
  }
  return refuse(Cause::bad_data, 0, "values that it refuses and offers by turns");
}

/// The controller may hold the inputs of an earlier connection for a moment longer.
bool Link::set_up_inputs() {
  if (!settings_.io) return inputs_ = {}, true;
  for (int attempt = 0; attempt < 10; ++attempt) {
    if (ask_for_inputs()) return true;
    if (refused() != Cause::second_client) return false;
    wire::wait_readable(rtde_.number(), 50'000'000);
  }
  return false;
}

bool Link::ask_for_inputs() {
  inputs_ = {};
  const auto answer = ask(PackageType::setup_inputs, wire::Writer().text(kInputs));
  if (!answer || answer->empty()) return refuse(Cause::rtde_silent);
  wire::Reader in(*answer);
  if (protocol_ >= 2) inputs_.id = in.u8();
  const std::vector<std::string> types = split_names(in.text(in.left())), names = split_names(kInputs);
  if (types.size() != names.size())
    return refuse(Cause::bad_data, 0, "an answer with other inputs than asked");
  for (std::size_t i = 0; i < types.size(); ++i) {
    if (types[i] == "IN_USE") return refuse(Cause::second_client, 0, names[i]);
    const FieldType* type = find_type(types[i]);
    if (!type || type->elements != 1) return refuse(Cause::missing_value, 0, names[i]);
    inputs_.add(*type);
  }
  return true;
}

std::string Link::ask_dashboard(const std::string& line) {
  std::string why, text;
  const Descriptor socket =
      wire::connect_tcp(settings_.host, settings_.dashboard_port, settings_.connect_timeout, why);
  if (!socket) return {};
  const Nanoseconds deadline = realtime::monotonic_now() + settings_.connect_timeout;
  bool asked = false;
  std::array<std::uint8_t, 1024> bytes;
  while (text.size() < 65536) {
    const std::size_t end = text.find('\n');
    if (end != std::string::npos && asked) return std::string(trim(text.substr(0, end)));
    if (end != std::string::npos) {  // the greeting
      text.erase(0, end + 1);
      asked = wire::send_frame(socket.number(), line + "\n");
      if (!asked) return {};
      continue;
    }
    const Nanoseconds left = deadline - realtime::monotonic_now();
    if (left <= 0 || !wire::wait_readable(socket.number(), left)) return {};
    const wire::Received got = wire::receive(socket.number(), bytes);
    if (got.got == wire::Got::closed || got.got == wire::Got::failed) return {};
    text.append(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(got.count));
  }
  return {};
}

/// A dashboard without an answer is no hindrance: CB3 and old software do not know the question.
bool Link::check_remote() {
  if (!settings_.dashboard) return true;
  return ask_dashboard("is in remote control") == "false" ? refuse(Cause::not_remote) : true;
}

bool Link::open() {
  close();
  fault_.clear();
  refused_.clear();
  frames_.reset();
  messages_.reset();
  current_ = {};
  primary_lost_ = false;
  current_.values.fill(std::numeric_limits<double>::quiet_NaN());
  samples_.reset(current_);
  commands_.fetch();
  outputs_.fetch();
  {
    const std::lock_guard lock(mutex_);
    nominal_ = calibrated_ = std::nullopt;
    phase_ = Phase::idle;
  }
  std::string why;
  bool fine = connect(settings_.rtde_port, rtde_) && negotiate() && set_up_outputs() && set_up_inputs() &&
              connect(settings_.primary_port, primary_);
  if (fine) {
    const std::string own = settings_.own_address.empty() ? wire::local_address(rtde_.number()) : "0.0.0.0";
    listener_ = wire::listen_tcp(own, settings_.own_port, why);
    controller_ = wire::peer_address(rtde_.number());
    if (!listener_) fine = refuse(Cause::unreachable, 0, why);
  }
  if (fine) {
    const auto answer = ask(PackageType::start, {});
    fine = answer && answer->size() == 1 && answer->front() == 1;
    if (!fine) refuse(Cause::rtde_silent);
  }
  if (!fine) {
    drop();
    return false;
  }
  quit_ = false;
  heard_ = realtime::monotonic_now();
  thread_ = std::thread([this] { run(); });
  std::unique_lock lock(mutex_);
  // The first package, so that the states are measured when this returns.
  changed_.wait_for(lock, std::chrono::nanoseconds(settings_.connect_timeout),
                    [this] { return current_.count > 0 || fault_; });
  const bool heard = current_.count > 0 && !fault_;
  lock.unlock();
  if (heard) return true;
  if (!fault_) refuse(Cause::rtde_silent);
  close();
  return false;
}

void Link::close() {
  if (thread_.joinable()) {
    stop();
    quit_ = true;
    wake();
    thread_.join();
  }
  drop();
}

/// Neither a stop nor another program may be in the way. A program of ours that is just ending is waited for.
bool Link::check_robot() {
  std::unique_lock lock(mutex_);
  const auto value = [this](Field field) { return static_cast<int>(current_[field]); };
  changed_.wait_for(lock, std::chrono::nanoseconds(settings_.start_timeout), [&] {
    return value(kRuntimeState) == stopped || value(kRuntimeState) == paused || fault_;
  });
  const Obstacle obstacle = obstacle_of(value(kRobotMode), value(kSafetyMode));
  const int state = value(kRuntimeState);
  lock.unlock();
  if (fault_) return false;
  if (obstacle.cause != Cause::none) return refuse(obstacle.cause, obstacle.detail);
  return state == stopped ? true : refuse(Cause::other_program, state);
}

bool Link::start() {
  if (!thread_.joinable()) return refuse(Cause::rtde_closed);
  refused_.clear();
  if (!check_robot()) return false;
  if (!check_remote()) return false;
  ScriptSettings script = settings_.script;
  script.host =
      settings_.own_address.empty() ? wire::local_address(primary_.number()) : settings_.own_address;
  script.port = wire::local_port(listener_.number());
  std::unique_lock lock(mutex_);
  exception_.clear();
  refusal_.clear();
  stop_wanted_ = false;
  phase_ = Phase::starting;
  lock.unlock();
  if (!wire::send_frame(primary_.number(), moves_ ? move_program_text(script) : program_text(script)))
    return refuse(Cause::unreachable, 0, "it does not take the program");
  lock.lock();
  const auto decided = [this] {
    return phase_ == Phase::streaming || !exception_.empty() || !refusal_.empty() || fault_;
  };
  changed_.wait_for(lock, std::chrono::nanoseconds(settings_.start_timeout), decided);
  const Phase phase = phase_;
  const std::string exception = exception_, refusal = refusal_;
  if (phase != Phase::streaming) phase_ = Phase::idle;
  lock.unlock();
  if (fault_) return false;
  if (phase == Phase::streaming) return true;
  if (!exception.empty()) return refuse(Cause::script_error, 0, exception);
  if (!refusal.empty()) return refuse(Cause::not_remote, 0, refusal);
  wire::send_frame(primary_.number(), "stop program\n");
  return refuse(Cause::no_answer_back, 0, script.host + ":" + std::to_string(script.port));
}

void Link::stop() {
  std::unique_lock lock(mutex_);
  if (phase_ == Phase::idle) return;
  stop_wanted_ = true;
  lock.unlock();
  wake();
  lock.lock();
  changed_.wait_for(lock, std::chrono::nanoseconds(settings_.connect_timeout),
                    [this] { return phase_ == Phase::idle; });
}

}  // namespace polyarm::ur
