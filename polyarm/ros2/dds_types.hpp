#pragma once
/// What the cell's process and the one that speaks DDS call the same: endpoints, samples, and how a domain is
/// joined. Nothing here is of Fast DDS.
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
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
  /// transient_local: its owner writes it again after the process that speaks DDS was started anew; else the
  /// samples kept are.
  bool renewed_by_owner = false;
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

/// What a writer of somebody else writes, as DDS calls it ("rt/cmd_vel"); empty: it is a reader.
struct Offer {
  std::string topic, type;
};

/// An endpoint of somebody else that matches one of ours.
struct Remote {
  Guid guid;
  std::string user_data;
  std::chrono::steady_clock::time_point since;  ///< it has matched
};

}  // namespace polyarm::ros2
