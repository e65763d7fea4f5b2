#include "polyarm/cell/check.hpp"

#include <fmt/format.h>
#include <stdlib.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/reach.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/cell/cell.hpp"
#include "polyarm/cell/rehearsal.hpp"
#include "polyarm/cell/run.hpp"
#include "polyarm/cell/swept_check.hpp"
#include "polyarm/description/scene_file.hpp"
#include "polyarm/hardware/driver_loader.hpp"
#include "polyarm/inside/inside.hpp"
#include "polyarm/language/parser.hpp"
#include "polyarm/program/checker.hpp"
#include "polyarm/ros_files/controllers_file.hpp"
#include "polyarm/setup/bodies.hpp"
#include "polyarm/setup/build.hpp"
#include "polyarm/setup/controllers_plan.hpp"
#include "polyarm/setup/frame_check.hpp"
#include "polyarm/shapes/robot_shapes.hpp"
#include "polyarm/signals/tags.hpp"
#include "polyarm/yaml/yaml.hpp"
#include "polyarm/yaml/yaml_repeats.hpp"

namespace polyarm::cell {

namespace {

/// Collects the problems of a dry run and ignores all other events.
class Listener : public Observer {
 public:
  void on_problem(Nanoseconds, const Problem& problem) override { problems.push_back(problem); }
  std::vector<Problem> problems;
};

class Checker {
 public:
  Checker(const description::Catalogue& catalogue, const CheckOptions& options)
      : catalogue_(catalogue), options_(options) {}

  CheckResult check(const std::function<CellFile()>& open) {
    collect(problems_, [&] { file_ = open(); });
    if (!problems_.has_errors()) {
      std::vector<std::string> notes;
      if (check_plugins_of_cell(file_, problems_)) leave_out_unknown();
      if (file_.record && !file_.record->file.empty())
        collect(problems_, [&] { polyarm::reach().check(file_.record->file, Reach::Use::write); });
      ros_files::ControllersFile controllers;
      collect(problems_, [&] { controllers = read_cell_controllers(file_, problems_); });
      robots_ = resolve_robots(file_, controllers, catalogue_, false, problems_, notes);
      add_hardware_faults(robots_, Severity::error, problems_);
      files();
      bodies();
      programs();
      points();
    }
    // These errors only appear when everything is assembled: interfaces of tags and controllers.
    if (!problems_.has_errors()) together();
    result_.problems = problems_.list();
    remove_repeats();
    return std::move(result_);
  }

 private:
  std::string beside(const std::string& name) const { return (file_.folder / name).string(); }

  /// Replaces hardware whose driver is not loaded here by the mock. Drops the lists of controllers to start
  /// and of messages to send, because they may need plugins that are not loaded.
  void leave_out_unknown() {
    for (RobotEntry& robot : file_.robots)
      if (robot.hardware.find('/') != std::string::npos && !hardware::driver_available(robot.hardware))
        robot.hardware = "mock", robot.parameters.clear();
    file_.activate.clear();
    file_.send.clear();
  }

  void files() {
    if (!file_.scene.empty())
      collect(problems_, [&] {
        scene_ = description::read_scene(file_of_cell(file_, file_.scene, file_.scene_where), problems_);
      });
    if (!file_.signals.empty())
      collect(problems_, [&] {
        Problems found;
        const std::string from = file_of_cell(file_, file_.signals, file_.signals_where);
        signals_ = signals::parse_signals(read_file(from), from, found);
        for (const Problem& problem : found.list()) problems_.add(problem);
        check_live(file_, signals_, problems_);
      });
  }

  void bodies() {
    for (const auto& robot : robots_) shapes::check_look(robot->model, problems_);
    make_robot_bodies(robots_, problems_);
    make_scene_bodies(robots_, scene_, problems_);
    result_.notes = file_.notes;
    std::vector<Problem> unchecked = unchecked_bodies(robots_, scene_);
    if (options_.dry)  // finds contacts on any hardware
      std::erase_if(unchecked, [](const Problem& problem) { return problem.code == "no-contacts"; });
    for (const auto& more : {sentences(unchecked), physics_notes(robots_), notes_of_arms(robots_)})
      result_.notes.insert(result_.notes.end(), more.begin(), more.end());
  }

