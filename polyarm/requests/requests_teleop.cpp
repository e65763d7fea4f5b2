/// The request about robots that lead others.
#include "polyarm/base/text.hpp"
#include "polyarm/inside/requests_work.hpp"
#include "polyarm/operation/jog_commands.hpp"
#include "polyarm/operation/teleoperation.hpp"
#include "polyarm/protocol/teleop.hpp"
#include "polyarm/requests/families.hpp"

namespace polyarm::cell {

namespace {

struct TeleopOwners {
  const CellSetup& setup;
  Machine& machine;
  CellData& data;
  const ContactWatch& contacts;
  Motions& motions;
  const Programs& programs;
  Jogging& jogging;
  Teleoperation& teleoperation;
  JogOwners of_jog() const { return {setup, machine, data, contacts, motions, programs, jogging}; }
};

constexpr double kLongestHold = 1;  // s
constexpr const char* kMappings[] = {"joints", "tcp"};
constexpr const char* kClutches[] = {"key", "tag", "gripper"};

protocol::TeleopPair pair_of(const JogOwners& jog, const Teleoperation& teleoperation, std::size_t i) {
  const teleop::PairSettings& settings = teleoperation.settings(i);
  const Teleoperation::State state = teleoperation.state(i);
  protocol::TeleopPair out;
  out.name = settings.name;
  out.leader = settings.leader;
  out.follower = settings.follower;
  out.mapping = kMappings[static_cast<std::size_t>(settings.mapping)];
  out.clutch = kClutches[static_cast<std::size_t>(settings.clutch)];
  out.state = teleop::kTeleopPhases[static_cast<std::size_t>(state.phase)];
  out.reason = state.reason;
  out.furthest = state.furthest;
  out.distance = state.distance;
  if (teleop::moves(state.phase)) {
    const std::size_t follower = robot_named(jog.setup, settings.follower);
    const jog::JogStatus status = jog.jogging.status(follower);
    out.reason = reason_text(jog, follower, status.hold, status.which);
  }
  return out;
}

protocol::Teleop::Answer teleop_pairs(const TeleopOwners& cell, const protocol::Teleop& request) {
  if (request.hold) {
    const double hold = *request.hold;
    if (!(hold == 0 || (hold >= 0.02 && hold <= kLongestHold)))
      throw Error("bad-argument", "'hold' is " + format_number(hold) + " s",
                  "0 to release the clutch, or 0.02 to 1 s");
    cell.teleoperation.hold_key(cell.teleoperation.find(request.pair), nanoseconds(hold));
  } else if (request.pair) {
    cell.teleoperation.find(request.pair);
  }
  protocol::Teleop::Answer out;
  for (std::size_t i = 0; i < cell.teleoperation.size(); ++i)
    if (!request.pair || cell.teleoperation.settings(i).name == *request.pair)
      out.pairs.push_back(pair_of(cell.of_jog(), cell.teleoperation, i));
  return out;
}

}  // namespace

std::vector<Handler> teleop_handlers() {
  return handlers<teleop_pairs>();
}

}  // namespace polyarm::cell
