#include "polyarm/hardware/own_clock.hpp"

#include <algorithm>
#include <limits>

namespace polyarm::hardware {

namespace {
constexpr double kNoOrder = std::numeric_limits<double>::quiet_NaN();
}

OwnClock::OwnClock(const std::unique_ptr<Component>& component, std::span<const double> states,
                   std::size_t commands, Nanoseconds period, bool lock_step, realtime::ThreadOptions options)
    : component_(component),
      period_(std::max<Nanoseconds>(1, period)),
      lock_step_(lock_step),
      states_(states.begin(), states.end()) {
  orders_.reset({0, ReturnType::ok, {}, {}, std::vector<double>(commands, kNoOrder)});
  results_.reset({0, ReturnType::ok, {}, {}, states_});
  if (!lock_step_)
    runner_ =
        std::make_unique<realtime::PeriodicRunner>([this] { return exchange(); }, period_, options, health_);
}

void OwnClock::open() noexcept {
  if (++sessions_ == 0) ++sessions_;
  fresh_ = true;
  behind_ = 0;
  health_.late_in_a_row.store(0, std::memory_order_relaxed);
  session_.store(sessions_);
}

void OwnClock::order(const Cycle& cycle, std::span<const double> commands, bool writing) noexcept {
  Packet& draft = orders_.draft();
  draft.session = sessions_;
  draft.cycle = cycle;
  if (writing)
    std::copy(commands.begin(), commands.end(), draft.values.begin());
  else  // old commands must not be applied when it is activated again
    std::fill(draft.values.begin(), draft.values.end(), kNoOrder);
  orders_.publish();
  if (cycle.time < due_) return;
  due_ += ((cycle.time - due_) / period_ + 1) * period_;
  behind_ = fresh_ ? 0 : behind_ + 1;
  fresh_ = false;
  if (lock_step_ && exchange()) ++health_.runs;
}

std::optional<ReturnType> OwnClock::take(std::span<double> states, Exchanged& exchanged) noexcept {
  if (!results_.fetch()) return std::nullopt;
  const Packet& packet = results_.value();
  if (packet.session != sessions_) return std::nullopt;
  fresh_ = true;
  exchanged = packet.exchanged;
  if (packet.result == ReturnType::ok) std::copy(packet.values.begin(), packet.values.end(), states.begin());
  return packet.result;
}

void OwnClock::measure() {
  Packet& draft = results_.draft();
  draft.session = sessions_;
  draft.result = component_->read({0, period_, index_}, states_);
  draft.values = states_;
  results_.publish();
}

Nanoseconds OwnClock::clock(const Cycle& order) const noexcept {
  return lock_step_ ? order.time : realtime::monotonic_now();
}

bool OwnClock::exchange() noexcept {
  exchanging_->store(true);  // set before reading the session, so close() sees it
  const std::uint32_t session = session_.load();
  silent_ = orders_.fetch() ? 0 : silent_ + period_;
  const Packet& order = orders_.value();
  const bool wanted = session != 0 && session == order.session && session != failed_ &&
                      silent_ <= std::max(kSilence, 3 * order.cycle.period) + period_;
  if (wanted) {
    const Cycle cycle{order.cycle.time, period_, index_++};
    Packet& draft = results_.draft();
    draft.session = session;
    draft.exchanged.began = clock(order.cycle);
    draft.result = component_->write(cycle, order.values);
    if (draft.result == ReturnType::ok) draft.result = component_->read(cycle, states_);
    draft.exchanged.ended = clock(order.cycle);
    std::copy(states_.begin(), states_.end(), draft.values.begin());
    if (draft.result == ReturnType::error) failed_ = session;
    results_.publish();
  }
  exchanging_->store(false);
  exchanging_->notify_all();
  return wanted;
}

}  // namespace polyarm::hardware
