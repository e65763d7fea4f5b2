#pragma once
/// From text to a Program, with every error of the file at once.
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/program/ast.hpp"
#include "polyarm/program/words.hpp"

namespace polyarm::program {

/// Blocks inside blocks, and operators inside brackets, deeper than this are refused.
inline constexpr int kDeepestBlocks = 400;
inline constexpr int kDeepestExpression = 300;

/// What a line is to the blocks around it.
enum class BlockRole { none, opens, continues, closes };
BlockRole block_role(const SourceLine& line);

/// Parses `text`. Where problems gets errors the program holds only what was understood and must not be run.
Program parse(std::string_view text, const std::string& file, Problems& problems);

/// Reads and parses the file. Throws Error with every problem of it.
Program load_program(const std::string& path);

/// Hands out what a file was read to, once; nothing for other files.
using ReadPrograms = std::function<std::optional<Program>(const std::filesystem::path&)>;

}  // namespace polyarm::program
