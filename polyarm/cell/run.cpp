#include "polyarm/cell/run.hpp"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "polyarm/base/text.hpp"
#include "polyarm/cell/socket_door.hpp"
#include "polyarm/inside/inside.hpp"
#include "polyarm/inside/view.hpp"
#include "polyarm/io/typed_words.hpp"
#include "polyarm/io/worker.hpp"
#include "polyarm/protocol/hardware.hpp"
#include "polyarm/realtime/bell.hpp"
#include "polyarm/realtime/periodic.hpp"
#include "polyarm/realtime/refusals.hpp"

namespace polyarm::cell {

namespace {

std::atomic<control::Supervisor*> running_supervisor{nullptr};
std::atomic<int> stop_requests{0};

/// The loop counts as hung if no cycle has ended for this long.
constexpr Nanoseconds kLoopSilence = 200'000'000;
/// Between two ticks, incoming requests are handled at most this often; a flood waits for the tick.
constexpr int kMostBetween = 16;
/// In lock-step nobody can resume a held cell, so the run ends after this cell time.
constexpr Nanoseconds kHeldPatience = 10'000'000'000;

/// An empty loop that runs in parallel to the real one with the same settings, except for the CPU pinning. It
/// measures how late the machine itself is.
class EmptyLoop {
 public:
  EmptyLoop(Nanoseconds period, realtime::ThreadOptions thread)
      : thread_([this, period, thread] {
          realtime::apply({thread.priority, -1, false});
          realtime::Periodic clock(period);
          for (clock.start(); !done_.load(std::memory_order_relaxed);) {
            const realtime::WakeUp wake = clock.wait();
            late_ += (wake.latency > period / 2 ? 1 : 0) + wake.skipped;
          }
        }) {}
  std::uint64_t finish() {
    done_ = true;
    thread_.join();
    return late_;
  }

 private:
  std::atomic<bool> done_{false};
  std::uint64_t late_ = 0;
  std::thread thread_;
};

/// Reads typed lines without blocking.
class Console {
 public:
  explicit Console(bool on) : on_(on) {}
  std::optional<std::string> line() {
    for (pollfd waiting{STDIN_FILENO, POLLIN, 0}; on_ && ::poll(&waiting, 1, 0) > 0;) {
      char text[256];
      const ssize_t n = ::read(STDIN_FILENO, text, sizeof text);
      if (n <= 0)
        on_ = false;
      else
        buffer_.append(text, static_cast<std::size_t>(n));
    }
    const auto end = buffer_.find('\n');
    if (end == std::string::npos) return std::nullopt;
    std::string out(trim(std::string_view(buffer_).substr(0, end)));
    buffer_.erase(0, end + 1);
    return out;
  }
  bool on() const { return on_; }
  bool is_terminal() const { return ::isatty(STDIN_FILENO) != 0; }

 private:
  bool on_;
  std::string buffer_;
};

/// The thread of the loop. Its shared state is separate from the cell, so a run can end without the thread.
class ControlThread {
 public:
  ControlThread(control::ControlLoop& loop, realtime::ThreadOptions options)
      : shared_(std::make_shared<Shared>()), thread_([&loop, options, shared = shared_] {
          shared->refused.store(realtime::apply_each(options), std::memory_order_release);
          realtime::Periodic clock(loop.options().period);
          for (clock.start(); !shared->done.load(std::memory_order_relaxed);) {
            const auto paced = loop.hardware().exchange().await_cycle(2 * loop.options().period);
            const realtime::WakeUp wake = paced ? clock.woken() : clock.wait();
            loop.step_next(loop.woke(wake.latency, wake.skipped));
          }
          const std::lock_guard lock(shared->mutex);
          shared->ended = true;
          shared->wake.notify_all();
        }) {}
  ~ControlThread() {
    if (thread_.joinable()) thread_.detach();
  }
  /// Bits of the options that the machine refused; reset by the call.
  unsigned refused() { return shared_->refused.exchange(0, std::memory_order_acquire); }
  /// False if the thread has not ended within `patience` ns; it then continues until it does.
  bool end(Nanoseconds patience) {
    shared_->done = true;
    std::unique_lock lock(shared_->mutex);
    if (!shared_->wake.wait_for(lock, std::chrono::nanoseconds(patience), [this] { return shared_->ended; }))
      return false;
    lock.unlock();
    thread_.join();
    return true;
  }

