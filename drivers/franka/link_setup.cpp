/// How a link begins and ends: connection, recovery, settings, motion; and the thread of the hand.
#include <arpa/inet.h>

#include <algorithm>
#include <utility>

#include "drivers/franka/errors.hpp"
#include "drivers/franka/link.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::franka {

namespace {

constexpr Nanoseconds kRound = 20'000'000;           // between two exchanges with the hand
constexpr Nanoseconds kOneState = 50'000'000;        // for a state to come
constexpr int kMostWaits = 2000;                     // states that may have gathered
constexpr Nanoseconds kAfterRecovery = 500'000'000;  // for the mode that follows

template <class Values>
Data as_numbers(const Values& values) {
  return numbers(std::span<const double>(values));
}

}  // namespace

Link::Link(LinkSettings settings)
    : StreamLink("the controller at " + settings.host),
      settings_(std::move(settings)),
      port_(settings_.host, settings_.port),
      hand_(settings_.host, settings_.hand),
      hand_wake_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)),
      shaper_(0.001) {}

/// The port of this machine for states; 0 if it could not be opened.
int Link::bind_states(const std::string& address) {
  std::string why;
  own_address_ = address;
  states_ = wire::bind_udp(address, 0, why);
  if (!states_) refuse(Cause::unreachable, 0, why);
  return states_ ? wire::local_port(states_.number()) : 0;
}

bool Link::connect() {
  version_ = settings_.version > 0 ? settings_.version : kNewestVersion;
  Refusal why;
  const auto bind = [this](const std::string& address) { return bind_states(address); };
  if (!connect_robot(port_, version_, settings_.timeout, bind, why))
    return why.cause != Cause::none && refuse(why.cause, why.detail, why.text);
  in_addr host{};
  ::inet_pton(AF_INET, port_.peer_address().c_str(), &host);
  robot_host_ = host.s_addr;
  limits_ = settings_.limits;
  const MotionLimits& robot = motion_limits(version_);
  for (std::size_t i = 0; i < 7; ++i) {
    limits_.of[1][i] = std::min(limits_.of[1][i], 0.97 * robot.acceleration[i]);
    limits_.of[2][i] = std::min(limits_.of[2][i], 0.97 * robot.jerk[i]);
  }
  return true;
}

bool Link::await_first_state() {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, std::chrono::nanoseconds(settings_.timeout),
                    [this] { return fault_ || states_seen_ > 0; });
  if (fault_) return false;
  if (states_seen_ > 0) return true;
  const std::string from = stranger_;
  lock.unlock();
  if (!from.empty()) return refuse(Cause::other_sender, 0, from);
  return refuse(Cause::silent, 0, own_address_ + ":" + std::to_string(wire::local_port(states_.number())));
}

bool Link::open() {
  close();
  fault_.clear();
  refused_.clear();
  current_ = {};
  states_seen_ = 0;
  pinned_ = port_lost_ = false;
  answered_ = 0;
  stranger_.clear();
  replies_.clear();
  motion_.reset();
  heard_ = realtime::monotonic_now();
  if (!connect()) {
    port_.close();
    return false;
  }
  quit_ = false;
  thread_ = std::thread([this] { run(); });
  if (await_first_state() && open_hand()) return true;
  const auto fault = fault_.value();
  const std::string said = text();
  if (fault_) refuse(fault.cause, fault.detail, said);
  const auto why = refused_.value();
  close();
  fault_.clear();
  refuse(why.cause, why.detail, said);
  return false;
}

void Link::close() {
  stop();
  quit_ = true;
  wake();
  ::eventfd_write(hand_wake_.number(), 1);
  if (thread_.joinable()) thread_.join();
  if (hand_thread_.joinable()) hand_thread_.join();
  port_.close();
  states_ = Descriptor();
  const std::lock_guard lock(hand_mutex_);
  hand_.close();
  hand_open_ = false;
}

// --- requests ---------------------------------------------------------------------------------------------

