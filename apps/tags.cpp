/// The verb that shows the tags and links of a running cell, and sets and forces tags.
#include <fmt/format.h>

#include "apps/client.hpp"

namespace polyarm::apps {

namespace {

std::string value_of(const Json& tag) {
  std::string out = shown(tag["text"]);
  if (const std::string unit = tag.value("unit", ""); !unit.empty()) out += " " + unit;
  if (tag.value("forced", false)) out += " (forced)";
  return out;
}

std::string change_of(const Json& tag) {
  if (tag["changed_s"].is_null()) return "-";
  return fmt::format("{:.3f} s by {}", tag["changed_s"].get<double>(), shown(tag["changed_by"]));
}

void print_tags(const Json& result) {
  std::vector<std::vector<std::string>> rows;
  for (const Json& tag : result["tags"])
    rows.push_back({shown(tag["name"]), shown(tag["type"]), value_of(tag), shown(tag["direction"]),
                    shown(tag["source"]), shown(tag["quality"]), change_of(tag)});
  print_table({"TAG", "TYPE", "VALUE", "DIRECTION", "SOURCE", "QUALITY", "LAST CHANGE"}, rows);
  if (result["links"].empty()) return;
  fmt::print("\n");
  rows.clear();
  for (const Json& link : result["links"])
    rows.push_back({shown(link["name"]), shown(link["address"]),
                    link["up"].get<bool>() ? "up" : "lost: " + shown(link["reason"]), shown(link["losses"]),
                    fmt::format("{:.1f} ms", link["round_ms"].get<double>()), shown(link["on_loss"])});
  print_table({"LINK", "AT", "STATE", "LOSSES", "ROUND", "ON LOSS"}, rows);
}

/// Keeps the value forced until Ctrl-C, or until the cell ends.
int force(const ClientOptions& options, const Json& request) {
  catch_interrupts();
  Client client(options.cell);
  client.send(request);
  for (bool told = false; !interrupted();) {
    const Json answer = client.receive(200);
    if (answer.is_null()) continue;
    const Json tag = Client::result_of(answer);
    if (options.json)
      fmt::print("{}\n", tag.dump());
    else if (!told)
      fmt::print("{} is forced to {} for as long as this runs; Ctrl-C ends it\n", shown(tag["name"]),
                 shown(tag["text"]));
    told = true;
    std::fflush(stdout);
  }
  return kOk;
}

/// A number or boolean if the text is one; otherwise the text.
Json json_of(const std::string& text) {
  if (text == "true" || text == "True" || text == "on") return true;
  if (text == "false" || text == "False" || text == "off") return false;
  const Json number = Json::parse(text, nullptr, false);
  return number.is_number() ? number : Json(text);
}

}  // namespace

int run_tags(int argc, char** argv) {
  CommandLine app("Tags and links of a running cell", "polyarm tags");
  ClientOptions options;
  std::vector<std::string> names;
  std::string name, value;
  CommandLine* list =
      app.add_subcommand("list", "list all tags, or those named (variables of data, too), and the links");
  CommandLine* set = app.add_subcommand("set", "change a tag once");
  CommandLine* forced = app.add_subcommand("force", "force a tag to a value as long as this command runs");
  for (CommandLine* sub : {list, set, forced}) options.add_to(*sub);
  list->add_option("names", names);
  for (CommandLine* sub : {set, forced}) {
    sub->add_option("name", name)->required();
    sub->add_option("value", value, "true, false, a number (with its unit), or a text")->required();
  }
  app.footer(examples({"polyarm tags list", "polyarm tags list PartHeld Vacuum",
                       "polyarm tags set Vacuum true", "polyarm tags force PartHeld true"}));
  return run_actions(app, argc, argv, [&]() -> int {
    const std::string action = app.subcommand();
    Json request{{"request", "tags." + action}};
    if (action == "list") {
      if (!names.empty()) request["names"] = names;
    } else {
      request["name"] = name;
      request["value"] = json_of(value);
      request["by"] = "terminal";
    }
    if (action == "force") return force(options, request);
    const Json result = Client(options.cell).ask(request);
    if (options.json)
      fmt::print("{}\n", result.dump(1));
    else if (action == "list")
      print_tags(result);
    else
      fmt::print("{} is {}\n", shown(result["name"]), value_of(result));
    return kOk;
  });
}

}  // namespace polyarm::apps
