#include "polyarm/cell/compare.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "apps/apart.hpp"
#include "apps/client.hpp"
#include "apps/options.hpp"
#include "apps/scratch.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::apps {

namespace {

namespace fs = std::filesystem;

struct CompareArguments {
  std::string program;
  std::vector<std::string> robots, plugins;
  cell::CompareOptions options;
  unsigned jobs = 0;
  double patience = 600;
  bool json = false;
};

Json located(const Location& where) {
  return where.file.empty() && where.line == 0 ? Json() : Json(where.text());
}

Json as_json(const std::optional<cell::Nearest>& nearest) {
  if (!nearest) return nullptr;
  return {{"value", nearest->value}, {"joint", nearest->joint}, {"where", located(nearest->where)}};
}

Json as_json(const cell::RobotVerdict& v) {
  Json problem;
  if (v.problem)
    problem = {{"code", v.problem->code},
               {"where", located(v.problem->where)},
               {"line", v.problem->where.line},
               {"what", v.problem->what},
               {"advice", v.problem->advice}};
  return {{"robot", v.robot},
          {"runs", v.runs},
          {"problem", problem},
          {"time_s", v.time_s},
          {"cycle_s", v.cycle_s ? Json(*v.cycle_s) : Json()},
          {"cycles", v.cycles},
          {"nearest_limit", as_json(v.limit)},
          {"nearest_singularity", as_json(v.singularity)}};
}

Json crashed(const std::string& robot, const std::string& why) {
  return {{"robot", robot},
          {"runs", false},
          {"problem", {{"code", "crashed"}, {"where", Json()}, {"line", 0}, {"what", why}, {"advice", ""}}}};
}

std::string near_text(const Json& nearest, double scale, const char* unit) {
  if (!nearest.is_object()) return "-";
  std::string out = fmt::format("{:.3g}{}", nearest["value"].get<double>() * scale, unit);
  if (!nearest["joint"].get<std::string>().empty()) out += " " + nearest["joint"].get<std::string>();
  if (nearest["where"].is_string())
    out += " at " + fs::path(nearest["where"].get<std::string>()).filename().string();
  return out;
}

void print_table_of(const std::vector<Json>& verdicts) {
  std::vector<std::vector<std::string>> rows;
  for (const Json& v : verdicts) {
    const bool runs = v["runs"];
    const auto number = [&](const char* key) {
      return v.contains(key) && v[key].is_number() ? fmt::format("{:.2f} s", v[key].get<double>())
                                                   : std::string("-");
    };
    rows.push_back({v["robot"], runs ? "yes" : "no", runs ? number("cycle_s") : "-", number("time_s"),
                    near_text(v.value("nearest_limit", Json()), 1, ""),
                    near_text(v.value("nearest_singularity", Json()), 1, "")});
  }
  print_table({"ROBOT", "RUNS", "CYCLE", "TIME", "NEAREST LIMIT (rad, m)", "NEAREST SINGULARITY"}, rows);
  for (const Json& v : verdicts) {
    if (v["runs"].get<bool>()) continue;
    const Json& p = v["problem"];
    fmt::print("\n{} cannot: {}{}{}\n", v["robot"].get<std::string>(),
               p["where"].is_string() ? p["where"].get<std::string>() + ": " : "",
               p["what"].get<std::string>(),
               p["advice"].get<std::string>().empty() ? "" : " (" + p["advice"].get<std::string>() + ")");
  }
}

/// Finds the cell's folder and, if a script was named, the script in it.
void find_cell(CompareArguments& a) {
  fs::path path = a.program;
  if (path.extension() != ".script") return;
  a.options.overrides.program = fs::absolute(path).string();
  for (fs::path folder = fs::absolute(path).parent_path();; folder = folder.parent_path()) {
    if (fs::exists(folder / "cell.yaml")) {
      a.program = folder.string();
      return;
    }
    if (folder == folder.parent_path()) break;
  }
  throw Error("no-cell", "no folder from that of " + a.program + " upwards has a cell.yaml",
              "a program is compared in a cell: with its signals, its scene and its data");
}

int compare(CompareArguments& a) {
  find_cell(a);
  const description::Catalogue catalogue = open_catalogue();
  const Scratch scratch("compare");
  std::vector<Json> verdicts(a.robots.size());
  run_apart(
      a.robots.size(), a.jobs > 0 ? a.jobs : processors(), a.patience,
      [&](std::size_t i) {
        cell::CompareOptions options = a.options;
        options.overrides.robot = a.robots[i];
        options.state_folder = scratch.of(i);
        return as_json(cell::try_robot(a.program, catalogue, options))
            .dump(-1, ' ', false, Json::error_handler_t::replace);
      },
      [&](std::size_t i, const ApartResult& result) {
        const Json said = result.said ? Json::parse(*result.said, nullptr, false) : Json();
        verdicts[i] = said.is_object() ? said : crashed(a.robots[i], result.why);
      });
  if (a.json)
    fmt::print("{}\n", Json(verdicts).dump(1));
  else
    print_table_of(verdicts);
  const bool all =
      std::all_of(verdicts.begin(), verdicts.end(), [](const Json& v) { return v["runs"].get<bool>(); });
  return all ? kOk : kFailed;
}

}  // namespace

int run_compare(int argc, char** argv) {
  CommandLine app(
      "Runs one program on several robots in simulation: which can run it, how fast, how near to limits",
      "polyarm compare");
  CompareArguments a;
  app.add_option("program", a.program, "a cell (folder or cell.yaml), or a script of a cell")->required();
  app.add_option("--robots", a.robots, "models of the catalogue, or NAME=MODEL in a cell of several robots")
      ->delimiter(',')
      ->required();
  app.add_option("--program", a.options.overrides.program, "another program of the cell");
  app.add_option("--hardware", a.options.overrides.hardware, "declared, mock or mujoco")
      ->check(wrong_hardware, "NAME");
  app.add_option("--cycles", a.options.cycles, "passes of the outermost while (3)");
  app.add_option("--seconds", a.options.seconds, "of cell time at most (3600)");
  app.add_option("-j,--jobs", a.jobs, "how many run at the same time (default: the number of processors)");
  app.add_flag("--json", a.json, "a list of objects: robot, runs, problem, cycle_s, nearest_limit …");
  add_plugin_option(app, a.plugins);
  app.footer(examples({"polyarm compare examples/pick_and_place --robots "
                       "universal_robots/ur3,abb/irb_120,fanuc/lr_mate_200id",
                       "polyarm compare my_cell/fast.script --robots kuka/kr_6_r900,staubli/tx2_60 --json"}) +
             "\nExit codes: 0 all can run it, 1 some cannot, 2 wrong command line\n");
  if (const auto code = app.parse(argc, argv)) return *code;
  load_plugins(a.plugins);
  return compare(a);
}

}  // namespace polyarm::apps
