#include <fmt/format.h>
#include <signal.h>
#include <time.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>

#include "apps/ending.hpp"
#include "apps/options.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/doctor/machine.hpp"
#include "polyarm/doctor/trial.hpp"
#include "polyarm/hardware/driver_loader.hpp"

namespace polyarm::apps {

namespace {

using hardware::DriverFacts;
using hardware::DriverParameter;

struct Listed {
  std::string name, fault;
  std::unique_ptr<hardware::Component> component;  ///< null if it cannot be loaded
  const DriverFacts* facts() const { return component ? component->facts() : nullptr; }
};

std::vector<Listed> list_drivers() {
  std::vector<Listed> out;
  for (const std::string& name : hardware::driver_names()) {
    Listed driver{name, "", nullptr};
    try {
      driver.component = hardware::make_driver(name);
    } catch (const std::exception& e) {
      driver.fault = e.what();
    }
    out.push_back(std::move(driver));
  }
  return out;
}

const char* kind_of(const DriverParameter& p) {
  return p.kind == hardware::ParameterKind::number    ? "number"
         : p.kind == hardware::ParameterKind::boolean ? "true or false"
                                                      : "text";
}

nlohmann::json json_of(const Listed& driver) {
  nlohmann::json out = {
      {"name", driver.name}, {"fault", driver.fault}, {"parameters", nlohmann::json::array()}};
  const DriverFacts* facts = driver.facts();
  if (!facts) return out;
  out["kind"] = facts->kind, out["drives"] = facts->drives, out["proof"] = facts->proof;
  out["real"] = driver.component->real();
  for (const DriverParameter& p : facts->parameters)
    out["parameters"].push_back({{"name", p.name},
                                 {"kind", kind_of(p)},
                                 {"default", p.fallback ? nlohmann::json(p.fallback) : nlohmann::json()},
                                 {"meaning", p.meaning}});
  return out;
}

void print(const Listed& driver) {
  const DriverFacts* facts = driver.facts();
  if (!facts) {
    fmt::print("{}: {}\n\n", driver.name,
               driver.fault.empty() ? "has no description" : "cannot be loaded: " + driver.fault);
    return;
  }
  fmt::print("{} ({}{}): {}\n  proof: {}\n", driver.name, facts->kind,
             driver.component->real() ? ", real" : "", facts->drives, facts->proof);
  for (const DriverParameter& p : facts->parameters)
    fmt::print("  {:<42} {:<14} {}\n", p.name, p.fallback ? p.fallback : "(needed)", p.meaning);
  fmt::print("\n");
}

int run_list(bool json) {
  nlohmann::json list = nlohmann::json::array();
  for (const Listed& driver : list_drivers()) json ? list.push_back(json_of(driver)) : print(driver);
  if (json) fmt::print("{}\n", list.dump());
  return kOk;
}

std::atomic<bool> test_interrupted{false};

/// The robot for the device: from a description, or a robot without joints.
struct Carrier {
  description::RobotModel model;
  hardware::ComponentContext context;
};

/// The block that names the driver. If none does, the only block, as in a cell with `hardware: DRIVER`.
description::HardwareInfo block_for(const std::string& driver, const description::RobotModel& model,
                                    const std::string& description) {
  for (const description::HardwareInfo& block : model.hardware)
    if (block.plugin == driver) return block;
  if (model.hardware.size() == 1) return model.hardware.front();
  throw Error("no-such-block",
              description + " has " + (model.hardware.empty() ? "no" : "several") +
                  " <ros2_control> blocks, and none with the plugin " + driver,
              "write <plugin>" + driver + "</plugin> into the block of this driver");
}

std::unique_ptr<Carrier> make_carrier(const std::string& driver, const std::string& description) {
  auto out = std::make_unique<Carrier>();
  out->context.name = driver;
  hardware::RobotInstance robot;
  robot.name = "trial";
  if (description.empty()) {
    out->model.name = "none";
    out->model.links.resize(1);
    out->model.links.front().name = "base_link";
  } else {
    Problems found;
    out->model = description::load_robot(description, open_catalogue(), found);
    found.throw_if_errors();  // only the hardware is tried here
    robot.hardware.push_back(block_for(driver, out->model, description));
    out->context.parameters = robot.hardware.front().parameters;
  }
  robot.model = &out->model;
  robot.initial_positions.assign(out->model.actuated.size(), 0.0);
  out->context.robots.push_back(std::move(robot));
  return out;
}

bool confirmed() {
  if (!isatty(STDIN_FILENO)) {
    fmt::print(stderr, "polyarm drivers test: --move needs a person at a terminal to confirm it\n");
    return false;
  }
  fmt::print(
      "Each joint will move a little and back, one after the other. Is there room, and a hand on the "
      "emergency stop?\nType move to continue: ");
  std::fflush(stdout);
  std::string line;
  return std::getline(std::cin, line) && trim(line) == "move";
}

std::string now_text() {
  const time_t now = ::time(nullptr);
  struct tm parts {};
  std::array<char, 32> out{};
  if (!gmtime_r(&now, &parts) || strftime(out.data(), out.size(), "%Y-%m-%dT%H:%M:%SZ", &parts) == 0)
    return "";
  return out.data();
}

int print_trial(const doctor::Trial& trial, const std::string& file) {
  if (!trial.summary.empty()) fmt::print("{}\n", trial.summary);
  for (const std::string& line : doctor::highlights(trial)) fmt::print("  {}\n", line);
  if (!trial.reason.empty() && trial.failure.empty()) fmt::print("  reason: {}\n", trial.reason);
  if (!trial.failure.empty()) fmt::print("{}\n", trial.failure);
  fmt::print("{}; report in {}\n", trial.passed ? "passed" : trial.stopped ? "stopped" : "failed", file);
  return trial.passed ? kOk : trial.stopped ? kStopped : kFailed;
}

struct TestArguments {
  std::string name, description, report;
  std::vector<std::string> parameters;
  doctor::TrialOptions options;
};

int run_test(TestArguments& a) {
  auto component = hardware::make_driver(a.name);
  const auto carrier = make_carrier(a.name, a.description);
  for (const std::string& parameter : a.parameters) {
    const auto equals = parameter.find('=');
    if (equals == std::string::npos || equals == 0)
      throw Error("bad-value", "'" + parameter + "' is not NAME=VALUE", "for example port=/dev/ttyUSB0");
    carrier->context.parameters[parameter.substr(0, equals)] = parameter.substr(equals + 1);
  }
  carrier->context.period = nanoseconds(1 / a.options.rate);
  if (a.options.move && component->real() && !confirmed()) return kUsage;
  struct sigaction action {};
  action.sa_handler = [](int number) {
    test_interrupted = true;
    if (number == SIGPIPE) write_to_nowhere();
  };
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE, SIGTSTP, SIGUSR1, SIGUSR2, SIGALRM})
    if (sigaction(number, &action, nullptr) != 0)
      throw Error("no-signals", "Ctrl-C cannot be caught, and a trial must be stoppable");
  a.options.stop = [] { return test_interrupted.load(); };
  const doctor::Trial trial = doctor::try_driver(*component, carrier->context, a.options);
  const doctor::Machine machine = doctor::look_at(doctor::Place::here());
  const DriverFacts* facts = component->facts();
  const std::string file = a.report.empty() ? "driver-" + a.name + ".yaml" : a.report;
  write_file_atomically(
      file, doctor::report(trial, {POLYARM_VERSION, machine.kernel, facts ? facts->proof : "", now_text(),
                                   machine.preempt_rt}));
  return print_trial(trial, file);
}

}  // namespace

