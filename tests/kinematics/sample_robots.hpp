#pragma once
/// Robots written by hand, so that these tests need no file: a UR3, seven- and five-joint arms, and a gantry
/// whose second axis carries a mimic joint.
#include <numbers>
#include <string>
#include <vector>

#include "polyarm/description/robot_model.hpp"

namespace polyarm::test {

/// A row with lower = upper is a fixed joint.
struct JointRow {
  const char* name;
  Vec3 xyz, rpy, axis;
  double lower, upper;
};

inline description::RobotModel serial_robot(const std::string& name, std::initializer_list<JointRow> rows) {
  description::RobotModel model;
  model.name = name;
  model.links.push_back({"base_link", {}, {}, {}, -1});
  for (const JointRow& row : rows) {
    const int index = static_cast<int>(model.joints.size());
    description::Joint joint;
    joint.name = row.name;
    joint.type = row.lower < row.upper ? description::JointType::revolute : description::JointType::fixed;
    joint.parent_link = index;
    joint.child_link = index + 1;
    joint.origin = pose_xyz_rpy(row.xyz, row.rpy);
    joint.axis = row.axis;
    if (joint.moves()) {
      joint.limits.lower = row.lower;
      joint.limits.upper = row.upper;
      joint.limits.velocity = 3.0;
      model.actuated.push_back(index);
    }
    model.joints.push_back(joint);
    model.links.push_back({"link_" + std::to_string(index + 1), {}, {}, {}, index});
  }
  model.links.back().name = "tool0";
  return model;
}

/// Kinematics of the Universal Robots UR3 (the maker's published DH parameters, base turned as in its ROS
/// description).
inline description::RobotModel ur3() {
  constexpr double pi = std::numbers::pi;
  const Vec3 z{0, 0, 1};
  return serial_robot("ur3", {{"base", {0, 0, 0}, {0, 0, pi}, z, 0, 0},
                              {"shoulder_pan", {0, 0, 0.1519}, {0, 0, 0}, z, -2 * pi, 2 * pi},
                              {"shoulder_lift", {0, 0, 0}, {pi / 2, 0, 0}, z, -2 * pi, 2 * pi},
                              {"elbow", {-0.24365, 0, 0}, {0, 0, 0}, z, -pi, pi},
                              {"wrist_1", {-0.21325, 0, 0.11235}, {0, 0, 0}, z, -2 * pi, 2 * pi},
                              {"wrist_2", {0, -0.08535, 0}, {pi / 2, 0, 0}, z, -2 * pi, 2 * pi},
                              {"wrist_3", {0, 0.0819, 0}, {pi / 2, pi, pi}, z, -2 * pi, 2 * pi}});
}

inline description::RobotModel seven() {
  constexpr double pi = std::numbers::pi;
  const Vec3 z{0, 0, 1};
  return serial_robot("seven", {{"a1", {0, 0, 0.34}, {0, 0, 0}, z, -2.9, 2.9},
                                {"a2", {0, 0, 0}, {-pi / 2, 0, 0}, z, -2.0, 2.0},
                                {"a3", {0, -0.4, 0}, {pi / 2, 0, 0}, z, -2.9, 2.9},
                                {"a4", {0, 0, 0}, {pi / 2, 0, 0}, z, -2.0, 2.0},
                                {"a5", {0, 0.4, 0}, {-pi / 2, 0, 0}, z, -2.9, 2.9},
                                {"a6", {0, 0, 0}, {-pi / 2, 0, 0}, z, -2.0, 2.0},
                                {"a7", {0, 0, 0}, {pi / 2, 0, 0}, z, -3.0, 3.0},
                                {"flange", {0, 0, 0.126}, {0, 0, 0}, z, 0, 0}});
}

/// A classic arm without its fourth joint.
inline description::RobotModel five() {
  const Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
  return serial_robot("five", {{"turn", {0, 0, 0.3}, {0, 0, 0}, z, -3, 3},
                               {"lift", {0.05, 0, 0}, {0, 0, 0}, y, -2, 2},
                               {"bend", {0, 0, 0.4}, {0, 0, 0}, y, -2.5, 2.5},
                               {"nod", {0.4, 0, 0.03}, {0, 0, 0}, y, -2, 2},
                               {"roll", {0.08, 0, 0}, {0, 0, 0}, x, -3, 3},
                               {"flange", {0.05, 0, 0}, {0, std::numbers::pi / 2, 0}, z, 0, 0}});
}

/// x slides; the arm turns; the wrist mimics the arm with -0.5 times its angle plus 0.1; then a slanted axis;
/// a finger beside the path moves nothing.
inline description::RobotModel gantry() {
  description::RobotModel model =
      serial_robot("gantry", {{"x", {0, 0, 0.5}, {0, 0, 0}, {1, 0, 0}, -1, 2},
                              {"arm", {0, 0, 0.1}, {0.3, 0, 0}, {0, 0, 1}, -3, 3},
                              {"wrist", {0.3, 0, 0}, {0, 0.2, 0}, {0, 1, 0}, -3, 3},
                              {"tilt", {0.2, 0.1, 0}, {0, 0, 0}, {0.6, 0, 0.8}, -2, 2},
                              {"tool", {0, 0, 0.1}, {0, 0, 0}, {0, 0, 1}, 0, 0}});
  model.joints[0].type = description::JointType::prismatic;
  model.joints[2].mimic = description::Mimic{1, -0.5, 0.1};
  description::Joint finger = model.joints[0];
  finger.name = "finger";
  finger.parent_link = 3;
  finger.child_link = static_cast<int>(model.links.size());
  model.links.push_back({"finger", {}, {}, {}, static_cast<int>(model.joints.size())});
  model.actuated = {0, 1, 3, static_cast<int>(model.joints.size())};
  model.joints.push_back(finger);
  return model;
}

/// An axis as it stands in the base where all joint values are zero.
struct AxisRow {
  Vec3 direction, point;
};

/// A robot of turning joints given by their axes, each within +-3 rad; all frames are parallel at zero.
inline description::RobotModel robot_of_axes(const std::string& name, const std::vector<AxisRow>& rows,
                                             const Pose& tool) {
  description::RobotModel model;
  model.name = name;
  model.links.push_back({"base_link", {}, {}, {}, -1});
  Vec3 at;
  for (std::size_t i = 0; i <= rows.size(); ++i) {
    const bool last = i == rows.size();
    description::Joint joint;
    joint.name = last ? "tool" : "joint_" + std::to_string(i + 1);
    joint.type = last ? description::JointType::fixed : description::JointType::revolute;
    joint.parent_link = static_cast<int>(i);
    joint.child_link = static_cast<int>(i) + 1;
    const Vec3 point = last ? tool.position : rows[i].point;
    joint.origin = {point - at, last ? tool.rotation : Quaternion{}};
    at = point;
    if (!last) {
      joint.axis = normalized(rows[i].direction);
      joint.limits.lower = -3;
      joint.limits.upper = 3;
      model.actuated.push_back(static_cast<int>(i));
    }
    model.joints.push_back(joint);
    model.links.push_back(
        {last ? "tool0" : "link_" + std::to_string(i + 1), {}, {}, {}, static_cast<int>(i)});
  }
  return model;
}

/// The index of the link "tool0".
inline int tip_of(const description::RobotModel& model) {
  for (std::size_t i = 0; i < model.links.size(); ++i)
    if (model.links[i].name == "tool0") return static_cast<int>(i);
  return -1;
}

}  // namespace polyarm::test
