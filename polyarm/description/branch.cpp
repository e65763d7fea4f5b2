#include "polyarm/description/branch.hpp"

#include <algorithm>
#include <utility>

#include "polyarm/base/text.hpp"

namespace polyarm::description {

namespace {

std::size_t place(int index) {
  return static_cast<std::size_t>(index);
}

/// By link: the first link of the body that it is fixed to.
std::vector<int> bodies_of_links(const RobotModel& model) {
  std::vector<int> out(model.links.size(), model.root);
  for (const Joint& joint : model.joints)
    out[place(joint.child_link)] = joint.moves() ? joint.child_link : out[place(joint.parent_link)];
  return out;
}

/// What a cut keeps, and the new numbers of it; -1: left out.
class Branch {
 public:
  Branch(const RobotModel& model, int through) : model_(model), body_(bodies_of_links(model)) {
    keep_links(body_[place(through)]);
    number(
        model.links.size(), [&](std::size_t i) { return keeps_[i] != 0; }, link_);
    number(
        model.joints.size(), [&](std::size_t j) { return keeps_[place(model.joints[j].child_link)] != 0; },
        joint_);
    number(
        model.actuated.size(), [&](std::size_t k) { return joint(model.actuated[k]) >= 0; }, actuated_);
  }

  bool is_whole() const { return std::find(keeps_.begin(), keeps_.end(), 0) == keeps_.end(); }
  int link(int old) const { return old < 0 ? -1 : link_[place(old)]; }
  int joint(int old) const { return old < 0 ? -1 : joint_[place(old)]; }
  int actuated(std::size_t old) const { return actuated_[old]; }

  /// True for a name of a joint of the description that is left out.
  bool lacks_joint(const std::string& name) const {
    const int found = model_.find_joint(name);
    return found >= 0 && joint(found) < 0;
  }
  bool lacks_link(const std::string& name) const {
    const int found = model_.find_link(name);
    return found >= 0 && link(found) < 0;
  }

  /// The elements of a list whose index is kept.
  template <typename Item>
  static std::vector<Item> rest(const std::vector<Item>& all, const std::vector<int>& numbers) {
    std::vector<Item> out;
    for (std::size_t i = 0; i < all.size(); ++i)
      if (numbers[i] >= 0) out.push_back(all[i]);
    return out;
  }
  const std::vector<int>& links() const { return link_; }
  const std::vector<int>& joints() const { return joint_; }
  const std::vector<int>& values() const { return actuated_; }

 private:
  template <typename Keeps>
  static void number(std::size_t count, Keeps keeps, std::vector<int>& out) {
    int next = 0;
    for (std::size_t i = 0; i < count; ++i) out.push_back(keeps(i) ? next++ : -1);
  }

  void keep_links(int body) {
    keeps_.assign(model_.links.size(), 0);
    std::vector<char> on_the_way(model_.links.size(), 0);  // by first link of a body
    for (int at = body;;) {
      on_the_way[place(at)] = 1;
      const int joint = model_.links[place(at)].parent_joint;
      if (joint < 0) break;
      at = body_[place(model_.joints[place(joint)].parent_link)];
    }
    for (std::size_t i = 0; i < keeps_.size(); ++i) keeps_[i] = on_the_way[place(body_[i])];
    std::vector<char> behind(model_.links.size(), 0);
    behind[place(body)] = 1;
    for (const Joint& joint : model_.joints)
      if (behind[place(joint.parent_link)] || body_[place(joint.child_link)] == body)
        behind[place(joint.child_link)] = keeps_[place(joint.child_link)] = 1;
    keep_bars();
  }

  /// Bars of a linkage hang beside the arm and follow its joints.
  void keep_bars() {
    for (bool more = true; more;) {
      more = false;
      for (const Joint& joint : model_.joints) {
        char& child = keeps_[place(joint.child_link)];
        if (child || !keeps_[place(joint.parent_link)]) continue;
        const bool follows =
            joint.mimic && keeps_[place(model_.joints[place(joint.mimic->joint)].child_link)];
        if (joint.moves() && !follows) continue;
        child = 1;
        more = true;
      }
    }
  }

