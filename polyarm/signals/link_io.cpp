#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <iterator>
#include <mutex>
#include <thread>
#include <utility>

#include "polyarm/base/bounds.hpp"
#include "polyarm/signals/link.hpp"

namespace polyarm::signals {

namespace {
/// Interval at which a port that waits for news checks for posts, ns.
constexpr Nanoseconds kTimeout = 5'000'000;
constexpr Nanoseconds kSecond = 1'000'000'000;
/// A far side that has never been reached for this time is reported.
constexpr Nanoseconds kUnreached = kSecond;
/// Limit for losses, refusals and notes that wait for the cell.
constexpr std::size_t kMostOtherEvents = 100;

Nanoseconds steady_now() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}
}  // namespace

/// Runs on the port's thread: connects, exchanges values and counts. Holds both queues.
class Link::Io {
 public:
  Io(LinkEntry entry, std::unique_ptr<LinkPort> port, LinkOptions options)
      : entry_(std::move(entry)),
        port_(std::move(port)),
        options_(options),
        wanted_(entry_.tags.size()),
        posted_(entry_.tags.size(), 0),
        given_(entry_.tags.size(), 0),
        received_at_(entry_.tags.size(), -1),
        refusals_(entry_.tags.size()) {
    state_.reason = "it has not been connected yet";
    state_.stale.assign(entry_.tags.size(), 0);
    state_.heard.assign(entry_.tags.size(), 0);
    pause_ = options_.first_pause;
  }

  ~Io() {
    if (!thread_.joinable()) {
      finish();
      return;
    }
    {
      const std::lock_guard lock(mutex_);
      ending_ = true;
    }
    wake_.notify_all();
    if (!open_) port_->give_up();
    thread_.join();
  }

  const LinkEntry& entry() const { return entry_; }

  void post(std::size_t tag, const data::Value& value) {
    {
      const std::lock_guard lock(mutex_);
      wanted_[tag] = value;
      ++posted_[tag];
      news_ = true;
    }
    wake_.notify_all();
  }

  std::vector<LinkEvent> take_events() {
    // Started here, so that values posted before the first call are available at the far side's first
    // request.
    if (options_.thread && !thread_.joinable()) thread_ = std::thread([this] { run(); });
    std::vector<LinkEvent> out;
    const std::lock_guard lock(mutex_);
    for (auto& [event, known] : events_)
      if (event.kind != LinkEvent::Kind::value || posted_[event.tag] <= known)
        out.push_back(std::move(event));
    events_.clear();
    return out;
  }

  LinkState state() const {
    const std::lock_guard lock(mutex_);
    LinkState out = state_;
    // Values also age during a round, because the far side, or the process that speaks with it, may hang.
    if (options_.thread && state_.was_up) age(out, steady_now());
    return out;
  }

  bool idle() const {
    const std::lock_guard lock(mutex_);
    return posted_ == given_;
  }

  void step(Nanoseconds now) {
    if (!open_) {
      if (now < next_try_) return;
      connect(now);
    }
    if (open_) round(now, 0);
  }

 private:
  void run() {
    for (std::unique_lock lock(mutex_); !ending_;) {
      lock.unlock();
      const Nanoseconds begun = steady_now();
      if (!open_ && begun >= next_try_) connect(begun);
      if (open_) round(begun, kTimeout);
      lock.lock();
      if (open_ && port_->waits()) continue;
      const Nanoseconds next = open_ ? begun + entry_.poll : std::max(next_try_, begun + 1'000'000);
      // A post wakes the thread and is sent at once.
      wake_.wait_for(lock, std::chrono::nanoseconds(std::max<Nanoseconds>(0, next - steady_now())),
                     [this] { return ending_ || (news_ && open_); });
    }
    finish();
  }

  /// Runs on the port's thread, because a port's process ends with its thread.
  void finish() {
    const Nanoseconds until = steady_now() + entry_.timeout;
    while (open_ && !idle() && steady_now() < until) round(steady_now(), 0);
    port_->close();
  }

