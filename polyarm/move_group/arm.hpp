#pragma once
/// One robot as MoveIt's clients see it: joints, groups and links by name, and the frames that messages may
/// refer to. Const after construction: any thread. Metres, radians.
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "polyarm/move_group/refusal.hpp"
#include "polyarm/moves/robot_facts.hpp"
#include "polyarm/surroundings/bodies.hpp"

namespace polyarm::move_group {

struct Group {
  std::string name;
  std::vector<std::size_t> variables;  ///< indices in a joint state of the robot
  int tip = -1;                        ///< the last link of a chain; -1: it has none
  bool solvable = false;               ///< the tip is rigid with the robot's tool link
  bool has(std::size_t variable) const;
};

class Arm {
 public:
  /// `facts` outlive it; `model` is that robot's, with its groups. `index`: of the robot in its cell.
  Arm(const moves::RobotFacts& facts, description::RobotModel model, std::size_t index);

  const std::string& name() const { return facts_.name; }
  std::size_t index() const { return index_; }
  const moves::RobotFacts& facts() const { return facts_; }
  const description::RobotModel& model() const { return model_; }
  const std::vector<Group>& groups() const { return groups_; }
  /// Throws Refusal(INVALID_GROUP_NAME). An empty name is the only group, or the first one that is solvable.
  const Group& group(const std::string& name) const;
  /// Names of the joints of a joint state.
  const std::vector<std::string>& joints() const { return facts_.chain.names(); }
  std::optional<std::size_t> find_joint(const std::string& name) const;
  /// The index of a link. Throws Refusal(INVALID_LINK_NAME).
  int link(const std::string& name) const;
  const std::string& link_name(int link) const { return model_.links[static_cast<std::size_t>(link)].name; }
  /// The frame of poses without one: the root link.
  const std::string& planning_frame() const { return link_name(model_.root); }

  /// T_base_link in a joint state.
  Pose link_in_base(int link, std::span<const double> q) const;
  /// T_link_tcp of a link that is rigid with the tool link. Throws Refusal(INVALID_LINK_NAME) for others.
  Pose tcp_in_link(int link) const;
  bool carries_tool(int link) const { return rigid_root(link) == rigid_root(model_.tool_link()); }

  /// Sets the joints of `state` in `q`. Names of mimic and fixed joints are skipped. Throws
  /// Refusal(INVALID_ROBOT_STATE) for unknown names, lists of different lengths and values that are not
  /// finite.
  void set_joints(const messages::sensor_msgs::msg::JointState& state, std::vector<double>& q) const;
  messages::sensor_msgs::msg::JointState joint_state(std::span<const double> q) const;
  /// The first joint outside its limits, as a sentence; empty if there is none.
  std::string outside_limits(std::span<const double> q) const;

 private:
  int rigid_root(int link) const;

  const moves::RobotFacts& facts_;
  description::RobotModel model_;
  std::size_t index_;
  std::vector<Group> groups_;
};

}  // namespace polyarm::move_group
