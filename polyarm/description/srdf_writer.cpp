#include <tinyxml2.h>

#include <algorithm>
#include <utility>

#include "polyarm/base/text.hpp"
#include "polyarm/description/srdf.hpp"

namespace polyarm::description {

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