  const RobotModel& model_;
  std::vector<int> body_;
  std::vector<char> keeps_;  ///< by link
  std::vector<int> link_, joint_, actuated_;
};

/// The values that a state has for joints that it does not name: those of home, or the nearest to zero.
std::vector<double> unnamed_values(const RobotModel& model, const std::string& state) {
  if (const auto home = model.named_states.find("home"); state != "home" && home != model.named_states.end())
    return home->second;
  std::vector<double> out;
  for (const int index : model.actuated) {
    const JointLimits& limits = model.joints[place(index)].limits;
    const double below = std::min(0.0, limits.upper.value_or(0));
    out.push_back(limits.lower ? std::max(below, *limits.lower) : below);
  }
  return out;
}

/// Leaves out the states that are about other branches alone.
void keep_states(RobotModel& model, const Branch& branch) {
  std::map<std::string, std::vector<double>> out;
  for (const auto& [name, values] : model.named_states) {
    const std::vector<double> usual = unnamed_values(model, name);
    bool moves_kept = false, moves_others = false;
    for (std::size_t k = 0; k < values.size() && k < usual.size(); ++k)
      if (values[k] != usual[k]) (branch.actuated(k) >= 0 ? moves_kept : moves_others) = true;
    if (moves_kept || !moves_others) out[name] = Branch::rest(values, branch.values());
  }
  model.named_states = std::move(out);
}

void keep_transmissions(std::vector<TransmissionInfo>& transmissions, const Branch& branch) {
  std::erase_if(transmissions, [&](const TransmissionInfo& each) {
    return std::any_of(each.joints.begin(), each.joints.end(),
                       [&](const TransmissionEnd& end) { return branch.lacks_joint(end.name); });
  });
}

/// A block without any joint that is left is left out, too. A block that never had one stays.
void keep_hardware(RobotModel& model, const Branch& branch) {
  const auto is_joint = [](const ComponentInfo& c) { return c.kind == "joint"; };
  std::erase_if(model.hardware, [&](HardwareInfo& block) {
    const bool had = std::any_of(block.components.begin(), block.components.end(), is_joint);
    std::erase_if(block.components, [&](const ComponentInfo& c) {
      const auto frame = c.parameters.find("frame_id");
      return (is_joint(c) && branch.lacks_joint(c.name)) ||
             (c.kind == "sensor" && frame != c.parameters.end() && branch.lacks_link(frame->second));
    });
    keep_transmissions(block.transmissions, branch);
    return had && std::none_of(block.components.begin(), block.components.end(), is_joint);
  });
  keep_transmissions(model.transmissions, branch);
}

void keep_groups(RobotModel& model, const Branch& branch) {
  const auto keep = [](std::vector<int>& indices, const auto& renamed) {
    for (int& index : indices) index = renamed(index);
    std::erase(indices, -1);
  };
  for (GroupInfo& group : model.groups) {
    keep(group.joints, [&](int j) { return branch.joint(j); });
    keep(group.links, [&](int l) { return branch.link(l); });
  }
  std::erase_if(model.groups, [](const GroupInfo& g) { return g.joints.empty() && g.links.empty(); });
  const auto has = [&](const std::string& name) {
    return std::any_of(model.groups.begin(), model.groups.end(),
                       [&](const GroupInfo& g) { return g.name == name; });
  };
  for (EndEffectorInfo& hand : model.end_effectors) {
    hand.parent_link = branch.link(hand.parent_link);
    if (!has(hand.parent_group)) hand.parent_group.clear();
  }
  std::erase_if(model.end_effectors,
                [&](const EndEffectorInfo& hand) { return hand.parent_link < 0 || !has(hand.group); });
}

void keep_axes(RobotModel& model, const Branch& branch) {
  if (model.controller_axes.empty()) return;
  model.controller_axes = Branch::rest(model.controller_axes, branch.values());
  for (ControllerAxis& axis : model.controller_axes) {
    for (ControllerAxis::Coupling& coupling : axis.coupling)
      coupling.joint = branch.actuated(place(coupling.joint));
    std::erase_if(axis.coupling, [](const auto& coupling) { return coupling.joint < 0; });
  }
}

void keep_tree(RobotModel& model, const Branch& branch) {
  model.links = Branch::rest(model.links, branch.links());
  for (Link& link : model.links) link.parent_joint = branch.joint(link.parent_joint);
  model.joints = Branch::rest(model.joints, branch.joints());
  for (Joint& joint : model.joints) {
    joint.parent_link = branch.link(joint.parent_link);
    joint.child_link = branch.link(joint.child_link);
    if (joint.mimic) joint.mimic->joint = branch.joint(joint.mimic->joint);
  }
  model.actuated = Branch::rest(model.actuated, branch.values());
  for (int& joint : model.actuated) joint = branch.joint(joint);
  model.root = branch.link(model.root);
  model.tip = branch.link(model.tip);
  for (auto& [a, b] : model.allowed_collisions) a = branch.link(a), b = branch.link(b);
  std::erase_if(model.allowed_collisions, [](const auto& pair) { return pair[0] < 0 || pair[1] < 0; });
}

/// Refuses a branch with a joint that nothing would lead.
void check_followers(const RobotModel& model, const Branch& branch, const std::string& link,
                     const Location& where) {
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const Joint& joint = model.joints[j];
    if (!joint.mimic || branch.joint(static_cast<int>(j)) < 0 || branch.joint(joint.mimic->joint) >= 0)
      continue;
    throw Error(Problem{"bad-branch", where,
                        "the branch through '" + link + "' has the joint '" + joint.name +
                            "', which follows '" + model.joints[place(joint.mimic->joint)].name +
                            "' of another branch",
                        "use the description as one robot, without 'branch'"});
  }
}

[[noreturn]] void refuse_fixed(const RobotModel& model, const std::string& link, const Location& where) {
  const std::vector<std::string> tools = arms_of(model).tools;
  throw Error(Problem{"bad-branch", where,
                      "'" + link + "' is fixed to the base, so it belongs to every branch",
                      tools.empty() ? "name a link behind the first joint of the arm"
                                    : "name a link of one arm: " + join(tools, " or ")});
}

}  // namespace

