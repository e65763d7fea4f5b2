#include "polyarm/ros2/wire.hpp"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <deque>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <thread>
#include <utility>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/messages/json.hpp"

namespace polyarm::ros2 {

namespace {

using Clock = std::chrono::steady_clock;
/// Topic messages written before replies are checked again.
constexpr std::size_t kAtOnce = 64;
/// How long a reply waits for its reader. The middlewares of ROS 2 wait 0.1 s and block their server. Here
/// nothing blocks, so a client also gets its reply if it called before it was discovered: a client of Fast
/// DDS announces its endpoints again after 3 s.
constexpr auto kTimeout = std::chrono::seconds(10);
/// A server that is matched here may not have matched this client yet. Fast DDS requests samples that it
/// missed. A reader of another middleware treats such a sample as old, so the first call would be lost.
/// Endpoints are announced again each second.
constexpr auto kMutual = std::chrono::milliseconds(1200);
/// The first reply to a reader of Cyclone is delayed by this time. The first heartbeat of a writer counts the
/// samples before it, and such a reader treats these as old: a reply before that heartbeat would be lost. It
/// requests a heartbeat as soon as it knows the writer, and a client does know it.
constexpr auto kFirstReply = std::chrono::milliseconds(100);
constexpr std::size_t kMostAnswered = 4096;
/// Cyclone DDS puts client id and call number before the fields of requests and replies.
constexpr std::size_t kCycloneHeader = 16, kEncapsulation = 4;

/// The value of `key=value;` in user data; "" if missing.
std::string entry_of(const std::string& user_data, const std::string& key) {
  const std::size_t at = user_data.find(key + "=");
  if (at == std::string::npos) return "";
  const std::size_t begin = at + key.size() + 1;
  return user_data.substr(begin, user_data.find(';', begin) - begin);
}

/// The client that called: what is needed to address the reply.
struct Asker {
  Vendor vendor = Vendor::other;
  Related related;        ///< Fast DDS and others: the reader that waits, or the writer that asked
  std::string client_id;  ///< Cyclone: an id that its request writer and reply reader share
  std::array<std::byte, kCycloneHeader> header{};
  Clock::time_point asked = Clock::now();
};

}  // namespace

class Wire::Work {
 public:
  Work(const ParticipantOptions& options, messages::Distribution distribution)
      : participant_{options}, distribution_{distribution} {
    const messages::TypeInfo& type = *find_type(kGraph);
    graph_ =
        participant_.add_writer("ros_discovery_info", type.dds_name, {true, true, 1, true}, type_hash(type));
    thread_ = std::thread([this] { run(); });
  }

  ~Work() {
    {
      const std::lock_guard lock(mutex_);
      over_ = true;
    }
    wake_.notify_all();
    thread_.join();
    for (const auto& [name, node] : nodes_)
      for (const auto& [id, endpoint] : node.endpoints) participant_.remove(id);
  }

  Id publisher(const std::string& node, const std::string& topic, const messages::TypeInfo& type,
               const Qos& qos) {
    const Id id = participant_.add_writer("rt" + topic, type.dds_name, qos, type_hash(type));
    return own(node, id, {false, {}});
  }

  Id subscription(const std::string& node, const std::string& topic, const messages::TypeInfo& type,
                  const Qos& qos, OnMessage on_message) {
    const auto shared = std::make_shared<OnMessage>(std::move(on_message));
    const Id id = participant_.add_reader(
        "rt" + topic, type.dds_name, qos, type_hash(type), [this, shared](const Sample& sample) {
          const Guid own = participant_.prefix();
          if (std::equal(own.begin(), own.begin() + 12, sample.writer.begin())) return;
          enqueue([shared, payload = std::vector<std::byte>(sample.payload.begin(), sample.payload.end())] {
            return !*shared || (*shared)(payload);
          });
        });
    return own(node, id, {true, [shared] { *shared = nullptr; }});
  }

