/// What a rehearsal knows of force sensors, belts and streams: only what the files of the cell say.
#include <algorithm>

#include "polyarm/base/text.hpp"
#include "polyarm/cell/rehearsal_stage.hpp"
#include "polyarm/inside/inside.hpp"

namespace polyarm::cell {

namespace {
/// Throws Error if none of the entries of the cell has this name. `what`: belt or stream.
template <typename Entries>
void require(const std::string& what, const std::string& name, const Entries& entries) {
  std::vector<std::string> names;
  for (const auto& each : entries) names.push_back(each.name);
  if (std::find(names.begin(), names.end(), name) != names.end()) return;
  throw Error("unknown-" + what, "the cell has no " + what + " '" + name + "'" + did_you_mean(name, names),
              names.empty() ? "describe it in cell.yaml: " + what + "s" : "known are: " + join(names, ", "));
}
}  // namespace

/// Keeps an error that follows from the files of the cell, whatever the values in the line are.
void Stage::by_cell(const std::function<void()>& check) {
  try {
    check();
  } catch (const Error& e) {
    of_cell_.insert(e.problems().front().what);
    throw;
  }
}

void Stage::comply(const std::string& robot, const program::Compliance&) {
  const std::string& name = moves_of_program().name_of(robot);
  const auto check = [&](const CellRobot& found) {
    ProgramMoves::check_compliance(found.entry);
    if (!may_feel_force(found, cell_.setup.robots))
      throw Error(
          "signal", "'" + name + "' has no force sensor, so it cannot yield to forces",
          "write `force_sensor: true` at the robot in cell.yaml, for physics, or use hardware with a sensor");
  };
  for (const auto& each : cell_.setup.robots)
    if (each->entry.name == name) by_cell([&] { check(*each); });
}

std::array<double, 6> Stage::wrench(const std::string& robot) {
  const std::string& name = moves_of_program().name_of(robot);
  for (const auto& each : cell_.setup.robots)
    if (each->entry.name == name && !may_feel_force(*each, cell_.setup.robots))
      by_cell([&] {
        throw Error("signal", "'" + name + "' has no force sensor",
                    "write `force_sensor: true` at the robot in cell.yaml, for physics, or use hardware with "
                    "a sensor");
      });
  return {};
}

void Stage::require_belt(const std::string& belt) {
  by_cell([&] { require("belt", belt, cell_.setup.file.belts); });
}

bool Stage::next_part(const std::string& belt, const std::string& robot) {
  require_belt(belt);
  moves_of_program().suppose_part(belt, robot);
  return true;
}

double Stage::waiting_parts(const std::string& belt) {
  require_belt(belt);
  return 1;
}

double Stage::missed_parts(const std::string& belt) {
  require_belt(belt);
  return 0;
}

bool Stage::is_connected(const std::string& stream) {
  by_cell([&] { require("stream", stream, cell_.setup.file.streams); });
  return true;
}

std::string Stage::next_line(const std::string& stream) {
  is_connected(stream);
  throw Error("nobody-there", "check knows no lines of the stream '" + stream + "'");
}

}  // namespace polyarm::cell
