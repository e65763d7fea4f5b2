#include "polyarm/cell/controller_switch.hpp"

namespace polyarm::cell {

Poll<control::SwitchPlan> switch_controllers(Cell& cell, control::SwitchRequest request) {
  using Switched = Progress<control::SwitchPlan>;
  auto job = cell.loop().controllers().begin_switch(request);
  return [&cell, job, request = std::move(request), tries = 0]() mutable {
    if (!job->done()) return Switched{};
    if (cell.loop().controllers().finish(*job)) return Switched::done(job->plan());
    if (++tries > 5)
      throw Error("busy", "the loop keeps changing its controllers by itself", "look at the log");
    cell.tell_loop_events();
    job = cell.loop().controllers().begin_switch(request);
    return Switched{};
  };
}

}  // namespace polyarm::cell
