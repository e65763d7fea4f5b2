#pragma once
#include <array>

#include "polyarm/controllers/controller.hpp"

namespace polyarm::controllers {

/// Tells where a sensor says that something is (the TCP of an arm that knows it, a tracked body), as
/// ros2_control's PoseBroadcaster does: outputs `pose` (geometry_msgs/PoseStamped, m, in frame_id) and,
/// unless `tf.enable` is false, `tf` from frame_id to `tf.child_frame_id`, at `tf_publish_rate` Hz at most. A
/// pose that is not finite, or whose quaternion is no rotation (norm off by more than 1e-3), is not told.
class PoseBroadcaster : public Controller {
 public:
  CallbackReturn on_configure(ControllerContext& context) override;
  CallbackReturn on_activate(const Cycle& cycle) noexcept override;
  ReturnType update(const Cycle& cycle, const Verdict& verdict) noexcept override;

 private:
  void tell(Output& output, const Cycle& cycle) noexcept;

  std::array<double, 7> pose_{};  // x y z, then the quaternion x y z w
  Nanoseconds tf_period_ = 0, next_tf_ = 0;
  Output* output_ = nullptr;
  Output* tf_ = nullptr;  // null: not told
};

}  // namespace polyarm::controllers
