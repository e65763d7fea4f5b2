#pragma once
/// init, ok, shutdown and sleep_for of one module. Polyarm owns the process: it handles its signals.
#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "rclcpp/macros.hpp"

namespace polyarm_ros {
/// False once the last component of the module is about to end. Threads of plugins loop while it is true.
inline std::atomic<bool>& running() {
  static std::atomic<bool> value{true};
  return value;
}
}  // namespace polyarm_ros

namespace rclcpp {

enum class SignalHandlerOptions { All, SigInt, SigTerm, None };
class InitOptions {
 public:
  bool shutdown_on_signal = true;
  InitOptions& auto_initialize_logging(bool) { return *this; }
  void set_domain_id(std::size_t) {}
};
class Context : public std::enable_shared_from_this<Context> {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(Context)
  bool is_valid() const { return polyarm_ros::running().load(); }
  void init(int = 0, char const* const* = nullptr, const InitOptions& = {}) {}
  bool shutdown(const std::string&) { return true; }
};
namespace contexts {
inline Context::SharedPtr get_global_default_context() {
  static const auto only = std::make_shared<Context>();
  return only;
}
}  // namespace contexts

inline void init(int = 0, char const* const* = nullptr, const InitOptions& = {},
                 SignalHandlerOptions = SignalHandlerOptions::All) {}
inline bool ok(Context::SharedPtr = nullptr) {
  return polyarm_ros::running().load();
}
/// The process is Polyarm's: nothing is shut down.
inline bool shutdown(Context::SharedPtr = nullptr, const std::string& = {}) {
  return true;
}
inline void on_shutdown(std::function<void()>, Context::SharedPtr = nullptr) {}
inline void uninstall_signal_handlers() {}
inline std::vector<std::string> remove_ros_arguments(int argc, char const* const* argv) {
  return std::vector<std::string>(argv, argv + argc);
}
inline std::vector<std::string> init_and_remove_ros_arguments(int argc, char const* const* argv, const InitOptions& = {}) {
  return remove_ros_arguments(argc, argv);
}
inline bool sleep_for(const std::chrono::nanoseconds& span, Context::SharedPtr = nullptr) {
  const auto end = std::chrono::steady_clock::now() + span;
  while (ok() && std::chrono::steady_clock::now() < end) {
    const auto left = end - std::chrono::steady_clock::now();
    std::this_thread::sleep_for(left < std::chrono::milliseconds(50) ? left : std::chrono::milliseconds(50));
  }
  return ok();
}

}  // namespace rclcpp
