#pragma once
/// Cells that come with Polyarm, by name, from any folder: `polyarm run pick_and_place`.
#include <filesystem>
#include <optional>
#include <string>

namespace polyarm::apps {

/// The user's own copy of the example `name` ("pick_and_place", or "examples/pick_and_place" as the pages
/// write it), among the user's cells. Makes the copy if it is missing and reports it on standard error; an
/// existing copy stays as it is. Empty if no example has this name. Throws Error("unwritable").
std::optional<std::filesystem::path> own_copy_of_example(const std::string& name);

}  // namespace polyarm::apps
