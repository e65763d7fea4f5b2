#pragma once
/// Bytes through Cyclone DDS, whatever their type, as ROS 2's middleware on it sends and takes them: samples
/// are payloads with their encapsulation, and the requests and replies of a service begin with who asks and
/// the how manieth time.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpedantic"
#pragma GCC diagnostic ignored "-Wold-style-cast"
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wsign-conversion"
#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsi/ddsi_sertype.h>
#include <dds/ddsi/q_radmin.h>
#pragma GCC diagnostic pop

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/ros2/cyclone.hpp"

namespace polyarm::ros2::test {

using Payload = std::vector<std::byte>;

/// A sample as Cyclone keeps it: nothing but its bytes.
struct RawSample : ddsi_serdata {
  RawSample(const ddsi_sertype* of, ddsi_serdata_kind what) { ddsi_serdata_init(this, of, what); }
  Payload bytes;
};

struct RawOperations {
  static RawSample& raw(ddsi_serdata* data) { return *static_cast<RawSample*>(data); }
  static const RawSample& raw(const ddsi_serdata* data) { return *static_cast<const RawSample*>(data); }
  /// To four bytes, as the protocol has them.
  static std::uint32_t size(const ddsi_serdata* data) {
    return static_cast<std::uint32_t>(raw(data).bytes.size());
  }
  static ddsi_serdata* from_network(const ddsi_sertype* type, ddsi_serdata_kind kind,
                                    const nn_rdata* fragment, size_t bytes) {
    auto* out = new RawSample(type, kind);
    out->bytes.resize(bytes);
    std::uint32_t at = 0;
    for (; fragment; fragment = fragment->nextfrag) {
      if (fragment->maxp1 <= at) continue;
      const auto* begin = reinterpret_cast<const std::byte*>(
          NN_RMSG_PAYLOADOFF(fragment->rmsg, NN_RDATA_PAYLOAD_OFF(fragment)));
      std::memcpy(out->bytes.data() + at, begin + (at - fragment->min), fragment->maxp1 - at);
      at = fragment->maxp1;
    }
    return out;
  }
  static ddsi_serdata* from_pieces(const ddsi_sertype* type, ddsi_serdata_kind kind, ddsrt_msg_iovlen_t count,
                                   const ddsrt_iovec_t* pieces, size_t) {
    auto* out = new RawSample(type, kind);
    for (ddsrt_msg_iovlen_t i = 0; i < count; ++i) {
      const auto* begin = static_cast<const std::byte*>(pieces[i].iov_base);
      out->bytes.insert(out->bytes.end(), begin, begin + pieces[i].iov_len);
    }
    return out;
  }
  static ddsi_serdata* from_key(const ddsi_sertype* type, const ddsi_keyhash*) {
    return new RawSample(type, SDK_KEY);
  }
  static ddsi_serdata* from_bytes(const ddsi_sertype* type, ddsi_serdata_kind kind, const void* payload) {
    auto* out = new RawSample(type, kind);
    if (kind == SDK_DATA) out->bytes = *static_cast<const Payload*>(payload);
    while (out->bytes.size() % 4 != 0) out->bytes.push_back(std::byte{0});
    return out;
  }
  static void copy(const ddsi_serdata* data, size_t offset, size_t count, void* to) {
    std::memcpy(to, raw(data).bytes.data() + offset, std::min(count, raw(data).bytes.size() - offset));
  }
  static ddsi_serdata* lend(const ddsi_serdata* data, size_t offset, size_t count, ddsrt_iovec_t* to) {
    to->iov_base = const_cast<std::byte*>(raw(data).bytes.data()) + offset;
    to->iov_len = count;
    return ddsi_serdata_ref(data);
  }
  static void give_back(ddsi_serdata* data, const ddsrt_iovec_t*) { ddsi_serdata_unref(data); }
  static bool to_bytes(const ddsi_serdata* data, void* payload, void**, void*) {
    *static_cast<Payload*>(payload) = raw(data).bytes;
    return true;
  }
  static ddsi_serdata* without_type(const ddsi_serdata* data) {
    auto* out = new RawSample(data->type, SDK_KEY);
    out->type = nullptr;
    return out;
  }
  static bool from_nothing(const ddsi_sertype*, const ddsi_serdata*, void*, void**, void*) { return true; }
  static void end(ddsi_serdata* data) { delete static_cast<RawSample*>(data); }
  static size_t print(const ddsi_sertype*, const ddsi_serdata*, char* text, size_t room) {
    if (room > 0) text[0] = 0;
    return 0;
  }
  static void key(const ddsi_serdata*, ddsi_keyhash* to, bool) { std::memset(to, 0, sizeof *to); }
  static bool same_key(const ddsi_serdata*, const ddsi_serdata*) { return true; }

