#include "polyarm/ros_packages/parameter_code.hpp"

#include <algorithm>
#include <cctype>
#include <map>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/yaml/yaml.hpp"

namespace polyarm::ros_packages {

namespace {
[[noreturn]] void refuse(const Location& where, std::string what, std::string advice) {
  throw Error(Problem{"bad-parameters", where, std::move(what), std::move(advice)});
}

void check_identifier(const std::string& name, const Location& where) {
  bool good = !name.empty() && !std::isdigit(static_cast<unsigned char>(name[0]));
  for (const char c : name) good = good && (std::isalnum(static_cast<unsigned char>(c)) || c == '_');
  if (!good) refuse(where, "'" + name + "' is no name", "use letters, digits and _");
}

/// "ft_sensor" → "FtSensor".
std::string struct_name(const std::string& key) {
  std::string out;
  bool upper = true;
  for (const char c : key) {
    if (c == '_') {
      upper = true;
    } else {
      out += upper ? static_cast<char>(std::toupper(static_cast<unsigned char>(c))) : c;
      upper = false;
    }
  }
  return out;
}

std::string text_literal(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '\n') {
      out += "\\n";
      continue;
    }
    if (c == '"' || c == '\\') out += '\\';
    out += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  }
  return out + "\"";
}

/// The type of a parameter, split: "double_array_fixed_6" is an array of double.
struct Type {
  std::string element;  ///< bool, std::int64_t, double or std::string
  bool array = false;
  std::string cpp() const { return array ? "std::vector<" + element + ">" : element; }
};

Type type_of(const Yaml& leaf) {
  std::string written = leaf["type"].text();
  if (const auto fixed = written.find("_fixed_"); fixed != std::string::npos) written.erase(fixed);
  Type out;
  out.array = written.ends_with("_array");
  if (out.array) written.erase(written.size() - 6);
  static const std::map<std::string, std::string> known = {
      {"bool", "bool"}, {"int", "std::int64_t"}, {"double", "double"}, {"string", "std::string"}};
  const auto found = known.find(written);
  if (found == known.end())
    refuse(leaf["type"].where(), "'" + leaf["type"].text() + "' is no type of a parameter",
           "bool, int, double or string, with _array behind it for a list");
  out.element = found->second;
  return out;
}

/// A number as C++ has it; empty if the text is none.
std::string number_literal(const std::string& text, bool real) {
  const std::string word = lower(text);
  for (const char* nan : {".nan", "nan"})
    if (word == nan) return "std::numeric_limits<double>::quiet_NaN()";
  for (const char* inf : {".inf", "inf", "+.inf"})
    if (word == inf) return "std::numeric_limits<double>::infinity()";
  if (word == "-.inf" || word == "-inf") return "-std::numeric_limits<double>::infinity()";
  const bool plain = !word.empty() && word.find_first_not_of("0123456789+-.e") == std::string::npos &&
                     word.find_first_of("0123456789") != std::string::npos && word[0] != 'e';
  if (!plain) return {};
  const bool whole = word.find_first_of(".e") == std::string::npos;
  return real && whole ? word + ".0" : word;
}

std::string value_literal(const Yaml& value, const std::string& element) {
  const std::string text = value.text();
  if (element == "std::string") return text_literal(text);
  if (element == "bool") return value.boolean() ? "true" : "false";
  const std::string number = number_literal(text, element == "double");
  if (number.empty()) refuse(value.where(), "'" + text + "' is no number", "write a number");
  return number;
}

struct Header {
  std::string fields, visits, map_visits;
  std::size_t count = 0;
  std::vector<const Yaml*> groups;  ///< from the root to where we are
  std::vector<std::string> paths;   ///< C++ names of the same

  static bool is_leaf(const Yaml& node) { return node["type"].is_scalar(); }
  static std::string indent(std::size_t depth) { return std::string(2 * depth, ' '); }

