#include "polyarm/ros2/remote_participant.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/printable.hpp"
#include "polyarm/participant/dds_exchange.hpp"
#include "polyarm/process/channel.hpp"
#include "polyarm/process/child.hpp"
#include "polyarm/ros2/dds_view.hpp"

namespace polyarm::ros2 {

namespace {

using process::Channel;
using process::Packer;
using process::Unpacker;
using Clock = std::chrono::steady_clock;

/// Messages handled before the process itself is checked, and the interval of these checks, ms.
constexpr int kAtOnce = 1000, kCheck_ms = 100;
/// Time that the process gets to leave the network.
constexpr auto kLeaving = std::chrono::seconds(2);
constexpr auto kBetweenNews = std::chrono::minutes(1);
constexpr std::size_t kMostNews = 32;

std::uint8_t number_of(DdsOrder order) {
  return static_cast<std::uint8_t>(order);
}
std::string seconds_of(Clock::duration duration) {
  const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(duration).count();
  return std::to_string(ms / 1000) + "." + std::to_string(ms % 1000 / 100) + " s";
}

}  // namespace

class RemoteParticipant::Work {
 public:
  Work(const ParticipantOptions& options, RemoteOptions remote)
      : options_{options},
        remote_{std::move(remote)},
        pause_{remote_.first_pause},
        bell_{::eventfd(0, EFD_CLOEXEC)} {
    if (remote_.program.empty()) remote_.program = process::find_program(kDdsProgram);
    if (remote_.program.empty())
      throw Error("no-dds", std::string("the program ") + kDdsProgram + " is not installed",
                  "it belongs beside Polyarm's modules; it is not in " + process::program_folders());
    thread_ = std::thread([this] { run(); });
    std::unique_lock lock(mutex_);
    opened_.wait(lock, [this] { return first_.has_value(); });
    if (first_->what.empty()) return;
    const Problem problem{"no-dds", {}, first_->what, first_->advice};
    lock.unlock();
    end();
    throw Error(problem);
  }
  ~Work() { end(); }

  Id add(DdsView::Endpoint endpoint) {
    if (std::max(endpoint.topic.size(), endpoint.type.size()) > kMostName ||
        endpoint.user_data.size() > kMostUserData)
      throw Error("no-dds", "the name of " + endpoint.topic.substr(0, 80) + "... is too long",
                  "names of topics and types have at most 1,024 bytes");
    const std::lock_guard lock(mutex_);
    const Id id = view_.add(std::move(endpoint));
    if (channel_) report_on(id, *view_.find(id));
    return id;
  }

  void remove(Id id) {
    {
      const std::lock_guard lock(mutex_);
      if (!view_.remove(id)) return;
      order([&](Packer& out) { out.number(number_of(DdsOrder::remove)).number(std::uint64_t{id}); }, true);
    }
    const std::lock_guard nobody_is_told(telling_);
  }

  std::int64_t write(Id id, std::span<const std::byte> payload, const std::optional<Related>& related) {
    const std::lock_guard lock(mutex_);
    DdsView::Endpoint* writer = view_.find(id);
    if (!writer || writer->on_sample || payload.size() > bounds::kSampleBytes) return 0;
    const bool kept = writer->keep(payload);
    if (!channel_) return kept ? 1 : 0;
    return hand_over(id, *writer, payload, related);
  }

  template <class Ask>
  auto look(Ask ask) const {
    const std::lock_guard lock(mutex_);
    return ask(view_);
  }
  RemoteStatistics statistics() const {
    const std::lock_guard lock(mutex_);
    RemoteStatistics out = statistics_;
    if (channel_) out.dropped += channel_->dropped_there();
    return out;
  }
  std::vector<RemoteReport> take_reports() {
    const std::lock_guard lock(mutex_);
    return std::exchange(news_, {});
  }
  std::chrono::nanoseconds missing_for() const {
    const std::lock_guard lock(mutex_);
    return missing_since_ ? Clock::now() - *missing_since_ : std::chrono::nanoseconds(0);
  }
  int process() const {
    const std::lock_guard lock(mutex_);
    return process_;
  }

 private:
  void end() {
    {
      const std::lock_guard lock(mutex_);
      over_ = true;
    }
    const std::uint64_t once = 1;
    if (::write(bell_.number(), &once, sizeof once) < 0) errno = 0;
    if (thread_.joinable()) thread_.join();
  }

