#include "drivers/fanuc/stream.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>

namespace polyarm::fanuc {

namespace {

constexpr std::size_t kIoSetupBytes = 8 + 16 * kIoRows, kLimitBytes = 24 + 8 * kLimitSteps;
constexpr std::uint32_t kRegister = 100, kMostIo = 100'000;

wire::Writer begin(PacketType type, std::uint32_t version) {
  wire::Writer out;
  out.u32(static_cast<std::uint32_t>(type)).u32(version);
  return out;
}

bool fits(Bytes packet, PacketType type, std::size_t size) noexcept {
  return packet.size() == size && type_of(packet) == static_cast<std::uint32_t>(type);
}

template <std::size_t N>
void put(wire::Writer& out, const std::array<float, N>& values) {
  for (const float value : values) out.f32(value);
}

/// False if a value is not finite.
template <std::size_t N>
bool get(wire::Reader& in, std::array<float, N>& values) noexcept {
  bool finite = true;
  for (float& value : values) {
    value = in.f32();
    finite = finite && std::isfinite(value);
  }
  return finite;
}

void get_io(wire::Reader& in, IoArea& io) noexcept {
  const Bytes bytes = in.take(io.size());
  std::copy(bytes.begin(), bytes.end(), io.begin());
}

std::vector<std::uint8_t> finish(const wire::Writer& out) {
  return out.bytes();
}

}  // namespace

std::uint32_t type_of(Bytes packet) noexcept {
  return wire::Reader(packet).u32();
}

std::vector<std::uint8_t> encode(const Status& s) {
  const bool force = s.with_force;
  wire::Writer out = begin(force ? PacketType::status_with_force : PacketType::status, s.version);
  out.u32(s.sequence).u8(s.status).u8(s.robot).u8(s.contact_stop).u8(0).u32(s.time_ms);
  put(out, s.pose);
  put(out, s.joints);
  put(out, s.current);
  out.f32(s.safety_scale);
  if (force) put(out, s.force);
  if (force) out.u32(s.sensor);
  return finish(out.append(s.io));
}

std::optional<Status> decode_status(Bytes packet) noexcept {
  const bool force = fits(packet, PacketType::status_with_force, kForceStatusBytes);
  if (!force && !fits(packet, PacketType::status, kStatusBytes)) return std::nullopt;
  wire::Reader in(packet.subspan(4));
  Status out;
  out.with_force = force;
  out.version = in.u32();
  if (out.version < kOldestVersion || out.version > kNewestVersion) return std::nullopt;
  out.sequence = in.u32();
  out.status = in.u8();
  out.robot = in.u8();
  out.contact_stop = in.u8();
  in.u8();
  out.time_ms = in.u32();
  bool finite = get(in, out.pose) & get(in, out.joints) & get(in, out.current);
  out.safety_scale = in.f32();
  if (force) finite = get(in, out.force) && finite;
  if (force) out.sensor = in.u32();
  get_io(in, out.io);
  if (!finite || !std::isfinite(out.safety_scale) || !in.ok()) return std::nullopt;
  return out;
}

std::vector<std::uint8_t> encode(const Command& c) {
  wire::Writer out = begin(PacketType::command, c.version);
  out.u32(c.sequence).u8(c.last).u8(c.motion).u16(c.style);
  for (const double joint : c.joints) out.f64(joint);
  return finish(out.append(c.io));
}

std::optional<Command> decode_command(Bytes packet) noexcept {
  if (!fits(packet, PacketType::command, kCommandBytes)) return std::nullopt;
  wire::Reader in(packet.subspan(4));
  Command out;
  out.version = in.u32();
  out.sequence = in.u32();
  out.last = in.u8() != 0;
  out.motion = in.u8() != 0;
  out.style = in.u16();
  for (double& joint : out.joints) {
    joint = in.f64();
    if (!std::isfinite(joint)) return std::nullopt;
  }
  get_io(in, out.io);
  return out;
}

std::vector<std::uint8_t> encode_start(std::uint32_t version) {
  return finish(begin(PacketType::start, version));
}

std::vector<std::uint8_t> encode_stop(std::uint32_t version) {
  return finish(begin(PacketType::stop, version));
}

std::vector<std::uint8_t> encode(const Capability& c) {
  wire::Writer out = begin(c.set ? PacketType::set_capability : PacketType::get_capability, c.version);
  return finish(out.u32(1).u32(c.sampling_ms).u32(c.start_move).u32(c.available).u32(c.uses_tcp));
}

std::optional<Capability> decode_capability(Bytes packet) noexcept {
  Capability out;
  out.set = fits(packet, PacketType::set_capability, 28);
  if (!out.set && !fits(packet, PacketType::get_capability, 28)) return std::nullopt;
  wire::Reader in(packet.subspan(4));
  out.version = in.u32();
  in.u32();  // always 1
  out.sampling_ms = in.u32();
  out.start_move = in.u32();
  out.available = in.u32();
  out.uses_tcp = in.u32();
  return out;
}

std::vector<std::uint8_t> encode(const LimitRequest& request) {
  wire::Writer out = begin(PacketType::limits, request.version);
  return finish(out.u32(request.axis).u32(static_cast<std::uint32_t>(request.kind)));
}

std::optional<LimitRequest> decode_limit_request(Bytes packet) noexcept {
  if (!fits(packet, PacketType::limits, 16)) return std::nullopt;
  wire::Reader in(packet.subspan(4));
  LimitRequest out;
  out.version = in.u32();
  out.axis = in.u32();
  const std::uint32_t kind = in.u32();
  if (out.axis < 1 || out.axis > 9 || kind > 2) return std::nullopt;
  out.kind = static_cast<LimitKind>(kind);
  return out;
}

std::vector<std::uint8_t> encode(const LimitTable& table, std::uint32_t version) {
  wire::Writer out = begin(PacketType::limits, version);
  out.u32(table.axis).u32(static_cast<std::uint32_t>(table.kind)).u32(table.max_speed).u32(table.interval_ms);
  put(out, table.empty);
  put(out, table.loaded);
  return finish(out);
}

std::optional<LimitTable> decode_limits(Bytes packet) noexcept {
  if (!fits(packet, PacketType::limits, kLimitBytes)) return std::nullopt;
  wire::Reader in(packet.subspan(8));
  LimitTable out;
  out.axis = in.u32();
  const std::uint32_t kind = in.u32();
  out.max_speed = in.u32();
  out.interval_ms = in.u32();
  if (out.axis < 1 || out.axis > 9 || kind > 2 || out.max_speed == 0) return std::nullopt;
  out.kind = static_cast<LimitKind>(kind);
  if (!get(in, out.empty) || !get(in, out.loaded)) return std::nullopt;
  const auto bad = [](float limit) { return !(limit > 0); };
  if (std::ranges::any_of(out.empty, bad) || std::ranges::any_of(out.loaded, bad)) return std::nullopt;
  return out;
}

std::size_t IoRow::bytes() const noexcept {
  std::size_t packed = 0;  // values in 4 bytes
  if (direction == IoDirection::command || direction == IoDirection::state) {
    const bool analog = kind == static_cast<std::uint32_t>(IoKind::analog_out) ||
                        kind == static_cast<std::uint32_t>(IoKind::analog_in);
    if (kind <= static_cast<std::uint32_t>(IoKind::flag)) packed = analog ? 2 : 32;
  } else if (direction != IoDirection::none && kind == kRegister) {
    packed = 1;
  }
  if (packed == 0 || first == 0 || count == 0 || first > kMostIo || count > kMostIo) return 0;
  return 4 * ((count + packed - 1) / packed);
}

std::vector<std::uint8_t> encode(const IoSetup& setup, std::uint32_t version) {
  wire::Writer out = begin(PacketType::io_setup, version);
  for (const IoRow& row : setup)
    out.u32(static_cast<std::uint32_t>(row.direction)).u32(row.kind).u32(row.first).u32(row.count);
  return finish(out);
}

std::optional<IoSetup> decode_io_setup(Bytes packet) noexcept {
  if (!fits(packet, PacketType::io_setup, kIoSetupBytes)) return std::nullopt;
  wire::Reader in(packet.subspan(8));
  IoSetup out;
  for (IoRow& row : out) {
    const std::uint32_t direction = in.u32();
    if (direction > 4) return std::nullopt;
    row.direction = static_cast<IoDirection>(direction);
    row.kind = in.u32();
    row.first = in.u32();
    row.count = in.u32();
  }
  return out;
}

std::vector<std::uint8_t> encode_io_result(std::uint32_t result) {
  wire::Writer out;
  return finish(out.u32(static_cast<std::uint32_t>(PacketType::io_setup)).u32(result).u32(1));
}

std::optional<std::uint32_t> decode_io_result(Bytes packet) noexcept {
  if (!fits(packet, PacketType::io_setup, 12)) return std::nullopt;
  return wire::Reader(packet.subspan(4)).u32();
}

bool digital(const IoArea& area, std::size_t offset, std::size_t i) noexcept {
  const std::size_t at = offset + i / 8;
  return at < area.size() && (area[at] >> i % 8 & 1) != 0;
}

void set_digital(IoArea& area, std::size_t offset, std::size_t i, bool on) noexcept {
  const std::size_t at = offset + i / 8;
  if (at >= area.size()) return;
  const auto bit = static_cast<std::uint8_t>(1u << i % 8);
  area[at] = static_cast<std::uint8_t>(on ? area[at] | bit : area[at] & ~bit);
}

}  // namespace polyarm::fanuc
