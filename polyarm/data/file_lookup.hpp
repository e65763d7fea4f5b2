#pragma once
/// Which file is meant by a name in a program.
#include <filesystem>
#include <string>
#include <vector>

#include "polyarm/data/import_format.hpp"

namespace polyarm::data {

/// The endings that a program may leave out, in the order in which they are tried.
const std::vector<std::string>& file_endings();

/// The names in `folder` as a program could write them: whole, and without a known ending.
std::vector<std::string> file_names_in(const std::filesystem::path& folder);

/// The file called `name`, looked for beside the file that names it: as written, then, without a known
/// ending, with .points, .data, .script, .txt. Throws Error("no-file") that lists what was tried and the
/// nearest file there is.
std::filesystem::path find_file(const std::string& name, const std::filesystem::path& folder,
                                Location named_at = {});

/// A data file and the points it brings along.
struct LoadedFiles {
  ImportFile data;
  std::vector<ImportFile> points;  ///< the file that PointFile names; empty where it names none
  std::filesystem::path script;    ///< the file that ScriptFile names; empty where it names none
};

/// Reads the data file `name` as it is now, and the PointFile it names, looked for beside it. ScriptFile is
/// looked up, not read. Reads disk: not for the cell thread. Throws Error with every problem of every file.
LoadedFiles load_files(const std::string& name, const std::filesystem::path& folder, Location named_at = {});

}  // namespace polyarm::data