void keep_branch(RobotModel& model, const std::string& link, const Location& where) {
  if (link.empty()) return;
  RobotModel found = model;
  set_tip(found, link, where);
  if (bodies_of_links(model)[place(found.tip)] == model.root) refuse_fixed(model, link, where);
  const Branch branch(model, found.tip);
  if (branch.is_whole()) return;
  check_followers(model, branch, link, where);
  // The names of what is left out are needed until the tree is cut.
  keep_hardware(found, branch);
  found.tip = model.tip;
  keep_states(found, branch);
  keep_groups(found, branch);
  keep_axes(found, branch);
  keep_tree(found, branch);
  model = std::move(found);
}

namespace {

/// Finds where a description parts into arms. Only joints with a value of their own count.
class ArmSearch {
 public:
  explicit ArmSearch(const RobotModel& model)
      : model_(model), body_(bodies_of_links(model)), below_(model.links.size(), 0) {
    for (auto joint = model.joints.rbegin(); joint != model.joints.rend(); ++joint)
      below_[place(joint->parent_link)] = std::max(
          below_[place(joint->parent_link)], below_[place(joint->child_link)] + (counts(*joint) ? 1 : 0));
  }

  Arms find() const {
    Arms out;
    for (int body = model_.root;;) {
      std::vector<const Joint*> arms;
      for (const Joint& joint : model_.joints)
        if (counts(joint) && body_[place(joint.parent_link)] == body && is_arm(joint, out.shared.size()))
          arms.push_back(&joint);
      if (arms.empty()) return {};
      if (arms.size() == 1) {
        out.shared.push_back(arms[0]->name);
        body = arms[0]->child_link;
        continue;
      }
      for (const Joint* arm : arms) out.tools.push_back(tool_of(model_.links[place(arm->child_link)].name));
      return out;
    }
  }

