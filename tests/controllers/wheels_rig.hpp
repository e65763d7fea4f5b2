#pragma once
#include <memory>

#include "polyarm/wheels/base_controller.hpp"
#include "tests/controllers/rig.hpp"

namespace polyarm::controllers {

/// A wheeled base of some type, with joints that have position and velocity to read, and both to command.
template <typename T>
struct WheelsRig {
  T base;
  Rig rig;

  WheelsRig(const std::vector<std::string>& joints, Rig::Values values, const Rig::Values& more = {})
      : rig(base, "base", joints, all(joints), all(joints), merged(std::move(values), more), "drive") {}

  void send(double x, double y, double angular, std::optional<Nanoseconds> stamp = {}) {
    base.receive(base.inputs().front().name, Twist{{x, y, 0}, {0, 0, angular}, stamp}, false);
  }
  double velocity(const std::string& joint) { return rig.command(joint + "/velocity"); }
  double angle(const std::string& joint) { return rig.command(joint + "/position"); }
  void measure(const std::string& joint, double velocity) { rig.state(joint + "/velocity") = velocity; }
  void steer(const std::string& joint, double angle) { rig.state(joint + "/position") = angle; }

 private:
  static std::vector<std::string> all(const std::vector<std::string>& joints) {
    std::vector<std::string> out;
    for (const std::string& joint : joints)
      for (const char* kind : {"/position", "/velocity"}) out.push_back(joint + kind);
    return out;
  }
  static Rig::Values merged(Rig::Values values, const Rig::Values& more) {
    for (const auto& [key, value] : more) values[key] = value;
    return values;
  }
};

}  // namespace polyarm::controllers
