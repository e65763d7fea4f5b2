#pragma once
/// What a robot is, whoever made it: links, joints, limits, shapes and masses, as plain facts that never
/// change while it runs. Standard types only: drivers and plugins include this.
#include <array>
#include <map>
#include <optional>
#include <span>
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

/// How a link rubs, from `<gazebo reference="link">`. Empty means not stated.
struct Contact {
  std::optional<double> mu1, mu2;    ///< Coulomb friction along the two directions of a contact
  std::optional<bool> self_collide;  ///< collides with other links of its own robot
};

struct Link {
  std::string name;
  std::optional<Inertial> inertial;
  std::vector<Shape> visuals;
  std::vector<Shape> collisions;
  int parent_joint = -1;  ///< index into RobotModel::joints; -1 for the root
  Contact contact;
};

enum class JointType { fixed, revolute, continuous, prismatic, planar, floating };
const char* name(JointType type);

/// Empty means not stated. SI units; lower and upper in rad or m.
struct JointLimits {
  std::optional<double> lower, upper;
  std::optional<double> velocity, effort;
  std::optional<double> acceleration,
      jerk;  ///< not part of URDF; from catalogue, joint_limits.yaml or ros2_control
  std::optional<double> deceleration;  ///< as the acceleration where not stated
};

/// `<safety_controller>`: a range inside the hard one, whose ends slow the joint down.
struct SoftLimits {
  std::optional<double> lower, upper;  ///< rad or m
  double k_position = 0;               ///< 1/s: velocity allowed for each rad (m) to the end of the range
  double k_velocity = 0;  ///< N m s/rad (N s/m): effort allowed for each rad/s (m/s) to the bound
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
  std::optional<SoftLimits> soft_limits;
  double damping = 0, friction = 0;
  std::optional<Mimic> mimic;
  bool moves() const { return type != JointType::fixed; }
};

/// One `<command_interface>` or `<state_interface>` of `<ros2_control>`.
struct InterfaceInfo {
  std::string name;
  std::string data_type = "double";
  std::optional<double> min, max, initial_value;  ///< initial_value of a bool: 0 or 1
  std::map<std::string, std::string> parameters;  ///< as written, min, max and initial_value among them
  int size = 1;                                   ///< how many values it has
  bool limits_enabled = true;  ///< false where it or its component says <limits enable="false">
  Location where;
};

/// The types an interface may have: "double", "float32", "bool", "uint8" … "int32".
const std::vector<std::string>& data_types();
/// The value of an interface that nothing has been written to: NaN for double and float32, false for bool,
/// the largest value for integers. Nothing for a type that is not known.
std::optional<double> default_value(std::string_view data_type);

/// One `<joint>`, `<sensor>` or `<gpio>` of `<ros2_control>`.
struct ComponentInfo {
  std::string name;
  std::string kind;  ///< "joint", "sensor", "gpio"
  std::vector<InterfaceInfo> command_interfaces, state_interfaces;
  std::map<std::string, std::string> parameters;
  std::optional<bool>
      mimic;  ///< as stated; false: commanded on its own although the joint of the robot mimics
  bool limits_enabled = true;  ///< false: no limit of this joint is kept
  Location where;
};

/// One joint or actuator of a transmission.
struct TransmissionEnd {
  std::string name;
  std::string role;                     ///< "joint1", "actuator2"; may be empty where there is only one
  double reduction = 1;                 ///< actuator turns for each turn of the joint
  double offset = 0;                    ///< rad or m
  bool read_only = false;               ///< takes no commands
  std::vector<std::string> interfaces;  ///< ROS 1: its hardwareInterface elements
};

/// One `<transmission>`, of a `<ros2_control>` block or (ROS 1) of the robot.
struct TransmissionInfo {
  std::string name;
  std::string plugin;  ///< "transmission_interface/SimpleTransmission"; ROS 1: its <type>
  std::vector<TransmissionEnd> joints, actuators;
  std::map<std::string, std::string> parameters;
  Location where;
};

