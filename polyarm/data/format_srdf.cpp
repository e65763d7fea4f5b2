/// Joint states as the group states of an SRDF.
#include <tinyxml2.h>

#include "polyarm/base/text.hpp"
#include "polyarm/base/xml_bounds.hpp"
#include "polyarm/data/format_parts.hpp"

namespace polyarm::data {

void read_srdf(std::string_view text, const std::string& file, DataSet& out, Problems& problems) {
  check_xml_bounds(text, file);
  tinyxml2::XMLDocument document;
  const std::string plain = without_instructions(text);
  if (document.Parse(plain.data(), plain.size()) != tinyxml2::XML_SUCCESS || !document.RootElement())
    return problems.error("bad-xml", {file, document.ErrorLineNum()}, "this is not an SRDF: it is not XML");
  for (auto* state = document.RootElement()->FirstChildElement("group_state"); state;
       state = state->NextSiblingElement("group_state")) {
    JointState joints;
    bool good = state->Attribute("name") != nullptr;
    for (auto* joint = state->FirstChildElement("joint"); joint; joint = joint->NextSiblingElement("joint")) {
      const char* const value = joint->Attribute("value");
      const auto number = parse_number(value ? value : "");
      good = good && joint->Attribute("name") && number;
      if (!good) break;
      joints.names.emplace_back(joint->Attribute("name"));
      joints.positions.push_back(*number);
    }
    if (good && !joints.names.empty())
      out.set(state->Attribute("name"), joints, {file, state->GetLineNum()});
    else
      problems.error("bad-value", {file, state->GetLineNum()},
                     "this group_state has no name, or a joint without name and value");
  }
}

std::string write_srdf(const DataSet& set, const std::string& group, Problems& problems) {
  tinyxml2::XMLPrinter out;
  out.OpenElement("robot");
  out.PushAttribute("name", group.c_str());
  for (const Entry& entry : set.entries()) {
    const JointState* joints = entry.value.as_joints();
    if (!joints || joints->names.empty()) {
      problems.warning("cannot-keep", entry.where,
                       "'" + entry.name + "' is " + name(entry.value.kind()) +
                           "; an SRDF holds joint states with names only, it is left out");
      continue;
    }
    out.OpenElement("group_state");
    out.PushAttribute("name", entry.name.c_str());
    out.PushAttribute("group", group.c_str());
    for (std::size_t i = 0; i < joints->names.size(); ++i) {
      out.OpenElement("joint");
      out.PushAttribute("name", joints->names[i].c_str());
      out.PushAttribute("value", format_number(joints->positions[i]).c_str());
      out.CloseElement();
    }
    out.CloseElement();
  }
  out.CloseElement();
  return out.CStr();
}

}  // namespace polyarm::data
