#pragma once
#include "polyarm/wheels/diff_drive_controller.hpp"
#include "tests/controllers/rig.hpp"

namespace polyarm::controllers {

inline const std::vector<std::string> kWheels = {"left", "right", "left_rear", "right_rear"};

inline std::vector<std::string> interfaces(std::initializer_list<const char*> kinds) {
  std::vector<std::string> out;
  for (const std::string& wheel : kWheels)
    for (const char* kind : kinds) out.push_back(wheel + "/" + kind);
  return out;
}

inline Rig::Values plus(Rig::Values values, const Rig::Values& more) {
  for (const auto& [key, value] : more) values[key] = value;
  return values;
}

/// A base with a separation of 0.4 m and wheels of 1 m radius, which knows the wheels' feedback.
struct Base {
  DiffDriveController drive;
  Rig rig;
  explicit Base(const Rig::Values& more = {})
      : rig(drive, "base", kWheels, interfaces({"position", "velocity"}), interfaces({"velocity"}),
            plus({{"left_wheel_names", {"left"}},
                  {"right_wheel_names", {"right"}},
                  {"wheel_separation", {"0.4"}},
                  {"wheel_radius", {"1"}}},
                 more),
            "drive") {}
  void command(double linear, double angular, std::optional<Nanoseconds> stamp = {}) {
    drive.receive("cmd_vel", Twist{{linear, 0, 0}, {0, 0, angular}, stamp}, false);
  }
  double left() { return rig.command("left/velocity"); }
  double right() { return rig.command("right/velocity"); }
};

}  // namespace polyarm::controllers
