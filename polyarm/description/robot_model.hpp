#pragma once
/// The model of a robot: links, joints, limits, shapes and masses, as plain facts that never change while it
/// runs. SI units: metres, radians, kg. Standard types only, because drivers and plugins include this header.
/// Const: any thread.
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
  bool estimated = false;           ///< not in the source, but computed from the link's shape
};

enum class ShapeKind { box, cylinder, sphere, capsule, mesh };

/// A piece of geometry in its link's frame. Cylinders and capsules lie along z, centred on the origin.
struct Shape {
  ShapeKind kind = ShapeKind::box;
  Pose pose;
  Vec3 size;          ///< box: full edge lengths, m
  double radius = 0;  ///< cylinder, sphere, capsule, m
  double length = 0;  ///< cylinder: full height; capsule: between the centres of its ends, m
  /// mesh: the URI as written; `mesh_path` if the file was found, else empty. Else: the point cloud that the
  /// shape belongs to, if any (cloud_of() of bodies.hpp).
  std::string mesh;
  std::string mesh_path;
  Vec3 scale{1, 1, 1};
  /// mesh: the corners of convex pieces that contain it, scaled, m, in the shape's frame; empty until
  /// hulls::make_bodies fills it. Physics simulates these.
  std::vector<std::vector<Vec3>> pieces;
};

/// Friction of a link, from `<gazebo reference="link">`. Empty means not stated.
struct Contact {
  std::optional<double> mu1, mu2;    ///< Coulomb friction along the two directions of a contact
  std::optional<bool> self_collide;  ///< collides with other links of its own robot
};

/// An axis-aligned box in a link's frame, m.
struct Outline {
  Vec3 lower, upper;
};

struct Link {
  std::string name;
  std::optional<Inertial> inertial;
  std::vector<Shape> visuals;
  std::vector<Shape> collisions;
  int parent_joint = -1;  ///< index into RobotModel::joints; -1 for the root
  Contact contact;
  /// The bounds of the link's real shape, measured from a public description. Pictures are built from it.
  std::optional<Outline> outline;
};

enum class JointType { fixed, revolute, continuous, prismatic, planar, floating };
const char* name(JointType type);

/// Empty means not stated. SI units; lower and upper in rad or m.
struct JointLimits {
  std::optional<double> lower, upper;
  std::optional<double> velocity, effort;
  std::optional<double> acceleration,
      jerk;  ///< not part of URDF; from catalogue, joint_limits.yaml or ros2_control
  std::optional<double> deceleration;  ///< as the acceleration if not stated
};

/// `<safety_controller>`: a range within the hard limits; the joint slows down near its ends.
struct SoftLimits {
  std::optional<double> lower, upper;  ///< rad or m
  double k_position = 0;               ///< 1/s: velocity allowed per rad (m) of distance to the end of the
                                       ///< range
  double k_velocity = 0;  ///< N m s/rad (N s/m): effort allowed per rad/s (m/s) of distance to the bound
};

struct Mimic {
  int joint = -1;  ///< index of the leading joint
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
  std::map<std::string, std::string> parameters;  ///< as written, including min, max and initial_value
  int size = 1;                                   ///< number of values
  bool limits_enabled = true;  ///< false if it or its component has <limits enable="false">
  Location where;
};

/// The types an interface may have: "double", "float32", "bool", "uint8" … "int32".
const std::vector<std::string>& data_types();
/// The value of an interface before the first write: NaN for double and float32, false for bool, the largest
/// value for integers. Empty for an unknown type.
std::optional<double> default_value(std::string_view data_type);

/// One `<joint>`, `<sensor>` or `<gpio>` of `<ros2_control>`.
struct ComponentInfo {
  std::string name;
  std::string kind;  ///< "joint", "sensor", "gpio"
  std::vector<InterfaceInfo> command_interfaces, state_interfaces;
  std::map<std::string, std::string> parameters;
  std::optional<bool>
      mimic;  ///< as stated; false: has its own command, although the robot's joint is a mimic joint
  bool limits_enabled = true;  ///< false: no limits of this joint are enforced
  Location where;
};

