#include "polyarm/signals/link.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <cmath>

#include "polyarm/base/text.hpp"
#include "polyarm/signals/remote_port.hpp"

namespace polyarm::signals {

namespace {
bool is_whole(LinkTag::Format format) {
  return format != LinkTag::Format::float32 && format != LinkTag::Format::float64;
}

/// The range of an integer format.
std::array<double, 2> range_of(LinkTag::Format format) {
  switch (format) {
    case LinkTag::Format::uint16:
      return {0, 65535};
    case LinkTag::Format::int16:
      return {-32768, 32767};
    case LinkTag::Format::uint32:
      return {0, 4294967295.0};
    case LinkTag::Format::int32:
      return {-2147483648.0, 2147483647.0};
    default:
      return {-1.7e308, 1.7e308};
  }
}

double fitted(const LinkTag& tag, double raw) {
  if (!std::isfinite(raw)) return 0;
  const auto [lower, upper] = range_of(tag.format);
  return std::clamp(is_whole(tag.format) && tag.topic.empty() ? std::round(raw) : raw, lower, upper);
}
}  // namespace

const char* name(Direction direction) {
  constexpr const char* kNames[] = {"in", "out", "both"};
  return kNames[static_cast<std::size_t>(direction)];
}

int LinkTag::registers() const {
  if (area == Area::coil || area == Area::discrete) return 1;
  constexpr int kWords[] = {1, 1, 2, 2, 2, 4};
  return kWords[static_cast<std::size_t>(format)] * (type == Type::pose ? kPoseNumbers : 1);
}

std::string LinkEntry::address() const {
  if (port == 0) return kind + (server ? " server" : "");
  return kind + (server ? " server at " : " at ") + host + ":" + std::to_string(port);
}

std::optional<std::string> PoseRange::refuses(const Pose& pose) const {
  const double position[] = {pose.position.x, pose.position.y, pose.position.z};
  const Quaternion& q = pose.rotation;
  for (const double number : {position[0], position[1], position[2], q.x, q.y, q.z, q.w})
    if (!std::isfinite(number)) return "it has a number that is not finite";
  if (std::abs(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w - 1) > 0.02)
    return "its quaternion is not of length 1";
  for (std::size_t k = 0; k < 3; ++k)
    if (position[k] < lower[k] || position[k] > upper[k])
      return std::string(1, "xyz"[k]) + " = " + format_number(position[k]) + " m is outside of " +
             format_number(lower[k]) + " to " + format_number(upper[k]) + " m";
  return std::nullopt;
}

std::optional<data::Value> taken_number(const LinkTag& tag, double raw, std::string& why) {
  const double value = tag.scale * raw + tag.offset;
  if (!std::isfinite(value)) {
    why = "it is not a finite number";
    return std::nullopt;
  }
  if (tag.range && (value < (*tag.range)[0] || value > (*tag.range)[1])) {
    why = format_number(value) + " is outside of " + format_number((*tag.range)[0]) + " to " +
          format_number((*tag.range)[1]);
    return std::nullopt;
  }
  return data::Value(value);
}

std::optional<data::Value> taken_pose(const LinkTag& tag, const std::vector<double>& raw, std::string& why) {
  if (raw.size() != 6 && raw.size() != 7) {
    why = "a pose has 6 or 7 numbers, here are " + std::to_string(raw.size());
    return std::nullopt;
  }
  for (const double number : raw)
    if (!std::isfinite(number)) {
      why = "it has a number that is not finite";
      return std::nullopt;
    }
  const Vec3 at{tag.scale * raw[0], tag.scale * raw[1], tag.scale * raw[2]};
  data::Point point;
  point.quaternion_given = raw.size() == 7;
  if (point.quaternion_given) {
    const double length = std::hypot(std::hypot(raw[3], raw[4]), std::hypot(raw[5], raw[6]));
    point.pose = {at, {raw[3], raw[4], raw[5], raw[6]}};
    if (std::abs(length - 1) < 0.01) point.pose.rotation = normalized(point.pose.rotation);
  } else {
    const double a = tag.angle_scale;
    if (std::max({std::abs(a * raw[3]), std::abs(a * raw[4]), std::abs(a * raw[5])}) > 9.5) {
      why = "its angles are more than one and a half turns; is its unit deg?";
      return std::nullopt;
    }
    point.pose = pose_xyz_rpy(at, {a * raw[3], a * raw[4], a * raw[5]});
  }
  if (const auto refused = tag.within.refuses(point.pose)) {
    why = *refused;
    return std::nullopt;
  }
  return data::Value(point);
}

double given_number(const LinkTag& tag, const data::Value& value) {
  if (const bool* flag = value.as_boolean()) return *flag ? 1 : 0;
  const data::Number* number = value.as_number();
  return number ? fitted(tag, (number->value - tag.offset) / tag.scale) : 0;
}

std::vector<double> given_pose(const LinkTag& tag, const data::Value& value) {
  const data::Point* point = value.as_point();
  if (!point) return {};
  const Vec3& at = point->pose.position;
  const Vec3 rpy = to_rpy(point->pose.rotation);
  std::vector<double> out = {at.x / tag.scale,        at.y / tag.scale,        at.z / tag.scale,
                             rpy.x / tag.angle_scale, rpy.y / tag.angle_scale, rpy.z / tag.angle_scale};
  for (double& number : out) number = fitted(tag, number);
  return out;
}

std::unique_ptr<LinkPort> load_link_port(const LinkEntry& entry,
                                         const std::vector<std::filesystem::path>& folders) {
  const std::string program = link_program(entry.kind), file = program + ".so";
  for (const std::filesystem::path& folder : folders) {
    std::error_code ignored;
    if (std::filesystem::is_regular_file(folder / program, ignored))
      return std::make_unique<RemotePort>(entry, (folder / program).string());
    if (!std::filesystem::exists(folder / file, ignored)) continue;
    void* const library = ::dlopen((folder / file).c_str(), RTLD_NOW | RTLD_LOCAL);  // stays loaded
    if (!library)
      throw Error(Problem{"no-link-module", {(folder / file).string()}, ::dlerror(), "build Polyarm again"});
    const auto make = reinterpret_cast<MakeLinkPort>(::dlsym(library, "polyarm_link_1"));
    if (!make)
      throw Error(Problem{
          "no-link-module", {(folder / file).string()}, "it is of another version", "build Polyarm again"});
    return std::unique_ptr<LinkPort>(make(entry));
  }
  throw Error(Problem{"no-link-module", entry.where,
                      "the link '" + entry.name + "' needs " + program + ", which is not built here",
                      "tools/setup installs what it needs; then build again"});
}

}  // namespace polyarm::signals
