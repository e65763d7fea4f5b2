/// Requests that jog a robot, stream targets, and set the limits profile.
#include "polyarm/inside/requests_work.hpp"
#include "polyarm/operation/jog_commands.hpp"
#include "polyarm/requests/families.hpp"

namespace polyarm::cell {

namespace {

using namespace protocol;

constexpr Nanoseconds kRenewEvery = 50'000'000, kTellJogEvery = 100'000'000;

/// Sends the command once the jog controller has the robot's joints, and reports its state.
Poll<JogAnswer> follow_command(const JogOwners& cell, std::size_t i, std::uint32_t session,
                               jog::JogCommand command) {
  return [cell, i, session, command, sent = false]() mutable {
    Jogging& jogging = cell.jogging;
    if (!jogging.engage(i)) return Progress<JogAnswer>{};
    if (!sent) {
      session = jogging.session(i, session);
      jogging.send(i, session, command);
      sent = true;
    }
    JogAnswer out = jog_answer(cell, i);
    out.session = session;
    return Progress<JogAnswer>::done(std::move(out));
  };
}

/// Why a step ended early.
Error stopped(const JogOwners& cell) {
  if (const ContactReport* contact = cell.contacts.touching_now())
    return {"stopped", "a contact ended the step: " + contact->sentence(), "jog it away slowly"};
  const control::StopCause cause = cell.machine.snapshot().cause;
  return {"stopped",
          std::string("the step ended early: ") +
              (cause == control::StopCause::none ? "another client has the robot now" : control::name(cause)),
          "polyarm health shows the state"};
}

/// A step: the cell renews it as long as the client is connected, and reports its progress.
Poll<JogAnswer> follow_step(const JogOwners& cell, std::size_t i, std::uint32_t session,
                            jog::JogCommand command) {
  using Stepped = Progress<JogAnswer>;
  return [cell, i, session, command, own = session == 0, begun = false, renewed = Nanoseconds{0},
          reported = Nanoseconds{0}]() mutable {
    Jogging& jogging = cell.jogging;
    if (!begun) {
      if (!jogging.engage(i)) return Stepped{};
      session = jogging.session(i, session);
      command.step = jogging.new_step();
      jogging.send(i, session, command);
      begun = true;
      renewed = reported = cell.machine.now();
      return Stepped{};
    }
    const jog::JogStatus status = jogging.status(i);
    const bool over = status.step >= command.step;
    if (status.ended >= session || (!over && !jogging.engaged(i))) throw stopped(cell);
    JogAnswer out = jog_answer(cell, i);
    out.session = session;
    if (over && status.standing) {
      if (own) jogging.end(i, session);
      out.done = status.step_hold == jog::JogHold::none;
      out.held_back = name(status.step_hold);
      out.reason = reason_text(cell, i, status.step_hold, status.step_which);
      out.which = which_text(cell, i, status.step_hold, status.step_which);
      return Stepped::done(std::move(out));
    }
    if (cell.machine.now() - renewed >= kRenewEvery) {
      renewed = cell.machine.now();
      jogging.send(i, session, command);
    }
    if (cell.machine.now() - reported < kTellJogEvery) return Stepped{};
    reported = cell.machine.now();
    return Stepped::more(std::move(out));
  };
}

Poll<JogAnswer> jog(const JogOwners& cell, const JogMotion& request) {
  const std::size_t i = robot_named(cell.setup, request.robot);
  if (request.end) {
    cell.jogging.end(i, session_of(request.session));
    return at_once(jog_answer(cell, i));
  }
  jog::JogCommand command = jog_command(cell, *cell.setup.robots[i], request);
  const std::uint32_t session = session_of(request.session);
  cell.jogging.require_allowed(i);
  if (session != 0) cell.jogging.session(i, session);  // refused at once if the session has ended
  return command.by ? follow_step(cell, i, session, command) : follow_command(cell, i, session, command);
}

JogAnswer jog_state(const JogOwners& cell, const JogState& request) {
  return jog_answer(cell, robot_named(cell.setup, request.robot));
}

Poll<JogAnswer> target(const JogOwners& cell, const FollowTarget& request) {
  const std::size_t i = robot_named(cell.setup, request.robot);
  jog::JogCommand command = target_command(cell, i, request);
  const std::uint32_t session = session_of(request.session);
  cell.jogging.require_allowed(i);
  if (session != 0) cell.jogging.session(i, session);
  cell.jogging.estimate(i, session, command.wish);
  return follow_command(cell, i, session, command);
}

LimitsProfile::Answer profile(const JogOwners& cell, const LimitsProfile& request) {
  if (request.name) cell.motions.set_profile(*request.name);
  const jog::JogLimits limits = cell.motions.jog_limits();
  LimitsProfile::Answer out{cell.motions.profile(), limits.joint_share, {}};
  if (limits.tcp_speed < 1e6) out.tcp_speed = limits.tcp_speed;
  return out;
}

}  // namespace

std::vector<Handler> jog_handlers() {
  return handlers<jog, jog_state, target, profile>();
}

}  // namespace polyarm::cell
