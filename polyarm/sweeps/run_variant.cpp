#include "polyarm/sweeps/run_variant.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "polyarm/base/text.hpp"
#include "polyarm/cell/cell.hpp"
#include "polyarm/cell/run.hpp"
#include "polyarm/cell/swept_check.hpp"
#include "polyarm/inside/inside.hpp"
#include "polyarm/io/typed_words.hpp"
#include "polyarm/sweeps/measures.hpp"
#include "polyarm/sweeps/names.hpp"
#include "polyarm/sweeps/variants.hpp"

namespace polyarm::sweeps {

namespace {

namespace fs = std::filesystem;

class Quiet : public cell::Observer {};

void put_base(cell::RobotEntry& robot, const Sweep& sweep, const Variant& variant, Deviations& random) {
  const Place& place = variant.place;
  Vec3& at = robot.base.position;
  at = {place.x.value_or(at.x), place.y.value_or(at.y), place.z.value_or(at.z)};
  const double x = random.next(), y = random.next(), turn = random.next();
  at.x += sweep.vary.base * x, at.y += sweep.vary.base * y;
  if (!place.yaw && sweep.vary.yaw == 0) return;
  const Vec3 rpy = to_rpy(robot.base.rotation);
  robot.base.rotation = from_rpy(rpy.x, rpy.y, place.yaw.value_or(rpy.z) + sweep.vary.yaw * turn);
}

void put_values(cell::CellInside& cell, const Sweep& sweep, const Variant& variant, Deviations& random) {
  data::DataStore& store = cell.data.store;
  const auto require = [&](const std::string& name) -> const data::Value& {
    if (const data::Value* value = store.find(name)) return *value;
    throw Error("unknown-name", "the cell has no '" + name + "'" + did_you_mean(name, store.names()),
                "tags and variables of the cell's files");
  };
  for (const auto& [name, text] : variant.values)
    store.set(name, value_of(text, require(name), name), "sweep");
  for (const auto& [name, deviation] : sweep.vary.points) {
    const data::Point* const point = require(name).as_point();
    if (!point) throw Error("bad-value", "'" + name + "' is no point and cannot vary");
    data::Point moved = *point;
    const double x = random.next(), y = random.next(), z = random.next();
    moved.pose.position = moved.pose.position + deviation * Vec3{x, y, z};
    store.set(name, moved, "sweep");
  }
}

/// Orders the steps of a fault when their time has come. Cell thread.
class FaultOrders {
 public:
  FaultOrders(cell::CellInside& cell, const Fault& fault) : cell_(cell) {
    for (const FaultStep& step : fault.steps) {
      orders_.push_back({step.at_s, [this, &step] { begin(step); }});
      if (step.for_s) orders_.push_back({step.at_s + *step.for_s, [this, &step] { end(step); }});
    }
    std::stable_sort(orders_.begin(), orders_.end(),
                     [](const Order& a, const Order& b) { return a.at_s < b.at_s; });
  }
  void look(double now_s) {
    for (; next_ < orders_.size() && orders_[next_].at_s <= now_s; ++next_) orders_[next_].act();
  }

 private:
  struct Order {
    double at_s;
    std::function<void()> act;
  };

  void begin(const FaultStep& step) {
    for (const auto& [name, value] : step.force) cell_.machine.hardware().force(name, value);
    if (step.emergency_stop) cell_.machine.supervisor().latch().request(realtime::StopKind::immediate);
    if (step.person == "stop")
      cell_.programs->stop_all();
    else if (const auto request = cell::typed_request(step.person))
      cell_.requests.ask(*request, [](const protocol::Reply&) { return true; });  // a refusal changes nothing
  }
  void end(const FaultStep& step) {
    for (const auto& [name, value] : step.force)
      cell_.machine.hardware().force(name, std::numeric_limits<double>::quiet_NaN());
  }

