#pragma once
#include <cstdint>
#include <random>
#include <string>

#include "polyarm/data/data_store.hpp"
#include "polyarm/description/scene.hpp"
#include "polyarm/hardware/world_state.hpp"

namespace polyarm::cell {

/// A stand-in for a camera with its vision program: when its request tag turns true it writes the pose of the
/// nearest part in its view into a point (top of the part, tool axis down), sets the done tag and takes back
/// the request. Cell thread.
class Camera {
 public:
  struct Setup {
    std::string name;   ///< of the scene's camera
    std::string point;  ///< name of the point that it writes
    std::string request, done;
    bool noise = false;  ///< up to 2 mm and 2 degrees, evenly
    std::uint64_t seed = 1;
    std::string robot;               ///< that carries it; empty: it stands where the scene has it
    Pose mount;                      ///< T_tool0_camera, z the way it looks
    double view = 0.6, reach = 0.6;  ///< half angle of view, rad; how far it sees, m
  };
  const Setup& setup() const { return setup_; }
  Camera(Setup setup, const description::Scene& scene);

  /// True if it took a picture in this tick.
  /// `tool0`: of the robot that carries it, in the world, as it is measured now.
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

/// Height of the topmost point of the shape above its origin when it is posed like this, m.
double height_above_origin(const description::Shape& shape, const Quaternion& rotation);

}  // namespace polyarm::cell
