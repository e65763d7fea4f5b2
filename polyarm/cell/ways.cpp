#include "polyarm/cell/ways.hpp"

#include <fmt/format.h>

#include "polyarm/cell/cell.hpp"

namespace polyarm::cell {

namespace {

using control::RunState;

Problem in_fault(const Cell& cell) {
  return {"fault",
          {},
          std::string("the cell is in a fault: ") + control::name(cell.snapshot().cause),
          "polyarm control recover, then polyarm control resume",
          Severity::error,
          {{"cause", control::code(cell.snapshot().cause)}}};
}

Problem still_moving(const Cell& cell) {
  return {"stopping",
          {},
          std::string("the cell is ") + control::name(cell.snapshot().state) + " and still moves",
          "ask again when it stands",
          Severity::error,
          {{"state", control::name(cell.snapshot().state)}}};
}

/// A stop that is not asked for any more is answered by the loop one cycle later.
bool is_moving_state(RunState state) {
  return state == RunState::stopping || state == RunState::backing;
}

}  // namespace

std::optional<Problem> why_no_resume(const Cell& cell) {
  const RunState state = cell.snapshot().state;
  if (state == RunState::fault) return in_fault(cell);
  if (is_moving_state(state)) return still_moving(cell);
  const ContactReport* contact = cell.contacts().touching_now();
  if (state == RunState::held && contact && cell.motion_left())
    return Problem{
        "in-contact",
        {},
        fmt::format("{} still touches {} ({:.2f} mm deep), and the motion that is held goes on from there",
                    contact->a, contact->b, 1e3 * contact->depth),
        "polyarm control back leads out along the path; or polyarm control discard forgets the motion, "
        "then jog away slowly and polyarm control resume; --anyway goes on all the same",
        Severity::error,
        {{"a", contact->a}, {"b", contact->b}, {"depth_m", contact->depth}}};
  return cell.held_place().pushed();
}

std::optional<Problem> why_no_discard(const Cell& cell) {
  const RunState state = cell.snapshot().state;
  if (state == RunState::fault) return in_fault(cell);
  if (is_moving_state(state)) return still_moving(cell);
  if (state == RunState::running)
    return Problem{"not-held", {}, "nothing is held: the cell runs", "polyarm control hold comes first"};
  return std::nullopt;
}

std::optional<Problem> why_no_back(const Cell& cell) {
  const RunState state = cell.snapshot().state;
  if (state == RunState::fault) return in_fault(cell);
  if (is_moving_state(state)) return still_moving(cell);
  if (state != RunState::held)
    return Problem{"wrong-state",
                   {},
                   std::string("the loop is at ") + control::name(state),
                   "only what is held steps back: polyarm control hold",
                   Severity::error,
                   {{"state", control::name(state)}}};
  return cell.held_place().pushed();
}

std::optional<Problem> why_no_recover(const Cell& cell) {
  const RunState state = cell.snapshot().state;
  if (state == RunState::fault) return std::nullopt;
  return Problem{"no-fault",
                 {},
                 std::string("there is no fault to leave: the cell is ") + control::name(state),
                 state == RunState::held ? "polyarm control resume" : "nothing has to be done",
                 Severity::error,
                 {{"state", control::name(state)}}};
}

std::optional<Problem> why_no_statement(const Cell& cell) {
  const RunState state = cell.snapshot().state;
  if (!cell.arming().armed())
    return Problem{"disarmed", {}, "no program goes on: real hardware that nobody has armed", "polyarm control arm"};
  if (state == RunState::fault) return in_fault(cell);
  if (is_moving_state(state)) return still_moving(cell);
  if (state == RunState::held)
    return Problem{
        "held",
        {},
        "the cell is held (" + cell.stop_cause().what + "), and no statement of the program begins",
        "polyarm control resume",
        Severity::error,
        {{"cause", cell.stop_cause().code}}};
  return std::nullopt;
}

protocol::PossibleNow possible_now(Cell& cell) {
  const auto of = [](const std::optional<Problem>& why) {
    protocol::OrNull<protocol::ProblemFacts> out;
    if (why) out.emplace(protocol::problem_facts(*why));
    return out;
  };
  protocol::PossibleNow out{of(why_no_resume(cell)),  of(why_no_discard(cell)),   of(why_no_back(cell)),
                            of(why_no_recover(cell)), of(why_no_statement(cell)), {}};
  for (std::size_t i = 0; i < cell.robots().size(); ++i)
    out.jog[cell.robots()[i]->entry.name] = of(cell.jogging().why_not(i));
  return out;
}

}  // namespace polyarm::cell
