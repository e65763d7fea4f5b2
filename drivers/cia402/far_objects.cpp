/// The object dictionary of a simulated drive, and its SDO server.
#include <algorithm>
#include <cmath>

#include "drivers/cia402/far_drive.hpp"

namespace polyarm::cia402 {

namespace {
constexpr std::size_t kMostLog = 1000, kLongestTransfer = 256;
constexpr std::uint32_t kPdoOff = 0x8000'0000;

void append(std::vector<std::uint8_t>& bytes, std::uint32_t value, int size) {
  for (int k = 0; k < size; ++k) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * k)));
}

std::uint32_t number(const std::vector<std::uint8_t>& bytes) {
  std::uint32_t out = 0;
  for (std::size_t k = 0; k < bytes.size() && k < 4; ++k)
    out |= static_cast<std::uint32_t>(bytes[k]) << (8 * k);
  return out;
}
}  // namespace

void FarDrive::add(std::uint16_t index, std::uint8_t sub, std::uint8_t size, std::uint32_t value,
                   bool writable, bool mappable) {
  entries_[key(index, sub)] = {value, size, writable, mappable};
}

/// As after switching on.
void FarDrive::fill() {
  entries_.clear();
  const auto n = static_cast<std::uint32_t>(options_.node);
  add(0x1000, 0, 4, 0x0002'0192, false);  // a servo drive with CiA 402
  add(0x1001, 0, 1, 0, false, true);
  add(0x1014, 0, 4, 0x80 + n, true);
  add(0x1016, 0, 1, 1, false);
  add(0x1016, 1, 4, 0, true);
  add(0x1017, 0, 2, 0, true);
  add(0x1018, 0, 1, 3, false);
  add(0x1018, 1, 4, 0x0000'0000, false);
  add(0x1018, 2, 4, 0x4021, false);
  add(0x1018, 3, 4, 0x0001'0000, false);
  add_pdos();
  add(0x6007, 0, 2, 0, true);
  add(0x603F, 0, 2, 0, false, true);
  add(0x6040, 0, 2, 0, true, true);
  add(0x6041, 0, 2, 0, false, true);
  add(0x605A, 0, 2, 2, true);
  add(0x6060, 0, 1, 1, true, true);
  add(0x6061, 0, 1, 1, false, true);
  add(0x6064, 0, 4, 0, false, true);
  add(0x6065, 0, 4, 2000, true);
  add(0x606C, 0, 4, 0, false, true);
  add(0x6072, 0, 2, 1000, true);
  add(0x6076, 0, 4, options_.rated_torque, false);
  add(0x6077, 0, 2, 0, false, true);
  add(0x607A, 0, 4, 0, true, true);
  add(0x607C, 0, 4, 0, true);
  add(0x607D, 1, 4, 0x8000'0000, true);
  add(0x607D, 2, 4, 0x7FFF'FFFF, true);
  add(0x6080, 0, 4, 5000, true);
  add(0x6085, 0, 4, static_cast<std::uint32_t>(20 * std::abs(options_.counts_per_rad)), true);
  add(0x6098, 0, 1, 0, true);
  add(0x60C2, 1, 1, 1, true);
  add(0x60C2, 2, 1, 0xFD, true);
  add(0x6502, 0, 4, 0x0000'00A5, false);  // profile position and velocity, homing, cyclic position
}

/// Four of each direction; those that a maker maps by default send at events.
void FarDrive::add_pdos() {
  const auto n = static_cast<std::uint32_t>(options_.node);
  for (std::uint16_t k = 0; k < 4; ++k) {
    const auto at = [&](int base) { return static_cast<std::uint16_t>(base + k); };
    add(at(0x1400), 0, 1, 2, false);
    add(at(0x1400), 1, 4, 0x200 + 0x100U * k + n, true);
    add(at(0x1400), 2, 1, 255, true);
    add(at(0x1800), 0, 1, 2, false);
    add(at(0x1800), 1, 4, 0x4000'0180U + 0x100U * k + n, true);
    add(at(0x1800), 2, 1, 255, true);
    for (const int base : {0x1600, 0x1A00}) {
      add(at(base), 0, 1, 1, true);
      add(at(base), 1, 4, base == 0x1600 ? 0x6040'0010 : 0x6041'0010, true);
      for (std::uint8_t sub = 2; sub <= 8; ++sub) add(at(base), sub, 4, 0, true);
    }
  }
}

std::uint32_t FarDrive::value(std::uint16_t index, std::uint8_t sub) const {
  const auto found = entries_.find(key(index, sub));
  return found == entries_.end() ? 0 : found->second.value;
}

std::int32_t FarDrive::signed_value(std::uint16_t index, std::uint8_t sub) const {
  const auto found = entries_.find(key(index, sub));
  if (found == entries_.end()) return 0;
  const int unused = 32 - 8 * found->second.size;
  return static_cast<std::int32_t>(found->second.value << unused) >> unused;
}

const std::vector<std::uint32_t>& FarDrive::written(std::uint16_t index, std::uint8_t sub) {
  return log_[key(index, sub)];
}

// --- SDO server -------------------------------------------------------------------------------------------

void FarDrive::answer(std::vector<std::uint8_t> bytes, Frames& out) {
  bytes.resize(8);
  send(static_cast<std::uint16_t>(0x580 + options_.node), std::move(bytes), out);
}

void FarDrive::abort(std::uint16_t index, std::uint8_t sub, std::uint32_t code, Frames& out) {
  transfer_.active = false;
  std::vector<std::uint8_t> bytes{0x80};
  append(bytes, index, 2);
  bytes.push_back(sub);
  append(bytes, code, 4);
  answer(std::move(bytes), out);
}

void FarDrive::serve_sdo(const CanFrame& frame, Frames& out) {
  if (frame.size != 8 || faults.sdo_mute) return;
  if (faults.sdo_wrong) return answer({0xE0, frame.data[1], frame.data[2], frame.data[3]}, out);
  const unsigned command = frame.data[0];
  const auto index = static_cast<std::uint16_t>(frame.data[1] | frame.data[2] << 8);
  switch (command >> 5) {
    case 0:
      return download_segment(frame, out);
    case 1:
      return download(frame, out);
    case 2:
      return upload(index, frame.data[3], out);
    case 3:
      return upload_segment(command, out);
    case 4:
      transfer_.active = false;
      return;
    default:
      return abort(index, frame.data[3], 0x0504'0001, out);
  }
}

void FarDrive::upload(std::uint16_t index, std::uint8_t sub, Frames& out) {
  refresh();
  std::vector<std::uint8_t> bytes;
  if (index == 0x1008 && sub == 0) {
    bytes.assign(name_.begin(), name_.end());
  } else {
    const auto found = entries_.find(key(index, sub));
    if (found == entries_.end() || (faults.hides && (index == 0x6502 || index == 0x60C2))) {
      const bool index_exists = entries_.lower_bound(key(index, 0)) != entries_.end() &&
                                entries_.lower_bound(key(index, 0))->first >> 8 == index;
      return abort(index, sub, index_exists ? 0x0609'0011 : 0x0602'0000, out);
    }
    append(bytes, found->second.value, found->second.size);
  }
  std::vector<std::uint8_t> head{0x41};
  append(head, index, 2);
  head.push_back(sub);
  if (bytes.size() <= 4) {
    head[0] = static_cast<std::uint8_t>(0x43 | (4 - bytes.size()) << 2);
    head.insert(head.end(), bytes.begin(), bytes.end());
    return answer(std::move(head), out);
  }
  append(head, static_cast<std::uint32_t>(bytes.size()), 4);
  transfer_ = {std::move(bytes), 0, 0, index, sub, false, true, false};
  answer(std::move(head), out);
}

void FarDrive::upload_segment(unsigned command, Frames& out) {
  if (!transfer_.active || transfer_.download) return abort(0, 0, 0x0504'0001, out);
  if (static_cast<bool>(command & 0x10) != transfer_.toggle)
    return abort(transfer_.index, transfer_.sub, 0x0503'0000, out);
  const std::size_t count = std::min<std::size_t>(7, transfer_.bytes.size() - transfer_.at);
  const bool last = transfer_.at + count == transfer_.bytes.size();
  std::vector<std::uint8_t> bytes{
      static_cast<std::uint8_t>((transfer_.toggle ? 0x10 : 0) | (7 - count) << 1 | (last ? 1 : 0))};
  for (std::size_t k = 0; k < count; ++k) bytes.push_back(transfer_.bytes[transfer_.at + k]);
  transfer_.at += count;
  transfer_.toggle = !transfer_.toggle;
  transfer_.active = !last;
  answer(std::move(bytes), out);
}

void FarDrive::download(const CanFrame& frame, Frames& out) {
  const unsigned command = frame.data[0];
  const auto index = static_cast<std::uint16_t>(frame.data[1] | frame.data[2] << 8);
  const std::uint8_t sub = frame.data[3];
  std::vector<std::uint8_t> head{0x60, frame.data[1], frame.data[2], sub};
  if (!(command & 2)) {  // segments follow
    const std::vector<std::uint8_t> size(frame.data.begin() + 4, frame.data.end());
    if (number(size) > kLongestTransfer) return abort(index, sub, 0x0504'0005, out);
    transfer_ = {{}, 0, number(size), index, sub, false, true, true};
    return answer(std::move(head), out);
  }
  const std::size_t count = command & 1 ? 4 - (command >> 2 & 3) : 4;
  const std::vector<std::uint8_t> bytes(frame.data.begin() + 4,
                                        frame.data.begin() + 4 + static_cast<std::ptrdiff_t>(count));
  if (const std::uint32_t code = write(index, sub, bytes, out)) return abort(index, sub, code, out);
  answer(std::move(head), out);
}

void FarDrive::download_segment(const CanFrame& frame, Frames& out) {
  if (!transfer_.active || !transfer_.download) return abort(0, 0, 0x0504'0001, out);
  const unsigned command = frame.data[0];
  if (static_cast<bool>(command & 0x10) != transfer_.toggle)
    return abort(transfer_.index, transfer_.sub, 0x0503'0000, out);
  const std::size_t count = 7 - (command >> 1 & 7);
  transfer_.bytes.insert(transfer_.bytes.end(), frame.data.begin() + 1,
                         frame.data.begin() + 1 + static_cast<std::ptrdiff_t>(count));
  if (transfer_.bytes.size() > kLongestTransfer)
    return abort(transfer_.index, transfer_.sub, 0x0607'0012, out);
  if (command & 1) {
    transfer_.active = false;
    if (const std::uint32_t code = write(transfer_.index, transfer_.sub, transfer_.bytes, out))
      return abort(transfer_.index, transfer_.sub, code, out);
  }
  answer({static_cast<std::uint8_t>(0x20 | (transfer_.toggle ? 0x10 : 0))}, out);
  transfer_.toggle = !transfer_.toggle;
}

std::uint32_t FarDrive::check_mapping(std::uint16_t index, std::uint8_t sub, std::uint32_t value) const {
  const auto communication = static_cast<std::uint16_t>(index - 0x200);
  if (!(this->value(communication, 1) & kPdoOff)) return 0x0601'0000;  // it is in use
  if (faults.refuse_mapping) return 0x0604'0041;
  if (sub != 0) {
    if (this->value(index, 0) != 0) return 0x0601'0000;  // its number of objects is not 0
    const auto found = entries_.find(value >> 8);
    return found != entries_.end() && found->second.mappable && (value & 0xFF) == found->second.size * 8U
               ? 0
               : 0x0604'0041;
  }
  unsigned bits = 0;
  if (value > 8) return 0x0604'0042;
  for (std::uint8_t k = 1; k <= value; ++k) bits += this->value(index, k) & 0xFF;
  return bits > 64 ? 0x0604'0042 : 0;
}

/// 0, or why not.
std::uint32_t FarDrive::write(std::uint16_t index, std::uint8_t sub, const std::vector<std::uint8_t>& bytes,
                              Frames& out) {
  if (faults.unwatched && (index == 0x1016 || index == 0x6007)) return 0x0602'0000;
  const auto found = entries_.find(key(index, sub));
  if (found == entries_.end()) return 0x0602'0000;
  if (!found->second.writable) return 0x0601'0002;
  if (bytes.size() != found->second.size) return 0x0607'0010;
  const std::uint32_t value = number(bytes);
  if ((index >= 0x1600 && index < 0x1604) || (index >= 0x1A00 && index < 0x1A04))
    if (const std::uint32_t code = check_mapping(index, sub, value)) return code;
  if (index == 0x60C2 && sub == 1 && value == 0) return 0x0609'0030;
  if (faults.forgetful && index == 0x60C2) return 0;
  found->second.value = value;
  auto& log = log_[key(index, sub)];
  if (log.size() < kMostLog) log.push_back(value);
  if (index == 0x1016) master_seen_ = master_lost_ = false;
  if (index == 0x6040) apply_control(value, out);
  return 0;
}

}  // namespace polyarm::cia402
