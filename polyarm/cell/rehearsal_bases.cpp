/// Bases with wheels in a rehearsal.
#include <cmath>
#include <utility>

#include "polyarm/cell/rehearsal_stage.hpp"
#include "polyarm/inside/inside.hpp"

namespace polyarm::cell {

/// T_world_root of a robot, which may be on a base that has driven.
Pose Stage::root_of(std::size_t robot) const {
  const RobotEntry& entry = arms_[robot].robot->entry;
  for (std::size_t i = 0; i < arms_.size() && !entry.on.empty(); ++i)
    if (arms_[i].robot->entry.name == entry.on)
      return root_of(i) * inverse(arms_[i].robot->entry.base) * entry.base;
  return arms_[robot].base * inverse(cell_.motions->base(robot).tracked());
}

/// Where the program has brought all robots so far.
surroundings::Moment Stage::moment() const {
  surroundings::Moment out;
  for (std::size_t i = 0; i < arms_.size(); ++i) out.robots.push_back({root_of(i), arms_[i].at});
  return out;
}

/// The base then stands at the end of the drive or turn. Only the way to a pose is planned.
void Stage::drive(const program::Move& move, const Asked& asked) {
  const std::size_t index = moves_->base_of(move, asked.where);
  Arm& base = arms_[index];
  if (const auto goal = moves_->base_goal(move, asked.where)) return drive_to(index, *goal, asked);
  const auto* amount = move.targets.front().value.as_number();
  if (move.kind == program::Move::Kind::turn)
    base.base.rotation = base.base.rotation * from_rpy(0, 0, amount->value);
  else
    base.base.position = base.base * Vec3{amount->value, 0, 0};
  base.driven.push_back({asked});
}

/// Without a way the base counts as there, unless the program catches the error or something is in its place.
void Stage::drive_to(std::size_t index, const Pose& goal, const Asked& asked) {
  Arm& base = arms_[index];
  AroundOptions options;
  options.clearance = cell_.setup.file.clearance;
  ++out_.moves;
  const bool from_known = start_known(base.driven, asked.where);
  try {
    base_search(fixed_bodies(), moment(),
                {index, cell_.motions->base(index).tracked(), goal, cell_.motions->wheels(index)->sharpest(),
                 options})({});
    base.driven.push_back({asked, true});
  } catch (const Error& e) {
    const Problem problem = e.problems().front();
    const bool is_taken = problem.code == "goal-in-contact";
    tell(problem, asked, values_known(asked) && (from_known || is_taken));
    base.driven.push_back({asked, false, true});
    if (pending_ || is_taken) return;
  }
  const Vec3 ahead = goal.rotation * Vec3{1, 0, 0};
  base.base = {{goal.position.x, goal.position.y, base.base.position.z},
               from_rpy(0, 0, std::atan2(ahead.y, ahead.x))};
}

/// Fixtures that do not move, the floor and the robots: what is there in every run.
const std::shared_ptr<SharedBodies>& Stage::fixed_bodies() {
  if (fixed_) return fixed_;
  fixed_scene_ = cell_.setup.scene;
  fixed_scene_.parts.clear();
  std::erase_if(fixed_scene_.fixtures,
                [](const description::Fixture& fixture) { return !fixture.mover.empty(); });
  return fixed_ = std::make_shared<SharedBodies>(cell_.setup.robots, fixed_scene_);
}

}  // namespace polyarm::cell