  void programs() {
    program::KnownNames known;
    known.folder = file_.folder;
    add_robots(file_, known);
    for (const signals::Tag& tag : signals_.tags) {
      known.names[tag.name] = program::type_of(tag.initial);
      if (tag.role == data::TagRole::state) known.measured.insert(tag.name);
    }
    for (const signals::CameraLink& camera : signals_.cameras) known.names.try_emplace(camera.point);
    add_named_states(known);
    add_link_names(known);
    add_provided(signals_, known);
    add_places(signals_, known);
    collect(problems_, [&] {  // malformed tags still count as known names
      std::error_code ignored;
      if (file_.signals.empty() || !std::filesystem::exists(beside(file_.signals), ignored)) return;
      for (const std::string& tag : load_with_repeats(beside(file_.signals))["tags"].keys())
        known.names.try_emplace(tag);
    });
    std::filesystem::path script, plc;
    if (!file_.program.empty())
      collect(problems_, [&] {
        script = data::find_file(file_.program, file_.folder, file_.program_where);
        if (script.extension() == ".script")
          data_of(script, known);
        else
          script = script_of(std::exchange(script, {}), known);
      });
    if (!file_.plc.empty())
      collect(problems_, [&] {
        plc = data::find_file(file_.plc, file_.folder, file_.plc_where);
        data_of(plc, known);
      });
    add_elsewhere(known);
    if (!script.empty()) one_program(script, known);
    if (!plc.empty()) one_program(plc, known);
  }

  /// Adds the named joint states of the robots; a cell offers them as data.
  void add_named_states(program::KnownNames& known) const {
    for (const auto& robot : robots_)
      for (const auto& [state, positions] : robot->model.named_states)
        known.names[file_.robots.size() == 1 ? state : robot->entry.name + "_" + state] = {data::Kind::joints,
                                                                                           {}};
  }

  /// Adds names that only a link or the heartbeat defines.
  void add_link_names(program::KnownNames& known) const {
    if (signals_.heartbeat) known.names.try_emplace(signals_.heartbeat->tag, program::type_of(false));
    for (const signals::LinkEntry& link : signals_.links)
      for (const signals::LinkTag& tag : link.tags) {
        using Type = signals::LinkTag::Type;
        const data::Value like = tag.type == Type::boolean  ? data::Value(false)
                                 : tag.type == Type::number ? data::Value(0)
                                 : tag.type == Type::text   ? data::Value("")
                                                            : data::Value(data::Point{});
        known.names.try_emplace(tag.name, program::type_of(like));
      }
  }

  data::ImportFile take(const std::filesystem::path& from, program::KnownNames& known) {
    Problems found;
    const std::string text = read_file(from, bounds::kDataBytes);
    data::ImportFile file = data::ImportFile::parse(text, from.string(), found);
    for (const Problem& problem : found.list()) problems_.add(problem);
    known.add(file.values());
    add_names(text, known);
    sets_.push_back(file.values());
    taken_.insert(from);
    return file;
  }

  /// Reads the data file and its points separately, so an error in one does not hide errors in the other.
  data::ImportFile data(const std::filesystem::path& path, program::KnownNames& known) {
    data::ImportFile file = take(path, known);
    const data::Value* points = file.values().value("PointFile");
    if (points && points->as_text())
      collect(problems_, [&] {
        take(data::find_file(*points->as_text(), file_.folder, file.values().find("PointFile")->where),
             known);
      });
    return file;
  }

  /// Reads a data file, then returns the script that it names.
  std::filesystem::path script_of(const std::filesystem::path& path, program::KnownNames& known) {
    const data::ImportFile file = data(path, known);
    const data::Value* script = file.values().value("ScriptFile");
    if (!script || !script->as_text())
      throw Error(Problem{"no-script",
                          {path.string()},
                          "this data file names no script",
                          "add 'Name: ScriptFile' and 'Text: <script>' to it"});
    return data::find_file(*script->as_text(), file_.folder, file.values().find("ScriptFile")->where);
  }

