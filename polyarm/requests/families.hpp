#pragma once
/// The request handlers of a running cell, grouped by subject; one file per group.
#include <vector>

#include "polyarm/inside/requests_work.hpp"

namespace polyarm::cell {

/// All handlers of this room.
std::vector<Handler> room_handlers();

std::vector<Handler> controller_handlers();
std::vector<Handler> motion_handlers();
std::vector<Handler> tag_handlers();
std::vector<Handler> hardware_handlers();
std::vector<Handler> health_handlers();
std::vector<Handler> message_handlers();
std::vector<Handler> jog_handlers();
std::vector<Handler> teleop_handlers();
std::vector<Handler> move_handlers();
std::vector<Handler> load_handlers();
std::vector<Handler> program_handlers();
std::vector<Handler> record_handlers();
std::vector<Handler> point_handlers();
std::vector<Handler> frame_handlers();
std::vector<Handler> calibration_handlers();
std::vector<Handler> preview_handlers();
std::vector<Handler> file_handlers();
std::vector<Handler> scene_handlers();
std::vector<Handler> connect_handlers();

}  // namespace polyarm::cell
