#include "polyarm/participant/participant.hpp"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

#include "polyarm/base/error.hpp"
#include "polyarm/participant/fast_dds.hpp"
#include "polyarm/participant/loopback_transport.hpp"

namespace polyarm::ros2 {

using rtps::IPLocator;

namespace {

Guid guid_of(const rtps::GUID_t& guid) {
  Guid out;
  std::memcpy(out.data(), guid.guidPrefix.value, 12);
  std::memcpy(out.data() + 12, guid.entityId.value, 4);
  return out;
}

rtps::GUID_t guid_of(const Guid& guid) {
  rtps::GUID_t out;
  std::memcpy(out.guidPrefix.value, guid.data(), 12);
  std::memcpy(out.entityId.value, guid.data() + 12, 4);
  return out;
}

std::vector<rtps::octet> octets_of(const std::string& text) {
  return {text.begin(), text.end()};
}

/// Time that a new participant needs to register this one.
constexpr auto kIntroduction = std::chrono::milliseconds(20);

[[noreturn]] void refuse(const std::string& what, const std::string& advice = {}) {
  throw Error("no-dds", what, advice);
}

/// Sends each reader of Fast DDS only the replies addressed to it. Cyclone's readers get all replies: they
/// recognise their own by a header, and would lose the first sample after a gap.
class OnlyItsOwn : public eprosima::fastdds::rtps::IReaderDataFilter {
 public:
  bool is_relevant(const rtps::CacheChange_t& change, const rtps::GUID_t& reader) const override {
    return vendor_of(guid_of(reader)) != Vendor::fast_dds ||
           change.write_params.related_sample_identity().writer_guid() == reader;
  }
};

/// The identity is in one field if the sample came over the wire, in the other if it came from this process.
Related related_of(const rtps::WriteParams& params) {
  const auto& within = params.related_sample_identity();
  const auto& identity = within.writer_guid() != rtps::c_Guid_Unknown ? within : params.sample_identity();
  return {guid_of(identity.writer_guid()), static_cast<std::int64_t>(identity.sequence_number().to64long())};
}

/// Locator of a peer, given by address or host name. `localhost` is always this machine (RFC 6761).
rtps::Locator_t locator_of(const std::string& told) {
  rtps::Locator_t out;
  const std::string peer = told == "localhost" ? "127.0.0.1" : told;
  if (IPLocator::isIPv4(peer) && IPLocator::setIPv4(out, peer)) return out;
  const auto found = IPLocator::resolveNameDNS(peer).first;
  if (found.empty() || !IPLocator::setIPv4(out, *found.begin()))
    refuse("the peer '" + peer + "' is neither an IPv4 address nor the name of a machine that has one",
           "check ROS_STATIC_PEERS and `ros2: {peers: …}`");
  return out;
}

rtps::RTPSParticipantAttributes attributes_of(const ParticipantOptions& options) {
  rtps::RTPSParticipantAttributes out;
  out.setName("polyarm");
  out.userData = octets_of(options.user_data);
  out.useBuiltinTransports = false;
  const auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  udp->maxInitialPeersRange = 32;
  if (options.loopback) udp->interfaceWhiteList = {"127.0.0.1"};
  if (options.loopback)
    out.userTransports.push_back(std::make_shared<AboveUdp<LoopbackTransport>>(udp));
  else
    out.userTransports.push_back(std::make_shared<AboveUdp<PlainKeysTransport>>(udp));
  auto& discovery = out.builtin.discovery_config;
  if (!options.discovery) discovery.discoveryProtocol = kNoDiscovery;
  // Other participants forget a process that was killed after 50 missed announcements.
  discovery.leaseDuration = {5, 0};
  discovery.leaseDuration_announcementperiod = {0, 100'000'000};
  out.builtin.avoid_builtin_multicast = options.loopback;
  std::vector<std::string> peers = options.peers;
  peers.emplace_back("127.0.0.1");
  if (!options.loopback) peers.emplace_back("239.255.0.1");
  for (const std::string& peer : peers) {
    rtps::Locator_t locator = locator_of(peer);
    if (peer.starts_with("239.")) locator.port = 7400 + 250 * options.domain;
    out.builtin.initialPeersList.push_back(locator);
  }
  return out;
}

}  // namespace

class Participant::Work : public DiscoveryListener {
  struct Endpoint;