  /// Reads the data files that a script loads; a cell has them from the start.
  void data_of(const std::filesystem::path& script, program::KnownNames& known) {
    const program::Program& program = read_program(script).program;
    for (const program::Statement* load : program::loads(program)) {
      std::filesystem::path file;
      try {
        file = data::find_file(load->name, file_.folder, program.at(load->name_place));
      } catch (const Error&) {
        continue;  // the checker reports it
      }
      if (!taken_.contains(file)) collect(problems_, [&] { data(file, known); });
    }
  }

  /// Adds the names in data files of the folder that no program loads, for the advice to load them.
  void add_elsewhere(program::KnownNames& known) const {
    constexpr std::size_t kMostFiles = 50;
    std::error_code error;
    std::set<std::filesystem::path> files;
    for (std::filesystem::directory_iterator each(file_.folder, error), end; !error && each != end;
         each.increment(error)) {
      const std::filesystem::path& path = each->path();
      const bool data = path.extension() == ".points" || path.extension() == ".data";
      if (data && each->symlink_status(error).type() == std::filesystem::file_type::regular && !taken_.contains(path))
        files.insert(path);
      if (files.size() >= kMostFiles) break;
    }
    for (const std::filesystem::path& path : files) {
      try {
        program::KnownNames own;
        add_names(read_file(path, bounds::kDataBytes), own);
        for (const auto& name : own.names)
          if (!known.names.contains(name.first))
            known.elsewhere.try_emplace(name.first, path.filename().string(), path.stem().string());
      } catch (const Error&) {
        continue;  // only for advice
      }
    }
  }

  /// Names whose values are malformed still count as known names.
  static void add_names(const std::string& text, program::KnownNames& known) {
    for (const std::string& line : split_words(text, "\r\n")) {
      const auto colon = line.find(':');
      if (colon != std::string::npos && equal_ignoring_case(trim(line.substr(0, colon)), "name"))
        known.names.try_emplace(std::string(trim(line.substr(colon + 1))));
    }
  }

  struct ReadProgram {
    program::Program program;
    Problems problems;
  };

  /// Parses each file once.
  const ReadProgram& read_program(const std::filesystem::path& path) {
    const auto at = read_.find(path);
    if (at != read_.end()) return at->second;
    ReadProgram read;
    read.program = program::parse(read_file(path, bounds::kProgramBytes), path.string(), read.problems);
    return read_.emplace(path, std::move(read)).first->second;
  }

  /// Takes the parsed program out of the cache. Empty if it has errors, because the checker has reported them
  /// already.
  std::optional<program::Program> take_program(const std::filesystem::path& path) {
    const auto at = read_.find(path);
    if (at == read_.end() || at->second.problems.has_errors()) return std::nullopt;
    std::optional<program::Program> out = std::move(at->second.program);
    read_.erase(at);
    return out;
  }

  void one_program(const std::filesystem::path& path, const program::KnownNames& known) {
    collect(problems_, [&] {
      const ReadProgram& read = read_program(path);
      Problems found = read.problems;
      program::check(read.program, known, found);  // checks the part that could be parsed
      for (const Problem& problem : found.list()) problems_.add(problem);
    });
  }

  void points() {
    std::set<std::string> later;  // names whose values come from outside
    for (const signals::Tag& tag : signals_.tags) later.insert(tag.name);
    for (const signals::LinkEntry& link : signals_.links)
      for (const signals::LinkTag& tag : link.tags) later.insert(tag.name);
    for (const signals::CameraLink& camera : signals_.cameras) later.insert(camera.point);
    for (const BeltEntry& belt : file_.belts) later.insert(belt.name);
    FrameCheck frames(sets_, robots_, std::move(later));
    for (const auto& [path, read] : read_) frames.look_at(read.program);
    // From another carrier's place a carried robot reaches other points; its moves are checked later.
    const bool carried = std::any_of(robots_.begin(), robots_.end(),
                                     [](const auto& robot) { return !robot->entry.on.empty(); });
    for (const data::DataSet& set : sets_)
      for (const data::Entry& entry : set.entries())
        if (entry.value.is_place()) point(!carried || robots_.size() == 1, entry, frames);
  }

