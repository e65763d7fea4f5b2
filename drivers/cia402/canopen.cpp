#include "drivers/cia402/canopen.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace polyarm::cia402 {

const char* name(NmtState state) {
  switch (state) {
    case NmtState::boot_up:
      return "boot-up";
    case NmtState::stopped:
      return "stopped";
    case NmtState::operational:
      return "operational";
    case NmtState::pre_operational:
      return "pre-operational";
    case NmtState::unknown:
      break;
  }
  return "unknown";
}

void put(std::span<std::uint8_t> into, std::uint64_t value, std::size_t size) noexcept {
  for (std::size_t k = 0; k < size && k < into.size(); ++k)
    into[k] = static_cast<std::uint8_t>(value >> (8 * k));
}

std::uint64_t get(std::span<const std::uint8_t> from, std::size_t at, std::size_t size) noexcept {
  std::uint64_t out = 0;
  for (std::size_t k = 0; k < size && at + k < from.size(); ++k)
    out |= static_cast<std::uint64_t>(from[at + k]) << (8 * k);
  return out;
}

namespace {

CanFrame made(int base, int node, std::uint8_t size) noexcept {
  CanFrame out;
  out.id = static_cast<std::uint16_t>(base + node);
  out.size = size;
  return out;
}

CanFrame sdo(int node, std::uint8_t command, Object object) noexcept {
  CanFrame out = made(kSdoRequest, node, 8);
  out.data[0] = command;
  put(std::span(out.data).subspan(1), object.index, 2);
  out.data[3] = object.sub;
  return out;
}

}  // namespace

CanFrame nmt(NmtCommand command, int node) noexcept {
  CanFrame out = made(kNmt, 0, 2);
  out.data[0] = static_cast<std::uint8_t>(command);
  out.data[1] = static_cast<std::uint8_t>(node);
  return out;
}

CanFrame sync() noexcept {
  return made(kSync, 0, 0);
}

CanFrame heartbeat(int node, NmtState state) noexcept {
  CanFrame out = made(kHeartbeat, node, 1);
  out.data[0] = static_cast<std::uint8_t>(state);
  return out;
}

int node_of(const CanFrame& frame, std::uint16_t base) noexcept {
  const int node = frame.id - base;
  return node >= 1 && node <= kMostNode ? node : 0;
}

NmtState state_of_heartbeat(const CanFrame& frame) noexcept {
  if (frame.size < 1) return NmtState::unknown;
  const auto state = static_cast<NmtState>(frame.data[0] & 0x7F);
  switch (state) {
    case NmtState::boot_up:
    case NmtState::stopped:
    case NmtState::operational:
    case NmtState::pre_operational:
      return state;
    default:
      return NmtState::unknown;
  }
}

std::optional<Emergency> emergency_of(const CanFrame& frame) noexcept {
  if (frame.size < 3) return std::nullopt;
  return Emergency{static_cast<std::uint16_t>(get(frame.data, 0, 2)), frame.data[2]};
}

std::string text_of(Object object) {
  return fmt::format("0x{:04X}:{}", object.index, object.sub);
}

CanFrame upload_request(int node, Object object) noexcept {
  return sdo(node, 0x40, object);
}

CanFrame upload_segment_request(int node, bool toggle) noexcept {
  return sdo(node, toggle ? 0x70 : 0x60, {});
}

CanFrame download_request(int node, Object object, std::span<const std::uint8_t> bytes) noexcept {
  const std::size_t size = std::clamp<std::size_t>(bytes.size(), 1, 4);
  CanFrame out = sdo(node, static_cast<std::uint8_t>(0x23 | (4 - size) << 2), object);
  std::copy_n(bytes.begin(), std::min(size, bytes.size()), out.data.begin() + 4);
  return out;
}

CanFrame download_announcement(int node, Object object, std::uint32_t size) noexcept {
  CanFrame out = sdo(node, 0x21, object);
  put(std::span(out.data).subspan(4), size, 4);
  return out;
}

CanFrame download_segment(int node, bool toggle, bool last, std::span<const std::uint8_t> bytes) noexcept {
  CanFrame out = made(kSdoRequest, node, 8);
  const std::size_t size = std::min<std::size_t>(bytes.size(), 7);
  out.data[0] = static_cast<std::uint8_t>((toggle ? 0x10 : 0) | (7 - size) << 1 | (last ? 1 : 0));
  std::copy_n(bytes.begin(), size, out.data.begin() + 1);
  return out;
}

