#pragma once
/// What a robot looks like, apart from what it collides with: shapes made from its kinematics, its measured
/// outlines and the style of its maker's family. m, in the links' frames, z up as in URDF. Pure; any thread.
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/description/robot_model.hpp"
#include "polyarm/meshes/mesh.hpp"

namespace polyarm::shapes {

/// The surfaces of one link.
struct LinkShape {
  int link = -1;  ///< index into RobotModel::links
  meshes::Mesh mesh;
};

/// True if the robot brings no look of its own: its visuals are capsules, or there are none. A robot with a
/// mesh, box, cylinder or sphere as a visual is drawn as its author wants it.
bool has_no_look(const description::RobotModel& model);

/// One entry per rigid body, in the frame of one of its links; never empty for a robot with a moving joint.
/// Wrong entries of RobotModel::look are reported as warnings.
std::vector<LinkShape> robot_shapes(const description::RobotModel& model, Problems& problems);

/// The links that robot_shapes gives a shape.
std::vector<int> links_with_shapes(const description::RobotModel& model);

/// The same as glTF 2.0, binary, with one node per link; the same robot gives the same bytes.
std::string robot_glb(const description::RobotModel& model);

/// 16 hexadecimal digits that change with everything that robot_glb depends on.
std::string shapes_hash(const description::RobotModel& model);

}  // namespace polyarm::shapes
