/// The rcl_interfaces services for parameters, which every node has.
#include <algorithm>
#include <cstddef>
#include <memory>
#include <set>
#include <utility>

#include "polyarm/messages/json.hpp"
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

/// An entry states its type if the value does not show it (an empty list).
int type_of_entry(const Json& entry) {
  if (entry.is_null()) return Type::PARAMETER_NOT_SET;
  const Json& value = entry["value"];
  return value.is_array() && entry.contains("type") ? entry["type"].get<int>() : type_of(value);
}

Json to_message(const Json& entry) {
  const int type = type_of_entry(entry);
  Json out{{"type", type}};
  if (const char* field = field_of(type)) out[field] = entry["value"];
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

/// True if the name begins with one of the prefixes and has at most `depth` parts after it; 0: no limit.
bool wanted(const std::string& name, const Json& prefixes, std::uint64_t depth) {
  const auto deep = [&](std::size_t from) {
    const auto dots = std::count(name.begin() + static_cast<std::ptrdiff_t>(from), name.end(), '.');
    return depth == 0 || static_cast<std::uint64_t>(dots) < depth;
  };
  if (prefixes.empty()) return deep(0);
  for (const Json& prefix : prefixes) {
    const std::string start = prefix.get<std::string>() + ".";
    if (name == prefix || (name.starts_with(start) && deep(start.size()))) return true;
  }
  return false;
}

/// Calls `each` for every name, with its entry or null, and collects the results.
template <class Each>
Json for_names(const Json& all, const Json& names, Each each) {
  Json out = Json::array();
  for (const Json& name : names) {
    const auto at = all.find(name.get<std::string>());
    out.push_back(each(name.get<std::string>(), at == all.end() ? Json() : *at));
  }
  return out;
}

/// The six parameter services of one node, and its change events.
class Parameters : public std::enable_shared_from_this<Parameters> {
 public:
  Parameters(Bridge& bridge, std::string node, ParameterSource source)
      : bridge_{bridge}, node_{std::move(node)}, source_{std::move(source)} {}

  void offer() {
    const auto& event = messages::type_info<messages::rcl_interfaces::msg::ParameterEvent>();
    events_ = bridge_.wire().publisher(node_, "/parameter_events", event, {true, false, 1000});
    serve("list_parameters", "ListParameters", &Parameters::list);
    serve("get_parameters", "GetParameters", &Parameters::get);
    serve("get_parameter_types", "GetParameterTypes", &Parameters::get_types);
    serve("describe_parameters", "DescribeParameters", &Parameters::describe);
    serve("set_parameters", "SetParameters", &Parameters::set_each);
    serve("set_parameters_atomically", "SetParametersAtomically", &Parameters::set_all);
  }

 private:
  using Done = std::function<void(const std::string& refusal)>;

  template <class Member>
  void serve(const char* name, const char* type, Member member) {
    bridge_.service(node_, node_ + "/" + name, std::string("rcl_interfaces/srv/") + type,
                    [self = shared_from_this(), member](const Json& request, Reply reply) {
                      (self.get()->*member)(request, std::move(reply));
                    });
  }

  bool simulated() const { return bridge_.cell().lock_step(); }

  /// The list of parameters, with `use_sim_time` added.
  void listed(std::function<void(const Json& all)> got) {
    source_.list([self = shared_from_this(), got = std::move(got)](Json all) {
      all[kSimTime] = {
          {"value", self->simulated()}, {"text", "stamps are those of /clock"}, {"read_only", true}};
      got(all);
    });
  }

  void list(const Json& request, Reply reply) {
    listed([request, reply = std::move(reply)](const Json& all) {
      Json names = Json::array();
      std::set<std::string> prefixes;
      for (const auto& [name, entry] : all.items()) {
        if (!wanted(name, request["prefixes"], request["depth"].get<std::uint64_t>())) continue;
        names.push_back(name);
        if (const auto dot = name.rfind('.'); dot != std::string::npos) prefixes.insert(name.substr(0, dot));
      }
      reply({{"result", {{"names", names}, {"prefixes", prefixes}}}});
    });
  }

  /// Replies with `field`: the results of `each` for all names.
  void answer(const Json& request, Reply reply, const char* field,
              Json (*each)(const std::string& name, const Json& entry)) {
    listed([names = request["names"], reply = std::move(reply), field, each](const Json& all) {
      reply({{field, for_names(all, names, each)}});
    });
  }
  void get(const Json& request, Reply reply) {
    answer(request, std::move(reply), "values",
           [](const std::string&, const Json& entry) { return to_message(entry); });
  }
  void get_types(const Json& request, Reply reply) {
    answer(request, std::move(reply), "types",
           [](const std::string&, const Json& entry) { return Json(type_of_entry(entry)); });
  }
  void describe(const Json& request, Reply reply) {
    answer(request, std::move(reply), "descriptors", [](const std::string& name, const Json& entry) {
      if (entry.is_null()) return Json{{"name", name}};
      return Json{{"name", name},
                  {"type", type_of_entry(entry)},
                  {"description", entry["text"]},
                  {"additional_constraints", entry.value("constraints", std::string())},
                  {"read_only", entry["read_only"]}};
    });
  }

  void set_all(const Json& request, Reply reply) {
    Json values = Json::object();
    for (const Json& p : request["parameters"])
      values[p["name"].get<std::string>()] = from_message(p["value"]);
    set(std::move(values), [reply = std::move(reply)](const std::string& refusal) {
      reply({{"result", result(refusal)}});
    });
  }

  /// Sets each parameter separately, as in ROS 2: a refused one does not affect the others.
  void set_each(const Json& request, Reply reply) {
    const std::size_t count = request["parameters"].size();
    const auto results = std::make_shared<Json>(Json::array());
    if (count == 0) return reply({{"results", *results}});
    for (std::size_t i = 0; i < count; ++i) results->push_back(nullptr);
    const auto left = std::make_shared<std::size_t>(count);
    for (std::size_t i = 0; i < count; ++i) {
      const Json& p = request["parameters"][i];
      set({{p["name"].get<std::string>(), from_message(p["value"])}},
          [results, left, i, reply](const std::string& refusal) {
            (*results)[i] = result(refusal);
            if (--*left == 0) reply({{"results", *results}});
          });
    }
  }

  void set(Json values, const Done& done) {
    if (const auto time = values.find(kSimTime); time != values.end()) {
      if (*time != simulated()) return done("the clock of time stamps is chosen when the cell is started");
      values.erase(time);
    }
    if (values.empty()) return done("");
    for (const auto& [name, value] : values.items())
      if (value.is_null()) return done("the parameter '" + name + "' has a type, and cannot be removed");
    if (!bridge_.wire().wanted(events_)) return source_.set(values, done);
    listed([self = shared_from_this(), values, done](const Json& before) {
      self->source_.set(values, [self, values, before, done](const std::string& refusal) {
        done(refusal);
        if (refusal.empty()) self->tell_change(values, before);
      });
    });
  }

  /// Publishes the change. Parameters that did not exist in `before` are new.
  void tell_change(const Json& values, const Json& before) {
    listed([self = shared_from_this(), values, before](const Json& now) {
      Json event{{"stamp", self->bridge_.ros_stamp(self->bridge_.cell().now())},
                 {"node", self->node_},
                 {"new_parameters", Json::array()},
                 {"changed_parameters", Json::array()}};
      for (const auto& [name, value] : values.items())
        if (now.contains(name))
          event[before.contains(name) ? "changed_parameters" : "new_parameters"].push_back(
              {{"name", name}, {"value", to_message(now[name])}});
      const auto& type = messages::type_info<messages::rcl_interfaces::msg::ParameterEvent>();
      self->bridge_.wire().publish(self->events_, messages::from_json(type, event));
    });
  }

  static constexpr const char* kSimTime = "use_sim_time";

  Bridge& bridge_;
  std::string node_;
  ParameterSource source_;
  Wire::Id events_ = 0;
};

}  // namespace

void offer_parameters(Bridge& bridge, const std::string& node, ParameterSource source) {
  std::make_shared<Parameters>(bridge, node, std::move(source))->offer();
}

}  // namespace polyarm::ros2
