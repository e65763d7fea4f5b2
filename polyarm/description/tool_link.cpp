#include <algorithm>
#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/base/text.hpp"
#include "polyarm/description/robot_model.hpp"

namespace polyarm::description {

namespace {

using Words = std::span<const std::string_view>;

constexpr std::string_view kFingers[] = {"finger", "jaw", "claw", "knuckle", "thumb"};
constexpr std::string_view kFingersJoints[] = {"grip", "finger", "jaw", "claw", "knuckle", "thumb"};
constexpr std::string_view kTurnsOfAWrist[] = {"roll", "pitch", "yaw", "wrist", "rotat"};
constexpr std::string_view kNoEnds[] = {"finger", "thumb", "knuckle", "camera", "optical", "sensor", "imu"};
/// Names for the point between fingers, the most certain first.
constexpr std::string_view kPoints[] = {"tcp"};
constexpr std::string_view kFrames[] = {"grasp", "gripper_frame", "tool_frame", "tool_link", "tool_center"};
constexpr std::string_view kEnds[] = {"ee_gripper", "end_effector", "ee_link", "eef"};

bool names_one_of(const std::string& name, Words words) {
  const std::string low = lower(name);
  return std::any_of(words.begin(), words.end(),
                     [&](std::string_view word) { return low.find(word) != std::string::npos; });
}

/// Finds where an arm ends and its gripper begins. Indices are those of the model's links.
class ArmEnd {
 public:
  explicit ArmEnd(const RobotModel& model)
      : model_{model},
        children_(model.links.size()),
        above_(model.links.size(), 0),
        below_(model.links.size(), 0) {
    for (std::size_t i = 0; i < model.joints.size(); ++i) {
      const Joint& joint = model.joints[i];
      children_[at(joint.parent_link)].push_back(static_cast<int>(i));
      above_[at(joint.child_link)] = above_[at(joint.parent_link)] + weight(joint);
    }
    for (auto i = model.joints.rbegin(); i != model.joints.rend(); ++i)
      below_[at(i->parent_link)] =
          std::max(below_[at(i->parent_link)], below_[at(i->child_link)] + weight(*i));
  }

  int link() const {
    const auto [body, holds] = last_body();
    return holds ? point_held(body) : deepest(body);
  }

 private:
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  static constexpr int kJoint = 1000;  ///< weight of a moving joint: more than any number of fixed ones
  static int weight(const Joint& joint) { return joint.moves() ? kJoint : 1; }

  struct Body {
    int link = 0;        ///< its first link
    bool holds = false;  ///< it carries fingers
  };

  /// The last body of the longest chain, or the one that carries a gripper's fingers.
  Body last_body() const {
    int body = model_.root;
    for (int link = model_.root;;) {
      if (is_palm(link)) return {body, true};
      int next = -1;
      for (const int i : children_[at(link)]) {
        const Joint& joint = model_.joints[at(i)];
        if (below_[at(joint.child_link)] + weight(joint) == below_[at(link)]) {
          next = i;
          break;
        }
      }
      if (next < 0 || below_[at(link)] < kJoint) return {body, false};
      link = model_.joints[at(next)].child_link;
      if (model_.joints[at(next)].moves()) body = link;
    }
  }

  /// True if the body carries fingers: joints with such names, or two or more branches that are shorter than
  /// the arm.
  bool is_palm(int link) const {
    const int arm = above_[at(link)] / kJoint, hand = below_[at(link)] / kJoint;
    if (arm < 2 || hand == 0 || hand >= arm) return false;
    int branches = 0, called = 0;
    for (const int i : children_[at(link)]) {
      const Joint& joint = model_.joints[at(i)];
      if (below_[at(joint.child_link)] + weight(joint) < kJoint || follows_the_arm(joint)) continue;
      ++branches;
      called += joint.moves() && called_finger(joint);
    }
    return branches > 1 || called == 1;
  }

  /// True if a joint nearer to the base moves this bar of a linkage. Fingers follow only fingers.
  bool follows_the_arm(const Joint& joint) const {
    if (!joint.mimic || joint.mimic->joint < 0) return false;
    const Joint& leader = model_.joints[at(joint.mimic->joint)];
    return above_[at(leader.child_link)] <= above_[at(joint.parent_link)];
  }

  bool called_finger(const Joint& joint) const {
    if (names_one_of(joint.name, kTurnsOfAWrist)) return false;
    return names_one_of(joint.name, kFingersJoints) ||
           names_one_of(model_.links[at(joint.child_link)].name, kFingers);
  }

  /// The links that cannot move relative to `link`, itself first, and the number of fixed joints to each.
  std::vector<std::array<int, 2>> rigid_with(int link) const {
    std::vector<std::array<int, 2>> out{{link, 0}};
    for (std::size_t i = 0; i < out.size(); ++i)
      for (const int j : children_[at(out[i][0])])
        if (!model_.joints[at(j)].moves()) out.push_back({model_.joints[at(j)].child_link, out[i][1] + 1});
    return out;
  }

  /// The deepest link of the body that can be the end of the arm. Fixed fingers and sensors cannot.
  int deepest(int body) const {
    std::array<int, 2> best{body, -1};
    for (const auto& [link, depth] : rigid_with(body))
      if (depth > best[1] && !names_one_of(model_.links[at(link)].name, kNoEnds)) best = {link, depth};
    return best[0];
  }

  /// For the body that carries fingers: the link whose name means the point between the fingers, else the
  /// link that carries the fingers.
  int point_held(int body) const {
    const std::vector<std::array<int, 2>> links = rigid_with(body);
    for (const Words words : {Words(kPoints), Words(kFrames), Words(kEnds)}) {
      std::array<int, 2> best{-1, -1};
      for (const auto& [link, depth] : links)
        if (names_one_of(model_.links[at(link)].name, words) && depth > best[1]) best = {link, depth};
      if (best[0] >= 0) return best[0];
    }
    for (const auto& [link, depth] : links)
      if (is_palm(link)) return link;
    return body;
  }

  const RobotModel& model_;
  std::vector<std::vector<int>> children_;  ///< joints
  std::vector<int> above_, below_;          ///< weights of the joints to the root, and of the longest branch
};

}  // namespace

void set_tip(RobotModel& model, const std::string& link, const Location& where) {
  if (link.empty()) return;
  model.tip = model.find_link(link);
  if (model.tip >= 0) return;
  std::vector<std::string> names;
  for (const Link& l : model.links) names.push_back(l.name);
  throw Error(Problem{"unknown-link", where,
                      "the robot '" + model.name + "' has no link '" + link + "'" + did_you_mean(link, names),
                      "its links are " + join(names, ", ")});
}

int RobotModel::tool_link() const {
  if (tip >= 0) return tip;
  for (const char* wanted : {"tool0", "flange"})
    if (const int link = find_link(wanted); link >= 0) return link;
  for (const EndEffectorInfo& hand : end_effectors)
    if (hand.parent_link >= 0) return hand.parent_link;
  for (const char* wanted : {"tool0", "flange"})
    for (std::size_t i = 0; i < links.size(); ++i)
      if (links[i].name.ends_with(wanted)) return static_cast<int>(i);
  return ArmEnd(*this).link();
}

}  // namespace polyarm::description
