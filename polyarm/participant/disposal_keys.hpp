#pragma once
/// Lets Fast DDS understand how other middlewares announce that an endpoint or a participant has left.
///
/// Discovery announces a departure with a DATA submessage that holds only the key (RTPS 2.3, OMG
/// formal/2019-04-03, 8.7.2.2 and 9.4.5.3). Cyclone DDS writes that key as a parameter list: the GUID in
/// PID_ENDPOINT_GUID or PID_PARTICIPANT_GUID. Fast DDS accepts a key of at most 16 bytes and ignores any
/// other (up to 3.6 at least). So it noticed that a participant had left only when the lease ended, and never
/// noticed that a single endpoint had left. Here such a key is converted to its 16 bytes.
#include <cstdint>
#include <span>
#include <vector>

namespace polyarm::ros2 {

/// Converts one RTPS message. If a discovery key is a parameter list, writes the message with plain keys to
/// `out` and returns true. Else returns false and leaves `out` unchanged. One pass; reads only within
/// `message`, whatever it contains. Any thread.
bool with_plain_keys(std::span<const std::uint8_t> message, std::vector<std::uint8_t>& out);

}  // namespace polyarm::ros2
