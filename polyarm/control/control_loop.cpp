#include "polyarm/control/control_loop.hpp"

#include <algorithm>

#include "polyarm/base/error.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::control {

void BlackBox::build(std::size_t states, std::size_t commands, std::size_t rows) {
  states_ = states;
  width_ = states + commands;
  capacity_ = rows;
  heads_.assign(rows, {});
  data_.assign(width_ * rows, 0.0);
  next_ = filled_ = 0;
}

BlackBox BlackBox::empty_one() const {
  BlackBox out;
  out.build(states_, width_ - states_, capacity_);
  return out;
}

void BlackBox::record(const Row& row) noexcept {
  if (capacity_ == 0) return;
  heads_[next_] = {row.cycle, row.state, row.cause, row.request};
  double* to = data_.data() + next_ * width_;
  to = std::copy(row.states.begin(), row.states.end(), to);
  std::copy(row.commands.begin(), row.commands.end(), to);
  next_ = next_ + 1 == capacity_ ? 0 : next_ + 1;
  filled_ = std::min(filled_ + 1, capacity_);
}

BlackBox::Row BlackBox::row(std::size_t i) const noexcept {
  const std::size_t at = ((filled_ < capacity_ ? 0 : next_) + i) % capacity_;
  const Head& head = heads_[at];
  const std::span<const double> values{data_.data() + at * width_, width_};
  return {head.cycle, head.state, head.cause, head.request, values.first(states_), values.subspan(states_)};
}

std::shared_ptr<ControlLoop::TakeBlackBox> ControlLoop::take_black_box() {
  auto job = std::make_shared<TakeBlackBox>(black_box_);
  if (!jobs_.post(job)) throw Error("busy", "the control loop has not taken the last requests yet");
  return job;
}

class ControlLoop::SetTap : public realtime::Job {
 public:
  SetTap(CycleTap*& place, CycleTap* tap) : place_(place), tap_(tap) {}
  void run() noexcept override { place_ = tap_; }

 private:
  CycleTap*& place_;
  CycleTap* tap_;
};

std::unique_ptr<CycleTap> ControlLoop::make_tap(std::size_t rows, unsigned every) const {
  return std::make_unique<CycleTap>(table_.built_states(), table_.built_commands(), rows, every);
}

std::shared_ptr<realtime::Job> ControlLoop::tap(CycleTap* tap) {
  auto job = std::make_shared<SetTap>(tap_, tap);
  if (!jobs_.post(job)) throw Error("busy", "the control loop has not taken the last requests yet");
  return job;
}

ControlLoop::ControlLoop(const LoopOptions& options) : options_(options) {
  cycle_.period = options.period;
  controllers_.set_cycle(cycle_);
  controllers_.measure(options.measure_parts);
  hardware_.measure(options.measure_parts);
}

void ControlLoop::start_hardware() {
  hardware_.configure_and_activate();
  hardware_.read(cycle_);
}

void ControlLoop::start_hardware(hardware::Caller& caller) {
  hardware_.configure_and_activate(caller);
  hardware_.read(cycle_);
}

void ControlLoop::prepare(const std::vector<controllers::JointFacts>& joints) {
  table_.seal();
  controllers_.bind_all();
  limits_.build(table_, joints, options_.period);
  traced_.clear();
  std::vector<hardware::WatchedJoint> watched;
  for (const controllers::JointFacts& joint : joints)
    if (const auto index = table_.find_state(joint.name + "/position")) {
      traced_.push_back(static_cast<std::uint32_t>(*index));
      const auto command = table_.find_command(joint.name + "/position");
      watched.push_back({*index, command ? static_cast<int>(*command) : -1,
                         joint.states_velocity ? joint.velocity : controllers::kUnlimited});
    }
  hardware_.watch(watched, options_.period);
  const std::size_t states = table_.built_states(), commands = table_.built_commands();
  black_box_.build(states, commands, options_.black_box_rows);
  Snapshot empty;
  empty.states.assign(table_.states().begin(), table_.states().end());
  empty.commands.assign(table_.commands().begin(), table_.commands().end());
  if (hardware_.world()) empty.world = *hardware_.world();
  empty.threads.resize(hardware_.size());
  empty.fallen.resize(hardware_.size());
  outbox_.reset(empty);
}

controllers::Verdict ControlLoop::step(const hardware::Cycle& cycle, bool gap) noexcept {
  const hardware::Fault fault = hardware_.read(cycle);  // learn what the robot did
  const bool of_all = fault && take_off_failed(cycle);
  if (hardware_.take_hold()) supervisor_.hold(StopCause::late);
  look_for_contacts();
  Request request = Request::none;
  inbox_.pop(request);  // at most one request from outside
  const controllers::Verdict verdict = supervisor_.judge(cycle, of_all ? fault : hardware::Fault{}, gap,
                                                         controllers_.standing(), request);  // may we go on?
  controllers_.update(cycle, verdict);  // a stop is followed on the path
  for (std::size_t i = 0; i < hardware_.size(); ++i)
    if (hardware_.take_restarted(i))
      limits_.forget(hardware_.commands_of(i).first, hardware_.commands_of(i).second);
  if (options_.limits) {
    const RunState now = supervisor_.state();  // held is held, whatever is commanded
    // A controller that moves by hand what is held says that it does not stand.
    const bool still = (now == RunState::held || now == RunState::fault) && controllers_.standing();
    limits_.restrict(table_.commands(), table_.states(), cycle.index,
                     still);  // the last word before the wire
    for (const std::int32_t command : limits_.faults())
      if (!fell_alone(hardware_.component_of_command(static_cast<std::size_t>(command)),
                      hardware::FaultKind::outside, command))
        supervisor_.raise(StopCause::limits, command);
  }
  for (const ControllerManager::Failure& failure : controllers_.failures())
    if (!fell_alone(failure.component, hardware::FaultKind::controller, -1))
      supervisor_.raise(StopCause::controller, failure.controller);
  const hardware::Fault failed = hardware_.write(cycle);
  if (take_off_failed(cycle) && failed) supervisor_.raise(cause_of(failed), failed.component);
  if (options_.publish) publish(cycle, request);  // snapshot, and the ring of cycle records
  return verdict;
}

