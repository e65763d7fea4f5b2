#pragma once
/// A participant on the DDS wire that carries payloads which are written and read elsewhere: Fast DDS at its
/// RTPS layer, where a reply can be addressed to one reader. Nothing of ROS is known here but where its
/// middlewares differ in how services are told apart. No cell's process has one: it lives in
/// polyarm_ros2_dds, and RemoteParticipant stands for it.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "polyarm/ros2/dds_types.hpp"

namespace polyarm::ros2 {

/// Told what a participant sees of others. On its threads; must not block.
class ParticipantObserver {
 public:
  virtual ~ParticipantObserver() = default;
  /// An endpoint of ours matches one of others, or does no longer.
  virtual void on_match(std::size_t id, const Guid& other, bool matches) = 0;
  virtual void on_known(const Guid& endpoint, const std::string& user_data, const Offer& offer) = 0;
  virtual void on_unknown(const Guid& endpoint) = 0;
  /// All endpoints whose guids have its prefix are unknown.
  virtual void on_forgotten(const Guid& participant) = 0;
};

/// Functions may be called from any thread but those of OnSample.
class Participant {
 public:
  using Id = std::size_t;

  /// Throws Error("no-dds") where the network cannot be had.
  explicit Participant(const ParticipantOptions& options, ParticipantObserver* observer = nullptr);
  ~Participant();
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;

  /// Throw Error("no-dds"). `addressed`: samples carry Related, and readers of Fast DDS get only their own.
  /// `id`: what it is called, which no other endpoint is; 0: any.
  Id add_writer(const std::string& topic, const std::string& type, const Qos& qos,
                const std::string& user_data, bool addressed = false, Id id = 0);
  Id add_reader(const std::string& topic, const std::string& type, const Qos& qos,
                const std::string& user_data, OnSample on_sample, Id id = 0);
  /// Ends the endpoint; no OnSample of it is under way any more when this returns.
  void remove(Id id);

  /// Its sequence number, from 1; 0 where the sample could not be taken (too large, no memory).
  std::int64_t write(Id writer, std::span<const std::byte> payload,
                     const std::optional<Related>& related = {});

  Guid guid(Id id) const;
  Guid prefix() const;
  /// Endpoints of others that match this one now.
  std::vector<Remote> matched(Id id) const;
  /// What the writer of a sample says of itself, "" where it is not known.
  std::string user_data_of_writer(const Guid& writer) const;
  /// How many endpoints of others are known, whether they match or not.
  std::size_t known() const;

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

}  // namespace polyarm::ros2
