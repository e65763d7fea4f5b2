#include "polyarm/controllers/joint_state_broadcaster.hpp"

#include <algorithm>
#include <limits>

namespace polyarm::controllers {

namespace {
constexpr const char* kQuantities[] = {"position", "velocity", "effort"};
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
}  // namespace

CallbackReturn JointStateBroadcaster::on_configure(const ControllerContext& context) {
  joints_.clear();
  names_.clear();
  places_.clear();
  for (const std::string& joint : context.parameters.list("joints"))
    joints_.push_back(joint.find('/') == std::string::npos ? context.robot + "/" + joint : joint);
  if (joints_.empty())
    for (const JointFacts& joint : context.joints) joints_.push_back(joint.name);
  const std::vector<std::string> only = context.parameters.list("interfaces");
  for (const std::string& joint : joints_) {
    std::array<int, 3> place{-1, -1, -1};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::string name = joint + "/" + kQuantities[k];
      const bool asked = only.empty() || std::find(only.begin(), only.end(), kQuantities[k]) != only.end();
      if (!asked || std::find(available_.begin(), available_.end(), name) == available_.end()) continue;
      place[k] = static_cast<int>(names_.size());
      names_.push_back(name);
    }
    places_.push_back(place);
  }
  const std::vector<double> nothing(joints_.size(), kNone);
  outbox_.reset({0, nothing, nothing, nothing});
  return CallbackReturn::success;
}

ReturnType JointStateBroadcaster::update(const Cycle& cycle, const Verdict&) noexcept {
  JointStates& out = outbox_.draft();
  out.time = cycle.time;
  const auto value = [&](int place) { return place < 0 ? kNone : state(static_cast<std::size_t>(place)); };
  for (std::size_t j = 0; j < places_.size(); ++j) {
    out.position[j] = value(places_[j][0]);
    out.velocity[j] = value(places_[j][1]);
    out.effort[j] = value(places_[j][2]);
  }
  outbox_.publish();
  return ReturnType::ok;
}

}  // namespace polyarm::controllers
