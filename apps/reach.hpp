#pragma once
/// Access of cells to files and hosts outside their folders: allowed on the command line, or asked at a
/// terminal.
#include <filesystem>
#include <string>
#include <vector>

#include "polyarm/setup/cell_file.hpp"

namespace polyarm::apps {

/// Confines cells to their folders. Allows the files named on the command line and each `--allow
/// PATH|host:HOST|secret:NAME`, which it removes from the arguments and so reduces argc. Installed robots,
/// ROS packages and caches stay readable. Throws Error("bad-value").
void take_reach_options(int& argc, char** argv);

/// The values of `--allow`, for a cell that this process starts in another one; paths are absolute.
const std::vector<std::string>& allowed_by_options();

/// Shows what the cell needs and the user has not allowed yet, asks for permission, and stores the answer.
/// Without a terminal it does nothing: the cell is then refused, with the option to type.
void ask_for_access(const cell::CellFile& file);

/// Asks a question at the terminal; true if the answer is "yes". Standard input and error must be terminals.
bool ask(const std::string& question);
bool can_ask();

}  // namespace polyarm::apps
