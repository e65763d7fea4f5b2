#include "polyarm/sweeps/names.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "polyarm/base/text.hpp"
#include "polyarm/cell/cell.hpp"
#include "polyarm/data/file_lookup.hpp"
#include "polyarm/inside/inside.hpp"

namespace polyarm::sweeps {

namespace {

namespace fs = std::filesystem;

/// Cells that are built to look for a name.
constexpr std::size_t kMostCells = 64;

class Quiet : public cell::Observer {};

class NameCheck {
 public:
  NameCheck(const Sweep& sweep, const description::Catalogue& catalogue, fs::path state_folder)
      : sweep_(sweep), catalogue_(catalogue), state_folder_(std::move(state_folder)) {
    for (const ValueAxis& axis : sweep.values) wanted_.insert(axis.name);
    for (const auto& [name, deviation] : sweep.vary.points) wanted_.insert(name);
    for (const Fault& fault : sweep.faults)
      for (const FaultStep& step : fault.steps)
        for (const auto& [name, value] : step.force) forced_.insert(name);
  }

  std::vector<Problem> run() {
    const cell::CellFile file = cell::read_cell_file(sweep_.cell);
    collect(problems_, [&] { index_of_robot(sweep_, file); });
    for (const std::string& program : sweep_.programs)
      if (!program.empty())
        collect(problems_, [&] {
          // A path may also be one in the working folder, as with --program.
          const cell::CellFile with = cell::read_cell_file(sweep_.cell, overrides_of(sweep_, "", program));
          data::find_file(with.program, with.folder, place_of(program));
        });
    if (!problems_.has_errors()) look_into_cells();
    return problems_.list();
  }

 private:
  Location place_of(const std::string& name) const {
    const auto at = sweep_.where.find(name);
    return at == sweep_.where.end() ? Location{sweep_.file.string()} : at->second;
  }

  /// Every program with the first robot, then every robot with the first program.
  void look_into_cells() {
    std::vector<std::pair<std::string, std::string>> combinations;  // robot, program
    for (const std::string& program : sweep_.programs) combinations.emplace_back(sweep_.robots[0], program);
    for (const std::string& robot : sweep_.robots)
      if (robot != sweep_.robots[0]) combinations.emplace_back(robot, sweep_.programs[0]);
    std::size_t built = 0, tried = 0;
    for (const auto& [robot, program] : combinations) {
      if ((wanted_.empty() && forced_.empty()) || tried == kMostCells) break;
      ++tried;
      try {
        look_into(robot, program);
        ++built;
      } catch (const Error&) {  // the rows of its variants say why
      }
    }
    if (built == 0 || (tried == kMostCells && combinations.size() > kMostCells)) return;
    for (const std::string& name : wanted_)
      problems_.error("unknown-name", place_of(name), "the cell has no '" + name + "'" + near(name, names_),
                      "tags and variables of the cell's files");
    for (const std::string& name : forced_)
      problems_.error("unknown-interface", place_of(name),
                      "there is no interface '" + name + "'" + near(name, interfaces_),
                      "`polyarm interfaces` lists those of a running cell, for example arm/tool/vacuum");
  }

  static std::string near(const std::string& name, const std::set<std::string>& known) {
    return did_you_mean(name, std::vector<std::string>(known.begin(), known.end()));
  }

  void look_into(const std::string& robot, const std::string& program) {
    const cell::CellFile file = cell::read_cell_file(sweep_.cell, overrides_of(sweep_, robot, program));
    cell::CellOptions options;
    options.lock_step = true;
    options.state_folder = state_folder_;
    Quiet quiet;
    cell::Cell whole(file, catalogue_, options, quiet);
    const cell::CellInside& inside = cell::inside_of(whole);
    for (const ValueAxis& axis : sweep_.values)
      if (const data::Value* now = inside.data.store.find(axis.name); now && wanted_.contains(axis.name))
        check_values(axis, *now);
    for (const auto& [name, deviation] : sweep_.vary.points)
      if (const data::Value* now = inside.data.store.find(name); now && wanted_.contains(name))
        if (!now->as_point())
          problems_.error("bad-value", place_of(name), "'" + name + "' is no point and cannot vary",
                          "name a point of the cell");
    const std::vector<std::string> names = inside.data.store.names();
    names_.insert(names.begin(), names.end());
    for (const std::string& name : names) wanted_.erase(name);
    const hardware::InterfaceTable& table = inside.machine.table();
    for (const auto* list : {&table.state_names(), &table.command_names()})
      for (const std::string& name : *list) {
        interfaces_.insert(name);
        forced_.erase(name);
      }
  }

  void check_values(const ValueAxis& axis, const data::Value& now) {
    for (const std::string& text : axis.values) {
      try {
        value_of(text, now, axis.name);
      } catch (const Error& e) {
        Problem problem = e.problems().front();
        problem.where = axis.where;
        problems_.add(std::move(problem));
      }
    }
  }

  const Sweep& sweep_;
  const description::Catalogue& catalogue_;
  fs::path state_folder_;
  Problems problems_;
  std::set<std::string> wanted_, forced_;     ///< names that no cell had yet
  std::set<std::string> names_, interfaces_;  ///< of the cells that were built
};

}  // namespace

std::size_t index_of_robot(const Sweep& sweep, const cell::CellFile& file) {
  std::vector<std::string> names;
  for (const cell::RobotEntry& robot : file.robots) names.push_back(robot.name);
  const auto at = sweep.where.find("robot");
  const Location where = at == sweep.where.end() ? Location{sweep.file.string()} : at->second;
  if (sweep.robot.empty()) {
    if (names.size() == 1) return 0;
    throw Error(Problem{"unknown-robot", where,
                        "the cell has several robots, and the sweep does not say which one is changed",
                        "robot: " + join(names, " or ")});
  }
  const auto found = std::find(names.begin(), names.end(), sweep.robot);
  if (found == names.end())
    throw Error(Problem{"unknown-robot", where,
                        "the cell has no robot '" + sweep.robot + "'" + did_you_mean(sweep.robot, names),
                        "robots are " + join(names, ", ")});
  return static_cast<std::size_t>(found - names.begin());
}

data::Value value_of(const std::string& text, const data::Value& now, const std::string& name) {
  if (now.as_text()) return text;
  if (now.as_boolean()) {
    const std::string word = lower(text);
    if (word == "true" || word == "on" || word == "1") return true;
    if (word == "false" || word == "off" || word == "0") return false;
  }
  if (const data::Number* number = now.as_number())
    if (const auto value = parse_quantity(text, number->dimension))
      return data::Number{*value, number->dimension};
  throw Error("bad-value", "'" + text + "' is no value for " + name + ", which is " + data::name(now.kind()));
}

cell::Overrides overrides_of(const Sweep& sweep, const std::string& robot, const std::string& program) {
  cell::Overrides out;
  out.hardware = sweep.hardware;
  out.program = program;
  if (!robot.empty()) out.robot = sweep.robot.empty() ? robot : sweep.robot + "=" + robot;
  return out;
}

std::vector<Problem> unknown_names(const Sweep& sweep, const description::Catalogue& catalogue,
                                   const fs::path& state_folder) {
  return NameCheck(sweep, catalogue, state_folder).run();
}

}  // namespace polyarm::sweeps
