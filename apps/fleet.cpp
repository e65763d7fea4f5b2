#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <thread>

#include "apps/ending.hpp"
#include "apps/options.hpp"
#include "apps/terminal.hpp"
#include "apps/verb.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/cell/run.hpp"
#include "polyarm/fleet/deployment.hpp"
#include "polyarm/fleet/site_page.hpp"
#include "polyarm/fleet/site_watch.hpp"

namespace polyarm::apps {

namespace {

using Json = nlohmann::json;

struct FleetArguments {
  std::filesystem::path file, program;
  std::vector<std::string> cells;
  std::string as;
  double every = 1, timeout = 5;
  unsigned port = 8770;
  bool json = false, dry = false, despite = false, watch = false;
};

/// The cells that were named; all without a name.
std::vector<fleet::SiteCell> chosen(const fleet::Site& site, const std::vector<std::string>& names) {
  if (names.empty()) return site.cells;
  std::vector<fleet::SiteCell> out;
  std::vector<std::string> known;
  for (const fleet::SiteCell& each : site.cells) known.push_back(each.name);
  for (const std::string& name : names) {
    const auto found = std::find(known.begin(), known.end(), name);
    if (found == known.end())
      throw WrongUse("unknown-cell", "the site has no cell '" + name + "'" + did_you_mean(name, known),
                     "cells: " + join(known, ", "));
    out.push_back(site.cells[static_cast<std::size_t>(found - known.begin())]);
  }
  return out;
}

int show_status(const fleet::Site& site, const FleetArguments& a) {
  const fleet::SiteWatch watch(site, 0, a.timeout);
  watch.wait_for_first();
  const auto reports = watch.reports();
  if (a.json)
    fmt::print("{}\n", fleet::json_of(reports).dump(-1, ' ', false, Json::error_handler_t::replace));
  else
    fmt::print("{}", fleet::table_of(reports));
  const bool all = std::all_of(reports.begin(), reports.end(), [](const auto& each) { return each.answers; });
  return all ? kOk : kFailed;
}

int serve(const fleet::Site& site, const FleetArguments& a) {
  const fleet::SiteWatch watch(site, a.every, a.timeout);
  const fleet::SitePage page(watch, site.name, static_cast<std::uint16_t>(a.port));
  fmt::print("the page of the site, for this machine: http://localhost:{}/\n", page.port());
  std::fflush(stdout);
  stop_on_signals(true);
  while (cell::stops_requested() == 0) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  return kOk;
}

void print_deployed(const std::vector<fleet::Deployed>& all, bool json, bool with_diff) {
  if (json) {
    Json out = Json::array();
    for (const auto& each : all)
      out.push_back({{"cell", each.cell},
                     {"state", name(each.state)},
                     {"why", each.why},
                     {"diff", each.diff},
                     {"problems", each.problems}});
    fmt::print("{}\n", out.dump(-1, ' ', false, Json::error_handler_t::replace));
    return;
  }
  for (const auto& each : all) {
    fmt::print("{}: {}{}{}\n", each.cell, name(each.state), each.why.empty() ? "" : ": ", each.why);
    for (const std::string& problem : each.problems) fmt::print("  {}\n", problem);
    if (with_diff)
      for (const std::string& line : each.diff) fmt::print("  {}\n", line);
  }
}

/// First the check of each cell, then the files. Where one check fails, no cell gets the program, unless that
/// was asked.
int deploy(const fleet::Site& site, const FleetArguments& a) {
  using State = fleet::Deployed::State;
  const std::string text = read_file(a.program, std::size_t{900'000});
  const std::string file = a.as.empty() ? a.program.filename().string() : a.as;
  const auto cells = chosen(site, a.cells);
  auto all = fleet::plan(cells, file, text, a.timeout);
  if (!a.json) print_deployed(all, false, true);
  const auto good = [](const fleet::Deployed& each) {
    return each.state == State::ready || each.state == State::same;
  };
  const bool clean = std::all_of(all.begin(), all.end(), good);
  if (a.dry || (!clean && !a.despite)) {
    if (a.json) print_deployed(all, true, true);
    std::fflush(stdout);
    if (!clean)
      fmt::print(stderr,
                 "nothing was written: see above, or --despite to write to the cells that are ready\n");
    return clean ? kOk : kFailed;
  }
  fleet::write(cells, all, file, text, false, a.timeout);
  print_deployed(all, a.json, false);
  const bool done = std::all_of(all.begin(), all.end(), [](const auto& each) {
    return each.state == State::written || each.state == State::same;
  });
  return done ? kOk : kFailed;
}

}  // namespace

int run_fleet(int argc, char** argv) {
  CommandLine app("The cells of a site: their states, one page of all, and programs for several",
                  "polyarm fleet");
  FleetArguments a;
  app.require_subcommand();
  const auto sub = [&](const char* verb, const char* help) {
    CommandLine* const out = app.add_subcommand(verb, help);
    out->add_option("file", a.file, "the site: a file with polyarm: site/1")->required()->existing_file();
    out->add_option("--timeout", a.timeout, "a cell that does not answer for so many s is silent (5)")
        ->range(0.1, 600.0);
    return out;
  };
  CommandLine* const status = sub("status", "print a table of all cells");
  status->add_flag("--json", a.json, "as a JSON list");
  CommandLine* const page = sub("serve", "serve one page of all cells to a browser on this machine");
  page->add_option("--port", a.port, "port of the page (8770); 0: any free port")->range(0, 65535);
  page->add_option("--every", a.every, "ask each cell every so many s (1)")->range(0.1, 3600.0);
  CommandLine* const program =
      sub("deploy", "check a program on several cells, then write it there; nothing is started");
  program->add_option("program", a.program, "the script")->required()->existing_file();
  program->add_option("--as", a.as, "its name in the cells (default: its own)");
  program->add_option("--cells", a.cells, "only these cells, with commas")->delimiter(',');
  program->add_flag("--dry", a.dry, "only compare and check");
  program->add_flag("--despite", a.despite,
                    "write to the cells that are ready, although others have errors or are silent");
  program->add_flag("--json", a.json, "as a JSON list");
  app.footer(examples({"polyarm fleet status site.yaml", "polyarm fleet serve site.yaml",
                       "polyarm fleet deploy site.yaml pick.script --dry",
                       "polyarm fleet deploy site.yaml pick.script --cells press,oven"}) +
             "\nExit codes: 0 done, 1 a cell is silent, has errors or refuses, 2 wrong command line\n");
  if (const auto code = app.parse(argc, argv)) return *code;
  const fleet::Site site = fleet::read_site_file(a.file);
  if (app.subcommand() == "status") return show_status(site, a);
  return app.subcommand() == "serve" ? serve(site, a) : deploy(site, a);
}

}  // namespace polyarm::apps
