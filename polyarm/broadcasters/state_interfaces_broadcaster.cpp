#include "polyarm/broadcasters/state_interfaces_broadcaster.hpp"

#include "polyarm/base/text.hpp"
#include "polyarm/broadcasters/sensor_interfaces.hpp"

namespace polyarm::controllers {

CallbackReturn StateInterfacesBroadcaster::on_configure(ControllerContext& context) {
  Parameters& p = context.parameters;
  std::vector<std::string> names;
  p.read("interfaces", names, {"the states to publish: joint/interface, sensor/interface, …"});
  const Location where = place_of(p, "interfaces");
  if (names.empty())
    p.problems().error("bad-value", where, "it names no interfaces", "write interfaces: [joint/position, …]");
  places_.clear();
  for (const std::string& name : names) {
    const std::string whole = context.whole_name(name);
    if (context.has_state(whole))
      places_.push_back(claim_state(whole));
    else
      p.problems().error("unknown-interface", where,
                         "there is no state '" + name + "'" + did_you_mean(whole, context.state_names));
  }
  values_ = &add_output("values", "control_msgs/Float64Values", std::move(names));
  return CallbackReturn::success;
}

ReturnType StateInterfacesBroadcaster::update(const Cycle& cycle, const Verdict&) noexcept {
  std::vector<double>& out = values_->draft().values;
  for (std::size_t i = 0; i < places_.size(); ++i) out[i] = state(places_[i]);
  values_->publish(cycle.time);
  return ReturnType::ok;
}

}  // namespace polyarm::controllers
