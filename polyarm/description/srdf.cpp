#include "polyarm/description/srdf.hpp"

#include <tinyxml2.h>

#include <algorithm>
#include <set>
#include <utility>

#include "polyarm/base/text.hpp"
#include "polyarm/description/xml_reader.hpp"

namespace polyarm::description {

namespace {

class SrdfReader : private XmlReader {
 public:
  SrdfReader(const std::string& file, RobotModel& model, Problems& problems)
      : XmlReader(file, problems, problems), model_(model) {
    for (const Link& l : model.links) links_.push_back(l.name);
    for (const Joint& j : model.joints) {
      joints_.push_back(j.name);
      if (j.moves()) moving_.push_back(j.name);
    }
  }

  void read(std::string_view text) {
    tinyxml2::XMLDocument document;
    parse(document, text, file_);
    const Element* robot = document.FirstChildElement("robot");
    if (!robot)
      throw Error(Problem{"no-robot", {file_, 1}, "there is no <robot> element", "is this an SRDF file?"});
    check_children(*robot, {"group", "group_state", "end_effector", "virtual_joint", "passive_joint",
                            "disable_collisions", "enable_collisions", "disable_default_collisions",
                            "link_sphere_approximation", "joint_property"});
    check_name(*robot);
    for_each(*robot, "virtual_joint",
             [&](const Element& e) { virtual_.insert(optional_attribute(e, "name")); });
    groups(*robot);
    for_each(*robot, "end_effector", [&](const Element& e) { end_effector(e); });
    states(*robot);
    collisions(*robot);
  }

 private:
  template <typename Step>
  static void for_each(const Element& parent, const char* tag, Step step) {
    for (const Element* e = parent.FirstChildElement(tag); e; e = e->NextSiblingElement(tag)) step(*e);
  }

  void check_name(const Element& robot) {
    const std::string name = optional_attribute(robot, "name");
    if (!name.empty() && !model_.name.empty() && name != model_.name)
      warning(robot, "other-robot",
              "this SRDF is of the robot '" + name + "', the description is of '" + model_.name + "'");
  }

  /// The index of a link; -1 and a problem if there is none.
  int link(const Element& e, const char* attribute_name) {
    const std::string name = attribute(e, attribute_name);
    const int out = name.empty() ? -1 : model_.find_link(name);
    if (out < 0 && !name.empty())
      error(e, "unknown-link", "there is no link '" + name + "'" + suggest_(name, links_));
    return out;
  }

  /// The same for a joint. Joints to the world are ignored without a message, because the cell defines where
  /// the robot is.
  int joint(const Element& e) {
    const std::string name = attribute(e, "name");
    const int out = name.empty() ? -1 : model_.find_joint(name);
    if (out < 0 && !name.empty() && !virtual_.contains(name))
      error(e, "unknown-joint", "there is no joint '" + name + "'" + suggest_(name, moving_));
    return out;
  }

  // --- groups

  struct Draft {
    const Element* element = nullptr;
    std::set<int> joints, links;
    bool open = false, done = false;  ///< open: under evaluation
  };

  void groups(const Element& robot) {
    std::vector<std::string> order;
    for_each(robot, "group", [&](const Element& e) {
      const std::string name = attribute(e, "name", "arm");
      if (name.empty()) return;
      Draft draft;
      draft.element = &e;
      if (!drafts_.emplace(name, std::move(draft)).second)
        return error(e, "duplicate-name", "two groups are called '" + name + "'", "rename one of them");
      order.push_back(name);
      names_of_groups_.push_back(name);
    });
    for (const std::string& name : order) {
      const Draft& draft = resolved(name, 0);
      count(model_.groups.size() / 16 + draft.joints.size() + draft.links.size());
      std::erase_if(model_.groups, [&](const GroupInfo& g) { return g.name == name; });
      model_.groups.push_back(
          {name, {draft.joints.begin(), draft.joints.end()}, {draft.links.begin(), draft.links.end()}});
    }
  }

