/// Verbs that show the hardware, the interfaces, the health and the limits of a running cell.
#include <fmt/format.h>

#include "apps/client.hpp"

namespace polyarm::apps {

namespace {

/// Runs a verb that sends one request and prints the answer.
int ask(CommandLine& app, int argc, char** argv, const char* request,
        const std::function<void(const Json&)>& print) {
  ClientOptions options;
  options.add_to(app);
  if (const auto code = app.parse(argc, argv)) return *code;
  const Json result = Client(options.cell).ask({{"request", request}});
  if (options.json)
    fmt::print("{}\n", result.dump(1));
  else
    print(result);
  return kOk;
}

void print_components(const Json& components) {
  std::vector<std::vector<std::string>> rows;
  for (const Json& c : components)
    rows.push_back({shown(c["name"]), shown(c["type"]), shown(c["plugin"]),
                    shown(c["state"]) + (c.value("being", "").empty() ? "" : ", being " + shown(c["being"])),
                    fmt::format("{:g} Hz{}", number_of(c["rate"]), flag_of(c["async"]) ? " async" : ""),
                    std::to_string(c["states"].size()), std::to_string(c["commands"].size())});
  print_table({"COMPONENT", "TYPE", "PLUGIN", "STATE", "RATE", "STATES", "COMMANDS"}, rows);
}

std::string microseconds(const Json& nanoseconds) {
  return fmt::format("{:.1f} us", number_of(nanoseconds) / 1000);
}

/// p50, p99 and max.
std::string times(const Json& histogram) {
  return microseconds(histogram["p50_ns"]) + ", " + microseconds(histogram["p99_ns"]) + ", " +
         microseconds(histogram["max_ns"]);
}

/// Name of a component or a controller.
std::string name_of(const Json& entry) {
  return shown(entry.contains("component") ? entry["component"] : entry["controller"]);
}

void print_parts(const Json& parts) {
  if (parts.empty()) return;
  std::vector<std::vector<std::string>> rows;
  for (const Json& p : parts)
    rows.push_back({name_of(p), p.contains("component") ? "component" : "controller",
                    fmt::format("{:g} Hz", number_of(p["rate_hz"])), shown(p["turns"]), times(p["cost"]),
                    times(p["period"])});
  fmt::print("\n");
  print_table({"IN THE LOOP", "", "RATE", "TURNS", "COST p50, p99, max", "PERIOD"}, rows);
}

void print_threads(const Json& threads) {
  if (threads.empty()) return;
  std::vector<std::vector<std::string>> rows;
  for (const Json& t : threads)
    rows.push_back(
        {name_of(t),
         fmt::format("{:g} Hz{}", number_of(t["rate_hz"]), flag_of(t["own_clock"]) ? "" : ", by the loop"),
         shown(t["runs"]), shown(t["late"]), shown(t["missed"]), times(t["cost"]), times(t["wake_up"]),
         times(t["period"])});
  fmt::print("\n");
  print_table({"THREAD OF", "RATE", "RUNS", "LATE", "MISSED", "COST p50, p99, max", "WAKE-UP", "PERIOD"},
              rows);
}

void print_health(const Json& h) {
  fmt::print("state     {}{}\n", shown(h["state"]), h["state"] == "running" ? "" : ": " + shown(h["cause"]));
  fmt::print("override  {:g} %", number_of(h["override_percent"]));
  if (h["allowed_percent"] != 100.0)
    fmt::print(" of the {:g} % that are allowed now", number_of(h["allowed_percent"]));
  fmt::print("\n");
  if (const Json& stop = h["last_stop"]; !stop.is_null())
    fmt::print("last stop {:.3f} s at {:.3f} s, category {}: {}\n", number_of(stop["time_s"]),
               number_of(stop["at_s"]), shown(stop["category"]), shown(stop["cause"]));
  fmt::print("loop      {:g} Hz, {} cycles, {} late, {:.3f} s\n", number_of(h["rate_hz"]), shown(h["cycles"]),
             shown(h["late"]), number_of(h["time_s"]));
  for (const auto& [key, name] :
       {std::pair{"cost", "cost    "}, {"wake_up", "wake-up "}, {"period", "period  "}})
    fmt::print("{}  p50 {}, p99 {}, max {}\n", name, microseconds(h[key]["p50_ns"]),
               microseconds(h[key]["p99_ns"]), microseconds(h[key]["max_ns"]));
  fmt::print("clamps    {}\n", shown(h["clamps"]));
  for (const Json& f : h["fallen"])
    fmt::print("fallen    {}: {}\n", shown(f["component"]), shown(f["cause"]));
  print_parts(h["parts"]);
  print_threads(h["threads"]);
}

void print_limits(const Json& limits) {
  if (limits.empty()) {
    fmt::print("no limit has changed a command\n");
    return;
  }
  std::vector<std::vector<std::string>> rows;
  for (const Json& l : limits)
    rows.push_back({shown(l["interface"]), shown(l["limit"]), shown(l["count"]), shown(l["asked"]),
                    shown(l["given"]), fmt::format("{:.3f} s", number_of(l["time_s"]))});
  print_table({"INTERFACE", "LIMIT", "COUNT", "ASKED", "GIVEN", "LAST AT"}, rows);
}

}  // namespace

int run_hardware(int argc, char** argv) {
  CommandLine app("Hardware components of a running cell", "polyarm hardware");
  ClientOptions options;
  std::string name, state;
  CommandLine* list = app.add_subcommand("list", "the components, their states and rates");
  CommandLine* change =
      app.add_subcommand("state", "bring a component to a state; controllers that use it are stopped");
  CommandLine* recover = app.add_subcommand("recover", "recover a failed component");
  CommandLine* reload = app.add_subcommand("reload", "create a component anew from its present description");
  for (CommandLine* sub : {list, change, recover, reload}) options.add_to(*sub);
  change->add_option("name", name)->required();
  change->add_option("state", state, "unconfigured, inactive, active or finalized")->required();
  recover->add_option("name", name)->required();
  reload->add_option("name", name)->required();
  app.footer(examples({"polyarm hardware list", "polyarm hardware state R6Bot inactive",
                       "polyarm hardware recover R6Bot", "polyarm hardware reload R6Bot"}));
  return run_actions(app, argc, argv, [&] {
    const std::string action = app.subcommand();
    Json request{{"request", "hardware." + action}};
    if (!name.empty()) request["name"] = name;
    if (!state.empty()) request["state"] = state;
    const Json result = Client(options.cell).ask(request);
    if (options.json) {
      fmt::print("{}\n", result.dump(1));
    } else if (action == "list") {
      print_components(result);
    } else {
      fmt::print("{} is {}\n", name, shown(result["state"]));
      if (const Json& with = part(result, {"with"}); !with.empty())
        fmt::print("with it {}: physics is one component\n", shown(with));
      if (!result.value("stopped", Json::array()).empty())
        fmt::print("stopped {}\n", shown(result["stopped"]));
      for (const Json& warning : result.value("warnings", Json::array())) fmt::print("{}\n", shown(warning));
      if (result.contains("next")) fmt::print("next: {}\n", shown(result["next"]));
    }
    return kOk;
  });
}

int run_interfaces(int argc, char** argv) {
  CommandLine app("Every state and command interface of a running cell", "polyarm interfaces");
  app.footer(examples({"polyarm interfaces", "polyarm interfaces --cell r6bot --json"}));
  return ask(app, argc, argv, "interfaces", [](const Json& result) {
    std::vector<std::vector<std::string>> rows;
    for (const Json& i : result["commands"])
      rows.push_back({"command", shown(i["name"]), shown(i["value"]),
                      text_of(i["claimed_by"]).empty() ? "-" : shown(i["claimed_by"])});
    for (const Json& i : result["states"]) rows.push_back({"state", shown(i["name"]), shown(i["value"]), ""});
    print_table({"KIND", "INTERFACE", "VALUE", "CLAIMED BY"}, rows);
  });
}

int run_health(int argc, char** argv) {
  CommandLine app("Shows the state and timing of the control loop of a running cell", "polyarm health");
  app.footer(examples({"polyarm health", "polyarm health --json"}));
  return ask(app, argc, argv, "health", print_health);
}

int run_limits(int argc, char** argv) {
  CommandLine app("Shows which limits changed commands in a running cell", "polyarm limits");
  app.footer(examples({"polyarm limits", "polyarm limits --json"}));
  return ask(app, argc, argv, "limits", print_limits);
}

}  // namespace polyarm::apps
