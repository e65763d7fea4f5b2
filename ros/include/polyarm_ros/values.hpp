#pragma once
/// Parameters of a controllers file as overrides of a node, and the node's parameters as Polyarm's.
#include <cstdint>
#include <cstdlib>
#include <deque>
#include <string>
#include <vector>

#include "polyarm/controllers/parameters.hpp"
#include "rclcpp/node_interfaces/node_interfaces.hpp"

namespace polyarm_ros {

/// The value of a scalar of YAML.
inline rclcpp::ParameterValue scalar(const std::string& text) {
  if (text == "true" || text == "True") return rclcpp::ParameterValue(true);
  if (text == "false" || text == "False") return rclcpp::ParameterValue(false);
  for (const char* nan : {".nan", ".NaN", ".NAN"})
    if (text == nan) return rclcpp::ParameterValue(std::numeric_limits<double>::quiet_NaN());
  for (const char* inf : {".inf", ".Inf", ".INF", "-.inf", "-.Inf", "-.INF"})
    if (text == inf)
      return rclcpp::ParameterValue(text[0] == '-' ? -std::numeric_limits<double>::infinity()
                                                   : std::numeric_limits<double>::infinity());
  const bool number = !text.empty() && text.find_first_not_of("0123456789+-.eE") == std::string::npos &&
                      text.find_first_of("0123456789") != std::string::npos;
  char* end = nullptr;
  if (number && text.find_first_of(".eE") == std::string::npos) {
    const long long whole = std::strtoll(text.c_str(), &end, 10);
    if (*end == '\0') return rclcpp::ParameterValue(static_cast<std::int64_t>(whole));
  }
  if (number) {
    const double real = std::strtod(text.c_str(), &end);
    if (*end == '\0') return rclcpp::ParameterValue(real);
  }
  return rclcpp::ParameterValue(text);
}

/// A list of YAML: of one type if all values have it, numbers as doubles if one has a point, else texts.
inline rclcpp::ParameterValue list(const std::vector<std::string>& texts) {
  using Type = rclcpp::ParameterType;
  bool whole = true, number = true, boolean = true;
  std::vector<rclcpp::ParameterValue> values;
  for (const std::string& text : texts) {
    const Type type = values.emplace_back(scalar(text)).get_type();
    whole = whole && type == Type::PARAMETER_INTEGER;
    number = number && (type == Type::PARAMETER_INTEGER || type == Type::PARAMETER_DOUBLE);
    boolean = boolean && type == Type::PARAMETER_BOOL;
  }
  const auto all = [&](auto element) {
    std::vector<decltype(element)> out;
    for (const auto& each : values) out.push_back(each.get<decltype(element)>());
    return rclcpp::ParameterValue(out);
  };
  if (texts.empty()) return rclcpp::ParameterValue(texts);
  if (boolean) return all(bool());
  if (whole) return all(std::int64_t());
  return number ? all(double()) : rclcpp::ParameterValue(texts);
}

inline std::vector<rclcpp::Parameter> overrides(const polyarm::controllers::Parameters& from) {
  std::vector<rclcpp::Parameter> out;
  for (const auto& [key, entry] : from.entries) {
    if (entry.list)
      out.emplace_back(key, list(entry.values));
    else if (!entry.values.empty())
      out.emplace_back(key, scalar(entry.values.front()));
  }
  return out;
}

/// The node's parameters, declared as Polyarm's: it lists them, and changes those that may change.
class Values {
 public:
  void declare(const rclcpp::node_interfaces::NodeCore& node, polyarm::controllers::Parameters& to) {
    using Type = rclcpp::ParameterType;
    bools_.clear(), ints_.clear(), reals_.clear();
    for (const auto& [name, known] : node.polyarm_parameters()) {
      if (name == "robot_description") continue;  // too long for a list
      const auto& [value, fixed] = known;
      polyarm::controllers::ParameterNote note;
      note.changeable = !fixed;
      switch (value.get_type()) {
        case Type::PARAMETER_BOOL:
          to.read(name, bools_.emplace_back(value.get<bool>()), note);
          break;
        case Type::PARAMETER_INTEGER:
          to.read(name, ints_.emplace_back(value.get<int>()), note);
          break;
        case Type::PARAMETER_DOUBLE:
          to.read(name, reals_.emplace_back(value.get<double>()), note);
          break;
        case Type::PARAMETER_STRING:
          read_text(name, value.get<std::string>(), to);
          break;
        default:
          read_texts(name, to);
      }
    }
  }
  rclcpp::Parameter parameter(const polyarm::controllers::ParameterChange& change) const {
    using Type = polyarm::controllers::ParameterType;
    if (change.type == Type::boolean) return rclcpp::Parameter(change.key, change.value != 0);
    if (change.type == Type::integer)
      return rclcpp::Parameter(change.key, static_cast<std::int64_t>(change.value));
    return rclcpp::Parameter(change.key, change.value);
  }

 private:
  static void read_text(const std::string& name, std::string value, polyarm::controllers::Parameters& to) {
    to.read(name, value, {});
  }
  static void read_texts(const std::string& name, polyarm::controllers::Parameters& to) {
    std::vector<std::string> values;
    to.read(name, values, {});
  }
  std::deque<bool> bools_;
  std::deque<int> ints_;
  std::deque<double> reals_;
};

/// "~/commands" and "/commands" are the port "commands".
inline std::string port_name(const std::string& topic) {
  const auto begin = topic.find_first_not_of("~/");
  return begin == std::string::npos ? topic : topic.substr(begin);
}

}  // namespace polyarm_ros
