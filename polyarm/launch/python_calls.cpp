#include "polyarm/launch/python_calls.hpp"

#include <cstdlib>

namespace polyarm::ros_files::python {

Value own_argument(const Arguments& a, const char* name) {
  const Value* value = a.first_or(name);
  return value ? *value : Value{};
}
Value map_of(const Arguments& a) {
  Value out;
  out.kind = Value::Kind::map;
  out.entries = a.named;
  return out;
}

Value path_of(const Arguments& a) {
  std::vector<std::string> parts;
  for (const Value& value : a.values) {
    if (value.kind != Value::Kind::list) {
      parts.push_back(flat(value));
      continue;
    }
    for (const Value& item : value.items) parts.push_back(flat(item));
  }
  return parts.empty() ? Value{} : Value::of(joined_path(parts));
}

Value environment(const Arguments& a) {
  const Value* name = a.first_or("name");
  if (!name || has_gap(flat(*name))) return {};
  if (const char* value = std::getenv(flat(*name).c_str())) return Value::of(value);
  const Value* fallback = a.second_or("default_value");
  return fallback ? *fallback : Value::gap();
}

Value condition(bool unless, const Arguments& a) {
  const std::string text = a.values.empty() ? std::string(1, kUnknown) : lower(flat(a.values.front()));
  const bool yes = text == "true" || text == "1", no = text == "false" || text == "0";
  return yes || no ? Value::of(yes != unless ? "true" : "false") : Value::gap();
}
std::string condition_of(const Arguments& a) {
  const Value* condition = a.find("condition");
  return condition ? flat(*condition) : "true";
}

bool is_process(const std::string& function) {
  return function == "ExecuteProcess" || function == "ExecuteLocal";
}

Value part_of_path(const Value& path, const std::string& name) {
  if (path.kind != Value::Kind::text || has_gap(path.text)) return {};
  const std::filesystem::path file = path.text;
  if (name == "parent") return Value::of(file.parent_path().string());
  if (name == "name") return Value::of(file.filename().string());
  if (name == "stem") return Value::of(file.stem().string());
  if (name == "suffix") return Value::of(file.extension().string());
  if (name != "parents") return {};
  Value out;
  out.kind = Value::Kind::list;
  for (auto at = file.parent_path(); out.items.size() < 20; at = at.parent_path()) {
    out.items.push_back(Value::of(at.string()));
    if (!at.has_relative_path()) break;
  }
  out.weight += out.items.size();
  return out;
}

bool is_description(const std::string& file) {
  return file.ends_with(".urdf") || file.ends_with(".xacro");
}

}  // namespace polyarm::ros_files::python
