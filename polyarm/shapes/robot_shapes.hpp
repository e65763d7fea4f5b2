#pragma once
/// The visible shapes of a robot, independent of its collision shapes. They are built from its kinematics,
/// its measured outlines and the style of its maker's family. m, in the links' frames, z up as in URDF. No
/// side effects; any thread.
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

/// True if the robot has no visual shapes of its own: its visuals are capsules, or it has none. A robot with
/// a mesh, box, cylinder or sphere as a visual is drawn as its author defined it.
bool has_no_look(const description::RobotModel& model);

/// One entry per rigid body, in the frame of one of its links; never empty for a robot with a moving joint.
/// Wrong entries of RobotModel::look are reported as warnings.
std::vector<LinkShape> robot_shapes(const description::RobotModel& model, Problems& problems);

/// Adds the warnings of robot_shapes without making shapes: wrong entries of RobotModel::look, and a file of
/// measured surfaces that cannot be read.
void check_look(const description::RobotModel& model, Problems& problems);

/// The links that robot_shapes gives a shape.
std::vector<int> links_with_shapes(const description::RobotModel& model);

/// The same shapes as binary glTF 2.0, with one node per link. The same robot gives the same bytes.
std::string robot_glb(const description::RobotModel& model);

/// A hash of everything that robot_glb depends on: 16 hexadecimal digits.
std::string shapes_hash(const description::RobotModel& model);

}  // namespace polyarm::shapes
