#include <fmt/format.h>
#include <malloc.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <exception>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>

#include "apps/journal.hpp"
#include "apps/reach.hpp"
#include "apps/terminal.hpp"
#include "apps/verb.hpp"
#include "apps/workspace.hpp"
#include "drivers/mock/mock.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/hardware/driver_loader.hpp"
#include "polyarm/hulls/robot_bodies.hpp"
#include "polyarm/setup/door_kinds.hpp"

namespace polyarm::apps {

const std::vector<Verb>& verbs() {
  static const std::vector<Verb> table = {
      {"run", "run a cell: simulate, execute its program, report", run_run},
      {"console", "menus: simulate, choose a robot, teach and edit points, move, run scripts", run_console},
      {"check", "find every error of a cell's files; nothing moves", run_check},
      {"test", "run the tests of programs in simulation, side by side", run_test},
      {"compare", "which robots can run a program, how fast, how near to their limits", run_compare},
      {"sweep", "which robot, where its base stands, how fast: thousands of variants, killed and continued",
       run_sweep},
      {"fmt", "write programs in one form; comments stay", run_fmt},
      {"language", "the words and functions of the language; the reference page", run_language},
      {"new", "create a starting point: a cell, hardware or a controller of your own", run_new},
      {"plugins", "list plugins: their types, and the refused ones with the reason", run_plugins},
      {"plugin", "build hardware plugins and controllers of ros2_control without ROS; check them",
       run_plugin},
      {"robots", "list the robots of the catalogue", run_robots},
      {"describe", "describe a robot: joints, limits, frames; or print its URDF", run_describe},
      {"fk", "forward kinematics: joint values to a pose", run_fk},
      {"ik", "inverse kinematics: a pose to joint values", run_ik},
      {"workspace", "map where an arm reaches and how well it moves there", run_workspace},
      {"plan", "plan a motion without moving: its duration, its limits, a plot", run_plan},
      {"xacro", "expand a description in xacro to URDF", run_xacro},
      {"export", "write the configuration of MoveIt 2 for a cell", run_export},
      {"replay", "replay the last cycles before a fault", run_replay},
      {"control", "controllers of a running cell: list, switch, load, state, hold, resume", run_control},
      {"hardware", "hardware components of a running cell: list, state, recover", run_hardware},
      {"interfaces", "every state and command interface of a running cell", run_interfaces},
      {"health", "state and timing of the control loop of a running cell", run_health},
      {"limits", "which limits changed commands in a running cell", run_limits},
      {"calibrate", "calibrate tools, frames, cameras, arms and payloads from samples", run_calibrate},
      {"data", "data sets: list, get, set, import, export, undo, frames, tools", run_data},
      {"tags", "tags and links of a running cell: show, set, force", run_tags},
      {"send", "send a message to a controller of a running cell", run_send},
      {"watch", "show the output of a controller of a running cell", run_watch},
      {"jog", "move a robot of a running cell by hand: joints or tool, by keys or by a distance", run_jog},
      {"lead", "lead an arm of a running cell by another while a key is held", run_lead},
      {"teleop", "drive a base of a running cell from the keyboard", run_teleop},
      {"param", "parameters of the controllers of a running cell", run_param},
      {"fleet", "the cells of a site: their states, one page of all, programs for several", run_fleet},
      {"users", "users who log in at the pendant: add, list, remove, role, password", run_users},
      {"audit", "who changed what, and when", run_audit},
      {"setup", "set up the servos of an arm, or inspect the controller of a robot", run_setup},
      {"doctor", "check what on this machine hinders a cell, and how to fix it", run_doctor},
      {"drivers", "list the drivers, or try one on its device and write a report", run_drivers},
      {"far-side", "simulate the controller of a robot byte for byte, with faults on request", run_far_side},
      {"completion", "print shell completion (bash, zsh, fish) or the manual page (man)", run_completion},
      {"version", "print the version", run_version},
  };
  return table;
}

namespace {

void print_help() {
  fmt::print("polyarm: one runtime for every robot arm\n\nUsage: polyarm VERB [OPTIONS]\n\n");
  for (const Verb& verb : verbs()) fmt::print("  {:<12}{}\n", verb.name, verb.summary);
  fmt::print(
      "\n  polyarm VERB --help has details and examples.\n"
      "  --allow PATH|host:NAME|secret:NAME, with any verb: let a cell access this outside its own folder\n\n"
      "Examples:\n"
      "  polyarm run examples/pick_and_place\n"
      "  polyarm run examples/sorting --robot abb/irb_120 --fast\n"
      "  polyarm check examples/bin_picking --robot fanuc/lr_mate_200id\n"
      "  polyarm ik universal_robots/ur5e --xyz 0.4 0 0.3 --rpy 3.1416 0 0\n\n"
      "Exit codes: 0 done, 1 failed, 2 wrong command line, 3 stopped by a person\n");
}

int unknown_verb(const std::string& wrong) {
  std::vector<std::string> names;
  for (const Verb& verb : verbs()) names.emplace_back(verb.name);
  fmt::print(stderr, "polyarm: there is no verb '{}'{}\nverbs: {}\n", wrong, did_you_mean(wrong, names),
             join(names, ", "));
  return kUsage;
}

/// Standard error may be closed; this must not change the exit code.
void complain(const std::string& text, Priority priority = Priority::error) {
  std::fputs((leads_to_journal(STDERR_FILENO) ? for_journal(text, priority) : text).c_str(), stderr);
}

}  // namespace
}  // namespace polyarm::apps

