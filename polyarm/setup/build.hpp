#pragma once
/// Loads the plugins and programs that a cell's files name.
#include <functional>
#include <optional>

#include "polyarm/base/error.hpp"
#include "polyarm/io/data_files.hpp"
#include "polyarm/language/parser.hpp"
#include "polyarm/program/checker.hpp"
#include "polyarm/setup/cell_file.hpp"
#include "polyarm/signals/tags.hpp"

namespace polyarm::cell {

/// Loads the plugins of the cell's folders that the user has approved, and those of the default folders. A
/// plugin that cannot be used gives a warning, an unapproved one an error.
void load_plugins(const CellFile& file, Problems& problems);
/// The same without the cell's folders, so no code of the cell runs. Warns of each folder whose libraries
/// were not loaded; true if there is one.
bool check_plugins_of_cell(const CellFile& file, Problems& problems);

/// Warns of live data sets without a file in the cell.
void check_live(const CellFile& file, const signals::Signals& signals, Problems& problems);

struct LoadedPrograms {
  std::optional<program::Program> program, plc;
};

/// The path of a file that the cell names. Throws Error at `where` if it does not exist, with the nearest
/// name.
std::string file_of_cell(const CellFile& file, const std::string& name, const Location& where);

/// Adds the names that a program may use for robots and tools.
void add_robots(const CellFile& file, program::KnownNames& known);
/// Adds tags that only the far side of a link sets. Tags that arrive as messages (MQTT, ROS 2 topics) are not
/// added, because a program resets them to notice the next message.
void add_provided(const signals::Signals& signals, program::KnownNames& known);
/// Adds the locations at which tags are defined.
void add_places(const signals::Signals& signals, program::KnownNames& known);

/// Loads the program (a script, or a script-information file and the files that it names), its data and the
/// PLC, and checks them against the names of the store. `more_names` may add names after the data are loaded.
LoadedPrograms load_programs(const CellFile& file, const signals::Signals& signals, DataFiles& files,
                             data::DataStore& store, Problems& problems,
                             const std::function<void()>& more_names = {},
                             const program::ReadPrograms& read = {});

}  // namespace polyarm::cell
