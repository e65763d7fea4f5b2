#include <algorithm>
#include <map>

#include "links/mqtt/connection.hpp"
#include "links/mqtt/payload.hpp"
#include "links/mqtt/port.hpp"
#include "polyarm/base/bounds.hpp"

namespace polyarm::mqtt {

namespace {
using signals::Direction;
using signals::LinkEntry;
using signals::LinkReport;
using signals::LinkTag;
using signals::LinkValue;

class Client : public signals::LinkPort {
 public:
  explicit Client(const LinkEntry& entry) : entry_(entry), last_(entry.tags.size()) {
    for (std::size_t i = 0; i < entry_.tags.size(); ++i)
      if (entry_.tags[i].direction != Direction::out) tags_of_.emplace(entry_.tags[i].topic, i);
  }
  ~Client() override { close(); }

  bool waits() const override { return true; }

  void open() override {
    std::optional<Will> will;
    if (!entry_.will_topic.empty())
      will = {entry_.will_topic, entry_.will_text, entry_.will_qos, entry_.will_retain};
    broker_.open(will);
    subscribe();
    for (auto& text : last_) text.reset();
  }

  void close() noexcept override { broker_.close(); }

  void exchange(const std::vector<LinkValue>& writes, Nanoseconds, Nanoseconds patience,
                LinkReport& news) override {
    for (const LinkValue& write : writes) publish(write);
    // Takes everything that has come in, up to a limit. Only the first call may wait.
    broker_.loop(static_cast<int>(patience / 1'000'000));
    for (std::size_t k = 0; k < 100 && came_.size() != looked_ && !is_much(); ++k) {
      looked_ = came_.size();
      broker_.loop(0);
    }
    looked_ = 0;
    came_bytes_ = 0;
    for (auto& [tag, text] : came_) take(tag, text, news);
    came_.clear();
  }

 private:
  /// True if this is enough for one round; the rest waits at the broker.
  bool is_much() const {
    return came_bytes_ > bounds::kLinkRoundBytes || came_.size() > bounds::kLinkRoundValues;
  }

  void subscribe() {
    came_.clear();
    came_bytes_ = 0;
    std::vector<std::pair<std::string, int>> topics;
    for (const auto& [topic, tag] : tags_of_) topics.emplace_back(topic, entry_.tags[tag].qos);
    broker_.subscribe(topics);
  }

  void publish(const LinkValue& write) {
    const LinkTag& tag = entry_.tags[write.tag];
    const std::string text = payload_of(tag, write.value);
    if (tag.direction == Direction::both) last_[write.tag] = text;
    broker_.publish(tag.topic, text, tag.qos, tag.retain);
  }

  void take(std::size_t index, const std::string& text, LinkReport& news) {
    const LinkTag& tag = entry_.tags[index];
    if (tag.direction == Direction::both && last_[index] == text)
      return news.seen.push_back(index);  // our own message
    std::string why;
    auto value = value_of_payload(tag, text, why);
    if (!value) return news.refuse(index, why);
    last_[index] = text;
    news.seen.push_back(index);
    news.values.push_back({index, std::move(*value)});
  }

  void on_message(const mosquitto_message& message) {
    const auto [first, last] = tags_of_.equal_range(message.topic);
    if (first == last || (broker_.subscribing() && is_much())) return;
    // One byte more than the limit, so that a longer message is refused.
    const auto length =
        std::min(static_cast<std::size_t>(std::max(0, message.payloadlen)), kLongestMessage + 1);
    const std::string text(static_cast<const char*>(message.payload), length);
    for (auto each = first; each != last; ++each) {
      came_.emplace_back(each->second, text);
      came_bytes_ += length;
    }
  }

  LinkEntry entry_;
  Connection broker_{entry_, [this](const mosquitto_message& message) { on_message(message); }};
  std::vector<std::pair<std::size_t, std::string>> came_;
  std::size_t looked_ = 0, came_bytes_ = 0;
  std::multimap<std::string, std::size_t> tags_of_;  ///< incoming tags, by topic
  std::vector<std::optional<std::string>> last_;  ///< direction both: the payload that both sides know
};
}  // namespace

std::unique_ptr<signals::LinkPort> make_client(const LinkEntry& entry) {
  if (entry.graph.contains("sparkplug")) return make_sparkplug(entry);
  return std::make_unique<Client>(entry);
}

}  // namespace polyarm::mqtt
