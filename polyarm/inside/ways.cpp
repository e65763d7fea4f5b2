#include "polyarm/inside/ways.hpp"

#include <fmt/format.h>

#include "polyarm/inside/inside.hpp"

namespace polyarm::cell {

namespace {

using control::RunState;

Problem in_fault(const Machine& machine) {
  return {"fault",
          {},
          std::string("the cell is in a fault: ") + control::name(machine.snapshot().cause),
          "polyarm control recover, then polyarm control resume",
          Severity::error,
          {{"cause", control::code(machine.snapshot().cause)}}};
}

Problem still_moving(const Machine& machine) {
  return {"stopping",
          {},
          std::string("the cell is ") + control::name(machine.snapshot().state) + " and still moves",
          "try again when it is at rest",
          Severity::error,
          {{"state", control::name(machine.snapshot().state)}}};
}

/// The loop reacts to a withdrawn stop one cycle later.
bool is_moving_state(RunState state) {
  return state == RunState::stopping || state == RunState::backing;
}

}  // namespace

std::optional<Problem> why_no_resume(const Machine& machine, const Motions& motions,
                                     const ContactWatch& contacts, const Watches& watches) {
  const RunState state = machine.snapshot().state;
  if (state == RunState::fault) return in_fault(machine);
  if (is_moving_state(state)) return still_moving(machine);
  const ContactReport* contact = contacts.touching_now();
  if (state == RunState::held && contact && motions.motion_left())
    return Problem{
        "in-contact",
        {},
        fmt::format("{} still touches {} ({} deep), and the held motion would continue from there",
                    contact->a, contact->b, depth_text(contact->depth)),
        "polyarm control back leads out along the path; or discard the motion (polyarm control discard), jog "
        "away slowly, then polyarm control resume; --anyway continues in spite of the contact",
        Severity::error,
        {{"a", contact->a}, {"b", contact->b}, {"depth_m", contact->depth}}};
  return watches.held_place().pushed();
}

std::optional<Problem> why_no_discard(const Machine& machine) {
  const RunState state = machine.snapshot().state;
  if (state == RunState::fault) return in_fault(machine);
  if (is_moving_state(state)) return still_moving(machine);
  if (state == RunState::running)
    return Problem{"not-held", {}, "nothing is held: the cell runs", "polyarm control hold comes first"};
  return std::nullopt;
}

std::optional<Problem> why_no_back(const Machine& machine, const Watches& watches) {
  const RunState state = machine.snapshot().state;
  if (state == RunState::fault) return in_fault(machine);
  if (is_moving_state(state)) return still_moving(machine);
  if (state != RunState::held)
    return Problem{"wrong-state",
                   {},
                   std::string("the control loop is in the state ") + control::name(state),
                   "hold the cell first: polyarm control hold",
                   Severity::error,
                   {{"state", control::name(state)}}};
  return watches.held_place().pushed();
}

std::optional<Problem> why_no_recover(const Machine& machine) {
  const RunState state = machine.snapshot().state;
  if (state == RunState::fault) return std::nullopt;
  return Problem{"no-fault",
                 {},
                 std::string("there is no fault: the cell is ") + control::name(state),
                 state == RunState::held ? "polyarm control resume" : "nothing to do",
                 Severity::error,
                 {{"state", control::name(state)}}};
}

std::optional<Problem> why_no_statement(const Machine& machine, const Arming& arming, const LifeCycle& life) {
  const RunState state = machine.snapshot().state;
  if (!arming.armed())
    return Problem{
        "disarmed", {}, "no program can continue: the real hardware is not armed", "polyarm control arm"};
  if (state == RunState::fault) return in_fault(machine);
  if (is_moving_state(state)) return still_moving(machine);
  if (state == RunState::held)
    return Problem{
        "held",
        {},
        "the cell is held (" + life.stop_cause().what + "), and no statement of the program begins",
        "polyarm control resume",
        Severity::error,
        {{"cause", life.stop_cause().code}}};
  return std::nullopt;
}

protocol::PossibleNow possible_now(const CellInside& cell) {
  const auto of = [](const std::optional<Problem>& why) {
    protocol::OrNull<protocol::ProblemFacts> out;
    if (why) out.emplace(protocol::problem_facts(*why));
    return out;
  };
  protocol::PossibleNow out{of(why_no_resume(cell.machine, *cell.motions, cell.contacts, *cell.watches)),
                            of(why_no_discard(cell.machine)),
                            of(why_no_back(cell.machine, *cell.watches)),
                            of(why_no_recover(cell.machine)),
                            of(why_no_statement(cell.machine, *cell.arming, *cell.life)),
                            {}};
  for (std::size_t i = 0; i < cell.setup.robots.size(); ++i)
    out.jog[cell.setup.robots[i]->entry.name] = of(cell.jogging->why_not(i));
  return out;
}

}  // namespace polyarm::cell