  /// One argument of a validator. Sizes stay whole numbers.
  static std::string argument(const Yaml& value, const Type& type, bool size) {
    if (value.is_list()) {
      std::vector<std::string> all;
      for (const Yaml& each : value.items()) all.push_back(argument(each, type, size));
      return "{" + join(all, ", ") + "}";
    }
    const std::string text = value.text();
    if (type.element == "std::string" && !size && value.is_scalar() && number_literal(text, false).empty())
      return text_literal(text);
    if (text == "true" || text == "false") return text;
    const std::string number = number_literal(text, type.element == "double" && !size);
    return number.empty() ? text_literal(text) : number;
  }

  static std::string validators(const Yaml& leaf, const Type& type) {
    std::string out;
    for (const Yaml::Entry& each : leaf["validation"].entries()) {
      std::string name = each.key;
      const bool size = name.starts_with("fixed_size") || name.starts_with("size_");
      if (name.ends_with("<>")) name = name.substr(0, name.size() - 1) + type.element + ">";
      if (name.find_first_not_of(
              "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_:<>") != std::string::npos)
        refuse(each.where, "'" + each.key + "' is no name of a validator", "name a function of C++");
      std::string arguments;
      if (each.value.defined() && each.value.is_list())
        for (const Yaml& value : each.value.items()) arguments += ", " + argument(value, type, size);
      else if (each.value.defined())
        arguments = ", " + argument(each.value, type, size);
      out += " if (auto r = " + name + "(p" + arguments + "); !r) return r;";
    }
    return out;
  }

  /// The call that declares, reads and checks one parameter.
  std::string visit_of(const std::string& name, const std::string& place, const Yaml& leaf) {
    const Type type = type_of(leaf);
    const std::string checks = validators(leaf, type);
    return "v.field(" + name + ", " + place + ", {" +
           (leaf["default_value"].defined() ? "true" : "false") + ", " +
           (leaf["read_only"].boolean(false) ? "true" : "false") + ", " +
           text_literal(leaf["description"].text("")) + "}, " +
           (checks.empty() ? "polyarm_ros::any_value"
                           : "[](const rclcpp::Parameter& p) -> polyarm_ros::Validity {" + checks +
                                 " return {}; }") +
           ");\n";
  }

  void add_field(const std::string& key, const Yaml& leaf, std::size_t depth) {
    const Type type = type_of(leaf);
    std::string initial;
    if (const Yaml value = leaf["default_value"]; value.defined()) {
      if (type.array) {
        std::vector<std::string> all;
        for (const Yaml& each : value.items()) all.push_back(value_literal(each, type.element));
        initial = join(all, ", ");
        initial = " = {" + initial + "}";
      } else {
        initial = " = " + value_literal(value, type.element);
      }
    } else if (!type.array && type.element != "std::string") {
      initial = "{}";
    }
    fields += indent(depth) + type.cpp() + " " + key + initial + ";\n";
  }

  /// The C++ name of the list that a map's keys come from: the nearest one upwards.
  std::string keys_of(const std::string& name, const Location& where) const {
    for (std::size_t i = groups.size(); i-- > 0;)
      if (is_leaf((*groups[i])[name])) return paths[i] + name;
    refuse(where, "'__map_" + name + "' has no parameter '" + name + "' with its keys",
           "add a string_array '" + name + "' beside it or above it");
  }

