#include "polyarm/sweeps/measures.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "polyarm/cell/cell.hpp"
#include "polyarm/sweeps/run_variant.hpp"

namespace polyarm::sweeps {

namespace {
constexpr double kTick = static_cast<double>(cell::Cell::kTick) * 1e-9;

int index_of(const std::optional<std::size_t>& state) {
  return state ? static_cast<int>(*state) : -1;
}

std::optional<double> value_at(const std::vector<double>& states, int index) {
  if (index < 0 || static_cast<std::size_t>(index) >= states.size()) return std::nullopt;
  const double value = states[static_cast<std::size_t>(index)];
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

template <class Better, class Extreme>
void take(std::optional<Extreme>& best, double value, const std::string& joint, Better better) {
  if (std::isfinite(value) && (!best || better(value, best->value))) best = Extreme{value, joint};
}
}  // namespace

Measures::Measures(const cell::CellInside& cell) : cell_(cell) {
  const hardware::InterfaceTable& table = cell.machine.table();
  for (const auto& robot : cell.setup.robots)
    for (const controllers::JointFacts& joint : robot->joints)
      joints_.push_back({joint.name, joint.continuous, joint.lower, joint.upper, joint.velocity, joint.effort,
                         index_of(table.find_state(joint.name + "/effort")),
                         index_of(table.find_state(joint.name + "/velocity"))});
}

void Measures::look(Nanoseconds now) {
  look_at_joints(cell_.machine.snapshot());
  look_at_passes(now);
  const std::span<const Vec3> tcps = cell_.motions->tcps();
  for (std::size_t i = 0; i < tcps.size() && i < tcps_.size(); ++i) path_ += norm(tcps[i] - tcps_[i]);
  tcps_.assign(tcps.begin(), tcps.end());
}

void Measures::look_at_joints(const control::Snapshot& snapshot) {
  cell_.machine.joint_places().commanded(snapshot, now_);
  for (std::size_t i = 0; i < joints_.size() && i < now_.size(); ++i) {
    const Joint& joint = joints_[i];
    if (i < before_.size())
      take(speed_, std::abs(now_[i] - before_[i]) / kTick / joint.speed, joint.name, std::greater<>());
    if (!joint.continuous)
      take(limit_, std::min(now_[i] - joint.lower, joint.upper - now_[i]), joint.name, std::less<>());
    const auto effort = value_at(snapshot.states, joint.effort_state),
               velocity = value_at(snapshot.states, joint.velocity_state);
    if (effort && joint.effort < controllers::kUnlimited)
      take(effort_, std::abs(*effort) / joint.effort, joint.name, std::greater<>());
    if (effort && velocity) energy_ = energy_.value_or(0) + std::abs(*effort * *velocity) * kTick;
  }
  std::swap(before_, now_);
}

void Measures::look_at_passes(Nanoseconds now) {
  const cell::Task* const program = cell_.programs->program();
  if (!program) return;
  if (program->status().passes > passes_.size()) passes_.push_back(seconds(now));
  if (!ended_at_ && program->ended()) ended_at_ = seconds(now);
}

void Measures::put_into(Row& row) const {
  std::vector<double> times;  // of the passes after the first, which begins elsewhere than the others
  for (std::size_t i = 1; i < passes_.size(); ++i) times.push_back(passes_[i] - passes_[i - 1]);
  if (times.empty() && !passes_.empty()) times = {passes_.front()};
  if (times.empty() && ended_at_) times = {*ended_at_};
  if (!times.empty()) {
    double sum = 0;
    for (const double time : times) sum += time;
    row.cycle_s = sum / static_cast<double>(times.size());
    row.cycle_p95_s = percentile(times, 0.95);
  }
  row.cycles = static_cast<double>(passes_.empty() && ended_at_ ? 1 : passes_.size());
  row.path_m = path_;
  row.energy_j = energy_;
  const auto put = [](const std::optional<Extreme>& from, std::optional<double>& value, std::string& joint) {
    if (!from) return;
    value = from->value;
    joint = from->joint;
  };
  put(speed_, row.speed_share, row.speed_joint);
  put(effort_, row.effort_share, row.effort_joint);
  put(limit_, row.limit_m_rad, row.limit_joint);
}

std::size_t points_out_of_reach(const cell::CellInside& cell, std::size_t robot) {
  const moves::RobotFacts* const facts = cell.setup.robots[robot]->facts.get();
  if (!facts) return 0;
  std::size_t out = 0;
  for (const std::string& name : cell.data.store.names()) {
    const data::Value* const value = cell.data.store.find(name);
    const data::Point* const point = value ? value->as_point() : nullptr;
    if (!point || !point->frame().empty()) continue;
    try {
      moves::joints_for(*facts, point->pose, facts->home, name);
    } catch (const Error&) {
      ++out;
    }
  }
  return out;
}

}  // namespace polyarm::sweeps
