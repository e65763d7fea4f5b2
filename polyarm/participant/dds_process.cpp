/// polyarm_ros2_dds: the only program that parses DDS packets. A cell starts it, sends it the list of
/// endpoints, and receives payloads unchanged. If a packet crashes it, the cell continues and starts it
/// again. Usage: `polyarm_ros2_dds PARENT`, with the three descriptors of a process::Channel.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/participant/dds_exchange.hpp"
#include "polyarm/participant/participant.hpp"
#include "polyarm/process/channel.hpp"
#include "polyarm/process/child.hpp"
#include "polyarm/process/confinement.hpp"
#include "polyarm/process/pulse.hpp"

namespace polyarm::ros2 {

namespace {

using process::Channel;
using process::Packer;
using process::Unpacker;

constexpr int kBeat_ms = 250;
/// Exit code when the cell stops reading and the channel is full. The cell then starts this process again and
/// learns the current state.
constexpr int kBehind = 3;

class DdsProcess : public ParticipantObserver {
 public:
  explicit DdsProcess(Channel& channel) : channel_{channel} {}

  /// Returns the exit code.
  int run() {
    std::vector<std::byte> order;
    for (;;) {
      channel_.beat();
      const auto received = channel_.receive(order);
      if (received == Channel::Received::broken || channel_.broken()) return kBehind;
      if (received == Channel::Received::nothing) {
        channel_.wait(kBeat_ms);
        continue;
      }
      Unpacker in(order);
      const auto what = static_cast<DdsOrder>(in.number<std::uint8_t>());
      if (what == DdsOrder::end) return end();
      if (what == DdsOrder::open ? !open(in) : !participant_) return 1;
      if (what != DdsOrder::open) obey(what, in);
    }
  }

 private:
  bool open(Unpacker& in) {
    try {
      participant_.emplace(unpack_options(in), this);
      tell([&](Packer& out) { out.number(number_of(DdsReport::ready)).array(participant_->prefix()); });
      return true;
    } catch (const Error& e) {
      const Problem& problem = e.problems().front();
      tell([&](Packer& out) {
        out.number(number_of(DdsReport::refused)).text(problem.what).text(problem.advice);
      });
      return false;
    }
  }

  /// Leaves the network; other participants are notified.
  int end() {
    participant_.reset();
    return 0;
  }

  void obey(DdsOrder what, Unpacker& in) {
    const std::size_t id = in.number<std::uint64_t>();
    if (what == DdsOrder::add_writer) return add(id, [&] { return add_writer(id, in); });
    if (what == DdsOrder::add_reader) return add(id, [&] { return add_reader(id, in); });
    if (what == DdsOrder::remove) return participant_->remove(id);
    if (what == DdsOrder::write) write(id, in);
  }

  std::size_t add_writer(std::size_t id, Unpacker& in) {
    const std::string topic = in.text(kMostName), type = in.text(kMostName);
    const Qos qos = unpack_qos(in);
    const std::string user_data = in.text(kMostUserData);
    return participant_->add_writer(topic, type, qos, user_data, in.truth(), id);
  }
  std::size_t add_reader(std::size_t id, Unpacker& in) {
    const std::string topic = in.text(kMostName), type = in.text(kMostName);
    const Qos qos = unpack_qos(in);
    const std::string user_data = in.text(kMostUserData);
    return participant_->add_reader(
        topic, type, qos, user_data, [this, id](const Sample& sample) { take(id, sample); }, id);
  }
  template <class Add>
  void add(std::size_t id, Add add) {
    try {
      const Guid guid = participant_->guid(add());
      tell(
          [&](Packer& out) { out.number(number_of(DdsReport::made)).number(std::uint64_t{id}).array(guid); });
    } catch (const Error& e) {
      tell([&](Packer& out) {
        out.number(number_of(DdsReport::not_made)).number(std::uint64_t{id}).text(e.problems().front().what);
      });
    }
  }

  void write(std::size_t id, Unpacker& in) {
    std::optional<Related> related;
    const bool has = in.truth();
    const Related given{in.array<16>(), in.number<std::int64_t>()};
    if (has) related = given;
    if (participant_->write(id, in.rest(), related) == 0)
      tell([&](Packer& out) { out.number(number_of(DdsReport::unsent)).number(std::uint64_t{id}); });
  }

  // Called on threads of Fast DDS.
  void take(std::size_t id, const Sample& sample) {
    if (sample.payload.size() > bounds::kSampleBytes)
      return tell([](Packer& out) { out.number(number_of(DdsReport::too_large)); });
    tell(
        [&](Packer& out) {
          out.number(number_of(DdsReport::sample)).number(std::uint64_t{id}).array(sample.writer);
          out.number(sample.sequence)
              .array(sample.related)
              .number(sample.related_sequence)
              .rest(sample.payload);
        },
        false);
  }
  void on_match(std::size_t id, const Guid& other, bool matches) override {
    tell([&](Packer& out) {
      out.number(number_of(DdsReport::matched)).number(std::uint64_t{id}).array(other).number(matches);
    });
  }
  void on_known(const Guid& endpoint, const std::string& user_data, const Offer& offer) override {
    const bool fits = std::max(offer.topic.size(), offer.type.size()) <= kMostName;
    tell([&](Packer& out) {
      out.number(number_of(DdsReport::known)).array(endpoint).text(user_data.substr(0, kMostUserData));
      out.text(fits ? offer.topic : "").text(fits ? offer.type : "");
    });
  }
  void on_unknown(const Guid& endpoint) override {
    tell([&](Packer& out) { out.number(number_of(DdsReport::unknown)).array(endpoint); });
  }
  void on_forgotten(const Guid& participant) override {
    tell([&](Packer& out) { out.number(number_of(DdsReport::forgotten)).array(participant); });
  }

  static std::uint8_t number_of(DdsReport news) { return static_cast<std::uint8_t>(news); }
  template <class Fill>
  void tell(Fill fill, bool must = true) {
    thread_local std::vector<std::byte> message;
    Packer out(message);
    fill(out);
    channel_.send(message, must);
  }

  Channel& channel_;
  std::optional<Participant> participant_;
};

}  // namespace

}  // namespace polyarm::ros2

int main(int argc, char** argv) {
  using namespace polyarm;
  const int parent = argc == 2 ? std::atoi(argv[1]) : 0;
  if (parent <= 0) {
    std::fputs("polyarm_ros2_dds is started by polyarm, which speaks ROS 2 through it\n", stderr);
    return 2;
  }
  process::ChildRules rules;
  rules.handed = 3;
  rules.parent = parent;
  rules.most_memory = bounds::kDdsMemory;
  if (!process::become_child(rules)) return 1;
  const char* profiles = std::getenv("FASTRTPS_DEFAULT_PROFILES_FILE");
  process::confine({{profiles ? profiles : ""}, {}, {}});
  process::filter_calls();
  try {
    process::Channel channel{process::Channel::Inherited{}};
    const process::Pulse pulse(channel);
    return ros2::DdsProcess(channel).run();
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 1;
  }
}