 public:
  Work(const ParticipantOptions& options, ParticipantObserver* observer) : observer_{observer} {
    participant_ = rtps::RTPSDomain::createParticipant(options.domain, attributes_of(options), this);
    if (!participant_)
      refuse("no participant in domain " + std::to_string(options.domain) + " can be made",
             "check that its ports are free: 7400 + 250 × domain and those after it");
    const std::lock_guard lock(mutex_);
    own_ = participant_->getGuid().guidPrefix;
  }

  ~Work() override {
    while (!endpoints_.empty()) remove(endpoints_.begin()->first);
    rtps::RTPSDomain::removeRTPSParticipant(participant_);
  }

  Id add_writer(const std::string& topic, const std::string& type, const Qos& qos,
                const std::string& user_data, bool addressed, Id id) {
    auto endpoint = std::make_unique<Endpoint>(*this, next(id));
    rtps::WriterAttributes attributes;
    attributes.endpoint = endpoint_attributes(qos);
    set_heartbeat_period(attributes, 100);
    endpoint->depth = std::max<std::size_t>(1, qos.depth);
    endpoint->written = std::make_unique<rtps::WriterHistory>(history_attributes());
    endpoint->writer =
        rtps::RTPSDomain::createRTPSWriter(participant_, attributes, endpoint->written.get(), endpoint.get());
    if (!endpoint->writer) refuse("no writer of " + topic + " can be made");
    if (addressed) endpoint->writer->reader_data_filter(&filter_);
    if (!announce(*participant_, endpoint->writer, topic, type, endpoint->depth,
                  stated<rtps_qos::WriterQos>(qos, user_data))) {
      rtps::RTPSDomain::removeRTPSWriter(endpoint->writer);
      refuse("the writer of " + topic + " cannot be announced");
    }
    return keep(std::move(endpoint));
  }

  Id add_reader(const std::string& topic, const std::string& type, const Qos& qos,
                const std::string& user_data, OnSample on_sample, Id id) {
    auto endpoint = std::make_unique<Endpoint>(*this, next(id));
    endpoint->on_sample = std::move(on_sample);
    rtps::ReaderAttributes attributes;
    attributes.endpoint = endpoint_attributes(qos);
    attributes.endpoint.endpointKind = rtps::READER;
    endpoint->received = std::make_unique<rtps::ReaderHistory>(history_attributes());
    endpoint->reader = rtps::RTPSDomain::createRTPSReader(participant_, attributes, endpoint->received.get(),
                                                          endpoint.get());
    if (!endpoint->reader) refuse("no reader of " + topic + " can be made");
    if (!announce(*participant_, endpoint->reader, topic, type, std::max<std::size_t>(1, qos.depth),
                  stated<rtps_qos::ReaderQos>(qos, user_data))) {
      rtps::RTPSDomain::removeRTPSReader(endpoint->reader);
      refuse("the reader of " + topic + " cannot be announced");
    }
    return keep(std::move(endpoint));
  }

  void remove(Id id) {
    std::unique_ptr<Endpoint> endpoint;
    {
      const std::lock_guard lock(mutex_);
      const auto at = endpoints_.find(id);
      if (at == endpoints_.end()) return;
      endpoint = std::move(at->second);
      endpoints_.erase(at);
    }
    if (endpoint->writer) rtps::RTPSDomain::removeRTPSWriter(endpoint->writer);
    if (endpoint->reader) rtps::RTPSDomain::removeRTPSReader(endpoint->reader);
  }

  std::int64_t write(Id id, std::span<const std::byte> payload, const std::optional<Related>& related) {
    Endpoint* endpoint = find(id);
    if (!endpoint || !endpoint->writer) return 0;
    const std::lock_guard one_at_a_time(endpoint->writing);
    const auto size = static_cast<std::uint32_t>(payload.size());
    while (endpoint->written->getHistorySize() >= endpoint->depth) endpoint->written->remove_min_change();
    rtps::CacheChange_t* change = new_change(*endpoint->writer, *endpoint->written, size);
    if (!change || change->serializedPayload.max_size < size) {
      if (change) release_change(*endpoint->writer, *endpoint->written, change);
      return 0;
    }
    std::memcpy(change->serializedPayload.data, payload.data(), size);
    change->serializedPayload.length = size;
    change->serializedPayload.encapsulation = CDR_LE;
    rtps::WriteParams params;
    if (!related) return added(*endpoint, change, params);
    params.related_sample_identity().writer_guid(guid_of(related->guid));
    const auto sequence = static_cast<std::uint64_t>(related->sequence);
    params.related_sample_identity().sequence_number(rtps::SequenceNumber_t(
        static_cast<std::int32_t>(sequence >> 32), static_cast<std::uint32_t>(sequence)));
    return added(*endpoint, change, params);
  }

