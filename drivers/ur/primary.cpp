#include "drivers/ur/primary.hpp"

#include <cmath>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/pose.hpp"

namespace polyarm::ur {

namespace {

constexpr std::uint8_t kKinematicsPart = 5, kConfigurationPart = 6;

std::array<double, 6> six(wire::Reader& in) {
  std::array<double, 6> out{};
  for (double& value : out) value = in.f64();
  return out;
}

void read_message(wire::Reader in, std::vector<PrimaryEvent>& events) {
  in.u64();  // time
  in.u8();   // source
  const std::uint8_t type = in.u8();
  PrimaryEvent event{};
  switch (type) {
    case kVersionMessage:
      event.kind = PrimaryEvent::Kind::version;
      in.take(in.u8());  // the project's name
      event.code = in.u8();
      event.argument = in.u8();
      event.text =
          std::to_string(event.code) + "." + std::to_string(event.argument) + "." + std::to_string(in.i32());
      break;
    case kTextMessage:
      event.kind = PrimaryEvent::Kind::text;
      event.text = in.text(in.left());
      break;
    case kErrorMessage:
      event.kind = PrimaryEvent::Kind::error;
      event.code = in.i32();
      event.argument = in.i32();
      in.take(12);  // level, type and value of the data
      event.text = in.text(in.left());
      break;
    case kExceptionMessage:
      event.kind = PrimaryEvent::Kind::exception;
      event.code = in.i32();
      event.argument = in.i32();
      event.text = in.text(in.left());
      break;
    case kKeyMessage: {
      in.take(8);
      const std::string title = in.text(in.u8());
      event.text = in.text(in.left());
      if (title == "PROGRAM_XXX_STARTED")
        event.kind = PrimaryEvent::Kind::started;
      else if (title == "PROGRAM_XXX_STOPPED")
        event.kind = PrimaryEvent::Kind::stopped;
      else
        return;
      break;
    }
    default:
      return;
  }
  if (in.ok()) events.push_back(std::move(event));
}

void read_state(wire::Reader in, std::vector<PrimaryEvent>& events) {
  while (in.ok() && in.left() >= 5) {
    const std::uint32_t size = in.u32();
    const std::uint8_t type = in.u8();
    if (size < 5) return;
    wire::Reader part(in.take(size - 5));
    if (!in.ok()) return;
    PrimaryEvent event{};
    if (type == kKinematicsPart) {
      event.kind = PrimaryEvent::Kind::kinematics;
      part.take(24);  // checksums
      event.kinematics.theta = six(part);
      event.kinematics.a = six(part);
      event.kinematics.d = six(part);
      event.kinematics.alpha = six(part);
    } else if (type == kConfigurationPart) {
      event.kind = PrimaryEvent::Kind::configuration;
      part.take((6 * 2 + 6 * 2 + 5) * 8);  // limits and defaults
      event.kinematics.a = six(part);
      event.kinematics.d = six(part);
      event.kinematics.alpha = six(part);
      event.kinematics.theta = six(part);
    } else {
      continue;
    }
    if (part.ok()) events.push_back(std::move(event));
  }
}

wire::Writer message(std::uint64_t time, std::uint8_t type) {
  wire::Writer out;
  out.u64(time).u8(254).u8(type);
  return out;
}

Quaternion about(const Vec3& axis, double angle) {
  const double s = std::sin(angle / 2);
  return {axis.x * s, axis.y * s, axis.z * s, std::cos(angle / 2)};
}

}  // namespace

std::array<double, 6> flange_pose(const Kinematics& k, const std::array<double, 6>& q) {
  Vec3 p{};
  Quaternion r{};
  for (std::size_t i = 0; i < 6; ++i) {
    p = p + r * Vec3{0, 0, k.d[i]};
    r = r * about({0, 0, 1}, q[i] + k.theta[i]);
    p = p + r * Vec3{k.a[i], 0, 0};
    r = r * about({1, 0, 0}, k.alpha[i]);
  }
  const Vec3 v{r.x, r.y, r.z};
  const double sine = norm(v);
  double angle = 2 * std::atan2(sine, r.w);
  if (angle > M_PI) angle -= 2 * M_PI;
  const Vec3 turn = sine > 0 ? angle / sine * v : Vec3{};
  return {p.x, p.y, p.z, turn.x, turn.y, turn.z};
}

bool PrimaryStream::feed(wire::Bytes bytes, std::vector<PrimaryEvent>& events) {
  if (broken_) return false;
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  std::size_t at = 0;
  while (buffer_.size() - at >= 5) {
    wire::Reader in(wire::Bytes(buffer_).subspan(at));
    const std::uint32_t size = in.u32();
    const std::uint8_t type = in.u8();
    if (size < 5 || size > bounds::kPrimaryBytes) {
      broken_ = true;
      buffer_.clear();
      return false;
    }
    if (buffer_.size() - at < size) break;
    const wire::Reader body(in.take(size - 5));
    if (type == kRobotMessage) read_message(body, events);
    if (type == kRobotState) read_state(body, events);
    at += size;
  }
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(at));
  return true;
}

std::vector<std::uint8_t> primary_package(std::uint8_t type, wire::Bytes body) {
  wire::Writer out;
  out.u32(body.size() + 5).u8(type).append(body);
  return out.bytes();
}

std::vector<std::uint8_t> version_message(std::uint64_t time, int major, int minor, int bugfix) {
  wire::Writer out = message(time, kVersionMessage);
  out.u8(9).text("URControl").u8(static_cast<std::uint64_t>(major)).u8(static_cast<std::uint64_t>(minor));
  out.i32(bugfix).i32(0).text("01-01-2026, 00:00:00");
  return primary_package(kRobotMessage, out.bytes());
}

std::vector<std::uint8_t> key_message(std::uint64_t time, const std::string& title, const std::string& text) {
  wire::Writer out = message(time, kKeyMessage);
  out.i32(0).i32(0).u8(title.size()).text(title).text(text);
  return primary_package(kRobotMessage, out.bytes());
}

std::vector<std::uint8_t> error_message(std::uint64_t time, int code, int argument, int level,
                                        const std::string& text) {
  wire::Writer out = message(time, kErrorMessage);
  out.i32(code).i32(argument).i32(level).u32(0).u32(0).text(text);
  return primary_package(kRobotMessage, out.bytes());
}

std::vector<std::uint8_t> exception_message(std::uint64_t time, int line, int column,
                                            const std::string& text) {
  wire::Writer out = message(time, kExceptionMessage);
  out.i32(line).i32(column).text(text);
  return primary_package(kRobotMessage, out.bytes());
}

}  // namespace polyarm::ur
