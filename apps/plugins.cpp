#include "polyarm/plugins/plugins.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "apps/options.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/cell/build.hpp"

namespace polyarm::apps {

namespace {

using nlohmann::json;

const char* kind(const plugins::Entry& entry) {
  return entry.kind == hardware::PluginKind::hardware ? "hardware" : "controller";
}

void print_json() {
  json found = json::array(), refused = json::array(), folders = json::array();
  for (const plugins::Plugin& plugin : plugins::found()) {
    json entries = json::array();
    for (const plugins::Entry& entry : plugin.entries)
      entries.push_back({{"name", entry.name}, {"kind", kind(entry)}, {"text", entry.help}});
    found.push_back({{"name", plugin.name},
                     {"version", plugin.version},
                     {"file", plugin.file.string()},
                     {"compiler", plugin.compiler},
                     {"entries", std::move(entries)}});
  }
  for (const plugins::Refusal& refusal : plugins::refused())
    refused.push_back(
        {{"file", refusal.file.string()}, {"reason", refusal.reason}, {"advice", refusal.advice}});
  for (const auto& folder : plugins::default_folders()) folders.push_back(folder.string());
  const json out = {{"plugins", found}, {"refused", refused}, {"default_folders", folders}};
  fmt::print("{}\n", out.dump(1, ' ', false, json::error_handler_t::replace));
}

void print_text() {
  for (const plugins::Plugin& plugin : plugins::found()) {
    fmt::print("{} {}  {}  ({})\n", plugin.name, plugin.version, plugin.file.string(), plugin.compiler);
    for (const plugins::Entry& entry : plugin.entries)
      fmt::print("  {:<11}{:<32} {}\n", kind(entry), entry.name, entry.help);
  }
  for (const plugins::Refusal& refusal : plugins::refused()) {
    fmt::print("refused  {}\n  {}\n", refusal.file.string(), refusal.reason);
    if (!refusal.advice.empty()) fmt::print("  {}\n", refusal.advice);
  }
  fmt::print("{} plugins, {} refused\n", plugins::found().size(), plugins::refused().size());
  if (!plugins::found().empty() || !plugins::refused().empty()) return;
  fmt::print("looked in by default:\n");
  for (const auto& folder : plugins::default_folders()) fmt::print("  {}\n", folder.string());
  fmt::print("others: --plugins DIR, POLYARM_PLUGINS=DIR:DIR, or 'plugins: [DIR]' of a cell file\n");
}

}  // namespace

int run_plugins(int argc, char** argv) {
  CommandLine app("Lists plugins: what they bring, where they are, and what was refused and why",
                  "polyarm plugins");
  std::vector<std::string> folders;
  std::string cell;
  bool as_json = false;
  app.add_option("cell", cell, "a cell: its 'plugins:' folders are looked through, too");
  add_plugin_option(app, folders);
  app.add_flag("--json", as_json, "one JSON object: plugins, refused, default_folders");
  app.footer(
      examples({"polyarm plugins", "polyarm plugins my_cell", "polyarm plugins --plugins my_arm/build"}) +
      "\nExit codes: 0 nothing was refused, 1 something was, 2 wrong command line\n");
  if (const auto code = app.parse(argc, argv)) return *code;
  load_plugins(folders);
  Problems problems;
  cell::load_plugins(cell.empty() ? cell::CellFile{} : cell::read_cell_file(cell), problems);
  for (const Problem& problem : problems.list())
    if (problem.code == "no-folder") fmt::print(stderr, "{}\n", problem.text());
  if (as_json)
    print_json();
  else
    print_text();
  return plugins::refused().empty() ? kOk : kFailed;
}

}  // namespace polyarm::apps
