#pragma once
/// The cell's view of DDS: its own endpoints, and other endpoints that polyarm_ros2_dds has reported.
/// Everything is bounded, whatever that process sends.
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "polyarm/participant/dds_exchange.hpp"
#include "polyarm/participant/dds_types.hpp"

namespace polyarm::ros2 {

class DdsView {
 public:
  using Id = std::size_t;
  using Clock = std::chrono::steady_clock;

  struct Endpoint {
    std::string topic, type;
    Qos qos;
    std::string user_data;
    bool addressed = false;
    std::shared_ptr<OnSample> on_sample;  ///< null: it is a writer
    Guid guid = kNoGuid;
    bool answered = false;      ///< the other process has made it, or could not
    std::int64_t sequence = 0;  ///< of the last sample written, as counted by the other process
    std::map<Guid, Clock::time_point> matched;
    /// Latched samples, oldest first, that are written again to a restarted process.
    std::deque<std::vector<std::byte>> kept;

    /// Keeps the payload if the endpoint is latched. Returns true if kept.
    bool keep(std::span<const std::byte> payload);
    std::size_t kept_bytes = 0;
  };

  Id add(Endpoint endpoint);
  bool remove(Id id);
  Endpoint* find(Id id);
  std::map<Id, Endpoint>& endpoints() { return endpoints_; }
  /// Clears all that came from the other process, which has ended.
  void forget();
  void set_prefix(const Guid& prefix);
  /// Handles a message. Returns false if it is malformed.
  bool take(DdsReport news, process::Unpacker& in);

  Guid prefix() const { return prefix_; }
  Guid guid(Id id) const;
  bool is_matched(Id id) const;
  std::vector<Remote> matched(Id id) const;
  std::string user_data(const Guid& endpoint) const;
  std::size_t known() const { return remotes_.size(); }
  /// True if another participant has a writer of this topic and type (DDS names), matched or not.
  bool is_offered(const std::string& topic, const std::string& type) const;
  /// True if the other process has answered for all endpoints.
  bool settled() const { return unanswered_ == 0 && prefix_ != kNoGuid; }
  std::uint64_t identities() const { return identities_; }

 private:
  struct Known {
    std::string user_data;
    Offer offer;
  };
  const Endpoint* find(Id id) const { return const_cast<DdsView*>(this)->find(id); }
  void answer(Id id, const Guid& guid);
  void match(Id id, const Guid& other, bool matches);
  void know(const Guid& other, Known known);

  std::map<Id, Endpoint> endpoints_;
  std::map<Guid, Known> remotes_;
  Id last_id_ = 0;
  Guid prefix_ = kNoGuid;
  std::uint64_t identities_ = 0;
  std::size_t unanswered_ = 0, matches_ = 0;
};

}  // namespace polyarm::ros2
