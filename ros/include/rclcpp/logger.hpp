#pragma once
#include <string>

#include "polyarm_ros/log.hpp"
#include "polyarm_ros/standard.hpp"
#include "rclcpp/macros.hpp"

namespace rclcpp {

class Logger {
 public:
  enum class Level { Unset = 0, Debug = 10, Info = 20, Warn = 30, Error = 40, Fatal = 50 };

  Logger() = default;
  explicit Logger(std::string name) : name_(std::move(name)) {}
  const char* get_name() const { return name_.c_str(); }
  Logger get_child(const std::string& suffix) const { return Logger(name_ + "." + suffix); }
  /// One level for all loggers of the module.
  void set_level(Level level) const {
    polyarm_ros::least_severity().store(level == Level::Unset ? 20 : static_cast<int>(level));
  }
  Level get_effective_level() const { return static_cast<Level>(polyarm_ros::least_severity().load()); }

 private:
  std::string name_;
};

inline Logger get_logger(const std::string& name) {
  return Logger(name);
}

}  // namespace rclcpp
