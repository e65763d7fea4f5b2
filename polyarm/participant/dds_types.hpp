#pragma once
/// Types shared by the cell's process and polyarm_ros2_dds: endpoints, samples, and options to join a domain.
/// Does not use Fast DDS.
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace polyarm::ros2 {

/// Guid of an endpoint: prefix of the participant (12 bytes) and entity id (4).
using Guid = std::array<std::uint8_t, 16>;
inline constexpr Guid kNoGuid{};
std::string text_of(const Guid& guid);

/// The DDS implementation of an endpoint, from the first bytes of its guid (RTPS vendor ids).
enum class Vendor { fast_dds, cyclone, other };
Vendor vendor_of(const Guid& guid);

struct Qos {
  bool reliable = true;
  bool transient_local = false;
  std::size_t depth = 10;  ///< samples to keep
  /// For transient_local: true if the owner writes its sample again after polyarm_ros2_dds was restarted. If
  /// false, the kept samples are written again.
  bool renewed_by_owner = false;
};

struct ParticipantOptions {
  std::uint32_t domain = 0;
  bool loopback = true;   ///< binds to and sends from the loopback interface only
  bool discovery = true;  ///< false: no discovery in either direction
  /// Addresses or host names of machines to announce to, in addition to multicast.
  std::vector<std::string> peers;
  std::string user_data = "enclave=/;";
};

/// One received sample.
struct Sample {
  std::span<const std::byte> payload;  ///< includes the encapsulation header; valid during the call
  Guid writer;
  std::int64_t sequence = 0;
  /// Of a request: the reader that waits for the reply, if stated. Of a reply: the guid and sequence number
  /// of the request.
  Guid related = kNoGuid;
  std::int64_t related_sequence = 0;
};
/// Called on threads of the participant. Must not block.
using OnSample = std::function<void(const Sample&)>;

/// The request to which a reply belongs.
struct Related {
  Guid guid;
  std::int64_t sequence = 0;
};

/// Topic and type of another participant's writer, with their DDS names ("rt/cmd_vel"). Empty: it is a
/// reader.
struct Offer {
  std::string topic, type;
};

/// An endpoint of another participant that matches one of ours.
struct Remote {
  Guid guid;
  std::string user_data;
  std::chrono::steady_clock::time_point since;  ///< when it matched
};

}  // namespace polyarm::ros2
