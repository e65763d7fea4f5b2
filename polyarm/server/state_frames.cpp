#include "polyarm/server/state_frames.hpp"

#include <bit>
#include <cstring>
#include <limits>

#include "polyarm/server/documents.hpp"

namespace polyarm::server {

namespace {

static_assert(std::endian::native == std::endian::little, "frames are written as they lie in memory");

template <typename T>
void append(std::string& out, T value) {
  char bytes[sizeof value];
  std::memcpy(bytes, &value, sizeof value);
  out.append(bytes, sizeof bytes);
}

std::string ending(const std::string& name) {
  return name.substr(name.rfind('/') + 1);
}

/// Unit of an interface with this name; it differs for prismatic joints (`slides`).
std::string unit_of(const std::string& interface, bool slides) {
  if (interface == "position") return slides ? "m" : "rad";
  if (interface == "velocity") return slides ? "m/s" : "rad/s";
  if (interface == "acceleration") return slides ? "m/s2" : "rad/s2";
  if (interface == "effort" || interface == "torque") return slides ? "N" : "Nm";
  return "";
}

bool slides(const cell::CellView& cell, const std::string& name) {
  const std::string joint = name.substr(0, name.rfind('/'));
  for (const auto& robot : cell.robots())
    for (std::size_t j = 0; j < robot->joints.size(); ++j)
      if (robot->joints[j].name == joint) return robot->facts->chain.slides(j);
  return false;
}

}  // namespace

StateFrames::StateFrames(cell::CellView& cell, std::uint16_t layout) : cell_(cell), id_(layout) {
  const hardware::InterfaceTable& table = cell.table();
  for (const std::string& name : table.state_names()) add(name, unit_of(ending(name), slides(cell, name)));
  for (const std::string& name : table.command_names()) {
    const std::string owner = name.substr(0, name.rfind('/') + 1);
    add(owner + "command_" + ending(name), unit_of(ending(name), slides(cell, name)));
  }
  for (const auto& robot : cell.robots()) {
    for (const char* axis : {"x", "y", "z"}) add(robot->entry.name + "/tcp/" + axis, "m");
    for (const char* axis : {"qx", "qy", "qz", "qw"}) add(robot->entry.name + "/tcp/" + axis, "");
    add(robot->entry.name + "/tcp/speed", "m/s");
  }
  for (std::size_t i = 0; i < cell.robots().size(); ++i) {
    if (!cell.base(i).moves() || cell.base(i).in_physics()) continue;
    wheeled_.push_back(i);
    const std::string base = cell.robots()[i]->entry.name + "/base/";
    for (const char* axis : {"x", "y", "z"}) add(base + "position." + axis, "m");
    for (const char* axis : {"x", "y", "z", "w"}) add(base + "orientation." + axis, "");
  }
  add("loop/period_us", "us");
  add("loop/cost_us", "us");
  add("loop/late", "");
  Json fields = Json::array();
  for (const Field& field : fields_) fields.push_back({{"name", field.name}, {"unit", field.unit}});
  layout_ = std::make_shared<const std::string>(dump({{"event", "layout"}, {"id", id_}, {"fields", fields}}));
  before_.resize(cell.robots().size());
  speed_.resize(cell.robots().size());
}

Text StateFrames::frame() {
  const control::Snapshot& seen = cell_.snapshot();
  const hardware::InterfaceTable& table = cell_.table();
  const double now = seconds(seen.cycle.time), dt = now - before_time_;
  std::string out;
  out.reserve(16 + 4 * fields_.size());
  append(out, std::uint8_t{1});
  append(out, std::uint8_t{0});
  append(out, id_);
  append(out, ++sequence_);
  append(out, now);
  const auto numbers = [&](const std::vector<double>& values, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i)
      append(out,
             i < values.size() ? static_cast<float>(values[i]) : std::numeric_limits<float>::quiet_NaN());
  };
  numbers(seen.states, table.state_names().size());
  numbers(seen.commands, table.command_names().size());
  for (std::size_t i = 0; i < cell_.robots().size(); ++i) {
    const Pose tcp = cell_.tcp(i);
    if (before_time_ < 0)
      speed_[i] = 0;
    else if (dt > 1e-9)
      speed_[i] = norm(tcp.position - before_[i].position) / dt;
    before_[i] = tcp;
    const Vec3& p = tcp.position;
    const Quaternion& q = tcp.rotation;
    for (const double value : {p.x, p.y, p.z, q.x, q.y, q.z, q.w, speed_[i]})
      append(out, static_cast<float>(value));
  }
  for (const std::size_t i : wheeled_) {
    const auto [p, q] = cell_.base(i).pose(seen);
    for (const double value : {p.x, p.y, p.z, q.x, q.y, q.z, q.w}) append(out, static_cast<float>(value));
  }
  before_time_ = now;
  const control::Health& health = cell_.health();
  append(out, static_cast<float>(static_cast<double>(health.period.percentile(0.5)) * 1e-3));
  append(out, static_cast<float>(static_cast<double>(health.cost.percentile(0.5)) * 1e-3));
  append(out, static_cast<float>(static_cast<double>(std::uint64_t{health.late})));
  return std::make_shared<const std::string>(std::move(out));
}

}  // namespace polyarm::server
