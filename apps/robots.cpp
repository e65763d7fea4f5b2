#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "apps/options.hpp"

namespace polyarm::apps {

namespace {
nlohmann::json json_of(const description::CatalogueEntry& robot) {
  nlohmann::json out = {
      {"name", robot.name}, {"maker", robot.maker}, {"model", robot.model}, {"axes", robot.axes}};
  out["reach_m"] = robot.reach_m ? nlohmann::json(*robot.reach_m) : nlohmann::json();
  out["payload_kg"] = robot.payload_kg ? nlohmann::json(*robot.payload_kg) : nlohmann::json();
  return out;
}

std::string number(const std::optional<double>& value, const char* unit) {
  return value ? fmt::format("{:g} {}", *value, unit) : "-";
}
}  // namespace

int run_robots(int argc, char** argv) {
  CLI::App app("Lists the robots of the catalogue", "polyarm robots");
  bool json = false, names = false;
  std::string filter;
  app.add_option("filter", filter, "only robots whose name contains this");
  app.add_flag("--json", json, "an array of objects: name, maker, model, axes, reach_m, payload_kg");
  app.add_flag("--names", names, "names only, one on a line");
  app.footer(examples({"polyarm robots", "polyarm robots fanuc", "polyarm robots --json"}));
  if (const auto code = parse(app, argc, argv)) return *code;
  const description::Catalogue catalogue = open_catalogue();
  if (names) {
    for (const std::string& name : catalogue.names()) fmt::print("{}\n", name);
    return kOk;
  }
  nlohmann::json list = nlohmann::json::array();
  int count = 0;
  for (const description::CatalogueEntry& robot : catalogue.entries()) {
    if (robot.name.find(filter) == std::string::npos) continue;
    ++count;
    if (json)
      list.push_back(json_of(robot));
    else
      fmt::print("{:<40} {:<24} {} axes  reach {:>9}  payload {:>8}\n", robot.name, robot.model, robot.axes,
                 number(robot.reach_m, "m"), number(robot.payload_kg, "kg"));
  }
  if (json)
    fmt::print("{}\n", list.dump(1));
  else
    fmt::print("{} robots\n", count);
  return kOk;
}

}  // namespace polyarm::apps
