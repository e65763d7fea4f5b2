#include "polyarm/broadcasters/joint_state_broadcaster.hpp"

#include <algorithm>
#include <limits>
#include <unordered_map>

namespace polyarm::controllers {

namespace {
constexpr const char* kQuantities[] = {"position", "velocity", "effort"};
constexpr double kNoState = std::numeric_limits<double>::quiet_NaN();

std::string short_name(const std::string& whole) {
  return whole.substr(whole.find('/') + 1);
}

/// How many joints have each short name.
std::unordered_map<std::string, int> count_short_names(const ControllerContext& context) {
  std::unordered_map<std::string, int> out;
  for (const JointFacts& joint : context.joints) ++out[short_name(joint.name)];
  return out;
}
}  // namespace

/// "arm/elbow_joint" is published as "elbow_joint" where no other robot has a joint of that name.
void JointStateBroadcaster::add_joint(const ControllerContext& context, const std::string& whole,
                                      bool is_only_one) {
  joints_.push_back(is_only_one ? short_name(whole) : whole);
  for (std::size_t k = 0; k < 3; ++k) {
    const std::string name = whole + "/" + renamed_[k];
    const bool asked =
        wanted_.empty() || std::find(wanted_.begin(), wanted_.end(), renamed_[k]) != wanted_.end();
    if (asked && context.has_state(name))
      measured_.push_back(
          {static_cast<std::uint32_t>(values_.size()), static_cast<std::uint32_t>(claim_state(name)), 0});
    values_.push_back(kNoState);
  }
}

CallbackReturn JointStateBroadcaster::on_configure(ControllerContext& context) {
  std::vector<std::string> joints, extra;
  std::string frame = "base_link";
  bool local = false, filter = true;
  Parameters& p = context.parameters;
  p.read("joints", joints, {"the joints to publish; empty: all"});
  p.read("interfaces", wanted_, {"the state interfaces to publish; empty: position, velocity and effort"});
  p.read("extra_joints", extra, {"joints that no hardware has; published at rest at zero"});
  p.read("use_local_topics", local,
         {"publish them under the controller's own name instead of /joint_states"});
  p.read("use_urdf_to_filter", filter, {"publish only joints of the description, in its order"});
  p.read("frame_id", frame, {"frame of the messages"});
  for (std::size_t k = 0; k < 3; ++k)
    p.read(std::string("map_interface_to_joint_state.") + kQuantities[k], renamed_[k],
           {"the state interface that is published as this quantity"});
  p.superseded("publish_dynamic_joint_states", "dynamic_joint_states can always be watched");
  joints_.clear();
  measured_.clear();
  values_.clear();
  const auto counts = count_short_names(context);
  const auto add = [&](const std::string& whole) {
    const auto same = counts.find(short_name(whole));
    add_joint(context, whole, same == counts.end() || same->second <= 1);
  };
  for (const std::string& joint : joints) add(context.whole_joint(joint));
  if (joints.empty())
    for (const JointFacts& joint : context.joints) add(joint.name);
  for (const std::string& joint : extra) {
    joints_.push_back(joint);
    values_.insert(values_.end(), {0, 0, 0});
  }
  std::vector<std::string> fields;
  for (const std::string& joint : joints_)
    for (const char* quantity : kQuantities) fields.push_back(joint + "/" + quantity);
  joint_states_ = &add_output("joint_states", "sensor_msgs/JointState", std::move(fields));
  joint_states_->texts["frame_id"] = frame;
  joint_states_->begin_with(values_);
  dynamic_ = &add_output("dynamic_joint_states", "control_msgs/DynamicJointState", state_interfaces());
  return CallbackReturn::success;
}

CallbackReturn JointStateBroadcaster::on_activate(const Cycle&) noexcept {
  for (Measured& one : measured_) one.state = static_cast<std::uint32_t>(bindings().state[one.claimed]);
  return CallbackReturn::success;
}

ReturnType JointStateBroadcaster::update(const Cycle& cycle, const Verdict&) noexcept {
  double* out = joint_states_->draft().values.data();
  const double* states = bindings().states.data();
  for (const Measured& one : measured_) out[one.field] = states[one.state];
  joint_states_->publish(cycle.time);
  if (!dynamic_->wanted()) return ReturnType::ok;
  std::vector<double>& all = dynamic_->draft().values;
  for (std::size_t k = 0; k < all.size(); ++k) all[k] = state(k);
  dynamic_->publish(cycle.time);
  return ReturnType::ok;
}

}  // namespace polyarm::controllers
