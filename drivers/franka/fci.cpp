#include "drivers/franka/fci.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "drivers/wire/ordered_bytes.hpp"

namespace polyarm::franka {

namespace {

using wire::ByteOrder;
using wire::OrderedReader;
using wire::OrderedWriter;
using enum Request;

/// By number: version 5, then 6 and 7, then 8 and 9, then 10.
constexpr Request kFive[] = {connect,
                             move,
                             stop_move,
                             get_cartesian_limit,
                             set_collision_behavior,
                             set_joint_impedance,
                             set_cartesian_impedance,
                             set_guiding_mode,
                             set_k_frame,
                             set_ee_frame,
                             set_load,
                             set_filters,
                             recover,
                             load_model_library};
constexpr Request kSix[] = {connect,
                            move,
                            stop_move,
                            set_collision_behavior,
                            set_joint_impedance,
                            set_cartesian_impedance,
                            set_guiding_mode,
                            set_k_frame,
                            set_ee_frame,
                            set_load,
                            recover,
                            load_model_library,
                            get_robot_model};

std::span<const Request> requests_of(int version) {
  if (version <= 5) return kFive;
  return std::span(kSix).first(version <= 7 ? 12 : 13);
}

using S = Status;
constexpr Status kMoveFive[] = {S::success,        S::started,          S::preempted, S::not_possible,
                                S::singular_start, S::invalid_argument, S::reflex,    S::user_stop,
                                S::input_error,    S::aborted};
constexpr Status kMoveSix[] = {S::success,
                               S::started,
                               S::preempted,
                               S::preempted_by_safety,
                               S::refused_by_safety,
                               S::not_possible,
                               S::singular_start,
                               S::invalid_argument,
                               S::reflex,
                               S::user_stop,
                               S::input_error,
                               S::aborted};
constexpr Status kStopFive[] = {S::success, S::not_possible, S::user_stop, S::reflex, S::aborted};
constexpr Status kStopSix[] = {S::success,   S::not_possible, S::refused_by_safety,
                               S::user_stop, S::reflex,       S::aborted};
constexpr Status kRecoverFive[] = {S::success, S::not_possible, S::manual_recovery,
                                   S::reflex,  S::user_stop,    S::aborted};
constexpr Status kRecoverSix[] = {S::success,         S::not_possible, S::refused_by_safety,
                                  S::manual_recovery, S::reflex,       S::user_stop,
                                  S::aborted};
constexpr Status kSetting[] = {S::success, S::not_possible, S::invalid_argument, S::refused_by_safety};
constexpr Status kConnectReply[] = {S::success, S::other_version};
constexpr Status kModel[] = {S::success, S::not_possible};

std::span<const Status> statuses_of(Request request, int version) {
  const bool five = version <= 5;
  switch (request) {
    case connect:
      return kConnectReply;
    case move:
      return five ? std::span<const Status>(kMoveFive) : kMoveSix;
    case stop_move:
      return five ? std::span<const Status>(kStopFive) : kStopSix;
    case recover:
      return five ? std::span<const Status>(kRecoverFive) : kRecoverSix;
    case load_model_library:
    case get_robot_model:
      return kModel;
    default:
      return std::span(kSetting).first(five ? 3 : 4);
  }
}

bool is_finite(std::span<const double> values) noexcept {
  return std::all_of(values.begin(), values.end(), [](double one) { return std::isfinite(one); });
}

}  // namespace

const char* name(Request request) {
  constexpr const char* kNames[] = {"Connect",
                                    "Move",
                                    "Stop Move",
                                    "Set Collision Behavior",
                                    "Set Joint Impedance",
                                    "Set Cartesian Impedance",
                                    "Set Guiding Mode",
                                    "Set EE to K",
                                    "Set NE to EE",
                                    "Set Load",
                                    "Automatic Error Recovery",
                                    "Get Cartesian Limit",
                                    "Set Filters",
                                    "Load Model Library",
                                    "Get Robot Model"};
  return kNames[static_cast<std::size_t>(request)];
}

const char* name(Status status) {
  constexpr const char* kNames[] = {"success",
                                    "started",
                                    "preempted",
                                    "preempted by a safety function",
                                    "refused by a safety function",
                                    "not possible in this mode",
                                    "singular start",
                                    "invalid argument",
                                    "a person must recover it",
                                    "reflex",
                                    "user stop",
                                    "invalid input",
                                    "aborted",
                                    "other version",
                                    "unknown"};
  return kNames[static_cast<std::size_t>(status)];
}

const char* name(RobotMode mode) {
  constexpr const char* kNames[] = {"other",  "idle",         "move",          "guiding",
                                    "reflex", "user stopped", "error recovery"};
  return kNames[static_cast<std::size_t>(mode)];
}

std::optional<std::uint32_t> number_of(Request request, int version) {
  if (request == get_robot_model && version >= 10) return 11;
  if (request == load_model_library && version >= 10) return std::nullopt;
  const auto all = requests_of(version);
  const auto at = std::find(all.begin(), all.end(), request);
  if (at == all.end()) return std::nullopt;
  return static_cast<std::uint32_t>(at - all.begin());
}

std::optional<Request> request_of(std::uint32_t number, int version) {
  if (version >= 10 && number == 11) return get_robot_model;
  const auto all = requests_of(version);
  if (number >= all.size() || (version >= 10 && number > 11)) return std::nullopt;
  return all[number];
}

std::uint8_t byte_of(Status status, Request request, int version) {
  const auto all = statuses_of(request, version);
  const auto find = [&](Status one) { return std::find(all.begin(), all.end(), one); };
  auto at = find(status);
  if (at == all.end()) at = find(S::aborted);
  if (at == all.end()) at = find(S::not_possible);
  return static_cast<std::uint8_t>(at == all.end() ? 1 : at - all.begin());
}

Status status_of(std::uint8_t byte, Request request, int version) {
  const auto all = statuses_of(request, version);
  return byte < all.size() ? all[byte] : S::unknown;
}

Data encode(const Frame& frame) {
  OrderedWriter out(ByteOrder::little);
  out.u32(frame.command).u32(frame.id).u32(kFciHead + frame.data.size()).append(frame.data);
  return out.bytes();
}

std::uint32_t FrameReader::size_of_first() const {
  OrderedReader in(Bytes(buffer_).subspan(head_ - 4, 4), ByteOrder::little);
  return in.u32();
}

bool FrameReader::feed(Bytes bytes) {
  if (broken_) return false;
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  if (buffer_.size() >= head_) {
    const std::uint32_t size = size_of_first();
    broken_ = size < head_ || size > kMostFrame;
  }
  // A peer that sends more than anyone takes is no controller.
  broken_ = broken_ || buffer_.size() > 8 * kMostFrame;
  return !broken_;
}

std::optional<Frame> FrameReader::next() {
  if (broken_ || buffer_.size() < head_) return std::nullopt;
  const std::uint32_t size = size_of_first();
  if (size < head_ || size > kMostFrame) {
    broken_ = true;
    return std::nullopt;
  }
  if (buffer_.size() < size) return std::nullopt;
  OrderedReader in(buffer_, ByteOrder::little);
  Frame out;
  out.command = head_ == kFciHead ? in.u32() : in.u16();
  out.id = in.u32();
  out.data.assign(buffer_.begin() + static_cast<std::ptrdiff_t>(head_), buffer_.begin() + size);
  buffer_.erase(buffer_.begin(), buffer_.begin() + size);
  return out;
}

// --- requests ---------------------------------------------------------------------------------------------

Data encode(const MoveRequest& move, int version) {
  OrderedWriter out(ByteOrder::little);
  out.u32(static_cast<std::uint32_t>(move.controller));
  out.u32(static_cast<std::uint32_t>(move.generator) - 1);  // a request counts without `idle`
  for (const double one : move.path_deviation) out.f64(one);
  for (const double one : move.goal_deviation) out.f64(one);
  if (version >= 10) {
    out.u8(0);  // not asynchronous
    for (int i = 0; i < 7; ++i) out.f64(0);
  }
  return out.bytes();
}

std::optional<MoveRequest> decode_move(Bytes data, int version) {
  if (data.size() != (version >= 10 ? 113u : 56u)) return std::nullopt;
  OrderedReader in(data, ByteOrder::little);
  const std::uint32_t controller = in.u32(), generator = in.u32();
  if (controller > 2 || generator > (version >= 7 ? 4u : 3u)) return std::nullopt;
  MoveRequest out;
  out.controller = static_cast<Controller>(controller);
  out.generator = static_cast<Generator>(generator + 1);
  for (double& one : out.path_deviation) one = in.f64();
  for (double& one : out.goal_deviation) one = in.f64();
  if (!is_finite(out.path_deviation) || !is_finite(out.goal_deviation)) return std::nullopt;
  return out;
}

Data numbers(std::span<const double> values) {
  OrderedWriter out(ByteOrder::little);
  for (const double one : values) out.f64(one);
  return out.bytes();
}

bool read_numbers(Bytes data, std::span<double> values) {
  if (data.size() != 8 * values.size()) return false;
  OrderedReader in(data, ByteOrder::little);
  for (double& one : values) one = in.f64();
  return is_finite(values);
}

Data encode(const CollisionBehavior& behavior) {
  OrderedWriter out(ByteOrder::little);
  // The same thresholds while it accelerates and at a steady speed.
  for (int phase = 0; phase < 2; ++phase)
    for (const Seven& torques : {behavior.lower_torque, behavior.upper_torque})
      for (const double one : torques) out.f64(one);
  for (int phase = 0; phase < 2; ++phase)
    for (const Six& forces : {behavior.lower_force, behavior.upper_force})
      for (const double one : forces) out.f64(one);
  return out.bytes();
}

std::optional<CollisionBehavior> decode_collision(Bytes data) {
  std::array<double, 52> all;
  if (!read_numbers(data, all)) return std::nullopt;
  CollisionBehavior out;
  const auto take = [&](std::size_t from, auto& into) {
    std::copy_n(all.begin() + static_cast<std::ptrdiff_t>(from), into.size(), into.begin());
  };
  take(14, out.lower_torque);
  take(21, out.upper_torque);
  take(40, out.lower_force);
  take(46, out.upper_force);
  const auto ordered = [](const auto& lower, const auto& upper) {
    for (std::size_t i = 0; i < lower.size(); ++i)
      if (lower[i] < 0 || lower[i] > upper[i]) return false;
    return true;
  };
  if (!ordered(out.lower_torque, out.upper_torque) || !ordered(out.lower_force, out.upper_force))
    return std::nullopt;
  return out;
}

Data encode(const Load& load) {
  OrderedWriter out(ByteOrder::little);
  out.f64(load.mass);
  for (const double one : load.center) out.f64(one);
  for (const double one : load.inertia) out.f64(one);
  return out.bytes();
}

std::optional<Load> decode_load(Bytes data) {
  std::array<double, 13> all;
  if (!read_numbers(data, all) || all[0] < 0) return std::nullopt;
  Load out;
  out.mass = all[0];
  std::copy_n(all.begin() + 1, 3, out.center.begin());
  std::copy_n(all.begin() + 4, 9, out.inertia.begin());
  return out;
}

// --- datagrams --------------------------------------------------------------------------------------------

namespace {

/// Fields of a state in their order. `Wire` reads or writes one number, and skips numbers of no interest.
template <class State, class Wire>
void walk_numbers(State& s, Wire& wire, bool accelerometers) {
  wire.array(s.O_T_EE), wire.array(s.O_T_EE_d), wire.array(s.F_T_EE), wire.array(s.EE_T_K);
  wire.array(s.F_T_NE), wire.array(s.NE_T_EE);
  wire.skip(1 + 9 + 3);  // the end effector's mass, inertia, centre
  wire.one(s.load.mass), wire.array(s.load.inertia), wire.array(s.load.center);
  wire.skip(2 + 2);  // elbow
  wire.array(s.tau_J);
  wire.skip(7 + 7);  // desired torque, its derivative
  wire.array(s.q), wire.array(s.q_d), wire.array(s.dq), wire.array(s.dq_d), wire.array(s.ddq_d);
  wire.array(s.joint_contact), wire.array(s.cartesian_contact);
  wire.array(s.joint_collision), wire.array(s.cartesian_collision);
  wire.array(s.tau_ext), wire.array(s.O_F_ext), wire.array(s.K_F_ext);
  wire.skip(6 + 3 + 2 + 2 + 2 + 16 + 6 + 6 + 7 + 7);  // Cartesian commands, motors
  if (accelerometers) wire.skip(36);
}

struct Putting {
  OrderedWriter& out;
  bool single;
  void one(double value) { single ? out.f32(static_cast<float>(value)) : out.f64(value); }
  template <class Array>
  void array(const Array& values) {
    for (const double value : values) one(value);
  }
  void skip(int count) {
    for (int i = 0; i < count; ++i) one(0);
  }
};

struct Taking {
  OrderedReader& in;
  bool single;
  void one(double& value) noexcept { value = single ? static_cast<double>(in.f32()) : in.f64(); }
  template <class Array>
  void array(Array& values) noexcept {
    for (double& value : values) one(value);
  }
  void skip(int count) noexcept { in.take(static_cast<std::size_t>(count) * (single ? 4 : 8)); }
};

constexpr bool single_precision(int version) {
  return version >= 10;
}

}  // namespace

std::size_t state_bytes(int version) {
  return single_precision(version) ? 1377 : 2373;
}

Data encode(const RobotState& state, int version) {
  OrderedWriter out(ByteOrder::little);
  const bool single = single_precision(version);
  Putting wire{out, single};
  out.u64(state.id);
  walk_numbers(state, wire, single);
  out.u8(static_cast<std::uint8_t>(state.generator)).u8(static_cast<std::uint8_t>(state.controller));
  for (const ErrorFlags& flags : {state.errors, state.reflex})
    for (std::size_t i = 0; i < kErrors; ++i) out.u8(flags[i]);
  out.u8(static_cast<std::uint8_t>(state.mode));
  wire.one(state.success_rate);
  return out.bytes();
}

std::optional<RobotState> decode_state(Bytes data, int version) noexcept {
  if (data.size() != state_bytes(version)) return std::nullopt;
  OrderedReader in(data, ByteOrder::little);
  const bool single = single_precision(version);
  Taking wire{in, single};
  RobotState out;
  out.id = in.u64();
  walk_numbers(out, wire, single);
  const std::uint8_t generator = in.u8(), controller = in.u8();
  for (ErrorFlags* flags : {&out.errors, &out.reflex})
    for (std::size_t i = 0; i < kErrors; ++i) (*flags)[i] = in.u8() != 0;
  const std::uint8_t mode = in.u8();
  wire.one(out.success_rate);
  if (!in.ok() || generator > 5 || controller > 3 || mode > 6) return std::nullopt;
  out.generator = static_cast<Generator>(generator);
  out.controller = static_cast<Controller>(controller);
  out.mode = static_cast<RobotMode>(mode);
  if (!is_finite(out.q) || !is_finite(out.q_d) || !is_finite(out.dq)) return std::nullopt;
  return out;
}

std::size_t command_bytes(int version) {
  return version >= 7 ? 371 : 370;
}

namespace {

/// Where the parts of a command are.
constexpr std::size_t kVelocities = 8 + 56, kPose = kVelocities + 56, kFinished = kPose + 128 + 48 + 16 + 1;

void put(std::span<std::uint8_t> out, std::size_t at, std::uint64_t value) noexcept {
  for (std::size_t i = 0; i < 8; ++i) out[at + i] = static_cast<std::uint8_t>(value >> 8 * i);
}

}  // namespace

void encode(const RobotCommand& command, int, std::span<std::uint8_t, kMostCommand> out) noexcept {
  std::fill(out.begin(), out.end(), std::uint8_t{0});
  put(out, 0, command.id);
  for (std::size_t i = 0; i < 7; ++i) {
    put(out, 8 + 8 * i, std::bit_cast<std::uint64_t>(command.q[i]));
    put(out, kVelocities + 8 * i, std::bit_cast<std::uint64_t>(command.dq[i]));
  }
  out[kFinished] = command.finished;
}

std::optional<RobotCommand> decode_command(Bytes data, int version) noexcept {
  if (data.size() != command_bytes(version)) return std::nullopt;
  OrderedReader in(data, ByteOrder::little);
  RobotCommand out;
  out.id = in.u64();
  for (double& one : out.q) one = in.f64();
  for (double& one : out.dq) one = in.f64();
  out.finished = data[kFinished] != 0 || (version >= 7 && data[370] != 0);
  return out;
}

std::array<double, 7> pose_of(const Matrix4& m) noexcept {
  const auto r = [&m](std::size_t row, std::size_t column) { return m[4 * column + row]; };
  // The largest of the four parts divides the others: no loss near half a turn.
  const double trace[4] = {1 + r(0, 0) - r(1, 1) - r(2, 2), 1 - r(0, 0) + r(1, 1) - r(2, 2),
                           1 - r(0, 0) - r(1, 1) + r(2, 2), 1 + r(0, 0) + r(1, 1) + r(2, 2)};
  const auto largest = static_cast<std::size_t>(std::max_element(trace, trace + 4) - trace);
  const double d = std::sqrt(std::max(trace[largest], 1e-12)) * 2;
  std::array<double, 4> q{};
  const double xy = r(0, 1) + r(1, 0), xz = r(0, 2) + r(2, 0), yz = r(1, 2) + r(2, 1);
  const double wx = r(2, 1) - r(1, 2), wy = r(0, 2) - r(2, 0), wz = r(1, 0) - r(0, 1);
  const std::array<std::array<double, 4>, 4> rows{
      {{d * d / 4, xy, xz, wx}, {xy, d * d / 4, yz, wy}, {xz, yz, d * d / 4, wz}, {wx, wy, wz, d * d / 4}}};
  for (std::size_t i = 0; i < 4; ++i) q[i] = rows[largest][i] / d;
  return {m[12], m[13], m[14], q[0], q[1], q[2], q[3]};
}

}  // namespace polyarm::franka