 private:
  static bool counts(const Joint& joint) { return joint.moves() && !joint.mimic; }
  /// Legs and fingers have fewer joints; the fingers of a large hand have fewer than the arm that carries it.
  bool is_arm(const Joint& joint, std::size_t above) const {
    constexpr std::size_t kLeast = 4;
    const auto joints = static_cast<std::size_t>(below_[place(joint.child_link)]) + 1;
    return joints >= kLeast && joints >= above;
  }
  std::string tool_of(const std::string& link) const {
    RobotModel arm = model_;
    Problems ignored;
    collect(ignored, [&] { keep_branch(arm, link); });
    return ignored.list().empty() ? arm.links[place(arm.tool_link())].name : link;
  }

  const RobotModel& model_;
  std::vector<int> body_, below_;
};

}  // namespace

Arms arms_of(const RobotModel& model) {
  return ArmSearch(model).find();
}

std::string hint_of_arms(const RobotModel& model) {
  const Arms arms = arms_of(model);
  if (arms.tools.empty()) return {};
  const std::string has = "the description has " + std::to_string(arms.tools.size()) + " arms, with " +
                          join(arms.tools, " and ") + ", and is one robot here; ";
  if (!arms.shared.empty())
    return has + "they can be robots of their own only in a description where " + join(arms.shared, " and ") +
           (arms.shared.size() == 1 ? " is" : " are") + " fixed, because all of them turn with it";
  return has +
         "to program each as a robot of its own, write as many robots with the same model and place, and "
         "'branch: " +
         join(arms.tools, "', 'branch: ") + "'";
}

namespace {

bool is_near(const Pose& a, const Pose& b) {
  constexpr double kNear = 0.01, kTurned = 0.05;  // m, rad: two solid bodies of one shape cannot be so near
  return norm(a.position - b.position) <= kNear && angle_between(a.rotation, b.rotation) <= kTurned;
}

bool same_shapes(const std::vector<Shape>& one, const std::vector<Shape>& other) {
  return std::equal(one.begin(), one.end(), other.begin(), other.end(), [](const Shape& a, const Shape& b) {
    return a.kind == b.kind && a.mesh == b.mesh && a.radius == b.radius && a.length == b.length &&
           a.size == b.size && is_near(a.pose, b.pose);
  });
}

/// The poses of the links that are fixed to the root, in its frame.
std::vector<std::pair<int, Pose>> fixed_links(const RobotModel& model) {
  std::vector<std::pair<int, Pose>> out{{model.root, {}}};
  std::vector<Pose> poses(model.links.size());
  const std::vector<int> body = bodies_of_links(model);
  for (const Joint& joint : model.joints) {
    if (body[place(joint.child_link)] != model.root) continue;
    poses[place(joint.child_link)] = poses[place(joint.parent_link)] * joint.origin;
    out.emplace_back(joint.child_link, poses[place(joint.child_link)]);
  }
  return out;
}

}  // namespace

std::vector<char> shared_links(const RobotModel& one, const Pose& T_world_one, const RobotModel& other,
                               const Pose& T_world_other) {
  constexpr double kFar = 1;  // m: only bases near each other can have links in common
  std::vector<char> out(one.links.size(), 0);
  if (one.links.empty() || other.links.empty() || norm(T_world_one.position - T_world_other.position) > kFar)
    return {};
  const auto others = fixed_links(other);
  bool any = false;
  for (const auto& [link, pose] : fixed_links(one)) {
    const Link& mine = one.links[place(link)];
    const auto same =
        std::find_if(others.begin(), others.end(), [&, at = T_world_one * pose](const auto& each) {
          const Link& its = other.links[place(each.first)];
          return its.name == mine.name && same_shapes(mine.collisions, its.collisions) &&
                 is_near(at, T_world_other * each.second);
        });
    if (same == others.end()) continue;
    any = true;
    out[place(link)] = 1;
  }
  return any ? out : std::vector<char>{};
}

}  // namespace polyarm::description
