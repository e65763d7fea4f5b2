#pragma once
/// What the cell's process and polyarm_ros2_dds tell each other: a number, and what follows it, packed. The
/// cell's side looks at every length that it is told: whoever sends a packet that Fast DDS does not bear may
/// have taken the other side over.
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "polyarm/process/packing.hpp"
#include "polyarm/ros2/dds_types.hpp"

namespace polyarm::ros2 {

inline constexpr const char* kDdsProgram = "polyarm_ros2_dds";

/// To the process that speaks DDS.
enum class DdsOrder : std::uint8_t {
  open,        ///< options; first, once
  add_writer,  ///< id, topic, type, QoS, user data, addressed
  add_reader,  ///< id, topic, type, QoS, user data
  remove,      ///< id
  write,       ///< id, whether it has Related, Related, payload
  end
};
/// From it.
enum class DdsNews : std::uint8_t {
  ready,      ///< prefix
  refused,    ///< what, advice: it cannot open, and ends
  made,       ///< id, guid
  not_made,   ///< id, what
  matched,    ///< id, guid, whether it matches
  known,      ///< guid, user data, topic and type where it is a writer
  unknown,    ///< guid
  forgotten,  ///< guid
  sample,     ///< id, writer, sequence, Related, payload
  too_large,  ///< a sample that was
  unsent      ///< id; what was written last could not be
};

/// Of names, types and what is said of endpoints; the rest is cut off or refused.
inline constexpr std::size_t kMostName = 1024, kMostUserData = 8192, kMostPeers = 64;

inline void pack(process::Packer& out, const ParticipantOptions& options) {
  out.number(options.domain).number(options.loopback).number(options.discovery).text(options.user_data);
  out.number(static_cast<std::uint32_t>(options.peers.size()));
  for (const std::string& peer : options.peers) out.text(peer);
}
inline ParticipantOptions unpack_options(process::Unpacker& in) {
  ParticipantOptions out;
  out.domain = in.number<std::uint32_t>();
  out.loopback = in.truth();
  out.discovery = in.truth();
  out.user_data = in.text(kMostUserData);
  for (auto peers = in.number<std::uint32_t>(); peers > 0 && in.good(); --peers)
    out.peers.push_back(in.text(kMostName));
  return out;
}
inline void pack(process::Packer& out, const Qos& qos) {
  out.number(qos.reliable).number(qos.transient_local).number(static_cast<std::uint64_t>(qos.depth));
}
inline Qos unpack_qos(process::Unpacker& in) {
  Qos out;
  out.reliable = in.truth();
  out.transient_local = in.truth();
  out.depth = in.number<std::uint64_t>();
  return out;
}

}  // namespace polyarm::ros2