  Guid guid(Id id) const {
    const Endpoint* endpoint = find(id);
    if (!endpoint) return kNoGuid;
    return guid_of(endpoint->writer ? endpoint->writer->getGuid() : endpoint->reader->getGuid());
  }
  Guid prefix() const { return guid_of(participant_->getGuid()); }

  std::vector<Remote> matched(Id id) const {
    std::vector<Remote> out;
    const std::lock_guard lock(mutex_);
    const auto at = endpoints_.find(id);
    if (at == endpoints_.end()) return out;
    for (const auto& [guid, since] : at->second->matched) {
      const auto known = remotes_.find(guid);
      out.push_back({guid, known == remotes_.end() ? "" : known->second, since});
    }
    return out;
  }

  std::string user_data_of_writer(const Guid& writer) const {
    const std::lock_guard lock(mutex_);
    const auto known = remotes_.find(writer);
    return known == remotes_.end() ? "" : known->second;
  }

  std::size_t known() const {
    const std::lock_guard lock(mutex_);
    return remotes_.size();
  }

 private:
  struct Endpoint : EndpointListener {
    Endpoint(Work& work, Id called) : owner(work), id(called) {}
    void match(const rtps::MatchingInfo& info) override { owner.match(*this, info); }
    void take(const rtps::CacheChange_t& change) override {
      const rtps::SerializedPayload_t& payload = change.serializedPayload;
      const Related related = related_of(change.write_params);
      if (change.kind == rtps::ALIVE && payload.data)
        on_sample({{reinterpret_cast<const std::byte*>(payload.data), payload.length},
                   guid_of(change.writerGUID),
                   static_cast<std::int64_t>(change.sequenceNumber.to64long()),
                   related.guid,
                   related.sequence});
      received->remove_change(const_cast<rtps::CacheChange_t*>(&change));
    }

    Work& owner;
    const Id id;
    rtps::RTPSWriter* writer = nullptr;
    rtps::RTPSReader* reader = nullptr;
    std::unique_ptr<rtps::WriterHistory> written;
    std::unique_ptr<rtps::ReaderHistory> received;
    std::size_t depth = 10;
    std::mutex writing;
    OnSample on_sample;
    std::map<Guid, std::chrono::steady_clock::time_point> matched;  ///< with the time since when; protected
                                                                    ///< by mutex_
  };

  static std::int64_t added(Endpoint& endpoint, rtps::CacheChange_t* change, rtps::WriteParams& params) {
    if (!endpoint.written->add_change(change, params)) return 0;
    return static_cast<std::int64_t>(params.sample_identity().sequence_number().to64long());
  }

  static rtps::EndpointAttributes endpoint_attributes(const Qos& qos) {
    rtps::EndpointAttributes out;
    out.reliabilityKind = qos.reliable ? rtps::RELIABLE : rtps::BEST_EFFORT;
    out.durabilityKind = qos.transient_local ? rtps::TRANSIENT_LOCAL : rtps::VOLATILE;
    out.topicKind = rtps::NO_KEY;
    return out;
  }
  static rtps::HistoryAttributes history_attributes() {
    rtps::HistoryAttributes out;
    out.memoryPolicy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    out.payloadMaxSize = 512;
    out.initialReservedCaches = 8;
    return out;
  }
  /// WriterQos or ReaderQos; both use the same names for reliability and durability.
  template <class Stated>
  static Stated stated(const Qos& wanted, const std::string& user_data) {
    Stated out;
    out.m_reliability.kind =
        wanted.reliable ? rtps_qos::RELIABLE_RELIABILITY_QOS : rtps_qos::BEST_EFFORT_RELIABILITY_QOS;
    out.m_durability.kind =
        wanted.transient_local ? rtps_qos::TRANSIENT_LOCAL_DURABILITY_QOS : rtps_qos::VOLATILE_DURABILITY_QOS;
    out.m_userData.setValue(octets_of(user_data));
    return out;
  }

