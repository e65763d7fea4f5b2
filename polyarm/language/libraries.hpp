#pragma once
/// Programs that are part of the language: `include "polyarm:NAME"`. Const: any thread.
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace polyarm::program {

/// The prefix of the names of libraries in `include`.
inline constexpr std::string_view kLibraryPrefix = "polyarm:";

/// The text of the library, by its whole name ("polyarm:search").
std::optional<std::string_view> library_text(std::string_view name);
std::vector<std::string> library_names();

}  // namespace polyarm::program
