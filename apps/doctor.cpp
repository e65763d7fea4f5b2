#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "apps/options.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/cell/socket_door.hpp"
#include "polyarm/doctor/findings.hpp"
#include "polyarm/hardware/driver_loader.hpp"

namespace polyarm::apps {

namespace {

namespace fs = std::filesystem;
using doctor::Finding;

void look_at_modules(doctor::Installation& here) {
  std::vector<std::string> names = split_words(POLYARM_MODULES, ",");
  for (const std::string& name : hardware::driver_names())
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  for (const std::string& name : names) {
    doctor::Installation::Module module{name, hardware::driver_available(name), ""};
    try {
      if (module.found) hardware::make_driver(name);  // opens no device; configuring would do that
    } catch (const std::exception& e) {
      module.fault = e.what();
    }
    here.modules.push_back(std::move(module));
  }
}

doctor::Installation look_at_installation() {
  doctor::Installation here;
  for (const fs::path& folder : description::default_catalogue_folders())
    here.catalogue_folders.push_back(folder.lexically_normal().string());
  try {
    here.robots = open_catalogue().names().size();
  } catch (const Error& e) {
    here.catalogue_error = e.what();
  }
  std::error_code error;
  for (const fs::path& folder : hardware::driver_folders())
    if (fs::is_directory(folder, error)) here.driver_folders.push_back(folder.lexically_normal().string());
  look_at_modules(here);
  for (const fs::path& socket : cell::SocketDoor::running()) here.cells.push_back(socket.stem().string());
  return here;
}

doctor::Disk look_at_disk() {
  std::error_code error;
  const fs::path folder = fs::current_path(error);
  const fs::space_info space = fs::space(folder, error);
  return {folder.string(), error ? 0 : static_cast<std::int64_t>(space.available)};
}

void print(const Finding& finding) {
  fmt::print("{:<8} {:<12} {}\n", doctor::name(finding.grade), finding.topic, finding.text);
  if (finding.grade != doctor::Grade::ok && !finding.mend.empty())
    fmt::print("{:>23} {}\n", "$", finding.mend);
}

void print_all(const std::vector<Finding>& findings) {
  int notes = 0, problems = 0;
  for (const Finding& finding : findings) {
    print(finding);
    notes += finding.grade == doctor::Grade::note;
    problems += finding.grade == doctor::Grade::problem;
  }
  fmt::print("\n{} problems, {} notes; {}\n", problems, notes,
             doctor::may_simulate(findings) ? "cells can be simulated here"
                                            : "cells cannot be simulated here until this is fixed");
}

void print_json(const std::vector<Finding>& findings) {
  nlohmann::json list = nlohmann::json::array();
  for (const Finding& f : findings)
    list.push_back({{"topic", f.topic},
                    {"grade", doctor::name(f.grade)},
                    {"concerns", doctor::name(f.concern)},
                    {"text", f.text},
                    {"mend", f.mend}});
  const nlohmann::json out = {{"version", POLYARM_VERSION},
                              {"may_simulate", doctor::may_simulate(findings)},
                              {"findings", std::move(list)}};
  fmt::print("{}\n", out.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
}

}  // namespace

int run_doctor(int argc, char** argv) {
  CommandLine app("Checks this machine: what hinders a cell, and how to fix it. Changes nothing",
                  "polyarm doctor");
  bool json = false;
  app.add_flag("--json", json,
               "one object: version, may_simulate, findings (topic, grade, concerns, text, mend)");
  app.footer(examples({"polyarm doctor", "polyarm doctor --json"}) +
             "\nExit codes: 0 cells can be simulated here, 1 they cannot\n");
  if (const auto code = app.parse(argc, argv)) return *code;
  std::vector<Finding> findings = doctor::judge(doctor::look_at(doctor::Place::here()));
  for (const auto& more : {doctor::judge(doctor::measure_clock(1'000'000'000)),
                           doctor::judge(look_at_installation()), doctor::judge(look_at_disk())})
    findings.insert(findings.end(), more.begin(), more.end());
  json ? print_json(findings) : print_all(findings);
  return doctor::may_simulate(findings) ? kOk : kFailed;
}

}  // namespace polyarm::apps