  Id next(Id wanted) {
    const std::lock_guard lock(mutex_);
    last_id_ = std::max(last_id_ + (wanted == 0 ? 1 : 0), wanted);
    return wanted == 0 ? last_id_ : wanted;
  }
  Id keep(std::unique_ptr<Endpoint> endpoint) {
    const std::lock_guard lock(mutex_);
    const Id id = endpoint->id;
    endpoints_.emplace(id, std::move(endpoint));
    return id;
  }
  Endpoint* find(Id id) const {
    const std::lock_guard lock(mutex_);
    const auto at = endpoints_.find(id);
    return at == endpoints_.end() ? nullptr : at->second.get();
  }

  void match(Endpoint& endpoint, const rtps::MatchingInfo& info) {
    const std::lock_guard lock(mutex_);
    const Guid guid = guid_of(info.remoteEndpointGuid);
    const bool matches = info.status == rtps::MATCHED_MATCHING;
    if (matches)
      endpoint.matched.try_emplace(guid, std::chrono::steady_clock::now());
    else
      endpoint.matched.erase(guid);
    if (observer_) observer_->on_match(endpoint.id, guid, matches);
  }

  void know(const rtps::GUID_t& guid, bool there, std::string user_data, std::string topic,
            std::string type) override {
    const std::lock_guard lock(mutex_);
    if (guid.guidPrefix == own_) return;
    const Guid endpoint = guid_of(guid);
    if (!there) {
      remotes_.erase(endpoint);
      if (observer_) observer_->on_unknown(endpoint);
      return;
    }
    if (observer_) observer_->on_known(endpoint, user_data, {std::move(topic), std::move(type)});
    remotes_[endpoint] = std::move(user_data);
  }

  /// Cyclone ignores messages from a participant that it has not discovered yet, and would learn of our
  /// endpoints one second later. So this participant announces itself first. Runs on the discovery thread.
  void meet(rtps::RTPSParticipant& own, const rtps::GUID_t& participant) override {
    if (vendor_of(guid_of(participant)) != Vendor::cyclone) return;
    own.announceRTPSParticipantState();
    std::this_thread::sleep_for(kIntroduction);
  }

  /// A participant has left or timed out. Its endpoints are not reported one by one.
  void forget(const rtps::GUID_t& participant) override {
    const Guid gone = guid_of(participant);
    const std::lock_guard lock(mutex_);
    std::erase_if(remotes_, [&](const auto& remote) {
      return std::equal(gone.begin(), gone.begin() + 12, remote.first.begin());
    });
    if (observer_) observer_->on_forgotten(gone);
  }

  ParticipantObserver* const observer_;
  rtps::RTPSParticipant* participant_ = nullptr;
  rtps::GuidPrefix_t own_;
  OnlyItsOwn filter_;
  mutable std::mutex mutex_;
  std::map<Id, std::unique_ptr<Endpoint>> endpoints_;
  Id last_id_ = 0;
  std::map<Guid, std::string> remotes_;  ///< user data by endpoint
};

Participant::Participant(const ParticipantOptions& options, ParticipantObserver* observer)
    : work_{std::make_unique<Work>(options, observer)} {}
Participant::~Participant() = default;
Participant::Id Participant::add_writer(const std::string& topic, const std::string& type, const Qos& qos,
                                        const std::string& user_data, bool addressed, Id id) {
  return work_->add_writer(topic, type, qos, user_data, addressed, id);
}
Participant::Id Participant::add_reader(const std::string& topic, const std::string& type, const Qos& qos,
                                        const std::string& user_data, OnSample on_sample, Id id) {
  return work_->add_reader(topic, type, qos, user_data, std::move(on_sample), id);
}
void Participant::remove(Id id) {
  work_->remove(id);
}
std::int64_t Participant::write(Id writer, std::span<const std::byte> payload,
                                const std::optional<Related>& related) {
  return work_->write(writer, payload, related);
}
Guid Participant::guid(Id id) const {
  return work_->guid(id);
}
Guid Participant::prefix() const {
  return work_->prefix();
}
std::vector<Remote> Participant::matched(Id id) const {
  return work_->matched(id);
}
std::string Participant::user_data_of_writer(const Guid& writer) const {
  return work_->user_data_of_writer(writer);
}
std::size_t Participant::known() const {
  return work_->known();
}

}  // namespace polyarm::ros2
