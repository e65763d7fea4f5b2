#pragma once
/// A node as rmw_fastrtps makes one: the DDS layer of Fast DDS, its transports and its discovery in each
/// range, services told apart by related identities. Nothing of Polyarm's own wire is in it; payloads are raw
/// CDR. Of Fast DDS 2: the third generation has other headers and names.
#if __has_include(<fastrtps/utils/IPLocator.h>)
#define POLYARM_RMW_FAST 1
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastdds/rtps/transport/shared_mem/SharedMemTransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace polyarm::ros2::test {

namespace dds = eprosima::fastdds::dds;
namespace fast = eprosima::fastrtps::rtps;
using Bytes = std::vector<std::byte>;

class RmwNode {
 public:
  enum class Range { localhost, subnet };

  /// `listener` is told of who is found; it outlives the node. `vendor`: it says that it is another's.
  /// `shared_memory`: in the range localhost, as rmw_fastrtps has it; else UDP alone.
  RmwNode(std::uint32_t domain, Range range, dds::DomainParticipantListener* listener = nullptr,
          std::optional<std::array<std::uint8_t, 2>> vendor = {}, bool shared_memory = true) {
    dds::DomainParticipantQos qos = factory()->get_default_participant_qos();
    if (vendor) {
      static std::uint8_t count = 0;
      auto& prefix = qos.wire_protocol().prefix.value;
      std::copy(vendor->begin(), vendor->end(), prefix);
      prefix[8] = static_cast<fast::octet>(::getpid());
      prefix[9] = static_cast<fast::octet>(::getpid() >> 8);
      prefix[11] = ++count;
    }
    auto& builtin = qos.wire_protocol().builtin;
    if (range == Range::localhost) {
      builtin.metatrafficMulticastLocatorList.clear();
      builtin.metatrafficUnicastLocatorList.push_back(fast::Locator_t());
      qos.transport().use_builtin_transports = false;
      if (shared_memory)
        qos.transport().user_transports.push_back(
            std::make_shared<eprosima::fastdds::rtps::SharedMemTransportDescriptor>());
      const auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
      udp->maxInitialPeersRange = 32;
      qos.transport().user_transports.push_back(udp);
      fast::Locator_t peer;
      fast::IPLocator::setIPv4(peer, "127.0.0.1");
      builtin.initialPeersList.push_back(peer);
    }
    builtin.readerHistoryMemoryPolicy = builtin.writerHistoryMemoryPolicy =
        fast::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    const std::string enclave = "enclave=/;";
    qos.user_data().resize(enclave.size());
    std::memcpy(qos.user_data().data(), enclave.data(), enclave.size());
    participant_ = factory()->create_participant(domain, qos, listener, dds::StatusMask::none());
    if (!participant_) throw std::runtime_error("no participant");
    publisher_ = participant_->create_publisher(dds::PUBLISHER_QOS_DEFAULT);
    subscriber_ = participant_->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT);
  }
  ~RmwNode() {
    participant_->delete_contained_entities();
    factory()->delete_participant(participant_);
  }
  RmwNode(const RmwNode&) = delete;
  RmwNode& operator=(const RmwNode&) = delete;

  dds::DataReader* reader(const std::string& topic, const std::string& type, bool latched = false,
                          bool reliable = true, int depth = 10) {
    dds::DataReaderQos qos = subscriber_->get_default_datareader_qos();
    state(qos, latched, reliable);
    if (!latched) qos.history().depth = depth;
    return subscriber_->create_datareader(topic_of(topic, type), qos);
  }
  dds::DataWriter* writer(const std::string& topic, const std::string& type, int depth = 10) {
    dds::DataWriterQos qos = publisher_->get_default_datawriter_qos();
    state(qos, false, true);
    qos.history().depth = depth;
    return publisher_->create_datawriter(topic_of(topic, type), qos);
  }
  /// The next sample, if one has come; its identity in `info`.
  static std::optional<Bytes> take(dds::DataReader& reader, dds::SampleInfo* info = nullptr) {
    dds::SampleInfo own;
    Bytes out;
    dds::SampleInfo& about = info ? *info : own;
    if (reader.take_next_sample(&out, &about) != eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK ||
        !about.valid_data)
      return std::nullopt;
    return out;
  }

  /// A client of one service.
  class Caller {
   public:
    Caller(RmwNode& node, const std::string& service, const std::string& request, const std::string& response)
        : replies_{node.reader("rr" + service + "Reply", response)},
          requests_{node.writer("rq" + service + "Request", request)} {}
    bool ready() const {
      dds::PublicationMatchedStatus sent;
      dds::SubscriptionMatchedStatus got;
      requests_->get_publication_matched_status(sent);
      replies_->get_subscription_matched_status(got);
      return sent.current_count > 0 && sent.current_count == got.current_count;
    }
    void ask(Bytes request) {
      fast::WriteParams params;
      params.related_sample_identity().writer_guid(replies_->guid());
      requests_->write(&request, params);
      asked_ = params.sample_identity().sequence_number();
    }
    std::optional<Bytes> answer() {
      dds::SampleInfo info;
      while (auto out = take(*replies_, &info)) {
        const auto& who = info.related_sample_identity.writer_guid();
        const bool mine = who == replies_->guid() || who == requests_->guid();
        if (mine && info.related_sample_identity.sequence_number() == asked_) return out;
      }
      return std::nullopt;
    }

   private:
    dds::DataReader* replies_;
    dds::DataWriter* requests_;
    fast::SequenceNumber_t asked_;
  };

 private:
  /// The bytes as they are, with their encapsulation.
  class Raw : public dds::TopicDataType {
   public:
    explicit Raw(const std::string& type) {
      setName(type.c_str());
      m_typeSize = 512;
      auto_fill_type_object(false);
      auto_fill_type_information(false);
    }
    bool serialize(void* data, fast::SerializedPayload_t* payload) override {
      const auto& bytes = *static_cast<const Bytes*>(data);
      if (payload->max_size < bytes.size()) return false;
      std::memcpy(payload->data, bytes.data(), bytes.size());
      payload->length = static_cast<std::uint32_t>(bytes.size());
      payload->encapsulation = CDR_LE;
      return true;
    }
    bool deserialize(fast::SerializedPayload_t* payload, void* data) override {
      const auto* begin = reinterpret_cast<const std::byte*>(payload->data);
      static_cast<Bytes*>(data)->assign(begin, begin + payload->length);
      return true;
    }
    std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
      return [data] { return static_cast<std::uint32_t>(static_cast<const Bytes*>(data)->size()); };
    }
    void* createData() override { return new Bytes; }
    void deleteData(void* data) override { delete static_cast<Bytes*>(data); }
    bool getKey(void*, fast::InstanceHandle_t*, bool) override { return false; }
  };

  static dds::DomainParticipantFactory* factory() { return dds::DomainParticipantFactory::get_instance(); }

  template <class Qos>
  static void state(Qos& qos, bool latched, bool reliable) {
    qos.endpoint().history_memory_policy = fast::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    qos.data_sharing().off();
    qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
    qos.history().depth = latched ? 1 : 10;
    qos.reliability().kind = reliable ? dds::RELIABLE_RELIABILITY_QOS : dds::BEST_EFFORT_RELIABILITY_QOS;
    qos.durability().kind = latched ? dds::TRANSIENT_LOCAL_DURABILITY_QOS : dds::VOLATILE_DURABILITY_QOS;
  }
  dds::Topic* topic_of(const std::string& topic, const std::string& type) {
    if (!participant_->find_type(type)) dds::TypeSupport(new Raw(type)).register_type(participant_);
    if (dds::TopicDescription* known = participant_->lookup_topicdescription(topic))
      return static_cast<dds::Topic*>(known);
    return participant_->create_topic(topic, type, dds::TOPIC_QOS_DEFAULT);
  }

  dds::DomainParticipant* participant_ = nullptr;
  dds::Publisher* publisher_ = nullptr;
  dds::Subscriber* subscriber_ = nullptr;
};

}  // namespace polyarm::ros2::test
#endif