  Id service(const std::string& node, const std::string& name, const std::string& type,
             OnRequest on_request) {
    return service(node, name, part(type, "_Request"), part(type, "_Response"), std::move(on_request));
  }

  Id service(const std::string& node, const std::string& name, const messages::TypeInfo& request,
             const messages::TypeInfo& response, OnRequest on_request) {
    const std::string service_id = "serviceid=" + text_of(unique()) + ";";
    const Id replies = participant_.add_writer("rr" + name + "Reply", response.dds_name, {},
                                               service_id + type_hash(response), true);
    const auto shared = std::make_shared<OnRequest>(std::move(on_request));
    const Id requests = participant_.add_reader(
        "rq" + name + "Request", request.dds_name, {}, service_id + type_hash(request),
        [this, shared, replies](const Sample& sample) { take_request(sample, replies, shared); });
    own(node, replies, {false, {}});
    return own(node, requests, {true, [shared] { *shared = nullptr; }});
  }

  Id client(const std::string& node, const std::string& name, const std::string& type, OnMessage on_reply) {
    return client(node, name, part(type, "_Request"), part(type, "_Response"), std::move(on_reply));
  }

  Id client(const std::string& node, const std::string& name, const messages::TypeInfo& request,
            const messages::TypeInfo& response, OnMessage on_reply) {
    const auto caller = std::make_shared<Caller>();
    caller->me = unique();
    caller->on_reply = std::move(on_reply);
    const std::string client_id = "clientid=" + text_of(caller->me) + ";";
    const Id replies =
        participant_.add_reader("rr" + name + "Reply", response.dds_name, {}, client_id + type_hash(response),
                                [this, caller](const Sample& sample) { take_reply(sample, caller); });
    const Id requests = participant_.add_writer("rq" + name + "Request", request.dds_name, {},
                                                client_id + type_hash(request));
    own(node, replies, {true, [caller] { caller->on_reply = nullptr; }});
    callers_[requests] = {caller, replies};
    return own(node, requests, {false, {}});
  }

  bool ready(Id client) const {
    const auto caller = callers_.find(client);
    if (caller == callers_.end() || participant_.matched(caller->second.second).empty()) return false;
    const auto servers = participant_.matched(client);
    return !servers.empty() && (vendor_of(servers.front().guid) == Vendor::fast_dds ||
                                Clock::now() - servers.front().since > kMutual);
  }

  bool call(Id client, std::vector<std::byte> request) {
    if (!ready(client)) return false;
    Caller& caller = *callers_.at(client).first;
    const auto servers = participant_.matched(client);
    if (servers.empty()) return false;  // it has left in the meantime
    caller.cyclone = vendor_of(servers.front().guid) == Vendor::cyclone;
    caller.writer = participant_.guid(client);
    caller.reader = participant_.guid(callers_.at(client).second);
    ++caller.number;
    if (caller.cyclone) {
      const auto header = caller.header();
      request.insert(request.begin() + kEncapsulation, header.begin(), header.end());
    }
    caller.awaited = participant_.write(client, request, Related{caller.reader, 0});
    return caller.awaited != 0;
  }

  const messages::TypeInfo* find_type(const std::string& name) const {
    return messages::find_type(name, distribution_);
  }

  void remove_node(const std::string& name) {
    const auto at = nodes_.find(name);
    if (at == nodes_.end()) return;
    for (const auto& [id, endpoint] : at->second.endpoints) {
      participant_.remove(id);
      callers_.erase(id);
      if (endpoint.silence) endpoint.silence();
    }
    nodes_.erase(at);
    graph_changed_ = true;
  }

  void publish(Id id, std::vector<std::byte> payload) { send(to_report_, {id, std::move(payload), {}, {}}); }
  bool wanted(Id id) const { return participant_.is_matched(id); }
  bool offered(const std::string& topic, const messages::TypeInfo& type) const {
    return participant_.is_offered("rt" + topic, type.dds_name);
  }