  cell::CellInside& cell_;
  std::vector<Order> orders_;
  std::size_t next_ = 0;
};

/// "cell.yaml:3", relative to the cell, so that the row is the same in every folder.
std::string place_text(const Location& where, const fs::path& folder) {
  if (where.file.empty()) return {};
  const fs::path file = fs::path(where.file).lexically_relative(folder);
  const std::string name = file.empty() || *file.begin() == ".." ? fs::path(where.file).filename().string()
                                                                 : file.generic_string();
  return where.line > 0 ? fmt::format("{}:{}", name, where.line) : name;
}

/// The same for sentences that name files of the cell.
std::string without_folder(std::string text, const fs::path& folder) {
  const std::string prefix = folder.string() + "/";
  for (auto at = text.find(prefix); at != std::string::npos; at = text.find(prefix, at))
    text.erase(at, prefix.size());
  return text;
}

void put_problem(Row& row, const Problem& problem, const fs::path& folder) {
  row.ended = "failed";
  row.code = problem.code;
  row.cause = without_folder(problem.what, folder);
  row.place = place_text(problem.where, folder);
}

/// An approach as the problems of the swept check tell it.
struct Near {
  std::string a, b;
  double distance = 0, at_s = 0;  ///< m, negative: overlap; s
  Location where;
};

Near near_of(const Problem& problem) {
  Near out;
  out.where = problem.where;
  for (const Fact& fact : problem.facts) {
    const double* const number = std::get_if<double>(&fact.value);
    if (fact.name == "a") out.a = std::get<std::string>(fact.value);
    if (fact.name == "b") out.b = std::get<std::string>(fact.value);
    if (fact.name == "distance_m") out.distance = *number;
    if (fact.name == "depth_m") out.distance = -*number;
    if (fact.name == "at_s") out.at_s = *number;
  }
  constexpr double kResolution = 1e-4;  // that of the check
  out.distance = std::round(out.distance / kResolution) * kResolution;
  return out;
}

/// A tool, its fingers or a held part near to what is no robot: work needs that.
bool is_at_work(const Near& near) {
  const std::string body = near.a.substr(near.a.find('/') + 1);
  return (body == "tool" || body == "fingers" || body.starts_with("part ")) &&
         near.b.find('/') == std::string::npos;
}

void put_clearance(Row& row, cell::SweptCheck& swept, const Sweep& sweep, const fs::path& folder) {
  const std::vector<Problem> found = swept.finish();
  std::optional<Near> nearest;
  for (const Problem& problem : found) {
    const Near near = near_of(problem);
    if (is_at_work(near))
      row.tool_clearance_m = std::min(row.tool_clearance_m.value_or(near.distance), near.distance);
    else if (!nearest || near.distance < nearest->distance)
      nearest = near;
  }
  if (nearest) {
    row.clearance_m = nearest->distance;
    row.clearance_a = nearest->a;
    row.clearance_b = nearest->b;
    row.clearance_at_s = nearest->at_s;
    row.clearance_place = place_text(nearest->where, folder);
  }
  if (!row.completed()) return;
  const auto contact = std::find_if(found.begin(), found.end(),
                                    [](const Problem& p) { return p.severity == Severity::error; });
  if (contact != found.end()) return put_problem(row, *contact, folder);
  if (nearest && nearest->distance < sweep.least_clearance)
    put_problem(row,
                {"clearance",
                 nearest->where,
                 fmt::format("{} comes within {:.1f} mm of {}; {:g} mm are required", nearest->a,
                             1e3 * nearest->distance, nearest->b, 1e3 * sweep.least_clearance),
                 {}},
                folder);
}

void put_result(Row& row, const cell::RunResult& result, bool finished, const fs::path& folder) {
  row.time_s = result.sim_time_s;
  row.trace = result.trace_hash;
  row.parts = static_cast<double>(
      std::count_if(result.parts.begin(), result.parts.end(),
                    [](const cell::PartReport& part) { return part.fate == cell::PartFate::placed; }));
  row.ended = result.outcome == cell::Outcome::stopped ? "stopped" : finished ? "completed" : "time-up";
  if (!result.problems.empty()) put_problem(row, result.problems.front(), folder);
  if (row.ended == "time-up") row.code = "too-long", row.cause = "the program has not ended in time";
}

cell::CellOptions options_of(const Sweep& sweep, const fs::path& state_folder) {
  constexpr std::size_t kMostQuestions = 1000;
  cell::CellOptions out;
  out.lock_step = true;
  out.cycles = sweep.cycles;
  out.state_folder = state_folder;
  out.answers.assign(kMostQuestions, "");  // an empty answer is Enter
  out.resume_holds = true;
  return out;
}

void run_cell(const Sweep& sweep, const Variant& variant, const description::Catalogue& catalogue,
              const fs::path& state_folder, Row& row) {
  Deviations random(variant.seed);
  cell::CellFile file = cell::read_cell_file(sweep.cell, overrides_of(sweep, variant.robot, variant.program));
  const std::size_t robot = index_of_robot(sweep, file);
  put_base(file.robots[robot], sweep, variant, random);
  Quiet quiet;
  cell::Cell whole(file, catalogue, options_of(sweep, state_folder), quiet);
  cell::CellInside& inside = cell::inside_of(whole);
  if (!inside.programs->program())
    throw Error("no-program", "the cell has no program", "name one: programs: [my_program]");
  put_values(inside, sweep, variant, random);
  row.out_of_reach = static_cast<double>(points_out_of_reach(inside, robot));
  if (variant.speed < 1) inside.machine.supervisor().set_override(variant.speed);
  std::optional<cell::SweptCheck> swept;
  if (sweep.clearance > 0) swept.emplace(inside, sweep.clearance);
  Measures measures(inside);
  FaultOrders faults(inside, *variant.fault);
  cell::RunOptions run;
  run.fast = true;
  run.seconds = sweep.seconds;
  run.socket = run.console = false;
  faults.look(0);
  run.each_tick = [&](Nanoseconds now) {
    faults.look(seconds(now));
    measures.look(now);
    if (swept) swept->look(now);
  };
  const cell::RunResult result = cell::run(whole, run, quiet);
  put_result(row, result, inside.life->finished(), file.folder);
  measures.put_into(row);
  if (swept) put_clearance(row, *swept, sweep, file.folder);
}

}  // namespace

Row run_variant(const Sweep& sweep, const Variant& variant, const std::string& key,
                const description::Catalogue& catalogue, const fs::path& state_folder) {
  Row row = row_of(variant, key);
  try {
    run_cell(sweep, variant, catalogue, state_folder, row);
  } catch (const Error& e) {
    const auto is_error = [](const Problem& p) { return p.severity == Severity::error; };
    const auto first = std::find_if(e.problems().begin(), e.problems().end(), is_error);
    std::error_code ignored;
    const fs::path folder = fs::is_directory(sweep.cell, ignored) ? sweep.cell : sweep.cell.parent_path();
    put_problem(row, first == e.problems().end() ? Problem{"failed", {}, e.what(), {}} : *first, folder);
  }
  return row;
}

Row crashed_row(const Variant& variant, const std::string& key, const std::string& why) {
  Row row = row_of(variant, key);
  row.ended = row.code = "crashed";
  row.cause = why;
  return row;
}

double percentile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const double rank = std::ceil(share * static_cast<double>(values.size()));
  return values[static_cast<std::size_t>(std::max(1.0, rank)) - 1];
}

}  // namespace polyarm::sweeps
