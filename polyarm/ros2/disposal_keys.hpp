#pragma once
/// Makes Fast DDS understand how other middlewares say that an endpoint or a participant has left.
///
/// Discovery announces a departure with a DATA submessage that holds only the key (RTPS 2.3, OMG
/// formal/2019-04-03, 8.7.2.2 and 9.4.5.3). Cyclone DDS writes that key as a parameter list: the GUID in
/// PID_ENDPOINT_GUID or PID_PARTICIPANT_GUID. Fast DDS takes a key of at most 16 bytes and ignores any other
/// (up to 3.6 at least), so a departure was noticed only when the lease of the participant ended, and that of
/// an endpoint whose participant stayed was never noticed. Here such a key becomes its 16 bytes.
#include <cstdint>
#include <span>
#include <vector>

namespace polyarm::ros2 {

/// Looks through the submessages of one RTPS message. Where a key of discovery is a parameter list, `out`
/// becomes the message with plain keys, and the result is true. Else false, and `out` is left as it is.
/// Reads within `message` only, in one pass, whatever it holds. Any thread.
bool with_plain_keys(std::span<const std::uint8_t> message, std::vector<std::uint8_t>& out);

}  // namespace polyarm::ros2
