#include "drivers/xarm/report.hpp"

#include <algorithm>
#include <cmath>

namespace polyarm::xarm {

namespace {

// Places of the fields.
constexpr std::size_t kStateMode = 4, kQueued = 5, kPosition = 7, kPose = 35, kTorque = 59;
constexpr std::size_t kForce = 87;
constexpr std::size_t kBrakes = 87, kEnabled = 88, kError = 89, kWarning = 90, kOffset = 91, kLoad = 115,
                      kSensitivity = 131, kTeach = 132, kGravity = 133;
constexpr std::size_t kType = 145, kAxes = 146, kVersion = 151, kVersionSize = 30, kLimits = 181,
                      kInputs = 387, kOutputs = 391;
// Jerk, least and most acceleration and speed of the TCP (mm) and of joints (rad), jerk and acceleration of
// turns: as the maker's client has them without a report.
constexpr double kMotionLimits[] = {1000, 1, 50000, 0.1, 1000, 20, 0.01, 20, 0.0001, 4, 2.3, 2.7};
// Old firmware says less than it sends: 133 for 145 bytes, and 233 for 245.
constexpr std::size_t kOldNormal = 133, kOldRich = 233, kUncounted = 12;

std::size_t word_at(Bytes in, std::size_t at) {
  return static_cast<std::size_t>(in[at]) << 24 | static_cast<std::size_t>(in[at + 1]) << 16 |
         static_cast<std::size_t>(in[at + 2]) << 8 | in[at + 3];
}

int short_at(Bytes in, std::size_t at) {
  return in[at] << 8 | in[at + 1];
}

/// False if one is not finite.
template <std::size_t N>
bool read(Bytes in, std::size_t at, std::array<double, N>& out) {
  bool finite = true;
  for (std::size_t i = 0; i < N; ++i) {
    out[i] = float_at(in, at + 4 * i);
    finite = finite && std::isfinite(out[i]);
  }
  return finite;
}

}  // namespace

std::vector<std::uint8_t> encode(const Report& report, const SlowReport& slow, ReportKind kind) {
  const bool real = kind == ReportKind::real;
  const std::size_t size = kind == ReportKind::rich     ? kRichReport
                           : kind == ReportKind::normal ? kNormalReport
                           : report.has_force           ? kForceReport
                                                        : kCommonReport;
  UxData out;
  out.u32(size).u8(static_cast<unsigned>(report.mode) << 4 | static_cast<unsigned>(report.state));
  out.u16(static_cast<std::uint64_t>(report.queued));
  out.f32(report.position).f32(report.pose).f32(report.torque);
  if (real && report.has_force) out.f32(report.force).f32(report.force);
  if (!real) {
    out.u8(slow.brakes).u8(slow.enabled).u8(static_cast<std::uint64_t>(slow.error));
    out.u8(static_cast<std::uint64_t>(slow.warning)).f32(slow.tcp_offset).f32(slow.load);
    out.f32(slow.load_centre).u8(static_cast<std::uint64_t>(slow.collision_sensitivity));
    out.u8(static_cast<std::uint64_t>(slow.teach_sensitivity)).f32(slow.gravity);
  }
  std::vector<std::uint8_t> bytes = out.bytes();
  bytes.resize(size);
  if (kind != ReportKind::rich) return bytes;
  bytes[kType] = static_cast<std::uint8_t>(slow.type);
  bytes[kAxes] = static_cast<std::uint8_t>(slow.axes);
  std::copy_n(slow.version.begin(), std::min(kVersionSize, slow.version.size()), bytes.begin() + kVersion);
  const UxData limits = UxData().f32(kMotionLimits);
  std::copy(limits.bytes().begin(), limits.bytes().end(), bytes.begin() + kLimits);
  const auto put = [&](std::size_t at, int value) {
    bytes[at] = static_cast<std::uint8_t>(value >> 8);
    bytes[at + 1] = static_cast<std::uint8_t>(value);
  };
  put(kInputs, slow.inputs);
  put(kOutputs, slow.outputs);
  return bytes;
}

std::optional<Report> decode_report(Bytes in, ReportKind kind) {
  if (in.size() < kCommonReport) return std::nullopt;
  Report out;
  out.state = static_cast<State>(in[kStateMode] & 0x0F);
  out.mode = static_cast<Mode>(in[kStateMode] >> 4);
  out.queued = short_at(in, kQueued);
  if (!read(in, kPosition, out.position) || !read(in, kPose, out.pose)) return std::nullopt;
  read(in, kTorque, out.torque);
  if (kind == ReportKind::real && in.size() >= kForceReport) out.has_force = read(in, kForce, out.force);
  return out;
}

std::optional<SlowReport> decode_slow_report(Bytes in) {
  if (in.size() < kNormalReport) return std::nullopt;
  SlowReport out;
  out.brakes = in[kBrakes];
  out.enabled = in[kEnabled];
  out.error = in[kError];
  out.warning = in[kWarning];
  out.load = float_at(in, kLoad);
  out.collision_sensitivity = in[kSensitivity];
  out.teach_sensitivity = in[kTeach];
  if (!read(in, kOffset, out.tcp_offset) || !read(in, kLoad + 4, out.load_centre) ||
      !read(in, kGravity, out.gravity) || !std::isfinite(out.load))
    return std::nullopt;
  if (in.size() < kVersion + kVersionSize) return out;
  out.type = in[kType];
  out.axes = in[kAxes];
  for (std::size_t i = 0; i < kVersionSize && in[kVersion + i] >= 32 && in[kVersion + i] < 127; ++i)
    out.version += static_cast<char>(in[kVersion + i]);
  if (in.size() < kOutputs + 2) return out;
  out.inputs = static_cast<std::uint16_t>(short_at(in, kInputs));
  out.outputs = static_cast<std::uint16_t>(short_at(in, kOutputs));
  return out;
}

std::size_t ReportReader::length() const {
  const std::size_t said = word_at(buffer_, 0);
  return said == kOldNormal || said == kOldRich ? said + kUncounted : said;
}

bool ReportReader::length_is_wrong() const {
  return buffer_.size() >= 4 && (length() < kCommonReport || length() > kLongestReport);
}

bool ReportReader::feed(Bytes bytes) {
  if (length_is_wrong()) return false;
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  return !length_is_wrong();
}

std::optional<std::vector<std::uint8_t>> ReportReader::next() {
  if (buffer_.size() < 4 || length_is_wrong() || buffer_.size() < length()) return std::nullopt;
  const auto end = buffer_.begin() + static_cast<std::ptrdiff_t>(length());
  std::vector<std::uint8_t> out(buffer_.begin(), end);
  buffer_.erase(buffer_.begin(), end);
  return out;
}

}  // namespace polyarm::xarm
