#include "polyarm/server/jog_watch.hpp"

#include <algorithm>

#include "polyarm/protocol/status.hpp"
#include "polyarm/protocol/wire.hpp"

namespace polyarm::server {

using What = cell::HeldEvent::What;

protocol::PlanPreview way_of(const protocol::JogGoto& request) {
  protocol::PlanPreview out;
  out.to = request.to;
  out.joints = request.joints;
  out.pose = request.pose;
  out.kind = request.kind;
  out.robot = request.robot;
  out.speed = request.speed;
  return out;
}

void JogWatch::begin(std::uint64_t client, const protocol::Any& id, const protocol::JogBegin& request) {
  jogs_.push_back({motions_.begin(request), client, id});
}

void JogWatch::go_to(std::uint64_t client, const protocol::Any& id, const protocol::JogGoto& request) {
  jogs_.push_back({motions_.go_to(request), client, id});
}

bool JogWatch::owns(std::uint64_t client, std::uint64_t jog) const {
  return std::any_of(jogs_.begin(), jogs_.end(),
                     [&](const Jog& each) { return each.motion == jog && each.client == client; });
}

void JogWatch::beat(std::uint64_t client, std::uint64_t jog) {
  if (owns(client, jog)) motions_.renew(jog);
}

void JogWatch::end(std::uint64_t client, std::uint64_t jog, const char* why) {
  if (owns(client, jog)) motions_.end(jog, why);
}

void JogWatch::end_all(std::uint64_t client, const char* why) {
  for (const Jog& jog : jogs_)
    if (jog.client == client) motions_.end(jog.motion, why);
}

void JogWatch::report(const Jog& jog, const cell::HeldEvent& event) const {
  if (event.what == What::refused) return send_(jog.client, protocol::refusal_line(*event.refusal, jog.id));
  if (event.what == What::begun) {
    const protocol::JogBegun begun{jog.motion, event.session, 0.05, cell::HeldMotions::kSilence};
    return send_(jog.client, protocol::result_line(protocol::any_of(begun), jog.id));
  }
  protocol::JogEvent out;
  out.jog = jog.motion;
  out.robot = event.robot;
  out.over = event.what == What::over;
  out.why = event.why;
  out.text = event.text;
  out.which = event.which;
  send_(jog.client, protocol::any_of(out).dump());
}

void JogWatch::tick() {
  for (const cell::HeldEvent& event : motions_.take_events()) {
    const auto jog = std::find_if(jogs_.begin(), jogs_.end(),
                                  [&](const Jog& each) { return each.motion == event.motion; });
    if (jog == jogs_.end()) continue;
    report(*jog, event);
    if (event.what == What::over || event.what == What::refused) jogs_.erase(jog);
  }
}

}  // namespace polyarm::server
