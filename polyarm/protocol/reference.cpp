#include "polyarm/protocol/reference.hpp"

#include <algorithm>
#include <cctype>
#include <map>
#include <string_view>

#include "polyarm/base/text.hpp"
#include "polyarm/protocol/families.hpp"
#include "polyarm/protocol/request.hpp"

namespace polyarm::protocol {

Help::Answer help_rows() {
  Help::Answer out;
  for (const RequestType* type : request_types()) {
    if (type->facts->session) continue;
    HelpRow row{type->facts->name, {}, type->answer->shape(), type->facts->text, type->facts->moves};
    for (const Member& member : type->arguments->members())
      row.arguments.push_back({member.name, member.type->word(), member.needed});
    out.push_back(std::move(row));
  }
  return out;
}

std::string role_reference() {
  std::string out = "| role | requests |\n|---|---|\n";
  for (const Role role : {Role::watch, Role::operate, Role::program, Role::administer}) {
    std::vector<std::string> names;
    for (const RequestType* type : request_types()) {
      const Facts& facts = *type->facts;
      if (facts.role != role) continue;
      std::string text = std::string("`") + facts.name + "`";
      if (facts.watch_with) text += std::string(" (with `") + facts.watch_with + "`: watch)";
      if (facts.watch_without) text += std::string(" (without `") + facts.watch_without + "`: watch)";
      names.push_back(std::move(text));
    }
    out += std::string("| ") + name(role) + " | " + join(names, ", ") + " |\n";
  }
  return out;
}

namespace {

/// Writes "  name?: string;" for each member. Members of a merged struct are optional; a member of the struct
/// itself replaces one with the same name.
void add_members(const Type& type, const Type& whole, bool request, std::string& out) {
  const auto is_own = [&](const std::string& name) {
    return std::any_of(whole.members().begin(), whole.members().end(),
                       [&](const Member& member) { return member.name == name && !member.merged; });
  };
  const bool optional = &type != &whole;
  for (const Member& member : type.members()) {
    if (member.merged) add_members(*member.type, whole, request, out);
    if (member.merged || (optional && is_own(member.name))) continue;
    const bool left_out = request && member.type->word() == "flag";
    const bool may_be_missing = optional || left_out || member.type->is_optional();
    out += "  " + member.name + (may_be_missing ? "?" : "") + ": " + member.type->typescript() + ";\n";
  }
}

std::string interface_of(const Type& type) {
  std::string out = "export interface " + type.name() + " {\n";
  add_members(type, type, false, out);
  return out + "}\n";
}

}  // namespace

std::string request_typescript() {
  std::vector<const Type*> structs;
  for (const RequestType* type : request_types()) type->answer->collect(structs);
  for (const Type* type : event_types()) type->collect(structs);
  std::sort(structs.begin(), structs.end(),
            [](const Type* a, const Type* b) { return a->name() < b->name(); });
  std::string out =
      "/**\n * Made from polyarm/protocol by tests/protocol: arguments and answers of every request. Do not "
      "edit;\n"
      " * the test ReferenceTest.ThePageHasTheTypes with POLYARM_UPDATE=1 writes it anew.\n"
      " * Lengths in m, angles in rad, quaternions x y z w; a number that is NaN or infinite comes as "
      "null.\n */\n\n";
  for (const Type* type : structs) out += interface_of(*type) + "\n";
  out += "export interface Requests {\n";
  for (const RequestType* type : request_types()) {
    std::string arguments;
    add_members(*type->arguments, *type->arguments, true, arguments);
    for (std::size_t at = 0; (at = arguments.find("\n  ", at)) != std::string::npos;)
      arguments.replace(at, 3, " ");
    if (!arguments.empty()) arguments = " " + std::string(trim(arguments)) + " ";
    if (arguments.ends_with("; ")) arguments.erase(arguments.size() - 2, 1);
    out += std::string("  '") + type->facts->name + "': { args: {" + arguments +
           "}; answer: " + type->answer->typescript() + " };\n";
  }
  return out + "}\n";
}

namespace {

/// The text with a capital first letter and a full stop.
std::string sentence(std::string text) {
  if (!text.empty()) text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return text.ends_with('.') ? text : text + ".";
}

/// How many requests answer with a struct.
using Uses = std::map<const Type*, int>;

std::vector<const Type*> structs_of(const RequestType& type) {
  std::vector<const Type*> out;
  type.answer->collect(out);
  return out;
}

Uses uses_of_structs() {
  Uses out;
  for (const RequestType* type : request_types())
    for (const Type* each : structs_of(*type)) ++out[each];
  return out;
}

/// "control.switch" → "controlswitch": the anchor of its heading.
std::string anchor_of(std::string name) {
  std::erase(name, '.');
  return name;
}

/// "role `operate` (without `percent`: `watch`); may start or stop motion"
std::string conditions_of(const Facts& facts) {
  std::string out = std::string("Role `") + name(facts.role) + "`";
  if (facts.watch_with) out += std::string(" (with `") + facts.watch_with + "`: `watch`)";
  if (facts.watch_without) out += std::string(" (without `") + facts.watch_without + "`: `watch`)";
  if (facts.moves) out += " · may start or stop motion";
  if (facts.urgent) out += " · overtakes earlier requests";
  if (facts.patient) out += " · may wait for a person";
  return out + "\n\n";
}

std::string arguments_of(const Type& arguments) {
  std::string out;
  add_members(arguments, arguments, true, out);
  return out.empty() ? "{}" : "{\n" + out + "}";
}

std::string section_of(const RequestType& type, const Uses& uses) {
  const Facts& facts = *type.facts;
  std::string out = std::string("### ") + facts.name + "\n\n" + sentence(facts.text) + "\n\n" +
                    conditions_of(facts) + "```ts\narguments: " + arguments_of(*type.arguments) +
                    "\nanswer: " + type.answer->typescript() + "\n";
  std::vector<std::string> shared;
  for (const Type* each : structs_of(type)) {
    if (uses.at(each) == 1)
      out += "\n" + interface_of(*each).substr(std::string_view("export ").size());
    else
      shared.push_back("[`" + each->name() + "`](#type-" + lower(each->name()) + ")");
  }
  out += "```\n\n";
  if (!shared.empty()) out += "Shared types: " + join(shared, ", ") + ".\n\n";
  return out;
}

std::string contents_of(const FamilyOfRequests& family) {
  std::vector<std::string> links;
  for (const RequestType* type : family.requests())
    links.push_back(std::string("[`") + type->facts->name + "`](#" + anchor_of(type->facts->name) + ")");
  return std::string("| ") + family.title + " | " + join(links, ", ") + " |\n";
}

}  // namespace

std::string request_reference() {
  std::string out = "| group | requests |\n|---|---|\n";
  for (const FamilyOfRequests& family : kFamilies) out += contents_of(family);
  out += "\n";
  const Uses uses = uses_of_structs();
  for (const FamilyOfRequests& family : kFamilies) {
    out += std::string("## ") + family.title + "\n\n";
    for (const RequestType* type : family.requests()) out += section_of(*type, uses);
  }
  std::map<std::string, const Type*> shared;
  for (const auto& [type, count] : uses)
    if (count > 1) shared.emplace(type->name(), type);
  out += "## Shared types\n\n";
  for (const auto& [name, type] : shared)
    out += "### Type " + name + "\n\n```ts\n" +
           interface_of(*type).substr(std::string_view("export ").size()) + "```\n\n";
  return out;
}

}  // namespace polyarm::protocol
