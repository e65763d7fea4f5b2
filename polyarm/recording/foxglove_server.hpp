#pragma once
/// The protocol by which Foxglove, Lichtblick and PlotJuggler watch something live, without its transport:
/// what clients send comes in as messages, what they are sent goes out as messages. Source: Foxglove's
/// WebSocket protocol, subprotocols `foxglove.sdk.v1` and `foxglove.websocket.v1`, which are the same on the
/// wire.
///
/// Clients only watch: they publish nothing, call nothing and set nothing.
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

#include "polyarm/recording/channel.hpp"

namespace polyarm::recording {

/// Which of the protocol's names the server answers with, of those that a client offers in
/// Sec-WebSocket-Protocol ("a, b"); empty where it offers none that is known.
std::string foxglove_subprotocol(std::string_view offered);

struct FoxgloveOptions {
  std::string name = "polyarm", version, session;  ///< session: another one with each start
  bool own_time = false;                           ///< the time of messages is not that of the clock
  std::size_t most_clients = 32;
};

/// A file that a description names, or why there is none.
struct Asset {
  std::optional<std::string> data;
  std::string problem;
};
/// Gives the asset of a URI to `reply`, once, from any thread.
using AssetSource = std::function<void(const std::string& uri, std::function<void(Asset)> reply)>;

class FoxgloveClient;

/// Any thread; what is given out is shared between clients.
class FoxgloveServer {
 public:
  explicit FoxgloveServer(FoxgloveOptions options) : options_(std::move(options)) {}

  /// Makes these the channels, with numbers that no channel had before; those there were are taken back.
  void set_channels(const std::vector<Channel>& channels);
  /// A message of one of them, by its place in the list; `time` in ns. True where somebody wants it.
  bool publish(std::size_t channel, std::int64_t time, std::span<const std::byte> payload);
  /// Does anybody watch the channel?
  bool wanted(std::size_t channel) const;
  /// Whether the time of messages is another than that of the clock; for who comes from now on.
  void set_own_time(bool own);
  /// Tells everybody what time it is, where it is another.
  void tell_time(std::int64_t time);
  /// What clients read and nobody sets. Those who asked for news are told.
  void set_parameters(std::map<std::string, nlohmann::json> parameters);
  /// Who knows the files; null: nobody.
  void set_assets(AssetSource source);
  /// Called, from any thread, when a client has been given something outside of its own calls and publish().
  void set_wake(std::function<void()> wake);

  /// Somebody new; null where there are too many. It tells the server when it is destroyed.
  std::shared_ptr<FoxgloveClient> connect();
  std::size_t clients() const;

 private:
  friend class FoxgloveClient;
  using Json = nlohmann::json;
  using Body = std::shared_ptr<const std::string>;
  struct Advertised {
    Channel channel;
    std::uint32_t id = 0;
    Body last;  ///< time and payload, of one that is latched
  };
  Json advertisement() const;
  Json parameter_values(const std::vector<std::string>& names) const;
  void leave(FoxgloveClient* client);

  FoxgloveOptions options_;
  mutable std::mutex mutex_;  ///< of everything below, and of what clients have to do with it
  std::vector<Advertised> channels_;
  std::uint32_t next_id_ = 1;
  std::map<std::string, nlohmann::json> parameters_;
  AssetSource assets_;
  std::function<void()> wake_;
  std::set<FoxgloveClient*> clients_;
  std::size_t asset_bytes_ = 0;  ///< that wait for all of them
};

/// One who watches. What waits for it is bounded: where it reads too little, a newer message of a channel
/// takes the place of one that waits, and then it gets fewer. The thread of its connection; gone() any.
class FoxgloveClient : public std::enable_shared_from_this<FoxgloveClient> {
 public:
  static constexpr std::size_t kMostSubscriptions = 1000;
  /// Bytes waiting from which on the newest wins, and from which on nothing but lists of channels is taken.
  static constexpr std::size_t kComfortable = 256 << 10, kMostWaiting = 8 << 20;
  /// Assets that are being read for it.
  static constexpr int kMostAssets = 16;

  ~FoxgloveClient();
  FoxgloveClient(const FoxgloveClient&) = delete;
  FoxgloveClient& operator=(const FoxgloveClient&) = delete;

  void take_text(std::string_view message);
  void take_binary(std::string_view message);
  struct Out {
    std::shared_ptr<const std::string> body;
    bool binary = false;
  };
  /// What to send next.
  std::optional<Out> next();
  /// Messages of channels that it did not get because it read too little.
  std::uint64_t left_out() const;

 private:
  friend class FoxgloveServer;
  using Json = nlohmann::json;
  static constexpr std::int64_t kNone = -1;  ///< what belongs to no subscription, and has to arrive
  struct Waiting {
    std::int64_t subscription = kNone;  ///< as the client calls it
    Out out;
    std::size_t asset = 0;  ///< bytes of an asset in it
  };
  explicit FoxgloveClient(FoxgloveServer& server) : server_(server) {}
  void dispatch(const Json& message);
  void subscribe(const Json& message);
  void unsubscribe(const Json& message);
  void get_parameters(const Json& message);
  void watch_parameters(const Json& message, bool on);
  void fetch_asset(const Json& message);
  void send_asset(std::uint32_t request, const Asset& asset);
  // The server's mutex is held in these.
  void put(const Json& message);
  void put(std::int64_t subscription, std::string body);
  void put_status(int level, const std::string& text);
  void put_message(std::uint32_t subscription, std::string_view time_and_payload);

  FoxgloveServer& server_;
  std::map<std::uint32_t, std::uint32_t> subscriptions_;  ///< by channel's id
  std::set<std::string> watched_;
  bool watches_all_ = false;
  int assets_ = 0;
  std::deque<Waiting> waiting_;
  std::size_t waiting_bytes_ = 0;
  std::uint64_t left_out_ = 0;
};

}  // namespace polyarm::recording
