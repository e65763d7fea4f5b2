#include "polyarm/ros2/move_group_cell.hpp"

#include "polyarm/setup/bodies.hpp"

namespace polyarm::ros2 {

bool LongWork::post(cell::Worker& worker, std::atomic<std::size_t>& waiting, Work work) {
  if (waiting.load() >= kMostWaiting) return false;
  ++waiting;
  worker.post([ended = ended_, &waiting, work = std::move(work)] {
    Then then;
    try {
      then = work();
    } catch (const std::exception&) {
      // The work answers its own failures; a client without an answer asks again.
    }
    --waiting;
    if (!then) return;
    const std::lock_guard lock(ended->mutex);
    ended->thens.push_back(std::move(then));
  });
  return true;
}

void LongWork::finish() {
  std::size_t left = 0;
  {
    const std::lock_guard lock(ended_->mutex);
    left = ended_->thens.size();
  }
  for (; left > 0; --left) {  // one by one: if one throws, the others wait for the next tick
    Then then;
    {
      const std::lock_guard lock(ended_->mutex);
      then = std::move(ended_->thens.front());
      ended_->thens.pop_front();
    }
    then();
  }
}

MoveGroupCell::Look MoveGroupCell::look(std::shared_ptr<const move_group::Arm> arm) const {
  return [arm = std::move(arm), moment = bridge.cell().moment(), shared = bodies, scene = scene] {
    const std::shared_ptr<const cell::ContactBodies> made = shared->get();
    return move_group::Around{arm, {made, &made->robots, &made->scene}, moment, scene->now()};
  };
}

move_group::PlanSettings MoveGroupCell::settings(std::shared_ptr<std::atomic<bool>> cancelled) const {
  move_group::PlanSettings out;
  out.clearance = bridge.cell().file().clearance;
  out.limits = bridge.cell().plan_options();
  out.cancelled = [cancelled = std::move(cancelled), closing = closing] {
    return closing->load() || (cancelled && cancelled->load());
  };
  return out;
}

}  // namespace polyarm::ros2
