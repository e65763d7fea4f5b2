/// How a link in forward mode begins and ends.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "drivers/abb/forward_link.hpp"
#include "drivers/abb/rapid.hpp"
#include "drivers/wire/six_axes.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::abb {

namespace {

constexpr Nanoseconds kLookAgain = 50'000'000;
constexpr double kSamePlace = 0.005, kSameTurn = 0.02;  // m, rad between the flange here and there

}  // namespace

ForwardLink::ForwardLink(ForwardSettings settings)
    : MoveLink({settings.frame, kMoveSlots}, settings.times, settings, settings.times.stepped,
               settings.start_timeout),
      settings_(std::move(settings)),
      port_(settings_.rws.http.host, settings_.moves_port) {}

bool ForwardLink::check_controller() {
  if (!identity().recent()) return refuse(Cause::old_software, 0, identity().software);
  if (rws_.has_module(settings_.task, kMovesModule)) return true;
  const bool missing = rws_.failure().cause == Cause::no_module;
  return missing ? refuse(Cause::no_moves_module, 0, settings_.task) : refuse_rws();
}

bool ForwardLink::open() {
  close();
  const std::lock_guard lock(rws_mutex_);
  fault_.clear();
  refused_.clear();
  current_ = {};
  samples_.write(current_);
  if (!(connect_services() && check_controller() && read_first())) {
    rws_.close();
    return false;
  }
  open_ = true;
  gone_ = false;
  run_threads();
  return true;
}

void ForwardLink::close() {
  stop();
  halt_threads();
  const std::lock_guard lock(rws_mutex_);
  port_.close();
  if (std::exchange(open_, false)) rws_.log_out();
  rws_.close();
}

void ForwardLink::halt_threads() {
  halt_thread();
  halt_service_thread();
}

void ForwardLink::run_threads() {
  run_thread();
  run_service_thread();
}

/// Before the thread runs. Nothing: it is refused.
std::optional<MoveReply> ForwardLink::ask_first(const MoveRequest& request) {
  if (port_.send(request))
    if (auto reply = await_reply()) return reply;
  refuse_why(port_.failure().cause == Cause::none ? Cause::moves_silent : port_.failure().cause);
  return std::nullopt;
}

/// The program needs a moment until it listens.
bool ForwardLink::connect_program() {
  const Nanoseconds deadline = realtime::monotonic_now() + settings_.start_timeout;
  for (; !port_.open(settings_.timeout); wire::wait_readable(-1, kLookAgain))
    if (realtime::monotonic_now() > deadline) return refuse_why(port_.failure().cause, port_.failure().text);
  return true;
}

/// A wrong model, or a base that is not the controller's world frame.
bool ForwardLink::check_frame(const MoveReply& reply) {
  const Six q = wire::scaled(reply.joints, wire::kRadians);
  const Pose there = pose_of(reply.flange), here = settings_.frame.flange->forward(q);
  const Vec3 way = there.position - here.position;
  const double turn = angle_between(there.rotation, here.rotation);
  if (norm(way) < kSamePlace && turn < kSameTurn) return true;
  return refuse(Cause::frame_differs, 0,
                fmt::format("x {:.0f}, y {:.0f}, z {:.0f} mm, turned by {:.1f} degrees", 1000 * way.x,
                            1000 * way.y, 1000 * way.z, turn * wire::kDegrees));
}

bool ForwardLink::begin_moves() {
  const auto state = ask_first({});
  if (!state) return false;
  if (state->version != kMovesVersion || state->result == MoveResult::version)
    return refuse(Cause::moves_version, state->version);
  if (!check_frame(*state)) return false;
  const auto begun = ask_first({0, MoveDo::begin, 0, settings_.watchdog_ms, {}, {}});
  if (!begun) return false;
  if (begun->result != MoveResult::done || begun->session == 0)
    return refuse(Cause::moves_refused, static_cast<int>(begun->result));
  session_ = begun->session;
  current_ = {};
  time_ms_ = 0;
  take(*begun);
  return true;
}

bool ForwardLink::start() {
  if (!runs()) return refuse(Cause::rws_silent, 0, "the last question");
  if (fault_) return false;
  refused_.clear();
  halt_threads();
  const std::lock_guard lock(rws_mutex_);
  const bool ready = begin_services() && check_panel();
  const bool fine = ready && begin_program(true) && connect_program() && begin_moves();
  if (fine) {
    end_asked_ = false;
    percent_ = -1;
    begin_queue(report());
    begin_session();
  } else {
    const auto why = refused_.value();
    const std::string said = text();
    if (ready) end_program();
    refuse(why.cause, why.detail, said);
  }
  run_threads();
  return fine;
}

/// Nobody who presses Start there goes on with its moves.
void ForwardLink::end_program() {
  port_.close();
  rws_.stop_program();
  rws_.reset_pointer();
}

void ForwardLink::stop() {
  if (phase_ == Phase::idle) return;
  finish(settings_.timeout + settings_.answer);
  halt_threads();
  {
    const std::lock_guard lock(rws_mutex_);
    end_program();
    if (current_.count > 0) current_panel_.joints = current_.q;  // those of before the motion are old
    panels_.write(current_panel_);
    read_states_next();
  }
  if (!fault_) run_threads();
}

}  // namespace polyarm::abb