/// Nothing: refused() has the cause.
std::optional<Status> Link::request(Request what, const Data& data) {
  const auto number = number_of(what, version_);
  if (!number) return Status::not_possible;
  std::unique_lock lock(mutex_);
  replies_.clear();  // requests come one at a time: nobody waits for an older reply
  const auto id = port_.send(*number, data);
  const auto came = [&] { return fault_ || (id && replies_.contains(*id)); };
  // The robot may move before it answers that it recovered.
  const Nanoseconds most =
      what == Request::recover ? std::max(settings_.timeout, settings_.start_timeout) : settings_.timeout;
  if (id) changed_.wait_for(lock, std::chrono::nanoseconds(most), came);
  if (id && replies_.contains(*id)) {
    const Status status = status_of(replies_[*id].data[0], what, version_);
    replies_.erase(*id);
    return status;
  }
  lock.unlock();
  if (!fault_) refuse(id ? Cause::command_silent : Cause::closed);
  return std::nullopt;
}

bool Link::set(Request what, const Data& data) {
  const auto status = request(what, data);
  if (!status) return false;
  if (*status == Status::success) return true;
  if (*status == Status::refused_by_safety) return refuse(Cause::safety);
  return refuse(Cause::setting_refused, 16 * static_cast<int>(what) + static_cast<int>(*status));
}

/// The robot's own recovery, which may move a joint back into its range.
bool Link::recover() {
  ErrorFlags errors;
  {
    const std::lock_guard lock(mutex_);
    errors = errors_;
  }
  if (!settings_.recover) return refuse(Cause::reflex_pending, first_error(errors), error_names(errors));
  const auto status = request(Request::recover, {});
  if (!status) return false;
  if (*status == Status::user_stop) return refuse(Cause::user_stop);
  if (*status == Status::refused_by_safety) return refuse(Cause::safety);
  if (*status != Status::success) return refuse(Cause::recovery_refused, static_cast<int>(*status));
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, std::chrono::nanoseconds(std::max(kAfterRecovery, settings_.timeout)), [this] {
    return fault_ || (mode_ != RobotMode::reflex && mode_ != RobotMode::recovery);
  });
  return !fault_;
}

/// Until the states that have come are read: the newest one decides.
void Link::await_newest_state() {
  std::uint64_t before = states_seen_;
  for (int i = 0; i < kMostWaits; ++i) {
    std::unique_lock lock(mutex_);
    const bool came = changed_.wait_for(lock, std::chrono::nanoseconds(kOneState),
                                        [&] { return fault_ || states_seen_ > before; });
    if (fault_ || !came) return;
    before = states_seen_;
    lock.unlock();
    if (!wire::wait_readable(states_.number(), 0)) return;
  }
}

bool Link::check_mode() {
  await_newest_state();
  if (mode_ == RobotMode::reflex && !recover()) return false;
  switch (mode_.load()) {
    case RobotMode::user_stopped:
      return refuse(Cause::user_stop);
    case RobotMode::guiding:
      return refuse(Cause::guiding);
    case RobotMode::other:
      return refuse(Cause::locked);
    case RobotMode::move:
      return refuse(Cause::motion_refused, static_cast<int>(Status::not_possible));
    case RobotMode::reflex:
    case RobotMode::recovery:
      return refuse(Cause::recovery_refused, static_cast<int>(Status::reflex));
    default:
      return true;
  }
}

bool Link::set_up_robot() {
  const RobotSettings& robot = settings_.robot;
  if (robot.collision && !set(Request::set_collision_behavior, encode(*robot.collision))) return false;
  if (robot.joint_stiffness && !set(Request::set_joint_impedance, as_numbers(*robot.joint_stiffness)))
    return false;
  if (robot.cartesian_stiffness &&
      !set(Request::set_cartesian_impedance, as_numbers(*robot.cartesian_stiffness)))
    return false;
  if (robot.guiding && !set(Request::set_guiding_mode, Data(robot.guiding->begin(), robot.guiding->end())))
    return false;
  return !robot.load || set(Request::set_load, encode(*robot.load));
}

