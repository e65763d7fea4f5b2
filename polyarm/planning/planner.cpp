#include "polyarm/planning/planner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "polyarm/planning/search.hpp"

namespace polyarm::planning {

namespace {

constexpr std::size_t kQuickSamples = 2000;  // by spheres, before exact shapes are tried
constexpr double kAtLimit = 1e-9;            // rad or m: rounding

/// Why the query cannot be understood; empty: it can.
std::string fault_of(const collision::Checker& checker, const PlanQuery& query, const PlanOptions& options) {
  const std::size_t n = checker.variables();
  if (n == 0) return "the robot has no joint that moves";
  if (query.start.size() != n || query.lower.size() != n || query.upper.size() != n ||
      (!options.weights.empty() && options.weights.size() != n))
    return fmt::format("start, limits and weights need {} values, one for each joint", n);
  if (query.goals.empty()) return "there is no goal";
  if (!(options.range > 0)) return "the range is not positive";
  for (const double w : options.weights)
    if (!(w > 0) || !std::isfinite(w)) return "a weight is not a positive number";
  const auto check = [&](const JointState& q, const std::string& what) -> std::string {
    if (q.size() != n) return fmt::format("{} has {} values, the robot has {} joints", what, q.size(), n);
    for (std::size_t j = 0; j < n; ++j)
      if (!(q[j] >= query.lower[j] - kAtLimit && q[j] <= query.upper[j] + kAtLimit) || !std::isfinite(q[j]))
        return fmt::format("{}: joint {} is at {:g}, its range is {:g} to {:g}", what, j + 1, q[j],
                           query.lower[j], query.upper[j]);
    return {};
  };
  std::string fault = check(query.start, "the start");
  for (std::size_t i = 0; i < query.goals.size() && fault.empty(); ++i)
    fault = check(query.goals[i], query.goals.size() == 1 ? "the goal" : fmt::format("goal {}", i + 1));
  return fault;
}

/// The goals that are free, by spheres and by exact shapes.
struct FreeGoals {
  std::vector<std::size_t> by_spheres, exactly;
};

/// False if the start or all goals touch; says which in `out`.
bool judge_ends(collision::Probe& probe, const PlanQuery& query, FreeGoals& goals, bool& start_by_spheres,
                Plan& out) {
  start_by_spheres = !probe.touches(query.start);
  if (!start_by_spheres && probe.touches_exactly(query.start)) {
    out.outcome = PlanOutcome::start_touches;
    out.contact = probe.nearest(query.start);
    out.reason = "the start collides: " + text_of(out.contact);
    return false;
  }
  for (std::size_t i = 0; i < query.goals.size(); ++i) {
    const bool by_spheres = !probe.touches(query.goals[i]);
    if (by_spheres) goals.by_spheres.push_back(i);
    if (by_spheres || !probe.touches_exactly(query.goals[i])) goals.exactly.push_back(i);
  }
  if (!goals.exactly.empty()) return true;
  out.outcome = PlanOutcome::goal_touches;
  for (std::size_t i = 0; i < query.goals.size(); ++i) {
    const collision::Contact contact = probe.nearest(query.goals[i]);
    if (i == 0 || contact.distance > out.contact.distance) out.contact = contact, out.goal = i;
  }
  out.reason = query.goals.size() == 1 ? "the goal collides: " + text_of(out.contact)
                                       : fmt::format("all {} goals collide, number {} least: {}",
                                                     query.goals.size(), out.goal + 1, text_of(out.contact));
  return false;
}

std::string reason_of(const Plan& plan) {
  if (plan.outcome == PlanOutcome::out_of_time)
    return fmt::format("the time ran out after {} samples; start and goal are free", plan.samples);
  return fmt::format("no way was found with {} samples; start and goal are free", plan.samples);
}

}  // namespace

const char* name(PlanOutcome outcome) {
  constexpr std::array<const char*, 6> kNames = {"found",        "bad-query",      "start-touches",
                                                 "goal-touches", "out-of-samples", "out-of-time"};
  return kNames[static_cast<std::size_t>(outcome)];
}

std::string text_of(const collision::Contact& contact) {
  if (contact.first.empty()) return "nothing is near";
  return contact.distance <= 0
             ? fmt::format("{} is {:.1f} mm inside {}", contact.first, -1000 * contact.distance,
                           contact.second)
             : fmt::format("{} is {:.1f} mm from {}", contact.first, 1000 * contact.distance, contact.second);
}

Plan plan(collision::Probe& probe, const PlanQuery& query, const PlanOptions& options) {
  Plan out;
  out.reason = fault_of(probe.checker(), query, options);
  if (!out.reason.empty()) return out;
  FreeGoals goals;
  bool start_by_spheres = false;
  if (!judge_ends(probe, query, goals, start_by_spheres, out)) return out;
  const bool quick = options.exactness != Exactness::exact && start_by_spheres && !goals.by_spheres.empty();
  out.outcome = PlanOutcome::out_of_samples;
  const auto attempt = [&](bool exact, const std::vector<std::size_t>& which, std::size_t samples) {
    Search search(probe, query, options, exact);
    out.outcome = search.run(which, samples, out);
    out.exact = exact;
    if (out.outcome == PlanOutcome::found) search.shorten(out);
  };
  const bool exact_follows = options.exactness == Exactness::automatic;
  if (quick)
    attempt(false, goals.by_spheres,
            exact_follows ? std::min(kQuickSamples, options.most_samples) : options.most_samples);
  if (out.outcome == PlanOutcome::out_of_samples && options.exactness != Exactness::spheres)
    attempt(true, goals.exactly, options.most_samples);
  if (out.outcome != PlanOutcome::found) out.reason = reason_of(out);
  return out;
}

}  // namespace polyarm::planning
