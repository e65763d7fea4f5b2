#pragma once
/// What the headers of `polyarm plugin parameters` have in common. A layout lists the parameters of a struct;
/// visitors declare and read them, or check and take changes.
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "rclcpp/node.hpp"
#include "rclcpp_lifecycle/lifecycle_node.hpp"
#include "rsl/algorithm.hpp"
#include "rsl/parameter_validators.hpp"
#include "rsl/static_string.hpp"
#include "rsl/static_vector.hpp"

namespace polyarm_ros {

using Validity = tl::expected<void, std::string>;
inline Validity any_value(const rclcpp::Parameter&) {
  return {};
}
struct ParameterFacts {
  bool has_default, read_only;
  const char* description;
};

/// Declares what is not declared, reads all, throws at the first bad value.
struct DeclaringVisitor {
  rclcpp::node_interfaces::NodeCore& node;
  const std::string& prefix;
  template <typename T, typename Check>
  void field(const std::string& name, T& value, ParameterFacts facts, Check check) {
    const std::string whole = prefix + name;
    rcl_interfaces::msg::ParameterDescriptor descriptor;
    descriptor.name = whole;
    descriptor.description = facts.description;
    descriptor.read_only = facts.read_only;
    if (!node.has_parameter(whole)) node.declare_parameter(whole, rclcpp::ParameterValue(value), descriptor);
    const rclcpp::Parameter found = node.get_parameter(whole);
    if (!facts.has_default && !node.is_overridden(whole) && !node.was_set(whole))
      throw rclcpp::exceptions::ParameterUninitializedException(
          "parameter '" + whole + "' is not initialized: it has no default, so the file must set it");
    const rclcpp::Parameter p(whole, found.get_parameter_value().as_type(
                                         rclcpp::ParameterValue(value).get_type(), whole));
    if (const Validity result = check(p); !result)
      throw rclcpp::exceptions::InvalidParameterValueException(
          "Invalid value set during initialization for parameter '" + whole + "': " + result.error());
    value = p.get_value<T>();
  }
};

/// Takes the changes that concern it; the first that is bad stays in `result`.
struct ChangingVisitor {
  const std::vector<rclcpp::Parameter>& changes;
  const std::string& prefix;
  Validity result;
  template <typename T, typename Check>
  void field(const std::string& name, T& value, ParameterFacts facts, Check check) {
    for (const rclcpp::Parameter& change : changes) {
      if (!result || change.get_name() != prefix + name) continue;
      if (facts.read_only) {
        result = tl::make_unexpected("parameter '" + change.get_name() + "' cannot be changed any more");
        continue;
      }
      const rclcpp::Parameter p(change.get_name(),
                                change.get_parameter_value().as_type(
                                    rclcpp::ParameterValue(value).get_type(), change.get_name()));
      result = check(p);
      if (result) value = p.get_value<T>();
    }
  }
};

/// Any thread; the try_… calls never wait.
template <typename Params, typename Layout>
class ParamListener {
  using Core = std::shared_ptr<rclcpp::node_interfaces::NodeCore>;

 public:
  template <typename Node>
  explicit ParamListener(const std::shared_ptr<Node>& node, const std::string& prefix = "")
      : ParamListener(core_of(node), rclcpp::get_logger("parameters"), prefix) {}
  ParamListener(Core core, rclcpp::Logger, const std::string& prefix = "")
      : core_(std::move(core)), prefix_(prefix) {
    if (!prefix_.empty() && prefix_.back() != '.') prefix_ += '.';
    declare_params();
    handle_ = core_->add_on_set_parameters_callback(
        [this](const std::vector<rclcpp::Parameter>& changes) { return update(changes); });
  }
  ParamListener(const ParamListener&) = delete;
  ParamListener& operator=(const ParamListener&) = delete;

  void declare_params() {
    Params made;
    DeclaringVisitor visitor{*core_, prefix_};
    Layout::visit(visitor, made);
    commit(made);
  }
  void refresh_dynamic_parameters() {
    Params made = get_params();
    DeclaringVisitor visitor{*core_, prefix_};
    Layout::visit(visitor, made);
    commit(made);
  }
  rcl_interfaces::msg::SetParametersResult update(const std::vector<rclcpp::Parameter>& changes) {
    Params made = get_params();
    ChangingVisitor visitor{changes, prefix_, {}};
    try {
      Layout::visit(visitor, made);
    } catch (const std::exception& e) {
      visitor.result = tl::make_unexpected(std::string(e.what()));
    }
    if (visitor.result) {
      commit(made);
      if (user_callback_) user_callback_(made);
    }
    return rsl::to_parameter_result_msg(visitor.result);
  }

  Params get_params() const {
    const std::lock_guard lock(mutex_);
    return params_;
  }
  Params get_stack_params() const { return get_params(); }
  bool try_get_params(Params& out) const {
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (lock.owns_lock() && out.__stamp != params_.__stamp) out = params_;
    return lock.owns_lock();
  }
  bool try_update_params(Params& out) const {
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock.owns_lock() || out.__stamp == params_.__stamp) return false;
    out = params_;
    return true;
  }
  bool is_old(const Params& other) const {
    const std::lock_guard lock(mutex_);
    return other.__stamp != params_.__stamp;
  }
  void setUserCallback(std::function<void(const Params&)> callback) { user_callback_ = std::move(callback); }
  void clearUserCallback() { user_callback_ = nullptr; }

 private:
  template <typename Node>
  static Core core_of(const std::shared_ptr<Node>& node) {
    if constexpr (std::is_same_v<Node, rclcpp::node_interfaces::NodeCore>)
      return node;
    else
      return node->get_node_base_interface();
  }
  void commit(Params& made) {
    const std::lock_guard lock(mutex_);
    made.__stamp = rclcpp::Time(++changes_, RCL_SYSTEM_TIME);  // differs from every earlier one; never-read ones have 0
    params_ = made;
  }
  Core core_;
  std::string prefix_;
  std::int64_t changes_ = 0;
  Params params_;
  mutable std::mutex mutex_;
  std::function<void(const Params&)> user_callback_;
  rclcpp::node_interfaces::OnSetParametersCallbackHandle::SharedPtr handle_;
};

}  // namespace polyarm_ros
