#pragma once
/// Fast DDS 2.9 to 3 at its RTPS layer, with one name for what the two major versions name differently. Only
/// participant.cpp includes this.
#if __has_include(<fastdds/rtps/RTPSDomain.hpp>)
#define POLYARM_FAST_DDS_3 1
#include <fastdds/dds/publisher/qos/WriterQos.hpp>
#include <fastdds/dds/subscriber/qos/ReaderQos.hpp>
#include <fastdds/rtps/RTPSDomain.hpp>
#include <fastdds/rtps/attributes/HistoryAttributes.hpp>
#include <fastdds/rtps/attributes/RTPSParticipantAttributes.hpp>
#include <fastdds/rtps/attributes/ReaderAttributes.hpp>
#include <fastdds/rtps/attributes/WriterAttributes.hpp>
#include <fastdds/rtps/builtin/data/ParticipantBuiltinTopicData.hpp>
#include <fastdds/rtps/builtin/data/PublicationBuiltinTopicData.hpp>
#include <fastdds/rtps/builtin/data/SubscriptionBuiltinTopicData.hpp>
#include <fastdds/rtps/builtin/data/TopicDescription.hpp>
#include <fastdds/rtps/history/ReaderHistory.hpp>
#include <fastdds/rtps/history/WriterHistory.hpp>
#include <fastdds/rtps/participant/ParticipantDiscoveryInfo.hpp>
#include <fastdds/rtps/participant/RTPSParticipant.hpp>
#include <fastdds/rtps/participant/RTPSParticipantListener.hpp>
#include <fastdds/rtps/reader/RTPSReader.hpp>
#include <fastdds/rtps/reader/ReaderListener.hpp>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.hpp>
#include <fastdds/rtps/writer/RTPSWriter.hpp>
#include <fastdds/rtps/writer/WriterListener.hpp>
#include <fastdds/utils/IPLocator.hpp>
#else
#include <fastdds/rtps/RTPSDomain.h>
#include <fastdds/rtps/attributes/HistoryAttributes.h>
#include <fastdds/rtps/attributes/RTPSParticipantAttributes.h>
#include <fastdds/rtps/attributes/ReaderAttributes.h>
#include <fastdds/rtps/attributes/WriterAttributes.h>
#include <fastdds/rtps/builtin/data/ReaderProxyData.h>
#include <fastdds/rtps/builtin/data/WriterProxyData.h>
#include <fastdds/rtps/history/ReaderHistory.h>
#include <fastdds/rtps/history/WriterHistory.h>
#include <fastdds/rtps/participant/ParticipantDiscoveryInfo.h>
#include <fastdds/rtps/participant/RTPSParticipant.h>
#include <fastdds/rtps/participant/RTPSParticipantListener.h>
#include <fastdds/rtps/reader/RTPSReader.h>
#include <fastdds/rtps/reader/ReaderListener.h>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastdds/rtps/writer/RTPSWriter.h>
#include <fastdds/rtps/writer/WriterListener.h>
#include <fastrtps/qos/ReaderQos.h>
#include <fastrtps/qos/WriterQos.h>
#include <fastrtps/utils/IPLocator.h>
#endif

#include <cstdint>
#include <fastdds/rtps/interfaces/IReaderDataFilter.hpp>
#include <string>
#include <type_traits>

namespace polyarm::ros2 {

#ifdef POLYARM_FAST_DDS_3
namespace rtps = eprosima::fastdds::rtps;
namespace rtps_qos = eprosima::fastdds::dds;
inline constexpr auto kNoDiscovery = rtps::DiscoveryProtocol::NONE;
#else
namespace rtps = eprosima::fastrtps::rtps;
namespace rtps_qos = eprosima::fastrtps;
inline constexpr auto kNoDiscovery = rtps::DiscoveryProtocol_t::NONE;
#endif

/// Reports endpoints of other participants, and participants that have left.
class DiscoveryListener : public rtps::RTPSParticipantListener {
 protected:
  /// `topic`, `type`: set for writers, empty for readers.
  virtual void know(const rtps::GUID_t& endpoint, bool there, std::string user_data, std::string topic,
                    std::string type) = 0;
  virtual void forget(const rtps::GUID_t& participant) = 0;
  /// A new participant was found. Our endpoints are announced to it after this returns.
  virtual void meet(rtps::RTPSParticipant& own, const rtps::GUID_t& participant) = 0;

