#include "polyarm/recording/foxglove_server.hpp"

#include <algorithm>
#include <utility>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::recording {

namespace {

using Json = nlohmann::json;
enum Status { kWarning = 1, kError = 2 };
enum ServerOpcode : char { kMessageData = 1, kTime = 2, kFetchAssetResponse = 4 };
constexpr std::size_t kLongestName = 1000;

template <class T>
void put_number(std::string& out, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i)
    out += static_cast<char>(static_cast<std::uint64_t>(value) >> (8 * i));
}

std::string dump(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// A 32-bit unsigned integer; nothing for any other value.
std::optional<std::uint32_t> number(const Json& json) {
  if (!json.is_number_unsigned() || json.get<std::uint64_t>() > UINT32_MAX) return std::nullopt;
  return static_cast<std::uint32_t>(json.get<std::uint64_t>());
}

const Json& list_of(const Json& message, const char* key) {
  static const Json nothing = Json::array();
  const auto found = message.find(key);
  return found != message.end() && found->is_array() ? *found : nothing;
}

/// Each name once, so that a long value is sent once even if it is requested several times.
std::vector<std::string> names_of(const Json& message, const char* key) {
  std::set<std::string> out;
  for (const Json& each : list_of(message, key))
    if (each.is_string() && each.get_ref<const std::string&>().size() <= kLongestName &&
        out.size() < FoxgloveClient::kMostSubscriptions)
      out.insert(each.get<std::string>());
  return {out.begin(), out.end()};
}

}  // namespace

std::string foxglove_subprotocol(std::string_view offered) {
  const std::vector<std::string> names = split_words(offered, ", \t");
  for (const char* known : {"foxglove.sdk.v1", "foxglove.websocket.v1"})
    if (std::find(names.begin(), names.end(), known) != names.end()) return known;
  return {};
}

void FoxgloveServer::set_channels(const std::vector<Channel>& channels) {
  const std::lock_guard lock(mutex_);
  Json gone = Json::array();
  for (const Advertised& each : channels_) gone.push_back(each.id);
  channels_.clear();
  for (const Channel& channel : channels) channels_.push_back({channel, next_id_++, nullptr});
  for (FoxgloveClient* client : clients_) {
    client->subscriptions_.clear();
    if (!gone.empty()) client->put(Json{{"op", "unadvertise"}, {"channelIds", gone}});
    if (!channels_.empty()) client->put(advertisement());
  }
}

FoxgloveServer::Json FoxgloveServer::advertisement() const {
  Json list = Json::array();
  for (const Advertised& each : channels_)
    list.push_back({{"id", each.id},
                    {"topic", each.channel.topic},
                    {"encoding", each.channel.encoding},
                    {"schemaName", each.channel.schema_name},
                    {"schema", each.channel.schema},
                    {"schemaEncoding", each.channel.schema_encoding}});
  return {{"op", "advertise"}, {"channels", std::move(list)}};
}

bool FoxgloveServer::publish(std::size_t channel, std::int64_t time, std::span<const std::byte> payload) {
  const std::lock_guard lock(mutex_);
  if (channel >= channels_.size()) return false;
  Advertised& advertised = channels_[channel];
  std::string body;
  const auto make = [&] {
    if (!body.empty()) return;
    put_number(body, static_cast<std::uint64_t>(time));
    body.append(reinterpret_cast<const char*>(payload.data()), payload.size());
  };
  if (advertised.channel.latched) {
    make();
    advertised.last = std::make_shared<const std::string>(body);
  }
  bool any = false;
  for (FoxgloveClient* client : clients_) {
    const auto subscription = client->subscriptions_.find(advertised.id);
    if (subscription == client->subscriptions_.end()) continue;
    make();
    client->put_message(subscription->second, body);
    any = true;
  }
  return any;
}

bool FoxgloveServer::wanted(std::size_t channel) const {
  const std::lock_guard lock(mutex_);
  if (channel >= channels_.size()) return false;
  const std::uint32_t id = channels_[channel].id;
  return std::any_of(clients_.begin(), clients_.end(),
                     [id](const FoxgloveClient* client) { return client->subscriptions_.contains(id); });
}

