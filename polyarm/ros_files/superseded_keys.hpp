#pragma once
/// Keys and types that older ROS releases knew and today's do not, each with what to write instead. The list
/// is data; docs/ros-controllers-files.md shows it.
#include <span>
#include <string_view>

namespace polyarm::ros_files {

/// `type` and `key` may hold `*` for any run of characters.
struct Superseded {
  const char* type;     ///< controller type, or "controller_manager"
  const char* key;      ///< dotted; "type" when the type itself is meant
  const char* instead;  ///< one sentence without a full stop: what to write instead
};

/// Every row, for the reference page and its test.
std::span<const Superseded> superseded_keys();

/// What to write instead of `key` in the parameters of a controller of `type` in a ROS 2 file; null where the
/// key is not superseded.
const char* superseded(std::string_view type, std::string_view key) noexcept;

/// The same for a type name as a ROS 2 file has it; null where the name is today's.
const char* superseded_type(std::string_view type) noexcept;

/// Does `pattern`, with `*` for any run of characters, match the whole of `text`?
bool matches_pattern(std::string_view pattern, std::string_view text) noexcept;

}  // namespace polyarm::ros_files
