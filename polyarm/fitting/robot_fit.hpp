#pragma once
/// Compares the look of a robot with the meshes of a description of the same robot, and measures a new look
/// on them. Lengths in m. Any thread; deterministic.
#include <cstddef>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/pose.hpp"
#include "polyarm/description/robot_model.hpp"
#include "polyarm/meshes/mesh.hpp"

namespace polyarm::fitting {

/// The meshes of a description, sorted by the bodies of the catalogue's robot.
struct MeshedRobot {
  std::map<int, meshes::Mesh> bodies;  ///< by the link that carries the body's shape, in its frame
  std::vector<Pose> links;             ///< of the catalogue's robot at home, in the world
  double reach = 1;
};

/// Finds links and joints by name; a prefix that the description gives to all names does not matter, nor do
/// the names if the frames of all moving links are the same while all joints are at zero. A link that the
/// catalogue's robot does not have belongs to the body of the next link above that it has. A link without
/// meshes to look at has those that it collides with. Throws Error("other-robot") if the bounds of a link's
/// meshes are off by more than `most_off` of the reach, or by five times as much if links of these names
/// have their joints at the same places, Error("no-mesh") if no mesh is found.
MeshedRobot meshes_of(const description::RobotModel& model, const description::RobotModel& meshed,
                      double most_off = std::numeric_limits<double>::infinity());
/// Differences of size above this share of the reach mean another model.
inline constexpr double kOtherRobot = 0.06;

/// Distances of the surfaces that are visible from outside, m, in ascending order.
struct Comparison {
  std::size_t mesh_triangles = 0, look_triangles = 0;
  std::vector<double> there, back;  ///< look to meshes, meshes to look
  double p95() const;
  double largest() const;
};
/// `share`: 0 to 1.
double at_share(const std::vector<double>& sorted, double share);

/// Compares the bodies that have meshes. Reports warnings about the look. Throws Error("no-mesh").
Comparison compare(const description::RobotModel& model, const MeshedRobot& to, Problems& warnings);

struct MeasureOptions {
  std::string file;    ///< the file that is written
  std::string source;  ///< where the meshes are from
  bool plain = false;  ///< colours of the maker's style instead of those of the meshes
};
/// Writes the measured look to the file, and again in more detail while it is not close enough. Throws Error
/// ("no-mesh") if a moving link has no mesh: next to measured surfaces its made-up ones would not fit.
Comparison measure(description::RobotModel model, const MeshedRobot& of, const MeasureOptions& options,
                   Problems& warnings);

}  // namespace polyarm::fitting
