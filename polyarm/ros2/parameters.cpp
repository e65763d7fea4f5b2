/// The services of rcl_interfaces that every node has for its parameters.
#include <set>
#include <utility>

#include "polyarm/messages/types.hpp"
#include "polyarm/ros2/cell_door.hpp"

namespace polyarm::ros2 {

namespace {

using Type = messages::rcl_interfaces::msg::ParameterType;

int type_of(const Json& value) {
  if (value.is_boolean()) return Type::PARAMETER_BOOL;
  if (value.is_number_integer()) return Type::PARAMETER_INTEGER;
  if (value.is_number()) return Type::PARAMETER_DOUBLE;
  if (value.is_string()) return Type::PARAMETER_STRING;
  if (!value.is_array()) return Type::PARAMETER_NOT_SET;
  if (value.empty() || value[0].is_string()) return Type::PARAMETER_STRING_ARRAY;
  if (value[0].is_boolean()) return Type::PARAMETER_BOOL_ARRAY;
  return value[0].is_number_integer() ? Type::PARAMETER_INTEGER_ARRAY : Type::PARAMETER_DOUBLE_ARRAY;
}

const char* field_of(int type) {
  static constexpr const char* names[] = {nullptr,
                                          "bool_value",
                                          "integer_value",
                                          "double_value",
                                          "string_value",
                                          "byte_array_value",
                                          "bool_array_value",
                                          "integer_array_value",
                                          "double_array_value",
                                          "string_array_value"};
  return type > 0 && type < 10 ? names[type] : nullptr;
}

Json to_message(const Json& value) {
  const int type = type_of(value);
  Json out{{"type", type}};
  if (const char* field = field_of(type)) out[field] = value;
  return out;
}

Json from_message(const Json& message) {
  const int type = message.value("type", 0);
  const char* field = field_of(type);
  if (!field) return nullptr;
  if (type != Type::PARAMETER_BOOL_ARRAY) return message[field];
  Json out = Json::array();
  for (const Json& value : message[field]) out.push_back(value != 0);
  return out;
}

Json result(const std::string& refusal) {
  return {{"successful", refusal.empty()}, {"reason", refusal}};
}

bool wanted(const std::string& name, const Json& prefixes, std::uint64_t depth) {
  if (prefixes.empty()) return true;
  for (const Json& prefix : prefixes) {
    const std::string start = prefix.get<std::string>() + ".";
    if (name == prefix) return true;
    if (!name.starts_with(start)) continue;
    std::uint64_t parts = 1;
    for (const char c : name.substr(start.size())) parts += c == '.' ? 1 : 0;
    if (depth == 0 || parts <= depth) return true;
  }
  return false;
}

/// Where a service is asked about names: `each` for every one, with its entry or null.
template <class Each>
Json for_names(const Json& all, const Json& names, Each each) {
  Json out = Json::array();
  for (const Json& name : names) {
    const auto at = all.find(name.get<std::string>());
    out.push_back(each(name.get<std::string>(), at == all.end() ? Json() : *at));
  }
  return out;
}

}  // namespace

void offer_parameters(Bridge& bridge, const std::string& node, ParameterSource source) {
  const auto shared = std::make_shared<ParameterSource>(std::move(source));
  const std::string types = "rcl_interfaces/srv/";
  // A node whose clock is the system's says so.
  const bool simulated = bridge.cell().lock_step();
  const auto listed = [shared, simulated](std::function<void(Json)> got) {
    shared->list([got = std::move(got), simulated](Json all) {
      all["use_sim_time"] = {
          {"value", simulated}, {"text", "stamps are those of /clock"}, {"read_only", true}};
      got(std::move(all));
    });
  };
  bridge.service(node, node + "/list_parameters", types + "ListParameters",
                 [listed](const Json& request, Reply reply) {
                   listed([request, reply](const Json& all) {
                     Json names = Json::array();
                     std::set<std::string> prefixes;
                     for (const auto& [name, entry] : all.items()) {
                       if (!wanted(name, request["prefixes"], request["depth"].get<std::uint64_t>()))
                         continue;
                       names.push_back(name);
                       if (const auto dot = name.rfind('.'); dot != std::string::npos)
                         prefixes.insert(name.substr(0, dot));
                     }
                     reply({{"result", {{"names", names}, {"prefixes", prefixes}}}});
                   });
                 });
  bridge.service(
      node, node + "/get_parameters", types + "GetParameters", [listed](const Json& request, Reply reply) {
        listed([request, reply](const Json& all) {
          reply({{"values", for_names(all, request["names"], [](const std::string&, const Json& entry) {
                    return to_message(entry.is_null() ? Json() : entry["value"]);
                  })}});
        });
      });
  bridge.service(
      node, node + "/get_parameter_types", types + "GetParameterTypes",
      [listed](const Json& request, Reply reply) {
        listed([request, reply](const Json& all) {
          reply({{"types", for_names(all, request["names"], [](const std::string&, const Json& entry) {
                    return entry.is_null() ? 0 : type_of(entry["value"]);
                  })}});
        });
      });
  bridge.service(node, node + "/describe_parameters", types + "DescribeParameters",
                 [listed](const Json& request, Reply reply) {
                   listed([request, reply](const Json& all) {
                     reply({{"descriptors",
                             for_names(all, request["names"], [](const std::string& name, const Json& entry) {
                               if (entry.is_null()) return Json{{"name", name}};
                               return Json{{"name", name},
                                           {"type", type_of(entry["value"])},
                                           {"description", entry["text"]},
                                           {"read_only", entry["read_only"]}};
                             })}});
                   });
                 });
  bridge.service(
      node, node + "/set_parameters_atomically", types + "SetParametersAtomically",
      [shared](const Json& request, Reply reply) {
        Json values = Json::object();
        for (const Json& p : request["parameters"])
          values[p["name"].get<std::string>()] = from_message(p["value"]);
        if (values.empty()) return reply({{"result", result("")}});
        shared->set(values, [reply](const std::string& refusal) { reply({{"result", result(refusal)}}); });
      });
  // Each by itself, as ROS 2 has it: one that is refused does not keep back the others.
  bridge.service(node, node + "/set_parameters", types + "SetParameters",
                 [shared](const Json& request, Reply reply) {
                   const std::size_t count = request["parameters"].size();
                   const auto results = std::make_shared<Json>(Json::array());
                   if (count == 0) return reply({{"results", *results}});
                   for (std::size_t i = 0; i < count; ++i) results->push_back(nullptr);
                   const auto left = std::make_shared<std::size_t>(count);
                   for (std::size_t i = 0; i < count; ++i) {
                     const Json& p = request["parameters"][i];
                     shared->set({{p["name"].get<std::string>(), from_message(p["value"])}},
                                 [results, left, i, reply](const std::string& refusal) {
                                   (*results)[i] = result(refusal);
                                   if (--*left == 0) reply({{"results", *results}});
                                 });
                   }
                 });
}

}  // namespace polyarm::ros2
