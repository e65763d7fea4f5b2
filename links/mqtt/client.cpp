#include <mosquitto.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <map>

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

/// Initialises the library, once for the life of the process.
void begin_library() {
  static const int begun = mosquitto_lib_init();
  (void)begun;
}

class Client : public signals::LinkPort {
 public:
  explicit Client(const LinkEntry& entry) : entry_(entry), last_(entry.tags.size()) {
    begin_library();
    for (std::size_t i = 0; i < entry_.tags.size(); ++i)
      if (entry_.tags[i].direction != Direction::out) tags_of_.emplace(entry_.tags[i].topic, i);
  }
  ~Client() override { close(); }

  bool waits() const override { return true; }

  void open() override {
    close();
    client_ = mosquitto_new(entry_.client_id.empty() ? nullptr : entry_.client_id.c_str(), true, this);
    if (!client_) throw Error("link-lost", "out of memory");
    mosquitto_connect_callback_set(client_, &Client::on_connect);
    mosquitto_message_callback_set(client_, &Client::on_message);
    mosquitto_subscribe_callback_set(client_, &Client::on_subscribe);
    set_up();
    connected_ = -1;
    const int keep_alive =
        static_cast<int>(std::clamp<Nanoseconds>(entry_.keep_alive / 1'000'000'000, 5, 65535));
    check(mosquitto_connect(client_, entry_.host.c_str(), entry_.port, keep_alive), "cannot be reached");
    await_answer();
    subscribe();
    for (auto& text : last_) text.reset();
  }

  void close() noexcept override {
    if (!client_) return;
    if (connected_ == 0) {  // a regular disconnect, so that the broker does not publish the last will
      mosquitto_disconnect(client_);
      mosquitto_loop(client_, 0, 1);
    }
    mosquitto_destroy(client_);
    client_ = nullptr;
  }

  void exchange(const std::vector<LinkValue>& writes, Nanoseconds, Nanoseconds patience,
                LinkReport& news) override {
    for (const LinkValue& write : writes) publish(write);
    // Takes everything that has come in, up to a limit. Only the first call may wait.
    check(mosquitto_loop(client_, static_cast<int>(patience / 1'000'000), 1), "is gone");
    for (std::size_t k = 0; k < 100 && came_.size() != looked_ && !is_much(); ++k) {
      looked_ = came_.size();
      check(mosquitto_loop(client_, 0, 1), "is gone");
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

  void set_up() {
    if (!entry_.user.empty())
      mosquitto_username_pw_set(client_, entry_.user.c_str(),
                                entry_.password.empty() ? nullptr : entry_.password.c_str());
    if (!entry_.will_topic.empty())
      check(mosquitto_will_set(client_, entry_.will_topic.c_str(), static_cast<int>(entry_.will_text.size()),
                               entry_.will_text.data(), entry_.will_qos, entry_.will_retain),
            "takes no such last will");
    if (!entry_.tls) return;
    const auto or_null = [](const std::string& text) { return text.empty() ? nullptr : text.c_str(); };
    check(mosquitto_tls_set(client_, or_null(entry_.ca_file),
                            entry_.ca_file.empty() ? "/etc/ssl/certs" : nullptr, or_null(entry_.certificate),
                            or_null(entry_.key), nullptr),
          "cannot be asked over TLS");
  }

  /// Waits for the broker's reply to the connection: it may refuse.
  void await_answer() {
    using Clock = std::chrono::steady_clock;
    for (const auto until = Clock::now() + std::chrono::nanoseconds(entry_.timeout);
         connected_ < 0 && Clock::now() < until;)
      check(mosquitto_loop(client_, 20, 1), "cannot be reached");
    if (connected_ < 0) throw Error("link-lost", entry_.address() + " does not answer");
    if (connected_ > 0)
      throw Error("link-lost", entry_.address() + " refuses: " + mosquitto_connack_string(connected_));
  }

  /// A broker may connect a client that it lets read nothing: its replies to the subscriptions say so.
  void subscribe() {
    subscriptions_.clear();
    came_.clear();
    came_bytes_ = 0;
    for (const auto& [topic, tag] : tags_of_) {
      int message = 0;
      check(mosquitto_subscribe(client_, &message, topic.c_str(), entry_.tags[tag].qos),
            "did not take a subscription");
      subscriptions_.emplace(message, topic);
    }
    using Clock = std::chrono::steady_clock;
    for (const auto until = Clock::now() + std::chrono::nanoseconds(entry_.timeout);
         !subscriptions_.empty() && Clock::now() < until;) {
      check(mosquitto_loop(client_, 20, 1), "is gone");
      if (!refused_topic_.empty())
        throw Error("link-lost", entry_.address() + " refuses the subscription to '" +
                                     std::exchange(refused_topic_, {}) + "'");
    }
    if (!subscriptions_.empty())
      throw Error("link-lost", entry_.address() + " does not answer the subscription to '" +
                                   subscriptions_.begin()->second + "'");
  }

  void check(int code, const char* what) {
    if (code == MOSQ_ERR_SUCCESS) return;
    const std::string why = code == MOSQ_ERR_ERRNO ? std::strerror(errno) : mosquitto_strerror(code);
    throw Error("link-lost", entry_.address() + " " + what + ": " + why);
  }

  void publish(const LinkValue& write) {
    const LinkTag& tag = entry_.tags[write.tag];
    const std::string text = payload_of(tag, write.value);
    if (tag.direction == Direction::both) last_[write.tag] = text;
    check(mosquitto_publish(client_, nullptr, tag.topic.c_str(), static_cast<int>(text.size()), text.data(),
                            tag.qos, tag.retain),
          "did not take a message");
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

  static void on_connect(mosquitto*, void* self, int code) { static_cast<Client*>(self)->connected_ = code; }

  static void on_subscribe(mosquitto*, void* self, int message, int count, const int* granted) {
    constexpr int kRefused = 0x80;
    Client& client = *static_cast<Client*>(self);
    const auto known = client.subscriptions_.find(message);
    if (known == client.subscriptions_.end()) return;
    if (count < 1 || granted[0] >= kRefused) client.refused_topic_ = known->second;
    client.subscriptions_.erase(known);
  }

  static void on_message(mosquitto*, void* self, const mosquitto_message* message) {
    Client& client = *static_cast<Client*>(self);
    const auto [first, last] = client.tags_of_.equal_range(message->topic);
    if (first == last || (!client.subscriptions_.empty() && client.is_much())) return;
    // One byte more than the limit, so that a longer message is refused.
    const auto length = std::min(static_cast<std::size_t>(std::max(0, message->payloadlen)), kLongestMessage + 1);
    const std::string text(static_cast<const char*>(message->payload), length);
    for (auto each = first; each != last; ++each) {
      client.came_.emplace_back(each->second, text);
      client.came_bytes_ += length;
    }
  }

  LinkEntry entry_;
  mosquitto* client_ = nullptr;
  int connected_ = -1;  ///< the broker's reply code; -1: none yet
  std::vector<std::pair<std::size_t, std::string>> came_;
  std::size_t looked_ = 0, came_bytes_ = 0;
  std::multimap<std::string, std::size_t> tags_of_;  ///< incoming tags, by topic
  std::map<int, std::string> subscriptions_;         ///< topics whose reply has not come, by message
  std::string refused_topic_;
  std::vector<std::optional<std::string>> last_;  ///< direction both: the payload that both sides know
};
}  // namespace

std::unique_ptr<signals::LinkPort> make_client(const LinkEntry& entry) {
  return std::make_unique<Client>(entry);
}

}  // namespace polyarm::mqtt