 private:
  struct Shared {
    std::atomic<bool> done{false};
    std::atomic<unsigned> refused{0};
    std::mutex mutex;
    std::condition_variable wake;
    bool ended = false;
  };
  std::shared_ptr<Shared> shared_;
  std::thread thread_;
};

class Runner {
 public:
  Runner(Cell& cell, const RunOptions& options, Observer& observer)
      : door_(cell),
        cell_(inside_of(cell)),
        options_(options),
        observer_(cell_.events),
        console_(options.console && !options.fast) {
    cell_.observers.add(observer);
    cell_.programs->answers().can_answer = console_.on();
    wall_start_ = realtime::monotonic_now();
    limit_ = options.seconds > 0 ? nanoseconds(options.seconds) : INT64_MAX;
  }

  RunResult run() {
    running_supervisor = &cell_.machine.loop().supervisor();
    cell_.machine.loop().begin();
    if (options_.fast)
      lock_step();
    else
      wall_clock();
    if (!stuck_) cell_.machine.loop().end();
    if (!stuck_ && cell_.recorder) cell_.recorder->stop();
    running_supervisor = nullptr;
    const RunResult out = result();
    stop_requests = 0;
    return out;
  }

 private:
  void lock_step() {
    control::ControlLoop& loop = cell_.machine.loop();
    const std::unique_ptr<SocketDoor> door = options_.fast_socket ? open_door() : nullptr;
    const auto doors = open_doors();
    nobody_answers_ = !door && doors.empty() && options_.doors.empty() && !cell_.setup.options.test;
    Nanoseconds next_tick = 0;
    while (!over_) {
      if (loop.cycle().time >= next_tick) {
        next_tick = loop.cycle().time + Cell::kTick;
        if (door) door->serve(cell_.requests);
        serve(doors);
        after_tick(loop.cycle().time);
        if (over_) break;
      }
      loop.step_next();
    }
  }

  void wall_clock() {
    const std::unique_ptr<SocketDoor> door = options_.socket ? open_door() : nullptr;
    const auto doors = open_doors();
    cell_.arming->announce();
    EmptyLoop empty(cell_.machine.loop().options().period, thread_options());
    ControlThread control(cell_.machine.loop(), thread_options());
    const auto bell = std::make_shared<realtime::Bell>();
    hang(bell, door.get(), doors);
    realtime::Periodic clock(Cell::kTick);
    Nanoseconds due = realtime::monotonic_now() + Cell::kTick;
    for (clock.start(); !over_;) {
      for (int i = 0; i < kMostBetween && bell->wait_until(due); ++i) take(door.get(), doors);
      const realtime::WakeUp wake = clock.wait();
      due = wake.due + static_cast<Nanoseconds>(wake.skipped + 1) * Cell::kTick;
      cell_.machine.loop().outbox().fetch();
      const hardware::Cycle seen = cell_.machine.snapshot().cycle;
      if (door) door->serve(cell_.requests);
      serve(doors);
      watch_loop();
      tell_refused(control.refused());
      after_tick(seen.time + seen.period);
      while (const auto line = console_.line()) typed(*line);
    }
    hang(nullptr, door.get(), doors);
    stuck_ = !control.end(options_.patience);
    late_empty_ = empty.finish();
  }

  std::unique_ptr<SocketDoor> open_door() {
    try {
      auto door = std::make_unique<SocketDoor>(cell_.setup.file.name);
      if (door->path().stem() != cell_.setup.file.name)
        observer_.on_note("this cell answers as '" + door->path().stem().string() + "'");
      return door;
    } catch (const Error& e) {
      observer_.on_note(std::string(e.what()) + "; other programs cannot reach this cell");
      return nullptr;
    }
  }

  std::vector<std::unique_ptr<Door>> open_doors() {
    std::vector<std::unique_ptr<Door>> out;
    for (const auto& [name, options] : cell_.setup.file.doors) try {
        out.push_back(cell::open_door(name, door_.view(), options));
        observer_.on_note(out.back()->address());
      } catch (const Error& e) {
        observer_.on_note(std::string(e.what()) + "; the door '" + name + "' stays shut");
      }
    return out;
  }