  /// At least one robot must reach the point. Its moves are checked later.
  void point(bool reach, const data::Entry& entry, const FrameCheck& frames) {
    PointReport report{entry.name, entry.where, true, "", {}};
    try {
      if (!entry.value.as_joints()) frames.in_world(entry);  // throws if a frame does not exist
      if (!reach || robots_.size() < file_.robots.size()) return;  // nothing is said for an unknown robot
      std::vector<std::pair<std::string, Error>> why;
      for (const auto& robot : robots_) {
        try {
          reached_by(*robot->facts, entry, frames, report);
          why.clear();
          break;
        } catch (const Error& e) {
          why.emplace_back(robot->entry.name, e);
        }
      }
      if (why.size() == 1) throw why.front().second;
      if (!why.empty()) throw reached_by_none(entry.name, why);
    } catch (const Error& e) {
      Problem problem = e.problems().front();
      problem.where = entry.where;
      report.reachable = false;
      report.reason = problem.what;
      if (const int line = frames.handled_in(entry.name); line > 0) {
        problem.severity = Severity::warning;
        problem.what += "; handled in line " + std::to_string(line);
      }
      problems_.add(std::move(problem));
    }
    result_.points.push_back(std::move(report));
  }

  void reached_by(const moves::RobotFacts& robot, const data::Entry& entry, const FrameCheck& frames,
                  PointReport& report) {
    if (const data::JointState* joints = entry.value.as_joints()) {
      report.joints = joints_by_name(*robot.model, *joints, entry.name);
      moves::check_joints(robot, report.joints, entry.name);
    } else if (!frames.is_no_target(entry.name)) {
      pose(robot, entry, frames.meanings(entry), report);
    }
  }

  static Error reached_by_none(const std::string& name, const std::vector<std::pair<std::string, Error>>& why) {
    std::string what = "no robot reaches " + name;
    for (std::size_t i = 0; i < why.size(); ++i)
      what += (i == 0 ? " (" : "; ") + why[i].first + ": " + why[i].second.problems().front().what;
    return {why.front().second.problems().front().code, what + ")",
            why.front().second.problems().front().advice};
  }

  /// At least one of the possible meanings must be within reach; each move is checked later.
  void pose(const moves::RobotFacts& robot, const data::Entry& entry, const std::vector<Pose>& meanings,
            PointReport& report) {
    std::optional<Error> why;
    for (const Pose& target : meanings) {
      try {
        report.joints = joints_to(robot, target, entry.name);
        return;
      } catch (const Error& e) {
        if (!why) why = e;
      }
    }
    if (why) throw *why;
  }

  static std::vector<double> joints_to(const moves::RobotFacts& robot, const Pose& target,
                                       const std::string& name) {
    const double away = norm(target.position - robot.chain.base().position);
    const double reach = robot.model->provenance.reach_m.value_or(robot.chain.reach());
    if (away > robot.chain.reach() + 1e-6)
      throw Error("unreachable",
                  fmt::format("{} is {:.2f} m from the base, this robot reaches {:.2f} m", name, away, reach),
                  away > 10 ? "this looks like millimetres; points are in metres"
                            : "move the point or choose a robot that reaches it");
    return moves::joints_for(robot, target, robot.home, name);
  }

  void together() {
    CellOptions options;
    options.lock_step = true;
    options.no_code = true;
    options.allow_contact = true;  // list all contacts instead of stopping at the first
    options.contact_errors = true;
    options.cycles = options_.cycles;
    options.read = [this](const std::filesystem::path& path) { return take_program(path); };
    const std::filesystem::path scratch =
        options_.state_folder.empty() ? own_folder() : std::filesystem::path();
    options.state_folder = scratch.empty() ? options_.state_folder : scratch / "data";
    rehearse_whole(options);
    if (options_.dry && file_.program.empty() && file_.send.empty())
      result_.notes.push_back("the cell has no program: there is nothing for a dry run");
    else if (options_.dry)
      run_whole(options), note_closed_streams();
    std::error_code ignored;
    if (!scratch.empty()) std::filesystem::remove_all(scratch, ignored);
  }

