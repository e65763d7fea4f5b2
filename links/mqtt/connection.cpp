#include "links/mqtt/connection.hpp"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>

namespace polyarm::mqtt {

namespace {

/// Initialises the library, once for the life of the process.
void begin_library() {
  static const int begun = mosquitto_lib_init();
  (void)begun;
}

}  // namespace

Connection::Connection(const signals::LinkEntry& entry, OnMessage on_message)
    : entry_(entry), on_message_(std::move(on_message)) {
  begin_library();
}

void Connection::open(const std::optional<Will>& will) {
  close();
  client_ = mosquitto_new(entry_.client_id.empty() ? nullptr : entry_.client_id.c_str(), true, this);
  if (!client_) throw Error("link-lost", "out of memory");
  mosquitto_connect_callback_set(client_, &Connection::on_connect);
  mosquitto_message_callback_set(client_, &Connection::on_message);
  mosquitto_subscribe_callback_set(client_, &Connection::on_subscribe);
  set_up(will);
  connected_ = -1;
  const int keep_alive =
      static_cast<int>(std::clamp<Nanoseconds>(entry_.keep_alive / 1'000'000'000, 5, 65535));
  check(mosquitto_connect(client_, entry_.host.c_str(), entry_.port, keep_alive), "cannot be reached");
  await_answer();
}

void Connection::close() noexcept {
  if (!client_) return;
  if (connected_ == 0) {
    mosquitto_disconnect(client_);
    mosquitto_loop(client_, 0, 1);
  }
  mosquitto_destroy(client_);
  client_ = nullptr;
}

void Connection::set_up(const std::optional<Will>& will) {
  if (!entry_.user.empty())
    mosquitto_username_pw_set(client_, entry_.user.c_str(),
                              entry_.password.empty() ? nullptr : entry_.password.c_str());
  if (will)
    check(mosquitto_will_set(client_, will->topic.c_str(), static_cast<int>(will->text.size()),
                             will->text.data(), will->qos, will->retain),
          "takes no such last will");
  if (!entry_.tls) return;
  const auto or_null = [](const std::string& text) { return text.empty() ? nullptr : text.c_str(); };
  check(
      mosquitto_tls_set(client_, or_null(entry_.ca_file), entry_.ca_file.empty() ? "/etc/ssl/certs" : nullptr,
                        or_null(entry_.certificate), or_null(entry_.key), nullptr),
      "cannot be asked over TLS");
}

/// Waits for the broker's reply to the connection: it may refuse.
void Connection::await_answer() {
  using Clock = std::chrono::steady_clock;
  for (const auto until = Clock::now() + std::chrono::nanoseconds(entry_.timeout);
       connected_ < 0 && Clock::now() < until;)
    loop(20, "cannot be reached");
  if (connected_ < 0) throw Error("link-lost", entry_.address() + " does not answer");
  if (connected_ > 0)
    throw Error("link-lost", entry_.address() + " refuses: " + mosquitto_connack_string(connected_));
}

void Connection::subscribe(const std::vector<std::pair<std::string, int>>& topics) {
  subscriptions_.clear();
  for (const auto& [topic, qos] : topics) {
    int message = 0;
    check(mosquitto_subscribe(client_, &message, topic.c_str(), qos), "did not take a subscription");
    subscriptions_.emplace(message, topic);
  }
  using Clock = std::chrono::steady_clock;
  for (const auto until = Clock::now() + std::chrono::nanoseconds(entry_.timeout);
       !subscriptions_.empty() && Clock::now() < until;) {
    loop(20);
    if (!refused_topic_.empty())
      throw Error("link-lost", entry_.address() + " refuses the subscription to '" +
                                   std::exchange(refused_topic_, {}) + "'");
  }
  if (!subscriptions_.empty())
    throw Error("link-lost", entry_.address() + " does not answer the subscription to '" +
                                 subscriptions_.begin()->second + "'");
}

void Connection::publish(const std::string& topic, const std::string& bytes, int qos, bool retain) {
  check(mosquitto_publish(client_, nullptr, topic.c_str(), static_cast<int>(bytes.size()), bytes.data(), qos,
                          retain),
        "did not take a message");
}

void Connection::loop(int patience_ms, const char* what) {
  check(mosquitto_loop(client_, patience_ms, 1), what);
}

void Connection::check(int code, const char* what) const {
  if (code == MOSQ_ERR_SUCCESS) return;
  const std::string why = code == MOSQ_ERR_ERRNO ? std::strerror(errno) : mosquitto_strerror(code);
  throw Error("link-lost", entry_.address() + " " + what + ": " + why);
}

void Connection::on_connect(mosquitto*, void* self, int code) {
  static_cast<Connection*>(self)->connected_ = code;
}

void Connection::on_subscribe(mosquitto*, void* self, int message, int count, const int* granted) {
  constexpr int kRefused = 0x80;
  Connection& connection = *static_cast<Connection*>(self);
  const auto known = connection.subscriptions_.find(message);
  if (known == connection.subscriptions_.end()) return;
  if (count < 1 || granted[0] >= kRefused) connection.refused_topic_ = known->second;
  connection.subscriptions_.erase(known);
}

void Connection::on_message(mosquitto*, void* self, const mosquitto_message* message) {
  static_cast<Connection*>(self)->on_message_(*message);
}

}  // namespace polyarm::mqtt
