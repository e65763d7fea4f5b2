#pragma once
/// Keys and types of older ROS releases that current ones do not have, each with its replacement. The list is
/// data; docs/ros-controllers-files.md shows it.
#include <span>
#include <string_view>

namespace polyarm::ros_files {

/// `type` and `key` may contain `*` for any sequence of characters.
struct Superseded {
  const char* type;     ///< controller type, or "controller_manager"
  const char* key;      ///< with dots; "type" for the type itself
  const char* instead;  ///< the replacement: one sentence without a full stop
};

/// All rows, for the reference page and its test.
std::span<const Superseded> superseded_keys();

/// The replacement for `key` in the parameters of a controller of `type` in a ROS 2 file; null if the key is
/// current.
const char* superseded(std::string_view type, std::string_view key) noexcept;

/// The same for a type name in a ROS 2 file; null if the name is current.
const char* superseded_type(std::string_view type) noexcept;

/// True if `pattern`, with `*` for any sequence of characters, matches the whole `text`.
bool matches_pattern(std::string_view pattern, std::string_view text) noexcept;

}  // namespace polyarm::ros_files