  std::size_t take(std::size_t most) {
    if ((graph_changed_ || participant_.identities() != reported_identities_) && participant_.settled())
      tell_graph();
    std::deque<std::function<bool()>> now;
    {
      const std::lock_guard lock(mutex_);
      while (!waiting_.empty() && now.size() < most) {
        now.push_back(std::move(waiting_.front()));
        waiting_.pop_front();
      }
    }
    for (const auto& work : now)
      if (!work()) refuse(false);
    return now.size();
  }

  void wait(std::chrono::nanoseconds patience) const {
    std::unique_lock lock(mutex_);
    arrived_.wait_for(lock, patience, [this] { return !waiting_.empty(); });
  }

  WireStatistics statistics() const {
    const RemoteStatistics remote = participant_.statistics();
    const std::lock_guard lock(mutex_);
    WireStatistics out = statistics_;
    out.received += remote.too_large + remote.dropped;
    out.refused += remote.too_large;
    out.dropped += remote.dropped;
    out.unsent += remote.unsent;
    return out;
  }
  std::vector<RemoteReport> take_reports() { return participant_.take_reports(); }
  const RemoteParticipant& participant() const { return participant_; }
  messages::Distribution distribution() const { return distribution_; }

  realtime::WakeupHandle rope;

 private:
  struct Endpoint {
    bool reader;
    std::function<void()> silence;  ///< stops callbacks for messages that are already queued
  };
  struct Node {
    std::map<Id, Endpoint> endpoints;
  };
  struct Outgoing {
    Id writer = 0;
    std::vector<std::byte> payload;
    std::optional<Asker> to;
    Clock::time_point until;
  };

  /// State of a client of ours: the call that waits for a reply. Cell thread.
  struct Caller {
    Guid me = kNoGuid;  ///< id that its writer and reader share
    Guid writer = kNoGuid, reader = kNoGuid;
    OnMessage on_reply;
    bool cyclone = false;
    std::int64_t awaited = 0;  ///< Fast DDS: sequence number of the request
    std::int64_t number = 0;   ///< Cyclone: number of the call
    std::array<std::byte, kCycloneHeader> header() const {
      std::array<std::byte, kCycloneHeader> out;
      std::memcpy(out.data(), me.data() + 8, 8);
      std::memcpy(out.data() + 8, &number, 8);
      return out;
    }
  };

  static constexpr const char* kGraph = "rmw_dds_common/msg/ParticipantEntitiesInfo";

  const messages::TypeInfo& part(const std::string& type, const char* name) const {
    const messages::TypeInfo* found = find_type(type + name);
    if (!found) throw Error("unknown-type", "there is no service type " + type);
    return *found;
  }

  /// Humble does not use type hashes. A type of a plugin has none.
  std::string type_hash(const messages::TypeInfo& type) const {
    if (distribution_ == messages::Distribution::humble || *type.hash == '\0') return "";
    return std::string("typehash=") + type.hash + ";";
  }

  /// A unique value in the form of a guid.
  Guid unique() {
    Guid out = participant_.prefix();
    const auto number = static_cast<std::uint32_t>(++uniques_);
    std::memcpy(out.data() + 12, &number, 4);
    return out;
  }

  Id own(const std::string& node, Id id, Endpoint endpoint) {
    nodes_[node].endpoints[id] = std::move(endpoint);
    graph_changed_ = true;
    return id;
  }

  /// `work` returns false if the message is not of its type.
  void enqueue(std::function<bool()> work) {
    {
      const std::lock_guard lock(mutex_);
      ++statistics_.received;
      if (waiting_.size() < bounds::kSamplesToTake)
        waiting_.push_back(std::move(work));
      else
        ++statistics_.dropped;
    }
    arrived_.notify_one();
    rope.pull();
  }

