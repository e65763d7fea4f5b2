#pragma once
/// A connection to an MQTT broker, on libmosquitto. One thread.
#include <mosquitto.h>

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/signals/link.hpp"

namespace polyarm::mqtt {

/// What the broker publishes when the connection is lost.
struct Will {
  std::string topic, text;
  int qos = 1;
  bool retain = false;
};

/// All functions throw Error("link-lost") with the reason.
class Connection {
 public:
  /// Called within loop() and subscribe() for each message.
  using OnMessage = std::function<void(const mosquitto_message&)>;

  /// `entry` must outlive this.
  Connection(const signals::LinkEntry& entry, OnMessage on_message);
  ~Connection() { close(); }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  /// Connects, and waits until the broker agrees.
  void open(const std::optional<Will>& will);
  /// A regular disconnect, so that the broker does not publish the last will.
  void close() noexcept;
  bool connected() const { return client_ && connected_ == 0; }
  /// Subscribes to topics with their quality, and waits until the broker agrees: it may connect a client that
  /// it lets read nothing.
  void subscribe(const std::vector<std::pair<std::string, int>>& topics);
  /// True while subscribe() waits.
  bool subscribing() const { return !subscriptions_.empty(); }
  void publish(const std::string& topic, const std::string& bytes, int qos, bool retain);
  /// Sends and receives; waits for at most `patience_ms`.
  void loop(int patience_ms, const char* what = "is gone");

 private:
  void set_up(const std::optional<Will>& will);
  void await_answer();
  void check(int code, const char* what) const;
  static void on_connect(mosquitto*, void* self, int code);
  static void on_subscribe(mosquitto*, void* self, int message, int count, const int* granted);
  static void on_message(mosquitto*, void* self, const mosquitto_message* message);

  const signals::LinkEntry& entry_;
  OnMessage on_message_;
  mosquitto* client_ = nullptr;
  int connected_ = -1;                        ///< the broker's reply code; -1: none yet
  std::map<int, std::string> subscriptions_;  ///< topics whose reply has not come, by message
  std::string refused_topic_;
};

}  // namespace polyarm::mqtt
