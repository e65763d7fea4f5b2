#pragma once
/// What a sweep names in its cell: a robot, programs, tags, variables, points, interfaces. Allocates, reads
/// the disk, builds cells. One at a time in a process.
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/data/value.hpp"
#include "polyarm/setup/cell_file.hpp"
#include "polyarm/sweeps/sweep.hpp"

namespace polyarm::sweeps {

/// The robot that the sweep exchanges and moves. Throws Error("unknown-robot").
std::size_t index_of_robot(const Sweep& sweep, const cell::CellFile& file);

/// The value that a text means for a name, by the kind of its present value. Throws Error("bad-value").
data::Value value_of(const std::string& text, const data::Value& now, const std::string& name);

/// What a variant says instead of the cell file.
cell::Overrides overrides_of(const Sweep& sweep, const std::string& robot, const std::string& program);

/// An error for each name of the sweep that the cell does not have, with the nearest one and its place in the
/// file, and for each value that does not fit. A name counts as known if the cell with one of the programs or
/// one of the robots has it; a combination whose cell cannot be built says nothing. `state_folder`: for the
/// data files of the cells.
std::vector<Problem> unknown_names(const Sweep& sweep, const description::Catalogue& catalogue,
                                   const std::filesystem::path& state_folder);

}  // namespace polyarm::sweeps
