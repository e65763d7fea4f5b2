#pragma once
/// Finds the file for a name in a program. Reads the disk: not for the cell thread.
#include <filesystem>
#include <string>
#include <vector>

#include "polyarm/data/import_format.hpp"

namespace polyarm::data {

/// The endings that a program may omit, in the order in which they are tried.
const std::vector<std::string>& file_endings();

/// The names in `folder` in the forms that a program may use: complete, and without a known ending.
std::vector<std::string> file_names_in(const std::filesystem::path& folder);

/// The file called `name` in the folder of the file that names it: first as written, then, if it has no known
/// ending, with .points, .data, .script, .txt. Throws Error("no-file") with the names tried and the nearest
/// existing file.
std::filesystem::path find_file(const std::string& name, const std::filesystem::path& folder,
                                Location named_at = {});

/// A data file and its points.
struct LoadedFiles {
  ImportFile data;
  std::vector<ImportFile> points;  ///< the file that PointFile names; empty without PointFile
  std::filesystem::path script;    ///< the file that ScriptFile names; empty without ScriptFile
};

/// Reads the present content of data file `name`, and of the PointFile that it names, in the same folder.
/// Finds ScriptFile but does not read it. Reads the disk: not for the cell thread. Throws Error with all
/// problems of all files.
LoadedFiles load_files(const std::string& name, const std::filesystem::path& folder, Location named_at = {});

}  // namespace polyarm::data
