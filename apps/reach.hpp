#pragma once
/// What the user lets cells reach beyond their folders: by the command line, or asked at a terminal.
#include <filesystem>
#include <string>
#include <vector>

#include "polyarm/setup/cell_file.hpp"

namespace polyarm::apps {

/// Confines cells to their folders. Files that the command line names are the user's choice, and so is each
/// `--allow PATH|host:HOST|secret:NAME`, which is taken out of the words; argc becomes smaller. Installed
/// robots, ROS packages and caches stay readable. Throws Error("bad-value").
void take_reach_options(int& argc, char** argv);

/// What `--allow` named, for a cell that this process starts in another: paths are absolute.
const std::vector<std::string>& allowed_by_options();

/// Shows what the cell wants to reach and the user has not allowed, and asks whether it may; the answer is
/// remembered. Where nobody can be asked it does nothing: the cell is refused, with what to type.
void ask_for_reach(const cell::CellFile& file);

/// A question at the terminal; true if the answer is "yes". Standard input and error have to be terminals.
bool ask(const std::string& question);
bool can_ask();

}  // namespace polyarm::apps
