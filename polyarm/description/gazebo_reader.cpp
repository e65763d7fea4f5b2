#include "polyarm/description/gazebo_reader.hpp"

#include <algorithm>

#include "polyarm/base/text.hpp"

namespace polyarm::description {

void GazeboReader::finish(RobotModel& model) {
  for (const Element* e : elements_) apply(*e, model);
  for (const Problem& fault : faults_.list())
    warnings_.warning(fault.code, fault.where, fault.what + "; it is ignored", fault.advice);
  if (!weightless_.empty())
    warnings_.warning("gazebo", first_weightless_,
                      "<gazebo> turns gravity off for " + join(weightless_, ", ") +
                          "; physics here applies it to them all the same",
                      "the effort limits of the joints must hold them");
  if (!passed_over_.empty())
    warnings_.warning("gazebo", first_, "<gazebo>: " + join(passed_over_, ", ") + " ignored",
                      "only mu1, mu2, selfCollide, damping and friction are read");
}

void GazeboReader::apply(const Element& e, RobotModel& model) {
  const std::string reference = optional_attribute(e, "reference");
  const int link_index = model.find_link(reference), joint_index = model.find_joint(reference);
  if (!reference.empty() && link_index < 0 && joint_index < 0) {
    const auto names = [&] {
      std::vector<std::string> out;
      for (const Link& l : model.links) out.push_back(l.name);
      for (const Joint& j : model.joints) out.push_back(j.name);
      return out;
    };
    return warning(e, "unknown-link",
                   "<gazebo> names '" + reference + "', which is neither a link nor a joint" +
                       suggest_(reference, names));
  }
  for (const Element* c = e.FirstChildElement(); c; c = c->NextSiblingElement()) {
    if (reference.empty()) controllers(*c, model);
    bool taken = reference.empty() && whole_robot(*c, model);
    if (link_index >= 0) taken = link(*c, model.links[static_cast<std::size_t>(link_index)]);
    if (!taken && joint_index >= 0) taken = joint(*c, model.joints[static_cast<std::size_t>(joint_index)]);
    if (!taken) pass_over(*c);
  }
}

/// The `<plugin>` of ros2_control names its controller file; the plugin itself is ignored.
void GazeboReader::controllers(const Element& plugin, RobotModel& model) {
  if (std::string_view(plugin.Name()) != "plugin") return;
  for (const Element* p = plugin.FirstChildElement("parameters"); p;
       p = p->NextSiblingElement("parameters")) {
    const std::string file = text(p);
    const bool known = std::find(model.controller_files.begin(), model.controller_files.end(), file) !=
                       model.controller_files.end();
    if ((file.ends_with(".yaml") || file.ends_with(".yml")) && !known && model.controller_files.size() < 20)
      model.controller_files.push_back(file);
  }
}

/// Reads an element that applies to every link without its own values.
bool GazeboReader::whole_robot(const Element& e, RobotModel& model) {
  const std::string_view tag = e.Name();
  if (tag != "self_collide" && tag != "selfCollide") return false;
  const auto value = choice(e);
  for (Link& l : model.links)
    if (!l.contact.self_collide) l.contact.self_collide = value;
  return true;
}

bool GazeboReader::link(const Element& e, Link& link) {
  const std::string_view tag = e.Name();
  if (tag == "mu1" || tag == "mu")
    link.contact.mu1 = amount(e);
  else if (tag == "mu2")
    link.contact.mu2 = amount(e);
  else if (tag == "selfCollide" || tag == "self_collide")
    link.contact.self_collide = choice(e);
  else if (tag == "gravity" || tag == "turnGravityOff")
    gravity(e, link, tag == "gravity");
  else
    return false;
  return true;
}

/// Links without gravity are not simulated.
void GazeboReader::gravity(const Element& e, const Link& link, bool off_by) {
  const auto value = choice(e);
  if (!value || *value == off_by) return;
  if (weightless_.empty()) first_weightless_ = at(e);
  weightless_.push_back(link.name);
}

bool GazeboReader::joint(const Element& e, Joint& joint) {
  const std::string_view tag = e.Name();
  if (tag == "damping") {
    joint.damping = amount(e).value_or(joint.damping);
  } else if (tag == "friction") {
    joint.friction = amount(e).value_or(joint.friction);
  } else if (tag == "dynamics") {
    for (const auto& [name, value] : {std::pair{"damping", &joint.damping}, {"friction", &joint.friction}}) {
      *value = number(&e, name).value_or(*value);
      if (const Element* inside = e.FirstChildElement(name)) *value = amount(*inside).value_or(*value);
    }
  } else {
    return false;
  }
  return true;
}

/// A number >= 0, inside the element or in its attribute `value`.
std::optional<double> GazeboReader::amount(const Element& e) {
  const auto out = e.Attribute("value") ? number(&e, "value") : number_inside(e);
  if (!out || *out >= 0) return out;
  error(e, "bad-number", std::string("<") + e.Name() + "> is " + format_number(*out) + ", below zero");
  return std::nullopt;
}

/// True or false, inside the element or in its attribute `value`.
std::optional<bool> GazeboReader::choice(const Element& e) {
  return e.Attribute("value") ? boolean(e, "value") : boolean_inside(e);
}

void GazeboReader::pass_over(const Element& e) {
  if (std::find(tags_.begin(), tags_.end(), e.Name()) != tags_.end()) return;
  if (tags_.empty()) first_ = at(e);
  tags_.emplace_back(e.Name());
  passed_over_.push_back("<" + tags_.back() + "> (line " + std::to_string(e.GetLineNum()) + ")");
}

}  // namespace polyarm::description
