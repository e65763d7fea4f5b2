#pragma once
/// A hardware plugin of ros2_control as a component of Polyarm. Every <ros2_control> block gets an object of
/// the plugin's class. Interface names get the robot's name in front: "joint1/position" is
/// "arm/joint1/position".
///
/// What the plugin throws is caught: it becomes an error with the text as reason. NaN as command leaves the
/// plugin's position commands as they are; velocities, efforts and other rates become 0. Between read and
/// write the wrapper copies numbers and nothing else: it does not allocate, lock or log.
#include <cmath>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "hardware_interface/actuator_interface.hpp"
#include "hardware_interface/sensor_interface.hpp"
#include "hardware_interface/system_interface.hpp"
#include "polyarm/hardware/component.hpp"
#include "polyarm_ros/description.hpp"
#include "polyarm_ros/exported.hpp"
#include "polyarm_ros/last_call.hpp"
#include "polyarm_ros/log.hpp"
#include "polyarm_ros/reason.hpp"
#include "polyarm_ros/wires.hpp"

namespace polyarm_ros {

namespace hw = ::polyarm::hardware;

/// One object of the plugin's class with its handles, in the order of the spans of read and write.
struct Part {
  struct Command {
    double* place;
    bool rate;           ///< a velocity, an effort: 0 when nobody commands it
    bool given = false;  ///< a controller has written it since the activation
  };
  std::string robot, name;
  std::unique_ptr<ros::HardwareComponentInterface> object;
  std::vector<const double*> states;
  std::vector<Command> commands;
  std::vector<ros::StateInterface::ConstSharedPtr> state_handles;
  std::vector<ros::CommandInterface::SharedPtr> command_handles;
  std::vector<std::string> start, stop;  ///< of the mode switch that was prepared last
  rclcpp_lifecycle::State state{1, "unconfigured"};
};

inline bool is_rate(const std::string& interface) {
  for (const char* name : {"velocity", "effort", "torque", "force", "acceleration", "current"})
    if (interface == name) return true;
  return false;
}

class RosComponent : public hw::Component {
 public:
  RosComponent(const char* name, const char* type, bool simulated)
      : name_(name), type_(type), simulated_(simulated) {
    if (!find_exported(type)) throw std::runtime_error(std::string("it exports no class ") + type);
    ++alive();
    running().store(true);
    log_ring().start();
  }
  ~RosComponent() override {
    if (--alive() == 0) running().store(false);
    if (executor_) executor_->cancel();
    if (spinner_.joinable()) spinner_.join();
    auto* const parts = new std::vector<Part>(std::move(parts_));
    end_of_plugin(name_, [parts] { delete parts; });
  }

  hw::CallbackReturn on_init(const hw::ComponentContext& context) override;
  hw::CallbackReturn on_configure() override {
    return all("on_configure", 2, "inactive", [](auto& o, auto& s) { return o.on_configure(s); });
  }
  hw::CallbackReturn on_activate() override {
    for (Part& part : parts_)
      for (Part::Command& command : part.commands) command.given = false;
    return all("on_activate", 3, "active", [](auto& o, auto& s) { return o.on_activate(s); });
  }
  hw::CallbackReturn on_deactivate() override {
    return all("on_deactivate", 2, "inactive", [](auto& o, auto& s) { return o.on_deactivate(s); });
  }
  hw::CallbackReturn on_cleanup() override {
    return all("on_cleanup", 1, "unconfigured", [](auto& o, auto& s) { return o.on_cleanup(s); });
  }
  hw::CallbackReturn on_shutdown() override {
    return all("on_shutdown", 4, "finalized", [](auto& o, auto& s) { return o.on_shutdown(s); });
  }
  hw::CallbackReturn on_error() override {
    return all("on_error", 1, "unconfigured", [](auto& o, auto& s) { return o.on_error(s); });
  }

  std::vector<hw::InterfaceDescription> state_interfaces() const override { return states_; }
  std::vector<hw::InterfaceDescription> command_interfaces() const override { return commands_; }

  hw::ReturnType prepare_command_mode_switch(std::span<const std::string> start,
                                             std::span<const std::string> stop) override {
    hw::ReturnType out = hw::ReturnType::ok;
    for (Part& part : parts_) {
      part.start = names_for(part, start);
      part.stop = names_for(part, stop);
      if (part.start.empty() && part.stop.empty()) continue;
      worse(out, guarded("prepare_command_mode_switch",
                         [&] { return part.object->prepare_command_mode_switch(part.start, part.stop); }));
    }
    return out;
  }
  /// The names are those that were prepared; a switch that nobody prepared builds them here.
  hw::ReturnType perform_command_mode_switch(std::span<const std::string> start,
                                             std::span<const std::string> stop) noexcept override {
    hw::ReturnType out = hw::ReturnType::ok;
    for (Part& part : parts_)
      worse(out, guarded("perform_command_mode_switch", [&] {
              if (!same(part, part.start, start)) part.start = names_for(part, start);
              if (!same(part, part.stop, stop)) part.stop = names_for(part, stop);
              if (part.start.empty() && part.stop.empty()) return ros::return_type::OK;
              return part.object->perform_command_mode_switch(part.start, part.stop);
            }));
    return out;
  }

