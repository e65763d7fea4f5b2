#pragma once
/// The list of all requests, by family. Private to the room.
#include <vector>

#include "polyarm/protocol/request.hpp"

namespace polyarm::protocol {

using Family = const std::vector<const RequestType*>&();
Family help_requests, controller_requests, motion_requests, tag_requests, hardware_requests, message_requests,
    jog_requests, program_requests, point_requests, calibration_requests, project_requests, session_requests;

struct FamilyOfRequests {
  const char* title;  ///< heading in the reference
  Family* requests;
};

inline constexpr FamilyOfRequests kFamilies[] = {
    {"Help", help_requests},
    {"Controllers", controller_requests},
    {"Stop, hold and resume", motion_requests},
    {"Tags", tag_requests},
    {"Hardware and the control loop", hardware_requests},
    {"Messages and parameters", message_requests},
    {"Jog and move", jog_requests},
    {"Programs and events", program_requests},
    {"Points and variables", point_requests},
    {"Calibration", calibration_requests},
    {"Files, cells and recordings", project_requests},
    {"Clients of the pendant's port", session_requests},
};

/// The events of the pendant's port that have structs.
const std::vector<const Type*>& event_types();

}  // namespace polyarm::protocol