  void connect(Nanoseconds now) {
    if (first_try_ < 0) first_try_ = now;
    try {
      port_->open();
      open_ = true;
      opened_ = now;
      const std::lock_guard lock(mutex_);
      std::fill(given_.begin(), given_.end(), 0);  // the far side may have lost them
      const bool first = !std::exchange(has_been_open_, true);
      for (std::size_t i = 0; i < given_.size(); ++i) {
        const LinkTag& tag = entry_.tags[i];
        const bool theirs = first && tag.direction == Direction::both && !tag.cell_first && !entry_.server;
        if (!wanted_[i] || theirs) given_[i] = posted_[i];
      }
    } catch (const Error& e) {
      fall(now, e.problems().front().what);
    }
  }

  /// Handles a lost connection: reports it once, and waits longer before each new attempt.
  void fall(Nanoseconds now, const std::string& why) {
    port_->close();
    open_ = false;
    next_try_ = (options_.thread ? steady_now() : now) + pause_;
    pause_ = std::min(2 * pause_, options_.longest_pause);
    const std::lock_guard lock(mutex_);
    down(why);
    if (!state_.was_up && now - first_try_ >= kUnreached && !std::exchange(unreached_reported_, true))
      events_.push_back({{LinkEvent::Kind::note, 0, {}, "it is not connected yet: " + why}, UINT64_MAX});
  }

  void down(const std::string& why) {
    state_.reason = why;
    if (!state_.up) return;
    state_.up = false;
    ++state_.losses;
    events_.push_back({{LinkEvent::Kind::lost, 0, {}, why}, 0});
  }

  /// A far side that accepts each connection and drops it soon is asked more and more rarely, too.
  void up(Nanoseconds now) {
    if (now - opened_ >= options_.longest_pause) pause_ = options_.first_pause;
    if (state_.up) return;
    state_.up = state_.was_up = true;
    state_.reason.clear();
    events_.push_back({{LinkEvent::Kind::found, 0, {}, {}}, 0});
  }

  void round(Nanoseconds now, Nanoseconds patience) {
    std::vector<LinkValue> writes;
    std::vector<std::uint64_t> known;
    {
      const std::lock_guard lock(mutex_);
      news_ = false;
      known = posted_;
      std::size_t bytes = 0;
      for (std::size_t i = 0; i < wanted_.size() && bytes <= bounds::kLinkRoundBytes; ++i) {
        if (!wanted_[i] || given_[i] == posted_[i]) continue;
        writes.push_back({i, *wanted_[i]});
        if (const std::string* text = wanted_[i]->as_text()) bytes += text->size();
      }
    }
    LinkReport news;
    const Nanoseconds begun = steady_now();
    try {
      port_->exchange(writes, now, patience, news);
    } catch (const Error& e) {
      fall(now, e.problems().front().what);
      return;
    }
    const std::lock_guard lock(mutex_);
    ++state_.exchanges;
    state_.round_ns = steady_now() - begun;
    for (const LinkValue& write : writes) given_[write.tag] = known[write.tag];
    take(news, known, now);
  }

  void take(LinkReport& news, const std::vector<std::uint64_t>& known, Nanoseconds now) {
    if (news.alive)
      up(now);
    else
      down("no client has sent a request within its timeout");
    for (std::string& note : news.notes)
      events_.push_back({{LinkEvent::Kind::note, 0, {}, std::move(note)}, UINT64_MAX});
    for (const std::size_t tag : news.seen) received_at_[tag] = now, state_.heard[tag] = 1;
    take_refusals(news, now);
    for (LinkValue& value : news.values) {
      refusals_[value.tag].clear();
      // The far side has sent this value, so it is not sent back after a reconnection.
      if (entry_.tags[value.tag].direction == Direction::both && posted_[value.tag] == known[value.tag])
        wanted_[value.tag].reset(), given_[value.tag] = posted_[value.tag];
      const std::size_t tag = value.tag;
      events_.push_back({{LinkEvent::Kind::value, tag, std::move(value.value), {}}, known[tag]});
    }
    age(state_, now);
    if (events_.size() > bounds::kLinkEvents) leave_out_events();
  }