CanFrame sdo_abort(int node, Object object, std::uint32_t code) noexcept {
  CanFrame out = sdo(node, 0x80, object);
  put(std::span(out.data).subspan(4), code, 4);
  return out;
}

SdoAnswer read_answer(const CanFrame& frame) noexcept {
  SdoAnswer out;
  if (frame.size < 8) return out;
  const unsigned command = frame.data[0];
  const auto copy = [&](std::size_t from, std::size_t size) {
    out.size = static_cast<std::uint32_t>(size);
    std::copy_n(frame.data.begin() + static_cast<std::ptrdiff_t>(from), size, out.data.begin());
  };
  out.toggle = command & 0x10;
  if (const unsigned kind = command >> 5; kind == 0 || kind == 1) {
    out.kind = kind == 0 ? SdoKind::segment : SdoKind::segment_ok;
    out.last = command & 1;
    if (kind == 0) copy(1, 7 - (command >> 1 & 7));
    return out;
  }
  out.object = {static_cast<std::uint16_t>(get(frame.data, 1, 2)), frame.data[3]};
  if (command == 0x80) {
    out.kind = SdoKind::aborted;
    out.code = static_cast<std::uint32_t>(get(frame.data, 4, 4));
  } else if (command == 0x60) {
    out.kind = SdoKind::written;
  } else if (command >> 5 == 2 && command & 2) {
    out.kind = SdoKind::expedited;
    copy(4, command & 1 ? 4 - (command >> 2 & 3) : 4);
  } else if (command >> 5 == 2) {
    out.kind = SdoKind::announced;
    if (command & 1) out.size = static_cast<std::uint32_t>(get(frame.data, 4, 4));
  }
  return out;
}