void FoxgloveServer::set_own_time(bool own) {
  const std::lock_guard lock(mutex_);
  options_.own_time = own;
}

void FoxgloveServer::report_time(std::int64_t time) {
  std::string body(1, kTime);
  put_number(body, static_cast<std::uint64_t>(time));
  const std::lock_guard lock(mutex_);
  if (!options_.own_time) return;
  for (FoxgloveClient* client : clients_)
    if (client->waiting_bytes_ < FoxgloveClient::kComfortable) client->put(FoxgloveClient::kNone, body);
}

FoxgloveServer::Json FoxgloveServer::parameter_values(const std::vector<std::string>& names) const {
  Json out = Json::array();
  const auto add = [&](const std::string& name, const Json& value) {
    out.push_back({{"name", name}, {"value", value}});
  };
  if (names.empty())
    for (const auto& [name, value] : parameters_) add(name, value);
  for (const std::string& name : names)
    if (const auto at = parameters_.find(name); at != parameters_.end()) add(name, at->second);
  return {{"op", "parameterValues"}, {"parameters", std::move(out)}};
}

void FoxgloveServer::set_parameters(std::map<std::string, Json> parameters) {
  const std::lock_guard lock(mutex_);
  parameters_ = std::move(parameters);
  for (FoxgloveClient* client : clients_) {
    if (client->waiting_bytes_ >= FoxgloveClient::kMostWaiting) continue;  // the client does not read
    if (client->watches_all_) client->put(parameter_values({}));
    if (!client->watches_all_ && !client->watched_.empty())
      client->put(parameter_values({client->watched_.begin(), client->watched_.end()}));
  }
}

void FoxgloveServer::set_assets(AssetSource source) {
  const std::lock_guard lock(mutex_);
  assets_ = std::move(source);
}

void FoxgloveServer::set_wake(std::function<void()> wake) {
  const std::lock_guard lock(mutex_);
  wake_ = std::move(wake);
}

std::shared_ptr<FoxgloveClient> FoxgloveServer::connect() {
  const std::lock_guard lock(mutex_);
  if (clients_.size() >= options_.most_clients) return nullptr;
  std::shared_ptr<FoxgloveClient> out(new FoxgloveClient(*this));
  Json capabilities = {"parameters", "parametersSubscribe", "assets"};
  if (options_.own_time) capabilities.push_back("time");
  out->put(Json{{"op", "serverInfo"},
                {"name", options_.name},
                {"capabilities", capabilities},
                {"supportedEncodings", Json::array()},
                {"metadata", {{"polyarm", options_.version}}},
                {"sessionId", options_.session}});
  if (!channels_.empty()) out->put(advertisement());
  clients_.insert(out.get());
  return out;
}

std::size_t FoxgloveServer::clients() const {
  const std::lock_guard lock(mutex_);
  return clients_.size();
}

void FoxgloveServer::leave(FoxgloveClient* client) {
  const std::lock_guard lock(mutex_);
  clients_.erase(client);
  for (const auto& each : client->waiting_) asset_bytes_ -= each.asset;
}

FoxgloveClient::~FoxgloveClient() {
  server_.leave(this);
}

void FoxgloveClient::put(const Json& message) {
  waiting_.push_back({kNone, {std::make_shared<const std::string>(dump(message)), false}});
  waiting_bytes_ += waiting_.back().out.body->size();
}

void FoxgloveClient::put(std::int64_t subscription, std::string body) {
  waiting_bytes_ += body.size();
  waiting_.push_back({subscription, {std::make_shared<const std::string>(std::move(body)), true}});
}

void FoxgloveClient::put_status(int level, const std::string& text) {
  if (waiting_bytes_ < kComfortable) put(Json{{"op", "status"}, {"level", level}, {"message", text}});
}

