/// The menus of the console, as described in the thesis: start a simulation, choose a robot, edit files,
/// move, run scripts.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "apps/console_cell.hpp"
#include "apps/console_editor.hpp"
#include "apps/console_move.hpp"
#include "apps/console_script.hpp"
#include "apps/dialogue.hpp"
#include "apps/jog_keys.hpp"
#include "apps/options.hpp"
#include "apps/reach.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/cell/socket_door.hpp"

namespace polyarm::apps {

namespace {
namespace fs = std::filesystem;

constexpr const char* kDefaultRobot = "universal_robots/ur3";

struct ConsoleArguments {
  std::string cell, robot, hardware;
  bool pendant = false;
};

class Console {
 public:
  explicit Console(const ConsoleArguments& a)
      : a_(a),
        robot_(a.robot),
        editor_(talk_, robot_source()),
        move_(talk_, cell_, editor_),
        script_(talk_, cell_, editor_) {
    talk_.on_interrupt = [this] { hold(); };
    find_place();
  }

  int run() {
    try {
      if (cell_.runs()) main_menu();
      start_menu();
      cell_.leave();
      return talk_.complained() && !talk_.at_terminal() ? kFailed : kOk;
    } catch (const EndOfAnswers&) {
      return end_of_answers();
    }
  }

 private:
  // --- the cell -------------------------------------------------------------------------------------------

  /// Finds a running cell, or the folder to work in.
  void find_place() {
    const fs::path given = a_.cell.empty() ? "." : a_.cell;
    if (fs::is_directory(given)) {
      folder_ = given;
      if (fs::exists(given / "cell.yaml")) cell_file_ = "cell.yaml";
    } else if (fs::exists(given)) {
      folder_ = given.parent_path().empty() ? "." : given.parent_path();
      cell_file_ = given.filename().string();
    } else {
      try {
        cell_.attach(a_.cell);
      } catch (const Error& e) {
        throw Error("no-cell",
                    "'" + a_.cell + "' is neither a folder nor a file, and " + e.problems().front().what,
                    "name a folder to work in: mkdir " + a_.cell + " && polyarm console " + a_.cell);
      }
      folder_ = cell_.folder();
      talk_.say("connected with '" + cell_.name() + "'");
    }
    editor_.set_folder(folder_);
  }

  std::string robot_text() const {
    if (!robot_.empty()) return robot_;
    return cell_file_.empty() ? kDefaultRobot : "the robots of " + cell_file_;
  }

  void start() {
    std::vector<std::string> arguments;
    if (!cell_file_.empty()) {
      arguments.push_back(cell_file_);
      if (!robot_.empty()) arguments.insert(arguments.end(), {"--robot", robot_});
      if (!a_.hardware.empty()) arguments.insert(arguments.end(), {"--hardware", a_.hardware});
    } else {
      arguments = {"--description", robot_.empty() ? kDefaultRobot : robot_, "--hardware",
                   a_.hardware.empty() ? "mock" : a_.hardware};
    }
    if (a_.pendant) arguments.push_back("--pendant");
    for (const std::string& each : allowed_by_options()) arguments.insert(arguments.end(), {"--allow", each});
    talk_.say("starting the simulation of " + robot_text() + " …");
    cell_.start(folder_, arguments);
    editor_.set_folder(cell_.folder());
    talk_.say(fmt::format("'{}' is running; its files are in {}", cell_.name(), cell_.folder().string()));
    if (!cell_.pendant().empty()) talk_.say("its pendant: " + cell_.pendant());
    main_menu();
  }

  void connect() {
    std::vector<std::string> names;
    for (const fs::path& socket : cell::SocketDoor::running()) names.push_back(socket.stem().string());
    if (names.empty())
      throw Error("no-cell", "no cell is running", "start one: 1, or in another terminal: polyarm run CELL");
    fmt::print("{}", in_columns(names));
    const std::string name = names.size() == 1 && talk_.yes("Connect with '" + names.front() + "'?", true)
                                 ? names.front()
                                 : talk_.name("Its name: ");
    if (!editor_.may_leave()) throw GivenUp{};
    cell_.attach(name);
    editor_.set_folder(cell_.folder());
    main_menu();
  }

  /// Ctrl-C at a question: the robot stops on its path.
  void hold() {
    if (!cell_.runs()) return;
    try {
      const Json health = cell_.ask({{"request", "health"}});
      if (health["standing"].get<bool>()) return;
      cell_.ask({{"request", "control.hold"}});
      talk_.say("stopped on the path");
    } catch (const Error& e) {
      talk_.complain(e);
    }
  }

