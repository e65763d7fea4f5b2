#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <iostream>
#include <optional>

#include "apps/client.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::apps {

namespace {

struct Arguments {
  ClientOptions client;
  std::vector<std::string> activate, deactivate, parameters;
  std::string strictness, name, type, file, state;
  std::string percent;
  std::vector<std::string> places;
  std::string how;
  double category = 0, seconds = 0, distance = 0;
  int line = 1;
  bool dry = false, anyway = false, clear = false, follow = false, yes = false;
};

void list(const Json& controllers) {
  std::vector<std::vector<std::string>> rows;
  for (const Json& c : controllers)
    rows.push_back({shown(c["name"]), shown(c["type"]),
                    shown(c["state"]) + (flag_of(c["chained"]) ? " (chained)" : "") +
                        (flag_of(part(c, {"stale"})) ? " (last message expired)" : ""),
                    fmt::format("{:g} Hz", number_of(c["rate"])), shown(c["claimed"])});
  print_table({"CONTROLLER", "TYPE", "STATE", "RATE", "CLAIMS"}, rows);
}

void tell_switch(const Json& result, bool dry) {
  if (!result.value("ok", true)) {
    fmt::print("refused: {}{}\n", shown(result["reason"]),
               text_of(result["advice"]).empty() ? "" : " (" + shown(result["advice"]) + ")");
    return;
  }
  fmt::print("{} {}; {} {}\n", dry ? "would stop" : "stopped", shown(result["stop"]),
             dry ? "would start" : "started", shown(result["start"]));
  for (const Json& left : result["left_out"]) fmt::print("left out: {}\n", shown(left));
}

Json parameters_of(const std::vector<std::string>& words) {
  Json out = Json::object();
  for (const std::string& word : words) {
    const auto equals = word.find('=');
    if (equals == std::string::npos) throw Error("bad-value", "'" + word + "' is not KEY=VALUE");
    const std::string value = word.substr(equals + 1);
    const Json list = value.starts_with('[') ? Json::parse(value, nullptr, false) : Json();
    if (list.is_array()) {
      out[word.substr(0, equals)] = list;
    } else if (value.starts_with('[') && value.ends_with(']')) {  // a list without quotes: [a, b]
      Json items = Json::array();
      for (const std::string& item : split_fields(value.substr(1, value.size() - 2), ','))
        items.push_back(item);
      out[word.substr(0, equals)] = items;
    } else {
      out[word.substr(0, equals)] = value;
    }
  }
  return out;
}

/// Accepts "50%" and "50".
double percent_of(const std::string& text) {
  const std::optional<double> percent =
      parse_number(text.ends_with('%') ? text.substr(0, text.size() - 1) : text);
  if (!percent) throw Error("bad-value", "'" + text + "' is not a share of the speed", "for example 50%");
  return *percent;
}

/// Prints the result of a request that moves or stops.
void tell_motion(const std::string& action, const Json& result) {
  if (action == "override") {
    fmt::print("override {:g} %\n", number_of(result["percent"]));
  } else if (action == "back") {
    fmt::print("stepped back, {} again\n", shown(result["state"]));
    for (const auto& [joint, way] : result["joints"].items())
      fmt::print("  {} {:+.4f}\n", joint, number_of(way));
    fmt::print("Resume repeats the motion that led here; discard forgets it first.\n");
  } else {
    fmt::print("asked to {}\n", shown(result["asked"]));
    if (result.contains("inactive")) fmt::print("switched off {}\n", shown(result["inactive"]));
  }
}

int act(const CommandLine& app, const Arguments& a) {
  const std::string action = app.subcommand();
  Client client(a.client.cell);
  Json request{{"request", "control." + action}};
  if (action == "switch")
    request.update({{"activate", a.activate}, {"deactivate", a.deactivate}, {"dry", a.dry}});
  if (!a.strictness.empty()) request["strictness"] = a.strictness;
  if (!a.percent.empty()) request["percent"] = percent_of(a.percent);
  if (a.category != 0) request["category"] = a.category;
  if (a.seconds != 0) request["time"] = a.seconds;
  if (a.distance != 0) request["distance"] = a.distance;
  if (a.anyway) request["anyway"] = true;
  if (!a.name.empty()) request["name"] = a.name;
  if (!a.state.empty()) request["state"] = a.state;
  if (action == "load" && !a.type.empty()) request["type"] = a.type;
  if (action == "load" && !a.file.empty()) request["file"] = std::filesystem::absolute(a.file).string();
  if (action == "load" && !a.parameters.empty()) request["parameters"] = parameters_of(a.parameters);
  const Json result = client.ask(request);
  if (a.client.json) {
    fmt::print("{}\n", result.dump(1));
  } else if (action == "list") {
    list(result);
  } else if (action == "types") {
    for (const Json& type : result) fmt::print("{:<64} {}\n", shown(type["type"]), shown(type["text"]));
  } else if (action == "chains") {
    for (const Json& link : result)
      fmt::print("{} → {} through {}{}\n", shown(link["from"]), shown(link["to"]), shown(link["reference"]),
                 flag_of(link["active"]) ? "" : " (inactive)");
    if (result.empty()) fmt::print("no controller works through another\n");
  } else if (action == "switch") {
    tell_switch(result, a.dry);
  } else if (!a.name.empty()) {
    fmt::print("{} is {}\n", a.name, action == "unload" ? "gone" : shown(result["state"]));
    for (const Json& warning : result.value("warnings", Json::array())) fmt::print("{}\n", shown(warning));
  } else {
    tell_motion(action, result);
  }
  return a.dry && !result.value("ok", true) ? kFailed : kOk;
}

std::string place_of(const Json& where) {
  return fmt::format("{}:{}", std::filesystem::path(text_of(where["file"])).filename().string(),
                     static_cast<int>(number_of(where["line"])));
}

std::string named_values(const Json& values) {
  std::string out;
  for (const Json& value : values)
    out += (out.empty() ? "" : ", ") + text_of(value["name"]) + " = " + text_of(value["value"]);
  return out;
}

/// Prints where the program is, task by task.
void report_program(const Json& p) {
  if (p["state"] == "none") {
    fmt::print("the cell has no program\n");
    return;
  }
  fmt::print("{} {} at {}: {}\n", flag_of(p["paused"]) ? "paused" : "the program is",
             flag_of(p["paused"]) ? "" : text_of(p["state"]), place_of(p["where"]), shown(p["source"]));
  for (const Json& task : p["tasks"]) {
    const std::string waits = text_of(task["waits_for"]);
    fmt::print("  {:<10}{}{} {}: {}\n", text_of(task["name"]), text_of(task["state"]),
               waits.empty() ? "" : " for " + waits, place_of(task["where"]), shown(task["source"]));
    for (const Json& call : task["calls"])
      if (call != task["calls"].back()) fmt::print("            called from {}\n", place_of(call));
    if (const std::string variables = named_values(task["variables"]); !variables.empty())
      fmt::print("            {}\n", variables);
    std::string use;
    for (const char* key : {"robot", "tool", "frame"})
      if (!text_of(task[key]).empty()) use += fmt::format("{} {} ", key, text_of(task[key]));
    if (!use.empty()) fmt::print("            moves use {}\n", use);
    if (task.contains("problem")) fmt::print("            {}\n", text_of(task["problem"]));
  }
  if (!p["held"].empty()) fmt::print("  held: {}\n", shown(p["held"]));
  for (const Json& place : p["breakpoints"]) fmt::print("  breakpoint {}\n", place_of(place));
}

/// The request for a verb about the program.
Json program_request(const std::string& action, const Arguments& a) {
  Json out{{"request", action == "program" ? a.follow ? "program.watch" : "program" : "program." + action}};
  if (action == "step" && !a.how.empty()) out["how"] = a.how;
  if (action == "break" && !a.places.empty()) out["at"] = a.places;
  if (action == "break" && a.clear) out["clear"] = true;
  if (action == "from") out["line"] = a.line;
  if (action == "end") out["request"] = "program.stop";
  return out;
}

bool is_about_program(const std::string& action) {
  for (const char* each : {"program", "pause", "go", "step", "break", "from", "end"})
    if (action == each) return true;
  return false;
}

/// Starts a program at a line, after the user has seen what it assumes.
int begin_from(Client& client, const Arguments& a) {
  const Json seen = client.ask(program_request("from", a));
  if (a.client.json)
    fmt::print("{}\n", seen.dump(1));
  else {
    fmt::print("the program begins at {}: {}\n", place_of(seen["where"]), shown(seen["source"]));
    for (const char* key : {"robot", "tool", "frame", "last_point"})
      if (!text_of(seen[key]).empty()) fmt::print("  {:<22}{}\n", key, text_of(seen[key]));
    for (const char* key : {"sets", "reads", "variables"})
      if (const std::string values = named_values(seen[key]); !values.empty())
        fmt::print("  {:<22}{}\n", key, values);
    fmt::print("  {:<22}{}\n", "held part", seen["held"].empty() ? "none known" : shown(seen["held"]));
  }
  if (!a.yes) {
    if (::isatty(STDIN_FILENO) == 0) {
      fmt::print("it waits: polyarm control go\n");
      return kOk;
    }
    fmt::print("Is all of this true? Type yes to continue: ");
    std::fflush(stdout);
    std::string answer;
    std::getline(std::cin, answer);
    if (answer != "yes") {
      fmt::print("it waits there: polyarm control go, or end\n");
      return kFailed;
    }
  }
  client.ask({{"request", "program.go"}});
  return kOk;
}

int act_on_program(const std::string& action, const Arguments& a) {
  Client client(a.client.cell);
  if (action == "from") return begin_from(client, a);
  const Json request = program_request(action, a);
  if (action == "program" && a.follow) {
    catch_interrupts();
    client.send(request);
    while (!interrupted()) {
      const Json line = client.receive(200);
      if (line.is_null()) continue;
      const Json result = Client::result_of(line);
      if (a.client.json)
        fmt::print("{}\n", result.dump());
      else
        report_program(result);
      std::fflush(stdout);
    }
    return kOk;
  }
  const Json result = client.ask(request);
  if (a.client.json) {
    fmt::print("{}\n", result.dump(1));
  } else if (action == "break") {
    for (const Json& place : result["breakpoints"]) fmt::print("breakpoint {}\n", place_of(place));
    if (result["breakpoints"].empty()) fmt::print("no breakpoints\n");
  } else {
    report_program(result);
  }
  return kOk;
}

/// Shows measured beside expected positions, and asks a user at the terminal.
int arm(const Arguments& a) {
  Client client(a.client.cell);
  const Json seen = client.ask({{"request", "control.arm"}});
  if (flag_of(part(seen, {"armed"}))) {
    fmt::print("armed already\n");
    return kOk;
  }
  std::vector<std::vector<std::string>> rows;
  for (const Json& joint : seen["joints"])
    rows.push_back({shown(joint["joint"]), shown(joint["measured"]), shown(joint["expected"])});
  print_table({"JOINT", "MEASURED", "EXPECTED"}, rows);
  if (::isatty(STDIN_FILENO) == 0)
    throw Error("nobody-there", "only a person at a terminal arms real hardware", "run this in a terminal");
  fmt::print("Is nobody within reach of the robot, and is this its position? Type yes to arm it: ");
  std::fflush(stdout);
  std::string answer;
  std::getline(std::cin, answer);
  if (answer != "yes") {
    fmt::print("not armed\n");
    return kFailed;
  }
  const Json done = client.ask({{"request", "control.arm"}, {"confirmed", true}});
  fmt::print("armed; started {}\n", shown(done["started"]));
  return kOk;
}

}  // namespace