  static const ddsi_serdata_ops* samples() {
    static const ddsi_serdata_ops out = [] {
      ddsi_serdata_ops o{};
      o.eqkey = same_key;
      o.get_size = size;
      o.from_ser = from_network;
      o.from_ser_iov = from_pieces;
      o.from_keyhash = from_key;
      o.from_sample = from_bytes;
      o.to_ser = copy;
      o.to_ser_ref = lend;
      o.to_ser_unref = give_back;
      o.to_sample = to_bytes;
      o.to_untyped = without_type;
      o.untyped_to_sample = from_nothing;
      o.free = end;
      o.print = print;
      o.get_keyhash = key;
      return o;
    }();
    return &out;
  }
  static const ddsi_sertype_ops* types() {
    static const ddsi_sertype_ops out = [] {
      ddsi_sertype_ops o{};
      o.version = ddsi_sertype_v0;
      o.free = [](ddsi_sertype* type) {
        ddsi_sertype_fini(type);
        delete type;
      };
      o.zero_samples = [](const ddsi_sertype*, void*, size_t) {};
      o.realloc_samples = [](void**, const ddsi_sertype*, void*, size_t, size_t) {};
      o.free_samples = [](const ddsi_sertype*, void**, size_t, dds_free_op_t) {};
      o.equal = [](const ddsi_sertype*, const ddsi_sertype*) { return true; };
      o.hash = [](const ddsi_sertype*) { return 0u; };
      return o;
    }();
    return &out;
  }
};

/// A participant whose topics carry bytes.
class RawCyclone {
 public:
  explicit RawCyclone(std::uint32_t domain) : cyclone_{domain} {}

  dds_entity_t writer(const std::string& topic, const std::string& type, const std::string& user_data = {}) {
    return endpoint(dds_create_writer, topic, type, false, user_data);
  }
  dds_entity_t reader(const std::string& topic, const std::string& type, bool latched = false,
                      const std::string& user_data = {}) {
    return endpoint(dds_create_reader, topic, type, latched, user_data);
  }
  static std::optional<Payload> take(dds_entity_t reader) {
    Payload out;
    void* samples[1] = {&out};
    dds_sample_info_t info[1];
    if (dds_take(reader, samples, info, 1, 1) != 1 || !info[0].valid_data) return std::nullopt;
    return out;
  }
  const Cyclone& cyclone() const { return cyclone_; }

  /// A client of one service.
  class Caller {
   public:
    Caller(RawCyclone& cyclone, const std::string& service, const std::string& request,
           const std::string& response)
        : requests_{cyclone.writer("rq" + service + "Request", request, client_id(service))},
          replies_{cyclone.reader("rr" + service + "Reply", response, false, client_id(service))} {}
    bool ready() const {
      dds_publication_matched_status_t sent;
      dds_subscription_matched_status_t got;
      dds_get_publication_matched_status(requests_, &sent);
      dds_get_subscription_matched_status(replies_, &got);
      return sent.current_count > 0 && got.current_count > 0;
    }
    void ask(Payload request) {
      ++number_;
      const auto header = this->header();
      request.insert(request.begin() + 4, header.begin(), header.end());
      dds_write(requests_, &request);
    }
    std::optional<Payload> answer() {
      const auto header = this->header();
      while (auto reply = take(replies_))
        if (reply->size() >= 20 && std::equal(header.begin(), header.end(), reply->begin() + 4)) {
          reply->erase(reply->begin() + 4, reply->begin() + 20);
          return reply;
        }
      return std::nullopt;
    }

   private:
    /// What its writer and reader have in common, and nobody else: 16 bytes.
    static std::string client_id(const std::string& service) {
      std::string out = "clientid=";
      std::size_t hash = std::hash<std::string>{}(service);
      for (int i = 0; i < 16; ++i, hash = hash * 31 + 7)
        out += std::string(i > 0 ? "." : "") + "0123456789abcdef"[hash >> 4 & 15] +
               "0123456789abcdef"[hash & 15];
      return out + ";";
    }
    std::array<std::byte, 16> header() const {
      std::array<std::byte, 16> out;
      std::memcpy(out.data(), &kMe, 8);
      std::memcpy(out.data() + 8, &number_, 8);
      return out;
    }
    static constexpr std::uint64_t kMe = 0x8877665544332211;
    dds_entity_t requests_, replies_;
    std::int64_t number_ = 0;
  };

 private:
  template <class Create>
  dds_entity_t endpoint(Create create, const std::string& topic, const std::string& type, bool latched,
                        const std::string& user_data) {
    auto* raw = new ddsi_sertype;
    ddsi_sertype_init(raw, type.c_str(), RawOperations::types(), RawOperations::samples(), true);
    raw->allowed_data_representation = DDS_DATA_REPRESENTATION_FLAG_XCDR1;
    const dds_entity_t made =
        dds_create_topic_sertype(cyclone_.participant(), topic.c_str(), &raw, nullptr, nullptr, nullptr);
    if (made < 0) throw std::runtime_error(topic + ": " + dds_strretcode(-made));
    dds_qos_t* qos = Cyclone::qos(latched);
    if (!user_data.empty()) dds_qset_userdata(qos, user_data.data(), user_data.size());
    const dds_entity_t out = create(cyclone_.participant(), made, qos, nullptr);
    dds_delete_qos(qos);
    if (out < 0) throw std::runtime_error(topic + ": " + dds_strretcode(-out));
    return out;
  }
  Cyclone cyclone_;
};

}  // namespace polyarm::ros2::test
