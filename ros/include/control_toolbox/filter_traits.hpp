#pragma once
/// The numbers of what filters work on: a double, a list of them, or the force and torque of a wrench.
#include <array>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

#include "geometry_msgs/msg/wrench_stamped.hpp"
#include "polyarm_ros/standard.hpp"

namespace control_toolbox {

template <typename T>
struct FilterNumbers;
template <>
struct FilterNumbers<double> {
  using Storage = std::array<double, 1>;
  static Storage read(const double& from) { return {from}; }
  static void write(const Storage& from, const double&, double& to) { to = from[0]; }
};
template <>
struct FilterNumbers<std::vector<double>> {
  using Storage = std::vector<double>;
  static const Storage& read(const std::vector<double>& from) { return from; }
  static void write(const Storage& from, const std::vector<double>&, std::vector<double>& to) { to = from; }
};
template <>
struct FilterNumbers<geometry_msgs::msg::WrenchStamped> {
  using Message = geometry_msgs::msg::WrenchStamped;
  using Storage = std::array<double, 6>;
  static Storage read(const Message& from) {
    const auto &f = from.wrench.force, &t = from.wrench.torque;
    return {f.x, f.y, f.z, t.x, t.y, t.z};
  }
  static void write(const Storage& n, const Message& in, Message& to) {
    to.header = in.header;
    auto &f = to.wrench.force, &t = to.wrench.torque;
    f.x = n[0], f.y = n[1], f.z = n[2], t.x = n[3], t.y = n[4], t.z = n[5];
  }
};

template <typename Storage>
bool all_finite(const Storage& numbers) {
  for (const double each : numbers)
    if (!std::isfinite(each)) return false;
  return true;
}

}  // namespace control_toolbox
