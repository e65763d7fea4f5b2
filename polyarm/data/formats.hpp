#pragma once
/// Data sets in the forms of others: CSV, JSON, YAML, and the group states of an SRDF.
#include <optional>
#include <string>
#include <string_view>

#include "polyarm/base/error.hpp"
#include "polyarm/data/data_set.hpp"

namespace polyarm::data {

enum class SetForm { text, csv, json, yaml, srdf };
/// By the ending of a file's name; text for all that is not known.
SetForm form_of_file(const std::string& file);
/// "csv", "json", …; nothing for another word.
std::optional<SetForm> form_named(std::string_view name);

/// Reads what is right; what is not, and what a pickle is, goes to `problems`.
DataSet read_form(std::string_view text, SetForm form, const std::string& file, Problems& problems);
/// The set in that form. `group`: of an SRDF, which holds joint states only; what it cannot hold becomes a
/// warning.
std::string write_form(const DataSet& set, SetForm form, const std::string& group, Problems& problems);

}  // namespace polyarm::data
