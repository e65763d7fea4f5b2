#pragma once
/// The planning scene of a cell: objects that MoveIt's clients add to it or attach to its robots. States are
/// values: a change makes a new one. Metres; poses in the world. Any thread; allocates.
#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "polyarm/move_group/arm.hpp"
#include "polyarm/surroundings/bodies.hpp"

namespace polyarm::move_group {

/// Bounds of what clients can add.
inline constexpr std::size_t kMostObjects = 500, kMostObjectShapes = 2000, kMostMeshTriangles = 100'000;
/// A mesh with more triangles becomes one convex hull; else convex pieces.
inline constexpr std::size_t kMostCutTriangles = 2000;

struct Object {
  std::string id;
  Pose pose;                               ///< in the world; of an attached object: in its link
  std::vector<description::Shape> shapes;  ///< in the object's frame
  std::map<std::string, Pose> subframes;   ///< in the object's frame
  messages::object_recognition_msgs::msg::ObjectType type;
};

struct AttachedObject {
  Object object;
  std::size_t robot = 0;  ///< index in the cell
  int link = -1;
  std::vector<std::string> touch_links;
};

struct SceneState {
  std::string name = "polyarm";
  std::map<std::string, Object> world;
  std::map<std::string, AttachedObject> attached;
  std::set<std::string> allowed;  ///< objects that everything may touch
  std::map<std::string, messages::std_msgs::msg::ColorRGBA> colors;
  std::uint64_t version = 0;
};

/// The bodies of a cell. `owner` keeps them alive.
struct Bodies {
  std::shared_ptr<const void> owner;
  const std::vector<surroundings::Robot>* robots = nullptr;
  const description::Scene* scene = nullptr;
};

/// One moment of a cell, as one request sees it.
struct Around {
  std::shared_ptr<const Arm> arm;
  Bodies bodies;
  surroundings::Moment moment;
  std::shared_ptr<const SceneState> scene;

  const std::vector<double>& joints() const { return moment.robots[arm->index()].joints; }
  const Pose& base() const { return moment.robots[arm->index()].base; }
  Pose link_in_world(int link) const { return base() * arm->link_in_base(link, joints()); }
  Pose link_in_world(int link, std::span<const double> q) const {
    return base() * arm->link_in_base(link, q);
  }
  /// T_world_frame of "" (the planning frame), "world", a link, an object, "object/subframe", or a link of a
  /// cell with several robots as its tf names it ("left/tool0"). Throws Refusal(FRAME_TRANSFORM_FAILURE).
  Pose frame(const std::string& id) const;
};

/// The state after a message: a diff, or a whole scene that replaces everything. The joint state of a message
/// counts nothing: the cell knows where its robots are. Throws Refusal, and then nothing has changed.
/// `notes` gets a sentence for each part of the message that has no effect.
SceneState applied(const Around& around, const msg::PlanningScene& message, std::vector<std::string>& notes);
/// Adds, removes, moves or extends one object; attaches or detaches one.
void apply(const Around& around, const msg::CollisionObject& message, SceneState& state);
void apply(const Around& around, const msg::AttachedCollisionObject& message, SceneState& state);

/// The objects that nobody holds, as fixtures of the cell; those that everything may touch are left out.
std::vector<description::Fixture> fixtures_of(const SceneState& state);
/// The shapes of objects that robots hold; those that everything may touch are left out.
std::vector<surroundings::AttachedThing> attached_of(const SceneState& state);

/// The scene as clients read it: objects of clients, and the fixtures and parts of the cell. `components`:
/// bits of PlanningSceneComponents; 0: all.
msg::PlanningScene to_message(const Around& around, std::uint32_t components);
msg::RobotState robot_state(const Around& around, std::span<const double> q, bool with_attached = true);

/// The robot and everything around it with its joints at `q`. `clearance`: m, kept from all obstacles.
std::unique_ptr<surroundings::Surroundings> compiled(const Around& around, std::span<const double> q,
                                                     double clearance);

}  // namespace polyarm::move_group
