#pragma once
/// Runs one variant of a sweep: a cell in lock-step, with everything that the table asks for measured.
/// Allocates, reads the disk, takes seconds. One at a time in a process.
#include <filesystem>
#include <string>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/sweeps/row.hpp"

namespace polyarm::sweeps {

/// The row of a variant, but for its wall time. Errors of the cell are results. The same variant gives the
/// same row. `state_folder`: for the data files of this run alone.
Row run_variant(const Sweep& sweep, const Variant& variant, const std::string& key,
                const description::Catalogue& catalogue, const std::filesystem::path& state_folder);

/// The row of a variant whose process did not end well.
Row crashed_row(const Variant& variant, const std::string& key, const std::string& why);

/// The value at `share` of the sorted values, nearest rank; 0 without values.
double percentile(std::vector<double> values, double share);

}  // namespace polyarm::sweeps
