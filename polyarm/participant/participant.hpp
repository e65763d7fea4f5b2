#pragma once
/// A DDS participant that sends and receives serialized payloads. It uses Fast DDS at the RTPS layer, where a
/// reply can be addressed to one reader. The only ROS knowledge here is how the middlewares tell services
/// apart. It lives in the process polyarm_ros2_dds only; the cell's process uses RemoteParticipant instead.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "polyarm/participant/dds_types.hpp"

namespace polyarm::ros2 {

/// Receives events about other participants. Called on the participant's threads. Must not block.
class ParticipantObserver {
 public:
  virtual ~ParticipantObserver() = default;
  /// An endpoint of ours now matches another one, or no longer does.
  virtual void on_match(std::size_t id, const Guid& other, bool matches) = 0;
  virtual void on_known(const Guid& endpoint, const std::string& user_data, const Offer& offer) = 0;
  virtual void on_unknown(const Guid& endpoint) = 0;
  /// All endpoints with this participant's prefix are gone.
  virtual void on_forgotten(const Guid& participant) = 0;
};

/// Functions may be called from any thread except inside an OnSample callback.
class Participant {
 public:
  using Id = std::size_t;

  /// Throws Error("no-dds") if the network cannot be used.
  explicit Participant(const ParticipantOptions& options, ParticipantObserver* observer = nullptr);
  ~Participant();
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;

  /// Both throw Error("no-dds"). `addressed`: samples carry Related, and readers of Fast DDS get only their
  /// own. `id`: a unique id for the endpoint; 0: any.
  Id add_writer(const std::string& topic, const std::string& type, const Qos& qos,
                const std::string& user_data, bool addressed = false, Id id = 0);
  Id add_reader(const std::string& topic, const std::string& type, const Qos& qos,
                const std::string& user_data, OnSample on_sample, Id id = 0);
  /// Ends the endpoint. No OnSample call of it is running when this returns.
  void remove(Id id);

  /// Returns the sequence number, from 1; 0 if the sample could not be taken (too large, no memory).
  std::int64_t write(Id writer, std::span<const std::byte> payload,
                     const std::optional<Related>& related = {});

  Guid guid(Id id) const;
  Guid prefix() const;
  /// Endpoints of other participants that match this one now.
  std::vector<Remote> matched(Id id) const;
  /// User data of a writer; "" if unknown.
  std::string user_data_of_writer(const Guid& writer) const;
  /// Count of known endpoints of other participants, matched or not.
  std::size_t known() const;

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

}  // namespace polyarm::ros2