  /// Runs on a thread of the participant.
  void take_request(const Sample& sample, Id replies, const std::shared_ptr<OnRequest>& on_request) {
    Asker asker;
    asker.vendor = vendor_of(sample.writer);
    if (sample.payload.size() < kEncapsulation) return refuse(true);
    std::vector<std::byte> payload(sample.payload.begin(), sample.payload.end());
    asker.related = {sample.related == kNoGuid ? sample.writer : sample.related, sample.sequence};
    if (asker.vendor == Vendor::cyclone) {
      if (payload.size() < kEncapsulation + kCycloneHeader) return refuse(true);
      const auto begin = payload.begin() + kEncapsulation, end = begin + kCycloneHeader;
      std::copy(begin, end, asker.header.begin());
      payload.erase(begin, end);
      asker.client_id = entry_of(participant_.user_data_of_writer(sample.writer), "clientid");
    }
    enqueue([this, asker, replies, on_request, payload = std::move(payload)]() mutable {
      if (!*on_request) return true;
      return (*on_request)({std::move(payload), [this, asker, replies](std::vector<std::byte> reply) {
                              answer({replies, std::move(reply), asker, Clock::now() + kTimeout});
                            }});
    });
  }

  /// Runs on a thread of the participant. Replies to other clients arrive here, too.
  void take_reply(const Sample& sample, const std::shared_ptr<Caller>& caller) {
    const bool cyclone = vendor_of(sample.writer) == Vendor::cyclone;
    if (sample.payload.size() < kEncapsulation + (cyclone ? kCycloneHeader : 0)) return refuse(true);
    enqueue([this, caller, cyclone, related = sample.related, sequence = sample.related_sequence,
             payload = std::vector<std::byte>(sample.payload.begin(), sample.payload.end())]() mutable {
      if (!caller->on_reply || caller->awaited == 0 || cyclone != caller->cyclone) return true;
      if (cyclone) {
        const auto header = caller->header();
        const auto begin = payload.begin() + kEncapsulation;
        if (!std::equal(header.begin(), header.end(), begin)) return true;
        payload.erase(begin, begin + kCycloneHeader);
      } else if (sequence != caller->awaited || (related != caller->reader && related != caller->writer)) {
        return true;
      }
      caller->awaited = 0;
      return caller->on_reply(payload);
    });
  }

  /// `unseen`: the message has not been counted as received yet.
  void refuse(bool unseen) {
    const std::lock_guard lock(mutex_);
    statistics_.received += unseen ? 1 : 0;
    ++statistics_.refused;
  }

  /// Writes the reply at once if its reader is matched; else queues it for the sending thread.
  void answer(Outgoing out) {
    if (!write(out)) send(to_answer_, std::move(out));
  }

  void send(std::deque<Outgoing>& queue, Outgoing out) {
    {
      const std::lock_guard lock(mutex_);
      if (queue.size() >= bounds::kSamplesToSend) {
        ++statistics_.unsent;
        return;
      }
      queue.push_back(std::move(out));
    }
    wake_.notify_one();
  }

  void run() {
    std::deque<Outgoing> postponed;
    std::unique_lock lock(mutex_);
    while (!over_) {
      const auto empty = [this] { return to_answer_.empty() && to_report_.empty(); };
      if (empty()) {
        const auto until = Clock::now() + (postponed.empty() ? std::chrono::milliseconds(500)
                                                             : std::chrono::milliseconds(1));
        wake_.wait_until(lock, until, [&] { return over_ || !empty(); });
      }
      std::deque<Outgoing> now = std::exchange(to_answer_, {});
      for (std::size_t i = 0; i < kAtOnce && !to_report_.empty(); ++i) {
        now.push_back(std::move(to_report_.front()));
        to_report_.pop_front();
      }
      lock.unlock();
      std::deque<Outgoing> still;
      std::uint64_t given_up = 0;
      for (auto* list : {&postponed, &now})
        for (Outgoing& out : *list)
          if (!write(out)) {
            if (still.size() < bounds::kSamplesToSend)
              still.push_back(std::move(out));
            else
              ++given_up;
          }
      postponed = std::move(still);
      lock.lock();
      statistics_.unsent += given_up;
    }
  }

