#pragma once
/// Changes one key of a robot in the text of a cell file; everything else, with its comments, stays as it is.
#include <filesystem>
#include <string>

namespace polyarm::apps {

/// The text of `file` with `key: value` at the robot; an existing value is replaced. Throws Error if the file
/// has no such robot, or if the result would not read back with all other keys.
std::string with_robot_key(const std::string& text, const std::string& file, const std::string& robot,
                           const std::string& key, const std::string& value);
/// The same in the cell file of a folder. The former content is kept for data::undo().
void set_robot_key(const std::filesystem::path& cell, const std::string& robot, const std::string& key,
                   const std::string& value);
/// The cell file: itself, or the one in this folder.
std::filesystem::path cell_file_of(const std::filesystem::path& cell);

}  // namespace polyarm::apps
