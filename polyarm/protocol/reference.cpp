#include "polyarm/protocol/reference.hpp"

#include <algorithm>

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

namespace {

/// A bar would end the table cell, so it is escaped.
std::string in_table(std::string text) {
  for (std::size_t at = 0; (at = text.find('|', at)) != std::string::npos; at += 2) text.insert(at, "\\");
  return text;
}

}  // namespace

std::string request_reference() {
  std::string out = "| request | arguments | result | what it does | may move |\n|---|---|---|---|---|\n";
  for (const HelpRow& row : help_rows()) {
    std::vector<std::string> arguments;
    for (const HelpArgument& a : row.arguments)
      arguments.push_back("`" + a.name + "`" + (a.needed ? "" : "?") + ": " + a.type);
    out += "| `" + row.request + "` | " + join(arguments, ", ") + " | `" + in_table(row.result) + "` | " +
           row.text + " | " + (row.moves ? "yes" : "") + " |\n";
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

}  // namespace polyarm::protocol
