#include "polyarm/control/control_loop.hpp"

#include <algorithm>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/pair.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::control {

void BlackBox::build(std::size_t states, std::size_t commands, std::size_t rows, std::size_t most_bytes,
                     bool at_once) {
  states_ = states;
  width_ = states + commands;
  capacity_ = std::min(rows, most_bytes / (sizeof(Head) + width_ * sizeof(double)));
  at_once_ = at_once;
  heads_ = {capacity_, at_once};
  data_ = {width_ * capacity_, at_once};
  next_ = filled_ = 0;
}

BlackBox BlackBox::empty_one() const {
  BlackBox out;
  out.build(states_, width_ - states_, capacity_, SIZE_MAX, at_once_);
  return out;
}

void BlackBox::record(const Row& row) noexcept {
  if (capacity_ == 0) return;
  heads_[next_] = {row.cycle, row.state, row.cause, row.request};
  double* to = data_.data() + next_ * width_;
  copy_row(row.states, to);
  copy_row(row.commands, to + row.states.size());
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
  exchange_.measure(options.measure_parts);
  supervisor_.set_when_late(options.overrun);
}

void ControlLoop::start_hardware() {
  hardware_.configure_and_activate();
  exchange_.read(cycle_, faults_);
}

void ControlLoop::start_hardware(hardware::Caller& caller) {
  hardware_.configure_and_activate(caller);
  exchange_.read(cycle_, faults_);
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
  exchange_.watch(watched, options_.period);
  std::vector<Overrun> late;
  for (std::size_t i = 0; i < hardware_.size(); ++i) late.push_back(hardware_.diagnostics().when_late(i));
  supervisor_.set_when_late(options_.overrun, std::move(late));
  const std::size_t states = table_.built_states(), commands = table_.built_commands();
  constexpr std::size_t kSpareEvents = 256;  // for controllers that are loaded later
  faults_.make_room(3 * hardware_.size() + commands + kSpareEvents);
  black_box_.build(states, commands, options_.black_box_rows, bounds::kBlackBoxBytes,
                   options_.memory_at_once);
  Snapshot empty;
  empty.states.assign(table_.states().begin(), table_.states().end());
  empty.commands.assign(table_.commands().begin(), table_.commands().end());
  if (exchange_.world()) empty.world = *exchange_.world();
  empty.threads.resize(hardware_.size());
  empty.fallen.resize(hardware_.size());
  outbox_.reset(empty);
}

inline void ControlLoop::decide(const hardware::Cycle& cycle) noexcept {
  if (!faults_.empty()) react_to_faults(cycle);
}

void ControlLoop::react_to_faults(const hardware::Cycle& cycle) noexcept {
  for (FaultEvent event : faults_.list()) {
    if (event.cause == StopCause::limits)
      event.component = hardware_.component_of_command(static_cast<std::size_t>(event.interface));
    if (!supervisor_.react(event, controllers_.contains(event.component))) continue;
    for (const std::size_t component : exchange_.switch_off_failed(event))
      controllers_.component_failed(component, event.cause == StopCause::deactivated, cycle);
  }
  faults_.clear();
}

inline Request ControlLoop::take_request() noexcept {
  Request request = Request::none;
  inbox_.pop(request);
  return request;
}

inline void ControlLoop::limit(const hardware::Cycle& cycle) noexcept {
  for (hardware::CommandRange range; exchange_.take_restarted(range);)
    limits_.forget(range.first, range.count);
  if (!options_.limits) return;
  const RunState now = supervisor_.state();
  // A held robot stays held whatever is commanded; a controller that a person moves by hand does not count as
  // standing.
  const bool still = (now == RunState::held || now == RunState::fault) && controllers_.standing();
  limits_.restrict(table_.commands(), table_.states(), cycle.index, still, faults_);
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
    supervisor_.react({StopCause::late}, false);
  }
  const Nanoseconds gap = static_cast<Nanoseconds>(skipped) * options_.period;
  exchange_.skipped(gap);
  if (gap < kGap) return false;
  if (!holds_after_gap()) ++health_.gaps;
  return holds_after_gap();
}

void ControlLoop::publish_components(Snapshot& draft) noexcept {
  for (std::size_t i = 0; i < draft.threads.size(); ++i) {
    draft.fallen[i] = exchange_.fallen(i);
    if (const realtime::ThreadHealth* thread = hardware_.diagnostics().thread_health(i))
      draft.threads[i] = {thread->runs, thread->late, thread->missed};
  }
}

void ControlLoop::publish_world(const hardware::WorldState& world, Snapshot& draft) noexcept {
  for (const hardware::PartState& part : world.parts) {
    trace_.add(part.pose.position.x);
    trace_.add(part.pose.position.y);
    trace_.add(part.pose.position.z);
  }
  std::copy(world.parts.begin(), world.parts.end(), draft.world.parts.begin());
  const int news = std::min(world.finding_count, hardware::WorldState::kMaxFindings);
  std::copy_n(world.findings.begin(), news, draft.world.findings.begin());
  draft.world.finding_count = world.finding_count;
  draft.world.contacts = world.contacts;
  draft.world.tracking_error = world.tracking_error;
  draft.world.at_rest = world.at_rest;
}

inline void ControlLoop::publish(const hardware::Cycle& cycle, Request request) noexcept {
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
  draft.event = supervisor_.event();
  draft.standing = controllers_.standing();
  draft.stop = supervisor_.stop_times();
  copy_row(states.first(table_.live_states()), draft.states.data());
  copy_row(commands.first(table_.live_commands()), draft.commands.data());
  publish_components(draft);
  if (const hardware::WorldState* world = exchange_.world()) publish_world(*world, draft);
  outbox_.publish();
}

controllers::Verdict ControlLoop::step(const hardware::Cycle& cycle, bool gap) noexcept {
  if (gap) faults_.push({StopCause::gap});
  exchange_.read(cycle, faults_);  // what did the robot do?
  decide(cycle);
  const Request request = take_request();
  const controllers::Verdict verdict = supervisor_.judge(cycle.time, controllers_.standing(), request);
  controllers_.update(cycle, verdict, faults_);  // controllers follow a stop on the path
  limit(cycle);                                  // the last check before the hardware
  decide(cycle);
  exchange_.write(cycle, faults_);
  decide(cycle);
  if (options_.publish) publish(cycle, request);
  return verdict;
}

controllers::Verdict ControlLoop::step_next(bool gap) noexcept {
  const Nanoseconds began = options_.measure ? realtime::monotonic_now() : 0;
  const controllers::Verdict verdict = step(cycle_, gap);
  if (options_.measure) health_.cost.add(last_cost_ = realtime::monotonic_now() - began);
  if (paced_ && began_ > 0) health_.period.add(began - began_);
  began_ = began;
  ++health_.cycles;
  cycle_.time += cycle_.period;
  ++cycle_.index;
  return verdict;
}

}  // namespace polyarm::control
