#include "polyarm/ros_files/json_trajectory.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "polyarm/ros_files/message_forms.hpp"

namespace polyarm::ros_files {

namespace json_trajectory {
namespace {

using nlohmann::json;
using trajectory::TrajectoryPoint;

constexpr std::size_t kShort = 16;  // fewer points are read as text, so that errors have a location
constexpr int kDeepest = 4;         // {goal: {trajectory: {points}}}

/// The list of points in a message; null if there is none.
const json* points_of(const json& message, int depth = 0) {
  if (!message.is_object() || depth > kDeepest) return nullptr;
  if (const auto points = message.find("points"); points != message.end())
    return points->is_array() ? &*points : nullptr;
  for (const char* inner : {"goal", "trajectory"})
    if (const auto found = message.find(inner); found != message.end()) return points_of(*found, depth + 1);
  return nullptr;
}

bool read_numbers(const json& list, std::vector<double>& out) {
  if (!list.is_array()) return false;
  out.reserve(list.size());
  for (const json& value : list) {
    if (!value.is_number()) return false;
    out.push_back(value.get<double>());
    if (!std::isfinite(out.back())) return false;
  }
  return true;
}

bool read_duration(const json& value, double& out) {
  if (value.is_number()) {
    out = value.get<double>();
    return std::isfinite(out);
  }
  if (!value.is_object() || value.size() != 2) return false;
  const auto whole = value.find("sec"), part = value.find("nanosec");
  if (whole == value.end() || part == value.end() || !whole->is_number() || !part->is_number()) return false;
  out = whole->get<double>() + part->get<double>() * 1e-9;
  return std::isfinite(out);
}

bool read_point(const json& from, TrajectoryPoint& out) {
  if (!from.is_object()) return false;
  bool timed = false;
  for (const auto& [key, value] : from.items()) {
    std::vector<double>* const list = key == "positions"       ? &out.positions
                                      : key == "velocities"    ? &out.velocities
                                      : key == "accelerations" ? &out.accelerations
                                      : key == "effort"        ? &out.effort
                                                               : nullptr;
    if (list ? !read_numbers(value, *list)
             : key != "time_from_start" || !read_duration(value, out.time_from_start))
      return false;
    timed = timed || !list;
  }
  return timed;
}

/// The message with empty lists of points.
json without_points(const json& from, int depth = 0) {
  if (!from.is_object() || depth > kDeepest) return from;
  json out = json::object();
  for (const auto& [key, value] : from.items())
    out[key] = key == "points" ? json::array() : without_points(value, depth + 1);
  return out;
}

}  // namespace
}  // namespace json_trajectory

std::optional<controllers::Input> read_json_trajectory(const nlohmann::json& message, const std::string& name,
                                                       const std::vector<std::string>& types) {
  const nlohmann::json* const given = json_trajectory::points_of(message);
  if (!given || given->size() < json_trajectory::kShort) return std::nullopt;
  std::vector<trajectory::TrajectoryPoint> points(given->size());
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!json_trajectory::read_point((*given)[i], points[i])) return std::nullopt;
  controllers::Input out = read_message(
      json_trajectory::without_points(message).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace),
      name, types);
  auto* const read = std::get_if<controllers::TrajectoryMessage>(&out);
  if (!read) return std::nullopt;
  read->points = std::move(points);
  return out;
}

}  // namespace polyarm::ros_files