  void serve(const std::vector<std::unique_ptr<Door>>& doors) const {
    for (const auto& door : doors) door->serve();
    for (Door* const door : options_.doors) door->serve();
  }

  /// Doors and the worker thread ring the bell when they have something for the cell.
  void hang(const std::shared_ptr<realtime::Bell>& bell, SocketDoor* socket,
            const std::vector<std::unique_ptr<Door>>& doors) {
    if (socket) socket->set_wakeup(bell);
    for (const auto& door : doors) door->set_wakeup(bell);
    for (Door* const door : options_.doors) door->set_wakeup(bell);
    cell_.worker.set_wakeup(bell);
    cell_.long_worker.set_wakeup(bell);
  }

  /// Between two ticks: starts requests that have arrived, and continues those that waited for the worker.
  void take(SocketDoor* socket, const std::vector<std::unique_ptr<Door>>& doors) {
    cell_.machine.loop().outbox().fetch();
    if (socket) socket->serve(cell_.requests);
    for (const auto& door : doors) door->take();
    for (Door* const door : options_.doors) door->take();
    cell_.requests.tick();
  }

  realtime::ThreadOptions thread_options() const {
    return control_thread(options_, cell_.setup.file.loop, cell_.setup.manager);
  }

  /// Reports once what the machine refused the control thread.
  void tell_refused(unsigned refused) {
    if (refused == 0) return;
    for (const std::string& text : realtime::refusals(refused, thread_options(), "the control thread"))
      observer_.on_note(text);
  }

  /// The loop monitors the cell thread; here the cell thread monitors the loop, and can only report.
  void watch_loop() {
    const std::uint64_t cycles = cell_.machine.loop().health().cycles,
                        gaps = cell_.machine.loop().health().gaps;
    if (std::exchange(gaps_, gaps) != gaps)
      observer_.on_note(
          "wall time was lost; a simulated cell continues (loop: {stall: hold} holds it instead)");
    const Nanoseconds now = realtime::monotonic_now();
    if (cycles != seen_cycles_) {
      if (loop_silent_)
        observer_.on_note("the control loop continues after " +
                          format_number(std::round(seconds(now - cycles_seen_at_) * 10) / 10) + " s");
      loop_silent_ = false;
      seen_cycles_ = cycles;
      cycles_seen_at_ = now;
    } else if (!loop_silent_ &&
               now - cycles_seen_at_ > std::max(kLoopSilence, 5 * cell_.machine.loop().options().period)) {
      loop_silent_ = true;
      observer_.on_note(standing_still());
    }
  }

  std::string standing_still() {
    const hardware::Hardware& hardware = cell_.machine.loop().hardware();
    const control::ControllerManager& controllers = cell_.machine.loop().controllers();
    if (const int who = hardware.diagnostics().in_call(); who >= 0)
      return "the control loop does not run: it waits for the hardware component " +
             hardware.component_name(static_cast<std::size_t>(who)) + "; give it is_async=\"true\"";
    if (const int who = controllers.in_call(); who >= 0)
      return "the control loop does not run: it waits for the controller " + controllers.name_of(who) +
             "; give it is_async: true";
    return "the control loop does not run";
  }

  void typed(const std::string& line) {
    const std::optional<protocol::Request> request = typed_request(line);
    if (line == "resume") stop_requests = 0;
    if (line == "arm" && cell_.arming->needed() && !console_.is_terminal()) {
      observer_.on_note("only a person at a terminal arms real hardware");
    } else if (line == "arm" && cell_.arming->needed()) {
      protocol::ControlArm arm;
      arm.confirmed = true;
      ask(arm);
    } else if (line == "stop") {
      request_stop();
    } else if (request) {
      ask(*request);
    } else {
      answer(line);
    }
  }

  /// At a terminal a line answers only a question that was asked: an early one would answer the next question.
  /// A script may write its answers in advance.
  void answer(const std::string& line) {
    Answers& answers = cell_.programs->answers();
    if (!console_.is_terminal()) return answers.give(line);
    const auto asks = [](const Task* task) {
      return task && !task->ended() && task->status().waiting.kind == program::WaitKind::user;
    };
    if (!asks(cell_.programs->program()) && !asks(cell_.programs->plc())) {
      if (!line.empty()) observer_.on_note("nothing is asked now, and '" + line + "' is no command here");
    } else if (!answers.answer(line)) {
      observer_.on_note("the question is answered already, and the program has not gone on yet");
    }
  }

