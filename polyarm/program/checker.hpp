#pragma once
/// Finds what is wrong with a program before anything moves.
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "polyarm/data/data_set.hpp"
#include "polyarm/data/data_store.hpp"
#include "polyarm/program/ast.hpp"

namespace polyarm::program {

/// What is known of a name or an expression; unknown parts are not complained about.
struct Type {
  std::optional<data::Kind> kind;
  std::optional<Dimension> dimension;  ///< of a number
};
Type type_of(const Value& value);

/// Everything a program may name.
struct KnownNames {
  std::map<std::string, Type> names;
  /// Where `load` looks for files; nothing: files are not looked for.
  std::optional<std::filesystem::path> folder;
  std::set<std::string> measured;              ///< tags that the hardware alone sets
  std::map<std::string, std::string> brought;  ///< tags that a link alone sets, and its name
  struct Robots {
    std::vector<std::string> names, tools;
  };
  std::optional<Robots>
      robots;  ///< of the cell; nothing: what is meant by robots, tools and frames is not looked at

  void add(const data::DataSet& set);
  void add(const data::DataStore& store);
};

/// Adds every finding to `problems`: unknown names and files with the nearest that exist, conditions that are
/// not boolean, moves to what is no point, types that do not fit, statements that are never reached. Names
/// that differ only in case and names that a thesis `set` makes are warnings.
void check(const Program& program, const KnownNames& known, Problems& problems);

}  // namespace polyarm::program
