#pragma once
/// C++ structs of ROS interfaces (.msg, .srv, .action), with the names and members that rosidl gives them.
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/ros_packages/bounds.hpp"

namespace polyarm::ros_packages {


struct Interface {
  std::string package, kind, name;  ///< "std_msgs", "msg", "Float64"
  std::string text;                 ///< of its definition
  Location where;                   ///< of its first line
};

/// The interface of a file: its kind by its ending. Throws Error("bad-interface").
Interface read_interface(const std::string& package, const std::filesystem::path& file);
/// The interfaces of a list: a line "package/kind/Name", its definition indented below. Lines with a word in
/// front are those of another distribution, and left out.
std::vector<Interface> read_interface_list(const std::filesystem::path& file);

/// "Float64MultiArray" → "float64_multi_array", as files are named.
std::string header_name(std::string_view name);
/// The header of an interface. Throws Error("bad-interface") with file and line.
std::string header_code(const Interface& interface);
/// The headers of an interface: "package/kind/header_name.hpp" first, then those in detail/ that include it.
std::vector<std::string> header_names(const Interface& interface);
/// Writes the headers of all below `folder`, and those with the same content not again.
void write_headers(const std::vector<Interface>& all, const std::filesystem::path& folder);

}  // namespace polyarm::ros_packages
