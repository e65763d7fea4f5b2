/// What the simulated controller makes of the requests of its clients.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/wire/arcs.hpp"
#include "drivers/wire/six_axes.hpp"
#include "drivers/xarm/machine.hpp"

namespace polyarm::xarm {

namespace {

constexpr std::size_t kVersionSize = 40;
constexpr int kParameterWarning = 12, kUnknownWarning = 13, kFullWarning = 11;
constexpr int kJoints = 8;                          // number that means every joint
constexpr std::size_t kMostQueued = 1024;
constexpr double kSpeed = 20, kAcceleration = 500;  // degrees/s, degrees/s², where a move says none
constexpr std::uint16_t kToolInputs = 0x0A14, kToolOutputs = 0x0A15, kToolSet = 0x0A18, kLiteInput = 0x0A12;
constexpr int kToolSignals = 5;

UxData word(std::uint64_t value) {
  return UxData().u16(value);
}

}  // namespace

std::string Machine::version() const {
  const auto axes = static_cast<int>(options_.facts.axes);
  return std::to_string(other_axes != 0 ? other_axes : axes) + "," + std::to_string(options_.facts.type) +
         ",XS1304,AC1302,v" + options_.firmware;
}

std::uint8_t Machine::state_bits() const {
  std::uint8_t bits = 0;
  if (error_ != 0) bits |= kErrorBit;
  if (warning_ != 0) bits |= kWarningBit;
  if (!is_ready()) bits |= kNotReadyBit;
  return bits;
}

UxReply Machine::answer(const UxRequest& request) {
  UxReply out{request.transaction, request.reg, 0, {}, request.protocol};
  std::uint8_t bits = 0;
  out.data = read(request, bits);
  out.bits = static_cast<std::uint8_t>(state_bits() | bits);
  return out;
}

// --- what is read -----------------------------------------------------------------------------------------

std::vector<std::uint8_t> Machine::read(const UxRequest& request, std::uint8_t& bits) {
  switch (request.reg) {
    case Register::version:
      return UxData().text(version(), kVersionSize);
    case Register::serial_number:
      return UxData().text(std::string("XS130400000000\0AC130200000000", 29), kVersionSize);
    case Register::check_verified:
    case Register::reports_current:
    case Register::approximate_motion:
    case Register::is_tcp_limit:
    case Register::reduced_state:
      return UxData().u8(0);
    case Register::is_joint_limit: {
      const auto joints = joints_in(request.data);
      return UxData().u8(joints && within_limits(*joints) ? 0 : 1);
    }
    case Register::get_state:
      return UxData().u8(static_cast<unsigned>(state_));
    case Register::queue_length:
      return word(queued());
    case Register::get_error:
      return UxData().u8(static_cast<unsigned>(error_)).u8(static_cast<unsigned>(warning_));
    case Register::tcp_pose:
      return UxData().f32(pose_of(measured_));
    case Register::joint_positions: {
      UxData out;
      for (const double one : measured_) out.f32(one / wire::kDegrees);
      return out;
    }
    case Register::joint_torques:
      return UxData().f32(Seven{});
    case Register::forward:
      return forward(request, bits);
    case Register::servo_error:
      return UxData().text("", 16);
    case Register::tool_read:
    case Register::tool_write:
      return tool_register(request, bits);
    case Register::digital_in:
      return word(inputs_);
    case Register::analog_in_1:
    case Register::analog_in_2:
      return word(0);
    case Register::io_state: {
      UxData out;
      out.u8(0).u8(0).u16(0).u16(inputs_).u16(0).u16(outputs_).u16(0).u16(0);
      return out.u16(analog_out_[0]).u16(analog_out_[1]).text("", 32);
    }
    case Register::power_version:
      return UxData().text("", 6);
    case Register::hardware_types:
      return word(0);
    default:
      if (!act(request)) bits = kInvalidBit;
      return {};
  }
}

std::vector<std::uint8_t> Machine::forward(const UxRequest& request, std::uint8_t& bits) const {
  if (const auto joints = joints_in(request.data)) return UxData().f32(pose_of(*joints));
  bits = kInvalidBit;
  return {};
}

/// Registers of the board at the tool: its digital signals only.
std::vector<std::uint8_t> Machine::tool_register(const UxRequest& request, std::uint8_t& bits) {
  constexpr int kSignalBits[] = {0, 1, 4, 2, 3};  // of an output's number
  const bool writes = request.reg == Register::tool_write;
  if (request.data.size() < (writes ? 7u : 3u) || (writes && locked_outputs)) {
    bits = kInvalidBit;
    return {};
  }
  const auto address = static_cast<std::uint16_t>(request.data[1] << 8 | request.data[2]);
  if (!writes) {
    const std::uint32_t value = address == kToolInputs  ? tool_inputs_ & 3
                                : address == kLiteInput ? tool_inputs_ >> 2 & 1
                                : address == kToolSet   ? tool_outputs_
                                                        : 0;
    return UxData().u32(value);
  }
  const double given = float_at(request.data, 3);
  if (address != kToolOutputs || !(given >= 0 && given < 65536)) {
    bits = kInvalidBit;
    return {};
  }
  const auto value = static_cast<std::uint32_t>(given);
  for (int i = 0; i < kToolSignals; ++i) {
    const int bit = kSignalBits[i];
    if (!(value >> (8 + bit) & 1)) continue;
    tool_outputs_ = (tool_outputs_ & ~(1u << bit)) | (value >> bit & 1) << bit;
  }
  return {};
}

// --- what is done -----------------------------------------------------------------------------------------

bool Machine::act(const UxRequest& request) {
  const auto given = [&](std::size_t size) { return request.data.size() >= size; };
  switch (request.reg) {
    case Register::motion_enable:
      return enable(request);
    case Register::set_state:
      if (!given(1)) return false;
      set_state(request.data[0]);
      return true;
    case Register::set_mode:
      if (!given(1) || request.data[0] > static_cast<int>(Mode::online_cartesian)) return false;
      if (!(refuse_mode && request.data[0] == static_cast<int>(Mode::servo))) set_mode(request.data[0]);
      return true;
    case Register::clean_error:
      error_ = pressed_;  // it stays while the button is pressed
      return true;
    case Register::clean_warning:
      warning_ = 0;
      return true;
    case Register::servo_joint:
      return take_servo(request);
    case Register::move_joint:
    case Register::move_joint_blend:
    case Register::move_home:
    case Register::move_line:
    case Register::move_line_blend:
    case Register::move_circle:
      return take_move(request);
    case Register::joint_velocity:
      return take_velocity(request);
    case Register::set_digital:
    case Register::set_analog_1:
    case Register::set_analog_2:
      return set_signals(request);
    default:
      return take_values(request);
  }
}

bool Machine::enable(const UxRequest& request) {
  if (request.data.size() < 2 || request.data[0] > kJoints) return false;
  const bool on = request.data[1] != 0;
  if (on && (refuse_enable || error_ != 0)) return false;
  if (on != enabled_) {
    switch_motors(on);
    if (on) state_ = State::reset;  // it waits for a program that says: ready
  }
  return true;
}

std::optional<Seven> Machine::joints_in(Bytes data) const {
  const auto values = floats(data, kWireJoints);
  if (!values) return std::nullopt;
  Seven out{};
  for (std::size_t i = 0; i < options_.facts.axes; ++i) out[i] = (*values)[i] * wire::kDegrees;
  return out;
}

bool Machine::take_servo(const UxRequest& request) {
  const auto joints = joints_in(request.data);
  if (refuse_servo || !joints || request.data.size() < 40) return false;
  if (!is_ready()) return true;  // the bits of the reply say it
  if (mode_ != Mode::servo) {
    warning_ = kParameterWarning;
    return false;
  }
  ++servo_commands_;
  if (!within_limits(*joints)) {
    raise_error(23);
    return true;
  }
  target_ = *joints;
  has_target_ = true;
  return true;
}

bool Machine::take_move(const UxRequest& request) {
  const auto move = decode_move(request.reg, request.data);
  if (!move || refuse_moves) return false;
  if (move->kind != UxMove::Kind::joint && !plays()) {
    warning_ = kUnknownWarning;
    return false;
  }
  if (!is_ready()) return true;  // the bits of the reply say it
  Seven degrees{};
  for (std::size_t i = 0; i < options_.facts.axes; ++i) degrees[i] = move->joints[i] * wire::kDegrees;
  if (move->kind == UxMove::Kind::joint && !within_limits(degrees)) {
    raise_error(23);
  } else if (queued() >= kMostQueued) {
    warning_ = kFullWarning;
  } else if (plays()) {
    return play(*move);
  } else {
    const double speed = move->speed * wire::kDegrees, acceleration = move->acceleration * wire::kDegrees;
    if (mode_ == Mode::online_joint) moves_.clear();  // the newest target replaces the others
    moves_.push_back({degrees, speed > 0.01 ? std::min(speed, 180.0) : kSpeed,
                      acceleration > 0.1 ? std::min(acceleration, 1145.0) : kAcceleration});
  }
  return true;
}

/// Where the TCP only turns, the speed of a line counts as degrees/s. On a circle the TCP turns evenly, and
/// is turned as at the second point when it ends.
bool Machine::play(const UxMove& move) {
  constexpr double kMostSpeed = 1000, kMostAcceleration = 50'000, kNoWay = 1e-3;  // mm, s
  const auto between = [](double given, double least, double otherwise, double most) {
    return given > least ? std::min(given, most) : otherwise;
  };
  forward::PlayedMove out;
  out.blend = std::clamp(move.radius, 0.0, 1000.0) / 1000;
  if (move.kind == UxMove::Kind::joint) {
    std::copy_n(move.joints.begin(), out.goal.size(), out.goal.begin());
    out.speed = between(move.speed, 1e-4, kSpeed / wire::kDegrees, std::numbers::pi);
    out.acceleration = between(move.acceleration, 1e-3, kAcceleration / wire::kDegrees, 20);
    Seven end{};
    for (std::size_t i = 0; i < out.goal.size(); ++i) end[i] = out.goal[i] * wire::kDegrees;
    last_pose_ = pose_of(end);
    return player_.take(out);
  }
  const double speed = between(move.speed, 1e-3, 100, kMostSpeed);
  const double acceleration = between(move.acceleration, 1e-3, 2000, kMostAcceleration);
  out.kind = hardware::ForwardMove::Kind::line;
  out.end = pose_from(move.pose);
  out.speed = speed / 1000;
  out.acceleration = acceleration / 1000;
  const Pose begin = pose_from(player_.waiting() > 0 ? last_pose_ : pose_of(command_));
  last_pose_ = move.pose;
  if (move.kind == UxMove::Kind::line) {
    if (1000 * norm(out.end->position - begin.position) < kNoWay) out.turn = speed / wire::kDegrees;
    return player_.take(out);
  }
  const Vec3 via = pose_from(move.via).position;
  const auto circle = wire::Circle::through(begin.position, via, out.end->position);
  if (!circle) {
    raise_error(32);  // three points that make no circle
    return true;
  }
  out.kind = hardware::ForwardMove::Kind::arc;
  const double angle = std::clamp(move.percent, 0.1, 99.9) / 100 * 2 * std::numbers::pi;
  out.end->position = circle->point(angle);
  out.via_point = circle->point(angle / 2);
  last_pose_ = pose_values(*out.end);
  return player_.take(out);
}

bool Machine::take_velocity(const UxRequest& request) {
  const auto joints = joints_in(request.data);
  if (!joints) return false;
  if (!is_ready()) return true;
  if (mode_ != Mode::joint_velocity) {
    warning_ = kParameterWarning;
    return false;
  }
  velocity_ = *joints;
  for (std::size_t i = 0; i < kWireJoints; ++i)
    velocity_[i] = std::clamp(velocity_[i], -options_.facts.velocity[i], options_.facts.velocity[i]);
  return true;
}

/// A word for eight signals: the upper half says which, the lower half what.
bool Machine::set_signals(const UxRequest& request) {
  if (locked_outputs || request.data.size() < 2) return false;
  const auto word_at = [&](std::size_t at) {
    return static_cast<unsigned>(request.data[at] << 8 | request.data[at + 1]);
  };
  if (request.reg != Register::set_digital) {
    analog_out_[request.reg == Register::set_analog_1 ? 0 : 1] = static_cast<std::uint16_t>(word_at(0));
    return true;
  }
  const std::size_t halves = request.data.size() >= 4 ? 2 : 1;
  for (std::size_t half = 0; half < halves; ++half) {
    const unsigned given = word_at(2 * half), which = given >> 8, shift = static_cast<unsigned>(8 * half);
    outputs_ = (outputs_ & ~(which << shift)) | (given & which) << shift;
  }
  return true;
}

/// Settings, which are kept or taken without effect.
bool Machine::take_values(const UxRequest& request) {
  const auto keep = [&](auto& into) {
    const auto values = floats(request.data, into.size());
    if (values) std::copy(values->begin(), values->end(), into.begin());
    return values.has_value();
  };
  const auto small = [&](int& into) {
    if (request.data.empty() || request.data[0] > 5) return false;
    into = request.data[0];
    return true;
  };
  switch (request.reg) {
    case Register::tcp_offset:
      if (refuse_tool) return true;
      if (!keep(tcp_offset_)) return false;
      player_.set_tool(pose_from(tcp_offset_));
      return true;
    case Register::world_offset:
      return keep(world_offset_);
    case Register::tcp_load:
      return keep(load_);
    case Register::gravity:
      return keep(gravity_);
    case Register::collision_sensitivity:
      return small(collision_);
    case Register::teach_sensitivity:
      return small(teach_);
    case Register::counter_reset:
      counter_ = 0;
      return true;
    case Register::counter_plus:
      ++counter_;
      return true;
    case Register::sleep:
    case Register::tcp_jerk:
    case Register::tcp_acceleration:
    case Register::joint_jerk:
    case Register::joint_acceleration:
    case Register::save_settings:
    case Register::clean_settings:
    case Register::reload_dynamics:
    case Register::collision_rebound:
    case Register::self_collision:
    case Register::brake:
    case Register::set_in_function:
    case Register::set_out_function:
    case Register::tool_timeout:
    case Register::feedback_type:
      return true;
    default:
      warning_ = kUnknownWarning;
      return false;
  }
}

}  // namespace polyarm::xarm