/// One joint or actuator of a transmission.
struct TransmissionEnd {
  std::string name;
  std::string role;                     ///< "joint1", "actuator2"; may be empty if there is only one
  double reduction = 1;                 ///< turns of the actuator per turn of the joint
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
  int rw_rate = 0;            ///< Hz; 0: the rate of the control loop
  bool is_async = false;      ///< runs on its own thread
  int thread_priority = 0;    ///< SCHED_FIFO priority of that thread; 0: not stated, normal scheduling
  std::vector<int> affinity;  ///< CPUs of that thread; empty: any
  std::string scheduling_policy = "synchronized";  ///< of that thread, or "detached"
  bool print_warnings = true;                      ///< of that thread, when it is late
  std::vector<TransmissionInfo> transmissions;
};

/// A group of joints, from SRDF. Indices, ascending.
struct GroupInfo {
  std::string name;
  std::vector<int> joints;
  std::vector<int> links;
};

/// A group that is attached to the end of another one, from SRDF.
struct EndEffectorInfo {
  std::string name, group, parent_group;  ///< parent_group may be empty
  int parent_link = -1;
};

/// Facts of the catalogue in addition to the geometry.
struct Provenance {
  std::string maker, model, source, licence;
  std::vector<std::string> notes;  ///< values that are from memory, estimated or suspicious, one sentence
                                   ///< each
  std::string controller_axes;     ///< source of RobotModel::controller_axes
  std::optional<double> payload_kg, reach_m;
};

/// The value that the maker's controller displays for one joint: sign * q + offset, plus factor * q of other
/// joints.
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
  int tip = -1;  ///< the link that was explicitly named as the tool link (`tool_link`)
  /// Named joint states in the order of `actuated`; includes "home" if known.
  std::map<std::string, std::vector<double>> named_states;
  /// Indices of the joints with a value of their own (not fixed, not mimic), parents before children.
  std::vector<int> actuated;
  std::vector<HardwareInfo> hardware;
  std::vector<TransmissionInfo> transmissions;  ///< of the robot itself, as in ROS 1
  /// Controller files named by a plugin in `<gazebo>` (`<parameters>`), as written.
  std::vector<std::string> controller_files;
  std::vector<GroupInfo> groups;
  std::vector<EndEffectorInfo> end_effectors;
  Provenance provenance;
  /// How the maker's controller displays the joints, in the order of `actuated`; empty if not known for
  /// certain.
  std::vector<ControllerAxis> controller_axes;
  /// Pairs of links (indices, smaller first) that are excluded from collision checks.
  std::vector<std::array<int, 2>> allowed_collisions;
  /// The robot's changes to the look of its maker's family: "style" and colours, see shapes/style.hpp.
  std::map<std::string, std::string> look;

  int find_link(std::string_view link) const;    ///< -1 if there is none
  int find_joint(std::string_view joint) const;  ///< -1 if there is none
  /// The names of the actuated joints, in order.
  std::vector<std::string> joint_names() const;
  /// The initial positions of the actuated joints, in order: "home", else the initial positions declared by
  /// the hardware, else zero; the latter two within the joints' limits.
  std::vector<double> start() const;
  /// The values that the maker's controller displays for a joint state, rad or m; empty if unknown.
  std::vector<double> displayed(std::span<const double> q) const;
  /// The link that carries the tool, with z pointing out: `tip`, else `tool0`, else `flange`, else the parent
  /// link of the SRDF's end effector, else a link whose name ends in one of these, else the last link of the
  /// longest chain. For an arm with a gripper, whose fingers do not belong to the arm, that is the grasp
  /// point if a link has such a name, or the palm.
  int tool_link() const;
};

/// Sets the link that carries the tool (`tip`) by name; an empty name has no effect. Error: unknown-link.
void set_tip(RobotModel& model, const std::string& link, const Location& where = {});

}  // namespace polyarm::description
