#include "polyarm/io/heartbeats.hpp"

#include "polyarm/base/text.hpp"

namespace polyarm::cell {

Heartbeats::Heartbeats(const signals::Signals& signals, data::DataStore& store, Problems& problems)
    : own_(signals.heartbeat) {
  if (own_) {
    const data::Value* known = store.find(own_->tag);
    if (known && !known->as_boolean())
      problems.error("bad-tag", own_->where,
                     "the heartbeat '" + own_->tag + "' is " + data::name(known->kind()) + ", not a boolean");
    if (!known) store.declare_tag(own_->tag, false);
  }
  for (const signals::Heartbeat& beat : signals.watched) {
    if (!store.find(beat.tag))
      problems.error("unknown-name", beat.where,
                     "there is no tag '" + beat.tag + "' to watch" + did_you_mean(beat.tag, store.names()));
    watched_.push_back({beat, {}, -1});
  }
}

void Heartbeats::tick(Nanoseconds now, std::uint64_t cycles, data::DataStore& store) {
  if (own_ && now - toggled_at_ >= own_->period && cycles != cycles_) {
    toggled_at_ = now;
    cycles_ = cycles;
    high_ = !high_;
    store.set(own_->tag, high_, "heartbeat");
  }
  stopped_.reset();
  for (Watched& watched : watched_) {
    const data::Value* value = store.find(watched.beat.tag);
    if (!value) continue;
    if (!watched.last || !(*watched.last == *value)) {
      if (watched.last) watched.changed_at = now;
      watched.last = *value;
    }
    if (watched.changed_at >= 0 && now - watched.changed_at > watched.beat.period)
      stopped_ = Problem{"heartbeat",
                         {},
                         "the heartbeat '" + watched.beat.tag + "' has not changed for " +
                             format_number(seconds(watched.beat.period)) + " s",
                         {},
                         Severity::warning,
                         {{"tag", watched.beat.tag}, {"time_s", seconds(watched.beat.period)}}};
  }
}

}  // namespace polyarm::cell