namespace {

struct Words {
  std::uint32_t code;
  const char* words;
};

constexpr Words kAborts[] = {
    {0x05030000, "the toggle bit did not alternate"},
    {0x05040000, "the drive waited too long for the next frame"},
    {0x05040001, "the drive does not know the command"},
    {0x05040002, "the block size is invalid"},
    {0x05040003, "the sequence number is invalid"},
    {0x05040004, "the checksum is wrong"},
    {0x05040005, "there is no memory for it"},
    {0x06010000, "this access is not supported"},
    {0x06010001, "the object can only be written"},
    {0x06010002, "the object can only be read"},
    {0x06020000, "the object does not exist"},
    {0x06040041, "the object cannot be mapped to a PDO"},
    {0x06040042, "the objects are longer than a PDO"},
    {0x06040043, "parameters do not fit each other"},
    {0x06040047, "the drive contradicts itself"},
    {0x06060000, "its hardware failed"},
    {0x06070010, "the length does not fit"},
    {0x06070012, "the value is too long"},
    {0x06070013, "the value is too short"},
    {0x06090011, "the sub-index does not exist"},
    {0x06090030, "the value is out of range"},
    {0x06090031, "the value is too large"},
    {0x06090032, "the value is too small"},
    {0x06090036, "the maximum is below the minimum"},
    {0x060A0023, "the resource is not available"},
    {0x08000000, "general error"},
    {0x08000020, "the value cannot be stored"},
    {0x08000021, "the value cannot be stored because of local control"},
    {0x08000022, "not in the present state of the drive"},
    {0x08000023, "there is no object dictionary"},
    {0x08000024, "there are no data"},
};

/// Codes of CiA 402 and CiA 301.
constexpr Words kEmergencies[] = {
    {0x2110, "short circuit or earth leakage at the input"},
    {0x2120, "earth leakage at the input"},
    {0x2130, "short circuit at the input"},
    {0x2211, "internal current 1"},
    {0x2212, "internal current 2"},
    {0x2213, "over-current in the ramp"},
    {0x2214, "over-current in the sequence"},
    {0x2220, "continuous over-current inside the drive"},
    {0x2230, "short circuit or earth leakage inside the drive"},
    {0x2240, "earth leakage inside the drive"},
    {0x2250, "short circuit inside the drive"},
    {0x2310, "continuous over-current"},
    {0x2311, "over-current 1"},
    {0x2312, "over-current 2"},
    {0x2320, "short circuit or earth leakage at the motor"},
    {0x2330, "earth leakage at the motor"},
    {0x2340, "short circuit at the motor"},
    {0x3110, "mains over-voltage"},
    {0x3120, "mains under-voltage"},
    {0x3130, "a mains phase failed"},
    {0x3210, "DC link over-voltage"},
    {0x3220, "DC link under-voltage"},
    {0x3230, "load error"},
    {0x3310, "output over-voltage"},
    {0x4110, "ambient temperature too high"},
    {0x4120, "ambient temperature too low"},
    {0x4210, "drive too hot"},
    {0x4220, "drive too cold"},
    {0x4310, "drive temperature too high"},
    {0x4320, "drive temperature too low"},
    {0x4410, "supply temperature too high"},
    {0x5110, "low supply voltage"},
    {0x5112, "24 V supply low"},
    {0x5113, "5 V supply low"},
    {0x5210, "measurement circuit"},
    {0x5220, "computing circuit"},
    {0x5410, "output stage"},
    {0x5420, "brake chopper"},
    {0x5440, "contacts"},
    {0x5510, "memory (RAM)"},
    {0x5520, "memory (EPROM)"},
    {0x5530, "memory (EEPROM)"},
    {0x6010, "software reset by the drive's watchdog"},
    {0x6310, "parameters were lost"},
    {0x6320, "wrong parameter"},
    {0x7110, "brake chopper"},
    {0x7112, "over-current in the brake chopper"},
    {0x7121, "motor blocked"},
    {0x7122, "motor error or commutation"},
    {0x7123, "motor tilted"},
    {0x7301, "tacho failed"},
    {0x7303, "resolver 1 failed"},
    {0x7304, "resolver 2 failed"},
    {0x7305, "encoder 1 failed"},
    {0x7306, "encoder 2 failed"},
    {0x7310, "speed measurement"},
    {0x7320, "position measurement"},
    {0x7400, "computing circuit"},
    {0x7500, "communication"},
    {0x8110, "CAN overrun: messages were lost"},
    {0x8120, "CAN in error passive mode"},
    {0x8130, "the drive missed the heartbeat of this computer"},
    {0x8140, "CAN recovered from bus off"},
    {0x8150, "two devices use one CAN identifier"},
    {0x8210, "a PDO was too short"},
    {0x8220, "a PDO was too long"},
    {0x8240, "SYNC has a wrong length"},
    {0x8250, "a PDO did not come in time"},
    {0x8311, "torque too high"},
    {0x8312, "torque at start too high"},
    {0x8313, "torque at standstill"},
    {0x8321, "torque too low"},
    {0x8331, "torque error"},
    {0x8400, "speed controller"},
    {0x8500, "position controller"},
    {0x8611, "following error: the joint did not follow its target"},
    {0x8612, "a limit of the target position"},
    {0x8700, "SYNC controller"},
    {0x8800, "winding controller"},
};

/// The first hexadecimal digits of a code.
constexpr Words kClasses[] = {
    {0x1000, "generic error"},
    {0x2000, "current"},
    {0x3000, "voltage"},
    {0x4000, "temperature"},
    {0x5000, "hardware of the drive"},
    {0x6000, "software of the drive"},
    {0x7000, "an additional module"},
    {0x8000, "monitoring"},
    {0x9000, "external error"},
    {0xF000, "additional functions"},
};

const char* find(std::span<const Words> table, std::uint32_t code) {
  const auto row = std::find_if(table.begin(), table.end(), [&](const Words& w) { return w.code == code; });
  return row == table.end() ? nullptr : row->words;
}

}  // namespace

std::string emergency_words(std::uint16_t code) {
  if (code == 0) return "no error (0x0000)";
  const char* words = find(kEmergencies, code);
  if (!words && code >= 0xFF00) words = "an error of this maker's own";
  if (!words) words = find(kClasses, code & 0xF000U);
  return fmt::format("{} (0x{:04X})", words ? words : "an error that no standard names", code);
}

std::string abort_words(std::uint32_t code) {
  const char* const words = find(kAborts, code);
  return fmt::format("{} (0x{:08X})", words ? words : "a reason of this maker's own", code);
}

}  // namespace polyarm::cia402