  /// A temporary state folder: the cell may be running and uses its own .state.
  static std::filesystem::path own_folder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "polyarm-check-XXXXXX").string();
    if (!::mkdtemp(pattern.data())) throw Error("unwritable", "no folder can be made like " + pattern);
    return pattern;
  }

  /// Leaves physics out if nothing depends on it. Controllers are configured for the hardware that they are
  /// written for.
  void rehearse_whole(const CellOptions& options) {
    Listener listener;
    CellFile file = file_;
    for (RobotEntry& robot : file.robots)
      if (file.controllers.empty()) robot.hardware = "mock";
    collect(problems_, [&] {
      Cell cell(file, catalogue_, options, listener);
      if (!file.controllers.empty())
        for (const Problem& problem : listener.problems) problems_.add(problem);
      CellInside& inside = inside_of(cell);
      as_warning([&] {
        for (Problem& problem : contacts_at_rest(inside)) problems_.add(std::move(problem));
      });
      const Rehearsal found = rehearse(inside), of_plc = rehearse_plc(inside);
      for (const Problem& problem : found.problems.list()) problems_.add(problem);
      for (const Problem& problem : of_plc.problems.list()) problems_.add(problem);
      note_omitted(found, "program");
      note_omitted(of_plc, "script of the PLC");
      result_.moves = found.moves;
      result_.reached = found.reached;
    });
  }

  void note_closed_streams() {
    std::string names;
    for (const auto& stream : file_.streams) names += (names.empty() ? "'" : ", '") + stream.name + "'";
    if (!names.empty())
      result_.notes.push_back("streams stay closed in the dry run: what the program waits for from " + names +
                              " does not come");
  }

  void note_omitted(const Rehearsal& found, const std::string& of) {
    if (found.left_out == 0) return;
    result_.notes.push_back(fmt::format(
        "the {} was also checked with {} other values, answers, time-outs and errors; {} more were left out",
        of, found.variants, found.left_out));
  }

  void run_whole(CellOptions options) {
    constexpr std::size_t kMostQuestions = 1000;
    options.answers.assign(kMostQuestions, "");  // an empty answer is Enter, as in the rehearsal
    options.resume_holds = true;
    Listener listener;
    collect(problems_, [&] {
      Cell cell(file_, catalogue_, options, listener);
      listener.problems.clear();  // reported already by the steps before
      RunOptions run_options;
      run_options.fast = true;
      run_options.seconds = 3600;
      std::optional<SweptCheck> swept;
      as_warning([&] { swept.emplace(inside_of(cell)); });
      run_options.each_tick = [&](Nanoseconds now) {
        if (swept) swept->look(now);
        if (options_.progress) options_.progress(seconds(now));
      };
      RunResult run = cell::run(cell, run_options, listener);
      std::vector<Problem> found;
      if (swept) found = swept->finish();
      std::erase_if(found, [&](const Problem& problem) { return is_start_known(problem); });
      std::erase_if(listener.problems, [&](const Problem& problem) {
        return is_told(problem, found) || is_start_known(problem);
      });
      add_stops(inside_of(cell).guards->would_stop(), found, listener.problems);
      for (Problem& problem : found) problems_.add(std::move(problem));
      if (swept) note_clearance(*swept);
      for (const Problem& problem : listener.problems) problems_.add(problem);
      for (const Problem& problem : run.problems) problems_.add(problem);
    });
  }

  /// Robots with more bodies than can be checked are no error of the cell.
  template <class Work>
  void as_warning(const Work& work) {
    try {
      work();
    } catch (const Error& e) {
      Problem problem = e.problems().front();
      problem.severity = Severity::warning;
      problem.what = "contacts are not checked: " + problem.what;
      problems_.add(std::move(problem));
    }
  }