void ControlLoop::look_for_contacts() noexcept {
  const hardware::WorldState* world = hardware_.world();
  if (!world) return;
  if (world->finding_count > findings_) supervisor_.touched();
  findings_ = world->finding_count;
}

bool ControlLoop::fell_alone(int component, hardware::FaultKind kind, std::int32_t what) noexcept {
  if (component < 0 || !controllers_.contains(static_cast<std::size_t>(component))) return false;
  hardware_.fail_for(static_cast<std::size_t>(component), kind, what);
  return true;
}

bool ControlLoop::take_off_failed(const hardware::Cycle& cycle) noexcept {
  using Fall = hardware::Hardware::Fall;
  bool contained = true;
  for (std::size_t i = 0; i < hardware_.size(); ++i)
    if (const Fall fall = hardware_.newly_failed(i); fall != Fall::none) {
      contained = contained && controllers_.contains(i);
      controllers_.component_failed(i, fall == Fall::deactivated, cycle);
    }
  return !contained;
}

bool ControlLoop::holds_after_gap() const {
  if (options_.stall_holds) return *options_.stall_holds;
  for (std::size_t i = 0; i < hardware_.size(); ++i)
    if (hardware_.real(i)) return true;
  return false;
}

bool ControlLoop::woke(Nanoseconds latency, std::uint64_t skipped) noexcept {
  const bool late = latency > options_.period / 2 || skipped > 0;
  paced_ = true;
  last_wake_ = latency;
  health_.wake_up.add(latency);
  health_.late += (latency > options_.period / 2 ? 1 : 0) + skipped;
  late_in_a_row_ = late ? late_in_a_row_ + 1 : 0;
  if (late_in_a_row_ >= options_.overrun_after && options_.overrun != Overrun::report) {
    late_in_a_row_ = 0;
    if (options_.overrun == Overrun::fault)
      supervisor_.raise(StopCause::late, -1);
    else
      supervisor_.hold(StopCause::late);
  }
  const Nanoseconds gap = static_cast<Nanoseconds>(skipped) * options_.period;
  hardware_.skipped(gap);
  if (gap < kGap) return false;
  if (!holds_after_gap()) ++health_.gaps;
  return holds_after_gap();
}

controllers::Verdict ControlLoop::step_next(bool gap) noexcept {
  const Nanoseconds before = options_.measure ? realtime::monotonic_now() : 0;
  if (paced_ && began_ > 0) health_.period.add(before - began_);
  began_ = before;
  const controllers::Verdict verdict = step(cycle_, gap);
  if (options_.measure) health_.cost.add(last_cost_ = realtime::monotonic_now() - before);
  ++health_.cycles;
  cycle_.time += cycle_.period;
  ++cycle_.index;
  return verdict;
}

void ControlLoop::publish(const hardware::Cycle& cycle, Request request) noexcept {
  const std::span<const double> states = table_.states(), commands = table_.commands();
  for (const std::uint32_t index : traced_) trace_.add(states[index]);
  black_box_.record({cycle.index, supervisor_.state(), supervisor_.cause(), request,
                     states.first(table_.built_states()), commands.first(table_.built_commands())});
  if (tap_)
    tap_->record({cycle.index, cycle.time, last_wake_, last_cost_, health_.late, supervisor_.state(),
                  supervisor_.cause(), controllers_.standing()},
                 states, commands);
  Snapshot& draft = outbox_.draft();
  draft.cycle = cycle;
  draft.state = supervisor_.state();
  draft.cause = supervisor_.cause();
  draft.culprit = supervisor_.culprit();
  draft.standing = controllers_.standing();
  draft.stop = supervisor_.stop_times();
  for (std::size_t i = 0; i < draft.threads.size(); ++i) {
    const hardware::FaultKind fallen = hardware_.fallen(i);
    draft.fallen[i] = fallen == hardware::FaultKind::none ? StopCause::none : cause_of({fallen, -1});
    if (const realtime::ThreadHealth* thread = hardware_.thread_health(i))
      draft.threads[i] = {thread->runs, thread->late, thread->missed};
  }
  std::copy(states.begin(), states.end(), draft.states.begin());
  std::copy(commands.begin(), commands.end(), draft.commands.begin());
  if (const hardware::WorldState* world = hardware_.world()) {
    for (const hardware::PartState& part : world->parts) {
      trace_.add(part.pose.position.x);
      trace_.add(part.pose.position.y);
      trace_.add(part.pose.position.z);
    }
    std::copy(world->parts.begin(), world->parts.end(), draft.world.parts.begin());
    const int news = std::min(world->finding_count, hardware::WorldState::kMaxFindings);
    std::copy_n(world->findings.begin(), news, draft.world.findings.begin());
    draft.world.finding_count = world->finding_count;
    draft.world.contacts = world->contacts;
    draft.world.tracking_error = world->tracking_error;
    draft.world.at_rest = world->at_rest;
  }
  outbox_.publish();
}

}  // namespace polyarm::control
