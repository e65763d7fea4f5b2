#include "polyarm/controllers/joint_state_broadcaster.hpp"

#include <algorithm>
#include <limits>

namespace polyarm::controllers {

namespace {
constexpr const char* kQuantities[] = {"position", "velocity", "effort"};
constexpr double kNoState = std::numeric_limits<double>::quiet_NaN();

/// "arm/elbow_joint" is told as "elbow_joint" where no other robot has one of that name.
std::string told_name(const ControllerContext& context, const std::string& whole) {
  const std::string name = whole.substr(whole.find('/') + 1);
  const auto same = std::count_if(context.joints.begin(), context.joints.end(), [&](const JointFacts& joint) {
    return joint.name.substr(joint.name.find('/') + 1) == name;
  });
  return same > 1 ? whole : name;
}
}  // namespace

void JointStateBroadcaster::add_joint(const ControllerContext& context, const std::string& whole) {
  joints_.push_back(told_name(context, whole));
  for (std::size_t k = 0; k < 3; ++k) {
    const std::string name = whole + "/" + renamed_[k];
    const bool asked =
        wanted_.empty() || std::find(wanted_.begin(), wanted_.end(), renamed_[k]) != wanted_.end();
    places_.push_back(asked && context.has_state(name) ? static_cast<int>(claim_state(name)) : -1);
    fixed_.push_back(kNoState);
  }
}

CallbackReturn JointStateBroadcaster::on_configure(ControllerContext& context) {
  std::vector<std::string> joints, extra;
  std::string frame = "base_link";
  bool local = false, filter = true;
  Parameters& p = context.parameters;
  p.read("joints", joints, {"the joints to tell; all where empty"});
  p.read("interfaces", wanted_, {"the state interfaces to tell; position, velocity and effort where empty"});
  p.read("extra_joints", extra, {"joints that no hardware has, told at rest at zero"});
  p.read("use_local_topics", local, {"tell them under the controller's own name instead of /joint_states"});
  p.read("use_urdf_to_filter", filter, {"tell only joints of the description, in its order"});
  p.read("frame_id", frame, {"frame of the messages"});
  for (std::size_t k = 0; k < 3; ++k)
    p.read(std::string("map_interface_to_joint_state.") + kQuantities[k], renamed_[k],
           {"the state interface that is told as this quantity"});
  p.superseded("publish_dynamic_joint_states", "dynamic_joint_states can always be watched");
  joints_.clear();
  places_.clear();
  fixed_.clear();
  for (const std::string& joint : joints) add_joint(context, context.whole_joint(joint));
  if (joints.empty())
    for (const JointFacts& joint : context.joints) add_joint(context, joint.name);
  for (const std::string& joint : extra) {
    joints_.push_back(joint);
    places_.insert(places_.end(), 3, -1);
    fixed_.insert(fixed_.end(), {0, 0, 0});
  }
  std::vector<std::string> fields;
  for (const std::string& joint : joints_)
    for (const char* quantity : kQuantities) fields.push_back(joint + "/" + quantity);
  joint_states_ = &add_output("joint_states", "sensor_msgs/JointState", std::move(fields));
  joint_states_->texts["frame_id"] = frame;
  dynamic_ = &add_output("dynamic_joint_states", "control_msgs/DynamicJointState", state_interfaces());
  return CallbackReturn::success;
}

ReturnType JointStateBroadcaster::update(const Cycle& cycle, const Verdict&) noexcept {
  std::vector<double>& out = joint_states_->draft().values;
  for (std::size_t k = 0; k < places_.size(); ++k)
    out[k] = places_[k] < 0 ? fixed_[k] : state(static_cast<std::size_t>(places_[k]));
  joint_states_->publish(cycle.time);
  if (!dynamic_->wanted()) return ReturnType::ok;
  std::vector<double>& all = dynamic_->draft().values;
  for (std::size_t k = 0; k < all.size(); ++k) all[k] = state(k);
  dynamic_->publish(cycle.time);
  return ReturnType::ok;
}

}  // namespace polyarm::controllers
