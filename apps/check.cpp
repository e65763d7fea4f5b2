#include "polyarm/cell/check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>

#include "apps/asked_cell.hpp"
#include "apps/options.hpp"
#include "polyarm/base/bounds.hpp"

namespace polyarm::apps {

namespace {

using nlohmann::json;

/// Number of problems to print; of the rest only the count is printed.
constexpr std::size_t kMostReported = bounds::kProblemsTold;

std::span<const Problem> first_of(const std::vector<Problem>& problems) {
  return std::span(problems).first(std::min(problems.size(), kMostReported));
}

json json_of(const Problem& p) {
  return {{"code", p.code},
          {"file", p.where.file},
          {"line", p.where.line},
          {"column", p.where.column},
          {"text", p.what},
          {"advice", p.advice},
          {"severity", p.severity == Severity::error ? "error" : "warning"}};
}

void print_json(const cell::CheckResult& result) {
  json problems = json::array(), points = json::array();
  for (const Problem& problem : first_of(result.problems)) problems.push_back(json_of(problem));
  for (const cell::PointReport& point : result.points)
    points.push_back({{"name", point.name},
                      {"file", point.where.file},
                      {"line", point.where.line},
                      {"reachable", point.reachable},
                      {"reason", point.reason},
                      {"joints", point.joints}});
  const json out = {{"result", result.has_errors() ? "failed" : "ok"},
                    {"problems", problems},
                    {"problems_left_out", result.problems.size() - problems.size()},
                    {"notes", result.notes},
                    {"points", points},
                    {"moves", result.moves},
                    {"reached", result.reached.file.empty() ? "" : result.reached.text()}};
  fmt::print("{}\n", out.dump(1, ' ', false, json::error_handler_t::replace));
}

void print_text(const cell::CheckResult& result) {
  int errors = 0, warnings = 0;
  for (const Problem& problem : first_of(result.problems)) fmt::print("{}\n", problem.text());
  for (const Problem& problem : result.problems) ++(problem.severity == Severity::error ? errors : warnings);
  if (result.problems.size() > kMostReported)
    fmt::print("and {} more problems\n", result.problems.size() - kMostReported);
  for (const std::string& note : result.notes) fmt::print("note: {}\n", note);
  int reached = 0;
  for (const cell::PointReport& point : result.points) reached += point.reachable ? 1 : 0;
  if (!result.points.empty()) fmt::print("{} of {} points can be reached\n", reached, result.points.size());
  if (result.moves > 0 || !result.reached.file.empty())
    fmt::print("{} move{} planned{}\n", result.moves, result.moves == 1 ? "" : "s",
               result.reached.file.empty() ? "" : ", as far as " + result.reached.text());
  fmt::print("{} error{}, {} warning{}\n", errors, errors == 1 ? "" : "s", warnings,
             warnings == 1 ? "" : "s");
}

}  // namespace

int run_check(int argc, char** argv) {
  CommandLine app(
      "Finds every error of a cell's files, or of a description and its controllers files; nothing moves",
      "polyarm check");
  CellOption asked;
  cell::CheckOptions options;
  std::vector<std::string> plugins;
  bool as_json = false;
  asked.add_to(app);
  app.add_option("--robot", asked.overrides.robot, "check for another robot");
  app.add_option("--program", asked.overrides.program,
                 "another program: a script, beside the cell or anywhere");
  app.add_option("--hardware", asked.overrides.hardware, "hardware of the dry run: mock or mujoco");
  add_plugin_option(app, plugins);
  app.add_flag("--dry", options.dry,
               "run the program in lock-step simulation; list contacts, limits and parts by line");
  app.add_option("--cycles", options.cycles, "passes of the dry run");
  app.add_flag("--json", as_json, "one JSON object: result, problems, notes, points, moves, reached");
  app.footer(
      examples({"polyarm check examples/pick_and_place",
                "polyarm check examples/sorting --robot abb/irb_120 --dry", "polyarm check my_cell --json",
                "polyarm check --description my_robot.urdf --controllers controllers.yaml"}) +
      "\nExit codes: 0 no errors, 1 errors, 2 wrong command line\n");
  if (const auto code = app.parse(argc, argv)) return *code;
  if (const auto code = asked.settle("check")) return *code;
  load_plugins(plugins);
  const cell::CheckResult result = cell::check([&] { return asked.open(); }, open_catalogue(), options);
  if (as_json)
    print_json(result);
  else
    print_text(result);
  return result.has_errors() ? kFailed : kOk;
}

}  // namespace polyarm::apps