 private:
  template <class Octets>
  static std::string text(const Octets& octets) {
    return {octets.begin(), octets.end()};
  }

#ifdef POLYARM_FAST_DDS_3
  void on_reader_discovery(rtps::RTPSParticipant*, rtps::ReaderDiscoveryStatus reason,
                           const rtps::SubscriptionBuiltinTopicData& info, bool& ignored) override {
    ignored = false;
    know(info.guid, reason != rtps::ReaderDiscoveryStatus::REMOVED_READER, text(info.user_data.data_vec()),
         {}, {});
  }
  void on_writer_discovery(rtps::RTPSParticipant*, rtps::WriterDiscoveryStatus reason,
                           const rtps::PublicationBuiltinTopicData& info, bool& ignored) override {
    ignored = false;
    know(info.guid, reason != rtps::WriterDiscoveryStatus::REMOVED_WRITER, text(info.user_data.data_vec()),
         info.topic_name.c_str(), info.type_name.c_str());
  }
  void on_participant_discovery(rtps::RTPSParticipant* own, rtps::ParticipantDiscoveryStatus reason,
                                const rtps::ParticipantBuiltinTopicData& info, bool& ignored) override {
    ignored = false;
    using Status = rtps::ParticipantDiscoveryStatus;
    if (reason == Status::DISCOVERED_PARTICIPANT && own) meet(*own, info.guid);
    if (reason == Status::REMOVED_PARTICIPANT || reason == Status::DROPPED_PARTICIPANT) forget(info.guid);
  }
#else
  void onReaderDiscovery(rtps::RTPSParticipant*, rtps::ReaderDiscoveryInfo&& info) override {
    know(info.info.guid(), info.status != rtps::ReaderDiscoveryInfo::REMOVED_READER,
         text(info.info.m_qos.m_userData.data_vec()), {}, {});
  }
  void onWriterDiscovery(rtps::RTPSParticipant*, rtps::WriterDiscoveryInfo&& info) override {
    know(info.info.guid(), info.status != rtps::WriterDiscoveryInfo::REMOVED_WRITER,
         text(info.info.m_qos.m_userData.data_vec()), info.info.topicName().c_str(),
         info.info.typeName().c_str());
  }
  void onParticipantDiscovery(rtps::RTPSParticipant* own, rtps::ParticipantDiscoveryInfo&& info) override {
    using Info = rtps::ParticipantDiscoveryInfo;
    if (info.status == Info::DISCOVERED_PARTICIPANT && own) meet(*own, info.info.m_guid);
    if (info.status == Info::REMOVED_PARTICIPANT || info.status == Info::DROPPED_PARTICIPANT)
      forget(info.info.m_guid);
  }
#endif
};

/// Listener of one writer or reader.
class EndpointListener : public rtps::WriterListener, public rtps::ReaderListener {
 protected:
  virtual void match(const rtps::MatchingInfo& info) = 0;
  virtual void take(const rtps::CacheChange_t& change) = 0;

 private:
#ifdef POLYARM_FAST_DDS_3
  void on_writer_matched(rtps::RTPSWriter*, const rtps::MatchingInfo& info) override {
    match(info);
  }
  void on_reader_matched(rtps::RTPSReader*, const rtps::MatchingInfo& info) override {
    match(info);
  }
  void on_new_cache_change_added(rtps::RTPSReader*, const rtps::CacheChange_t* const change) override {
    take(*change);
  }
#else
  void onWriterMatched(rtps::RTPSWriter*, rtps::MatchingInfo& info) override {
    match(info);
  }
  void onReaderMatched(rtps::RTPSReader*, rtps::MatchingInfo& info) override {
    match(info);
  }
  void onNewCacheChangeAdded(rtps::RTPSReader*, const rtps::CacheChange_t* const change) override {
    take(*change);
  }
#endif
};

/// Null if there is no memory.
inline rtps::CacheChange_t* new_change(rtps::RTPSWriter& writer, rtps::WriterHistory& history,
                                       std::uint32_t size) {
#ifdef POLYARM_FAST_DDS_3
  static_cast<void>(writer);
  return history.create_change(size, rtps::ALIVE);
#else
  static_cast<void>(history);
  return writer.new_change([size] { return size; }, rtps::ALIVE);
#endif
}

inline void release_change(rtps::RTPSWriter& writer, rtps::WriterHistory& history,
                           rtps::CacheChange_t* change) {
#ifdef POLYARM_FAST_DDS_3
  static_cast<void>(writer);
  history.release_change(change);
#else
  static_cast<void>(history);
  writer.release_change(change);
#endif
}

inline void set_heartbeat_period(rtps::WriterAttributes& attributes, std::uint32_t milliseconds) {
#ifdef POLYARM_FAST_DDS_3
  attributes.times.heartbeat_period = {0, milliseconds * 1'000'000};
#else
  attributes.times.heartbeatPeriod = {0, milliseconds * 1'000'000};
#endif
}

/// Announces a writer (with WriterQos) or a reader (with ReaderQos) to other participants.
template <class Endpoint, class EndpointQos>
bool announce(rtps::RTPSParticipant& participant, Endpoint* endpoint, const std::string& topic,
              const std::string& type, std::size_t depth, const EndpointQos& offered) {
  constexpr bool kWriter = std::is_same_v<Endpoint, rtps::RTPSWriter>;
#ifdef POLYARM_FAST_DDS_3
  static_cast<void>(depth);
  rtps::TopicDescription description;
  description.topic_name = topic;
  description.type_name = type;
  if constexpr (kWriter)
    return participant.register_writer(endpoint, description, offered);
  else
    return participant.register_reader(endpoint, description, offered);
#else
  eprosima::fastrtps::TopicAttributes attributes(topic.c_str(), type.c_str(), rtps::NO_KEY);
  attributes.historyQos.kind = eprosima::fastrtps::KEEP_LAST_HISTORY_QOS;
  attributes.historyQos.depth = static_cast<std::int32_t>(depth);
  attributes.auto_fill_type_object = false;
  attributes.auto_fill_type_information = false;
  if constexpr (kWriter)
    return participant.registerWriter(endpoint, attributes, offered);
  else
    return participant.registerReader(endpoint, attributes, offered);
#endif
}

}  // namespace polyarm::ros2
