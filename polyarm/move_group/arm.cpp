#include "polyarm/move_group/arm.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "polyarm/base/text.hpp"
#include "polyarm/move_group/groups.hpp"

namespace polyarm::move_group {

namespace {
constexpr double kLimitSlack = 1e-6;  // rad or m beyond a limit that rounding explains

const description::Joint& joint_at(const description::RobotModel& model, int index) {
  return model.joints[static_cast<std::size_t>(index)];
}
}  // namespace

bool Group::has(std::size_t variable) const {
  return std::find(variables.begin(), variables.end(), variable) != variables.end();
}

Arm::Arm(const moves::RobotFacts& facts, description::RobotModel model, std::size_t index)
    : facts_(facts), model_(std::move(model)), index_(index) {
  for (const description::GroupInfo& info : model_.groups) {
    Group group{info.name, {}, -1, false};
    for (std::size_t v = 0; v < model_.actuated.size(); ++v)
      if (std::count(info.joints.begin(), info.joints.end(), model_.actuated[v]))
        group.variables.push_back(v);
    if (!info.joints.empty() && has_chain(model_, info)) {
      group.tip = joint_at(model_, info.joints.back()).child_link;
      group.solvable = carries_tool(group.tip);
    }
    if (!group.variables.empty()) groups_.push_back(std::move(group));
  }
}

const Group& Arm::group(const std::string& name) const {
  if (name.empty()) {
    for (const Group& group : groups_)
      if (group.solvable || groups_.size() == 1) return group;
    throw Refusal(Code::INVALID_GROUP_NAME,
                  "no group is named, and no group of '" + this->name() + "' is an arm");
  }
  std::vector<std::string> names;
  for (const Group& group : groups_) {
    if (group.name == name) return group;
    names.push_back(group.name);
  }
  throw Refusal(Code::INVALID_GROUP_NAME, fmt::format("'{}' has no group '{}'{}: it has {}", this->name(),
                                                      name, did_you_mean(name, names), join(names, ", ")));
}

std::optional<std::size_t> Arm::find_joint(const std::string& name) const {
  const auto found = std::find(joints().begin(), joints().end(), name);
  if (found == joints().end()) return std::nullopt;
  return static_cast<std::size_t>(found - joints().begin());
}

int Arm::link(const std::string& name) const {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < model_.links.size(); ++i) {
    if (model_.links[i].name == name) return static_cast<int>(i);
    names.push_back(model_.links[i].name);
  }
  throw Refusal(Code::INVALID_LINK_NAME,
                fmt::format("'{}' has no link '{}'{}", this->name(), name, did_you_mean(name, names)));
}

Pose Arm::link_in_base(int link, std::span<const double> q) const {
  std::vector<Pose> poses(facts_.chain.links());
  facts_.chain.link_poses(q, poses);
  return inverse(facts_.chain.base()) * poses[static_cast<std::size_t>(link)];
}

int Arm::rigid_root(int link) const {
  for (int joint = model_.links[static_cast<std::size_t>(link)].parent_joint;
       joint >= 0 && !joint_at(model_, joint).moves();
       joint = model_.links[static_cast<std::size_t>(link)].parent_joint)
    link = joint_at(model_, joint).parent_link;
  return link;
}

Pose Arm::tcp_in_link(int link) const {
  if (!carries_tool(link))
    throw Refusal(Code::INVALID_LINK_NAME,
                  fmt::format("poses of '{}' are not solved: it is not rigid with the tool link '{}'",
                              link_name(link), link_name(model_.tool_link())));
  const std::vector<double> q(joints().size(), 0.0);
  return inverse(facts_.chain.base() * link_in_base(link, q)) * facts_.chain.forward(q);
}

void Arm::set_joints(const messages::sensor_msgs::msg::JointState& state, std::vector<double>& q) const {
  if (state.name.size() != state.position.size() && !(state.name.empty() && state.position.empty()))
    throw Refusal(Code::INVALID_ROBOT_STATE, fmt::format("the joint state has {} names and {} positions",
                                                         state.name.size(), state.position.size()));
  for (std::size_t i = 0; i < state.name.size(); ++i) {
    const std::string& joint = state.name[i];
    if (!std::isfinite(state.position[i]))
      throw Refusal(Code::INVALID_ROBOT_STATE, "the position of '" + joint + "' is not finite");
    if (const auto variable = find_joint(joint))
      q[*variable] = state.position[i];
    else if (model_.find_joint(joint) < 0)
      throw Refusal(Code::INVALID_ROBOT_STATE,
                    fmt::format("'{}' has no joint '{}'{}", name(), joint, did_you_mean(joint, joints())));
  }
}

messages::sensor_msgs::msg::JointState Arm::joint_state(std::span<const double> q) const {
  messages::sensor_msgs::msg::JointState out;
  out.header.frame_id = planning_frame();
  out.name = joints();
  out.position.assign(q.begin(), q.end());
  return out;
}

std::string Arm::outside_limits(std::span<const double> q) const {
  const kinematics::Chain& chain = facts_.chain;
  for (std::size_t i = 0; i < joints().size(); ++i)
    if (q[i] < chain.lower()[i] - kLimitSlack || q[i] > chain.upper()[i] + kLimitSlack)
      return fmt::format("{} is at {:.4f}, and its limits are {:.4f} to {:.4f}", joints()[i], q[i],
                         chain.lower()[i], chain.upper()[i]);
  return "";
}

}  // namespace polyarm::move_group
