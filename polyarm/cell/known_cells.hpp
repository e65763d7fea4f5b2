#pragma once
/// Lists the cells that can be opened, and what each of them needs to reach, before one is opened. Reads the
/// disk only; no cell is changed.
#include <filesystem>
#include <string>
#include <vector>

#include "polyarm/protocol/projects.hpp"

namespace polyarm::cell {

struct RestartRequest;

/// Folder of the user's own cells.
std::filesystem::path projects_folder();

/// The user's own cells, the cells beside the open one, and recently opened cells. `open_folder` is recorded
/// as open; empty if no cell is open.
protocol::CellsList::Answer known_cells(const std::filesystem::path& open_folder);

/// What a known cell needs outside its folder. `folder` names the cell; empty: the open cell, whose file is
/// `open`. First stores the entries of `allow` (host:NAME or secret:NAME) as allowed for that cell. Throws
/// Error("unknown-cell" | "no-cell" | "not-here" | "not-wanted").
protocol::CellReach::Answer reach_of_cell(const std::filesystem::path& open, const std::string& folder,
                                          const std::vector<std::string>& allow);

/// Throws unless `wish` stays within what a client may open: a cell from known_cells() or a file of the open
/// project, a program in that folder, a robot from the catalogue or a description in the project. Anything
/// else must be given on the command line. `open_folder` is empty if no cell is open. Throws
/// Error("unknown-cell" | "outside-cell").
void require_within_reach(const RestartRequest& wish, const std::filesystem::path& open_folder);

}  // namespace polyarm::cell