/// One `<ros2_control>` block.
struct HardwareInfo {
  std::string name, type, plugin, group;
  std::map<std::string, std::string> parameters;
  std::vector<ComponentInfo> components;
  Location where;
  int rw_rate = 0;            ///< Hz; 0 means that of the control loop
  bool is_async = false;      ///< on a thread of its own
  int thread_priority = 0;    ///< SCHED_FIFO priority of that thread; 0: not stated, an ordinary one
  std::vector<int> affinity;  ///< processors of that thread; empty: any
  std::string scheduling_policy = "synchronized";  ///< of that thread, or "detached"
  bool print_warnings = true;                      ///< of that thread, when it is late
  std::vector<TransmissionInfo> transmissions;
};

/// Joints that belong together, from SRDF. Indices, ascending.
struct GroupInfo {
  std::string name;
  std::vector<int> joints;
  std::vector<int> links;
};

/// A group that is carried at the end of another one, from SRDF.
struct EndEffectorInfo {
  std::string name, group, parent_group;  ///< parent_group may be empty
  int parent_link = -1;
};

/// Facts of the catalogue beside the geometry.
struct Provenance {
  std::string maker, model, source, licence;
  std::vector<std::string> notes;  ///< what is recalled, estimated or looks wrong, one sentence each
  std::string controller_axes;     ///< where RobotModel::controller_axes comes from
  std::optional<double> payload_kg, reach_m;
};

/// What the maker's controller shows of one joint: sign * q + offset, and factor * q of other joints added.
struct ControllerAxis {
  double sign = 1;
  double offset = 0;  ///< rad or m
  struct Coupling {
    int joint = -1;  ///< index in RobotModel::actuated
    double factor = 0;
  };
  std::vector<Coupling> coupling;
};

struct RobotModel {
  std::string name;
  std::vector<Link> links;    ///< links[root] is the base
  std::vector<Joint> joints;  ///< parents before children
  int root = 0;
  int tip = -1;  ///< the link that somebody said a tool is bolted on (`tool_link`)
  /// Named joint states in the order of `actuated`; "home" where known.
  std::map<std::string, std::vector<double>> named_states;
  /// Indices of the joints that have a value of their own (not fixed, not mimic), parents before children.
  std::vector<int> actuated;
  std::vector<HardwareInfo> hardware;
  std::vector<TransmissionInfo> transmissions;  ///< of the robot itself, as in ROS 1
  /// Controllers files that a plugin within `<gazebo>` names (`<parameters>`), as written.
  std::vector<std::string> controller_files;
  std::vector<GroupInfo> groups;
  std::vector<EndEffectorInfo> end_effectors;
  Provenance provenance;
  /// In the order of `actuated`; empty where it is not known for certain.
  std::vector<ControllerAxis> controller_axes;
  /// Pairs of links (indices, smaller first) whose collision shapes are never compared.
  std::vector<std::array<int, 2>> allowed_collisions;

  int find_link(std::string_view link) const;    ///< -1 if there is none
  int find_joint(std::string_view joint) const;  ///< -1 if there is none
  /// The names of the actuated joints, in order.
  std::vector<std::string> joint_names() const;
  /// Where the actuated joints are when nothing has moved them, in order: "home", else the initial positions
  /// that the hardware declares, else zero; the latter two within the joints' limits.
  std::vector<double> start() const;
  /// What the maker's controller shows for a joint state, rad or m; empty where that is not known.
  std::vector<double> displayed(std::span<const double> q) const;
  /// The link where a tool is bolted on, z out of it: `tip`, else `tool0`, else `flange`, else where the
  /// SRDF's end effector hangs, else a name that ends so, else the last link of the longest chain: of an arm
  /// with a gripper, whose fingers are not the arm's, the point that it holds at, where a link is called so,
  /// or its palm.
  int tool_link() const;
};

/// Says by its name which link carries the tool (`tip`); an empty name changes nothing. Error: unknown-link.
void set_tip(RobotModel& model, const std::string& link, const Location& where = {});

}  // namespace polyarm::description