  hw::ReturnType read(const hw::Cycle& cycle, std::span<double> states) noexcept override {
    const InCycle mark;
    hw::ReturnType out = hw::ReturnType::ok;
    const rclcpp::Time time(epoch_ + cycle.time, RCL_ROS_TIME);
    const rclcpp::Duration period = rclcpp::Duration::from_nanoseconds(cycle.period);
    std::size_t at = 0;
    for (Part& part : parts_) {
      worse(out, guarded("read", [&] { return part.object->read(time, period); }));
      for (const double* place : part.states) states[at++] = *place;
    }
    return out;
  }
  hw::ReturnType write(const hw::Cycle& cycle, std::span<const double> commands) noexcept override {
    const InCycle mark;
    hw::ReturnType out = hw::ReturnType::ok;
    const rclcpp::Time time(epoch_ + cycle.time, RCL_ROS_TIME);
    const rclcpp::Duration period = rclcpp::Duration::from_nanoseconds(cycle.period);
    std::size_t at = 0;
    for (Part& part : parts_) {
      for (Part::Command& command : part.commands) take(command, commands[at++]);
      worse(out, guarded("write", [&] { return part.object->write(time, period); }));
    }
    return out;
  }

  bool real() const noexcept override { return !simulated_; }
  std::string reason() const override { return reason_.text(); }
  std::string summary() const override {
    return std::string(name_) + ", a ros2_control plugin (" + type_ + ")";
  }

 private:
  struct InCycle {
    InCycle() { in_cycle() = true; }
    ~InCycle() { in_cycle() = false; }
  };
  static std::atomic<int>& alive() {
    static std::atomic<int> count{0};
    return count;
  }

  static void take(Part::Command& command, double value) noexcept {
    if (value == value) {
      *command.place = value;
      command.given = true;
    } else if (command.given && command.rate) {
      *command.place = 0;
      command.given = false;
    }
  }
  static void worse(hw::ReturnType& out, hw::ReturnType next) noexcept {
    if (next == hw::ReturnType::error || out == hw::ReturnType::ok) out = next;
  }
  /// The call's result; what it throws is an error with its text as the reason.
  template <typename Call>
  hw::ReturnType guarded(const char* where, Call&& call) noexcept {
    try {
      const ros::return_type result = call();
      if (result == ros::return_type::OK) return hw::ReturnType::ok;
      reason_.set(where, result == ros::return_type::DEACTIVATE
                             ? "the plugin asks to be deactivated"
                             : "the plugin returns an error; its log says more");
      return result == ros::return_type::DEACTIVATE ? hw::ReturnType::deactivate : hw::ReturnType::error;
    } catch (const std::exception& e) {
      reason_.set(where, e.what());
    } catch (...) {
      reason_.set(where, "the plugin threw something that is not a std::exception");
    }
    return hw::ReturnType::error;
  }
  template <typename Call>
  hw::CallbackReturn callback(const char* where, Call&& call) {
    const ServesGraph mark;
    try {
      const ros::CallbackReturn result = call();
      if (result == ros::CallbackReturn::SUCCESS) return hw::CallbackReturn::success;
      reason_.set(where, "the plugin returns a failure; its log says more");
      return result == ros::CallbackReturn::FAILURE ? hw::CallbackReturn::failure : hw::CallbackReturn::error;
    } catch (const std::exception& e) {
      reason_.set(where, e.what());
    } catch (...) {
      reason_.set(where, "the plugin threw something that is not a std::exception");
    }
    return hw::CallbackReturn::error;
  }
  /// One callback of all parts; the first that fails ends it.
  template <typename Call>
  hw::CallbackReturn all(const char* where, std::uint8_t id, const char* label, Call&& call) {
    for (Part& part : parts_) {
      const hw::CallbackReturn result = callback(where, [&] { return call(*part.object, part.state); });
      if (result != hw::CallbackReturn::success) return result;
      part.state = rclcpp_lifecycle::State(id, label);
      part.object->set_lifecycle_state(part.state);
    }
    spin_nodes();
    return hw::CallbackReturn::success;
  }

