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

/// The base then stands at the end of the drive or turn. Only the way to a pose is planned.
void Stage::drive(const program::Move& move, const Asked& asked) {
  const std::size_t index = moves_->base_of(move, asked.where);
  Arm& base = arms_[index];
  const auto* amount = move.targets.front().value.as_number();
  if (move.kind == program::Move::Kind::turn) {
    base.base.rotation = base.base.rotation * from_rpy(0, 0, amount->value);
  } else if (const auto goal = moves_->base_goal(move, asked.where)) {
    surroundings::Moment moment;
    for (std::size_t i = 0; i < arms_.size(); ++i) moment.robots.push_back({root_of(i), arms_[i].at});
    const Pose from = std::exchange(base.base, *goal);
    const Vec3 ahead = goal->rotation * Vec3{1, 0, 0};
    base.base = {{goal->position.x, goal->position.y, from.position.z},
                 from_rpy(0, 0, std::atan2(ahead.y, ahead.x))};
    AroundOptions options;
    options.clearance = cell_.setup.file.clearance;
    cell_.motions->wheels(index)->check_way();
    ++out_.moves;
    base_search(fixed_bodies(), std::move(moment),
                {index, cell_.motions->base(index).tracked(), *goal, options})();
  } else {
    base.base.position = base.base * Vec3{amount->value, 0, 0};
  }
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
