#include "polyarm/broadcasters/range_sensor_broadcaster.hpp"

#include <algorithm>

#include "polyarm/broadcasters/sensor_interfaces.hpp"

namespace polyarm::controllers {

CallbackReturn RangeSensorBroadcaster::on_configure(ControllerContext& context) {
  Parameters& p = context.parameters;
  constexpr const char* kInterfaces[] = {"range"};
  const FoundSensor sensor = read_sensor(context, kInterfaces, "a distance sensor");
  claim_state(sensor.whole + "/range");
  p.read("radiation_type", radiation_type_ = 0,
         {.text = "0: ultrasound, 1: infrared", .least = 0, .most = 1});
  p.read("field_of_view", field_of_view_ = 0.52, {.text = "rad", .least = 0, .most = 7});
  p.read("min_range", min_range_ = 0.52,
         {.text = "m, shortest distance it can measure", .least = -1e6, .most = 1e6});
  p.read("max_range", max_range_ = 4,
         {.text = "m, longest distance it can measure", .least = -1e6, .most = 1e6});
  p.read("variance", variance_ = 0, {.text = "m²", .least = 0, .most = 1e6});
  range_ = &add_output("range", "sensor_msgs/Range",
                       {"radiation_type", "field_of_view", "min_range", "max_range", "range", "variance"});
  range_->texts["frame_id"] = read_frame(p, sensor.name);
  return CallbackReturn::success;
}

ReturnType RangeSensorBroadcaster::update(const Cycle& cycle, const Verdict&) noexcept {
  const double values[] = {
      static_cast<double>(radiation_type_), field_of_view_, min_range_, max_range_, state(0), variance_};
  std::copy(std::begin(values), std::end(values), range_->draft().values.begin());
  range_->publish(cycle.time);
  return ReturnType::ok;
}

}  // namespace polyarm::controllers
