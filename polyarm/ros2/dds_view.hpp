#pragma once
/// What the cell's process knows of the one that speaks DDS: its own endpoints, and those of others that it
/// has been told of. Everything has a bound, whatever the other process says.
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "polyarm/ros2/dds_exchange.hpp"
#include "polyarm/ros2/dds_types.hpp"

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
    std::shared_ptr<OnSample> on_sample;  ///< null: a writer
    Guid guid = kNoGuid;
    bool answered = false;      ///< it was made, or could not be
    std::int64_t sequence = 0;  ///< of what was written last, as the other process counts
    std::map<Guid, Clock::time_point> matched;
    /// What a process that is started anew writes first, the oldest first.
    std::deque<std::vector<std::byte>> kept;

    /// Keeps it if it is latched.
    bool keep(std::span<const std::byte> payload);
    std::size_t kept_bytes = 0;
  };

  Id add(Endpoint endpoint);
  bool remove(Id id);
  Endpoint* find(Id id);
  std::map<Id, Endpoint>& endpoints() { return endpoints_; }
  /// The other process is gone, and what it knew.
  void forget();
  void set_prefix(const Guid& prefix);
  /// False where what it says is no message.
  bool take(DdsNews news, process::Unpacker& in);

  Guid prefix() const { return prefix_; }
  Guid guid(Id id) const;
  bool is_matched(Id id) const;
  std::vector<Remote> matched(Id id) const;
  std::string user_data(const Guid& endpoint) const;
  std::size_t known() const { return remotes_.size(); }
  /// Somebody else has a writer of this topic and type, as DDS calls them, whether it matches or not.
  bool is_offered(const std::string& topic, const std::string& type) const;
  /// All endpoints have been answered.
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
