#pragma once
/// The views of a node. They are one class here, under the names of ROS.
#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "polyarm_ros/call_watch.hpp"
#include "polyarm_ros/wires.hpp"
#include "rcl_interfaces/msg/list_parameters_result.hpp"
#include "rclcpp/callback_group.hpp"
#include "rclcpp/clock.hpp"
#include "rclcpp/exceptions.hpp"
#include "rclcpp/logger.hpp"
#include "rclcpp/node_options.hpp"
#include "rclcpp/parameter.hpp"
#include "rclcpp/timer.hpp"
#include "rclcpp/utilities.hpp"

namespace rclcpp::node_interfaces {

using ParametersCallback =
    std::function<rcl_interfaces::msg::SetParametersResult(const std::vector<Parameter>&)>;
struct OnSetParametersCallbackHandle {
  RCLCPP_SMART_PTR_DEFINITIONS(OnSetParametersCallbackHandle)
  using OnParametersSetCallbackType = ParametersCallback;
  ParametersCallback callback;
};
struct PostSetParametersCallbackHandle {
  RCLCPP_SMART_PTR_DEFINITIONS(PostSetParametersCallbackHandle)
  std::function<void(const std::vector<Parameter>&)> callback;
};
struct PreSetParametersCallbackHandle {
  RCLCPP_SMART_PTR_DEFINITIONS(PreSetParametersCallbackHandle)
};

/// Name, clock, logger, parameters and timers of a node. Any thread.
class NodeCore {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(NodeCore)

  NodeCore(std::string name, std::string name_space, const NodeOptions& options)
      : name_(std::move(name)),
        space_(name_space.empty() ? "/" : std::move(name_space)),
        options_(options),
        logger_(name_),
        clock_(std::make_shared<Clock>(RCL_ROS_TIME)) {
    if (space_[0] != '/') space_ = "/" + space_;
    if (options.automatically_declare_parameters_from_overrides())
      for (const Parameter& p : options.parameter_overrides()) values_[p.get_name()] = p;
  }

  const char* get_name() const { return name_.c_str(); }
  const char* get_namespace() const { return space_.c_str(); }
  const char* get_fully_qualified_name() const { return full_.c_str(); }
  Logger get_logger() const { return logger_; }
  const char* get_logger_name() const { return logger_.get_name(); }
  Clock::SharedPtr get_clock() const { return clock_; }
  Context::SharedPtr get_context() const { return contexts::get_global_default_context(); }
  const NodeOptions& options() const { return options_; }
  CallbackGroup::SharedPtr create_callback_group(CallbackGroupType type, bool = true) {
    return std::make_shared<CallbackGroup>(type);
  }
  CallbackGroup::SharedPtr get_default_callback_group() {
    return create_callback_group(CallbackGroupType::Reentrant);
  }

