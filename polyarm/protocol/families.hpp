#pragma once
/// The list of all requests, by family. Private to the room.
#include <vector>

#include "polyarm/protocol/request.hpp"

namespace polyarm::protocol {

using Family = const std::vector<const RequestType*>&();
Family help_requests, controller_requests, motion_requests, tag_requests, hardware_requests, message_requests,
    jog_requests, program_requests, point_requests, project_requests, session_requests;

inline constexpr Family* kFamilies[] = {help_requests,    controller_requests, motion_requests,
                                        tag_requests,     hardware_requests,   message_requests,
                                        jog_requests,     program_requests,    point_requests,
                                        project_requests, session_requests};

/// The events of the pendant's port that have structs.
const std::vector<const Type*>& event_types();

}  // namespace polyarm::protocol
