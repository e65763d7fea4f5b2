#pragma once
/// Simulates a camera with its vision program for scenes in simulation.
#include <cstdint>
#include <random>
#include <string>

#include "polyarm/data/data_store.hpp"
#include "polyarm/description/scene.hpp"
#include "polyarm/hardware/world_state.hpp"

namespace polyarm::cell {

/// When its request tag becomes true, the camera writes the pose of the nearest part in view to a point (top
/// of the part, tool axis down), sets the done tag and resets the request. Cell thread.
class Camera {
 public:
  struct Setup {
    std::string name;   ///< of the scene's camera
    std::string point;  ///< name of the point to write
    std::string request, done;
    bool noise = false;  ///< adds uniform noise, up to 2 mm and 2 degrees
    std::uint64_t seed = 1;
    std::string robot;               ///< robot that carries the camera; empty: fixed in the scene
    Pose mount;                      ///< T_tool0_camera; z is the viewing direction
    double view = 0.6, reach = 0.6;  ///< view: half angle, rad; reach: range of sight, m
  };
  const Setup& setup() const { return setup_; }
  Camera(Setup setup, const description::Scene& scene);

  /// True if it took a picture in this tick. `tool0`: measured pose of the carrying robot's flange, world
  /// frame.
  bool tick(const hardware::WorldState& world, data::DataStore& store, const Pose& tool0 = {});

 private:
  int nearest(const hardware::WorldState& world, const Pose& eye) const;
  bool sees(const Vec3& point, const Pose& eye) const;
  Pose grasp_of(const description::Part& part, const Pose& at);

  Setup setup_;
  const description::Scene* scene_;
  const description::Camera* view_ = nullptr;
  std::mt19937_64 random_;
};

/// Height of the shape's topmost point above its origin at this rotation, m.
double height_above_origin(const description::Shape& shape, const Quaternion& rotation);

}  // namespace polyarm::cell
