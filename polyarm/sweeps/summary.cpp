#include "polyarm/sweeps/summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "polyarm/base/text.hpp"
#include "polyarm/sweeps/variants.hpp"

namespace polyarm::sweeps {

namespace {
constexpr double kFar = std::numeric_limits<double>::infinity();

/// True if `a` is at least as good in cycle time and clearance, and better in one of them.
bool dominates(const Row& a, const Row& b) {
  const double cycle_a = *a.cycle_s, cycle_b = *b.cycle_s, near_a = clearance_of(a), near_b = clearance_of(b);
  return cycle_a <= cycle_b && near_a >= near_b && (cycle_a < cycle_b || near_a > near_b);
}

void add_to_front(std::vector<Row>& front, const Row& row) {
  const auto same = [&](const Row& other) {
    return *other.cycle_s == *row.cycle_s && clearance_of(other) == clearance_of(row);
  };
  for (const Row& other : front)
    if (dominates(other, row) || same(other)) return;
  std::erase_if(front, [&](const Row& other) { return dominates(row, other); });
  front.push_back(row);
}
}  // namespace

double clearance_of(const Row& row) {
  return row.clearance_m.value_or(kFar);
}

bool is_better(const Row& a, const Row& b) {
  const double cycle_a = a.cycle_s.value_or(kFar), cycle_b = b.cycle_s.value_or(kFar);
  if (cycle_a != cycle_b) return cycle_a < cycle_b;
  if (clearance_of(a) != clearance_of(b)) return clearance_of(a) > clearance_of(b);
  return a.key < b.key;
}

void Share::add(const Row& row) {
  ++ran;
  if (!row.completed()) {
    ++codes[row.code.empty() ? row.ended : row.code];
    return;
  }
  const double cycle = row.cycle_s.value_or(0), near = clearance_of(row);
  cycle_best = completed == 0 ? cycle : std::min(cycle_best, cycle);
  clearance_least = completed == 0 ? near : std::min(clearance_least, near);
  cycle_sum += cycle;
  ++completed;
}

std::string Share::main_code() const {
  const auto most = std::max_element(codes.begin(), codes.end(),
                                     [](const auto& a, const auto& b) { return a.second < b.second; });
  return most == codes.end() ? std::string() : most->first;
}

void Summary::add(const Row& row) {
  total_.add(row);
  wall_s_ += row.wall_s.value_or(0);
  crashed_ += row.ended == "crashed";
  for (const auto& [axis, value] : axis_values(row)) axes_[axis][value].add(row);
  if (row.x_m || row.y_m) {
    const auto [at, is_new] = maps_[row.robot].insert({{row.x_m.value_or(0), row.y_m.value_or(0)}, row});
    if (!is_new && row.completed() && (!at->second.completed() || is_better(row, at->second)))
      at->second = row;
  }
  if (!row.completed()) {
    examples_.insert({row.code.empty() ? row.ended : row.code, row});
    return;
  }
  if (!row.cycle_s) return;
  add_to_front(fronts_[row.robot], row);
  const auto [own, first] = best_of_robot_.insert({row.robot, row});
  if (!first && is_better(row, own->second)) own->second = row;
  best_.insert(std::upper_bound(best_.begin(), best_.end(), row, is_better), row);
  if (best_.size() > most_) best_.pop_back();
}

std::vector<Row> Summary::pareto() const {
  std::vector<Row> out;
  for (const auto& [robot, front] : fronts_)
    for (const Row& row : front) add_to_front(out, row);
  std::sort(out.begin(), out.end(), is_better);
  return out;
}

std::string place_of(const Row& row) {
  return text_of(Place{row.x_m, row.y_m, row.z_m, row.yaw_rad});
}

std::vector<std::pair<std::string, std::string>> axis_values(const Row& row) {
  return {{"robot", row.robot.empty() ? "as in the cell" : row.robot},
          {"base", place_of(row)},
          {"program", row.program.empty() ? "as in the cell" : row.program},
          {"speed", fmt::format("{:g} %", 100 * row.speed.value_or(1))},
          {"fault", row.fault.empty() ? "none" : row.fault},
          {"seed", format_number(row.seed.value_or(1))},
          {"values", row.given.empty() ? "as in the cell" : row.given}};
}

std::string why_worse(const Row& row, const Row& best) {
  std::vector<std::string> out;
  if (row.cycle_s && best.cycle_s && *best.cycle_s > 0) {
    const double slower = 100 * (*row.cycle_s / *best.cycle_s - 1);
    out.push_back(slower < 0.05 ? "as fast" : fmt::format("{:.1f} % slower", slower));
  }
  if (clearance_of(row) < clearance_of(best)) out.push_back("nearer to " + row.clearance_b);
  if (row.speed_share && *row.speed_share > 0.99 && (!best.speed_share || *best.speed_share <= 0.99))
    out.push_back("at the speed limit of " + row.speed_joint);
  if (row.effort_share && *row.effort_share > 0.95 && (!best.effort_share || *best.effort_share <= 0.95))
    out.push_back("at the torque limit of " + row.effort_joint);
  std::vector<std::string> other;
  const auto own = axis_values(row), its = axis_values(best);
  for (std::size_t i = 0; i < own.size(); ++i)
    if (own[i].second != its[i].second) other.push_back(own[i].first);
  std::string text = join(out, ", ");
  if (!other.empty()) text += " (other " + join(other, ", ") + ")";
  return text;
}

std::string title_of(const Row& row) {
  std::vector<std::string> out;
  if (!row.robot.empty()) out.push_back(row.robot);
  if (row.x_m || row.y_m || row.z_m || row.yaw_rad) out.push_back("base " + place_of(row));
  if (!row.program.empty()) out.push_back(row.program);
  if (row.speed && *row.speed != 1) out.push_back(fmt::format("{:g} %", 100 * *row.speed));
  if (!row.fault.empty()) out.push_back(row.fault);
  if (!row.given.empty()) out.push_back(row.given);
  return out.empty() ? "the cell as it is" : join(out, ", ");
}

}  // namespace polyarm::sweeps
