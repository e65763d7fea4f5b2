#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <memory>

#include "apps/options.hpp"
#include "apps/plan_around.hpp"
#include "apps/plan_motion.hpp"
#include "apps/plan_moves.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/data/file_lookup.hpp"
#include "polyarm/description/scene_file.hpp"
#include "polyarm/language/parser.hpp"
#include "polyarm/moves/cartesian_joints.hpp"
#include "polyarm/moves/tcp_rates.hpp"
#include "polyarm/ros_files/trajectory_file.hpp"
#include "polyarm/setup/robots.hpp"
#include "polyarm/yaml/yaml.hpp"
#include "polyarm/yaml/yaml_repeats.hpp"

namespace polyarm::apps {

namespace {

namespace fs = std::filesystem;
using trajectory::MotionLimits;

struct Request {
  std::string robot, of, tool = "none";
  std::vector<std::string> words, data;
  std::vector<std::string> from;  ///< a position, or one number per joint
  PaceWords pace;
  bool keep_times = false, lines = false, ros1 = false, as_json = false;
  std::string svg, csv;
  std::vector<std::string> exports;
  double rate = 0, tolerance = 1e-6;
  bool around = false;
  std::string scene, clearance;
  unsigned seed = 1;
  double seconds = 5;

  void add_to(CommandLine& app);
  /// Returns words to the moves that the parser took as more values of --from.
  void part();
};

void Request::part() {
  auto rest = from.begin();
  if (rest != from.end() && !parse_number(*rest))
    ++rest;
  else
    rest = std::find_if(rest, from.end(), [](const std::string& word) { return !parse_number(word); });
  words.insert(words.end(), rest, from.end());
  from.erase(rest, from.end());
}

void Request::add_to(CommandLine& app) {
  app.add_option(
      "what", words,
      "[CELL or ROBOT], then a JointTrajectory file (YAML or JSON) or moves: movej P, movel P, movec VIA P, "
      "spline P Q …; P: a name of the cell's points, joints(…), pose(x,y,z[,r,p,y]), by(x,y,z), "
      "tool(x,y,z), home; behind a move blend=, speed=, acceleration=, duration= for it alone");
  app.add_option("--robot", robot, "catalogue name or description; with a cell in place of its robot");
  app.add_option("--of", of, "the robot, if a cell has several");
  app.add_option("--tool", tool, "tool, if there is no cell");
  app.add_option("--data", data, "data file with more points; may be repeated")->existing_file();
  app.add_option("--from", from, "where to start, home by default: a place like P, or joint values, rad or m")
      ->expected(-1);
  app.add_option("--blend", pace.blend,
                 "how far around points the path may leave its lines: 20mm; for files also rad");
  app.add_option("--speed", pace.speed, "50% of the limits, or at most 250mm/s at the TCP");
  app.add_option("--acceleration", pace.acceleration, "50% of the limits, or at most 1m/s2 at the TCP");
  app.add_flag("--keep-times", keep_times, "check the file's trajectory with its own times");
  app.add_flag("--lines", lines, "straight between the file's points in joint space, not a spline");
  app.add_option("--svg", svg, "plot position, velocity, acceleration, jerk and TCP speed");
  app.add_option("--csv", csv, "write them as a table, at --rate (250 Hz)");
  app.add_option("--export", exports, "write a JointTrajectory, FILE.yaml or FILE.json; may be repeated");
  app.add_option("--rate", rate, "Hz of --csv and --export; without it an export has the fewest points")
      ->positive();
  app.add_option("--tolerance", tolerance, "tolerance of an export without --rate, rad or m")->positive();
  app.add_flag("--around", around, "movej goes around the robot itself, the scene and its floor");
  app.add_option("--scene", scene, "scene file: what the robot must not touch; without it that of the cell")
      ->existing_file();
  app.add_option("--clearance", clearance, "distance to keep from the scene: 10mm");
  app.add_option("--seed", seed, "seed of the search of --around; the same seed gives the same path");
  app.add_option("--time", seconds, "time limit of --around, s for each move (5)")->positive();
  app.add_flag("--ros1", ros1, "exports have secs and nsecs");
  app.add_flag("--json", as_json, "one JSON object");
}

/// True for a cell file, recognised by its contents, because its name is free.
bool is_cell_file(const std::string& word) {
  std::error_code error;
  if (!fs::is_regular_file(word, error)) return false;
  try {
    return load_with_repeats(word)["polyarm"].text("").starts_with("cell/");
  } catch (const Error&) {  // the reader of the file reports the error
    return false;
  }
}

bool is_trajectory_file(const std::string& word) {
  const std::string ending = lower(fs::path(word).extension().string());
  return (ending == ".yaml" || ending == ".yml" || ending == ".json") && !is_cell_file(word);
}

/// The robot of the plan, and the named positions.
struct Setting {
  cell::CellFile file;
  cell::CellRobots robots;
  cell::CellRobot* robot = nullptr;
  std::vector<data::DataSet> sets;

