#include "polyarm/requests/families.hpp"

#include "polyarm/protocol/reference.hpp"

namespace polyarm::cell {

namespace {

struct NoOwners {};

protocol::Help::Answer help(const NoOwners&, const protocol::Help&) {
  return protocol::help_rows();
}

}  // namespace

std::vector<Handler> room_handlers() {
  std::vector<Handler> out;
  for (const auto& family :
       {handlers<help>(),    controller_handlers(), motion_handlers(),  tag_handlers(),
        hardware_handlers(), health_handlers(),     message_handlers(), jog_handlers(),
        teleop_handlers(),   move_handlers(),       load_handlers(),    program_handlers(),
        record_handlers(),   point_handlers(),      frame_handlers(),   calibration_handlers(),
        preview_handlers(),  file_handlers(),       scene_handlers(),   connect_handlers()})
    out.insert(out.end(), family.begin(), family.end());
  return out;
}

}  // namespace polyarm::cell
