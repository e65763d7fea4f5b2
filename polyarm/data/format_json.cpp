/// Data sets in JSON and YAML: plain values, and maps with a key for their type.
#include <initializer_list>
#include <map>
#include <memory>
#include <utility>

#include "polyarm/base/text.hpp"
#include "polyarm/data/format_parts.hpp"
#include "polyarm/data/import_format.hpp"
#include "polyarm/data/literal.hpp"
#include "polyarm/yaml/yaml.hpp"
#include "polyarm/yaml/yaml_repeats.hpp"

namespace polyarm::data {

namespace {
std::string json_numbers(const std::vector<double>& numbers) {
  std::string out;
  for (const double number : numbers) out += (out.empty() ? "" : ", ") + format_number(number);
  return "[" + out + "]";
}

std::string json_joints(const JointState& joints) {
  if (joints.names.empty()) return json_numbers(joints.positions);
  std::string out;
  for (std::size_t i = 0; i < joints.names.size(); ++i)
    out += (i ? ", " : "") + quoted(joints.names[i]) + ": " + format_number(joints.positions[i]);
  return "{" + out + "}";
}

std::string json_of(const Value& value);

std::string json_point(const Point& point) {
  std::string out = std::string("{\"") + (point.quaternion_given ? "quaternion" : "pose") +
                    "\": " + json_numbers(numbers_of(point));
  if (const Taught* taught = point.taught.get()) {
    for (const auto& [key, text] :
         {std::pair{"frame", &taught->frame}, {"tool", &taught->tool}, {"robot", &taught->robot}})
      if (!text->empty()) out += std::string(", \"") + key + "\": " + quoted(*text);
    if (!taught->joints.positions.empty()) out += ", \"joints\": " + json_joints(taught->joints);
  }
  return out + "}";
}

std::string json_of(const Value& value) {
  if (const bool* flag = value.as_boolean()) return *flag ? "true" : "false";
  if (const std::string* text = value.as_text()) return quoted(*text);
  if (const JointState* joints = value.as_joints()) return "{\"joints\": " + json_joints(*joints) + "}";
  if (const Point* point = value.as_point()) return json_point(*point);
  if (const Number* number = value.as_number())
    return number->dimension == Dimension::none
               ? format_number(number->value)
               : "{\"number\": " + format_number(number->value) +
                     ", \"unit\": " + quoted(unit_text(number->dimension)) + "}";
  std::string out;
  if (const List* list = value.as_list()) {
    for (const Value& item : *list) out += (out.empty() ? "" : ", ") + json_of(item);
    return "[" + out + "]";
  }
  const Record& record = *value.as_record();
  for (std::size_t i = 0; i < record.names.size(); ++i)
    out += (i ? ", " : "") + quoted(record.names[i]) + ": " + json_of(record.values[i]);
  return "{\"record\": {" + out + "}}";
}

std::optional<std::vector<double>> plain_numbers(const Value& value) {
  if (!value.as_list()) return std::nullopt;
  std::vector<double> out;
  for (const Value& item : *value.as_list()) {
    if (!item.as_number()) return std::nullopt;
    out.push_back(item.as_number()->value);
  }
  return out;
}

std::optional<JointState> joints_from(const Value& value) {
  if (const auto numbers = plain_numbers(value)) return JointState{{}, *numbers};
  if (!value.as_record()) return std::nullopt;
  JointState out{value.as_record()->names, {}};
  for (const Value& item : value.as_record()->values) {
    if (!item.as_number()) return std::nullopt;
    out.positions.push_back(item.as_number()->value);
  }
  return out;
}

/// The numbers under these names, if all of them exist.
std::optional<std::vector<double>> named_numbers(const Record& record,
                                                 std::initializer_list<const char*> names) {
  std::vector<double> out;
  for (const char* name : names) {
    const Value* value = record.find(name);
    if (!value || !value->as_number()) return std::nullopt;
    out.push_back(value->as_number()->value);
  }
  return out;
}

std::optional<Value> typed_record(const Record& record, std::string& why);

/// Converts a plain JSON or YAML value to a typed value. Returns empty, with the reason in `why`, if that is
/// not possible.
std::optional<Value> typed(const Value& plain, std::string& why) {
  if (const Record* record = plain.as_record()) return typed_record(*record, why);
  if (!plain.as_list()) return plain;
  List out;
  for (const Value& item : *plain.as_list()) {
    auto value = typed(item, why);
    if (!value) return std::nullopt;
    out.push_back(std::move(*value));
  }
  return Value(std::move(out));
}

std::optional<Value> typed_fields(const Record& record, std::string& why) {
  Record out;
  for (std::size_t i = 0; i < record.names.size(); ++i) {
    auto value = typed(record.values[i], why);
    if (!value) return std::nullopt;
    out.names.push_back(record.names[i]);
    out.values.push_back(std::move(*value));
  }
  return Value(std::move(out));
}

std::optional<Value> typed_point(const Record& record, const std::vector<double>& numbers, std::string& why) {
  auto point = point_from(numbers);
  if (!point) {
    why = "a pose has 6 numbers (x y z roll pitch yaw) or 7 (x y z qx qy qz qw)";
    return std::nullopt;
  }
  Taught taught;
  for (const auto& [key, text] :
       {std::pair{"frame", &taught.frame}, {"tool", &taught.tool}, {"robot", &taught.robot}})
    if (const Value* value = record.find(key); value && value->as_text()) *text = *value->as_text();
  if (const Value* value = record.find("joints"))
    if (const auto joints = joints_from(*value)) taught.joints = *joints;
  if (!(taught == Taught{})) point->taught = std::make_shared<Taught>(taught);
  return Value(*point);
}

std::optional<Value> typed_record(const Record& record, std::string& why) {
  for (const char* key : {"pose", "quaternion"})
    if (const Value* value = record.find(key)) {
      const auto numbers = plain_numbers(*value);
      return typed_point(record, numbers.value_or(std::vector<double>{}), why);
    }
  if (const auto numbers = named_numbers(record, {"x", "y", "z", "qx", "qy", "qz", "qw"}))
    return typed_point(record, *numbers, why);
  if (const auto numbers = named_numbers(record, {"x", "y", "z", "rx", "ry", "rz"}))
    return typed_point(record, *numbers, why);
  const Value* number = record.find("number");
  const Value* unit = record.find("unit");
  if (number && unit && number->as_number() && unit->as_text()) {
    const Unit* known = find_unit(*unit->as_text());
    if (known) return Value(Number{number->as_number()->value * known->scale, known->dimension});
    why = "'" + *unit->as_text() + "' is not a unit";
    return std::nullopt;
  }
  if (const Value* joints = record.find("joints"); joints && record.names.size() == 1)
    if (const auto state = joints_from(*joints)) return Value(*state);
  if (const Value* inner = record.find("record"); inner && inner->as_record() && record.names.size() == 1)
    return typed_fields(*inner->as_record(), why);
  return typed_fields(record, why);
}

/// A map from groups to lists of names.
void read_groups(const Value& groups, const std::string& file, DataSet& out, Problems& problems) {
  const Record* record = groups.as_record();
  if (!record)
    return problems.error("bad-value", {file}, "'groups' is not a map of groups and lists of names");
  for (std::size_t i = 0; i < record->names.size(); ++i) {
    collect(problems, [&] { check_group(record->names[i]); });
    const List* names = record->values[i].as_list();
    if (!names)
      problems.error("bad-value", {file}, "the group '" + record->names[i] + "' is not a list of names");
    else
      for (const Value& name : *names)
        if (name.as_text()) out.set_group(*name.as_text(), record->names[i]);
  }
}

std::string json_groups(const DataSet& set) {
  std::map<std::string, std::string> names;
  for (const Entry& entry : set.entries())
    if (!entry.group.empty())
      names[entry.group] += (names[entry.group].empty() ? "" : ", ") + quoted(entry.name);
  std::string out;
  for (const auto& [group, list] : names)
    out += (out.empty() ? "" : ", ") + quoted(group) + ": [" + list + "]";
  return out;
}

/// Unwraps `polyarm` and `values` if they exist.
void read_tree(const Value& tree, const std::string& file, DataSet& out, Problems& problems) {
  const Record* record = tree.as_record();
  if (!record) return problems.error("bad-value", {file}, "a map of names and values is expected here");
  const Value* version = record->find("polyarm");
  if (version && version->text() != "data/1")
    return problems.error("bad-version", {file},
                          "'" + version->text() + "' is not a kind of file that is read here",
                          "this version reads `polyarm: data/1`");
  const Value* groups = nullptr;
  if (const Value* values = record->find("values"); values && values->as_record()) {
    groups = record->find("groups");
    record = values->as_record();
  }
  for (std::size_t i = 0; i < record->names.size(); ++i) {
    std::string why;
    if (record->names[i] == "polyarm") continue;
    if (const auto value = typed(record->values[i], why))
      out.set(record->names[i], *value);
    else
      problems.error("bad-value", {file}, "'" + record->names[i] + "' is not a value: " + why);
  }
  if (groups) read_groups(*groups, file, out, problems);
}

Value tree_of(const Yaml& node) {
  if (node.is_map()) {
    Record out;
    for (const Yaml::Entry& entry : node.entries()) {
      out.names.push_back(entry.key);
      out.values.push_back(entry.value.defined() ? tree_of(entry.value) : Value(""));
    }
    return out;
  }
  if (node.is_list()) {
    List out;
    for (const Yaml& item : node.items()) out.push_back(tree_of(item));
    return out;
  }
  const std::string text = node.text();
  std::string ignored;
  const auto value = parse_literal(text, ignored);
  return value && (value->as_boolean() || value->as_number()) ? *value : Value(text);
}
}  // namespace

void read_json(std::string_view text, const std::string& file, DataSet& out, Problems& problems) {
  std::string why;
  if (const auto tree = parse_literal(text, why))
    read_tree(*tree, file, out, problems);
  else
    problems.error("bad-json", {file}, "this is not a JSON file of values: " + why);
}

void read_yaml(std::string_view text, const std::string& file, DataSet& out, Problems& problems) {
  collect(problems, [&] {
    const Yaml yaml = Yaml::parse(text, file);
    check_repeats(yaml, problems);
    read_tree(tree_of(yaml), file, out, problems);
  });
}

std::string write_json(const DataSet& set) {
  std::string out;
  for (const Entry& entry : set.entries())
    out += (out.empty() ? "\n  " : ",\n  ") + quoted(entry.name) + ": " + json_of(entry.value);
  const std::string groups = json_groups(set);
  return "{\"polyarm\": \"data/1\",\n" + (groups.empty() ? "" : " \"groups\": {" + groups + "},\n") +
         " \"values\": {" + out + "\n}}\n";
}

std::string write_yaml(const DataSet& set) {
  const std::string groups = json_groups(set);
  std::string out = "polyarm: data/1\n" + (groups.empty() ? "" : "groups: {" + groups + "}\n") + "values:\n";
  for (const Entry& entry : set.entries())
    out += "  " + quoted(entry.name) + ": " + json_of(entry.value) + "\n";
  return out;
}

}  // namespace polyarm::data
