#include "apps/new_cell.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "apps/new_cell_tour.hpp"
#include "apps/options.hpp"
#include "apps/scratch.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/reach.hpp"
#include "polyarm/cell/check.hpp"
#include "polyarm/hardware/driver_loader.hpp"
#include "polyarm/moves/move_plan.hpp"
#include "polyarm/setup/robots.hpp"

namespace polyarm::apps {

namespace {

namespace fs = std::filesystem;

constexpr int kParts = 3;

/// Layout of the cell: metres, world frame, robot at the origin. Values are rounded to millimetres, as a
/// person would write them.
struct Layout {
  double distance = 0.4;  ///< of feeder and tray from the robot's axis
  double table = 0;       ///< height of the table's top
  double yaw = 0;         ///< of the tool, rad
  double angle = 0.5;     ///< feeder to the left, tray to the right, rad from x
  double lift = 0.1;      ///< height above a position before and after it
  /// The tool's yaw counts from the direction in which the point lies, seen from the pivot. For arms whose
  /// tool does not turn.
  bool facing = false;
  double pivot_x = 0, pivot_y = 0;  ///< where the first axis stands

  double x() const { return round(distance * std::cos(angle)); }
  double y() const { return round(distance * std::sin(angle)); }
  static double round(double metres) { return std::round(1000 * metres) / 1000 + 0.0; }
};

/// Sizes that fit the robot.
struct Sizes {
  double reach = 0.5, tool = 0.1, tool_mass = 0.15, part = 0.04, part_mass = 0.05, pitch = 0.06;
};

Sizes sizes_of(const description::RobotModel& model, double reach) {
  Sizes out;
  out.reach = reach;
  out.tool = std::clamp(Layout::round(0.2 * reach), 0.05, 0.3);
  out.part = std::clamp(std::round(20 * reach) * 0.002, 0.02, 0.08);
  out.part = Layout::round(out.part);
  const double payload = model.provenance.payload_kg.value_or(0.5);
  out.tool_mass = std::clamp(0.3 * payload, 0.03, 1.5);
  out.part_mass = std::min(std::pow(out.part, 3) * 800, 0.4 * payload);
  out.pitch = Layout::round(1.5 * out.part);
  return out;
}

Pose down(const Layout& l, double x, double y, double z) {
  const double way = l.facing ? std::atan2(y - l.pivot_y, x - l.pivot_x) : 0;
  return {{x, y, z}, from_rpy(std::numbers::pi, 0, l.yaw + way)};
}

/// A pose of the program; the list is in program order.
struct Point {
  const char* name;
  Pose pose;
};
std::vector<Point> points_of(const Layout& l, const Sizes& s) {
  const double x = l.x(), y = l.y(), top = l.table + s.part, above = Layout::round(top + l.lift);
  const double gap = 0.005;  // height above the tray at which a part is released
  return {{"Above", down(l, Layout::round(l.distance), 0, above)},
          {"PrePick", down(l, x, y, above)},
          {"Pick", down(l, x, y, top)},
          {"PrePlace", down(l, x, -y, above)},
          {"Place", down(l, x, -y, Layout::round(top + gap))}};
}

/// The program's moves, one pass for each part.
std::vector<moves::Move> moves_of(const Layout& layout, const std::vector<Point>& points,
                                  const Sizes& sizes) {
  using moves::MoveKind;
  std::vector<moves::Move> out;
  const auto go = [&](MoveKind kind, std::size_t point, double y) {
    moves::Move move;
    move.kind = kind;
    move.speed = 0.5;
    const Vec3 at = points[point].pose.position;
    move.targets.push_back({down(layout, at.x, at.y + y, at.z), points[point].name});
    out.push_back(std::move(move));
  };
  go(MoveKind::joint, 0, 0);
  for (int n = 0; n < kParts; ++n) {
    go(MoveKind::joint, 1, 0), go(MoveKind::line, 2, 0), go(MoveKind::line, 1, 0);
    const double along = n * sizes.pitch;
    go(MoveKind::joint, 3, along), go(MoveKind::line, 4, along), go(MoveKind::line, 3, along);
  }
  go(MoveKind::joint, 0, 0);
  return out;
}

std::string metres(double value) {
  return fmt::format("{:.4g}", Layout::round(value));
}

std::string at(double x, double y, double z) {
  return fmt::format("[{}, {}, {}]", metres(x), metres(y), metres(z));
}

std::string millimetres(double value) {
  return fmt::format("{:.0f}mm", 1000 * value);
}

// --- the files

std::string cell_yaml(const NewCell& asked, const std::string& hardware) {
  return fmt::format(
      "polyarm: cell/1\n"
      "# A robot takes parts from a feeder and puts them into a tray.\n"
      "robots:\n"
      "  arm: {{model: {}, hardware: {}, tool: tool}}   # the tool is described in tool.yaml\n"
      "scene: scene.yaml        # the surroundings of the robot\n"
      "signals: signals.yaml    # names for inputs and outputs\n"
      "program: main.script\n",
      asked.robot, hardware);
}

std::string scene_yaml(const Layout& l, const Sizes& s) {
  const double depth = std::max(0.5 * l.distance, 6 * s.part), width = 2 * (l.y() + 3 * s.part);
  const double tray_y = -l.y() + s.pitch * (kParts - 1) / 2;
  const std::string tray_size = fmt::format(
      "[{}, {}, {}]", metres(3 * s.part), metres(s.pitch * (kParts - 1) + 2.5 * s.part), metres(2 * s.part));
  std::string out = fmt::format(
      "polyarm: scene/1\n"
      "# World frame: the robot's base is at the origin. Numbers without a unit are in metres.\n"
      "floor: {{height: {}}}\n"
      "fixtures:\n"
      "  table: {{box: [{}, {}, 0.04], at: {}}}\n"
      "bins:\n"
      "  tray: {{at: {}, inner: {}, walls: false}}\n"
      "feeders:\n"
      "  feeder: {{at: {}}}          # where parts appear: their centre\n"
      "parts:                                       # weigh yours: gripping depends on the mass\n",
      metres(std::min(l.table - 0.1, -0.6 * s.reach)), metres(depth), metres(width),
      at(l.x(), 0, l.table - 0.02), at(l.x(), tray_y, l.table), tray_size,
      at(l.x(), l.y(), l.table + s.part / 2));
  const std::string edge = millimetres(s.part);
  for (int n = 0; n < kParts; ++n)
    out += fmt::format(
        "  part_{}: {{kind: part, box: [{}, {}, {}], mass: {:.3g}kg, feeder: feeder, goal: {{at: {}, bin: "
        "tray}}}}\n",
        n + 1, edge, edge, edge, s.part_mass, at(l.x(), -l.y() + n * s.pitch, l.table + s.part / 2));
  return out;
}

std::string tool_yaml(const Sizes& s) {
  const double k = s.tool / 0.1;
  return fmt::format(
      "polyarm: tool/1\n"
      "# A suction cup. tcp: the centre of its lip, in the frame of the flange; z points out of the tool.\n"
      "tcp: [0, 0, {}]\n"
      "mass: {:.3g}kg\n"
      "center: [0, 0, {}]\n"
      "gripper: suction\n"
      "cup_radius: {:.4g}mm\n"
      "body:                    # it must not touch anything\n"
      "  - {{cylinder: {{radius: {:.4g}mm, height: {}}}, at: [0, 0, {}]}}\n"
      "  - {{cylinder: {{radius: {:.4g}mm, height: {}}}, at: [0, 0, {}]}}\n",
      metres(s.tool), s.tool_mass, metres(0.4 * s.tool), 225 * s.part, std::min(25 * k, 40.0),
      metres(0.2 * s.tool), metres(0.1 * s.tool), std::min(12 * k, 300 * s.part),
      metres(0.8 * s.tool - 0.004), metres(0.6 * s.tool - 0.002));
}

constexpr const char* kSignals =
    "polyarm: signals/1\n"
    "tags:\n"
    "  Vacuum: {command: arm/tool/vacuum}\n"
    "  PartHeld: {state: arm/tool/part_present}                    # the sensor in the cup\n"
    "  Feed: {command: scene/feeder/feed, type: number}            # the number of parts to bring, in "
    "all\n"
    "  PartReady: {state: scene/feeder/present}                    # a part is at the feeder\n"
    "  PartsReady: {state: scene/feeder/count, type: number}       # the number of parts there\n"
    "  PartsLeft: {state: scene/feeder/remaining, type: number}    # the number of parts left\n"
    "  PartsFed: {state: scene/feeder/presented, type: number}     # the number of parts brought\n";

/// A function of the program; see Layout::facing.
std::string facing(const Layout& l) {
  const std::string turned = l.yaw == 0 ? "" : fmt::format(" + {:.0f}deg", l.yaw * 180 / std::numbers::pi);
  const auto from = [](const char* name, double pivot) {
    if (std::abs(pivot) < 1e-6) return std::string(name);
    return fmt::format("{} {} {:.6g}mm", name, pivot < 0 ? '+' : '-', 1000 * std::abs(pivot));
  };
  return "# The tool of this robot does not turn by itself: it faces the way in which the point lies.\n"
         "func facing(p)\n"
         "  return p with rz = atan2(" +
         from("p.y", l.pivot_y) + ", " + from("p.x", l.pivot_x) + ")" + turned + "\nend\n";
}

std::string script(const Layout& l, const Sizes& s) {
  const auto shifted = [&](const std::string& point) {
    return l.facing ? "facing(offset(" + point + ", y = y))" : "offset(" + point + ", y = y)";
  };
  const std::string before = shifted("PrePlace"), place = shifted("Place");
  return fmt::format(
      "# Takes each part from the feeder and puts it into the tray, one beside the other.\n"
      "load points\n"
      "let parts = {}\n"
      "let pitch = {}\n"
      "{}"
      "use speed 50%\n"
      "movej Above\n"
      "for n in 1 .. parts\n"
      "  set Feed = n\n"
      "  wait PartReady timeout 5s\n"
      "  movej PrePick\n"
      "  movel Pick\n"
      "  set Vacuum = true\n"
      "  wait PartHeld timeout 3s\n"
      "  movel PrePick\n"
      "  let y = (n - 1) * pitch\n"
      "  movej {}\n"
      "  movel {}\n"
      "  set Vacuum = false\n"
      "  wait not PartHeld timeout 3s\n"
      "  movel {}\n"
      "end\n"
      "movej Above\n"
      "log(\"{{parts}} parts are in the tray\")\n",
      kParts, millimetres(s.pitch), l.facing ? facing(l) : "", before, place, before);
}

constexpr const char* kTests =
    "# polyarm test .\n"
    "test \"every part goes from the feeder into the tray\"\n"
    "  run\n"
    "  expect PartHeld timeout 120s\n"
    "  expect program.state == \"finished\" timeout 300s\n"
    "  expect PartsLeft == 0\n"
    "  expect not PartHeld and not Vacuum\n"
    "end\n";

std::string points_file(const std::vector<Point>& points) {
  std::string out =
      "# Poses of the TCP in the world: x, y, z in metres, roll, pitch, yaw in radians. The tool points "
      "down.\n"
      "Pose: RPY\n";
  for (const Point& point : points) {
    const Vec3 p = point.pose.position, rpy = to_rpy(point.pose.rotation);
    out += fmt::format("\nName: {}\nPoint: {}, {}, {}, {:.6f}, {:.6f}, {:.6f}\n", point.name, metres(p.x),
                       metres(p.y), metres(p.z), rpy.x + 0.0, rpy.y + 0.0, rpy.z + 0.0);
  }
  return out;
}

std::string readme(const NewCell& asked) {
  return fmt::format(
      "# {}\n\n"
      "{} takes parts from a feeder and puts them into a tray. Everything is simulated.\n\n"
      "| file | content |\n|---|---|\n"
      "| `cell.yaml` | which robot, tool and program |\n"
      "{}"
      "| `scene.yaml` | table, feeder, tray and parts |\n"
      "| `tool.yaml` | the suction cup: its TCP, mass and body |\n"
      "| `signals.yaml` | names for inputs and outputs; `PartReady`: a part is at the feeder, "
      "`PartsReady`: how many, `PartsFed`: how many it has brought |\n"
      "| `points.points` | the poses that the program moves to |\n"
      "| `main.script` | the program |\n"
      "| `tests.script` | a test of the program |\n\n"
      "```\n"
      "polyarm check .              # all files, and every move along its path\n"
      "polyarm check . --dry        # the same, and a simulated run: contacts, final places of parts\n"
      "polyarm run . --fast         # as fast as the machine allows\n"
      "polyarm run . --pendant        # with the pendant in a browser\n"
      "polyarm test .\n"
      "polyarm run . --robot universal_robots/ur10e --fast    # another robot\n"
      "```\n\n"
      "Next: put your own table and parts into `scene.yaml`, teach the points (`polyarm console .`, or the "
      "pendant), and change the program.\n",
      asked.name, asked.robot,
      asked.robot_files.empty() ? ""
                                : "| `robot` | its description, SRDF and meshes, copied from elsewhere |\n");
}

std::string hardware_of_simulation() {
  return hardware::driver_available("mujoco") ? "mujoco" : "mock";
}

Files pick_files(const NewCell& asked, const Layout& layout, const Sizes& sizes) {
  Files out = {{"cell.yaml", cell_yaml(asked, hardware_of_simulation())},
               {"scene.yaml", scene_yaml(layout, sizes)},
               {"tool.yaml", tool_yaml(sizes)},
               {"signals.yaml", kSignals},
               {"points.points", points_file(points_of(layout, sizes))},
               {"main.script", script(layout, sizes)},
               {"tests.script", kTests},
               {"README.md", readme(asked)}};
  out.insert(asked.robot_files.begin(), asked.robot_files.end());
  return out;
}

void write_files(const fs::path& folder, const Files& files) {
  for (const auto& [name, text] : files) {
    std::error_code error;
    fs::create_directories((folder / name).parent_path(), error);
    write_file_atomically(folder / name, text);
  }
}

/// Leaves nothing behind if a file cannot be written, so that another attempt finds no half of a cell.
void write_new_files(const fs::path& folder, const Files& files) {
  std::error_code error;
  const bool was_there = fs::exists(folder, error);
  fs::create_directories(folder, error);
  if (error)
    throw Error("unwritable", "the folder " + folder.string() + " cannot be created: " + error.message(),
                "choose a place where you may write with --folder DIR");
  try {
    write_files(folder, files);
  } catch (const Error&) {
    for (const auto& entry : fs::directory_iterator(folder, error)) fs::remove_all(entry.path(), error);
    if (!was_there) fs::remove(folder, error);
    throw;
  }
}

// --- finding a layout

cell::CellRobots robot_with_tool(const NewCell& asked, const fs::path& folder, const Sizes& sizes) {
  write_file_atomically(folder / "tool.yaml", tool_yaml(sizes));
  cell::CellFile file;
  file.folder = folder;
  cell::RobotEntry entry;
  entry.name = "arm", entry.tool = "tool", entry.hardware = "mock";
  entry.model = asked.robot_files.empty() ? asked.robot : (folder / asked.robot).string();
  file.robots.push_back(entry);
  Problems problems;
  std::vector<std::string> notes;
  cell::CellRobots out = cell::resolve_robots(file, open_catalogue(), false, problems, notes);
  problems.throw_if_errors();
  return out;
}

/// Layouts to try, the most usual ones first; then those around `home`, the pose of the TCP where the robot
/// starts.
std::vector<Layout> layouts(const Sizes& sizes, const Pose& home, const Vec3& pivot) {
  std::vector<Layout> out;
  const double reach = sizes.reach;
  Layout l;
  l.lift = std::clamp(Layout::round(0.12 * reach), 0.03, 0.2);
  l.pivot_x = pivot.x;
  l.pivot_y = pivot.y;
  for (const bool facing : {false, true})
    for (const double angle : {0.5, 0.35})
      for (const double table : {0.0, 0.15, -0.15, 0.3, -0.3})
        for (const double distance : {0.6, 0.5, 0.7, 0.4, 0.8})
          for (const int quarter : {0, 2, 1, 3}) {
            l.distance = Layout::round(distance * reach);
            l.table = Layout::round(table * reach);
            l.yaw = quarter * std::numbers::pi / 2;
            l.angle = angle;
            l.facing = facing;
            out.push_back(l);
          }
  const Vec3 tcp = home.position;
  const double turn = to_rpy(home.rotation).z - std::atan2(tcp.y - pivot.y, tcp.x - pivot.x);
  l.yaw =
      std::round(turn * 180 / std::numbers::pi) * std::numbers::pi / 180;  // whole degrees, as in the program
  l.facing = true;
  for (const double lift : {l.lift, 0.02})
    for (const double angle : {0.35, 0.2})
      for (const double below : {1.0, 0.5, 1.5, 0.0, 2.0})
        for (const double distance : {1.0, 0.9, 1.1, 0.8, 1.2, 0.7, 1.3}) {
          l.lift = lift;
          l.angle = angle;
          l.distance = Layout::round(distance * std::hypot(tcp.x, tcp.y));
          l.table = Layout::round(tcp.z - below * lift - sizes.part - lift);
          out.push_back(l);
        }
  return out;
}

bool can_move(const moves::RobotFacts& robot, const std::vector<double>& from, const Layout& layout,
              const Sizes& sizes) {
  try {
    const std::vector<Point> points = points_of(layout, sizes);
    for (const Point& point : points) moves::joints_for(robot, point.pose, from, point.name);
    moves::plan_moves(robot, from, moves_of(layout, points, sizes));
    return true;
  } catch (const Error&) {
    return false;
  }
}

/// The layouts that the robot can reach, in the order in which they are tried: the usual ones first. After
/// some of them had problems, those come first that resemble them least.
class LayoutsToTry {
 public:
  LayoutsToTry(const cell::CellRobot& robot, const Sizes& sizes)
      : robot_(robot),
        sizes_(sizes),
        untried_(layouts(sizes, robot.facts->chain.forward(robot.start), pivot_of(robot))) {}

