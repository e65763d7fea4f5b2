#include "drivers/abb/egm.hpp"

#include <cmath>

#include "drivers/wire/proto.hpp"

namespace polyarm::abb {

namespace {

using wire::ProtoReader;
using wire::ProtoWriter;

ProtoWriter written(const EgmHeader& header) {
  ProtoWriter out;
  out.number(1, header.sequence).number(2, header.time_ms);
  out.number(3, static_cast<std::uint32_t>(header.type));
  return out;
}

ProtoWriter written(const Values& values) {
  ProtoWriter out;
  for (std::size_t i = 0; i < values.count; ++i) out.f64(1, values.value[i]);
  return out;
}

ProtoWriter written(const EgmPose& pose) {
  ProtoWriter position, orientation;
  for (std::uint32_t i = 0; i < 3; ++i) position.f64(i + 1, pose.position[i]);
  for (std::uint32_t i = 0; i < 4; ++i) orientation.f64(i + 1, pose.orientation[i]);
  return ProtoWriter().message(1, position).message(2, orientation);
}

ProtoWriter written(const EgmPosition& at) {
  ProtoWriter out;
  if (at.joints) out.message(1, written(*at.joints));
  if (at.pose) out.message(2, written(*at.pose));
  if (at.external) out.message(3, written(*at.external));
  if (at.time) out.message(4, ProtoWriter().number(1, at.time->s).number(2, at.time->us));
  return out;
}

template <typename State>
ProtoWriter written_state(State state) {
  return ProtoWriter().number(1, static_cast<std::uint32_t>(state));
}

/// The last field of this number wins, as in every reader of protocol buffers.
template <typename Read>
bool each_field(Bytes bytes, Read read) noexcept {
  ProtoReader in(bytes);
  while (in.next()) read(in);
  return in.ok();
}

double finite(double value, bool& fine) noexcept {
  fine = fine && std::isfinite(value);
  return value;
}

/// Repeated doubles; packed ones are allowed too.
bool read_values(Bytes bytes, Values& out, std::uint32_t field = 1) noexcept {
  bool fine = true;
  const auto add = [&](double value) {
    if (out.count == Values::kMost) return void(fine = false);
    out.value[out.count++] = finite(value, fine);
  };
  const auto add_packed = [&](Bytes packed) {
    fine = fine && packed.size() % 8 == 0;
    for (; fine && !packed.empty(); packed = packed.subspan(8)) {
      std::uint64_t bits = 0;
      for (std::size_t i = 8; i > 0; --i) bits = bits << 8 | packed[i - 1];
      add(std::bit_cast<double>(bits));
    }
  };
  const bool read = each_field(bytes, [&](ProtoReader& in) {
    if (in.field() != field) return;
    in.type() == ProtoReader::Type::bytes ? add_packed(in.bytes()) : add(in.f64());
  });
  return read && fine;
}

bool read_header(Bytes bytes, EgmHeader& out) noexcept {
  return each_field(bytes, [&](ProtoReader& in) {
    if (in.field() == 1) out.sequence = static_cast<std::uint32_t>(in.number());
    if (in.field() == 2) out.time_ms = static_cast<std::uint32_t>(in.number());
    if (in.field() == 3) out.type = static_cast<MessageType>(in.number() & 7);
  });
}

template <std::size_t N>
bool read_numbers(Bytes bytes, std::array<double, N>& out) noexcept {
  std::uint32_t seen = 0;
  bool fine = true;
  const bool read = each_field(bytes, [&](ProtoReader& in) {
    if (in.field() > N) return;
    out[in.field() - 1] = finite(in.f64(), fine);
    seen |= 1u << (in.field() - 1);
  });
  return read && fine && seen == (1u << N) - 1;
}

bool read_pose(Bytes bytes, EgmPose& out) noexcept {
  bool fine = true;
  return each_field(bytes,
                    [&](ProtoReader& in) {
                      if (in.field() == 1) fine = read_numbers(in.bytes(), out.position) && fine;
                      if (in.field() == 2) fine = read_numbers(in.bytes(), out.orientation) && fine;
                    }) &&
         fine;
}

bool read_clock(Bytes bytes, EgmClock& out) noexcept {
  return each_field(bytes, [&](ProtoReader& in) {
    if (in.field() == 1) out.s = in.number();
    if (in.field() == 2) out.us = in.number();
  });
}

bool read_position(Bytes bytes, EgmPosition& out) noexcept {
  bool fine = true;
  return each_field(bytes,
                    [&](ProtoReader& in) {
                      if (in.field() == 1) fine = read_values(in.bytes(), out.joints.emplace()) && fine;
                      if (in.field() == 2) fine = read_pose(in.bytes(), out.pose.emplace()) && fine;
                      if (in.field() == 3) fine = read_values(in.bytes(), out.external.emplace()) && fine;
                      if (in.field() == 4) fine = read_clock(in.bytes(), out.time.emplace()) && fine;
                    }) &&
         fine;
}

/// A message that holds one number. A number that the protocol does not have counts as undefined.
template <typename State>
bool read_state(Bytes bytes, State& out, std::uint64_t last) noexcept {
  return each_field(bytes, [&](ProtoReader& in) {
    if (in.field() != 1) return;
    const std::uint64_t value = in.number();
    out = static_cast<State>(value <= last ? value : 0);
  });
}

bool read_collision(Bytes bytes, std::optional<bool>& out) noexcept {
  return each_field(bytes, [&](ProtoReader& in) {
    if (in.field() == 1) out = in.number() != 0;
  });
}

/// RobotWare 6 has the forces in field 1 alone; with a flag of RobotWare 7 in field 1 they are in field 2.
bool read_force(Bytes bytes, Values& out) noexcept {
  bool flag = false;
  const bool read = each_field(bytes, [&](ProtoReader& in) {
    if (in.field() == 1 && in.type() == ProtoReader::Type::number) flag = true;
  });
  return read && read_values(bytes, out, flag ? 2 : 1);
}

bool read_field(ProtoReader& in, EgmRobot& out, bool& header) noexcept {
  switch (in.field()) {
    case 1:
      header = true;
      return read_header(in.bytes(), out.header);
    case 2:
      return read_position(in.bytes(), out.feedback.emplace());
    case 3:
      return read_position(in.bytes(), out.planned.emplace());
    case 4:
      return read_state(in.bytes(), out.motors, 2);
    case 5:
      return read_state(in.bytes(), out.state, 3);
    case 6:
      out.converged = in.number() != 0;
      return true;
    case 8:
      return read_state(in.bytes(), out.rapid, 2);
    case 9:
      return read_force(in.bytes(), out.force.emplace());
    case 10: {
      bool fine = true;
      out.utilization = finite(in.f64(), fine);
      return fine;
    }
    case 12:
      return read_collision(in.bytes(), out.collision);
    default:
      return true;
  }
}

bool read_speed(Bytes bytes, EgmSensor& out) noexcept {
  bool fine = true;
  return each_field(bytes,
                    [&](ProtoReader& in) {
                      if (in.field() == 1) fine = read_values(in.bytes(), out.joint_speed.emplace()) && fine;
                      if (in.field() == 3)
                        fine = read_values(in.bytes(), out.external_speed.emplace()) && fine;
                    }) &&
         fine;
}

}  // namespace

std::vector<std::uint8_t> encode(const EgmRobot& message) {
  ProtoWriter out;
  out.message(1, written(message.header));
  if (message.feedback) out.message(2, written(*message.feedback));
  if (message.planned) out.message(3, written(*message.planned));
  out.message(4, written_state(message.motors)).message(5, written_state(message.state));
  if (message.converged) out.number(6, *message.converged);
  out.message(8, written_state(message.rapid));
  if (message.force) out.message(9, written(*message.force));
  if (message.utilization) out.f64(10, *message.utilization);
  if (message.collision) out.message(12, ProtoWriter().number(1, *message.collision));
  return out.bytes();
}

std::vector<std::uint8_t> encode(const EgmSensor& message) {
  ProtoWriter out;
  out.message(1, written(message.header));
  if (message.planned) out.message(2, written(*message.planned));
  if (message.joint_speed || message.external_speed) {
    ProtoWriter speed;
    if (message.joint_speed) speed.message(1, written(*message.joint_speed));
    if (message.external_speed) speed.message(3, written(*message.external_speed));
    out.message(3, speed);
  }
  return out.bytes();
}

std::optional<EgmRobot> decode_robot(Bytes datagram) noexcept {
  EgmRobot out;
  bool header = false, fine = true;
  const bool read =
      each_field(datagram, [&](ProtoReader& in) { fine = read_field(in, out, header) && fine; });
  if (!read || !fine || !header) return std::nullopt;
  return out;
}

std::optional<EgmSensor> decode_sensor(Bytes datagram) noexcept {
  EgmSensor out;
  bool header = false, fine = true;
  const bool read = each_field(datagram, [&](ProtoReader& in) {
    if (in.field() == 1) {
      header = true;
      fine = read_header(in.bytes(), out.header) && fine;
    }
    if (in.field() == 2) fine = read_position(in.bytes(), out.planned.emplace()) && fine;
    if (in.field() == 3) fine = read_speed(in.bytes(), out) && fine;
  });
  if (!read || !fine || !header) return std::nullopt;
  return out;
}

}  // namespace polyarm::abb