  /// Typed input is a normal request; a refusal is reported.
  void ask(protocol::Request request) {
    cell_.requests.ask(std::move(request), [this](const protocol::Reply& reply) {
      if (!reply.refusal) return true;
      const Problem& why = reply.refusal->problems().front();
      observer_.on_note(why.what + " (" + why.advice + ")");
      return true;
    });
  }

  void after_tick(Nanoseconds now) {
    cell_.tick(now);
    if (options_.each_tick) options_.each_tick(now);
    watch_state(now);
    watch_first_motion();
    const control::Snapshot& seen = cell_.machine.snapshot();
    if (stop_requests.load() > 0 && !stopping_) {
      stopping_ = true;
      cell_.programs->stop_all();
    }
    if (cell_.life->restart() && !stopping_) {
      stopping_ = true;
      cell_.machine.loop().supervisor().latch().request(realtime::StopKind::controlled);
      cell_.programs->stop_all();
    }
    if (stopping_ || cell_.life->failure()) {
      const Nanoseconds clock = options_.fast ? now : realtime::monotonic_now();  // the loop may hang
      if (stop_since_ < 0) stop_since_ = clock;
      const bool standing = seen.standing && seen.state != control::RunState::stopping &&
                            seen.state != control::RunState::running;
      over_ = (standing && cell_.outputs_settled()) || clock - stop_since_ > options_.patience;
    } else {
      const bool finished = cell_.life->finished() && !options_.stay;
      if (seen.state != control::RunState::held || !seen.standing) held_since_ = now;
      held_out_ = nobody_answers_ && now - held_since_ > kHeldPatience;
      over_ = finished || now >= limit_ || held_out_;
      cut_short_ = over_ && !cell_.life->finished();
    }
    if (now - reported_pose_ >= 100'000'000) {
      reported_pose_ = now;
      for (std::size_t i = 0; i < cell_.setup.robots.size(); ++i)
        observer_.on_pose(now, cell_.setup.robots[i]->entry.name, cell_.motions->tcp(i));
    }
  }

  void watch_state(Nanoseconds now) {
    const control::Snapshot& seen = cell_.machine.snapshot();
    if (seen.state == reported_state_) return;
    reported_state_ = seen.state;
    observer_.on_state(now, control::name(seen.state), cell_.life->stop_cause());
  }

  void watch_first_motion() {
    if (first_motion_ || !cell_.motions->first_motion_cycle()) return;
    const Nanoseconds here = options_.started > 0 ? realtime::wall_now() - options_.started
                                                  : realtime::monotonic_now() - wall_start_;
    first_motion_ = seconds(here);
  }

  RunResult result() {
    cell_.data.files().flush();
    cell_.programs->keep_safe_point();
    control::ControlLoop& loop = cell_.machine.loop();
    RunResult out;
    out.sim_time_s = seconds(loop.cycle().time);
    out.wall_time_s = seconds(realtime::monotonic_now() - wall_start_);
    out.program_cycles = cell_.programs->program() ? cell_.programs->program()->status().cycles : 0;
    out.contacts_max = cell_.watches->contacts_max();
    out.tracking_error_max = cell_.watches->tracking_error_max();
    out.clamps = loop.limits().clamps();
    out.parts = cell_.parts->report();
    out.stops = cell_.watches->stops();
    out.restart = cell_.life->restart();
    out.repeatable = options_.fast && !options_.fast_socket && !cell_.data.files().has_outside_writers() &&
                     !cell_.data.links().any();
    out.trace_hash = loop.trace().text();
    out.first_motion_s = first_motion_;
    for (const auto& robot : cell_.setup.robots)
      if (robot->driver == "mujoco") out.physics_step_s = std::min(1e-3, seconds(loop.options().period));
    health(out.health);
    verdict(out);
    return out;
  }

  void health(LoopHealth& out) {
    const control::Health& h = cell_.machine.loop().health();
    out = {h.cycles,
           h.late,
           late_empty_,
           h.cost.percentile(0.5),
           h.cost.percentile(0.99),
           h.cost.max(),
           h.wake_up.percentile(0.5),
           h.wake_up.percentile(0.99),
           h.wake_up.max()};
  }

