#pragma once
/// Data sets in common formats: CSV, JSON, YAML, and the group states of an SRDF. Any thread; nothing here
/// reads files.
#include <optional>
#include <string>
#include <string_view>

#include "polyarm/base/error.hpp"
#include "polyarm/data/data_set.hpp"

namespace polyarm::data {

enum class SetForm { text, csv, json, yaml, srdf };
/// By the ending of a file's name; text for an unknown ending.
SetForm form_of_file(const std::string& file);
/// "csv", "json", …; empty for an unknown word.
std::optional<SetForm> form_named(std::string_view name);

/// Reads valid entries and reports the others, and pickle files, in `problems`.
DataSet read_form(std::string_view text, SetForm form, const std::string& file, Problems& problems);
/// The set in that format. `group`: for SRDF, which holds joint states only. Values that the format cannot
/// hold become warnings.
std::string write_form(const DataSet& set, SetForm form, const std::string& group, Problems& problems);

}  // namespace polyarm::data
