#pragma once
/// A client on Cyclone DDS, on loopback alone, as ROS 2's middleware on it is configured for LOCALHOST.
#include <dds/dds.h>

#include <cstdlib>
#include <stdexcept>
#include <string>

namespace polyarm::ros2::test {

class Cyclone {
 public:
  explicit Cyclone(std::uint32_t domain) {
    ::setenv("CYCLONEDDS_URI",
             "<General><Interfaces><NetworkInterface "
             "name='lo'/></Interfaces><AllowMulticast>false</AllowMulticast>"
             "</General><Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>32"
             "</MaxAutoParticipantIndex><Peers><Peer address='127.0.0.1'/></Peers></Discovery>",
             1);
    participant_ = dds_create_participant(domain, nullptr, nullptr);
    if (participant_ < 0) throw std::runtime_error(dds_strretcode(-participant_));
  }
  ~Cyclone() { dds_delete(participant_); }
  Cyclone(const Cyclone&) = delete;
  Cyclone& operator=(const Cyclone&) = delete;

  dds_entity_t writer(const dds_topic_descriptor_t& type, const std::string& topic,
                      bool latched = false) const {
    return endpoint(dds_create_writer, type, topic, latched);
  }
  dds_entity_t reader(const dds_topic_descriptor_t& type, const std::string& topic,
                      bool latched = false) const {
    return endpoint(dds_create_reader, type, topic, latched);
  }
  dds_entity_t participant() const { return participant_; }
  /// As ROS 2's topics have it, and services.
  static dds_qos_t* qos(bool latched) {
    dds_qos_t* out = dds_create_qos();
    dds_qset_reliability(out, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
    dds_qset_durability(out, latched ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
    dds_qset_history(out, DDS_HISTORY_KEEP_LAST, 10);
    return out;
  }

 private:
  template <class Create>
  dds_entity_t endpoint(Create create, const dds_topic_descriptor_t& type, const std::string& topic,
                        bool latched) const {
    dds_qos_t* qos = Cyclone::qos(latched);
    const dds_entity_t made = dds_create_topic(participant_, &type, topic.c_str(), nullptr, nullptr);
    const dds_entity_t out = create(participant_, made, qos, nullptr);
    dds_delete_qos(qos);
    if (out < 0) throw std::runtime_error(dds_strretcode(-out));
    return out;
  }
  dds_entity_t participant_;
};

/// One sample where there is one; its memory is given back.
template <class T, class Use>
bool take(dds_entity_t reader, Use use) {
  void* samples[1] = {nullptr};
  dds_sample_info_t info[1];
  const dds_return_t count = dds_take(reader, samples, info, 1, 1);
  const bool valid = count == 1 && info[0].valid_data;
  if (valid) use(*static_cast<const T*>(samples[0]));
  if (count > 0) dds_return_loan(reader, samples, count);
  return valid;
}

/// A service as ROS 2's middleware on Cyclone DDS calls it: requests begin with who asks and the how manieth
/// time.
template <class Request, class Response>
class CycloneCaller {
 public:
  CycloneCaller(const Cyclone& cyclone, const std::string& service, const dds_topic_descriptor_t& request,
                const dds_topic_descriptor_t& response)
      : requests_{cyclone.writer(request, "rq" + service + "Request")},
        replies_{cyclone.reader(response, "rr" + service + "Reply")} {}
  bool ready() const {
    dds_publication_matched_status_t sent;
    dds_subscription_matched_status_t got;
    dds_get_publication_matched_status(requests_, &sent);
    dds_get_subscription_matched_status(replies_, &got);
    return sent.current_count > 0 && got.current_count > 0;
  }
  void ask(Request request) {
    request.guid = kMe;
    request.number = ++number_;
    dds_write(requests_, &request);
  }
  /// True once the answer to the latest request has been given to `use`.
  template <class Use>
  bool answered(Use use) {
    bool mine = false;
    take<Response>(replies_, [&](const Response& reply) {
      mine = reply.guid == kMe && reply.number == number_;
      if (mine) use(reply);
    });
    return mine;
  }

 private:
  static constexpr std::uint64_t kMe = 0x1122334455667788;
  dds_entity_t requests_, replies_;
  std::int64_t number_ = 0;
};

}  // namespace polyarm::ros2::test
