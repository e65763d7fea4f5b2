/// Ways of bases around what is in a cell.
#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "polyarm/machine/around.hpp"
#include "polyarm/surroundings/base_ways.hpp"

namespace polyarm::cell {

namespace {

[[noreturn]] void refuse(const surroundings::BaseWay& way, const Vec3& goal, bool steers) {
  const std::string to = fmt::format("no way to ({:.3f}, {:.3f}) m: ", goal.x, goal.y);
  const std::string touch = way.mine + " touches " + way.other;
  using Outcome = surroundings::BaseWayOutcome;
  switch (way.outcome) {
    case Outcome::start_touches:
      throw Error("start-in-contact", to + touch + " where the base stands",
                  "drive it away by a length first: `drive -300mm`");
    case Outcome::goal_touches:
      throw Error("goal-in-contact", to + touch + " there",
                  "go to a free pose before it, then with `drive 200mm` to it");
    case Outcome::out_of_time:
      throw Error("out-of-time", to + "the search took too long", "drive to a pose between");
    default:
      throw Error("no-way",
                  to + (steers ? "arcs" : "turns") + " and straight lines lead nowhere with this clearance",
                  "drive to a pose between, or give the base more room to turn");
  }
}

}  // namespace

moves::BaseSurroundings::Search base_search(std::shared_ptr<SharedBodies> bodies, surroundings::Moment moment,
                                            BaseGoal goal) {
  return [bodies = std::move(bodies), moment = std::move(moment),
          goal = std::move(goal)](const std::function<bool()>& dropped) {
    const std::shared_ptr<const ContactBodies> made = bodies->get();
    const Vec3 at = goal.goal.position, ahead = goal.goal.rotation * Vec3{1, 0, 0};
    surroundings::BaseWayQuery query;
    query.robot = goal.robot;
    query.T_root_base = goal.T_root_base;
    query.goal = {at.x, at.y, std::atan2(ahead.y, ahead.x)};
    query.clearance = goal.options.clearance;
    query.sharpest = goal.sharpest;
    query.stop = [&] { return (dropped && dropped()) || (goal.options.stop && goal.options.stop()); };
    const surroundings::BaseWay way = surroundings::find_base_way(made->robots, made->scene, moment, query);
    if (way.outcome != surroundings::BaseWayOutcome::found) refuse(way, at, std::isfinite(goal.sharpest));
    std::vector<moves::BaseLeg> out;
    for (const surroundings::BaseLeg& leg : way.legs)
      out.push_back({leg.length == 0,
                     {leg.from.x, leg.from.y, 0},
                     {leg.to.x, leg.to.y, 0},
                     leg.to.heading,
                     leg.backwards,
                     leg.curvature,
                     leg.length,
                     way.kept});
    return out;
  };
}

}  // namespace polyarm::cell
