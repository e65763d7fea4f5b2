#pragma once
/// A participant on the DDS wire that carries payloads which are written and read elsewhere: Fast DDS at its
/// RTPS layer, where a reply can be addressed to one reader. Nothing of ROS is known here but where its
/// middlewares differ in how services are told apart.
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace polyarm::ros2 {

/// Of an endpoint on the wire: prefix of the participant (12 bytes) and entity (4).
using Guid = std::array<std::uint8_t, 16>;
inline constexpr Guid kNoGuid{};
std::string text_of(const Guid& guid);

/// Whose implementation an endpoint is, by the first bytes of its guid (RTPS vendor ids).
enum class Vendor { fast_dds, cyclone, other };
Vendor vendor_of(const Guid& guid);

struct Qos {
  bool reliable = true;
  bool transient_local = false;
  std::size_t depth = 10;  ///< samples kept
};

struct ParticipantOptions {
  std::uint32_t domain = 0;
  bool loopback = true;   ///< no socket is bound to, and nothing sent from, another interface
  bool discovery = true;  ///< false: nobody is told of us, and we hear of nobody
  /// Addresses or names of machines that are told of us beside those that multicast reaches.
  std::vector<std::string> peers;
  std::string user_data = "enclave=/;";
};

/// One sample, and what its writer says of it.
struct Sample {
  std::span<const std::byte> payload;  ///< with its encapsulation; valid during the call
  Guid writer;
  std::int64_t sequence = 0;
  /// Of a request: the reader that waits for the reply, where it says so. Of a reply: who asked, and what.
  Guid related = kNoGuid;
  std::int64_t related_sequence = 0;
};
/// Called on threads of the participant; must not block.
using OnSample = std::function<void(const Sample&)>;

/// What a reply belongs to.
struct Related {
  Guid guid;
  std::int64_t sequence = 0;
};

/// An endpoint of somebody else that matches one of ours.
struct Remote {
  Guid guid;
  std::string user_data;
  std::chrono::steady_clock::time_point since;  ///< it has matched
};

/// Functions may be called from any thread but those of OnSample.
class Participant {
 public:
  using Id = std::size_t;

  /// Throws Error("no-dds") where the network cannot be had.
  explicit Participant(const ParticipantOptions& options);
  ~Participant();
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;

  /// Throw Error("no-dds"). `addressed`: samples carry Related, and readers of Fast DDS get only their own.
  Id add_writer(const std::string& topic, const std::string& type, const Qos& qos,
                const std::string& user_data, bool addressed = false);
  Id add_reader(const std::string& topic, const std::string& type, const Qos& qos,
                const std::string& user_data, OnSample on_sample);
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