  const ParameterValue& declare_parameter(const std::string& name, const ParameterValue& value,
                                          const rcl_interfaces::msg::ParameterDescriptor& descriptor = {},
                                          bool = false) {
    const std::lock_guard lock(mutex_);
    if (values_.count(name))
      throw exceptions::ParameterAlreadyDeclaredException("parameter '" + name +
                                                          "' has already been declared");
    if (descriptor.read_only) fixed_.insert(name);
    described_[name] = descriptor;
    described_[name].name = name;
    const std::vector<Parameter>& given = options_.parameter_overrides();
    for (auto p = given.rbegin(); p != given.rend(); ++p)  // the last counts
      if (p->get_name() == name)
        return (values_[name] = Parameter(name, p->get_parameter_value().as_type(value.get_type(), name)))
            .get_parameter_value();
    return (values_[name] = Parameter(name, value)).get_parameter_value();
  }
  /// True if a file or an option gives the parameter a value.
  bool is_overridden(const std::string& name) const {
    for (const Parameter& p : options_.parameter_overrides())
      if (p.get_name() == name) return true;
    return false;
  }
  /// True if set_parameters has given it a value.
  bool was_set(const std::string& name) const {
    const std::lock_guard lock(mutex_);
    return set_.count(name) > 0;
  }
  bool has_parameter(const std::string& name) const {
    const std::lock_guard lock(mutex_);
    return values_.count(name) > 0;
  }
  /// A declared parameter, or one that get_parameter finds without a declaration.
  bool knows_parameter(const std::string& name) const {
    const std::lock_guard lock(mutex_);
    return values_.count(name) > 0 || given(name) != nullptr;
  }
  void undeclare_parameter(const std::string& name) {
    const std::lock_guard lock(mutex_);
    values_.erase(name), described_.erase(name), fixed_.erase(name);
  }
  bool get_parameter(const std::string& name, Parameter& out) const {
    const std::lock_guard lock(mutex_);
    const auto found = values_.find(name);
    const Parameter* const undeclared = found == values_.end() ? given(name) : nullptr;
    if (found == values_.end() && !undeclared) return false;
    out = undeclared ? *undeclared : found->second;
    return out.get_type() != ParameterType::PARAMETER_NOT_SET;
  }
  Parameter get_parameter(const std::string& name) const {
    Parameter out;
    if (!knows_parameter(name))
      throw exceptions::ParameterNotDeclaredException("parameter '" + name + "' is not declared");
    if (!get_parameter(name, out))
      throw exceptions::ParameterUninitializedException("parameter '" + name + "' is not initialized");
    return out;
  }
  std::vector<Parameter> get_parameters(const std::vector<std::string>& names) const {
    std::vector<Parameter> out;
    for (const std::string& name : names) out.push_back(get_parameter(name));
    return out;
  }
  bool get_parameters_by_prefix(const std::string& prefix, std::map<std::string, Parameter>& out) const {
    const std::lock_guard lock(mutex_);
    const std::string start = prefix.empty() ? "" : prefix + ".";
    for (const auto& [name, value] : known())
      if (name.compare(0, start.size(), start) == 0) out[name.substr(start.size())] = value, given(name);
    return !out.empty();
  }
  /// Names below any of the prefixes (all without one), down to `depth` levels (0: all).
  rcl_interfaces::msg::ListParametersResult list_parameters(const std::vector<std::string>& prefixes,
                                                            std::uint64_t depth) const {
    const auto levels = [](const std::string& name) {
      return static_cast<std::uint64_t>(std::count(name.begin(), name.end(), '.')) + 1;
    };
    const auto wanted = [&](const std::string& name) {
      if (prefixes.empty()) return depth == 0 || levels(name) <= depth;
      for (const std::string& prefix : prefixes)
        if (name == prefix || (name.compare(0, prefix.size() + 1, prefix + ".") == 0 &&
                               (depth == 0 || levels(name.substr(prefix.size() + 1)) <= depth)))
          return true;
      return false;
    };
    const std::lock_guard lock(mutex_);
    rcl_interfaces::msg::ListParametersResult out;
    for (const auto& [name, value] : known()) {
      if (!wanted(name)) continue;
      out.names.push_back(name);
      const std::string prefix = name.substr(0, name.find('.') == std::string::npos ? 0 : name.rfind('.'));
      if (!prefix.empty() &&
          std::find(out.prefixes.begin(), out.prefixes.end(), prefix) == out.prefixes.end())
        out.prefixes.push_back(prefix);
    }
    return out;
  }
  std::vector<rcl_interfaces::msg::ParameterDescriptor> describe_parameters(
      const std::vector<std::string>& names) const {
    std::vector<rcl_interfaces::msg::ParameterDescriptor> out;
    for (const std::string& name : names) {
      const std::lock_guard lock(mutex_);
      const auto found = values_.find(name);
      if (found == values_.end())
        throw exceptions::ParameterNotDeclaredException("parameter '" + name + "' is not declared");
      const auto described = described_.find(name);
      out.push_back(described == described_.end() ? rcl_interfaces::msg::ParameterDescriptor()
                                                  : described->second);
      out.back().name = name;
      out.back().type = static_cast<std::uint8_t>(found->second.get_type());
    }
    return out;
  }
  std::vector<std::uint8_t> get_parameter_types(const std::vector<std::string>& names) const {
    std::vector<std::uint8_t> out;
    for (const auto& each : describe_parameters(names)) out.push_back(each.type);
    return out;
  }
  rcl_interfaces::msg::SetParametersResult set_parameters_atomically(const std::vector<Parameter>& all) {
    rcl_interfaces::msg::SetParametersResult result;
    result.successful = true;
    for (const auto& each : callbacks_)
      if (const auto alive = each.lock())
        if (result = alive->callback(all); !result.successful) return result;
    {
      const std::lock_guard lock(mutex_);
      for (const Parameter& p : all) values_[p.get_name()] = p, set_.insert(p.get_name());
    }
    for (const auto& each : after_)
      if (const auto alive = each.lock()) alive->callback(all);
    return result;
  }
  std::vector<rcl_interfaces::msg::SetParametersResult> set_parameters(const std::vector<Parameter>& all) {
    std::vector<rcl_interfaces::msg::SetParametersResult> out;
    for (const Parameter& p : all) out.push_back(set_parameters_atomically({p}));
    return out;
  }
  rcl_interfaces::msg::SetParametersResult set_parameter(const Parameter& p) {
    return set_parameters_atomically({p});
  }
  OnSetParametersCallbackHandle::SharedPtr add_on_set_parameters_callback(ParametersCallback callback) {
    auto handle = std::make_shared<OnSetParametersCallbackHandle>();
    handle->callback = std::move(callback);
    callbacks_.push_back(handle);
    return handle;
  }
  void remove_on_set_parameters_callback(const OnSetParametersCallbackHandle* handle) {
    for (auto& each : callbacks_)
      if (each.lock().get() == handle) each.reset();
  }
  PostSetParametersCallbackHandle::SharedPtr add_post_set_parameters_callback(
      std::function<void(const std::vector<Parameter>&)> callback) {
    auto handle = std::make_shared<PostSetParametersCallbackHandle>();
    handle->callback = std::move(callback);
    after_.push_back(handle);
    return handle;
  }
  const std::map<std::string, Parameter> get_parameter_overrides() const {
    std::map<std::string, Parameter> out;
    for (const Parameter& p : options_.parameter_overrides()) out[p.get_name()] = p;
    return out;
  }