void FoxgloveClient::put_message(std::uint32_t subscription, std::string_view time_and_payload) {
  std::string body(1, kMessageData);
  put_number(body, subscription);
  body += time_and_payload;
  if (waiting_bytes_ >= kComfortable) {
    const auto old = std::find_if(waiting_.rbegin(), waiting_.rend(), [&](const Waiting& each) {
      return each.subscription == std::int64_t{subscription};
    });
    if (old != waiting_.rend()) {
      ++omitted_;
      waiting_bytes_ -= old->out.body->size();
      waiting_.erase(std::next(old).base());
    } else if (waiting_bytes_ >= kMostWaiting) {
      ++omitted_;
      return;
    }
  }
  put(subscription, std::move(body));
}

std::optional<FoxgloveClient::Out> FoxgloveClient::next() {
  std::optional<AssetRequest> asset;
  AssetSource source;
  Out out;
  {
    const std::lock_guard lock(server_.mutex_);
    if (waiting_.empty()) return std::nullopt;
    out = std::move(waiting_.front().out);
    waiting_bytes_ -= out.body->size();
    server_.asset_bytes_ -= waiting_.front().asset;
    waiting_.pop_front();
    if (!later_.empty() && may_read_asset()) {
      asset = std::move(later_.front());
      later_.pop_front();
      source = server_.assets_;
      if (source)
        ++assets_;
      else
        refuse_asset(asset->id, "files cannot be read now");
    }
  }
  if (source) read_asset(source, *asset);
  return out;
}

std::uint64_t FoxgloveClient::left_out() const {
  const std::lock_guard lock(server_.mutex_);
  return omitted_;
}

void FoxgloveClient::take_text(std::string_view text) {
  const Json message = Json::parse(text.begin(), text.end(), nullptr, false);
  if (message.is_object()) return dispatch(message);
  const std::lock_guard lock(server_.mutex_);
  put_status(kError, "a message is a JSON object");
}

void FoxgloveClient::take_binary(std::string_view) {
  const std::lock_guard lock(server_.mutex_);
  put_status(
      kError,
      "this connection only watches the cell: messages and calls are refused; use the pendant to move it");
}

void FoxgloveClient::dispatch(const Json& message) {
  const auto found = message.find("op");
  const std::string op =
      found != message.end() && found->is_string() ? found->get<std::string>() : std::string();
  if (op == "subscribe") return subscribe(message);
  if (op == "unsubscribe") return unsubscribe(message);
  if (op == "getParameters") return get_parameters(message);
  if (op == "subscribeParameterUpdates") return watch_parameters(message, true);
  if (op == "unsubscribeParameterUpdates") return watch_parameters(message, false);
  if (op == "fetchAsset") return fetch_asset(message);
  const std::lock_guard lock(server_.mutex_);
  if (op == "setParameters")
    put_status(kError, "parameters are read-only here; set them in the cell's files");
  else if (op == "advertise" || op == "unadvertise")
    put_status(kError,
               "this connection only watches the cell: messages are refused; use the pendant to move it");
  else
    put_status(kError, "'" + op.substr(0, 40) + "' is not offered here");
}

void FoxgloveClient::subscribe(const Json& message) {
  const std::lock_guard lock(server_.mutex_);
  for (const Json& each : list_of(message, "subscriptions")) {
    const auto id = each.is_object() ? number(each.value("id", Json())) : std::nullopt;
    const auto channel = each.is_object() ? number(each.value("channelId", Json())) : std::nullopt;
    if (!id || !channel) {
      put_status(kError, "a subscription needs the numbers 'id' and 'channelId'");
      continue;
    }
    const auto there = std::find_if(server_.channels_.begin(), server_.channels_.end(),
                                    [&](const auto& advertised) { return advertised.id == *channel; });
    const bool used = std::any_of(subscriptions_.begin(), subscriptions_.end(),
                                  [&](const auto& other) { return other.second == *id; });
    if (there == server_.channels_.end())
      put_status(kWarning, "there is no channel " + std::to_string(*channel));
    else if (used || subscriptions_.contains(*channel))
      put_status(kWarning, "the channel " + std::to_string(*channel) + " or the subscription " +
                               std::to_string(*id) + " is in use already");
    else if (subscriptions_.size() >= kMostSubscriptions)
      put_status(kError, "there are too many subscriptions");
    else {
      subscriptions_[*channel] = *id;
      if (there->last) put_message(*id, *there->last);
    }
  }
}