  hw::CallbackReturn make_part(const hw::ComponentContext& context, const hw::RobotInstance& robot,
                               const own::HardwareInfo& block);
  void take_handles(Part& part);
  void spin_nodes() {
    if (!executor_ || spinner_.joinable() || !executor_->has_nodes()) return;
    spinner_ = std::thread([this] {
      while (!spin_until_throw()) {
      }
    });
  }
  /// True if the executor has ended; false after a callback that threw: the others go on.
  bool spin_until_throw() {
    try {
      executor_->spin();
      return true;
    } catch (const std::exception& e) {
      log_format(Severity::error, name_, "a callback of its node: %s", e.what());
    } catch (...) {
      log_format(Severity::error, name_, "a callback of its node threw something that is no std::exception");
    }
    return false;
  }
  /// Those of `names` that are the part's, without the robot's name.
  static std::vector<std::string> names_for(const Part& part, std::span<const std::string> names) {
    std::vector<std::string> out;
    for (const std::string& name : names)
      if (mine(part, name)) out.push_back(name.substr(part.robot.size() + 1));
    return out;
  }
  static bool mine(const Part& part, const std::string& name) noexcept {
    if (name.size() <= part.robot.size() || name.compare(0, part.robot.size(), part.robot) != 0) return false;
    for (const auto& handle : part.command_handles)
      if (name.compare(part.robot.size() + 1, std::string::npos, handle->get_name()) == 0) return true;
    return false;
  }
  static bool same(const Part& part, const std::vector<std::string>& prepared,
                   std::span<const std::string> names) noexcept {
    std::size_t at = 0;
    for (const std::string& name : names) {
      if (!mine(part, name)) continue;
      if (at == prepared.size() || name.compare(part.robot.size() + 1, std::string::npos, prepared[at]) != 0)
        return false;
      ++at;
    }
    return at == prepared.size();
  }

  const char* name_;
  const char* type_;
  bool simulated_;
  std::vector<Part> parts_;
  std::vector<hw::InterfaceDescription> states_, commands_;
  std::int64_t epoch_ = 0;
  Reason reason_;
  std::shared_ptr<rclcpp::Executor> executor_;
  std::thread spinner_;
};

/// An object of the exported class; null if there is none, or if its base is no hardware.
inline std::unique_ptr<ros::HardwareComponentInterface> make_object(const char* type) {
  const ExportedClass* exported = find_exported(type);
  if (!exported) return nullptr;
  std::unique_ptr<ros::HardwareComponentInterface> out;
  if (is_base(exported->base, "SystemInterface"))
    out.reset(static_cast<ros::SystemInterface*>(exported->make()));
  if (is_base(exported->base, "ActuatorInterface"))
    out.reset(static_cast<ros::ActuatorInterface*>(exported->make()));
  if (is_base(exported->base, "SensorInterface"))
    out.reset(static_cast<ros::SensorInterface*>(exported->make()));
  return out;
}

inline void RosComponent::take_handles(Part& part) {
  part.state_handles = part.object->on_export_state_interfaces();
  part.command_handles = part.object->on_export_command_interfaces();
  for (const auto& handle : part.state_handles) {
    double* place = const_cast<ros::StateInterface&>(*handle).polyarm_place();
    part.states.push_back(place);
    states_.push_back({part.robot + "/" + handle->get_name(), *place});
  }
  for (const auto& handle : part.command_handles) {
    part.commands.push_back({handle->polyarm_place(), is_rate(handle->get_interface_name())});
    commands_.push_back({part.robot + "/" + handle->get_name(), std::nan("")});
  }
}

inline hw::CallbackReturn RosComponent::make_part(const hw::ComponentContext& context,
                                                  const hw::RobotInstance& robot,
                                                  const own::HardwareInfo& block) {
  Part part;
  part.robot = robot.name;
  part.name = block.name;
  const auto result = callback("on_init", [&] {
    part.object = make_object(type_);
    if (!part.object)
      throw std::runtime_error(std::string("no class ") + type_ +
                               " with a hardware interface as its base is exported");
    ros::HardwareComponentParams params;
    params.hardware_info = hardware_info(block, *robot.model, context.parameters);
    if (params.hardware_info.rw_rate == 0 &&
        context.period > 0)  // as the controller manager of ROS fills it in
      params.hardware_info.rw_rate =
          static_cast<unsigned>(std::lround(1e9 / static_cast<double>(context.period)));
    params.logger = rclcpp::get_logger("resource_manager");
    params.clock = std::make_shared<rclcpp::Clock>(RCL_ROS_TIME);
    params.executor = executor_;
    const ros::CallbackReturn result = part.object->init(params);
    if (result != ros::CallbackReturn::SUCCESS) return result;
    part.object->set_lifecycle_state(part.state);
    take_handles(part);
    return result;
  });
  if (result == hw::CallbackReturn::success)
    parts_.push_back(std::move(part));
  else if (auto* const object = part.object.release())
    end_of_plugin(name_, [object] { delete object; });
  return result;
}

inline hw::CallbackReturn RosComponent::on_init(const hw::ComponentContext& context) {
  executor_ = std::make_shared<rclcpp::executors::SingleThreadedExecutor>();
  epoch_ = rclcpp::Clock(RCL_ROS_TIME).now().nanoseconds();
  for (const hw::RobotInstance& robot : context.robots)
    for (const own::HardwareInfo& block : robot.hardware)
      if (const auto result = make_part(context, robot, block); result != hw::CallbackReturn::success)
        return result;
  if (parts_.empty()) {
    reason_.set(name_, "the robot has no <ros2_control> block for this plugin");
    return hw::CallbackReturn::error;
  }
  spin_nodes();
  return hw::CallbackReturn::success;
}

}  // namespace polyarm_ros
