/// Previews a planned path before the robot follows it.
#include "polyarm/inside/requests_work.hpp"
#include "polyarm/operation/way_planning.hpp"
#include "polyarm/requests/families.hpp"

namespace polyarm::cell {

namespace {

using namespace protocol;

PlanPreview::Answer preview_of(const moves::RobotFacts& facts, const std::string& robot, const moves::MovePlan& plan) {
  constexpr int kSamples = 100;
  PlanPreview::Answer out;
  out.robot = robot;
  std::vector<double> q(plan.end.size());
  for (const moves::PlannedMotion& each : plan.motions) {
    std::size_t hint = 0;
    for (int k = 0; k <= kSamples; ++k) {
      each.path.sample(each.path.duration() * k / kSamples, q, {}, {}, {}, hint);
      out.path.push_back(facts.chain.forward(q).position);
    }
  }
  for (const auto& warning : plan.warnings) out.warnings.push_back(warning.problem.text());
  for (std::size_t j = 0; j < plan.end.size(); ++j) out.joints[facts.chain.names()[j]] = plan.end[j];
  out.seconds = plan.duration();
  out.pose = pose_facts(facts.chain.forward(plan.end));
  return out;
}

Poll<PlanPreview::Answer> plan_preview(const PointOwners& cell, const PlanPreview& request) {
  using Previewed = Progress<PlanPreview::Answer>;
  const std::size_t i = robot_named(cell.setup, request.robot);
  return [&robot = *cell.setup.robots[i], way = plan_way(cell, i, request)] {
    if (!way->done.load(std::memory_order_acquire)) return Previewed{};
    if (way->error) throw *way->error;
    return Previewed::done(preview_of(*robot.facts, robot.entry.name, *way->plan));
  };
}

}  // namespace

std::vector<Handler> preview_handlers() {
  return handlers<plan_preview>();
}

}  // namespace polyarm::cell