  // The caller holds mutex_.

  template <class Fill>
  bool order(Fill fill, bool must) {
    if (!channel_) return false;
    Packer out(order_);
    fill(out);
    return channel_->send(order_, must);
  }

  void report_on(Id id, const DdsView::Endpoint& endpoint) {
    const bool reader = endpoint.on_sample != nullptr;
    order(
        [&](Packer& out) {
          out.number(number_of(reader ? DdsOrder::add_reader : DdsOrder::add_writer))
              .number(std::uint64_t{id});
          out.text(endpoint.topic).text(endpoint.type);
          pack(out, endpoint.qos);
          out.text(endpoint.user_data).number(endpoint.addressed);
        },
        true);
  }

  std::int64_t hand_over(Id id, DdsView::Endpoint& writer, std::span<const std::byte> payload,
                         const std::optional<Related>& related) {
    const bool sent = order(
        [&](Packer& out) {
          out.number(number_of(DdsOrder::write)).number(std::uint64_t{id}).number(related.has_value());
          const Related to = related.value_or(Related{kNoGuid, 0});
          out.array(to.guid).number(to.sequence).rest(payload);
        },
        false);
    return sent ? ++writer.sequence : 0;
  }

  void tell(RemoteReport news) {
    if (news_.size() < kMostNews) news_.push_back(std::move(news));
  }

  // Runs on the thread.

  void run() {
    start();
    while (!is_over()) {
      if (!child_.running()) {
        sleep(std::max(Clock::duration::zero(), next_start_ - Clock::now()));
        if (!is_over() && Clock::now() >= next_start_) start();
        continue;
      }
      bool look = true;  // check the process itself: it wrote something there, or nothing happened
      if (channel_->may_sleep()) look = sleep(std::chrono::milliseconds(kCheck_ms));
      channel_->woken();
      const bool broken = !hear();
      const auto now = Clock::now();
      if (!look && now - looked_ < std::chrono::milliseconds(kCheck_ms) && !broken && !channel_->broken()) continue;
      looked_ = now;
      child_.listen();
      if (const auto ending = child_.ended()) {
        hear();
        lose(ending->text());
      } else if (broken || channel_->broken()) {
        child_.kill();
        lose("broke the rules of the exchange, and was ended");
      } else if (!lives()) {
        child_.kill();
        lose("sent nothing for " + seconds_of(remote_.patience) + ", and was ended");
      } else if (pulse_.silent(*channel_, now, remote_.silence)) {
        child_.kill();
        lose("hangs: it sent nothing for " + seconds_of(remote_.silence) + ", and was ended");
      }
    }
    leave();
  }

  bool is_over() const {
    const std::lock_guard lock(mutex_);
    return over_;
  }

  /// Sleeps until the process or the owner signals something, at most for `most`. Returns false if only a
  /// message came.
  bool sleep(Clock::duration most) const {
    std::array<pollfd, 4> fds{{{bell_.number(), POLLIN, 0},
                               {child_.running() ? channel_->bell() : -1, POLLIN, 0},
                               {child_.end(), POLLIN, 0},
                               {child_.errors(), POLLIN, 0}}};
    const auto ms = std::chrono::ceil<std::chrono::milliseconds>(most).count();
    const int count = ::poll(fds.data(), fds.size(), static_cast<int>(ms));
    if (count < 0) errno = 0;
    return count != 1 || fds[1].revents != POLLIN;
  }

  void start() {
    std::string why, advice;
    started_ = sign_ = Clock::now();
    try {
      auto channel = std::make_unique<Channel>();
      std::vector<std::string> words = remote_.words;
      words.push_back(std::to_string(::getpid()));
      const auto handed = channel->of_child();
      child_.start(remote_.program, std::move(words), handed);
      const std::lock_guard lock(mutex_);
      channel_ = std::move(channel);
      process_ = child_.process();
      beats_ = 0;
      pulse_ = {};
      pulse_.restart(started_);
      begin_again();
      return;
    } catch (const Error& e) {
      why = e.problems().front().what;
      advice = e.problems().front().advice;
    }
    refused_ = {false, why, advice};
    lose("could not be started");
  }