  /// The next candidate; empty after the last one.
  std::optional<Layout> next() {
    while (!untried_.empty()) {
      const auto found =
          tried_.size() < kUsual
              ? untried_.begin()
              : std::ranges::min_element(untried_, {}, [this](const Layout& l) { return resemblance(l); });
      const Layout layout = *found;
      untried_.erase(found);
      if (!can_move(*robot_.facts, robot_.start, layout, sizes_)) continue;
      tried_.push_back(layout);
      return layout;
    }
    return std::nullopt;
  }

 private:
  static constexpr std::size_t kUsual = 8;

  /// Where the first axis meets the ground, if it is vertical; else the origin.
  static Vec3 pivot_of(const cell::CellRobot& robot) {
    const auto axes = robot.facts->chain.axes();
    const bool vertical = !axes.empty() && !axes.front().slides && std::abs(axes.front().direction.z) > 0.999;
    return vertical ? axes.front().point : Vec3{};
  }
  std::size_t resemblance(const Layout& layout) const {
    std::size_t out = 0;
    for (const Layout& other : tried_)
      out += (layout.table == other.table) + (layout.distance == other.distance) + (layout.yaw == other.yaw);
    return out;
  }

  const cell::CellRobot& robot_;
  Sizes sizes_;
  std::vector<Layout> untried_;
  std::vector<Layout> tried_;
};

/// The problems that `check` and `check --dry` find, including contacts.
std::vector<Problem> found_in(const fs::path& folder) {
  const description::Catalogue catalogue = open_catalogue();
  const Scratch state("new");
  std::vector<Problem> out;
  for (const bool dry : {false, true}) {
    cell::CheckOptions options;
    options.dry = dry;
    options.state_folder = state.path() / "data";
    const cell::CheckResult result = cell::check(folder, {}, catalogue, options);
    for (const Problem& problem : result.problems)
      if (problem.severity == Severity::error || problem.code == "contact") out.push_back(problem);
    if (!out.empty()) break;
  }
  return out;
}

/// The path of a file in `from`, moved to `to`.
std::string in_folder(const std::string& file, const fs::path& from, const fs::path& to) {
  const std::string prefix = from.string() + "/";
  return file.starts_with(prefix) ? (to / file.substr(prefix.size())).string() : file;
}

/// A cell to write, and what is wrong with it.
struct Found {
  Files files;
  std::vector<Problem> problems;
  bool reached = false;  ///< the robot reaches all points of a layout
};

/// Writes `files` into an empty folder of `scratch`, and checks them. Problems name the files in `folder`.
std::vector<Problem> problems_of(const Files& files, const Scratch& scratch, const fs::path& folder) {
  const fs::path place = scratch.path() / "try";
  std::error_code error;
  fs::remove_all(place, error);
  fs::create_directories(place, error);
  write_files(place, files);
  std::vector<Problem> out = found_in(place);
  for (Problem& problem : out) problem.where.file = in_folder(problem.where.file, place, folder);
  return out;
}

/// The layout with the fewest problems.
Found find_layout(const NewCell& asked, const cell::CellRobot& robot, const Sizes& sizes,
                  const Scratch& scratch) {
  constexpr int kMostTried = 24;
  LayoutsToTry to_try(robot, sizes);
  Found best;
  for (int tried = 0; tried < kMostTried; ++tried) {
    const std::optional<Layout> layout = to_try.next();
    if (!layout) break;
    Found found{pick_files(asked, *layout, sizes), {}, true};
    found.problems = problems_of(found.files, scratch, asked.folder);
    if (!best.reached || found.problems.size() < best.problems.size()) best = std::move(found);
    if (best.problems.empty()) break;
  }
  return best;
}

/// Why there is no feeder and no tray, as a sentence.
std::string reason_of(const Found& layout, const cell::CellRobot& robot) {
  if (layout.reached)
    return "Every place for feeder and tray that was tried has a problem, such as: " +
           layout.problems.front().what + ".";
  const std::size_t axes = robot.facts->chain.joints();
  return "There are no feeder and no tray: no place was found where the tool of this robot points straight "
         "down, both at a part and above it" +
         (axes < 6 ? fmt::format(" (it has {} axes)", axes) : std::string()) + ".";
}

/// A program that moves the joints; smaller moves if larger ones have problems.
Found find_tour(const NewCell& asked, const cell::CellRobot& robot, const std::string& why,
                const Scratch& scratch) {
  Found out;
  for (const double size : {1.0, 0.4, 0.1}) {
    out.files = tour_files(asked, robot, hardware_of_simulation(), why, size);
    out.files.insert(asked.robot_files.begin(), asked.robot_files.end());
    out.problems = problems_of(out.files, scratch, asked.folder);
    if (out.problems.empty()) break;
  }
  return out;
}

void print_next(const fs::path& folder) {
  fmt::print("Next:\n  cd {}\n  polyarm run . --fast\n  polyarm run . --pendant\n  polyarm test .\n",
             folder.string());
}

int write_tour(const NewCell& asked, const cell::CellRobot& robot, const Found& layout,
               const Scratch& scratch) {
  const std::string why = reason_of(layout, robot);
  const Found tour = find_tour(asked, robot, why, scratch);
  write_new_files(asked.folder, tour.files);
  fmt::print("The cell '{}' is in {}: {}, and a program that moves between three places.\n{}\n", asked.name,
             asked.folder.string(), asked.robot, why);
  if (!tour.problems.empty()) {
    fmt::print("Correct these:\n");
    for (const Problem& problem : tour.problems) fmt::print("  {}\n", problem.text());
    return kFailed;
  }
  fmt::print("Checked, and run once in simulation. ");
  print_next(asked.folder);
  return kOk;
}

}  // namespace

int write_new_cell(const NewCell& given) {
  NewCell asked = given;
  std::error_code error;
  const fs::path& folder = asked.folder;
  if (fs::exists(folder, error) && !(fs::is_directory(folder, error) && fs::is_empty(folder, error)))
    throw Error("exists", folder.string() + " exists already, nothing was written",
                "choose another folder with --folder DIR, or another name");
  const Scratch scratch("new");
  const std::shared_ptr<ReachGrant> grant = reach().grant();
  grant->allow(scratch.path());  // it is written again after a cell in it was opened
  if (fs::is_regular_file(asked.robot, error)) {
    CopiedRobot copied = copy_of_robot(asked.robot);
    asked.robot = std::move(copied.model), asked.robot_files = std::move(copied.files);
    write_files(scratch.path(), asked.robot_files);
  }
  Sizes sizes;
  sizes = sizes_of(robot_with_tool(asked, scratch.path(), sizes).front()->model,
                   robot_with_tool(asked, scratch.path(), sizes).front()->facts->chain.reach());
  const cell::CellRobots robots = robot_with_tool(asked, scratch.path(), sizes);
  const cell::CellRobot& robot = *robots.front();
  if (robot.facts->chain.joints() < 3 || !(sizes.reach > 0.05))
    throw Error("no-arm", "'" + given.robot + "' has no arm that could take parts",
                "name an arm: polyarm robots");

  const Found found = find_layout(asked, robot, sizes, scratch);
  if (!asked.robot_files.empty())
    fmt::print("{} is a copy of {}.\n", (folder / asked.robot).string(), given.robot);
  if (!found.reached || !found.problems.empty()) return write_tour(asked, robot, found, scratch);
  write_new_files(folder, found.files);
  fmt::print(
      "The cell '{}' is in {}: {}, table, suction cup, feeder, tray and {} parts.\n"
      "Checked, and run once in simulation: every part comes into the tray. ",
      asked.name, folder.string(), asked.robot, kParts);
  print_next(folder);
  return kOk;
}

}  // namespace polyarm::apps