  /// Returns false if it must wait for its reader. Runs on the sending thread; for a reply, also on the
  /// thread that answers.
  bool write(Outgoing& out) {
    std::optional<Related> related;
    if (out.to) {
      const auto reader = reader_of(*out.to, out.writer);
      if (!reader && Clock::now() < out.until) return false;
      if (reader && out.to->vendor == Vendor::cyclone && !hears(*reader, out.to->asked)) return false;
      related = Related{out.to->vendor == Vendor::cyclone && reader ? *reader : out.to->related.guid,
                        out.to->related.sequence};
      if (out.to->vendor == Vendor::cyclone)
        out.payload.insert(out.payload.begin() + kEncapsulation, out.to->header.begin(),
                           out.to->header.end());
    }
    const bool sent = participant_.write(out.writer, out.payload, related) != 0;
    const std::lock_guard lock(mutex_);
    ++(sent ? statistics_.sent : statistics_.unsent);
    return true;
  }

  /// True if this Cyclone reader got a reply before, or has had time to hear of the writer.
  bool hears(const Guid& reader, Clock::time_point asked) {
    const std::lock_guard lock(mutex_);
    if (answered_.contains(reader)) return true;
    if (Clock::now() < asked + kFirstReply) return false;
    if (answered_.size() >= kMostAnswered) answered_.clear();
    answered_.insert(reader);
    return true;
  }

  /// The matched reader that waits for the reply to this client; nothing if it is not matched yet.
  std::optional<Guid> reader_of(const Asker& asker, Id replies) const {
    for (const Remote& remote : participant_.matched(replies)) {
      if (asker.vendor == Vendor::cyclone) {
        const bool known = !asker.client_id.empty();
        if (vendor_of(remote.guid) == Vendor::cyclone &&
            (!known || entry_of(remote.user_data, "clientid") == asker.client_id))
          return remote.guid;
      } else if (remote.guid == asker.related.guid ||
                 (std::equal(remote.guid.begin(), remote.guid.begin() + 12, asker.related.guid.begin()) &&
                  asker.related.guid[15] != 0x04 && asker.related.guid[15] != 0x07)) {
        return remote.guid;  // the reader itself, or one of the same participant if a writer asked
      }
    }
    return std::nullopt;
  }

  /// Publishes all endpoints of our nodes; called after every change.
  void tell_graph() {
    struct Ends {
      nlohmann::json readers = nlohmann::json::array(), writers = nlohmann::json::array();
    };
    const std::uint64_t identities = participant_.identities();
    std::map<std::string, Ends> ends;
    for (const auto& [group, node] : nodes_) {
      Ends& of = ends[group.substr(0, group.find('@'))];
      for (const auto& [id, endpoint] : node.endpoints)
        (endpoint.reader ? of.readers : of.writers).push_back(gid(participant_.guid(id)));
    }
    nlohmann::json nodes = nlohmann::json::array();
    for (auto& [name, of] : ends) {
      const std::size_t slash = name.rfind('/');
      nodes.push_back({{"node_namespace", slash == 0 ? "/" : name.substr(0, slash)},
                       {"node_name", name.substr(slash + 1)},
                       {"reader_gid_seq", std::move(of.readers)},
                       {"writer_gid_seq", std::move(of.writers)}});
    }
    graph_changed_ = false;
    reported_identities_ = identities;
    publish(graph_, messages::from_json(*find_type(kGraph), {{"gid", gid(participant_.prefix())},
                                                             {"node_entities_info_seq", std::move(nodes)}}));
  }