  /// For clients of parameters: what robot_state_publisher has as `robot_description`. Empty if it is not
  /// known.
  std::string polyarm_robot_description;
  /// For controllers, which in Humble read what a file gives without a declaration. has_parameter() and
  /// declare_parameter() know only what is declared.
  bool polyarm_reads_undeclared = false;
  polyarm_ros::Wires wires;
  /// What timers count in: the cell's time in the node of a controller.
  polyarm_ros::TimeSource timer_source = std::make_shared<std::atomic<std::int64_t>>(0);
  /// All parameters that are declared or were read, by name, and whether they may only be set before the node
  /// runs.
  std::map<std::string, std::pair<ParameterValue, bool>> polyarm_parameters() const {
    const std::lock_guard lock(mutex_);
    std::map<std::string, std::pair<ParameterValue, bool>> out;
    for (const auto& [name, p] : values_) out[name] = {p.get_parameter_value(), fixed_.count(name) > 0};
    for (const std::string& name : read_)
      if (const Parameter* undeclared = given(name)) out[name] = {undeclared->get_parameter_value(), true};
    return out;
  }

  void add_timer(const TimerBase::SharedPtr& timer, const CallbackGroup::SharedPtr& = nullptr) {
    const std::lock_guard lock(mutex_);
    timers_.push_back(timer);
  }
  /// Runs what is due: timers, messages that wait for subscriptions, requests that wait for services. False
  /// if nothing was.
  bool run_due() {
    bool any = run_timers();
    for (const auto& listener : wires.listeners()) any = listener->run() || any;
    for (const auto& callee : wires.callees()) any = callee->run(0) || any;
    return any;
  }
  /// The same for a thread that waits for the callbacks: after `budget` ns it begins no further one, and goes
  /// on there at the next call; names those that take long. Timers that use up the budget leave time for one
  /// subscription or service.
  void run_due_within(std::int64_t budget) {
    const auto listeners = wires.listeners();
    const auto callees = wires.callees();
    const std::size_t all = listeners.size() + callees.size();
    const std::int64_t until = polyarm_ros::steady_time() + budget;
    {
      const polyarm_ros::WatchedCall mark(name_.c_str(), "timers of", name_);
      run_timers();
    }
    for (std::size_t n = 0; n < all && (n == 0 || polyarm_ros::steady_time() < until); ++n) {
      const std::size_t at = next_source_++ % all;
      if (at < listeners.size()) {
        const polyarm_ros::WatchedCall mark(name_.c_str(), "subscription", listeners[at]->topic);
        listeners[at]->run(until);
      } else {
        const auto& callee = callees[at - listeners.size()];
        const polyarm_ros::WatchedCall mark(name_.c_str(), "service", callee->title());
        callee->run(until);
      }
    }
  }
  /// Runs the timers that are due; false if there was none.
  bool run_timers() {
    std::vector<TimerBase::SharedPtr> due;
    {
      const std::lock_guard lock(mutex_);
      for (const auto& each : timers_)
        if (auto timer = each.lock(); timer && timer->is_ready()) due.push_back(timer);
    }
    for (const auto& timer : due) timer->execute_callback();
    return !due.empty();
  }