  /// `prefix`: the C++ expression of the names so far; `place`: that of the struct; `out`: where visits go.
  void group(const Yaml& node, const std::string& prefix, const std::string& place, std::size_t depth,
             std::string& out, bool in_map) {
    if (depth > kDeepestParameter)
      refuse(node.where(), "parameters are nested too deep", "use fewer levels");
    groups.push_back(&node);
    paths.push_back(place);
    for (const Yaml::Entry& each : node.entries()) {
      if (++count > kMostParameters) refuse(each.where, "there are too many parameters", "split the file");
      if (each.key.starts_with("__map_"))
        map(each, prefix, place, depth, out, in_map);
      else
        member(each, prefix, place, depth, out, in_map);
    }
    groups.pop_back();
    paths.pop_back();
  }
  void member(const Yaml::Entry& each, const std::string& prefix, const std::string& place,
              std::size_t depth, std::string& out, bool in_map) {
    check_identifier(each.key, each.where);
    const std::string name = prefix.empty() ? "\"" + each.key : prefix + "." + each.key;
    if (is_leaf(each.value)) {
      if (each.value["type"].text() == "none") return;
      add_field(each.key, each.value, depth);
      out += "    " + visit_of(name + "\"", place + each.key, each.value);
    } else if (each.value.is_map()) {
      fields += indent(depth) + "struct " + struct_name(each.key) + " {\n";
      group(each.value, name, place + each.key + ".", depth + 1, out, in_map);
      fields += indent(depth) + "} " + each.key + ";\n";
    } else {
      refuse(each.where, "'" + each.key + "' has no type", "write {type: double, …}, or parameters below it");
    }
  }
  void map(const Yaml::Entry& each, const std::string& prefix, const std::string& place, std::size_t depth,
           std::string& out, bool in_map) {
    const std::string key = each.key.substr(6), made = "Map" + struct_name(key), nr = std::to_string(depth);
    check_identifier(key, each.where);
    const std::string keys = keys_of(key, each.where);
    fields += indent(depth) + "struct " + made + " {\n";
    std::string inner;
    const std::string name =
        prefix.empty() ? "key" + nr + " + \"" : prefix + ".\" + key" + nr + " + \"";
    group(each.value, name, "each" + nr + ".", depth + 1, inner, true);
    fields += indent(depth) + "};\n" + indent(depth) + "std::map<std::string, " + made + "> " + key +
              "_map;\n";
    std::string& to = in_map ? out : map_visits;
    to += "    for (const std::string& key" + nr + " : " + keys + ") {\n      [[maybe_unused]] auto& each" +
          nr + " = " + place + key + "_map[key" + nr + "];\n" + inner + "    }\n";
  }
};

constexpr const char* kBegin = R"(#pragma once
#include "polyarm_ros/parameters.hpp"
)";
}  // namespace

std::string parameter_header(const std::string& text, const std::string& name,
                             const std::string& validators) {
  const Yaml root = Yaml::parse(text, name);
  const std::vector<Yaml::Entry> top = root.entries();
  if (top.size() != 1 || !top.front().value.is_map())
    refuse({name, 1}, "the file has not one key with the parameters below it",
           "its first key is the namespace of the C++ struct");
  std::string space = top.front().key;
  for (const std::string& part : split_words(space, ":")) check_identifier(part, top.front().where);
  Header made;
  made.group(top.front().value, "", "params.", 1, made.visits, false);
  std::string out = "// Made from " + name + " by `polyarm plugin parameters`.\n" + kBegin;
  if (!validators.empty()) out += "#include " + text_literal(validators) + "\n";
  out += "\nnamespace " + space + " {\n\n";
  // A file may name the rules as members of its own namespace.
  for (const char* rule :
       {"bounds", "element_bounds", "fixed_size", "gt", "gt_eq", "lower_element_bounds", "lt", "lt_eq",
        "not_empty", "one_of", "size_gt", "size_lt", "subset_of", "unique", "upper_element_bounds"})
    out += std::string("using ::rsl::") + rule + ";\n";
  out += "\nstruct Params {\n" + made.fields + "  rclcpp::Time __stamp;\n};\n";
  out += "using StackParams = Params;\n\nstruct ParamsLayout {\n";
  out += "  template <typename Visitor>\n  static void visit(Visitor& v, Params& params) {\n";
  out += "    using namespace ::rsl;\n    static_cast<void>(v);\n    static_cast<void>(params);\n";
  out += made.visits + made.map_visits + "  }\n};\n\n";
  out += "class ParamListener : public ::polyarm_ros::ParamListener<Params, ParamsLayout> {\n public:\n";
  out += "  using Base = ::polyarm_ros::ParamListener<Params, ParamsLayout>;\n  using Base::Base;\n};\n\n";
  return out + "}  // namespace " + space + "\n";
}

}  // namespace polyarm::ros_packages
