#pragma once
/// Settings of a cell file that limit its robots: speed profile, workspace, joint ranges, payload.
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/control/supervisor.hpp"
#include "polyarm/controllers/controller.hpp"
#include "polyarm/description/robot_model.hpp"
#include "polyarm/moves/workspace.hpp"
#include "polyarm/yaml/yaml.hpp"

namespace polyarm::cell {

/// TCP speeds from this value on mean "unlimited", m/s.
inline constexpr double kNoTcpLimit = 1e6;

/// Speed limits: `reduced` for teaching, `full` for automatic operation.
struct ProfileEntry {
  double tcp_speed = 1e9;  ///< m/s; 1e9: limited by the joints only
  double tcp_turning = 3;  ///< rad/s, for jogging the TCP
  double joint_speed = 1;  ///< share of the joints' velocity limits, (0, 1]
  std::string tag{};       ///< of the reduced profile: it holds while this tag is true; empty: none
  Location tag_place{};
};
/// 250 mm/s at the TCP (ISO 10218-1, reduced speed), joints at a tenth of their limits.
inline const ProfileEntry kReducedProfile{0.25, 0.6, 0.1};

struct ProfileEntries {
  std::string name = "full";  ///< profile at the start
  ProfileEntry reduced = kReducedProfile, full;
};

/// A joint range narrower than the robot's.
struct RangeEntry {
  std::string joint;
  double lower = 0, upper = 0;  ///< rad or m
  Location where;
};

/// `collision_torque` of a robot: the torque from outside at which it stops.
struct CollisionTorqueEntry {
  std::string joint;  ///< empty: every joint
  double limit = 0;   ///< N m, or N where it slides
  Location where;
};

/// The payload of a robot.
struct PayloadEntry {
  double mass = 0;             ///< kg
  std::optional<Vec3> center;  ///< in tool0, m; empty: at the TCP
};

/// `contacts: {stop: 1}`: stop category 0 or 1 after a contact; default: 1.
control::ContactStop read_contact_stop(const Yaml& yaml, Problems& problems);
/// `contacts: {clearance: 5mm}`: m that should stay between a robot and everything else.
double read_clearance(const Yaml& yaml, Problems& problems);
inline constexpr double kClearance = 0.005, kMostClearance = 1;
/// `guards: off`, or `guards: {clearance: 5mm, moves: true, slow_from: 60mm, others: false, bases: true}`.
struct GuardsEntry {
  bool on = true;
  double clearance = kClearance;  ///< m that robots keep from everything else; at most that of `contacts`
  bool moves = true;              ///< false: jogging and streamed targets alone are guarded, and bases
  double slow_from = 0.06;        ///< m before the place where it would stop
  bool others = false;            ///< motions that other programs command are stopped, too
  bool bases = true;              ///< false: bases that drive are not guarded
};
GuardsEntry read_guards(const Yaml& yaml, double clearance_of_contacts, Problems& problems);
/// `profile` and `profiles` of the cell file.
ProfileEntries read_profiles(const Yaml& cell, Problems& problems);
/// `workspace` of a cell or a robot.
std::vector<moves::WorkspaceZone> read_workspace(const Yaml& yaml, Problems& problems);
/// Takes the zones out beyond which the profile is reduced.
std::vector<moves::WorkspaceZone> take_slow_zones(std::vector<moves::WorkspaceZone>& zones);
/// `payload` of a robot: a mass, or mass and centre.
PayloadEntry read_payload(const Yaml& yaml, Problems& problems);
/// `joint_ranges` of a robot.
std::vector<RangeEntry> read_ranges(const Yaml& yaml, Problems& problems);
/// Finds the joints of the zones of a robot. A joint that it does not have is a problem.
void find_joints(std::vector<moves::WorkspaceZone>& zones, const description::RobotModel& model,
                 Problems& problems);
/// `collision_torque` of a robot: one torque, or one for each joint.
std::vector<CollisionTorqueEntry> read_collision_torques(const Yaml& yaml, Problems& problems);
/// Reports joints that the robot does not have.
void check_collision_torques(const std::vector<CollisionTorqueEntry>& torques,
                             const description::RobotModel& model, Problems& problems);
/// Narrows the model's limits for everything that uses the model. An unknown joint, or a range that is empty
/// or wider than the robot's, is a problem with its location.
void narrow_ranges(const std::vector<RangeEntry>& ranges, description::RobotModel& model, Problems& problems);

}  // namespace polyarm::cell