  const Draft& resolved(const std::string& name, int depth) {
    Draft& draft = drafts_.at(name);
    if (draft.done) return draft;
    draft.open = true;
    const Element& e = *draft.element;
    check_children(e, {"joint", "link", "chain", "group", "passive_joint"});
    for_each(e, "joint", [&](const Element& j) { add_joint(draft, joint(j)); });
    for_each(e, "link", [&](const Element& l) { add_link(draft, link(l, "name")); });
    for_each(e, "chain", [&](const Element& c) { add_chain(draft, c); });
    for_each(e, "group", [&](const Element& g) { add_group(draft, g, depth); });
    draft.open = false;
    draft.done = true;
    return draft;
  }

  /// Counts members and pairs, because a small file can define very many: groups of groups, chains, all pairs
  /// of links.
  void count(std::size_t entries) {
    if ((counted_ += entries) > bounds::kSrdfMembers)
      throw Error(Problem{"too-large",
                          {file_},
                          "the groups and pairs of the file come to more than " + std::to_string(bounds::kSrdfMembers) +
                              " joints and links",
                          "name fewer groups, or shorter chains"});
  }

  void add_joint(Draft& draft, int index) {
    if (index < 0) return;
    count(1);
    draft.joints.insert(index);
    draft.links.insert(model_.joints[static_cast<std::size_t>(index)].child_link);
  }

  void add_link(Draft& draft, int index) {
    if (index < 0) return;
    draft.links.insert(index);
    const int parent = model_.links[static_cast<std::size_t>(index)].parent_joint;
    if (parent >= 0) draft.joints.insert(parent);
  }

  void add_chain(Draft& draft, const Element& e) {
    const int base = link(e, "base_link"), tip = link(e, "tip_link");
    if (base < 0 || tip < 0) return;
    std::vector<int> path;
    for (int at = tip; at != base;) {
      const int parent = model_.links[static_cast<std::size_t>(at)].parent_joint;
      if (parent < 0)
        return error(e, "bad-chain",
                     "the link '" + links_[static_cast<std::size_t>(tip)] + "' is not carried by '" +
                         links_[static_cast<std::size_t>(base)] + "'",
                     "write the link nearer to the root as base_link");
      count(1);
      path.push_back(parent);
      at = model_.joints[static_cast<std::size_t>(parent)].parent_link;
    }
    for (const int joint : path) add_joint(draft, joint);
  }

  void add_group(Draft& draft, const Element& e, int depth) {
    const std::string name = attribute(e, "name");
    const auto found = drafts_.find(name);
    if (name.empty()) return;
    if (found == drafts_.end())
      return error(e, "unknown-group",
                   "there is no group '" + name + "'" + suggest_(name, names_of_groups_));
    if (found->second.open || depth > 100)
      return error(e, "circle", "the group '" + name + "' contains itself in the end");
    const Draft& other = resolved(name, depth + 1);
    count(other.joints.size() + other.links.size());
    draft.joints.insert(other.joints.begin(), other.joints.end());
    draft.links.insert(other.links.begin(), other.links.end());
  }

  bool known_group(const Element& e, const std::string& name) {
    if (name.empty() || drafts_.contains(name)) return !name.empty();
    error(e, "unknown-group", "there is no group '" + name + "'" + suggest_(name, names_of_groups_));
    return false;
  }

  void end_effector(const Element& e) {
    EndEffectorInfo out;
    out.name = attribute(e, "name", "hand");
    out.group = attribute(e, "group", "hand");
    out.parent_group = optional_attribute(e, "parent_group");
    out.parent_link = link(e, "parent_link");
    for (const std::string& group : {out.group, out.parent_group})
      if (!group.empty() && !drafts_.contains(group))
        return warning(e, "unknown-group",
                       "the end effector '" + out.name + "' is ignored: there is no group '" + group + "'" +
                           suggest_(group, names_of_groups_));
    if (out.group.empty() || out.parent_link < 0) return;
    std::erase_if(model_.end_effectors, [&](const EndEffectorInfo& other) { return other.name == out.name; });
    model_.end_effectors.push_back(std::move(out));
  }

