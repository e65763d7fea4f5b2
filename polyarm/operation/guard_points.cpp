/// Guards of trajectories of points, of the zones of a workspace while a robot moves, and of attached things.
#include <utility>

#include "polyarm/operation/guard_work.hpp"

namespace polyarm::cell {

/// Attached things are parts that their robot holds. Where they are in its hand counts when the bodies are
/// new.
void Guards::see_attached() {
  Work& work = *work_;
  if (work.held.empty()) return;
  work.moment.parts.resize(work.scene->parts.size() - work.held.size());  // unknown ones are not in the world
  const bool is_new = !work.bodies->has_looked();
  for (const surroundings::AttachedThing& thing : work.held) {
    surroundings::Moment::PartState part{{}, true, static_cast<int>(thing.robot)};
    if (is_new) {
      const surroundings::Moment::RobotState& robot = work.moment.robots[thing.robot];
      const kinematics::Chain chain(cell_.setup.robots[thing.robot]->model, thing.link, robot.base);
      part.pose = chain.forward(robot.joints) * thing.pose;
    }
    work.moment.parts.push_back(part);
  }
}

/// A trajectory of points that is guarded.
std::optional<Motions::Points> Guards::points(std::size_t r) const {
  if (!cell_.setup.file.guards.moves || cell_.jogging.engaged(r)) return std::nullopt;
  const auto out = cell_.motions.points(r);
  return out && !out->goal->trajectory.empty() ? out : std::nullopt;
}

/// Looks along the trajectory of points that moves the robot, as along a move. Returns false without one.
bool Guards::see_points(std::size_t r) {
  constexpr std::uint64_t kOfPoints = std::uint64_t{1} << 63;
  Of& of = work_->robots[r];
  const auto now = points(r);
  if (!now) return false;
  of.by_points = true;
  of.along = &of.points;
  of.facts = cell_.setup.robots[r]->facts.get();
  of.step = nullptr;
  of.time = now->time;
  of.speed = of.pace = 1;
  of.slowed = false;
  of.looks_at_zones = true;
  const bool is_new = std::exchange(of.goal, kOfPoints | now->goal->id) != (kOfPoints | now->goal->id),
             looks_anew = std::exchange(of.anew, false);
  if (is_new)
    of.points.set(*now->goal, work_->moment.robots[r].joints, of.axes);
  else
    of.points.still(*now->goal);
  of.duration = of.points.duration();
  if (is_new) of.zones.begin();
  if ((is_new || looks_anew) && of.ahead) of.ahead->begin(of.points, {});
  return true;
}

/// Where the way leaves the workspace counts as what is in the way.
void Guards::look_at_zones(std::size_t r, double until) {
  Of& of = work_->robots[r];
  if (!of.looks_at_zones || of.facts->workspace.empty()) return;
  const moves::RobotFacts& robot = *of.facts;
  const double leaves = of.zones.look(robot.workspace, robot.chain, *of.along, of.time, until, is_reduced());
  if (leaves >= of.ahead_of.free_until) return;
  of.ahead_of = {leaves, -1, {}, 0};
  of.crossing = of.zones.crossing();
}

}  // namespace polyarm::cell
