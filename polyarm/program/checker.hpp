#pragma once
/// Finds the faults of a program before anything moves. Not for the control thread; allocates.
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "polyarm/data/data_set.hpp"
#include "polyarm/data/data_store.hpp"
#include "polyarm/language/ast.hpp"

namespace polyarm::program {

/// The known properties of a name or an expression; unknown ones are not reported.
struct Type {
  std::optional<data::Kind> kind;
  std::optional<Dimension> dimension;  ///< of a number
};
Type type_of(const Value& value);

/// All names that a program may use.
struct KnownNames {
  std::map<std::string, Type> names;
  std::map<std::string, Location> defined;  ///< where those are that a file defines
  /// Names in data files that the program does not load: the file, and how `load` writes it.
  std::map<std::string, std::pair<std::string, std::string>> elsewhere;
  /// Where `load` looks for files; empty: files are not checked.
  std::optional<std::filesystem::path> folder;
  std::set<std::string> measured;              ///< tags that only the hardware sets
  std::map<std::string, std::string> brought;  ///< tags that only a link sets, with its name
  struct Robots {
    std::vector<std::string> names, tools;
    std::vector<std::string> belts;  ///< frames that move
  };
  std::optional<Robots>
      robots;  ///< of the cell; empty: the names of robots, tools and frames are not checked

  void add(const data::DataSet& set);
  void add(const data::DataStore& store);
};

/// Adds all findings to `problems`: unknown names and files with the nearest existing ones, conditions that
/// are not boolean, moves to values that are no point, wrong types, unreachable statements. Names that differ
/// only in case and names that a thesis `set` creates are warnings.
void check(const Program& program, const KnownNames& known, Problems& problems);

}  // namespace polyarm::program