  /// Humble uses 24 bytes; the last are zero.
  nlohmann::json gid(const Guid& guid) const {
    std::vector<std::uint8_t> bytes(guid.begin(), guid.end());
    bytes.resize(distribution_ == messages::Distribution::humble ? 24 : 16);
    return {{"data", bytes}};
  }

  RemoteParticipant participant_;
  const messages::Distribution distribution_;
  Id graph_ = 0;
  std::map<std::string, Node> nodes_;
  bool graph_changed_ = true;
  std::uint64_t reported_identities_ = 0;
  std::uint64_t uniques_ = 0;
  std::map<Id, std::pair<std::shared_ptr<Caller>, Id>> callers_;  ///< by request writer: caller and its reply
                                                                  ///< reader

  mutable std::mutex mutex_;
  std::condition_variable wake_;
  mutable std::condition_variable arrived_;
  std::deque<std::function<bool()>> waiting_;
  /// Replies have their own queue, so a flood of topic messages (as in lock-step) does not delay them.
  std::deque<Outgoing> to_answer_, to_report_;
  std::set<Guid> answered_;  ///< readers of Cyclone that got a reply
  WireStatistics statistics_;
  bool over_ = false;
  std::thread thread_;
};

Wire::Wire(const ParticipantOptions& options, messages::Distribution distribution)
    : work_{std::make_unique<Work>(options, distribution)} {}
Wire::~Wire() = default;
Wire::Id Wire::publisher(const std::string& node, const std::string& topic, const messages::TypeInfo& type,
                         const Qos& qos) {
  return work_->publisher(node, topic, type, qos);
}
Wire::Id Wire::subscription(const std::string& node, const std::string& topic, const messages::TypeInfo& type,
                            const Qos& qos, OnMessage on_message) {
  return work_->subscription(node, topic, type, qos, std::move(on_message));
}
Wire::Id Wire::service(const std::string& node, const std::string& name, const std::string& type,
                       OnRequest on_request) {
  return work_->service(node, name, type, std::move(on_request));
}
Wire::Id Wire::service(const std::string& node, const std::string& name, const messages::TypeInfo& request,
                       const messages::TypeInfo& response, OnRequest on_request) {
  return work_->service(node, name, request, response, std::move(on_request));
}
Wire::Id Wire::client(const std::string& node, const std::string& name, const std::string& type,
                      OnMessage on_reply) {
  return work_->client(node, name, type, std::move(on_reply));
}
Wire::Id Wire::client(const std::string& node, const std::string& name, const messages::TypeInfo& request,
                      const messages::TypeInfo& response, OnMessage on_reply) {
  return work_->client(node, name, request, response, std::move(on_reply));
}
bool Wire::ready(Id client) const {
  return work_->ready(client);
}
bool Wire::call(Id client, std::vector<std::byte> request) {
  return work_->call(client, std::move(request));
}
const messages::TypeInfo* Wire::find_type(const std::string& name) const {
  return work_->find_type(name);
}
void Wire::remove_node(const std::string& name) {
  work_->remove_node(name);
}
void Wire::publish(Id publisher, std::vector<std::byte> payload) {
  work_->publish(publisher, std::move(payload));
}
bool Wire::wanted(Id publisher) const {
  return work_->wanted(publisher);
}
bool Wire::offered(const std::string& topic, const messages::TypeInfo& type) const {
  return work_->offered(topic, type);
}
std::size_t Wire::take(std::size_t most) {
  return work_->take(most);
}
void Wire::wait(std::chrono::nanoseconds patience) const {
  work_->wait(patience);
}
void Wire::set_wakeup(const std::shared_ptr<realtime::Bell>& bell) {
  work_->rope.tie(bell);
}
WireStatistics Wire::statistics() const {
  return work_->statistics();
}
std::vector<RemoteReport> Wire::take_reports() {
  return work_->take_reports();
}
const RemoteParticipant& Wire::participant() const {
  return work_->participant();
}
messages::Distribution Wire::distribution() const {
  return work_->distribution();
}

}  // namespace polyarm::ros2
