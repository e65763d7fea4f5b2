#pragma once
/// What a robot is, whoever made it: links, joints, limits, shapes and masses, as plain facts that never
/// change while it runs. Standard types only: drivers and plugins include this.
#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/pose.hpp"

namespace polyarm::description {

/// Mass in kg, centre of mass in the link frame (m), inertia about the centre of mass in link axes (kg m²).
struct Inertial {
  double mass = 0;
  Vec3 center;
  std::array<double, 6> inertia{};  ///< ixx ixy ixz iyy iyz izz
  bool estimated = false;           ///< not in the source: computed from the link's shape
};

enum class ShapeKind { box, cylinder, sphere, capsule, mesh };

/// A piece of geometry in its link's frame. Cylinders and capsules lie along z, centred on the origin.
struct Shape {
  ShapeKind kind = ShapeKind::box;
  Pose pose;
  Vec3 size;          ///< box: full edge lengths, m
  double radius = 0;  ///< cylinder, sphere, capsule, m
  double length = 0;  ///< cylinder: full height; capsule: between the centres of its ends, m
  std::string mesh;   ///< mesh: the URI as written; `mesh_path` where it was found, else empty
  std::string mesh_path;
  Vec3 scale{1, 1, 1};
};

struct Link {
  std::string name;
  std::optional<Inertial> inertial;
  std::vector<Shape> visuals;
  std::vector<Shape> collisions;
  int parent_joint = -1;  ///< index into RobotModel::joints; -1 for the root
};

enum class JointType { fixed, revolute, continuous, prismatic, planar, floating };
const char* name(JointType type);

/// Empty means not stated. SI units; lower and upper in rad or m.
struct JointLimits {
  std::optional<double> lower, upper;
  std::optional<double> velocity, effort;
  std::optional<double> acceleration,
      jerk;  ///< not part of URDF; from catalogue, joint_limits.yaml or ros2_control
};

struct Mimic {
  int joint = -1;  ///< index of the joint followed
  double multiplier = 1;
  double offset = 0;
};

struct Joint {
  std::string name;
  JointType type = JointType::fixed;
  int parent_link = -1;
  int child_link = -1;
  Pose origin;         ///< T_parent_joint at zero
  Vec3 axis{1, 0, 0};  ///< unit, in the joint frame
  JointLimits limits;
  double damping = 0, friction = 0;
  std::optional<Mimic> mimic;
  bool moves() const { return type != JointType::fixed; }
};

/// One `<command_interface>` or `<state_interface>` of `<ros2_control>`.
struct InterfaceInfo {
  std::string name;
  std::string data_type = "double";
  int size = 1;                ///< values of one interface
  bool limits_enabled = true;  ///< `<limits enable="false"/>`
  std::optional<double> min, max, initial_value;
  std::map<std::string, std::string> parameters;
};

/// One `<joint>`, `<sensor>` or `<gpio>` of `<ros2_control>`.
struct ComponentInfo {
  std::string name;
  std::string kind;  ///< "joint", "sensor", "gpio"
  std::vector<InterfaceInfo> command_interfaces, state_interfaces;
  std::optional<bool> mimic;   ///< `mimic=`: whether a joint that mimics another in the URDF does so here
  bool limits_enabled = true;  ///< `<limits enable="false"/>`: min and max of its interfaces do not count
  std::map<std::string, std::string> parameters;
};

/// One end of a transmission.
struct TransmissionEnd {
  std::string name, role;
  double reduction = 1, offset = 0;
};
/// One `<transmission>` of a `<ros2_control>` block.
struct TransmissionInfo {
  std::string name, plugin;
  std::vector<TransmissionEnd> joints, actuators;
  std::map<std::string, std::string> parameters;
};

/// One `<ros2_control>` block.
struct HardwareInfo {
  std::string name, type, plugin, group;
  int rw_rate = 0;            ///< Hz at which it is read and written; 0: that of the loop
  bool is_async = false;      ///< on a thread of its own
  int thread_priority = 0;    ///< SCHED_FIFO priority of that thread; 0: ordinary
  std::vector<int> affinity;  ///< processors of that thread; empty: any
  std::vector<TransmissionInfo> transmissions;
  std::map<std::string, std::string> parameters;
  std::vector<ComponentInfo> components;
  Location where;
};

/// Facts of the catalogue beside the geometry.
struct Provenance {
  std::string maker, model, source, licence;
  std::vector<std::string> notes;  ///< what is recalled, estimated or looks wrong, one sentence each
  std::optional<double> payload_kg, reach_m;
};

struct RobotModel {
  std::string name;
  std::vector<Link> links;    ///< links[root] is the base
  std::vector<Joint> joints;  ///< parents before children
  int root = 0;
  /// Named joint states in the order of `actuated`; "home" where known.
  std::map<std::string, std::vector<double>> named_states;
  /// Indices of the joints that have a value of their own (not fixed, not mimic), parents before children.
  std::vector<int> actuated;
  std::vector<HardwareInfo> hardware;
  Provenance provenance;
  /// Pairs of links (indices, smaller first) whose collision shapes are never compared.
  std::vector<std::array<int, 2>> allowed_collisions;

  int find_link(std::string_view link) const;    ///< -1 if there is none
  int find_joint(std::string_view joint) const;  ///< -1 if there is none
  /// The names of the actuated joints, in order.
  std::vector<std::string> joint_names() const;
  /// The link where a tool is bolted on, z out of it: `tool0`, else `flange`, else the last link of the
  /// longest chain.
  int tool_link() const;
};

}  // namespace polyarm::description
