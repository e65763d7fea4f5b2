#pragma once
/// Quality of service. Depth, reliability and durability count on the ROS 2 graph; the rest has no effect.
#include <cstddef>

#include "rclcpp/duration.hpp"

enum rmw_qos_history_policy_e {
  RMW_QOS_POLICY_HISTORY_SYSTEM_DEFAULT,
  RMW_QOS_POLICY_HISTORY_KEEP_LAST,
  RMW_QOS_POLICY_HISTORY_KEEP_ALL
};
enum rmw_qos_reliability_policy_e {
  RMW_QOS_POLICY_RELIABILITY_SYSTEM_DEFAULT,
  RMW_QOS_POLICY_RELIABILITY_RELIABLE,
  RMW_QOS_POLICY_RELIABILITY_BEST_EFFORT
};
enum rmw_qos_durability_policy_e {
  RMW_QOS_POLICY_DURABILITY_SYSTEM_DEFAULT,
  RMW_QOS_POLICY_DURABILITY_TRANSIENT_LOCAL,
  RMW_QOS_POLICY_DURABILITY_VOLATILE
};
enum rmw_qos_liveliness_policy_e {
  RMW_QOS_POLICY_LIVELINESS_SYSTEM_DEFAULT,
  RMW_QOS_POLICY_LIVELINESS_AUTOMATIC
};
using rmw_qos_history_policy_t = rmw_qos_history_policy_e;
using rmw_qos_reliability_policy_t = rmw_qos_reliability_policy_e;
using rmw_qos_durability_policy_t = rmw_qos_durability_policy_e;
struct rmw_qos_profile_t {
  rmw_qos_history_policy_e history = RMW_QOS_POLICY_HISTORY_KEEP_LAST;
  std::size_t depth = 10;
  rmw_qos_reliability_policy_e reliability = RMW_QOS_POLICY_RELIABILITY_RELIABLE;
  rmw_qos_durability_policy_e durability = RMW_QOS_POLICY_DURABILITY_VOLATILE;
};
inline const rmw_qos_profile_t rmw_qos_profile_default{},
    rmw_qos_profile_sensor_data{RMW_QOS_POLICY_HISTORY_KEEP_LAST, 5, RMW_QOS_POLICY_RELIABILITY_BEST_EFFORT},
    rmw_qos_profile_services_default{}, rmw_qos_profile_parameters{}, rmw_qos_profile_system_default{};

namespace rclcpp {

enum class HistoryPolicy { KeepLast, KeepAll, SystemDefault, Unknown };
enum class ReliabilityPolicy { BestEffort, Reliable, SystemDefault, BestAvailable, Unknown };
enum class DurabilityPolicy { Volatile, TransientLocal, SystemDefault, BestAvailable, Unknown };
enum class LivelinessPolicy { Automatic, ManualByTopic, SystemDefault, BestAvailable, Unknown };

struct QoSInitialization {
  QoSInitialization() = default;
  QoSInitialization(rmw_qos_history_policy_e history, std::size_t n, bool = true)
      : history_policy(history), depth(n) {}
  rmw_qos_history_policy_e history_policy = RMW_QOS_POLICY_HISTORY_KEEP_LAST;
  std::size_t depth = 10;
  static QoSInitialization from_rmw(const rmw_qos_profile_t& p) { return {p.history, p.depth}; }
};
struct KeepLast : QoSInitialization {
  explicit KeepLast(std::size_t n, bool = true) { depth = n; }
};
struct KeepAll : QoSInitialization {
  KeepAll() { history_policy = RMW_QOS_POLICY_HISTORY_KEEP_ALL; }
};

class QoS {
 public:
  QoS(const QoSInitialization& initial, const rmw_qos_profile_t& profile = {})
      : profile_(profile) {  // NOLINT
    profile_.depth = initial.depth;
  }
  QoS(std::size_t depth) { profile_.depth = depth; }  // NOLINT: implicit in ROS
  QoS& history(HistoryPolicy) { return *this; }
  QoS& keep_last(std::size_t depth) { return profile_.depth = depth, *this; }
  QoS& keep_all() { return *this; }
  QoS& reliability(ReliabilityPolicy policy) {
    return policy == ReliabilityPolicy::BestEffort ? best_effort() : reliable();
  }
  QoS& reliability(rmw_qos_reliability_policy_e policy) { return profile_.reliability = policy, *this; }
  QoS& reliable() { return reliability(RMW_QOS_POLICY_RELIABILITY_RELIABLE); }
  QoS& best_effort() { return reliability(RMW_QOS_POLICY_RELIABILITY_BEST_EFFORT); }
  QoS& durability(DurabilityPolicy policy) {
    return policy == DurabilityPolicy::TransientLocal ? transient_local() : durability_volatile();
  }
  QoS& durability(rmw_qos_durability_policy_e policy) { return profile_.durability = policy, *this; }
  QoS& durability_volatile() { return durability(RMW_QOS_POLICY_DURABILITY_VOLATILE); }
  QoS& transient_local() { return durability(RMW_QOS_POLICY_DURABILITY_TRANSIENT_LOCAL); }
  QoS& deadline(const Duration&) { return *this; }
  QoS& lifespan(const Duration&) { return *this; }
  QoS& liveliness(LivelinessPolicy) { return *this; }
  std::size_t depth() const { return profile_.depth; }
  bool polyarm_reliable() const { return profile_.reliability != RMW_QOS_POLICY_RELIABILITY_BEST_EFFORT; }
  bool polyarm_transient_local() const {
    return profile_.durability == RMW_QOS_POLICY_DURABILITY_TRANSIENT_LOCAL;
  }
  const rmw_qos_profile_t& get_rmw_qos_profile() const { return profile_; }
  rmw_qos_profile_t& get_rmw_qos_profile() { return profile_; }

 private:
  rmw_qos_profile_t profile_;
};
#define POLYARM_ROS_QOS_(NAME)                                        \
  class NAME : public QoS {                                           \
   public:                                                            \
    NAME() : QoS(10) {}                                               \
    explicit NAME(const QoSInitialization& initial) : QoS(initial) {} \
  };
POLYARM_ROS_QOS_(SystemDefaultsQoS)
POLYARM_ROS_QOS_(ServicesQoS)
POLYARM_ROS_QOS_(ParametersQoS)
POLYARM_ROS_QOS_(ParameterEventsQoS)
POLYARM_ROS_QOS_(ClockQoS)
POLYARM_ROS_QOS_(RosoutQoS)
POLYARM_ROS_QOS_(BestAvailableQoS)
#undef POLYARM_ROS_QOS_
class SensorDataQoS : public QoS {
 public:
  SensorDataQoS() : SensorDataQoS(KeepLast(5)) {}
  explicit SensorDataQoS(const QoSInitialization& initial) : QoS(initial, rmw_qos_profile_sensor_data) {}
};

}  // namespace rclcpp