int run_drivers(int argc, char** argv) {
  CommandLine app("Lists drivers, and tries one on its device", "polyarm drivers");
  bool json = false;
  TestArguments arguments;
  app.add_flag("--json", json, "an array: name, kind, drives, proof, real, parameters, fault");
  CommandLine* test =
      app.add_subcommand("test", "opens and reads a device for some seconds, and writes a report");
  test->add_option("name", arguments.name, "the driver")->required();
  test->add_option("parameters", arguments.parameters, "its parameters, NAME=VALUE");
  test->add_option("--description", arguments.description,
                   "a robot whose <ros2_control> block names the driver: joints and parameters");
  test->add_option("--seconds", arguments.options.seconds, "how long it is read")->range(0.01, 3600.0);
  test->add_option("--rate", arguments.options.rate, "how often in a second")->range(0.1, 10000.0);
  test->add_flag("--move", arguments.options.move,
                 "move each joint a little, after you have confirmed it; else nothing moves");
  test->add_option("--report", arguments.report, "file for the report; else driver-NAME.yaml");
  app.footer(examples({"polyarm drivers", "polyarm drivers test serial_imu port=/dev/ttyUSB0 baud=115200",
                       "polyarm drivers test ublox_gnss port=/dev/ttyACM0 --seconds 30"}));
  if (const auto code = app.parse(argc, argv)) return *code;
  return test->parsed() ? run_test(arguments) : run_list(json);
}

}  // namespace polyarm::apps