  /// Marks the tags that were not received for longer than their `stale`.
  void age(LinkState& state, Nanoseconds now) const {
    for (std::size_t i = 0; i < received_at_.size(); ++i) {
      const Nanoseconds limit = entry_.tags[i].stale;
      state.stale[i] = limit > 0 && (received_at_[i] < 0 || now - received_at_[i] > limit);
    }
  }

  /// Reports each refusal once, and only some if a far side keeps sending different invalid values.
  void take_refusals(LinkReport& news, Nanoseconds now) {
    if (now - refusing_since_ >= kSecond) {
      if (const auto left_out = std::exchange(omitted_refusals_, 0); left_out > 0)
        events_.push_back({{LinkEvent::Kind::note, 0, {},
                            std::to_string(left_out) + " more values were not taken than are reported"}, UINT64_MAX});
      refusing_since_ = now;
      refusals_reported_ = 0;
    }
    for (auto& [tag, why] : news.refused) {
      if (refusals_[tag] == why) continue;
      if (refusals_reported_ == bounds::kLinkRefusals) {
        ++omitted_refusals_;
        continue;
      }
      ++refusals_reported_;
      refusals_[tag] = why;
      events_.push_back({{LinkEvent::Kind::refused, tag, {}, why}, 0});
    }
  }

  /// If the cell does not take events: keeps each tag's latest value, and the latest other events.
  void leave_out_events() {
    std::vector<std::pair<LinkEvent, std::uint64_t>> kept;
    std::vector<char> has(entry_.tags.size(), 0);
    std::size_t others = 0;
    for (auto each = events_.rbegin(); each != events_.rend(); ++each) {
      const bool value = each->first.kind == LinkEvent::Kind::value;
      if (value ? std::exchange(has[each->first.tag], 1) == 0 : ++others <= kMostOtherEvents)
        kept.push_back(std::move(*each));
    }
    events_.assign(std::make_move_iterator(kept.rbegin()), std::make_move_iterator(kept.rend()));
  }

  const LinkEntry entry_;
  std::unique_ptr<LinkPort> port_;
  const LinkOptions options_;
  // Port thread.
  std::atomic<bool> open_{false};
  bool has_been_open_ = false;
  Nanoseconds next_try_ = 0, pause_;
  Nanoseconds first_try_ = -1, opened_ = 0;
  bool unreached_reported_ = false;
  Nanoseconds refusing_since_ = 0;
  std::uint64_t refusals_reported_ = 0, omitted_refusals_ = 0;
  // Both threads; protected by the mutex.
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::vector<std::optional<data::Value>> wanted_;  ///< by tag: the value for the far side
  std::vector<std::uint64_t> posted_, given_;       ///< by tag: count of posts, and number of the last post
                                                    ///< sent
  std::vector<Nanoseconds> received_at_;
  std::vector<std::string> refusals_;
  std::vector<std::pair<LinkEvent, std::uint64_t>> events_;  ///< with the count of the tag's posts at that
                                                             ///< time
  LinkState state_;
  bool news_ = false, ending_ = false;
  std::thread thread_;
};

Link::Link(LinkEntry entry, std::unique_ptr<LinkPort> port, LinkOptions options)
    : io_(std::make_unique<Io>(std::move(entry), std::move(port), options)) {}
Link::~Link() = default;
const LinkEntry& Link::entry() const {
  return io_->entry();
}
void Link::post(std::size_t tag, const data::Value& value) {
  io_->post(tag, value);
}
std::vector<LinkEvent> Link::take_events() {
  return io_->take_events();
}
LinkState Link::state() const {
  return io_->state();
}
bool Link::idle() const {
  return io_->idle();
}
void Link::step(Nanoseconds now) {
  io_->step(now);
}

}  // namespace polyarm::signals
