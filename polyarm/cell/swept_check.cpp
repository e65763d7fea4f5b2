#include "polyarm/cell/swept_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include "polyarm/inside/inside.hpp"
#include "polyarm/setup/bodies.hpp"

namespace polyarm::cell {

using surroundings::Approach;

namespace {

polyarm::Facts approach_facts(const Approach& a) {
  const bool contact = a.distance <= 0;
  return {{"a", a.first},
          {"b", a.second},
          {contact ? "depth_m" : "distance_m", std::abs(a.distance)},
          {"at_s", a.time}};
}

Problem problem_of(const Approach& a, const Location& where, double clearance) {
  if (a.distance <= 0)
    return {"contact",
            where,
            surroundings::text_of(a),
            a.at_start ? "move the base of the robot, the obstacle, or where it starts (home)"
                       : "move the points or the obstacle, or let the move go around it: `around true`",
            Severity::error,
            approach_facts(a)};
  return {
      "clearance",
      where,
      surroundings::text_of(a),
      fmt::format("the cell requires {:g} mm (contacts: {{clearance: …}}): move the points or the obstacle",
                  1e3 * clearance),
      Severity::warning,
      approach_facts(a)};
}

}  // namespace

SweptCheck::SweptCheck(const CellInside& cell, std::optional<double> clearance)
    : cell_(cell),
      clearance_(clearance.value_or(cell.setup.file.clearance)),
      bodies_(cell.motions->bodies()->get()),
      marks_{Location{}} {
  sweep_ = std::make_unique<surroundings::Sweep>(bodies_->robots, bodies_->scene, clearance_);
}

SweptCheck::~SweptCheck() = default;

/// Where the program asked for the move under way of a robot.
std::uint64_t SweptCheck::mark_of(std::size_t robot) {
  const Motions& motions = *cell_.motions;
  const Programs& programs = *cell_.programs;
  Location where;
  if (const moves::RobotMotion* motion = motions.motion(robot); motion && motion->under_way())
    where = programs.place_of(*motion, motion->move_under_way());
  const moves::RobotMotion* const own = motions.motion(robot);
  const Location touch = own ? programs.touch_of(*own) : Location{};
  if (!touch.file.empty()) where = touch;
  if (where.file.empty() && programs.program()) where = programs.program()->status().where;
  if (!(marks_.back().file == where.file && marks_.back().line == where.line)) marks_.push_back(where);
  if (!touch.file.empty()) meant_.insert({robot, marks_.size() - 1});
  return marks_.size() - 1;
}

/// The tool, or a part that it may hold, in a move that is meant to touch; never with another link of a
/// robot. The contact may last into the next move, such as the one that goes back, but not get deeper there.
bool SweptCheck::is_meant(const Approach& a) const {
  const bool lasts = meant_.contains({a.robot, a.first_mark}) && a.distance <= 0 &&
                     a.distance >= a.first_distance - surroundings::Sweep::kPressing;
  if (!lasts && !meant_.contains({a.robot, a.mark})) return false;
  const auto is_tool = [](const std::string& name, const std::string& robot) {
    return name.starts_with(robot + "/tool") || name.starts_with(robot + "/finger");
  };
  for (const auto& robot : cell_.setup.robots)
    for (const std::string* name : {&a.first, &a.second})
      if (name->starts_with(robot->entry.name + "/") && !is_tool(*name, robot->entry.name)) return false;
  const std::string& own = cell_.setup.robots[a.robot]->entry.name;
  const auto may = [&](const std::string& name) { return is_tool(name, own) || name.starts_with("part "); };
  return may(a.first) || may(a.second);
}

void SweptCheck::look(Nanoseconds now) {
  sweep_->add(cell_.motions->moment(), seconds(now), [this](std::size_t robot) { return mark_of(robot); });
}

std::vector<Problem> SweptCheck::finish() {
  sweep_->finish();
  std::map<std::tuple<std::string, std::string, std::string>, const Approach*> worst;
  std::vector<const Approach*> in_order;
  for (const Approach& a : sweep_->approaches()) {
    if (is_meant(a)) continue;
    const auto [at, is_new] = worst.insert({{marks_[a.mark].text(), a.first, a.second}, &a});
    if (!is_new && a.distance >= at->second->distance) continue;
    at->second = &a;
  }
  for (const auto& [key, a] : worst) in_order.push_back(a);
  std::sort(in_order.begin(), in_order.end(),
            [](const Approach* a, const Approach* b) { return a->time < b->time; });
  std::vector<Problem> out;
  for (const Approach* a : in_order) {
    if (!nearest_ || a->distance < nearest_->distance) nearest_ = *a;
    out.push_back(problem_of(*a, marks_[a->mark], clearance_));
  }
  return out;
}

std::vector<Problem> contacts_at_rest(const CellInside& cell) {
  const std::shared_ptr<const ContactBodies> bodies = cell.motions->bodies()->get();
  std::vector<Problem> out;
  surroundings::Moment start = surroundings::start_of(bodies->scene);
  for (const auto& robot : cell.setup.robots) start.robots.push_back({robot->entry.base, robot->start});
  for (const bool home : {false, true}) {
    surroundings::Moment moment = start;
    for (std::size_t r = 0; home && r < moment.robots.size(); ++r)
      if (cell.setup.robots[r]->facts && !cell.setup.robots[r]->facts->home.empty())
        moment.robots[r].joints = cell.setup.robots[r]->facts->home;
    surroundings::Sweep sweep(bodies->robots, bodies->scene, 0);
    sweep.add(moment, 0, {});
    sweep.finish();
    for (const Approach& a : sweep.approaches()) {
      if (home && std::any_of(out.begin(), out.end(), [&](const Problem& p) {
            return std::get<std::string>(p.facts[0].value) == a.first &&
                   std::get<std::string>(p.facts[1].value) == a.second;
          }))
        continue;
      out.push_back({home ? "home-in-contact" : "start-in-contact", cell.setup.robots[a.robot]->entry.where,
                     fmt::format("{} is {:.2f} mm inside {} {}, at ({:.3f}, {:.3f}, {:.3f})", a.first,
                                 -1e3 * a.distance, a.second, home ? "at home" : "where it starts", a.point.x,
                                 a.point.y, a.point.z),
                     "move the base of the robot, the obstacle, or its home", Severity::error, approach_facts(a)});
    }
  }
  return out;
}

}  // namespace polyarm::cell
