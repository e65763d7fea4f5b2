#pragma once
/// The cells that can be opened, and what they want to reach, before one is. Reads disk; no cell is touched.
#include <filesystem>
#include <string>
#include <vector>

#include "polyarm/protocol/projects.hpp"

namespace polyarm::cell {

struct RestartWish;

/// Where cells of the user's own lie.
std::filesystem::path projects_folder();

/// The user's own cells, those beside the open one, and those that were open lately. `open_folder`: empty where no cell
/// is open; else it is noted as open.
protocol::CellsList::Answer known_cells(const std::filesystem::path& open_folder);

/// What the cell in `folder`, one of the known, names beyond its folder; empty: the open one, by the
/// path of its file. First remembers what is in `allow`, host:NAME or secret:NAME, as allowed for that cell.
/// Throws Error("unknown-cell" | "no-cell" | "not-here" | "not-wanted").
protocol::CellReach::Answer reach_of_cell(const std::filesystem::path& open, const std::string& folder,
                                          const std::vector<std::string>& allow);

/// What a door may have a cell built with: a cell that known_cells() lists or a file of the open project, a
/// program of its folder, a robot of the catalogue or a description in the project. Anything else is named on
/// the command line. `open_folder`: empty where no cell is open. Throws Error("unknown-cell" | "outside-cell").
void require_within_reach(const RestartWish& wish, const std::filesystem::path& open_folder);

}  // namespace polyarm::cell
