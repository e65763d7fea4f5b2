/// The ROS 2 door, which `ros2:` in a cell or --ros2 opens.
#include <vector>

#include "polyarm/ros2/cell_door.hpp"
#include "polyarm/ros2/options.hpp"
#include "polyarm/setup/door.hpp"

namespace polyarm::ros2 {

namespace {

/// Limit of messages handled in one call.
constexpr std::size_t kMost = 32;

class Ros2Door : public cell::Door {
 public:
  Ros2Door(cell::CellView& cell, const cell::DoorOptions& options)
      : options_{participant_options(options)},
        bridge_{cell, options_, distribution_of(options), option_of(options, "namespace"),
                twists_of(options)} {
    bridge_.check_clock();
    for (auto make :
         {make_robot_node, make_manager_node, make_controller_nodes, make_cell_node, make_plugin_nodes})
      parts_.push_back(make(bridge_));
    if (has_move_group(options)) parts_.push_back(make_move_groups(bridge_));
  }

  void serve() override {
    bridge_.check_clock();
    send_reports();
    take();
    for (const auto& part : parts_) bridge_.guarded([&] { part->serve(); });
  }

  void take() override {
    for (std::size_t i = 0; i < kMost && one(); ++i) {
    }
  }

  void set_wakeup(const std::shared_ptr<realtime::Bell>& bell) override { bridge_.wire().set_wakeup(bell); }

  /// Reports when the process that speaks DDS was lost or is back. The cell keeps running.
  void send_reports() {
    for (RemoteReport& news : bridge_.wire().take_reports()) {
      if (news.good)
        bridge_.cell().tell(news.what);
      else
        bridge_.cell().observer().on_problem(
            bridge_.cell().now(), {"dds-process", {}, news.what, std::move(news.advice), Severity::warning});
    }
  }

  /// Handles one message. Returns false if there was none.
  bool one() {
    bool more = true;
    bridge_.guarded([&] { more = bridge_.wire().take(1) > 0; });
    return more;
  }

  std::string address() const override {
    return "ROS 2: domain " + std::to_string(options_.domain) +
           (!options_.discovery ? ", not discoverable"
            : options_.loopback ? ", this machine alone"
                                : ", reachable from other machines");
  }

 private:
  ParticipantOptions options_;
  Bridge bridge_;
  std::vector<std::unique_ptr<Part>> parts_;
};

std::unique_ptr<cell::Door> make(cell::CellView& cell, const cell::DoorOptions& options) {
  return std::make_unique<Ros2Door>(cell, options);
}

}  // namespace

}  // namespace polyarm::ros2

POLYARM_DOOR(polyarm::ros2::make)