  RobotSource robot_source() {
    RobotSource out;
    out.state = [this] {
      if (!cell_.runs())
        throw Error("no-cell", "no simulation is running, so the robot has no position", "start it first");
      return cell_.ask({{"request", "jog.state"}});
    };
    out.joints = [this]() -> std::vector<RobotSource::Joint> {
      std::vector<RobotSource::Joint> joints;
      if (cell_.runs()) {
        const Json state = cell_.ask({{"request", "jog.state"}});
        for (std::size_t i = 0; i < state["names"].size(); ++i)
          joints.push_back({state["names"][i], state["slides"][i].get<bool>()});
        return joints;
      }
      const description::RobotModel model = open_catalogue().load(robot_.empty() ? kDefaultRobot : robot_);
      for (const std::string& name : model.joint_names()) {
        const auto joint = std::find_if(model.joints.begin(), model.joints.end(),
                                        [&](const description::Joint& j) { return j.name == name; });
        joints.push_back(
            {name, joint != model.joints.end() && joint->type == description::JointType::prismatic});
      }
      return joints;
    };
    return out;
  }

  // --- choosing a robot -----------------------------------------------------------------------------------

  /// Lists the catalogue with numbers. Text narrows the list; a number or a full name selects a robot.
  void select_robot() {
    const std::vector<std::string> all = open_catalogue().names();
    if (all.empty())
      throw Error("no-catalogue", "the catalogue of robots was not found",
                  "set POLYARM_ROBOTS to the folder robots/ of Polyarm");
    std::vector<std::size_t> shown_now(all.size());
    for (std::size_t i = 0; i < all.size(); ++i) shown_now[i] = i;
    for (;;) {
      show_robots(all, shown_now);
      const std::string answer =
          talk_.name("Number, or part of a name (Enter: stays " + robot_text() + "): ");
      if (const auto number = parse_number(answer)) {
        if (*number >= 1 && *number <= static_cast<double>(all.size()))
          return choose(all[static_cast<std::size_t>(*number) - 1]);
        talk_.complain(fmt::format("there is no robot {}, they are 1 to {}", answer, all.size()));
        continue;
      }
      std::vector<std::size_t> found;
      for (std::size_t i = 0; i < all.size(); ++i) {
        if (equal_ignoring_case(all[i], answer)) return choose(all[i]);
        if (matches(all[i], answer)) found.push_back(i);
      }
      if (found.size() == 1) return choose(all[found.front()]);
      if (found.empty()) talk_.complain("no robot is called '" + answer + "'" + did_you_mean(answer, all));
      if (!found.empty()) shown_now = found;
    }
  }

  /// One paragraph per manufacturer.
  static void show_robots(const std::vector<std::string>& all, const std::vector<std::size_t>& which) {
    std::vector<std::string> models;
    for (std::size_t k = 0; k < which.size(); ++k) {
      const auto maker = [&](std::size_t i) { return all[which[i]].substr(0, all[which[i]].find('/')); };
      models.push_back(fmt::format("{} {}", which[k] + 1, all[which[k]].substr(maker(k).size() + 1)));
      if (k + 1 < which.size() && maker(k + 1) == maker(k)) continue;
      fmt::print("{}\n{}", maker(k), flowing(models, "   "));
      models.clear();
    }
  }

  /// True if the name contains every word of `wanted`, in any order: "ur 5e", "fanuc lr mate".
  static bool matches(const std::string& name, const std::string& wanted) {
    const auto words = split_words(lower(wanted), " _/-");
    return std::all_of(words.begin(), words.end(),
                       [&](const std::string& word) { return lower(name).find(word) != std::string::npos; });
  }

  void choose(const std::string& name) {
    robot_ = name;
    talk_.say("robot: " + robot_);
  }

  // --- menus ----------------------------------------------------------------------------------------------

  void start_menu() {
    const auto entries = [this]() -> std::vector<MenuEntry> {
      return {
          {1, "Start Simulation", [this] { start(); }},
          {2, "Connect To A Running Cell", [this] { connect(); }},
          {3, "Select Robot", [this] { select_robot(); }},
          {4, "File Editor", [this] { editor_.run(); }},
      };
    };
    do
      talk_.menu([this] { return "Polyarm   " + robot_text() + ", no simulation" + unsaved(); }, entries,
                 [this] { return over_; });
    while (!over_ && !editor_.may_leave());
  }

  std::string unsaved() const { return editor_.has_unsaved() ? "   " + editor_.summary() : ""; }

