#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <ctime>
#include <deque>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "apps/options.hpp"
#include "apps/verb.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/printable.hpp"
#include "polyarm/users/audit_log.hpp"
#include "polyarm/users/user_list.hpp"

namespace polyarm::apps {

namespace {

using Json = nlohmann::json;

struct AuditArguments {
  std::string who, request, cell, since;
  std::filesystem::path folder;
  std::size_t count = 0;
  bool refused = false, json = false;
};

bool wanted(const Json& entry, const AuditArguments& a, const std::string& since) {
  const auto text = [&](const char* key) {
    return entry.contains(key) && entry[key].is_string() ? entry[key].get<std::string>() : std::string();
  };
  if (!a.who.empty() && text("who") != a.who) return false;
  if (!a.cell.empty() && text("cell") != a.cell) return false;
  if (!a.request.empty() && !text("request").starts_with(a.request)) return false;
  if (!since.empty() && text("time") < since) return false;
  return !a.refused || text("outcome") != "done";
}

void print_entry(const Json& entry) {
  const auto text = [&](const char* key) {
    return entry.contains(key) && entry[key].is_string() ? entry[key].get<std::string>() : std::string();
  };
  std::string more = entry.contains("arguments")
                         ? " " + entry["arguments"].dump(-1, ' ', false, Json::error_handler_t::replace)
                         : "";
  if (entry.contains("times")) more += fmt::format(" ({} times)", entry["times"].dump());
  const std::string outcome = text("outcome");
  // Who is refused may send any bytes as an argument.
  fmt::print("{}\n", printable_line(fmt::format("{}  {:<12} {:<16} {} {}{}{}", text("time"), text("cell"),
                                                text("who"), text("request"),
                                                outcome == "done" ? "" : "refused: " + outcome, more,
                                                text("from").empty() ? "" : "  from " + text("from"))));
}

}  // namespace

int run_audit(int argc, char** argv) {
  CommandLine app("Shows the audit log: who changed what, and when", "polyarm audit");
  AuditArguments a;
  a.folder = users::folder_of_user();
  app.add_option("--folder", a.folder,
                 "folder of users and audit log (default: polyarm/ in $XDG_DATA_HOME or ~/.local/share)");
  app.add_option("--who", a.who, "only this user");
  app.add_option("--request", a.request,
                 "only requests that begin with this: program, control.override, log-in");
  app.add_option("--cell", a.cell, "only this cell");
  app.add_option("--since", a.since, "only from then on: 2h, 30min or 7d ago, or 2026-11-28T10:00 (UTC)");
  app.add_flag("--refused", a.refused, "only what was refused");
  app.add_option("--count", a.count, "only the last so many");
  app.add_flag("--json", a.json, "the lines as they are stored");
  app.footer(examples({"polyarm audit --since 2h", "polyarm audit --who anna --request program",
                       "polyarm audit --refused --json"}) +
             "\nExit codes: 0 done, 1 the log cannot be read, 2 wrong command line\n");
  if (const auto code = app.parse(argc, argv)) return *code;
  std::string since;
  if (!a.since.empty()) {
    const auto time = users::time_since(a.since, std::time(nullptr));
    if (!time)
      throw WrongUse("bad-value", "'" + a.since + "' is no time",
                     "--since 2h, 30min, 7d, or 2026-11-28T10:00");
    since = *time;
  }
  std::deque<std::string> kept;
  const auto show = [&](const std::string& line) {
    if (a.json)
      fmt::print("{}\n", line);
    else
      print_entry(Json::parse(line));
  };
  const std::size_t damaged = users::read_audit(users::audit_folder(a.folder), [&](const std::string& line) {
    if (!wanted(Json::parse(line), a, since)) return;
    if (a.count == 0) return show(line);
    kept.push_back(line);
    if (kept.size() > a.count) kept.pop_front();
  });
  for (const std::string& line : kept) show(line);
  if (damaged > 0) fmt::print(stderr, "polyarm audit: {} damaged lines are left out\n", damaged);
  return kOk;
}

}  // namespace polyarm::apps
