#pragma once
/// Packets of FANUC's Stream Motion (option J519), protocol versions 3 and 4. Degrees, millimetres, seconds.
/// Numbers are big-endian and packed; the 256 bytes of inputs and outputs are little-endian.
/// Layout: FANUC-CORPORATION/fanuc_driver v2.2.0, fanuc_libs/stream_motion. Const: any thread.
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "drivers/wire/bytes.hpp"
#include "drivers/wire/shaper.hpp"

namespace polyarm::fanuc {

using wire::Bytes;
using Nine = std::array<double, 9>;
using IoArea = std::array<std::uint8_t, 256>;

enum class PacketType : std::uint32_t {
  stop = 2,
  limits = 3,
  get_capability = 7,
  set_capability = 8,
  start = 200,
  command = 201,
  status = 202,  ///< version 3
  io_setup = 203,
  status_with_force = 204,  ///< version 4
  force_setup = 205,
};
inline constexpr std::uint32_t kOldestVersion = 3, kNewestVersion = 4;
inline constexpr std::size_t kCommandBytes = 344, kStatusBytes = 388, kForceStatusBytes = 416;

/// Bits of Status::status and Status::robot.
enum StatusBit : std::uint8_t { ready_bit = 1, received_bit = 2, system_ready_bit = 4, moving_bit = 8 };
enum RobotBit : std::uint8_t { error_bit = 1, teach_bit = 2, emergency_bit = 4 };
enum class ContactStop : std::uint8_t { none, safe, stop, disabled, escape };

struct Status {
  std::uint32_t version = kOldestVersion, sequence = 0;
  bool with_force = false;  ///< the packet of version 4
  std::uint8_t status = 0, robot = 0, contact_stop = 0;
  std::uint32_t time_ms = 0;
  std::array<float, 9> pose{}, joints{}, current{};  ///< mm and W P R in degrees; degrees; A
  float safety_scale = 1;
  std::array<float, 6> force{};        ///< N, N·m; version 4
  std::uint32_t sensor = 0xFFFFFFFFu;  ///< 0 none, 1 embedded, 2 external, all bits: not available
  IoArea io{};
};
std::vector<std::uint8_t> encode(const Status& status);
/// Empty: no status packet of a version from 3 to 4, or a number that is not finite.
std::optional<Status> decode_status(Bytes packet) noexcept;

struct Command {
  std::uint32_t version = kOldestVersion, sequence = 0;
  bool last = false;    ///< the motion ends with this command
  bool motion = false;  ///< false: only the outputs are commanded
  /// All bits: the values are joints. With 0 the controller takes them for a Cartesian pose.
  std::uint16_t style = 0xFFFF;
  Nine joints{};  ///< degrees
  IoArea io{};
};
std::vector<std::uint8_t> encode(const Command& command);
std::optional<Command> decode_command(Bytes packet) noexcept;

/// start and stop.
std::vector<std::uint8_t> encode_start(std::uint32_t version);
std::vector<std::uint8_t> encode_stop(std::uint32_t version);

struct Capability {
  bool set = false;
  std::uint32_t version = kOldestVersion;
  std::uint32_t sampling_ms = 0, start_move = 0, available = 0, uses_tcp = 0;
};
std::vector<std::uint8_t> encode(const Capability& capability);
std::optional<Capability> decode_capability(Bytes packet) noexcept;

using wire::LimitKind;
inline constexpr std::size_t kLimitSteps = 20;
/// The limits of an axis at equal steps of the Cartesian speed, from 0 to `max_speed`.
struct LimitTable {
  std::uint32_t axis = 1;  ///< from 1
  LimitKind kind = LimitKind::velocity;
  std::uint32_t max_speed = 2000, interval_ms = 8;  ///< mm/s
  std::array<float, kLimitSteps> empty{}, loaded{};
};
struct LimitRequest {
  std::uint32_t version = kOldestVersion, axis = 1;
  LimitKind kind = LimitKind::velocity;
};
std::vector<std::uint8_t> encode(const LimitRequest& request);
std::optional<LimitRequest> decode_limit_request(Bytes packet) noexcept;
std::vector<std::uint8_t> encode(const LimitTable& table, std::uint32_t version);
/// Empty too for a table with a limit that is not a number above 0.
std::optional<LimitTable> decode_limits(Bytes packet) noexcept;

enum class IoDirection : std::uint32_t { none, command, state, register_command, register_state };
enum class IoKind : std::uint32_t {
  digital_out,
  digital_in,
  robot_out,
  robot_in,
  analog_out,
  analog_in,
  flag
};
struct IoRow {
  IoDirection direction = IoDirection::none;
  std::uint32_t kind = 0;  ///< IoKind; 100 for registers
  std::uint32_t first = 1, count = 0;
  /// Bytes in the area: 32 digital values, 2 analog values or 1 register in each 4. 0: the row is not valid.
  std::size_t bytes() const noexcept;
};
inline constexpr std::size_t kIoRows = 32;
using IoSetup = std::array<IoRow, kIoRows>;
std::vector<std::uint8_t> encode(const IoSetup& setup, std::uint32_t version);
std::optional<IoSetup> decode_io_setup(Bytes packet) noexcept;
std::vector<std::uint8_t> encode_io_result(std::uint32_t result);
std::optional<std::uint32_t> decode_io_result(Bytes packet) noexcept;

/// The type word; 0 for a packet of less than four bytes.
std::uint32_t type_of(Bytes packet) noexcept;

/// The value of digital `i` of a block at `offset` of an area, and its change. Out of range: false, nothing.
bool digital(const IoArea& area, std::size_t offset, std::size_t i) noexcept;
void set_digital(IoArea& area, std::size_t offset, std::size_t i, bool on) noexcept;

}  // namespace polyarm::fanuc
