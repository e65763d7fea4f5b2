#pragma once
/// Changes one key of a robot in the text of a cell file; everything else, with its comments, stays as it is.
/// Reads and writes the disk.
#include <filesystem>
#include <string>

namespace polyarm::cell {

/// The text of `file` with `key: value` at the robot; an existing value is replaced. Throws Error if the file
/// has no such robot, or if the result would not read back with all other keys.
std::string with_robot_key(const std::string& text, const std::string& file, const std::string& robot,
                           const std::string& key, const std::string& value);
/// The same in the cell file of a folder. The former content is kept for undo_robot_key().
void set_robot_key(const std::filesystem::path& cell, const std::string& robot, const std::string& key,
                   const std::string& value);
/// Undoes the last change by set_robot_key() and returns what it was, "payload of arm". Throws
/// Error("no-history") if there is none, and Error("changed-meanwhile") if the file was changed in another
/// way since: that change would be lost.
std::string undo_robot_key(const std::filesystem::path& cell);
/// The cell file: itself, or the one in this folder.
std::filesystem::path cell_file_of(const std::filesystem::path& cell);

}  // namespace polyarm::cell
