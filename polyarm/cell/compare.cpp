#include "polyarm/cell/compare.hpp"

#include <algorithm>
#include <cmath>

#include "polyarm/cell/cell.hpp"
#include "polyarm/inside/inside.hpp"
#include "polyarm/kinematics/singularity.hpp"

namespace polyarm::cell {

namespace {

/// Records each robot's distance to joint limits and singularities, once per tick.
class Closeness {
 public:
  explicit Closeness(const CellInside& cell)
      : cell_(cell), places_(cell.setup.robots, cell.machine.table()) {}

  void look(RobotVerdict& out) {
    const std::vector<double> at = places_.commanded(cell_.machine.snapshot());
    const Location where = cell_.programs->program() ? cell_.programs->program()->status().where : Location{};
    std::vector<double> q;
    for (std::size_t robot = 0, next = 0; robot < cell_.setup.robots.size(); ++robot) {
      const CellRobot& r = *cell_.setup.robots[robot];
      q.clear();
      for (std::size_t j = 0; j < r.joints.size(); ++j, ++next) {
        q.push_back(at[next]);
        const double near = std::min(at[next] - r.joints[j].lower, r.joints[j].upper - at[next]);
        if (!r.joints[j].continuous && std::isfinite(near)) take(out.limit, {near, r.joints[j].name, where});
      }
      if (q.size() >= 6 && q != looked_at_[robot])
        take(out.singularity, {kinematics::smallest_singular_value(r.facts->chain, q), "", where});
      looked_at_[robot] = q;
    }
  }

 private:
  static void take(std::optional<Nearest>& best, const Nearest& now) {
    if (!best || now.value < best->value) best = now;
  }

  const CellInside& cell_;
  JointPlaces places_;
  std::vector<std::vector<double>> looked_at_ = std::vector<std::vector<double>>(cell_.setup.robots.size());
};

class Quiet : public Observer {};

/// Runs a cell that has a program, and fills in the verdict.
void run_cell(CellInside& cell, double limit_s, RobotVerdict& out) {
  control::ControlLoop& loop = cell.machine.loop();
  Closeness closeness(cell);
  std::vector<double> passes;      // end time of each pass, s
  std::optional<double> ended_at;  // end time of the program, s
  loop.begin();
  Nanoseconds next_tick = 0;
  while (!cell.life->finished() && !cell.life->failure() && seconds(loop.cycle().time) < limit_s) {
    if (loop.cycle().time >= next_tick) {
      next_tick = loop.cycle().time + Cell::kTick;
      cell.tick(loop.cycle().time);
      closeness.look(out);
      const Task& program = *cell.programs->program();
      if (program.status().passes > passes.size()) passes.push_back(seconds(loop.cycle().time));
      if (!ended_at && program.ended()) ended_at = seconds(loop.cycle().time);
    }
    loop.step_next();
  }
  loop.end();
  out.time_s = seconds(loop.cycle().time);
  out.cycles = passes.size();
  if (passes.size() > 1)
    out.cycle_s = (passes.back() - passes.front()) / static_cast<double>(passes.size() - 1);
  else if (passes.size() == 1 || ended_at)
    out.cycle_s = passes.empty() ? *ended_at : passes.front();
  if (passes.empty() && ended_at) out.cycles = 1;
  const Task* const program = cell.programs->program();
  if (cell.life->failure()) {
    out.problem = cell.life->failure()->problem;
    if (out.problem->where.file.empty() && program) out.problem->where = program->status().where;
  } else if (!cell.life->finished()) {
    out.problem = Problem{"too-long", program ? program->status().where : Location{},
                          "the program has not ended in time", "allow more with --seconds"};
  }
}

}  // namespace

RobotVerdict try_robot(const std::filesystem::path& path, const description::Catalogue& catalogue,
                       const CompareOptions& options) {
  RobotVerdict out;
  out.robot = options.overrides.robot;
  try {
    const CellFile file = read_cell_file(path, options.overrides);
    CellOptions cell_options;
    cell_options.lock_step = true;
    cell_options.cycles = options.cycles;
    cell_options.state_folder = options.state_folder;
    Quiet quiet;
    Cell whole(file, catalogue, cell_options, quiet);
    CellInside& cell = inside_of(whole);
    if (!cell.programs->program())
      throw Error("no-program", "the cell has no program", "name one with --program");
    run_cell(cell, options.seconds, out);
    if (!out.problem && !cell.watches->group_faults().empty())
      out.problem = cell.watches->group_faults().front();
    for (const std::string& part : cell.parts->failures(true))
      if (!out.problem) out.problem = Problem{"part", {}, part, {}};
  } catch (const Error& e) {
    const auto is_error = [](const Problem& p) { return p.severity == Severity::error; };
    const auto first = std::find_if(e.problems().begin(), e.problems().end(), is_error);
    out.problem = first == e.problems().end() ? Problem{"failed", {}, e.what(), {}} : *first;
  }
  out.runs = !out.problem;
  return out;
}

}  // namespace polyarm::cell