  void main_menu() {
    const auto entries = [this] {
      std::vector<MenuEntry> out = {
          {1, "Robot Information", [this] { information(); }},
          {2, "File Editor", [this] { editor_.run(); }},
          {3, "Move Robot", [this] { move_.run(); }},
          {4, "Scripts", [this] { script_.run(); }},
          {5, cell_.is_own() ? "Stop Simulation" : "Leave This Cell", [this] { cell_.leave(); }},
      };
      if (cell_.robots().size() > 1)
        out.push_back({6, "Choose Robot Of The Cell", [this] { choose_of_cell(); }});
      return out;
    };
    const auto heading = [this] {
      return fmt::format("Main Menu   {}, {}{}", cell_.name(), cell_.robot(), unsaved());
    };
    for (;;) {
      talk_.menu(heading, entries, [this] { return !cell_.runs(); });
      if (!cell_.runs()) return;  // back to the first menu
      if (!editor_.may_leave()) continue;
      over_ = true;
      return cell_.leave();
    }
  }

  void choose_of_cell() {
    fmt::print("{}", in_columns(cell_.robots()));
    const std::string name = talk_.name("Its name: ");
    const auto& all = cell_.robots();
    if (std::find(all.begin(), all.end(), name) == all.end())
      throw Error("unknown-robot", "the cell has no robot '" + name + "'" + did_you_mean(name, all));
    cell_.choose_robot(name);
  }

  void information() {
    const Json state = cell_.ask({{"request", "jog.state"}});
    std::vector<std::vector<std::string>> rows;
    for (std::size_t i = 0; i < state["names"].size(); ++i) {
      const std::string name = state["names"][i];
      const bool slides = state["slides"][i].get<bool>();
      const Json& limits = state["limits"][name];
      const double value = state["joints"][name].get<double>();
      rows.push_back({name, fmt::format("{:.4f} {}", value, slides ? "m" : "rad"), joint_text(value, slides),
                      limits.is_array() ? joint_text(limits[0].get<double>(), slides) + " to " +
                                              joint_text(limits[1].get<double>(), slides)
                                        : "turns without end"});
    }
    print_table({"JOINT", "VALUE", "", "LIMITS"}, rows);
    const Json& q = state["orientation"];
    talk_.say("TCP in the world: " + tcp_line(state));
    talk_.say(fmt::format("quaternion x y z w: {:.5f} {:.5f} {:.5f} {:.5f}", q[0].get<double>(),
                          q[1].get<double>(), q[2].get<double>(), q[3].get<double>()));
    talk_.say(fmt::format("profile {}, control: {}", shown(state["profile"]), shown(state["control"])));
  }

  int end_of_answers() {
    std::optional<fs::path> rescued;
    try {
      rescued = editor_.rescue();
    } catch (const Error& e) {
      talk_.complain(e);
    }
    if (rescued) fmt::print(stderr, "polyarm console: unsaved values are in {}\n", rescued->string());
    cell_.leave();
    if (talk_.ended()) return kStopped;
    return rescued || (talk_.complained() && !talk_.at_terminal()) ? kFailed : kOk;
  }

  const ConsoleArguments& a_;
  Dialogue talk_;
  ConsoleCell cell_;
  std::string robot_, cell_file_;  ///< empty: the default robot; no cell file
  fs::path folder_ = ".";
  bool over_ = false;
  ConsoleEditor editor_;
  ConsoleMove move_;
  ConsoleScript script_;
};

}  // namespace

int run_console(int argc, char** argv) {
  CommandLine app("Menus: start a simulation, choose a robot, teach and edit points, move, run scripts",
                  "polyarm console");
  ConsoleArguments a;
  app.add_option("cell", a.cell,
                 "a folder to work in (with a cell.yaml or without), a cell file, or the name of a running "
                 "cell; default: this folder");
  app.add_option("--robot", a.robot, "the robot that is selected first: MODEL of the catalogue");
  app.add_option("--hardware", a.hardware, "mock (exact, without physics), mujoco, or what the cell declares")
      ->check(wrong_hardware, "NAME");
  app.add_flag("--pendant", a.pendant, "the simulation serves the pendant to a browser, too");
  app.footer(examples({"polyarm console", "polyarm console examples/pick_and_place",
                       "polyarm console ~/first", "polyarm console < answers.txt"}) +
             "\nA pipe can answer every question, one line each; its end ends the console.\n"
             "Ctrl-C stops the robot on its path.\n"
             "Exit codes: 0 done, 1 something was refused (from a pipe) or not saved, 3 ended by a signal\n");
  if (const auto code = app.parse(argc, argv)) return *code;
  if (!a.robot.empty()) open_catalogue().load(a.robot);  // reports a wrong name now
  return Console(a).run();
}

}  // namespace polyarm::apps
