#include "apps/robots.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "apps/options.hpp"
#include "polyarm/catalogue/catalogue_query.hpp"

namespace polyarm::apps {

namespace {

nlohmann::json optional(const std::optional<double>& value) {
  return value ? nlohmann::json(*value) : nlohmann::json();
}

nlohmann::json json_of(const description::CatalogueEntry& robot) {
  return {{"name", robot.name},
          {"maker", robot.maker},
          {"model", robot.model},
          {"axes", robot.axes},
          {"reach_m", optional(robot.reach_m)},
          {"payload_kg", optional(robot.payload_kg)},
          {"mass_kg", optional(robot.mass_kg)},
          {"mass_estimated", robot.mass_estimated}};
}

std::string number(const std::optional<double>& value, const char* unit) {
  return value ? fmt::format("{:.4g} {}", *value, unit) : "-";
}

void print_line(const description::CatalogueEntry& robot) {
  fmt::print("{:<40} {:<26} {} axes  reach {:>9}  payload {:>8}  mass {:>9}{}\n", robot.name, robot.model,
             robot.axes, number(robot.reach_m, "m"), number(robot.payload_kg, "kg"),
             number(robot.mass_kg, "kg"), robot.mass_estimated ? " (estimated)" : "");
}

/// The options of the robot search, as typed.
struct Wanted {
  std::string axes, reach, payload, mass;
  description::CatalogueQuery query;

  void add_to(CommandLine& app) {
    app.add_option("filter", query.text, "only robots whose name or model contains this");
    app.add_option("--maker", query.maker, "only this maker's (fanuc, 'Universal Robots')");
    app.add_option("--axes", axes, "how many axes: 6, 4..6, '>=7'");
    app.add_option("--reach", reach, "reach: '>=1.2', 0.5..0.9, '<500mm'; a bare number: at least that, m");
    app.add_option("--payload", payload, "payload: '>=5', 3..10; a bare number: at least that, kg");
    app.add_option("--mass", mass, "mass of the arm: '<30'; a bare number: at least that, kg");
    app.add_option("--sort", query.sort,
                   "name, maker, axes, reach, payload or mass; with - before it the largest first (-reach)");
  }
  const description::CatalogueQuery& parsed() {
    using description::BareNumber;
    const auto read = [](std::optional<description::Range>& out, const std::string& text, const char* option,
                         Dimension dimension, BareNumber bare) {
      if (!text.empty()) out = description::parse_range(text, option, dimension, bare);
    };
    read(query.axes, axes, "--axes", Dimension::none, BareNumber::exactly);
    read(query.reach_m, reach, "--reach", Dimension::length, BareNumber::at_least);
    read(query.payload_kg, payload, "--payload", Dimension::mass, BareNumber::at_least);
    read(query.mass_kg, mass, "--mass", Dimension::mass, BareNumber::at_least);
    return query;
  }
};

int list_robots(int argc, char** argv) {
  CommandLine app(
      "Finds robots of the catalogue; `add` adds one, `remove` removes one that was added, `picture` draws "
      "one, `page` writes pages of all, `fit` measures a look",
      "polyarm robots");
  bool json = false, names = false;
  Wanted wanted;
  wanted.add_to(app);
  app.add_flag("--json", json,
               "an array of objects: name, maker, model, axes, reach_m, payload_kg, mass_kg, mass_estimated");
  app.add_flag("--names", names, "names only, one on a line");
  app.footer(
      examples({"polyarm robots --maker fanuc --sort -payload",
                "polyarm robots --axes 6 --reach '>=1.2' --payload 5..12", "polyarm robots ur --json"}));
  if (const auto code = app.parse(argc, argv)) return *code;
  const auto found = find_robots(open_catalogue().entries(), wanted.parsed());
  nlohmann::json list = nlohmann::json::array();
  for (const description::CatalogueEntry& robot : found) {
    if (names)
      fmt::print("{}\n", robot.name);
    else if (json)
      list.push_back(json_of(robot));
    else
      print_line(robot);
  }
  if (names) return kOk;
  if (json)
    fmt::print("{}\n", list.dump(1));
  else
    fmt::print("{} robot{}\n", found.size(), found.size() == 1 ? "" : "s");
  return kOk;
}

}  // namespace

int run_robots(int argc, char** argv) {
  const std::string verb = argc > 1 ? argv[1] : "";
  if (verb == "add") return run_robots_add(argc - 1, argv + 1);
  if (verb == "remove") return run_robots_remove(argc - 1, argv + 1);
  if (verb == "picture") return run_robots_picture(argc - 1, argv + 1);
  if (verb == "fit") return run_robots_fit(argc - 1, argv + 1);
  if (verb == "page") return run_robots_page(argc - 1, argv + 1);
  return list_robots(argc, argv);
}

}  // namespace polyarm::apps
