/// The verb for parameters of the controllers of a running cell.
#include <fmt/format.h>

#include <algorithm>

#include "apps/client.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/yaml/yaml.hpp"
#include "polyarm/yaml/yaml_repeats.hpp"

namespace polyarm::apps {

namespace {

struct Arguments {
  ClientOptions client;
  std::string name, key, file;
  std::vector<std::string> values;
};

/// Parses KEY=VALUE …, or KEY VALUE.
Json values_of(std::vector<std::string> words) {
  if (words.size() == 2 && words[0].find('=') == std::string::npos) words = {words[0] + "=" + words[1]};
  Json out = Json::object();
  for (const std::string& word : words) {
    const auto equals = word.find('=');
    if (equals == std::string::npos) throw Error("bad-value", "'" + word + "' is not KEY=VALUE");
    out[word.substr(0, equals)] = word.substr(equals + 1);
  }
  return out;
}

void flatten(const Yaml& at, const std::string& prefix, Json& out) {
  for (const std::string& key : at.keys()) {
    if (at[key].is_map())
      flatten(at[key], prefix + key + ".", out);
    else if (at[key].is_scalar())
      out[prefix + key] = at[key].text();
    else
      out[prefix + key] = "[" + join(at[key].texts(), ", ") + "]";
  }
}

/// The parameters under the controller's name in a controllers' file, or a file that is a map of parameters.
Json values_in(const std::string& file, const std::string& controller) {
  Yaml yaml = load_with_repeats(file);
  for (const std::string& name : {controller, "/" + controller, std::string("/**")})
    if (yaml[name].is_map()) {
      yaml = yaml[name];
      break;
    }
  if (yaml["ros__parameters"].is_map()) yaml = yaml["ros__parameters"];
  if (!yaml.is_map())
    throw Error(
        Problem{"bad-value", yaml.where(), "the file has no parameters for '" + controller + "'", {}});
  Json out = Json::object();
  flatten(yaml, "", out);
  return out;
}

/// Values of `wanted` that differ and can be changed; reports those that differ but cannot be changed.
Json changes_among(const Json& wanted, const Json& listed) {
  Json out = Json::object();
  std::vector<std::string> known;
  for (const Json& p : listed) {
    const std::string key = p["key"];
    known.push_back(key);
    const auto found = wanted.find(key);
    if (found == wanted.end() || *found == p["value"]) continue;
    if (flag_of(p["changeable"]))
      out[key] = *found;
    else
      fmt::print(stderr, "{} stays {}: it cannot be changed while the controller is configured\n", key,
                 shown(p["value"]));
  }
  for (const auto& [key, value] : wanted.items())
    if (key != "type" && std::find(known.begin(), known.end(), key) == known.end())
      throw Error("unknown-parameter", "there is no parameter '" + key + "'" + did_you_mean(key, known));
  return out;
}

void print_list(const Json& parameters) {
  std::vector<std::vector<std::string>> rows;
  for (const Json& p : parameters)
    rows.push_back({shown(p["key"]), shown(p["value"]), shown(p["default"]),
                    flag_of(p["changeable"]) ? "yes" : "", shown(p["text"])});
  print_table({"PARAMETER", "VALUE", "DEFAULT", "CHANGEABLE", "WHAT"}, rows);
}

void print_dump(const std::string& name, const Json& parameters) {
  fmt::print("{}:\n  ros__parameters:\n", name);
  for (const Json& p : parameters)
    if (!shown(p["value"]).empty()) fmt::print("    {}: {}\n", shown(p["key"]), shown(p["value"]));
}

Json ask(Client& client, const std::string& action, const Arguments& a) {
  const Json all{{"request", "param.list"}, {"name", a.name}};
  if (action == "list" || action == "dump") return client.ask(all);
  if (action == "get") return client.ask({{"request", "param.get"}, {"name", a.name}, {"key", a.key}});
  Json values = values_of(a.values);
  if (action == "load") values = changes_among(values_in(a.file, a.name), client.ask(all));
  if (values.empty()) return {{"changed", 0}};
  return client.ask({{"request", "param.set"}, {"name", a.name}, {"values", values}});
}

int act(const std::string& action, const Arguments& a) {
  Client client(a.client.cell);
  const Json result = ask(client, action, a);
  if (a.client.json)
    fmt::print("{}\n", result.dump(1));
  else if (action == "list")
    print_list(result);
  else if (action == "dump")
    print_dump(a.name, result);
  else if (action == "get")
    fmt::print("{}\n", shown(result["value"]));
  else
    fmt::print("changed {} parameter{}\n", shown(result["changed"]), result["changed"] == 1 ? "" : "s");
  return kOk;
}

}  // namespace

int run_param(int argc, char** argv) {
  CommandLine app("Parameters of the controllers of a running cell", "polyarm param");
  Arguments a;
  const auto add = [&](const char* name, const char* text) {
    CommandLine* sub = app.add_subcommand(name, text);
    sub->add_option("controller", a.name)->required();
    a.client.add_to(*sub);
    return sub;
  };
  add("list", "all parameters: value, default, what they are");
  add("get", "one parameter")->add_option("key", a.key)->required();
  add("set", "change parameters that can be changed, all at once between two cycles")
      ->add_option("values", a.values, "KEY=VALUE …, or KEY VALUE")
      ->required();
  add("load", "set them from a YAML file")->add_option("file", a.file)->required();
  add("dump", "print them in the form of a controllers file");
  app.footer(examples({"polyarm param list joint_trajectory_controller",
                       "polyarm param set pid gains.joint_1.p=20 gains.joint_1.d=1",
                       "polyarm param dump pid > pid.yaml", "polyarm param load pid pid.yaml"}));
  return run_actions(app, argc, argv, [&] { return act(app.subcommand(), a); });
}

}  // namespace polyarm::apps