  /// Sends the domain, all endpoints and the latched samples.
  void begin_again() {
    order(
        [&](Packer& out) {
          out.number(number_of(DdsOrder::open));
          pack(out, options_);
        },
        true);
    for (auto& [id, endpoint] : view_.endpoints()) {
      report_on(id, endpoint);
      for (const auto& payload : endpoint.kept) hand_over(id, endpoint, payload, std::nullopt);
    }
  }

  bool lives() {
    const std::uint64_t beats = channel_->beats();
    if (std::exchange(beats_, beats) != beats) sign_ = Clock::now();
    return Clock::now() - sign_ < remote_.patience;
  }

  /// Handles waiting messages. Returns false if one is malformed.
  bool hear() {
    for (int i = 0; i < kAtOnce; ++i) {
      const auto received = channel_->receive(heard_);
      if (received == Channel::Received::nothing) return true;
      if (received == Channel::Received::broken || !take(heard_)) return false;
    }
    return true;
  }

  bool take(std::span<const std::byte> message) {
    Unpacker in(message);
    const auto news = static_cast<DdsReport>(in.number<std::uint8_t>());
    if (news == DdsReport::sample) return take_sample(in);
    const std::lock_guard lock(mutex_);
    if (news == DdsReport::ready) return opened(in);
    if (news == DdsReport::refused) {
      const std::string what = in.text(kMostName), advice = in.text(kMostName);
      refused_ = {false, printable_line(what), printable_line(advice)};
      return in.good();
    }
    if (news == DdsReport::too_large) return ++statistics_.too_large, in.good();
    if (news == DdsReport::unsent) ++statistics_.unsent;
    if (news == DdsReport::not_made) {
      Unpacker copy = in;
      copy.number<std::uint64_t>();
      tell({false, printable_line(copy.text(kMostName)), "its topic or service is missing for others"});
    }
    return view_.take(news, in);
  }

  /// The caller holds mutex_.
  bool opened(Unpacker& in) {
    const auto prefix = in.array<16>();
    if (!in.good()) return false;
    view_.set_prefix(prefix);
    if (missing_since_) {
      if (std::exchange(loss_reported_, false))
        tell({true, "ROS 2 is back after " + seconds_of(Clock::now() - *missing_since_), ""});
      missing_since_.reset();
    }
    if (!first_) first_ = RemoteReport{true, "", ""};
    opened_.notify_all();
    return true;
  }

  bool take_sample(Unpacker& in) {
    const std::lock_guard telling(telling_);
    const std::size_t id = in.number<std::uint64_t>();
    Sample sample;
    sample.writer = in.array<16>();
    sample.sequence = in.number<std::int64_t>();
    sample.related = in.array<16>();
    sample.related_sequence = in.number<std::int64_t>();
    sample.payload = in.rest();
    if (!in.good() || sample.payload.size() > bounds::kSampleBytes) return false;
    std::shared_ptr<OnSample> on_sample;
    {
      const std::lock_guard lock(mutex_);
      if (const auto* reader = view_.find(id)) on_sample = reader->on_sample;
    }
    if (on_sample && *on_sample) (*on_sample)(sample);
    return true;
  }

  /// The process has ended; `how` says in which way.
  void lose(const std::string& how) {
    const std::lock_guard lock(mutex_);
    const auto now = Clock::now();
    if (channel_) statistics_.dropped += channel_->dropped_there();
    channel_.reset();
    process_ = 0;
    view_.forget();
    if (!first_) {
      first_ = refused_.what.empty() ? RemoteReport{false, std::string(kDdsProgram) + " " + how, ""} : refused_;
      opened_.notify_all();
    }
    ++statistics_.losses;
    if (now - started_ >= remote_.fine) pause_ = remote_.first_pause;
    next_start_ = now + pause_;
    if (!missing_since_) missing_since_ = now;
    tell_of_loss(how, now);
    pause_ = std::min(2 * pause_, remote_.longest_pause);
    refused_ = {};
  }

  void tell_of_loss(const std::string& how, Clock::time_point now) {
    if (announced_ && now - *announced_ < kBetweenNews) return static_cast<void>(++unreported_);
    std::string what = std::string("the process that speaks ROS 2 (") + kDdsProgram + ") " + how;
    if (!refused_.what.empty()) what += ": " + refused_.what;
    if (const auto times = std::exchange(unreported_, 0); times > 0)
      what += ", after " + std::to_string(times) + " other ends since the last report";
    tell({false, what,
          "robots and programs continue; it is started again in " + seconds_of(pause_) +
              ", and open requests of others are lost"});
    announced_ = now;
    loss_reported_ = true;
  }

