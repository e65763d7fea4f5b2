#include "polyarm/ros_packages/module_code.hpp"

#include <algorithm>
#include <set>

#include "polyarm/base/text.hpp"
#include "polyarm/ros_packages/check.hpp"

namespace polyarm::ros_packages {

namespace {
/// As a literal of C++; one line.
std::string literal(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  }
  return out + "\"";
}
/// As an argument of CMake.
std::string cmake_text(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\' || c == '$') out += '\\';
    out += c;
  }
  return out + "\"";
}
std::string one_line(const std::string& text) {
  return join(split_words(text), " ");
}
}  // namespace

std::string module_code(const Package& package, const std::vector<PluginClass>& classes,
                        const std::vector<const Package*>& order, const ModuleOptions& options) {
  std::string out, entries, described;
  int number = 0;
  for (const PluginClass& c : classes) {
    described += "  polyarm_ros::described_types()[" + literal(c.name) + "] = " + literal(c.type) + ";\n";
    if (c.is_hardware()) {
      out += "polyarm::hardware::Component* make_" + std::to_string(number) +
             "() {\n  return polyarm_ros::make_component(" + literal(c.name) + ", " + literal(c.type) + ", " +
             (options.simulated ? "true" : "false") + ");\n}\n";
      entries += ",\n    {" + literal(c.name) +
                 ", polyarm::hardware::PluginKind::hardware, polyarm::hardware::kComponentLayout, &make_" +
                 std::to_string(number++) + ", nullptr, " + literal(one_line(c.description)) + "}";
    } else if (c.is_controller()) {
      out += "polyarm::controllers::Controller* make_" + std::to_string(number) +
             "() {\n  return polyarm_ros::make_controller(" + literal(c.type) + ");\n}\n";
      entries += ",\n    {" + literal(c.name) +
                 ", polyarm::hardware::PluginKind::controller, polyarm::controllers::kControllerLayout, "
                 "nullptr, &make_" +
                 std::to_string(number++) + ", " + literal(one_line(c.description)) + "}";
    }
  }
  for (const Package* each : order)
    for (const PluginClass& c : helper_classes(*each, order))
      described += "  polyarm_ros::described_types()[" + literal(c.name) + "] = " + literal(c.type) + ";\n";
  for (const Package* each : order)
    described += "  polyarm_ros::package_folders()[" + literal(each->name) +
                 "] = " + literal(each->folder.string()) + ";\n";
  out += "[[maybe_unused]] const bool described = [] {\n" + described +
         "  return true;\n}();\n}  // namespace\n\n";
  const std::string begin =
      "// Made by `polyarm plugin build`.\n#include \"polyarm_ros/module.hpp\"\n#include "
      "\"polyarm_ros/wrappers.hpp\"\n\nnamespace {\n";
  return begin + out + "POLYARM_PLUGIN(" + literal(package.name) + ", " + literal(package.version) + entries + ")\n";
}

std::string module_cmake(const Package& package, const std::vector<PluginClass>& classes,
                         const std::vector<const Package*>& order, const Kit& kit,
                         const ModuleOptions& options) {
  std::string out = "# Made by `polyarm plugin build`.\ncmake_minimum_required(VERSION 3.22)\nproject(" +
                    package.name + "_module LANGUAGES C CXX)\n";
  const auto set = [&](const char* name, const std::string& value) {
    out += std::string("set(") + name + " " + cmake_text(value) + ")\n";
  };
  set("POLYARM_ROS_KIT", kit.folder().string());
  set("POLYARM_ROS_HEADERS", kit.headers().string());
  set("POLYARM_ROS_GENERATED", options.generated.string());
  set("POLYARM_ROS_COMMAND", options.command.string());
  set("POLYARM_ROS_KEY", kit.key());
  set("POLYARM_ROS_SHARED", options.shared.string());
  const std::set<std::string> messages = kit.message_packages();
  set("POLYARM_ROS_MESSAGES", join(std::vector<std::string>(messages.begin(), messages.end()), ";"));
  out += "include(${POLYARM_ROS_KIT}/cmake/polyarm_ros.cmake)\n";
  if (std::any_of(order.begin(), order.end(), [](const Package* each) { return overrides_configure(*each); }))
    out += "add_compile_definitions(POLYARM_ROS_FOXY)\n";
  for (const Package* each : order) {
    std::vector<std::string> needed;
    for (const Dependency& d : each->dependencies)
      if (d.for_build) needed.push_back(d.name);
    set(("POLYARM_ROS_DEPENDS_" + each->name).c_str(), join(needed, ";"));
    if (each->has_cmake())
      out += "polyarm_ros_package(" + each->name + " " + cmake_text(each->folder.string()) + ")\n";
  }
  out +=
      "polyarm_ros_module(" + package.name + " " + package.name + " ${CMAKE_CURRENT_SOURCE_DIR}/module.cpp";
  std::set<std::string> libraries;
  for (const PluginClass& c : classes) libraries.insert(c.library);
  for (const PluginClass& c : helper_classes(package, order)) libraries.insert(c.library);
  for (const std::string& library : libraries)
    if (!library.empty()) out += " " + cmake_text(library);
  out += ")\n";
  const auto wrap = [&](const char* name, bool (PluginClass::*is)() const) {
    if (std::any_of(classes.begin(), classes.end(), [&](const PluginClass& c) { return (c.*is)(); }))
      out += std::string("polyarm_ros_wrapper(") + name + ")\n";
  };
  wrap("component", &PluginClass::is_hardware);
  wrap("controller", &PluginClass::is_controller);
  for (const Package* each : order)
    if (each != &package && !helper_classes(*each, order).empty())
      out += "polyarm_ros_whole(" + each->name + ")\n";
  return out;
}

}  // namespace polyarm::ros_packages
