#pragma once
/// The bodies of a cell for contacts: its robots with their tools, what they hold, fixtures and parts. One
/// definition for plans, checks and programs. Metres, radians; poses in the world. Any thread; allocates.
#include <memory>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/collision/checker.hpp"
#include "polyarm/description/scene.hpp"

namespace polyarm::surroundings {

/// Another robot of the cell with bodies in common: each is an arm on one torso.
struct SharedBodies {
  std::size_t robot = 0;    ///< index of the other one
  std::vector<char> links;  ///< by link of this one: true if the other one has it, too
};

/// One robot of a cell. Model and tool outlive what is made from them, and their meshes have their pieces
/// (make_meshes).
struct Robot {
  std::string name;  ///< prefix of its bodies: "arm/forearm"; empty: no prefix
  const description::RobotModel* model = nullptr;
  const description::Tool* tool = nullptr;  ///< null: none
  int on = -1;            ///< index of the robot whose root link carries it; -1: none
  bool is_free = false;   ///< its base is not fixed: it drives or stands free
  /// robot_body() of it with empty hands, if somebody has made it already: that takes milliseconds.
  std::shared_ptr<const collision::RobotBody> body;
  /// Joints that the controller of its base names; empty: the shapes say which links are wheels.
  std::vector<int> wheel_joints = {};
  /// Each robot is checked against its own copy of what it shares, not against the other robot's copy.
  std::vector<SharedBodies> shared = {};
  bool shares(int link, std::size_t other) const {
    for (const SharedBodies& each : shared)
      if (each.robot == other) return each.links[static_cast<std::size_t>(link)] != 0;
    return false;
  }
  /// True if it is the carrier of the other robot, or has the carrier's root link, too. `index`: of this one.
  bool carries(const Robot& other, std::size_t index) const {
    return other.on >= 0 &&
           (other.on == static_cast<int>(index) || shares_root(static_cast<std::size_t>(other.on)));
  }
  bool shares_root(std::size_t other) const { return !shared.empty() && shares(model->root, other); }
};

/// Finds what robots share, with their bases where they are at this moment. Those on different carriers share
/// nothing, and those that drive or stand free do not.
void find_shared(std::vector<Robot>& robots, const std::vector<Pose>& T_world_base);

/// Where everything is at one moment. Robots, parts and movers are in the order of the cell and its scene.
struct Moment {
  struct RobotState {
    Pose base;                  ///< T_world_base, of the root link
    std::vector<double> joints;  ///< of RobotModel::actuated
  };
  struct PartState {
    Pose pose;
    bool in_world = false;
    int held_by = -1;  ///< index of a robot; -1: none
  };
  std::vector<RobotState> robots;
  std::vector<PartState> parts;  ///< empty: the cell does not know where its parts are
  std::vector<double> movers;    ///< m along the axis; empty: at the start
};

/// A thing that is attached to a link of a robot, and is no part of the scene.
struct AttachedThing {
  std::string name;
  description::Shape shape;  ///< its pose is the identity
  std::size_t robot = 0;     ///< index of a robot
  int link = -1;             ///< of its model: the tool link, or one that is rigid with it
  Pose pose;                 ///< T_link_shape
};

/// The moment at which a scene begins: parts that no feeder brings lie at their start, movers are at zero.
Moment start_of(const description::Scene& scene);

/// Gives the meshes of a robot, its tool, and the fixtures and parts of a scene their convex pieces, from the
/// user's cache where it has them. Slow the first time; reads the disk. `of`: names the owner in warnings.
/// Warns of each mesh that cannot be read.
void make_meshes(description::RobotModel& model, description::Tool& tool, const std::string& of,
                 Problems& problems);
void make_meshes(description::Scene& scene, Problems& problems);

/// A part in a gripper.
struct HeldPart {
  const description::Part* part = nullptr;
  Pose pose;  ///< T_link_part, of the link that carries the tool
};

/// Links of the robot, its tool ("tool"), the pads of an open parallel gripper ("fingers") and held parts
/// ("part NAME"). The tool may touch the link that carries it and the link before that one.
std::shared_ptr<const collision::RobotBody> robot_body(const Robot& robot,
                                                       const std::vector<HeldPart>& held = {});
/// The links that a tool and what it holds may touch.
std::vector<int> links_at_tool(const description::RobotModel& model);
/// By link: true if it may touch the floor, as a wheel does. Empty: none may.
std::vector<char> links_on_floor(const Robot& robot);
/// The links behind the first joint of the robot: their loose bodies may reach into what carries the robot.
bool is_first_moving(const description::RobotModel& model, int link);
bool is_rigid_with_root(const description::RobotModel& model, int link);
/// Names of what has shapes but no known body: links, "tool NAME", "fixture NAME".
std::vector<std::string> without_body(const Robot& robot, const description::Scene& scene);

/// The pose of a fixture, with its mover at its place.
Pose pose_of(const description::Fixture& fixture, const description::Scene& scene, const Moment& moment);
/// The parts that a robot holds, as attached to it at this moment. `body` is the robot's.
std::vector<HeldPart> held_by(std::size_t robot, const Robot& facts, const collision::RobotBody& body,
                              const description::Scene& scene, const Moment& moment);

/// One robot among everything else, compiled for checks of states and edges, and for plans.
class Surroundings {
 public:
  /// Obstacles of robot `own`: the floor, fixtures, parts that it does not hold, and the other robots with
  /// what they hold. The first moving link of a fixed robot may touch floor and fixtures, as in physics.
  /// `clearance`: m, to be kept from all obstacles. `touching`: names of obstacles ("part cube") that are left
  /// out. Throws as collision::RobotBody and Checker do.
  Surroundings(const std::vector<Robot>& robots, const description::Scene& scene, const Moment& moment,
               std::size_t own, double clearance, const std::vector<std::string>& touching = {});

  const collision::Checker& checker() const { return *checker_; }
  collision::Probe& probe() { return *probe_; }

 private:
  std::unique_ptr<const collision::Checker> checker_;
  std::unique_ptr<collision::Probe> probe_;
};

}  // namespace polyarm::surroundings