  void leave() {
    if (!child_.running()) return;
    {
      const std::lock_guard lock(mutex_);
      order([](Packer& out) { out.number(number_of(DdsOrder::end)); }, true);
    }
    child_.finish(kLeaving);
  }

  const ParticipantOptions options_;
  RemoteOptions remote_;

  // Used by the thread only.
  process::Child child_;
  process::PulseWatch pulse_;
  std::vector<std::byte> heard_;
  Clock::time_point started_, sign_, looked_, next_start_;
  std::chrono::milliseconds pause_;
  std::uint64_t beats_ = 0;
  RemoteReport refused_;  ///< what the process reported before it ended

  Descriptor bell_;
  std::mutex telling_;  ///< held while OnSample is called
  mutable std::mutex mutex_;
  std::condition_variable opened_;
  std::unique_ptr<Channel> channel_;  ///< changed by the thread only
  DdsView view_;
  std::vector<std::byte> order_;
  RemoteStatistics statistics_;
  std::vector<RemoteReport> news_;
  std::optional<RemoteReport> first_;  ///< outcome of the first start; no text: success
  std::optional<Clock::time_point> missing_since_, announced_;
  std::uint64_t unreported_ = 0;
  int process_ = 0;
  bool loss_reported_ = false, over_ = false;
  std::thread thread_;
};

RemoteParticipant::RemoteParticipant(const ParticipantOptions& options, RemoteOptions remote)
    : work_{std::make_unique<Work>(options, std::move(remote))} {}
RemoteParticipant::~RemoteParticipant() = default;
RemoteParticipant::Id RemoteParticipant::add_writer(const std::string& topic, const std::string& type,
                                                    const Qos& qos, const std::string& user_data,
                                                    bool addressed) {
  return work_->add({topic, type, qos, user_data, addressed, nullptr, kNoGuid, false, 0, {}, {}, 0});
}
RemoteParticipant::Id RemoteParticipant::add_reader(const std::string& topic, const std::string& type,
                                                    const Qos& qos, const std::string& user_data,
                                                    OnSample on_sample) {
  return work_->add({topic,
                     type,
                     qos,
                     user_data,
                     false,
                     std::make_shared<OnSample>(std::move(on_sample)),
                     kNoGuid,
                     false,
                     0,
                     {},
                     {},
                     0});
}
void RemoteParticipant::remove(Id id) {
  work_->remove(id);
}
std::int64_t RemoteParticipant::write(Id writer, std::span<const std::byte> payload,
                                      const std::optional<Related>& related) {
  return work_->write(writer, payload, related);
}
Guid RemoteParticipant::guid(Id id) const {
  return work_->look([&](const DdsView& view) { return view.guid(id); });
}
Guid RemoteParticipant::prefix() const {
  return work_->look([](const DdsView& view) { return view.prefix(); });
}
std::vector<Remote> RemoteParticipant::matched(Id id) const {
  return work_->look([&](const DdsView& view) { return view.matched(id); });
}
bool RemoteParticipant::is_matched(Id id) const {
  return work_->look([&](const DdsView& view) { return view.is_matched(id); });
}
std::string RemoteParticipant::user_data_of_writer(const Guid& writer) const {
  return work_->look([&](const DdsView& view) { return view.user_data(writer); });
}
std::size_t RemoteParticipant::known() const {
  return work_->look([](const DdsView& view) { return view.known(); });
}
bool RemoteParticipant::is_offered(const std::string& topic, const std::string& type) const {
  return work_->look([&](const DdsView& view) { return view.is_offered(topic, type); });
}
bool RemoteParticipant::settled() const {
  return work_->look([](const DdsView& view) { return view.settled(); });
}
std::uint64_t RemoteParticipant::identities() const {
  return work_->look([](const DdsView& view) { return view.identities(); });
}
RemoteStatistics RemoteParticipant::statistics() const {
  return work_->statistics();
}
std::vector<RemoteReport> RemoteParticipant::take_reports() {
  return work_->take_reports();
}
std::chrono::nanoseconds RemoteParticipant::missing_for() const {
  return work_->missing_for();
}
int RemoteParticipant::process() const {
  return work_->process();
}

}  // namespace polyarm::ros2