 private:
  /// The value of an undeclared parameter in a file or an option, which counts as read then. Null: there is
  /// none, or undeclared parameters are not read.
  const Parameter* given(const std::string& name) const {
    if (!polyarm_reads_undeclared || values_.count(name)) return nullptr;
    const std::vector<Parameter>& all = options_.parameter_overrides();
    for (auto p = all.rbegin(); p != all.rend(); ++p)  // the last counts
      if (p->get_name() == name) return read_.insert(name), &*p;
    return nullptr;
  }
  std::map<std::string, Parameter> known() const {
    std::map<std::string, Parameter> out = values_;
    if (polyarm_reads_undeclared)
      for (const Parameter& p : options_.parameter_overrides())
        if (!values_.count(p.get_name())) out[p.get_name()] = p;
    return out;
  }
  std::string name_, space_;
  std::string full_ = space_ == "/" ? "/" + name_ : space_ + "/" + name_;
  NodeOptions options_;
  Logger logger_;
  Clock::SharedPtr clock_;
  mutable std::mutex mutex_;
  std::map<std::string, Parameter> values_;
  std::map<std::string, rcl_interfaces::msg::ParameterDescriptor> described_;
  mutable std::set<std::string> read_;  ///< without a declaration
  std::set<std::string> set_, fixed_;  ///< set by set_parameters; declared as read only
  std::vector<std::weak_ptr<OnSetParametersCallbackHandle>> callbacks_;
  std::vector<std::weak_ptr<PostSetParametersCallbackHandle>> after_;
  std::vector<TimerBase::WeakPtr> timers_;
  std::size_t next_source_ = 0;  ///< of run_due_within; its thread only
};
using NodeBaseInterface = NodeCore;
using NodeClockInterface = NodeCore;
using NodeLoggingInterface = NodeCore;
using NodeParametersInterface = NodeCore;
using NodeTimersInterface = NodeCore;
using NodeTopicsInterface = NodeCore;
using NodeServicesInterface = NodeCore;
using NodeGraphInterface = NodeCore;
using NodeWaitablesInterface = NodeCore;
using NodeTimeSourceInterface = NodeCore;

}  // namespace rclcpp::node_interfaces
