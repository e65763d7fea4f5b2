#include "drivers/wire/six_axes.hpp"

#include <algorithm>

namespace polyarm::wire {

namespace {

constexpr std::array<const char*, 3> kFlangeNames{"flange", "tool0", "faceplate"};

std::string list(std::span<const char* const> words) {
  std::string out;
  for (const char* word : words) (out += out.empty() ? "" : " or ") += word;
  return out;
}

std::string count_of(std::size_t least, std::size_t most) {
  constexpr const char* kWords[] = {"none", "one", "two", "three", "four", "five", "six", "seven"};
  const std::string last = kWords[most];
  return least == most ? last : kWords[least] + std::string(" to ") + last;
}

}  // namespace

int flange_link(const description::RobotModel& model, int last) {
  for (const char* wanted : kFlangeNames)
    for (std::size_t i = 0; i < model.links.size(); ++i)
      if (model.links[i].name == wanted) return static_cast<int>(i);
  return last;
}

std::vector<std::string> driven_joints(const hardware::ComponentContext& context,
                                       std::span<const char* const> takes, const std::string& whose,
                                       Problems& problems, std::size_t least, std::size_t most) {
  std::vector<std::string> out;
  if (context.robots.size() != 1) {
    problems.error("bad-hardware", {}, "'" + context.name + "' drives one robot",
                   "give each robot its own hardware");
    return out;
  }
  const hardware::RobotInstance& robot = context.robots.front();
  for (const description::HardwareInfo& block : robot.hardware)
    for (const description::ComponentInfo& part : block.components) {
      if (part.kind != "joint") continue;
      out.push_back(part.name);
      for (const description::InterfaceInfo& one : part.command_interfaces)
        if (std::find(takes.begin(), takes.end(), one.name) == takes.end())
          problems.error("unknown-interface", one.where,
                         "'" + part.name + "' takes no command '" + one.name + "'",
                         "it takes " + list(takes));
    }
  if (robot.model && out.empty()) {
    out = robot.model->joint_names();
    if (out.size() > most) out.resize(most);  // a gripper behind the arm has its own hardware
  }
  if (out.size() < least || out.size() > most)
    problems.error("bad-hardware", {},
                   "'" + context.name + "' has " + std::to_string(out.size()) +
                       " joints; this driver takes " + whose + " with " + count_of(least, most),
                   "name them in the order from base to tool");
  return out;
}

std::vector<const description::Joint*> revolute_joints(const description::RobotModel& model,
                                                       std::size_t least, std::size_t most,
                                                       const std::string& example) {
  std::vector<const description::Joint*> joints;
  for (const int i : model.actuated) joints.push_back(&model.joints[static_cast<std::size_t>(i)]);
  const bool counts = joints.size() >= least && joints.size() <= most;
  if (!counts || std::any_of(joints.begin(), joints.end(), [](const auto* j) {
        return j->type != description::JointType::revolute && j->type != description::JointType::continuous;
      }))
    throw Error("bad-model", "'" + model.name + "' has not " + count_of(least, most) + " revolute joints",
                "choose another robot, for example " + example);
  return joints;
}

std::array<const description::Joint*, 6> six_revolute_joints(const description::RobotModel& model,
                                                             const std::string& example) {
  const auto joints = revolute_joints(model, 6, 6, example);
  std::array<const description::Joint*, 6> out{};
  std::copy(joints.begin(), joints.end(), out.begin());
  return out;
}

AxisFacts axis_facts(const description::RobotModel& model, const std::string& example, double scale) {
  constexpr double kEndless = 36000, kVelocity = 2;
  const auto joints = six_revolute_joints(model, example);
  AxisFacts out;
  out.model = model.name.substr(model.name.find('/') + 1);
  for (std::size_t i = 0; i < 6; ++i) {
    const description::JointLimits& limits = joints[i]->limits;
    out.lower[i] = limits.lower ? *limits.lower * scale : -kEndless;
    out.upper[i] = limits.upper ? *limits.upper * scale : kEndless;
    out.velocity[i] = limits.velocity.value_or(kVelocity) * scale;
  }
  out.flange = flange_link(model, joints.back()->child_link);
  return out;
}

}  // namespace polyarm::wire
