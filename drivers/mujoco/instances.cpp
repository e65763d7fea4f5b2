/// What the world needs to know of its robots and parts before it is written.
#include <algorithm>
#include <sstream>

#include "drivers/mujoco/mjcf.hpp"

namespace polyarm::drivers {

const hardware::RobotInstance* carrier_of(const hardware::RobotInstance& robot,
                                          std::span<const hardware::RobotInstance> robots) {
  const auto carries = [&](const hardware::RobotInstance& each) { return each.name == robot.on; };
  const auto found = std::find_if(robots.begin(), robots.end(), carries);
  return robot.on.empty() || found == robots.end() ? nullptr : &*found;
}

std::vector<ForceSensor> force_sensors(const hardware::RobotInstance& robot) {
  std::vector<ForceSensor> out;
  for (const description::HardwareInfo& block : robot.hardware)
    for (const description::ComponentInfo& component : block.components) {
      const int link = hardware::force_sensor_link(*robot.model, component);
      if (link >= 0) out.push_back({component.name, link, hardware::force_sensor_errors(component)});
    }
  return out;
}

bool is_freestanding(const hardware::RobotInstance& robot) {
  return std::any_of(robot.hardware.begin(), robot.hardware.end(), [](const auto& block) {
    const auto found = block.parameters.find("base");
    return found != block.parameters.end() && found->second == "free";
  });
}

std::vector<int> wheel_joints(const hardware::RobotInstance& robot) {
  std::vector<int> out;
  for (const description::HardwareInfo& block : robot.hardware)
    if (const auto found = block.parameters.find("wheel_joints"); found != block.parameters.end()) {
      std::istringstream in(found->second);
      for (int joint = 0; in >> joint;)
        if (joint >= 0 && joint < static_cast<int>(robot.model->joints.size())) out.push_back(joint);
    }
  return out;
}

Rigid rigid_links(const description::RobotModel& model) {
  Rigid out;
  for (std::size_t i = 0; i < model.links.size(); ++i) {
    int link = static_cast<int>(i);
    for (int joint = model.links[i].parent_joint;
         joint >= 0 && !model.joints[static_cast<std::size_t>(joint)].moves();
         joint = model.links[static_cast<std::size_t>(link)].parent_joint)
      link = model.joints[static_cast<std::size_t>(joint)].parent_link;
    out.body_of_link.push_back(link);
  }
  return out;
}

std::vector<Follower> followers(const description::RobotModel& model) {
  const auto slides_or_turns = [&](int joint) {
    using description::JointType;
    const JointType type = model.joints[static_cast<std::size_t>(joint)].type;
    return type == JointType::revolute || type == JointType::continuous || type == JointType::prismatic;
  };
  std::vector<Follower> out;
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    if (!model.joints[j].mimic || !slides_or_turns(static_cast<int>(j))) continue;
    Follower follower{static_cast<int>(j), static_cast<int>(j), 1, 0};
    while (const auto& mimic = model.joints[static_cast<std::size_t>(follower.source)].mimic) {
      follower.offset += follower.multiplier * mimic->offset;
      follower.multiplier *= mimic->multiplier;
      follower.source = mimic->joint;
    }
    if (slides_or_turns(follower.source)) out.push_back(follower);
  }
  return out;
}

std::size_t most_pieces(const description::Scene* scene) {
  std::size_t out = 1;
  for (std::size_t i = 0; scene && i < scene->parts.size(); ++i)
    out = std::max(out, pieces_of(scene->parts[i]));
  return out;
}

}  // namespace polyarm::drivers
