#include "polyarm/broadcasters/pose_broadcaster.hpp"

#include <algorithm>
#include <cmath>

#include "polyarm/broadcasters/sensor_interfaces.hpp"

namespace polyarm::controllers {

namespace {
constexpr double kOffUnit = 1e-3;

std::vector<std::string> fields(const std::string& prefix, const char* place, const char* turn) {
  std::vector<std::string> out;
  for (const char* axis : {"x", "y", "z"}) out.push_back(prefix + "." + place + "." + axis);
  for (const char* axis : {"x", "y", "z", "w"}) out.push_back(prefix + "." + turn + "." + axis);
  return out;
}
}  // namespace

CallbackReturn PoseBroadcaster::on_configure(ControllerContext& context) {
  Parameters& p = context.parameters;
  const FoundSensor sensor = read_sensor(context, std::span(kPoseInterfaces).first(3), "a pose", "pose_name");
  for (const char* interface : kPoseInterfaces) claim_state(sensor.whole + "/" + interface);
  const std::string frame = read_frame(p, sensor.name);
  output_ = &add_output("pose", "geometry_msgs/PoseStamped", fields("pose", "position", "orientation"));
  output_->texts["frame_id"] = frame;

  bool enabled = true;
  double rate = 0;
  std::string child = sensor.name;
  p.read("tf.enable", enabled, {"false: no transform is published"});
  p.read("tf.child_frame_id", child, {"child frame of the transform; default: the pose's name"});
  p.read("tf_publish_rate", rate, {"Hz of the transform; 0: with every update"});
  if (!(rate >= 0 && rate <= 1e6))
    p.problems().error("bad-value", place_of(p, "tf_publish_rate"), "tf_publish_rate is not a rate",
                       "write Hz, 0 for every update");
  tf_period_ = rate > 0 ? static_cast<Nanoseconds>(std::llround(1e9 / rate)) : 0;
  tf_ = nullptr;
  if (!enabled) return CallbackReturn::success;
  tf_ = &add_output("tf", "geometry_msgs/TransformStamped", fields("transform", "translation", "rotation"));
  tf_->texts["frame_id"] = frame;
  tf_->texts["child_frame_id"] = child.empty() ? sensor.name : child;
  return CallbackReturn::success;
}

CallbackReturn PoseBroadcaster::on_activate(const Cycle& cycle) noexcept {
  next_tf_ = cycle.time;
  return CallbackReturn::success;
}

void PoseBroadcaster::tell(Output& output, const Cycle& cycle) noexcept {
  std::copy(pose_.begin(), pose_.end(), output.draft().values.begin());
  output.publish(cycle.time);
}

ReturnType PoseBroadcaster::update(const Cycle& cycle, const Verdict&) noexcept {
  double sum = 0, square = 0;
  for (std::size_t i = 0; i < pose_.size(); ++i) {
    pose_[i] = state(i);
    sum += pose_[i];
    if (i > 2) square += pose_[i] * pose_[i];
  }
  if (!std::isfinite(sum) || std::abs(std::sqrt(square) - 1) > kOffUnit) return ReturnType::ok;
  tell(*output_, cycle);
  if (!tf_ || cycle.time < next_tf_) return ReturnType::ok;
  tell(*tf_, cycle);
  // In step with the rate; after a pause it begins anew.
  next_tf_ = std::max(next_tf_ + tf_period_, cycle.time);
  return ReturnType::ok;
}

}  // namespace polyarm::controllers
