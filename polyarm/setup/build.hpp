#pragma once
/// What a cell's files name is loaded: its plugins and its programs.
#include <functional>
#include <optional>

#include "polyarm/base/error.hpp"
#include "polyarm/io/data_files.hpp"
#include "polyarm/language/parser.hpp"
#include "polyarm/program/checker.hpp"
#include "polyarm/setup/cell_file.hpp"
#include "polyarm/signals/tags.hpp"

namespace polyarm::cell {

/// Loads the plugins of the cell's folders, as far as the user has approved them, and of those that are
/// looked through by default. What cannot be used becomes a warning, what is not approved an error.
void load_plugins(const CellFile& file, Problems& problems);
/// The same without those of the cell's folders: no code that a cell brings runs. Warns of each folder whose
/// libraries were therefore not looked into; true if there is one.
bool look_at_plugins(const CellFile& file, Problems& problems);

/// Warns of live data sets that the cell has no file of.
void check_live(const CellFile& file, const signals::Signals& signals, Problems& problems);

struct LoadedPrograms {
  std::optional<program::Program> program, plc;
};

/// The file that the cell names, in its folder. Throws Error at the name where there is none, with the
/// nearest.
std::string file_of_cell(const CellFile& file, const std::string& name, const Location& where);

/// What a program may call robots and tools.
void add_robots(const CellFile& file, program::KnownNames& known);
/// Tags that only the far side of a link sets. What comes as messages (MQTT, topics of ROS 2) is not among
/// them: a program takes a message back so that it sees the next one.
void add_brought(const signals::Signals& signals, program::KnownNames& known);
/// Where tags are defined.
void add_places(const signals::Signals& signals, program::KnownNames& known);

/// Loads the program (a script, or a script-information file whose files are followed), its data and the PLC,
/// and checks them against the names of the store, which `more_names` may add to when the data are there.
LoadedPrograms load_programs(const CellFile& file, const signals::Signals& signals, DataFiles& files,
                             data::DataStore& store, Problems& problems,
                             const std::function<void()>& more_names = {},
                             const program::ReadPrograms& read = {});

}  // namespace polyarm::cell