int main(int argc, char** argv) {
  using namespace polyarm;
  using apps::complain;
#ifdef M_MXFAST
  // Joins small freed blocks with their neighbours at once. Otherwise the next large allocation joins
  // thousands of them in one tick of the cell.
  mallopt(M_MXFAST, 0);
#endif
  hardware::register_driver("mock",
                            [] { return std::unique_ptr<hardware::Component>(new drivers::MockComponent); });
  cell::register_door({"ros2",
                       {"domain", "range", "peers", "namespace", "distribution", "cmd_vel", "move_group"},
                       "install Fast DDS (tools/setup does) and build again, or run without --ros2"});
  apps::guard_terminal(apps::asks_for_document(argc, argv));
  hulls::listen_to_making([](std::size_t made, std::size_t meshes) {
    constexpr auto kBetween = std::chrono::seconds(2);
    static auto last = std::chrono::steady_clock::now();
    const auto now = std::chrono::steady_clock::now();
    if (made == 0)
      complain(
          fmt::format("computing bodies of {} mesh{} for the detection of contacts; stored for later runs\n",
                      meshes, meshes == 1 ? "" : "es"),
          apps::Priority::info);
    else if (made < meshes && now - last >= kBetween)
      complain(fmt::format("  {} of {} are computed\n", made, meshes), apps::Priority::info);
    else
      return;
    last = now;
  });
  try {
    apps::take_reach_options(argc, argv);
  } catch (const Error& e) {
    complain(std::string("polyarm: ") + e.what() + "\n");
    return apps::kUsage;
  }
  if (argc < 2) {
    apps::print_help();
    return apps::kUsage;
  }
  const std::string wanted = argv[1];
  if (wanted == "--help" || wanted == "-h" || wanted == "help") {
    apps::print_help();
    return apps::kOk;
  }
  if (wanted == "--version") return apps::run_version(argc - 1, argv + 1);
  for (const apps::Verb& verb : apps::verbs()) {
    if (wanted != verb.name) continue;
    try {
      return verb.run(argc - 1, argv + 1);
    } catch (const apps::WrongUse& e) {
      complain(std::string(e.what()) + "\n");
      return apps::kUsage;
    } catch (const Error& e) {
      complain(std::string(e.what()) + "\n");
    } catch (const std::filesystem::filesystem_error&) {
      complain(std::string(error_thrown().what()) + "\n");
    } catch (const std::system_error& e) {
      if (e.code() == std::errc::broken_pipe || e.code() == std::errc::io_error) return apps::kFailed;
      complain("polyarm " + wanted + ": unexpected: " + e.what() + "\n");
    } catch (const nlohmann::json::exception& e) {
      complain("polyarm " + wanted + ": an answer or a file is not as expected: " + e.what() +
               " (a cell of another version? see `polyarm version` and restart the cell)\n");
    } catch (const std::exception& e) {
      complain("polyarm " + wanted + ": unexpected: " + e.what() + "\n");
    }
    return apps::kFailed;
  }
  return apps::unknown_verb(wanted);
}
