#include "polyarm/description/robot_model.hpp"

#include <algorithm>

namespace polyarm::description {

const char* name(JointType type) {
  constexpr const char* kNames[] = {"fixed", "revolute", "continuous", "prismatic", "planar", "floating"};
  return kNames[static_cast<std::size_t>(type)];
}

int RobotModel::find_link(std::string_view link) const {
  for (std::size_t i = 0; i < links.size(); ++i)
    if (links[i].name == link) return static_cast<int>(i);
  return -1;
}

int RobotModel::find_joint(std::string_view joint) const {
  for (std::size_t i = 0; i < joints.size(); ++i)
    if (joints[i].name == joint) return static_cast<int>(i);
  return -1;
}

std::vector<std::string> RobotModel::joint_names() const {
  std::vector<std::string> out;
  for (const int joint : actuated) out.push_back(joints[static_cast<std::size_t>(joint)].name);
  return out;
}

int RobotModel::tool_link() const {
  for (const char* wanted : {"tool0", "flange"})
    if (const int link = find_link(wanted); link >= 0) return link;
  int best = root;
  std::size_t best_depth = 0;
  for (std::size_t i = 0; i < links.size(); ++i) {
    std::size_t depth = 0;
    for (int joint = links[i].parent_joint; joint >= 0;
         joint = links[static_cast<std::size_t>(joints[static_cast<std::size_t>(joint)].parent_link)]
                     .parent_joint)
      depth += joints[static_cast<std::size_t>(joint)].moves() ? 1000 : 1;
    if (depth > best_depth) {
      best_depth = depth;
      best = static_cast<int>(i);
    }
  }
  return best;
}

}  // namespace polyarm::description