  const moves::RobotFacts& facts() const { return *robot->facts; }
  const kinematics::Chain& chain() const { return robot->facts->chain; }
};

void read_points(Setting& setting, const std::string& name, const fs::path& folder, const Location& where) {
  const data::LoadedFiles files = data::load_files(name, folder, where);
  setting.sets.push_back(files.data.values());
  for (const data::ImportFile& points : files.points) setting.sets.push_back(points.values());
}

/// Reads what the cell's program loads: the `load` lines of a script, or the data file that names the script.
void read_points_of_program(Setting& setting) {
  const cell::CellFile& file = setting.file;
  if (file.program.empty()) return;
  const fs::path path = data::find_file(file.program, file.folder, file.program_where);
  if (path.extension() != ".script")
    return read_points(setting, file.program, file.folder, file.program_where);
  Problems ignored;  // `check` reports problems of the program
  const program::Program program = program::parse(read_file(path), path.string(), ignored);
  for (const program::Statement* load : program::loads(program))
    read_points(setting, load->name, file.folder, program.at(load->name_place));
}

cell::CellRobot* chosen(const Setting& setting, const std::string& of) {
  std::vector<std::string> names;
  for (const auto& robot : setting.robots) {
    names.push_back(robot->entry.name);
    if (robot->entry.name == of || (of.empty() && setting.robots.size() == 1)) return robot.get();
  }
  throw Error("unknown-name",
              of.empty() ? "this cell has several robots"
                         : "the cell has no robot '" + of + "'" + did_you_mean(of, names),
              "use --of " + join(names, " or --of "));
}

/// True for a robot instead of a cell: a catalogue name or a description file.
bool is_robot(const std::string& word, const description::Catalogue& catalogue) {
  const std::string ending = lower(fs::path(word).extension().string());
  return ending == ".urdf" || ending == ".xacro" || (!fs::exists(word) && catalogue.find(word).has_value());
}

Setting settle(Request& request, Problems& problems) {
  Setting out;
  if (request.robot.empty() && is_robot(request.words[0], open_catalogue())) {
    request.robot = request.words[0];
    request.words.erase(request.words.begin());
    if (request.words.empty()) return out;
  }
  if (fs::exists(request.words[0]) && !is_trajectory_file(request.words[0])) {
    cell::Overrides overrides;
    overrides.robot = request.robot;
    out.file = cell::read_cell_file(request.words[0], overrides);
    request.words.erase(request.words.begin());
  } else if (!request.robot.empty()) {
    out.file.folder = fs::current_path();
    cell::RobotEntry entry;
    entry.model = request.robot, entry.tool = request.tool;
    out.file.robots.push_back(entry);
  } else {
    const bool move = parse_number(request.words[0]) || is_move_word(request.words[0]) ||
                      is_trajectory_file(request.words[0]);
    throw WrongUse("no-robot",
                   move ? "no robot is named"
                        : "'" + request.words[0] + "' is neither a cell nor a robot" +
                              did_you_mean(request.words[0], open_catalogue().names()),
                   "begin with the folder of a cell, or with a robot such as universal_robots/ur5e");
  }
  std::vector<std::string> notes;
  out.robots = cell::resolve_robots(out.file, open_catalogue(), false, problems, notes);
  problems.throw_if_errors();
  Problems faults;
  cell::add_hardware_faults(out.robots, Severity::warning, faults);
  for (const Problem& fault : faults.list()) fmt::print(stderr, "{}\n", fault.text());
  out.robot = chosen(out, request.of);
  read_points_of_program(out);
  for (const std::string& file : request.data)
    read_points(out, fs::path(file).filename().string(), fs::absolute(file).parent_path(), {});
  return out;
}

std::vector<double> start_of(const Request& request, const Setting& setting) {
  const kinematics::Chain& chain = setting.chain();
  const std::vector<double>& home = setting.facts().home;
  if (request.from.empty()) return home;
  if (!parse_number(request.from[0])) {
    const NamedPlaces places{setting.facts(), setting.sets};
    const auto there = parse_moves({"movej", request.from[0]}, places, home, {});
    return plan_moves(setting.facts(), home, there).end;
  }
  std::vector<double> out;
  for (const std::string& word : request.from) out.push_back(parse_number(word).value());
  if (out.size() != chain.joints())
    throw Error("bad-value",
                fmt::format("--from takes a place, or {} numbers for this robot ({}), here are {}",
                            chain.joints(), join(chain.names(), " "), out.size()));
  moves::check_joints(setting.facts(), out, "--from");
  return out;
}

void describe_joints(PlannedMotion& motion, const kinematics::Chain& chain,
                     const std::vector<MotionLimits>& limits) {
  for (std::size_t j = 0; j < chain.joints(); ++j)
    motion.joints.push_back(
        {chain.names()[j], chain.slides(j), limits[j], chain.lower()[j], chain.upper()[j]});
}

// --- from a file ----------------------------------------------------------------------------------------

std::vector<MotionLimits> limits_of(const Setting& setting, const PaceValue& speed,
                                    const PaceValue& acceleration) {
  std::vector<MotionLimits> out;
  for (std::size_t j = 0; j < setting.chain().joints(); ++j) {
    const trajectory::JointMotionLimits& l = setting.facts().limits[j];
    double v = l.velocity * speed.share;
    if (speed.angular > 0 && !setting.chain().slides(j)) v = std::min(v, speed.angular);
    out.push_back(
        MotionLimits::symmetric(v, l.acceleration * acceleration.share, l.jerk * acceleration.share));
  }
  return out;
}

/// Corner radius: metres at the TCP with a unit of length, otherwise in the joint norm.
double radius_of(const std::string& text, bool& metres) {
  metres = false;
  if (text.empty()) return 0;
  if (const auto angle = parse_quantity(text, Dimension::angle)) return *angle;
  if (const auto length = parse_quantity(text, Dimension::length)) return metres = true, *length;
  throw Error("bad-value", "--blend is '" + text + "', which is not a radius",
              "write 20mm at the TCP, or 0.1 rad");
}

paths::PathSections path_of(const ros_files::JointTrajectoryFile& file, const Request& request,
                            const Setting& setting) {
  bool metres = false;
  const double radius = radius_of(request.pace.blend, metres);
  auto points = ros_files::as_waypoints(file, radius);
  if (const bool given = !request.from.empty(); given || points.size() == 1)  // one point needs a start
    points.insert(points.begin(), {start_of(request, setting), radius, given ? "--from" : "home"});
  paths::JointPathOptions options;
  if (metres) options.tcp_distance = moves::tcp_distance(setting.chain());
  for (const paths::JointWaypoint& p : points) moves::check_joints(setting.facts(), p.q, p.name);
  return request.lines || radius > 0 ? joint_lines(points, options) : joint_spline(points, options);
}

void plan_section(PlannedMotion& motion, const Setting& setting, std::unique_ptr<const paths::Path> section,
                  const std::vector<MotionLimits>& limits, double tcp_speed, double tcp_acceleration) {
  const std::shared_ptr<const paths::Path> path = std::move(section);
  const moves::TcpPath tcp(setting.chain(), path, moves::TcpPart::translation);
  std::vector<timing::NormLimit> norms;
  if (tcp_speed > 0 || tcp_acceleration > 0)
    norms.push_back({&tcp, tcp_speed > 0 ? tcp_speed : INFINITY,
                     tcp_acceleration > 0 ? tcp_acceleration : INFINITY, INFINITY, "the TCP"});
  timing::TimingOptions options;
  options.norms = norms;
  const timing::Timing timing = time_path(*path, limits, options);
  std::vector<std::string> bounds;
  for (const timing::NormLimit& norm : norms) bounds.push_back(norm.name);
  add_section(motion, fmt::format("section {}", motion.sections.size() + 1),
              std::make_shared<timing::TimedPath>(path, timing.profile), timing.active, bounds);
}

PlannedMotion from_file(const Request& request, const Setting& setting, Problems& problems) {
  if (request.words.size() != 1)
    throw Error("bad-value", fmt::format("'{}' follows a trajectory file", request.words[1]),
                "one file, or moves");
  const kinematics::Chain& chain = setting.chain();
  ros_files::JointTrajectoryFile file = ros_files::read_trajectory_file(request.words[0]);
  const std::vector<double> start = start_of(request, setting);
  order_joints(file, chain.names(), start, problems);
  const PaceValue speed = parse_speed(request.pace.speed, "--speed");
  const PaceValue acceleration = parse_acceleration(request.pace.acceleration, "--acceleration");
  const std::vector<MotionLimits> limits = limits_of(setting, speed, acceleration);
  PlannedMotion out;
  out.title =
      fmt::format("{} along {}", setting.robot->model.name, fs::path(request.words[0]).filename().string());
  describe_joints(out, chain, limits);
  if (speed.tcp > 0) out.tcp_speed_limit = speed.tcp;
  if (request.keep_times) {
    std::vector<double> times;
    for (const auto& point : file.message.points) times.push_back(point.time_from_start);
    std::vector<bool> continuous;
    for (const controllers::JointFacts& joint : setting.robot->joints) continuous.push_back(joint.continuous);
    take_trajectory(out, chain, as_timed(file, start, continuous), times);
    return out;
  }
  paths::PathSections path = path_of(file, request, setting);
  for (Problem& warning : path.warnings) problems.add(std::move(warning));
  for (auto& section : path.sections)
    plan_section(out, setting, std::move(section), limits, speed.tcp, acceleration.tcp);
  finish(out, chain);
  return out;
}

// --- from moves -----------------------------------------------------------------------------------------

PlannedMotion from_moves(const Request& request, const Setting& setting, Problems& problems) {
  const kinematics::Chain& chain = setting.chain();
  const std::vector<double> start = start_of(request, setting);
  const NamedPlaces places{setting.facts(), setting.sets};
  const std::vector<moves::Move> moves = parse_moves(request.words, places, start, request.pace);
  moves::MovePlan plan;
  try {
    plan = plan_moves(setting.facts(), start, moves);
  } catch (const moves::MoveError& e) {
    std::vector<Problem> all = e.problems();
    for (Problem& p : all)
      p.what = fmt::format("move {}, {}: {}", e.move + 1, text_of(moves[e.move]), p.what);
    throw Error(std::move(all));
  }
  if (plan.motions.empty())
    throw Error("no-motion", "these moves end where they begin", "name another target");
  PlannedMotion out;
  out.title =
      fmt::format("{}, {} move{}", setting.robot->model.name, moves.size(), moves.size() == 1 ? "" : "s");
  describe_joints(out, chain, plan.limits);
  const double tcp = parse_speed(request.pace.speed, "--speed").tcp;
  if (tcp > 0) out.tcp_speed_limit = tcp;
  for (moves::PlannedMotion& m : plan.motions) {
    std::string name = text_of(moves[m.first]);
    if (m.last > m.first)
      name = fmt::format("moves {} to {}, {} … {}", m.first + 1, m.last + 1, name, text_of(moves[m.last]));
    else
      name = fmt::format("move {}, {}", m.first + 1, name);
    add_section(out, name, std::make_shared<timing::TimedPath>(std::move(m.path)), m.active, m.bounds);
  }
  for (moves::MovePlan::Warning& warning : plan.warnings) {
    warning.problem.what =
        fmt::format("move {}, {}: {}", warning.move + 1, text_of(moves[warning.move]), warning.problem.what);
    problems.add(std::move(warning.problem));
  }
  finish(out, chain);
  return out;
}

// --- around obstacles -----------------------------------------------------------------------------------

/// A cell has its own scene.
bool looks_around(const Request& request, const Setting& setting) {
  return request.around || !request.scene.empty() || !setting.file.scene.empty();
}

PlanAround surroundings_of(const Request& request, const Setting& setting, Problems& problems) {
  description::Scene scene;
  scene.floor = false;
  if (!request.scene.empty()) {
    scene = description::read_scene(request.scene, problems);
  } else if (!setting.file.scene.empty()) {
    scene = description::read_scene(
        data::find_file(setting.file.scene, setting.file.folder, setting.file.scene_where).string(),
        problems);
  }
  double clearance = 0;
  if (!request.clearance.empty()) {
    const auto given = parse_quantity(request.clearance, Dimension::length);
    if (!given || *given < 0)
      throw Error("bad-value", "--clearance is '" + request.clearance + "', which is not a distance",
                  "write 10mm");
    clearance = *given;
  }
  return PlanAround(setting.robots, *setting.robot, scene, clearance, problems);
}

PlannedMotion from_moves_around(const Request& request, const Setting& setting, PlanAround& surroundings) {
  const kinematics::Chain& chain = setting.chain();
  const std::vector<double> start = start_of(request, setting);
  const NamedPlaces places{setting.facts(), setting.sets};
  const std::vector<moves::Move> moves = parse_moves(request.words, places, start, request.pace);
  const PaceValue speed = parse_speed(request.pace.speed, "--speed");
  const PaceValue acceleration = parse_acceleration(request.pace.acceleration, "--acceleration");
  const std::vector<MotionLimits> limits = limits_of(setting, speed, acceleration);
  PlannedMotion out;
  out.title = fmt::format("{}, {} move{} around obstacles", setting.robot->model.name, moves.size(),
                          moves.size() == 1 ? "" : "s");
  describe_joints(out, chain, limits);
  if (speed.tcp > 0) out.tcp_speed_limit = speed.tcp;
  for (PlanAround::Way& way : surroundings.around(start, moves, request.seed, request.seconds))
    for (auto& section : way.path.sections) {
      plan_section(out, setting, std::move(section), limits, speed.tcp, acceleration.tcp);
      out.sections.back().name = way.name;
    }
  finish(out, chain);
  return out;
}

PlannedMotion planned(const Request& request, const Setting& setting, Problems& problems) {
  const bool file = is_trajectory_file(request.words[0]);
  if (!looks_around(request, setting))
    return file ? from_file(request, setting, problems) : from_moves(request, setting, problems);
  if (file && request.around)
    throw Error("bad-value", "--around plans moves, not a trajectory file", "name moves: movej Pick");
  PlanAround surroundings = surroundings_of(request, setting, problems);
  PlannedMotion out = request.around ? from_moves_around(request, setting, surroundings)
                      : file         ? from_file(request, setting, problems)
                                     : from_moves(request, setting, problems);
  surroundings.measure(out);
  return out;
}

// --- output ---------------------------------------------------------------------------------------------

controllers::TrajectoryMessage message_of(const PlannedMotion& motion, const Request& request) {
  std::vector<std::string> names;
  for (const PlanJoint& joint : motion.joints) names.push_back(joint.name);
  controllers::TrajectoryMessage out;
  for (const auto& timed : motion.timed)
    ros_files::append(out, request.rate > 0 ? ros_files::sampled(*timed, request.rate, names)
                                            : ros_files::knots_of(*timed, request.tolerance, names));
  return out;
}

void write_files(const PlannedMotion& motion, const Request& request) {
  if (!request.svg.empty()) write_file_atomically(request.svg, svg_of(motion));
  if (!request.csv.empty())
    write_file_atomically(request.csv, csv_of(motion, request.rate > 0 ? request.rate : 250));
  for (const std::string& path : request.exports) {
    if (motion.timed.empty())
      throw Error("bad-value", "--keep-times plans nothing that could be exported", "leave --keep-times out");
    const std::string ending = lower(fs::path(path).extension().string());
    if (ending != ".json" && ending != ".yaml" && ending != ".yml")
      throw Error("bad-value", "'" + path + "' is neither .yaml nor .json", "name the file so");
    const auto words = request.ros1 ? ros_files::TimeWords::ros1 : ros_files::TimeWords::ros2;
    const auto message = message_of(motion, request);
    write_file_atomically(path, ending == ".json" ? to_json(message, words) : to_yaml(message, words));
  }
}

int show(const PlannedMotion& motion, const Request& request) {
  write_files(motion, request);
  if (request.as_json) {
    fmt::print("{}\n", json_of(motion));
  } else {
    fmt::print("{}", report_of(motion));
    for (const Problem& problem : motion.problems) fmt::print("{}\n", problem.text());
  }
  return motion.has_errors() ? kFailed : kOk;
}

}  // namespace

int run_plan(int argc, char** argv) {
  CommandLine app("Plans a motion without moving: its duration, the limits that determine it, and a plot",
                  "polyarm plan");
  Request request;
  request.add_to(app);
  app.footer(
      examples(
          {"polyarm plan --robot universal_robots/ur5e trajectory.yaml --svg plan.svg",
           "polyarm plan --robot universal_robots/ur5e trajectory.yaml --keep-times",
           "polyarm plan --robot universal_robots/ur5e trajectory.yaml --blend 20mm --export faster.yaml",
           "polyarm plan --robot universal_robots/ur5e movej 'joints(0,-90deg,90deg,-90deg,-90deg,0)' "
           "movel 'by(0,0,-200mm)' movel 'by(200mm,0,0)' --blend 20mm --speed 250mm/s",
           "polyarm plan examples/pick_and_place movel Pick movel Place --blend 20mm",
           "polyarm plan universal_robots/ur5e movej 'pose(0.4,0.3,0.3)' --around --scene scene.yaml"}) +
      "\nExit codes: 0 planned and within limits, 1 not, 2 wrong command line\n");
  if (const auto code = app.parse(argc, argv)) return *code;
  request.part();
  const auto require_words = [&] {
    if (request.words.empty())
      throw WrongUse("bad-move", "there is nothing to plan", "name moves: movel Pick movel Place");
  };
  Problems problems;
  try {
    require_words();
    Setting setting = settle(request, problems);
    require_words();
    PlannedMotion motion = planned(request, setting, problems);
    motion.problems.insert(motion.problems.begin(), problems.list().begin(), problems.list().end());
    return show(motion, request);
  } catch (const Error& e) {
    if (!request.as_json) {
      if (!problems.has_errors())  // otherwise they are part of the error
        for (const Problem& warning : problems.list()) fmt::print(stderr, "{}\n", warning.text());
      throw;
    }
    PlannedMotion none;
    none.problems = e.problems();
    fmt::print("{}\n", json_of(none));
    return kFailed;
  }
}

}  // namespace polyarm::apps
