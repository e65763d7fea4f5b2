/// How a link in forward mode begins and ends.
#include <algorithm>
#include <utility>

#include "drivers/yaskawa/forward_link.hpp"

namespace polyarm::yaskawa {

namespace {

constexpr Nanoseconds kPause = 5'000'000;     // between two looks
constexpr Nanoseconds kSlack = 200'000'000;   // beside the timer of the ladder
constexpr Nanoseconds kStop = 3'000'000'000;  // for a job to stop
constexpr std::int32_t kNumbersAnew = 1'000'000'000;

}  // namespace

ForwardLink::ForwardLink(ForwardSettings settings)
    : MoveLink({settings.frame, kMoveSlots, forward::MoveQueue::Paces::in_moves}, settings.times,
               "the controller at " + settings.host),
      settings_(std::move(settings)),
      hses_(settings_.host, settings_.hses_port, settings_.answer) {}

bool ForwardLink::refuse_hses() {
  return refuse(hses_.failure().cause, hses_.failure().detail, hses_.failure().text);
}

bool ForwardLink::open() {
  close();
  fault_.clear();
  refused_.clear();
  current_ = {};
  session_open_ = holding_ = forgotten_ = false;
  gone_ = false;
  if (!hses_.open() || !hses_.status()) return refuse_hses();
  const std::string version = hses_.system(kFirstRobot, 1), model = hses_.system(kFirstRobot, 2);
  system_ = model + (model.empty() || version.empty() ? "" : ", ") + version;
  if (!read()) {
    hses_.close();
    return false;
  }
  run_thread();
  return true;
}

void ForwardLink::close() {
  stop();
  halt_thread();
  hses_.close();
}

/// Until `seen(status)`. `beats`: with the heartbeat. False without a cause: it was not seen in time.
template <typename Seen>
bool ForwardLink::await_status(Nanoseconds timeout, bool beats, Seen seen) {
  const Nanoseconds deadline = realtime::monotonic_now() + timeout;
  for (;; wire::wait_readable(-1, settings_.times.stepped ? 0 : kPause)) {
    if (beats) beat_ = !beat_;
    if (beats && !write_beat()) return refuse_hses();
    const auto status = hses_.status();
    if (!status) return refuse_hses();
    current_.status = *status;
    if (seen(*status)) return true;
    if (realtime::monotonic_now() > deadline) return false;
  }
}

/// What a person has to change at the controller first. A hold from outside may be that of the ladder.
bool ForwardLink::check_panel(const HsesStatus& status) {
  if (status.alarm || status.error) {
    const auto alarm = hses_.alarm();
    if (!alarm) return refuse_hses();
    return refuse(status.alarm ? Cause::alarm : Cause::error, static_cast<int>(alarm->code), alarm->name);
  }
  if (status.teach) return refuse(Cause::teach_mode);
  if (!status.remote) return refuse(Cause::not_remote);
  if (status.pendant_hold) return refuse(Cause::hold, 1);
  return status.servo || settings_.servo_on || refuse(Cause::servo_off);
}

/// Our job of a session before may wait there, or hang in a move. A job of somebody else is left alone.
bool ForwardLink::end_old_job(const HsesStatus& status) {
  if (status.running) {
    const auto job = hses_.job();
    if (!job) return refuse_hses();
    if (*job != kMovesJob) return refuse(Cause::job_runs, 0, *job);
    if (!hses_.hold(true)) return refuse_hses();
    if (!await_status(kStop, false, [](const HsesStatus& s) { return !s.running; }))
      return refused_ ? false : refuse(Cause::hold_ignored);
  }
  return hses_.hold(false) || refuse_hses();
}

/// Without the heartbeat the robot is held; with it, it is not.
bool ForwardLink::prove_watchdog() {
  session_open_ = true;
  if (!write_beat()) return refuse_hses();
  const Nanoseconds most = 2 * settings_.watchdog + kSlack;
  if (!await_status(most, false, [](const HsesStatus& s) { return s.external_hold; }))
    return refused_ ? false : refuse(Cause::no_watchdog);
  if (await_status(most, true, [](const HsesStatus& s) { return !s.external_hold; })) return true;
  return !refused_ && refuse(Cause::hold, 2);
}

/// Numbers go on from those that are there: a request of before that comes late finds them used.
bool ForwardLink::prepare_job() {
  if (!hses_.select_job(kMovesJob)) return refuse_hses();
  const auto before = hses_.doubles(SharedDoubles::first, SharedDoubles::count);
  if (!before) return refuse_hses();
  std::copy_n(before->begin(), shared_.size(), shared_.begin());
  const auto next = [](std::int32_t number) { return number < 0 || number > kNumbersAnew ? 0 : number; };
  put_ = next(shared(SharedDoubles::put));
  output_asked_ = next(shared(SharedDoubles::output));
  const std::int32_t session = next(shared(SharedDoubles::session)) + 1;
  using S = SharedDoubles;
  const std::pair<int, std::int32_t> values[] = {
      {S::put, put_},  {S::ended, put_},           {S::session, session},          {S::session_here, 0},
      {S::version, 0}, {S::output, output_asked_}, {S::output_done, output_asked_}};
  for (const auto& [number, value] : values) {
    beat_ = !beat_;
    if (!write_beat() || !hses_.set_double(number, value)) return refuse_hses();
  }
  shared_[S::session - S::first] = session;
  return true;
}

bool ForwardLink::switch_servo_on() {
  if (current_.status.servo) return true;
  if (!hses_.servo(true)) {
    if (hses_.failure().cause != Cause::hses_refused) return refuse_hses();
    return refuse(Cause::servo_refused);
  }
  if (await_status(settings_.start_timeout, true, [](const HsesStatus& s) { return s.servo; })) return true;
  return !refused_ && refuse(Cause::servo_refused);
}

/// The job says that it began in this session, and which one it is.
bool ForwardLink::start_job() {
  if (!current_.status.continuous && !hses_.run_continuously()) return refuse_hses();
  const std::int32_t session = shared(SharedDoubles::session);
  if (!hses_.start_job()) return refuse_hses();
  const auto began = [&](const HsesStatus& status) {
    const auto now = hses_.doubles(SharedDoubles::first, SharedDoubles::count);
    if (now) std::copy_n(now->begin(), shared_.size(), shared_.begin());
    return !now || (status.running && shared(SharedDoubles::session_here) == session);
  };
  if (!await_status(settings_.start_timeout, true, began)) return !refused_ && refuse(Cause::job_stopped);
  if (hses_.failure().cause != Cause::none) return refuse_hses();
  const int version = shared(SharedDoubles::version);
  return version == kMovesJobVersion || refuse(Cause::job_version, version);
}

bool ForwardLink::begin() {
  const auto status = hses_.status();
  if (!status) return refuse_hses();
  current_.status = *status;
  return check_panel(*status) && end_old_job(*status) && prove_watchdog() && prepare_job() &&
         switch_servo_on() && start_job();
}

/// What was begun ends: the robot stands, and the job waits in its first line.
void ForwardLink::give_up() {
  if (!session_open_) return;
  session_open_ = false;
  hses_.hold(true);
  hses_.select_job(kMovesJob);
  write_beat();
  hses_.hold(false);
}

bool ForwardLink::start() {
  if (!runs()) return refuse(Cause::hses_silent);
  if (fault_) return false;
  refused_.clear();
  halt_thread();
  const bool fine = begin() && read();
  if (fine) {
    written_ = Outputs();
    holding_ = forgotten_ = false;
    halting_ = halted_ = unread_ = 0;
    ended_ = put_;
    end_ = End::hold;
    begin_session();
    read_at_ = started_at_ = now();
    begin_queue({now(), current_.q, put_, halted_});
  } else if (const Cause why = refused_.cause(); why == Cause::hses_silent || why == Cause::hses_bad_data) {
    gone_ = true;
    note(why);
  } else {
    give_up();
  }
  run_thread();
  return fine;
}

void ForwardLink::stop() {
  if (phase_ != Phase::idle) finish(settings_.timeout + kStop);
}

}  // namespace polyarm::yaskawa
