#include "polyarm/move_group/groups.hpp"

#include <algorithm>
#include <set>

#include "polyarm/base/text.hpp"

namespace polyarm::move_group {

using description::GroupInfo;
using description::Joint;
using description::RobotModel;

namespace {
const Joint& joint_at(const RobotModel& model, int index) {
  return model.joints[static_cast<std::size_t>(index)];
}
}  // namespace

std::string joint_of(const std::string& interface, const std::string& robot) {
  const std::vector<std::string> parts = split_fields(interface, '/');
  return parts.size() == 3 && parts[0] == robot ? parts[1] : "";
}

std::vector<Actor> actors_of(const control::ControllerManager& controllers, const std::string& robot) {
  std::vector<Actor> out;
  for (const control::ListedController& listed : controllers.list()) {
    Actor actor{listed.name, {}, {}, {}, listed.state == hardware::LifecycleState::active};
    for (const controllers::InputPort& port : controllers.find(listed.name)->inputs()) {
      if (!port.action) continue;
      actor.type = port.types.front().substr(port.types.front().find('/') + 1);
      actor.action = port.name;
    }
    for (const std::string& interface : listed.required_commands)
      if (const std::string joint = joint_of(interface, robot);
          !joint.empty() && !std::count(actor.joints.begin(), actor.joints.end(), joint))
        actor.joints.push_back(joint);
    if (!actor.type.empty() && !actor.joints.empty()) out.push_back(std::move(actor));
  }
  return out;
}

std::vector<int> joints_to_tool(const RobotModel& model) {
  std::vector<int> out;
  for (int link = model.tool_link(); model.links[static_cast<std::size_t>(link)].parent_joint >= 0;) {
    out.insert(out.begin(), model.links[static_cast<std::size_t>(link)].parent_joint);
    link = joint_at(model, out.front()).parent_link;
  }
  return out;
}

void add_groups(RobotModel& model, const std::string& arm, const std::vector<Actor>& actors) {
  if (!model.groups.empty()) return;
  std::vector<int> chain = joints_to_tool(model);
  std::set<std::string> gripping;
  for (const Actor& actor : actors)
    if (actor.gripper()) gripping.insert(actor.joints.begin(), actor.joints.end());
  while (!chain.empty() && gripping.contains(joint_at(model, chain.back()).name)) chain.pop_back();
  if (!chain.empty()) model.groups.push_back({arm, chain, {}});
  for (const Actor& actor : actors) {
    if (!actor.gripper()) continue;
    GroupInfo group{actor.name == arm ? actor.name + "_gripper" : actor.name, {}, {}};
    for (const std::string& joint : actor.joints)
      if (const int index = model.find_joint(joint); index >= 0) group.joints.push_back(index);
    std::sort(group.joints.begin(), group.joints.end());
    if (group.joints.empty()) continue;
    const int parent = joint_at(model, group.joints.front()).parent_link;
    model.end_effectors.push_back({group.name + "_end", group.name, chain.empty() ? "" : arm, parent});
    model.groups.push_back(std::move(group));
  }
}

bool has_chain(const RobotModel& model, const GroupInfo& group) {
  int moving = 0;
  for (std::size_t i = 0; i < group.joints.size(); ++i) {
    moving += joint_at(model, group.joints[i]).moves() ? 1 : 0;
    if (i > 0 &&
        joint_at(model, group.joints[i]).parent_link != joint_at(model, group.joints[i - 1]).child_link)
      return false;
  }
  return moving >= 3;
}

}  // namespace polyarm::move_group
