/// How the text of a request becomes its arguments.
#include <algorithm>
#include <cmath>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/cell/requests_work.hpp"

namespace polyarm::cell {

std::string text_argument(const Json& arguments, const char* name) {
  const auto found = arguments.find(name);
  if (found == arguments.end() || !found->is_string())
    throw Error("bad-argument", std::string("the request needs the text '") + name + "'");
  return found->get<std::string>();
}

std::string text_argument(const Json& arguments, const char* name, const std::string& fallback) {
  return arguments.contains(name) ? text_argument(arguments, name) : fallback;
}

std::vector<std::string> list_argument(const Json& arguments, const char* name) {
  const auto found = arguments.find(name);
  if (found == arguments.end() || found->is_null()) return {};
  std::vector<std::string> out;
  if (found->is_string()) out.push_back(found->get<std::string>());
  if (found->is_array())
    for (const Json& item : *found)
      if (item.is_string()) out.push_back(item.get<std::string>());
  if (out.size() != (found->is_array() ? found->size() : 1))
    throw Error("bad-argument", std::string("'") + name + "' is no list of names");
  return out;
}

bool flag_argument(const Json& arguments, const char* name) {
  const auto found = arguments.find(name);
  return found != arguments.end() && found->is_boolean() && found->get<bool>();
}

double number_argument(const Json& arguments, const char* name, double fallback) {
  const auto found = arguments.find(name);
  if (found == arguments.end() || found->is_null()) return fallback;
  if (!found->is_number()) throw Error("bad-argument", std::string("'") + name + "' is no number");
  return found->get<double>();
}

std::size_t robot_argument(Cell& cell, const Json& arguments) {
  const std::string wanted = text_argument(arguments, "robot", "");
  std::vector<std::string> names;
  for (std::size_t i = 0; i < cell.robots().size(); ++i) {
    names.push_back(cell.robots()[i]->entry.name);
    if (names.back() == wanted) return i;
  }
  if (wanted.empty() && names.size() == 1) return 0;
  if (wanted.empty())
    throw Error("which-robot", "the cell has " + std::to_string(names.size()) + " robots",
                "say which: " + join(names, ", "));
  throw Error("unknown-robot", "there is no robot '" + wanted + "'" + did_you_mean(wanted, names),
              "there are: " + join(names, ", "));
}

hardware::LifecycleState state_argument(const Json& arguments) {
  const std::string text = text_argument(arguments, "state");
  std::vector<std::string> names;
  for (const hardware::LifecycleState state :
       {hardware::LifecycleState::unconfigured, hardware::LifecycleState::inactive,
        hardware::LifecycleState::active, hardware::LifecycleState::finalized}) {
    if (text == hardware::name(state)) return state;
    names.emplace_back(hardware::name(state));
  }
  throw Error("bad-argument", "there is no state '" + text + "'" + did_you_mean(text, names),
              join(names, ", "));
}

bool nested_too_deep(const std::string& line) {
  std::size_t depth = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quoted && c == '\\') ++i;
    if (c == '"') quoted = !quoted;
    if (quoted) continue;
    if (c == '[' || c == '{') ++depth;
    if ((c == ']' || c == '}') && depth > 0) --depth;
    if (depth > bounds::kRequestNesting) return true;
  }
  return false;
}

namespace {

bool fits(const Json& value, ArgumentType type) {
  const auto is_text = [](const Json& item) { return item.is_string(); };
  switch (type) {
    case ArgumentType::text:
      return value.is_string();
    case ArgumentType::number:
      return value.is_number() && std::isfinite(value.get<double>());
    case ArgumentType::flag:
      return value.is_boolean();
    case ArgumentType::names:
      return value.is_string() || (value.is_array() && std::all_of(value.begin(), value.end(), is_text));
    case ArgumentType::map:
      return value.is_object();
    case ArgumentType::message:
      return value.is_string() || value.is_structured() || value.is_number();
    case ArgumentType::any:
      return true;
  }
  return false;
}

}  // namespace

void check_arguments(const Json& request, const RequestInfo& info) {
  std::vector<std::string> known;
  for (const RequestArgument& a : info.arguments) {
    known.emplace_back(a.name);
    const auto found = request.find(a.name);
    if (found == request.end() || found->is_null()) {
      if (!a.needed) continue;
      throw Error("bad-argument", std::string(info.name) + " needs '" + a.name + "' (" + name(a.type) + ")");
    }
    if (!fits(*found, a.type))
      throw Error("bad-argument", std::string("'") + a.name + "' of " + info.name + " is no " + name(a.type));
  }
  for (const auto& [key, value] : request.items())
    if (key != "request" && key != "id" && std::find(known.begin(), known.end(), key) == known.end())
      throw Error("bad-argument",
                  std::string(info.name) + " has no argument '" + key + "'" + did_you_mean(key, known),
                  known.empty() ? "it takes none" : "it takes " + join(known, ", "));
}

Json parse_request(const std::string& line) {
  const char* example = "for example {\"request\": \"control.list\"}";
  if (nested_too_deep(line)) throw Error("bad-request", "the request is nested more than 64 deep", example);
  Json request = Json::parse(line, nullptr, false);
  if (request.is_discarded() || !request.is_object())
    throw Error("bad-request", "a request is one JSON object a line", example);
  return request;
}

}  // namespace polyarm::cell