  // --- states

  /// "home" first, because the other states take values from it.
  void states(const Element& robot) {
    for (const bool home : {true, false})
      for_each(robot, "group_state", [&](const Element& e) {
        const std::string name = home ? optional_attribute(e, "name") : attribute(e, "name", "home");
        if (!name.empty() && (name == "home") == home) state(e, name);
      });
  }

  void state(const Element& e, const std::string& name) {
    if (!known_group(e, attribute(e, "group", "arm"))) return;
    check_children(e, {"joint"});
    const auto present = model_.named_states.find(name), home = model_.named_states.find("home");
    std::vector<double> values = present != model_.named_states.end() ? present->second
                                 : home != model_.named_states.end()  ? home->second
                                                                      : zeros();
    values.resize(model_.actuated.size());
    for_each(e, "joint", [&](const Element& j) { state_value(j, values); });
    model_.named_states[name] = std::move(values);
  }

  std::vector<double> zeros() const {
    std::vector<double> out;
    for (const int index : model_.actuated) {
      const JointLimits& l = model_.joints[static_cast<std::size_t>(index)].limits;
      double value = std::min(0.0, l.upper.value_or(0));
      if (l.lower) value = std::max(value, *l.lower);
      out.push_back(value);
    }
    return out;
  }

  void state_value(const Element& e, std::vector<double>& values) {
    const int index = joint(e);
    if (index < 0) return;
    const std::string name = joints_[static_cast<std::size_t>(index)];
    const auto found = std::find(model_.actuated.begin(), model_.actuated.end(), index);
    if (found == model_.actuated.end())
      return warning(e, "no-effect",
                     "the joint '" + name +
                         "' has no value of its own: it is fixed, follows another, or is no "
                         "revolute, continuous or prismatic joint");
    if (attribute(e, "value", "0").empty()) return;
    const auto value = number(&e, "value");
    if (!value) return;
    const JointLimits& l = model_.joints[static_cast<std::size_t>(index)].limits;
    if (*value < l.lower.value_or(*value) || *value > l.upper.value_or(*value))
      warning(e, "beyond-limit", name + ": " + format_number(*value) + " is beyond the joint's limits");
    values[static_cast<std::size_t>(found - model_.actuated.begin())] = *value;
  }

  // --- collisions

  void collisions(const Element& robot) {
    std::set<std::array<int, 2>> pairs(model_.allowed_collisions.begin(), model_.allowed_collisions.end());
    for_each(robot, "disable_default_collisions", [&](const Element& e) {
      const int one = collision_link(e, "link");
      count(model_.links.size());
      for (int other = 0; one >= 0 && other < static_cast<int>(model_.links.size()); ++other)
        if (other != one) pairs.insert({std::min(one, other), std::max(one, other)});
    });
    for (const bool enable : {false, true})
      for_each(robot, enable ? "enable_collisions" : "disable_collisions", [&](const Element& e) {
        const int one = collision_link(e, "link1"), other = collision_link(e, "link2");
        count(1 + model_.links.size() / 128);  // searching the links has a cost too
        if (one < 0 || other < 0 || one == other) return;
        if (enable)
          pairs.erase({std::min(one, other), std::max(one, other)});
        else
          pairs.insert({std::min(one, other), std::max(one, other)});
      });
    model_.allowed_collisions.assign(pairs.begin(), pairs.end());
  }

  int collision_link(const Element& e, const char* attribute_name) {
    const std::string name = attribute(e, attribute_name);
    const int out = name.empty() ? -1 : model_.find_link(name);
    if (out < 0 && !name.empty())
      warning(e, "unknown-link",
              "there is no link '" + name + "'" + suggest_(name, links_) + "; the line is ignored");
    return out;
  }

