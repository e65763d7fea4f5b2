/// What a contact in physics leads to, and what it is blamed on.
#include <algorithm>
#include <string>

#include "polyarm/cell/bodies.hpp"
#include "polyarm/cell/cell.hpp"

namespace polyarm::cell {

namespace {
/// What touches by then was there from the start: no joint has come anywhere yet.
constexpr Nanoseconds kFromTheStart = 5'000'000;

bool belongs(const std::string& name, const std::string& robot) {
  return name.starts_with(robot + "/") || name == "the part held by " + robot;
}
}  // namespace

bool Cell::motion_left() const {
  control::ControllerManager& manager = loop_->controllers();
  const std::vector<std::string> names = manager.names();
  const auto sent = [&](const std::string& name) {
    const auto* follower = dynamic_cast<const controllers::JointTrajectoryController*>(manager.find(name));
    return follower && follower->status().active.load(std::memory_order_acquire) != 0;
  };
  return !all_idle() || std::any_of(names.begin(), names.end(), sent) ||
         std::any_of(bases_.begin(), bases_.end(), [](const auto& base) { return base && !base->idle(); });
}

/// The robot that moves, of those that touch; a part is its who holds it. -1: none.
int Cell::robot_in(const ContactReport& contact) const {
  const auto holder = [&](const std::string& name) {
    const auto& parts = snapshot().world.parts;
    for (std::size_t p = 0; p < scene_.parts.size() && p < parts.size(); ++p)
      if (name == "part " + scene_.parts[p].name) return parts[p].held_by;
    return -1;
  };
  int out = -1;
  for (const std::string* name : {&contact.a, &contact.b})
    for (std::size_t r = 0; r < robots_.size(); ++r) {
      if (!belongs(*name, robots_[r]->entry.name) && holder(*name) != static_cast<int>(r)) continue;
      if (!idle(r) || jogging_->engaged(r)) return static_cast<int>(r);
      if (out < 0) out = static_cast<int>(r);
    }
  return out;
}

/// The move under way, and while somebody jogs the jog; never a program that has ended or has another robot.
void Cell::find_cause(ContactReport& contact) const {
  const int who = robot_in(contact);
  if (who < 0) return;
  const auto r = static_cast<std::size_t>(who);
  contact.robot = robots_[r]->entry.name;
  if (contact.time <= kFromTheStart) {
    contact.during = ContactDuring::start;
  } else if (jogging_->engaged(r)) {
    contact.during = ContactDuring::jog;
  } else if (motions_[r] && motions_[r]->under_way()) {
    if (moves_) contact.where = moves_->place_of(*motions_[r], motions_[r]->move_under_way());
    contact.during = contact.where.file.empty() ? ContactDuring::move : ContactDuring::program;
  } else if (bases_[r] && !bases_[r]->idle() && program_ && begun_ && !program_->ended()) {
    contact.during = ContactDuring::program;
    contact.where = program_->status().where;
  }
}

Problem Cell::problem_of(const ContactReport& contact) const {
  Problem out{"contact",       contact.where,  contact.sentence(), "move the points or the obstacle",
              Severity::error, contact.facts()};
  if (contact.during == ContactDuring::start)
    out.advice = "move the base of the robot, the obstacle, or where it starts (home)";
  else if (contact.during == ContactDuring::jog)
    out.advice = "jog it away slowly, then polyarm control resume";
  else if (options_.waits)
    out.advice =
        "polyarm control back leads out along the path; or polyarm control discard, then jog it away "
        "slowly; then polyarm control resume";
  if (!options_.waits) out.advice += ", or run with --allow-contact";
  return out;
}

void Cell::watch_contacts(Nanoseconds now, const control::Snapshot& snapshot) {
  std::optional<Problem> inside;  // what follows in physics is no news
  for (ContactReport* contact :
       contact_watch_.tick(snapshot, loop_->hardware().diagnostics().world_names())) {
    find_cause(*contact);
    if (failure_) continue;
    Problem problem = problem_of(*contact);
    if (options_.allow_contact) {
      problem.severity = options_.contact_errors ? Severity::error : Severity::warning;
      observer_.on_problem(now, problem);
      if (options_.contact_errors && contact->during == ContactDuring::start) inside = std::move(problem);
    } else if (options_.waits) {  // somebody is there; the loop has begun to stop
      observer_.on_problem(now, problem);
    } else {
      fail(now, std::move(problem));
    }
  }
  if (inside) fail(now, std::move(*inside));
}

protocol::ContactState contact_state(const Cell& cell) {
  protocol::ContactState out;
  for (const auto& robot : cell.robots()) out.checked = out.checked || checks_contacts(*robot);
  const control::ContactStop stop = cell.contact_stop();
  if (stop != control::ContactStop::none) out.stop = stop == control::ContactStop::cut ? 0 : 1;
  out.touching = cell.contacts().touching();
  out.unchecked = sentences(cell.unchecked_bodies());
  for (const Problem& each : cell.unchecked_bodies())
    out.unchecked_why.push_back({each.code, protocol::fact_values(each.facts)});
  for (const ContactReport& c : cell.contacts().list())
    out.list.push_back({c.a, c.b, c.robot, seconds(c.time), c.depth, c.position, c.now, name(c.during),
                        c.where.file.empty() ? "" : c.where.text(), c.sentence()});
  return out;
}

}  // namespace polyarm::cell
