/// Reactions to contacts in physics, and their causes.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "polyarm/operation/watches.hpp"
#include "polyarm/setup/bodies.hpp"
#include "polyarm/setup/controllers_start.hpp"

namespace polyarm::cell {

namespace {
/// Contacts up to this time existed from the start: no joint has moved noticeably yet, ns.
constexpr Nanoseconds kFromTheStart = 5'000'000;

bool belongs(const std::string& name, const std::string& robot) {
  return name.starts_with(robot + "/") || name == "the part held by " + robot;
}

/// True if the robot only rests: its trajectory controller holds its joints, has nothing to follow, and
/// nobody drives its base. Else something may have moved it.
bool rests(const Watches::Owners& cell, std::size_t r) {
  const moves::RobotMotion* const motion = cell.motions.motion(r);
  if (!motion || !motion->idle() || motion->complying() || cell.motions.base(r).moves()) return false;
  const controllers::JointTrajectoryController* const holds =
      trajectory_controller_of(*cell.setup.robots[r], cell.machine.controllers(), false);
  return holds && holds->status().active.load(std::memory_order_acquire) == 0;
}

/// True if the body or part of this name moves with the robot.
bool moves_with(const Watches::Owners& cell, const std::string& name, std::size_t r) {
  if (belongs(name, cell.setup.robots[r]->entry.name)) return true;
  const auto& parts = cell.machine.snapshot().world.parts;
  for (std::size_t p = 0; p < cell.setup.scene.parts.size() && p < parts.size(); ++p)
    if (name == "part " + cell.setup.scene.parts[p].name) return parts[p].held_by == static_cast<int>(r);
  return false;
}

/// True if all robots of a contact rest.
bool all_rest(const Watches::Owners& cell, const ContactReport& contact) {
  for (std::size_t r = 0; r < cell.setup.robots.size(); ++r)
    if ((moves_with(cell, contact.a, r) || moves_with(cell, contact.b, r)) && !rests(cell, r)) return false;
  return true;
}

/// Why one of the robots of a contact fell. Skipped if contacts are allowed, because there may be many.
std::string falls(const CellSetup& setup, const ContactReport& contact) {
  if (setup.options.allow_contact) return {};
  for (const auto& robot : setup.robots)
    if (belongs(contact.a, robot->entry.name) || belongs(contact.b, robot->entry.name))
      if (std::string why = why_it_sags(*robot); !why.empty()) return why;
  return {};
}
}  // namespace

/// The robot of a contact, preferably one that moves; a held part counts as its holder. -1: none.
int Watches::robot_in(const ContactReport& contact) const {
  int out = -1;
  for (const std::string* name : {&contact.a, &contact.b})
    for (std::size_t r = 0; r < cell_.setup.robots.size(); ++r) {
      if (!moves_with(cell_, *name, r)) continue;
      if (!cell_.motions.idle(r) || cell_.jogging.engaged(r)) return static_cast<int>(r);
      if (out < 0) out = static_cast<int>(r);
    }
  return out;
}

/// Sets the cause: the current move, or the jog while somebody jogs; never a program that has ended or
/// commands another robot.
void Watches::find_cause(ContactReport& contact) const {
  const int who = robot_in(contact);
  if (who < 0) return;
  const auto r = static_cast<std::size_t>(who);
  contact.robot = cell_.setup.robots[r]->entry.name;
  if (contact.time <= kFromTheStart) {
    contact.during = ContactDuring::start;
  } else if (cell_.jogging.engaged(r)) {
    contact.during = ContactDuring::jog;
  } else if (cell_.motions.motion(r) && cell_.motions.motion(r)->under_way()) {
    contact.where =
        cell_.programs.place_of(*cell_.motions.motion(r), cell_.motions.motion(r)->move_under_way());
    contact.during = contact.where.file.empty() ? ContactDuring::move : ContactDuring::program;
  } else if (cell_.motions.wheels(r) && !cell_.motions.wheels(r)->idle() && cell_.programs.under_way()) {
    contact.during = ContactDuring::program;
    contact.where = cell_.programs.program()->status().where;
  } else if (all_rest(cell_, contact)) {
    contact.during = ContactDuring::rest;
    contact.robot.clear();
  }
}

Problem Watches::problem_of(const ContactReport& contact) const {
  Problem out{"contact",       contact.where,  contact.sentence(), "move the points or the obstacle",
              Severity::error, contact.facts()};
  if (contact.during == ContactDuring::start)
    out.advice = "move the base of the robot, the obstacle, or where it starts (home)";
  else if (contact.during == ContactDuring::jog)
    out.advice = "jog it away slowly, then polyarm control resume";
  else if (const std::string why = falls(cell_.setup, contact); !why.empty())
    out.advice = why + "; correct the <limit effort> of the description";
  else if (contact.during == ContactDuring::rest)
    out.advice = "look at what came to the robot, and remove it" +
                 std::string(cell_.programs.waits() ? "; then polyarm control resume" : "");
  else if (cell_.programs.waits())
    out.advice =
        "polyarm control back leads out along the path; or polyarm control discard, then jog it away "
        "slowly; then polyarm control resume";
  if (!cell_.programs.waits()) out.advice += ", or run with --allow-contact";
  return out;
}

/// True for a contact of a robot's tool, or of a part that it holds, in a move that is meant to touch, with anything
/// but the links of a robot. Never while somebody jogs.
bool Watches::is_meant(const ContactReport& contact) const {
  const auto is_tool = [](const std::string& name, const std::string& robot) {
    return name.starts_with(robot + "/tool") || name.starts_with(robot + "/finger");
  };
  for (const auto& robot : cell_.setup.robots)
    for (const std::string* name : {&contact.a, &contact.b})
      if (name->starts_with(robot->entry.name + "/") && !is_tool(*name, robot->entry.name)) return false;
  if (contact.during == ContactDuring::jog) return false;
  const auto& parts = cell_.machine.snapshot().world.parts;
  for (std::size_t r = 0; r < cell_.setup.robots.size(); ++r) {
    const moves::RobotMotion* const motion = cell_.motions.motion(r);
    if (!motion || cell_.programs.touch_of(*motion).file.empty()) continue;
    for (const std::string* name : {&contact.a, &contact.b}) {
      if (is_tool(*name, cell_.setup.robots[r]->entry.name)) return true;
      for (std::size_t p = 0; p < cell_.setup.scene.parts.size() && p < parts.size(); ++p)
        if (*name == "part " + cell_.setup.scene.parts[p].name && parts[p].held_by == static_cast<int>(r)) return true;
    }
  }
  return false;
}

void Watches::watch_contacts() {
  const CellOptions& options = cell_.setup.options;
  const Nanoseconds now = cell_.machine.now();
  std::optional<Problem> inside;  // consequences of this contact in physics are not reported again
  for (ContactReport* contact :
       cell_.contacts.tick(cell_.machine.snapshot(), cell_.machine.hardware().diagnostics().world_names())) {
    find_cause(*contact);
    if (cell_.life.failure() || is_meant(*contact)) continue;
    Problem problem = problem_of(*contact);
    if (options.allow_contact) {
      problem.severity = options.contact_errors ? Severity::error : Severity::warning;
      cell_.observer.on_problem(now, problem);
      if (options.contact_errors && contact->during == ContactDuring::start) inside = std::move(problem);
    } else if (cell_.programs.waits()) {  // a person is present
      cell_.observer.on_problem(now, problem);
      cell_.machine.supervisor().stop_for_contact();  // the loop has not stopped while other contacts were meant
    } else {
      cell_.machine.supervisor().stop_for_contact();
      cell_.life.fail(std::move(problem));
    }
  }
  if (inside) cell_.life.fail(std::move(*inside));
}

std::string Watches::contact_behind(control::StopCause cause) const {
  if (cause != control::StopCause::jump && cause != control::StopCause::not_following) return {};
  const ContactReport* deepest = nullptr;
  for (const ContactReport& each : cell_.contacts.list())
    if (each.now && (!deepest || each.depth > deepest->depth)) deepest = &each;
  return deepest ? deepest->sentence() : "";
}

void Watches::watch_torques() {
  if (!torques_) {
    std::vector<std::string> notes;
    torques_.emplace(cell_.setup, cell_.machine, notes);
    for (const std::string& note : notes) cell_.observer.on_note(note);
  }
  const bool runs = cell_.machine.snapshot().state == control::RunState::running;
  if (!std::exchange(torques_ran_, runs) && runs) torques_->forget();  // a resume does not press on
  const std::optional<TorqueWatch::Found> found = torques_->tick();
  if (!found || cell_.life.failure()) return;
  const moves::RobotMotion* const motion = cell_.motions.motion(found->robot);
  const bool meant = motion && (motion->complying() || !cell_.programs.touch_of(*motion).file.empty());
  if (meant && !cell_.jogging.engaged(found->robot)) return;
  const std::string joint = cell_.setup.robots[found->robot]->entry.name + "/" + found->joint;
  const char* const unit = found->slides ? "N" : "Nm";
  Problem problem{
      "collision-torque",
      motion && motion->under_way() ? cell_.programs.place_of(*motion, motion->move_under_way()) : Location{},
      fmt::format("{:.0f} {} act on {} from outside, more than the {:g} {} of collision_torque",
                  std::abs(found->torque), unit, joint, found->limit, unit),
      "remove what the robot touches, then polyarm control resume; or allow more torque in cell.yaml",
      Severity::error,
      {{"joint", joint}, {"torque", fmt::format("{:.1f} {}", std::abs(found->torque), unit)}}};
  const bool stops = cell_.machine.supervisor().contact_stop() != control::ContactStop::none;
  if (stops) cell_.machine.supervisor().stop_for_contact();
  if (!cell_.programs.waits()) return cell_.life.fail(std::move(problem));
  cell_.observer.on_problem(cell_.machine.now(), problem);
  if (!stops) cell_.machine.hold_for(std::move(problem));  // contacts are allowed, this torque is not
}

protocol::ContactState contact_state(const CellSetup& setup, const Machine& machine,
                                     const ContactWatch& contacts) {
  protocol::ContactState out;
  for (const auto& robot : setup.robots) out.checked = out.checked || checks_contacts(*robot);
  const control::ContactStop stop = machine.supervisor().contact_stop();
  if (stop != control::ContactStop::none) out.stop = stop == control::ContactStop::cut ? 0 : 1;
  out.touching = contacts.touching();
  out.unchecked = sentences(setup.unchecked_bodies);
  for (const Problem& each : setup.unchecked_bodies)
    out.unchecked_why.push_back({each.code, protocol::fact_values(each.facts)});
  for (const ContactReport& c : contacts.list())
    out.list.push_back({c.a, c.b, c.robot, seconds(c.time), c.depth, c.position, c.now, name(c.during),
                        c.where.file.empty() ? "" : c.where.text(), c.sentence()});
  return out;
}

}  // namespace polyarm::cell
