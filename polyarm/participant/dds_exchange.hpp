#pragma once
/// The messages between the cell's process and polyarm_ros2_dds: one number for the kind, then its packed
/// fields. The cell's side checks every length that it receives, because a packet that exploits a bug in Fast
/// DDS may have taken control of the other side.
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "polyarm/participant/dds_types.hpp"
#include "polyarm/process/packing.hpp"

namespace polyarm::ros2 {

inline constexpr const char* kDdsProgram = "polyarm_ros2_dds";

/// Orders to polyarm_ros2_dds.
enum class DdsOrder : std::uint8_t {
  open,        ///< options; first order, once
  add_writer,  ///< id, topic, type, QoS, user data, addressed
  add_reader,  ///< id, topic, type, QoS, user data
  remove,      ///< id
  write,       ///< id, whether Related follows, Related, payload
  end
};
/// Messages from polyarm_ros2_dds.
enum class DdsReport : std::uint8_t {
  ready,      ///< prefix
  refused,    ///< what, advice; it cannot open DDS, and ends
  made,       ///< id, guid
  not_made,   ///< id, what
  matched,    ///< id, guid, whether they match now
  known,      ///< guid, user data; topic and type if it is a writer
  unknown,    ///< guid
  forgotten,  ///< guid
  sample,     ///< id, writer, sequence, Related, payload
  too_large,  ///< a received sample was too large
  unsent      ///< id; the last sample could not be written
};

/// Limits for names, user data and peers; more is cut off or refused.
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