  void note_clearance(const SweptCheck& swept) {
    const auto& nearest = swept.nearest();
    result_.notes.push_back(
        nearest ? "the nearest of the dry run: " + surroundings::text_of(*nearest)
                : fmt::format("every move of the dry run keeps {:g} mm of clearance", 1e3 * file_.clearance));
  }

  static bool is_same_pair(const Problem& a, const Problem& b) {
    const auto named = [](const Problem& p, const char* key) {
      const auto at =
          std::find_if(p.facts.begin(), p.facts.end(), [&](const Fact& fact) { return fact.name == key; });
      return at == p.facts.end() ? std::string() : std::get<std::string>(at->value);
    };
    return (named(a, "a") == named(b, "a") && named(a, "b") == named(b, "b")) ||
           (named(a, "a") == named(b, "b") && named(a, "b") == named(b, "a"));
  }

  /// Where guards would stop a robot: said with what the swept check, or physics, found of the same two
  /// bodies in the line; added to `found` if they found nothing there.
  static void add_stops(const std::vector<Problem>& stops, std::vector<Problem>& found,
                        std::vector<Problem>& of_physics) {
    const std::size_t swept = found.size();
    for (const Problem& stop : stops) {
      bool is_known = false;
      const auto say = [&](Problem& problem) {
        if (problem.where.line != stop.where.line || !is_same_pair(problem, stop)) return;
        problem.what += "; in a run guards stop " + std::get<std::string>(stop.facts[0].value) + " before it";
        problem.severity = stop.severity;  // the run fails there, also where the check alone would warn
        is_known = true;
      };
      for (std::size_t i = 0; i < swept; ++i) say(found[i]);
      for (Problem& problem : of_physics) say(problem);
      if (!is_known) found.push_back(stop);
    }
  }

  /// A contact at the start that was found before the dry run.
  bool is_start_known(const Problem& problem) const {
    return problem.what.find(" where it starts") != std::string::npos &&
           std::any_of(problems_.list().begin(), problems_.list().end(), [&](const Problem& known) {
             return known.code == "start-in-contact" && is_same_pair(problem, known);
           });
  }

  /// A contact of physics that is among those of the swept check: the same two bodies in the same line.
  static bool is_told(const Problem& problem, const std::vector<Problem>& found) {
    if (problem.code != "contact") return false;
    return std::any_of(found.begin(), found.end(), [&](const Problem& other) {
      return other.code == "contact" && other.where.line == problem.where.line &&
             is_same_pair(problem, other);
    });
  }

  /// What is told twice, and warnings of what is an error, too.
  void remove_repeats() {
    std::set<std::string> seen, errors;
    const auto place_and_text = [](const Problem& p) { return p.where.text() + "\n" + p.what; };
    for (const Problem& p : result_.problems)
      if (p.severity == Severity::error) errors.insert(place_and_text(p));
    std::erase_if(result_.problems, [&](const Problem& p) {
      return !seen.insert(p.text()).second ||
             (p.severity == Severity::warning && errors.contains(place_and_text(p)));
    });
  }

  const description::Catalogue& catalogue_;
  const CheckOptions& options_;
  Problems problems_;
  CellFile file_;
  CellRobots robots_;
  description::Scene scene_;
  signals::Signals signals_;
  std::vector<data::DataSet> sets_;
  std::set<std::filesystem::path> taken_;  // files of these sets
  std::map<std::filesystem::path, ReadProgram> read_;
  CheckResult result_;
};

}  // namespace

bool CheckResult::has_errors() const {
  return std::any_of(problems.begin(), problems.end(),
                     [](const Problem& p) { return p.severity == Severity::error; });
}

CheckResult check(const std::function<CellFile()>& open, const description::Catalogue& catalogue,
                  const CheckOptions& options) {
  return Checker(catalogue, options).check(open);
}
CheckResult check(const std::filesystem::path& cell, const Overrides& overrides,
                  const description::Catalogue& catalogue, const CheckOptions& options) {
  return check([&] { return read_cell_file(cell, overrides); }, catalogue, options);
}

}  // namespace polyarm::cell