int run_control(int argc, char** argv) {
  CommandLine app("Lists and switches the controllers of a running cell", "polyarm control");
  Arguments a;
  const auto add = [&](const char* name, const char* text) {
    CommandLine* sub = app.add_subcommand(name, text);
    a.client.add_to(*sub);
    return sub;
  };
  add("list", "list the controllers, their states and claimed interfaces");
  add("types", "list the controller types");
  add("chains", "which controllers work through which");
  CommandLine* change = add("switch", "stop and start controllers in one step, between two cycles");
  change->add_option("-a,--activate", a.activate, "start these");
  change->add_option("-d,--deactivate", a.deactivate, "stop these");
  change->add_option("--strictness", a.strictness, "strict, best_effort, auto (with their chains), force");
  change->add_flag("--dry", a.dry, "only print what would happen, or why the switch is refused");
  CommandLine* load = add("load", "create and configure a controller");
  load->add_option("name", a.name, "as in the controllers file, or a new name with --type")->required();
  load->add_option("--type", a.type, "type of a controller that no file describes");
  load->add_option("--file", a.file, "a controllers file that describes it, instead of the cell's own");
  load->add_option("-p,--param", a.parameters, "KEY=VALUE; lists as [a, b]");
  add("configure", "unconfigured to inactive")->add_option("name", a.name)->required();
  add("cleanup", "inactive to unconfigured")->add_option("name", a.name)->required();
  add("unload", "remove a controller that is not active")->add_option("name", a.name)->required();
  CommandLine* state = add("state", "bring a controller to a state");
  state->add_option("name", a.name)->required();
  state->add_option("state", a.state, "unconfigured, inactive or active")->required();
  add("arm", "let real hardware move: shows measured and expected positions, and asks you");
  add("hold", "stop on the path; resume continues");
  add("stop", "stop at once, on the path")
      ->add_option("--category", a.category, "1: then switch the drives off; 2 (otherwise): hold");
  add("resume", "continue after a hold")
      ->add_flag("--anyway", a.anyway, "even if the robot was moved during the hold");
  CommandLine* back = add("back", "during a hold: go back slowly along the planned path, then hold again");
  back->add_option("--time", a.seconds, "seconds of the plan (1)");
  back->add_option("--distance", a.distance,
                   "distance along the path: metres for paths of the TCP, radians for joint moves");
  add("override", "set the share of the planned speed")
      ->add_option("percent", a.percent, "0% to 100%; without it: print the present value");
  add("discard", "discard the rest of a held motion");
  add("recover", "leave the fault state; nothing moves yet");
  add("program", "show the state of the program: tasks, calls, variables, settings of moves")
      ->add_flag("--follow", a.follow, "print it again whenever it changes");
  add("pause", "pause the program before its next statement; queued motion continues");
  add("go", "continue after a pause");
  add("step", "run one statement of a paused program")
      ->add_option("how", a.how, "into functions, over them (otherwise), or out of this one")
      ->one_of({"into", "over", "out"});
  CommandLine* stop_at = add("break", "set breakpoints; without lines: list them");
  stop_at->add_option("at", a.places, "LINE or FILE:LINE");
  stop_at->add_flag("--clear", a.clear, "remove earlier breakpoints");
  CommandLine* from =
      add("from", "start a paused or ended program at a line; shows what it assumes, and asks");
  from->add_option("line", a.line)->positive()->required();
  from->add_flag("--yes", a.yes, "do not ask");
  add("end", "end the program; its `on stop` block runs");
  app.footer(
      examples({"polyarm control list", "polyarm control switch --deactivate old --activate new",
                "polyarm control switch -a new --strictness force --dry",
                "polyarm control load forward --type forward_command_controller/ForwardCommandController "
                "-p joints=[joint_1] -p interface_name=position",
                "polyarm control state forward active", "polyarm control override 50%",
                "polyarm control back --time 0.5", "polyarm control program --follow",
                "polyarm control break 12 && polyarm control step into"}));
  return run_actions(app, argc, argv, [&] {
    const std::string action = app.subcommand();
    if (is_about_program(action)) return act_on_program(action, a);
    return action == "arm" ? arm(a) : act(app, a);
  });
}

}  // namespace polyarm::apps