  RobotModel& model_;
  std::vector<std::string> links_, joints_, names_of_groups_;
  std::vector<std::string> moving_;  ///< names to suggest for unknown joints
  std::size_t counted_ = 0;
  std::map<std::string, Draft> drafts_;
  std::set<std::string> virtual_;
};

}  // namespace

void read_srdf(std::string_view text, const std::string& file, RobotModel& model, Problems& problems) {
  SrdfReader(file, model, problems).read(text);
}

std::filesystem::path srdf_beside(const std::filesystem::path& description) {
  std::filesystem::path out = description;
  if (out.extension() == ".xacro") out.replace_extension();
  if (out.extension() == ".urdf" || out.extension() == ".xml") out.replace_extension();
  out += ".srdf";
  return out;
}

namespace {

class SrdfWriter {
 public:
  explicit SrdfWriter(const RobotModel& model) : model_{model} {}

  std::string write(const std::vector<LinkPair>& pairs, bool hung) {
    xml_.PushHeader(false, true);
    open("robot", {{"name", model_.name}});
    for (const GroupInfo& group : model_.groups) write_group(group);
    for (const GroupInfo& group : model_.groups)
      for (const auto& [name, values] : model_.named_states) write_state(group, name, values);
    for (const EndEffectorInfo& e : model_.end_effectors) write_end_effector(e);
    const std::string& root = link(model_.root);
    if (hung && root != "world")
      leaf("virtual_joint",
           {{"name", "fixed_base"}, {"type", "fixed"}, {"parent_frame", "world"}, {"child_link", root}});
    for (const LinkPair& pair : pairs)
      leaf("disable_collisions", {{"link1", link(pair.first)},
                                  {"link2", link(pair.second)},
                                  {"reason", std::string(name(pair.reason))}});
    xml_.CloseElement();
    return xml_.CStr();
  }

 private:
  using Attributes = std::vector<std::pair<const char*, std::string>>;
  void open(const char* tag, const Attributes& attributes) {
    xml_.OpenElement(tag);
    for (const auto& [name, value] : attributes) xml_.PushAttribute(name, value.c_str());
  }
  void leaf(const char* tag, const Attributes& attributes) {
    open(tag, attributes);
    xml_.CloseElement();
  }
  const std::string& link(int index) const { return model_.links[static_cast<std::size_t>(index)].name; }
  const Joint& joint(int index) const { return model_.joints[static_cast<std::size_t>(index)]; }

  /// True if the joints are consecutive.
  bool is_chain(const GroupInfo& group) const {
    for (std::size_t i = 1; i < group.joints.size(); ++i)
      if (joint(group.joints[i]).parent_link != joint(group.joints[i - 1]).child_link) return false;
    return !group.joints.empty();
  }

  void write_group(const GroupInfo& group) {
    open("group", {{"name", group.name}});
    if (is_chain(group))
      leaf("chain", {{"base_link", link(joint(group.joints.front()).parent_link)},
                     {"tip_link", link(joint(group.joints.back()).child_link)}});
    else
      for (const int each : group.joints) leaf("joint", {{"name", joint(each).name}});
    xml_.CloseElement();
  }

  void write_state(const GroupInfo& group, const std::string& name, const std::vector<double>& values) {
    bool begun = false;
    for (std::size_t i = 0; i < model_.actuated.size() && i < values.size(); ++i) {
      if (!std::count(group.joints.begin(), group.joints.end(), model_.actuated[i])) continue;
      if (!std::exchange(begun, true)) open("group_state", {{"name", name}, {"group", group.name}});
      leaf("joint", {{"name", joint(model_.actuated[i]).name}, {"value", format_number(values[i])}});
    }
    if (begun) xml_.CloseElement();
  }

  void write_end_effector(const EndEffectorInfo& e) {
    Attributes attributes{{"name", e.name}, {"parent_link", link(e.parent_link)}, {"group", e.group}};
    if (!e.parent_group.empty()) attributes.emplace_back("parent_group", e.parent_group);
    leaf("end_effector", attributes);
  }

  const RobotModel& model_;
  tinyxml2::XMLPrinter xml_;
};

}  // namespace

std::string write_srdf(const RobotModel& model, const std::vector<LinkPair>& pairs, bool hung) {
  return SrdfWriter(model).write(pairs, hung);
}

}  // namespace polyarm::description
