#pragma once
/// The WebSocket protocol with which Foxglove, Lichtblick and PlotJuggler watch live data, without its
/// transport: the caller passes messages in and sends the messages that come out. Source: Foxglove's
/// WebSocket protocol, subprotocols `foxglove.sdk.v1` and `foxglove.websocket.v1`, which are the same on the
/// wire.
///
/// Clients are read-only: they cannot publish, call services or set parameters.
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/base/bounds.hpp"
#include "polyarm/recording/channel.hpp"

namespace polyarm::recording {

/// Chooses the subprotocol from those that a client offers in Sec-WebSocket-Protocol ("a, b"); empty if none
/// is known.
std::string foxglove_subprotocol(std::string_view offered);

struct FoxgloveOptions {
  std::string name = "polyarm", version, session;  ///< session: a different text for each start
  bool own_time = false;                           ///< true: messages carry simulated time, not system time
  std::size_t most_clients = 32;
};

/// A file named in a description, or the reason why it cannot be read.
struct Asset {
  std::optional<std::string> data;
  std::string problem;
};
/// Gets the asset of a URI and passes it to `reply`, once, from any thread.
using AssetSource = std::function<void(const std::string& uri, std::function<void(Asset)> reply)>;

class FoxgloveClient;

/// Any thread. Messages are shared between clients.
class FoxgloveServer {
 public:
  explicit FoxgloveServer(FoxgloveOptions options) : options_(std::move(options)) {}

  /// Replaces the channels. The new ones get ids that no channel had before; the old ones are unadvertised.
  void set_channels(const std::vector<Channel>& channels);
  /// Publishes a message of the channel with this index; `time` in ns. True if a client has subscribed to it.
  bool publish(std::size_t channel, std::int64_t time, std::span<const std::byte> payload);
  /// True if a client has subscribed to the channel.
  bool wanted(std::size_t channel) const;
  /// Sets whether messages carry simulated time; applies to clients that connect later.
  void set_own_time(bool own);
  /// Sends the time to all clients, if it is simulated.
  void report_time(std::int64_t time);
  /// Sets the parameters, which clients can only read. Subscribers are notified.
  void set_parameters(std::map<std::string, nlohmann::json> parameters);
  /// Sets the source of assets; null: none.
  void set_assets(AssetSource source);
  /// `wake` is called, from any thread, when a client has something to send outside its own calls and
  /// publish().
  void set_wake(std::function<void()> wake);

  /// Adds a client; null if there are too many. Its destructor removes it from the server.
  std::shared_ptr<FoxgloveClient> connect();
  std::size_t clients() const;

 private:
  friend class FoxgloveClient;
  using Json = nlohmann::json;
  using Body = std::shared_ptr<const std::string>;
  struct Advertised {
    Channel channel;
    std::uint32_t id = 0;
    Body last;  ///< latched channels: time and payload of the last message
  };
  Json advertisement() const;
  Json parameter_values(const std::vector<std::string>& names) const;
  void leave(FoxgloveClient* client);

  FoxgloveOptions options_;
  mutable std::mutex mutex_;  ///< protects the members below and the clients' members
  std::vector<Advertised> channels_;
  std::uint32_t next_id_ = 1;
  std::map<std::string, nlohmann::json> parameters_;
  AssetSource assets_;
  std::function<void()> wake_;
  std::set<FoxgloveClient*> clients_;
  std::size_t asset_bytes_ = 0;  ///< bytes of assets queued for all clients
};

/// One viewer. Its queue is bounded: when it reads too little, a newer message replaces a queued one of the
/// same channel, so it gets fewer. All members belong to the thread of its connection.
class FoxgloveClient : public std::enable_shared_from_this<FoxgloveClient> {
 public:
  static constexpr std::size_t kMostSubscriptions = bounds::kViewerSubscriptions;
  /// Queued bytes above which newer messages replace queued ones, and above which only channel lists are
  /// queued.
  static constexpr std::size_t kComfortable = 256 << 10, kMostWaiting = bounds::kViewerWaitingBytes;
  /// Limit of assets that are being read for the client.
  static constexpr int kMostAssets = 16;
  /// Limits of requests for assets that wait until the client has read enough, and of their URIs.
  static constexpr std::size_t kMostLater = 64, kLongestUri = bounds::kViewerUriBytes;
  /// Queued bytes beyond kMostWaiting up to which further requests for assets get a refusal.
  static constexpr std::size_t kRefusals = 64 << 10;

  ~FoxgloveClient();
  FoxgloveClient(const FoxgloveClient&) = delete;
  FoxgloveClient& operator=(const FoxgloveClient&) = delete;

  void take_text(std::string_view message);
  void take_binary(std::string_view message);
  struct Out {
    std::shared_ptr<const std::string> body;
    bool binary = false;
  };
  /// The next message to send; nothing if there is none.
  std::optional<Out> next();
  /// Count of messages that the client missed because it read too little.
  std::uint64_t left_out() const;

 private:
  friend class FoxgloveServer;
  using Json = nlohmann::json;
  static constexpr std::int64_t kNone = -1;  ///< belongs to no subscription, and is never dropped
  struct Waiting {
    std::int64_t subscription = kNone;  ///< the client's id of the subscription
    Out out;
    std::size_t asset = 0;  ///< bytes of an asset in this message
  };
  explicit FoxgloveClient(FoxgloveServer& server) : server_(server) {}
  void dispatch(const Json& message);
  void subscribe(const Json& message);
  void unsubscribe(const Json& message);
  void get_parameters(const Json& message);
  void watch_parameters(const Json& message, bool on);
  struct AssetRequest {
    std::uint32_t id = 0;
    std::string uri;
  };
  void fetch_asset(const Json& message);
  void read_asset(const AssetSource& source, const AssetRequest& request);
  // The caller holds the server's mutex.
  void put(const Json& message);
  void put(std::int64_t subscription, std::string body);
  void put_status(int level, const std::string& text);
  void put_message(std::uint32_t subscription, std::string_view time_and_payload);
  bool may_read_asset() const { return assets_ < kMostAssets && waiting_bytes_ < kMostWaiting; }
  void refuse_asset(std::uint32_t request, const std::string& why);
  void send_asset(std::uint32_t request, const Asset& asset);

  FoxgloveServer& server_;
  std::map<std::uint32_t, std::uint32_t> subscriptions_;  ///< by channel id: the subscription id
  std::set<std::string> watched_;
  bool watches_all_ = false;
  int assets_ = 0;  ///< being read
  std::deque<AssetRequest> later_;
  std::deque<Waiting> waiting_;
  std::size_t waiting_bytes_ = 0;
  std::uint64_t omitted_ = 0;
};

}  // namespace polyarm::recording