void FoxgloveClient::unsubscribe(const Json& message) {
  const std::lock_guard lock(server_.mutex_);
  for (const Json& each : list_of(message, "subscriptionIds")) {
    const auto id = number(each);
    const auto at = std::find_if(subscriptions_.begin(), subscriptions_.end(),
                                 [&](const auto& one) { return id && one.second == *id; });
    if (at != subscriptions_.end())
      subscriptions_.erase(at);
    else
      put_status(kWarning, "there is no such subscription");
  }
}

void FoxgloveClient::get_parameters(const Json& message) {
  const std::vector<std::string> names = names_of(message, "parameterNames");
  const auto id = message.find("id");
  const std::lock_guard lock(server_.mutex_);
  if (waiting_bytes_ >= kMostWaiting) return;
  Json answer = server_.parameter_values(names);
  if (id != message.end() && id->is_string() && id->get_ref<const std::string&>().size() <= kLongestName)
    answer["id"] = *id;
  put(answer);
}

void FoxgloveClient::watch_parameters(const Json& message, bool on) {
  const std::vector<std::string> names = names_of(message, "parameterNames");
  const std::lock_guard lock(server_.mutex_);
  if (names.empty()) {
    watches_all_ = on;
    if (!on) watched_.clear();
  }
  for (const std::string& name : names) {
    if (!on) watched_.erase(name);
    if (on && watched_.size() < kMostSubscriptions) watched_.insert(name);
  }
}

void FoxgloveClient::fetch_asset(const Json& message) {
  const auto id = number(message.value("requestId", Json()));
  const auto uri = message.find("uri");
  AssetRequest request;
  AssetSource source;
  {
    const std::lock_guard lock(server_.mutex_);
    if (!id || uri == message.end() || !uri->is_string()) {
      put_status(kError, "an asset needs the text 'uri' and the number 'requestId'");
      return;
    }
    request = {*id, uri->get<std::string>()};
    if (!server_.assets_) return refuse_asset(*id, "files cannot be read now");
    if (request.uri.size() > kLongestUri) return refuse_asset(*id, "this URI is too long");
    if (!later_.empty() || !may_read_asset()) {
      if (later_.size() >= kMostLater) return refuse_asset(*id, "too many requests wait: read their answers first");
      later_.push_back(std::move(request));
      return;
    }
    source = server_.assets_;
    ++assets_;
  }
  read_asset(source, request);
}

void FoxgloveClient::read_asset(const AssetSource& source, const AssetRequest& request) {
  source(request.uri, [weak = weak_from_this(), id = request.id](const Asset& asset) {
    const auto self = weak.lock();
    if (!self) return;
    std::function<void()> wake;
    {
      const std::lock_guard lock(self->server_.mutex_);
      --self->assets_;
      self->send_asset(id, asset);
      wake = self->server_.wake_;
    }
    if (wake) wake();
  });
}

/// A client that asks on and on without reading gets no more refusals.
void FoxgloveClient::refuse_asset(std::uint32_t request, const std::string& why) {
  if (waiting_bytes_ < kMostWaiting + kRefusals) send_asset(request, {std::nullopt, why});
}

void FoxgloveClient::send_asset(std::uint32_t request, const Asset& given) {
  const std::size_t bytes = given.data ? given.data->size() : 0;
  const bool room = server_.asset_bytes_ + bytes <= bounds::kAssetBytes;
  const Asset none{std::nullopt, "too much data waits for viewers: try again"};
  const Asset& asset = room ? given : none;
  std::string body(1, kFetchAssetResponse);
  put_number(body, request);
  put_number(body, static_cast<std::uint8_t>(asset.data ? 0 : 1));
  const std::string& problem = asset.data ? std::string() : asset.problem;
  put_number(body, static_cast<std::uint32_t>(problem.size()));
  body += problem;
  if (asset.data) body += *asset.data;
  put(kNone, std::move(body));
  if (asset.data) server_.asset_bytes_ += waiting_.back().asset = bytes;
}

}  // namespace polyarm::recording