  void verdict(RunResult& out) {
    out.stuck = stuck_;
    if (stuck_) {
      out.outcome = Outcome::failed;
      out.problems.push_back({"stuck",
                              {},
                              standing_still() + " (it did not return when the run ended)",
                              "only the driver's watchdog can stop what it drives"});
      return;
    }
    if (cell_.life->failure()) {
      out.outcome = Outcome::failed;
      out.problems.push_back(cell_.life->failure()->problem);
    } else if (stopping_) {
      out.outcome = Outcome::stopped;
      return;
    } else if (held_out_) {
      out.outcome = Outcome::failed;
      const std::optional<Problem>& why = cell_.machine.held_by();
      const Task* const program = cell_.programs->program();
      out.problems.push_back({"held",
                              why && why->where.line > 0 ? why->where
                              : program                  ? program->status().where
                                                         : Location{},
                              "the cell is held, and in lock-step nobody can resume it",
                              "run it without --fast, or with --socket, and polyarm control resume"});
    }
    for (const Problem& problem : cell_.watches->group_faults()) {
      out.outcome = Outcome::failed;
      out.problems.push_back(problem);
    }
    const bool cut = cut_short_ || cell_.life->failure().has_value() || cell_.setup.options.cycles > 0;
    for (const std::string& part : cell_.parts->failures(cut)) {
      if (cut_short_ && !cell_.life->failure()) continue;  // ended early by --seconds
      out.outcome = Outcome::failed;
      out.problems.push_back({"part", {}, part, {}});
    }
  }

  Cell& door_;
  CellInside& cell_;
  RunOptions options_;
  Observer& observer_;
  Console console_;
  Nanoseconds wall_start_ = 0, limit_ = 0, stop_since_ = -1, reported_pose_ = -1'000'000'000;
  control::RunState reported_state_ = control::RunState::running;
  std::optional<double> first_motion_;
  std::uint64_t late_empty_ = 0;
  std::uint64_t seen_cycles_ = 0, gaps_ = 0;
  Nanoseconds cycles_seen_at_ = realtime::monotonic_now();
  bool loop_silent_ = false, stuck_ = false;
  Nanoseconds held_since_ = 0;
  bool over_ = false, stopping_ = false, cut_short_ = false, nobody_answers_ = false, held_out_ = false;
};

}  // namespace

const char* name(Outcome outcome) {
  constexpr const char* kNames[] = {"completed", "stopped", "failed"};
  return kNames[static_cast<std::size_t>(outcome)];
}

void request_stop() noexcept {
  const int count = ++stop_requests;
  if (control::Supervisor* supervisor = running_supervisor.load())
    supervisor->latch().request(count > 1 ? realtime::StopKind::immediate : realtime::StopKind::controlled);
}

void request_stop_once() noexcept {
  int none = 0;
  if (!stop_requests.compare_exchange_strong(none, 1)) return;
  if (control::Supervisor* supervisor = running_supervisor.load())
    supervisor->latch().request(realtime::StopKind::controlled);
}

void request_hold() noexcept {
  if (control::Supervisor* supervisor = running_supervisor.load())
    supervisor->latch().request(realtime::StopKind::controlled);
}

int stops_requested() noexcept {
  return stop_requests.load();
}

realtime::ThreadOptions control_thread(const RunOptions& options, const LoopEntry& stated,
                                       const ros_files::ManagerParameters& manager) {
  const int priority = static_cast<int>(manager.thread_priority);
  const int cpu = manager.cpu_affinity.empty() ? -1 : static_cast<int>(manager.cpu_affinity.front());
  realtime::ThreadOptions out;
  out.priority = options.priority > 0 ? options.priority : stated.priority.value_or(priority);
  out.cpu = options.cpu >= 0 ? options.cpu : stated.cpu.value_or(cpu);
  out.lock_memory = stated.lock_memory.value_or(manager.lock_memory.value_or(out.priority > 0));
  return out;
}

RunResult run(Cell& cell, const RunOptions& options, Observer& observer) {
  return Runner(cell, options, observer).run();
}

}  // namespace polyarm::cell
