#pragma once
/// Parses a text to a Program and reports every error of the file at once. Any thread; allocates.
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/language/ast.hpp"
#include "polyarm/language/words.hpp"

namespace polyarm::program {

/// Limits of nested blocks and operators in brackets; deeper programs are refused.
inline constexpr int kDeepestBlocks = 400;
inline constexpr int kDeepestExpression = 300;

/// The role of a line for its enclosing blocks.
enum class BlockRole { none, opens, continues, closes };
BlockRole block_role(const SourceLine& line);

/// Parses `text`. If problems contains errors, the program has only the valid parts and must not be run.
Program parse(std::string_view text, const std::string& file, Problems& problems);

/// Reads and parses the file. Throws Error with all its problems.
Program load_program(const std::string& path);

/// Returns the program read from a file, once; empty for other files.
using ReadPrograms = std::function<std::optional<Program>(const std::filesystem::path&)>;

}  // namespace polyarm::program