bool Link::refuse_motion(Status status) {
  switch (status) {
    case Status::user_stop:
      return refuse(Cause::user_stop);
    case Status::refused_by_safety:
    case Status::preempted_by_safety:
      return refuse(Cause::safety);
    default:
      return refuse(Cause::motion_refused, static_cast<int>(status));
  }
}

bool Link::begin_motion() {
  std::unique_lock lock(mutex_);
  renew(lock);
  phase_ = Phase::starting;
  MoveRequest move;
  move.controller = settings_.controller;
  move.generator = settings_.generator;
  motion_ = port_.send(*number_of(Request::move, version_), encode(move, version_));
  if (!motion_) {
    lock.unlock();
    return refuse(Cause::closed);
  }
  const auto refused = [this] { return motion_reply_ && *motion_reply_ != Status::started; };
  changed_.wait_for(lock, std::chrono::nanoseconds(settings_.start_timeout),
                    [&] { return fault_ || phase_ == Phase::streaming || refused(); });
  if (phase_ == Phase::streaming || fault_) return !fault_;
  const auto reply = motion_reply_;
  lock.unlock();
  if (!reply) return refuse(Cause::command_silent);
  return refuse_motion(*reply);
}

/// The motion that was asked for does not begin later.
void Link::give_up_start() {
  const auto why = refused_.value();
  const std::string said = text();
  stop();
  if (why.cause != Cause::none) refuse(why.cause, why.detail, said);
}

bool Link::start() {
  if (!thread_.joinable()) return refuse(Cause::silent);
  if (fault_) return false;
  refused_.clear();
  {
    const std::lock_guard lock(hand_mutex_);
    wishes_.fetch();  // what was wanted before counts no more
    hand_wish_ = HandWish();
    hand_.forget();
  }
  if (!check_mode() || !set_up_robot()) return false;
  if (begin_motion()) return true;
  give_up_start();
  return false;
}

/// Where the robot ended the motion by itself, nothing is changed.
void Link::stop() {
  if (phase_ == Phase::idle) return;
  {
    const std::lock_guard lock(hand_mutex_);
    wishes_.fetch();
    hand_wish_ = HandWish();  // the hand ends what it does, and begins nothing new
  }
  {
    std::unique_lock lock(mutex_);
    if (phase_ == Phase::starting) stands_ = true;
    phase_ = Phase::ending;
    wake();
    changed_.wait_for(lock, std::chrono::nanoseconds(settings_.start_timeout),
                      [this] { return stands_.load(); });
    stands_ = true;
  }
  const std::lock_guard lock(mutex_);
  // A motion that is asked for, or did not end in time, ends; nobody waits for the reply.
  if (motion_ || mode_ == RobotMode::move) port_.send(*number_of(Request::stop_move, version_), {});
  phase_ = Phase::idle;
}

// --- the hand ---------------------------------------------------------------------------------------------

bool Link::open_hand() {
  if (!settings_.hand.used) return true;
  const std::lock_guard lock(hand_mutex_);
  if (!hand_.open(settings_.timeout)) {
    const Refusal& why = hand_.refusal();
    return refuse(why.cause, why.detail, why.text);
  }
  hand_open_ = true;
  panels_.write({hand_.state(), false});
  if (!settings_.stepped) hand_thread_ = std::thread([this] { run_hand(); });
  return true;
}

void Link::serve_hand(std::uint32_t id) {
  const std::lock_guard lock(hand_mutex_);
  if (!hand_open_ || fault_) return;
  if (wishes_.fetch()) hand_wish_ = wishes_.value();
  if (id > 0) hand_.await_state(id, settings_.timeout);
  if (!hand_.serve(hand_wish_, realtime::monotonic_now(), settings_.timeout)) {
    const Refusal& why = hand_.refusal();
    return note(why.cause, why.detail, why.text);
  }
  panels_.write({hand_.state(), hand_.busy()});
}

void Link::run_hand() {
  while (!quit_) {
    wire::wait_readable(hand_wake_.number(), kRound);
    calm(hand_wake_.number());
    if (!quit_) serve_hand(0);
  }
}

}  // namespace polyarm::franka
