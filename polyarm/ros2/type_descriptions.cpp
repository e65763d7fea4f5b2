/// The service with which a node describes its message types (REP 2016).
#include <map>
#include <utility>

#include "polyarm/ros2/cell_door.hpp"

namespace polyarm::ros2 {

namespace {

using messages::FieldInfo;
using messages::FieldKind;
using messages::TypeInfo;

/// A struct without fields has this one on the wire.
const char* const kNothing = "structure_needs_at_least_one_member";

/// Type id of a field: +48 for an array, +96 for a bounded sequence, +144 for an unbounded one.
int type_id(const FieldInfo& field) {
  constexpr int kBoundedText = 21;
  return (field.text_capacity > 0 ? kBoundedText : static_cast<int>(field.kind)) +
         48 * static_cast<int>(field.shape);
}

Json fields_of(const TypeInfo& type, std::map<std::string, const TypeInfo*>& used) {
  Json out = Json::array();
  for (const FieldInfo& field : type.fields) {
    Json description{
        {"type_id", type_id(field)}, {"capacity", field.capacity}, {"string_capacity", field.text_capacity}};
    if (field.nested) {
      used.emplace(field.nested->name, field.nested);
      description["nested_type_name"] = field.nested->name;
    }
    out.push_back({{"name", field.name}, {"type", std::move(description)}});
  }
  if (type.fields.empty())
    out.push_back({{"name", kNothing}, {"type", {{"type_id", static_cast<int>(FieldKind::uint8)}}}});
  return out;
}

Json described(const TypeInfo& type, std::map<std::string, const TypeInfo*>& used) {
  return {{"type_name", type.name}, {"fields", fields_of(type, used)}};
}

Json description_of(const TypeInfo& type) {
  std::map<std::string, const TypeInfo*> used;
  Json out{{"type_description", described(type, used)}};
  std::map<std::string, Json> referenced;
  while (referenced.size() < used.size())
    for (const auto& [name, each] : std::map(used))
      if (!referenced.contains(name)) referenced.emplace(name, described(*each, used));
  Json list = Json::array();
  for (auto& [name, each] : referenced) list.push_back(std::move(each));
  out["referenced_type_descriptions"] = std::move(list);
  return out;
}

Json answer(const Bridge& bridge, const Json& request) {
  const std::string name = request["type_name"], hash = request["type_hash"];
  const TypeInfo* type = bridge.wire().find_type(name);
  if (!type) return {{"successful", false}, {"failure_reason", "there is no type " + name + " here"}};
  if (!hash.empty() && hash != type->hash)
    return {{"successful", false},
            {"failure_reason", name + " has the hash " + type->hash + " here, not " + hash}};
  Json out{{"successful", true}, {"type_description", description_of(*type)}};
  if (request["include_type_sources"].get<bool>())
    out["type_sources"] = {
        {{"type_name", type->name}, {"encoding", "msg"}, {"raw_file_contents", type->schema}}};
  return out;
}

}  // namespace

void offer_type_descriptions(Bridge& bridge, const std::string& node) {
  bridge.service(node, node + "/get_type_description", "type_description_interfaces/srv/GetTypeDescription",
                 [&bridge](const Json& request, const Reply& reply) { reply(answer(bridge, request)); });
}

}  // namespace polyarm::ros2
