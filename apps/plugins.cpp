#include "polyarm/plugins/plugins.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "apps/options.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/setup/build.hpp"
#include "polyarm/base/approvals.hpp"
#include "polyarm/base/reach.hpp"
#include "polyarm/base/shell_word.hpp"

namespace polyarm::apps {

namespace {

using nlohmann::json;
namespace fs = std::filesystem;

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
  json unapproved = json::array();
  for (const plugins::Library& library : plugins::unapproved())
    unapproved.push_back({{"file", library.file.string()}, {"sha256", library.sha256}});
  const json out = {{"plugins", found},
                    {"refused", refused},
                    {"not_approved", unapproved},
                    {"default_folders", folders}};
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
  for (const plugins::Library& library : plugins::unapproved())
    fmt::print("not approved  {}\n  native code of a cell; sha256 {}\n  if you trust it: polyarm plugins approve {}\n",
               library.file.string(), library.sha256, shell_word(library.file.string()));
  fmt::print("{} plugins, {} refused, {} not approved\n", plugins::found().size(), plugins::refused().size(),
             plugins::unapproved().size());
  if (!plugins::unapproved().empty()) return;
  if (!plugins::found().empty() || !plugins::refused().empty()) return;
  fmt::print("looked in by default:\n");
  for (const auto& folder : plugins::default_folders()) fmt::print("  {}\n", folder.string());
  fmt::print("others: --plugins DIR, POLYARM_PLUGINS=DIR:DIR, or 'plugins: [DIR]' of a cell file\n");
}

// --- approvals

/// One library, or all libraries of a folder.
std::vector<plugins::Library> libraries_of(const std::string& named) {
  std::error_code error;
  if (!fs::is_directory(named, error)) return {plugins::check_file(named)};
  std::vector<plugins::Library> out = plugins::look_at(named);
  if (out.empty())
    throw Error("no-plugin", "there is no *.so in the folder " + named,
                "build the plugin first; or, for a folder that you build into: polyarm plugins approve "
                "--development " + named);
  return out;
}

void approve_folder(const std::string& named) {
  const std::string folder = resolved(named).string();
  if (const std::string unfit = unfit_for_development(folder); !unfit.empty())
    throw Error("bad-folder", folder + " cannot be approved for development: " + unfit,
                "use a folder of your own that others may not write to");
  approve({"folder", folder, {}});
  fmt::print("approved for development: whatever is built into {}\n", folder);
}

int run_approve(int argc, char** argv) {
  CommandLine app("Approves native code of cells on this machine: by its content, or a folder that you build into",
                  "polyarm plugins approve");
  std::vector<std::string> named;
  bool development = false;
  app.add_option("path", named, "a plugin (*.so), or a folder with plugins")->required();
  app.add_flag("--development", development,
               "the folder stays approved whatever is built into it; it must be yours alone to write to");
  app.footer(examples({"polyarm plugins approve their_cell/build/arm.so",
                       "polyarm plugins approve --development my_arm/build"}) +
             "\nApprovals are kept in ~/.config/polyarm/approved (XDG_CONFIG_HOME).\n");
  if (const auto code = app.parse(argc, argv)) return *code;
  for (const std::string& each : named) {
    if (development) {
      approve_folder(each);
      continue;
    }
    for (const plugins::Library& library : libraries_of(each)) {
      approve({"library", library.sha256, resolved(library.file).string()});
      fmt::print("approved {}  sha256 {}\n", library.file.string(), library.sha256);
    }
  }
  return kOk;
}

int run_approved(int argc, char** argv) {
  CommandLine app("Lists what you have approved on this machine: plugins, and what cells may access",
                  "polyarm plugins approved");
  bool as_json = false;
  app.add_flag("--json", as_json, "a list of {kind, subject, what}");
  if (const auto code = app.parse(argc, argv)) return *code;
  json list = json::array();
  for (const Approval& each : approvals()) {
    list.push_back({{"kind", each.kind}, {"subject", each.subject}, {"what", each.what}});
    if (!as_json) fmt::print("{:<9}{}  {}\n", each.kind, each.subject, each.what);
  }
  if (as_json) fmt::print("{}\n", list.dump(1, ' ', false, json::error_handler_t::replace));
  if (!as_json && list.empty()) fmt::print("nothing is approved\n");
  return kOk;
}

int run_revoke(int argc, char** argv) {
  CommandLine app("Takes approvals back", "polyarm plugins revoke");
  std::vector<std::string> named;
  app.add_option("what", named, "a plugin, a folder, a cell's folder, a host, or the first digits of a hash")
      ->required();
  app.footer(examples({"polyarm plugins revoke my_arm/build", "polyarm plugins revoke 3fa81c02"}));
  if (const auto code = app.parse(argc, argv)) return *code;
  bool all = true;
  for (const std::string& each : named) {
    std::vector<Approval> taken = revoke(each);
    for (Approval& more : revoke(resolved(each).string())) taken.push_back(std::move(more));
    for (const Approval& one : taken) fmt::print("revoked {} {} {}\n", one.kind, one.subject, one.what);
    if (taken.empty()) fmt::print(stderr, "polyarm plugins revoke: nothing is approved by '{}'\n", each);
    all = all && !taken.empty();
  }
  return all ? kOk : kFailed;
}

}  // namespace

int run_plugins(int argc, char** argv) {
  const std::string word = argc > 1 ? argv[1] : "";
  if (word == "approve") return run_approve(argc - 1, argv + 1);
  if (word == "approved") return run_approved(argc - 1, argv + 1);
  if (word == "revoke") return run_revoke(argc - 1, argv + 1);
  CommandLine app("Lists plugins: their types, their files, and the refused ones with the reason",
                  "polyarm plugins");
  std::vector<std::string> folders;
  std::string cell;
  bool as_json = false;
  app.add_option("cell", cell, "a cell: its 'plugins:' folders are searched, too");
  add_plugin_option(app, folders);
  app.add_flag("--json", as_json, "one JSON object: plugins, refused, not_approved, default_folders");
  app.footer(
      examples({"polyarm plugins", "polyarm plugins my_cell", "polyarm plugins --plugins my_arm/build"}) +
      "\nWhich native code of cells may run here: polyarm plugins approve|approved|revoke --help\n"
      "Exit codes: 0 nothing was refused, 1 something was, 2 wrong command line\n");
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
  return plugins::refused().empty() && plugins::unapproved().empty() ? kOk : kFailed;
}

}  // namespace polyarm::apps
