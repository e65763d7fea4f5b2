#pragma once
/// Quality of service. Depth, reliability and durability count on the ROS 2 graph; the rest has no effect.
#include <cstddef>

#include "polyarm_ros/standard.hpp"
#include "rclcpp/duration.hpp"

enum rmw_qos_history_policy_e {
  RMW_QOS_POLICY_HISTORY_SYSTEM_DEFAULT,
  RMW_QOS_POLICY_HISTORY_KEEP_LAST,
  RMW_QOS_POLICY_HISTORY_KEEP_ALL,
  RMW_QOS_POLICY_HISTORY_UNKNOWN
};
enum rmw_qos_reliability_policy_e {
  RMW_QOS_POLICY_RELIABILITY_SYSTEM_DEFAULT,
  RMW_QOS_POLICY_RELIABILITY_RELIABLE,
  RMW_QOS_POLICY_RELIABILITY_BEST_EFFORT,
  RMW_QOS_POLICY_RELIABILITY_UNKNOWN,
  RMW_QOS_POLICY_RELIABILITY_BEST_AVAILABLE
};
enum rmw_qos_durability_policy_e {
  RMW_QOS_POLICY_DURABILITY_SYSTEM_DEFAULT,
  RMW_QOS_POLICY_DURABILITY_TRANSIENT_LOCAL,
  RMW_QOS_POLICY_DURABILITY_VOLATILE,
  RMW_QOS_POLICY_DURABILITY_UNKNOWN,
  RMW_QOS_POLICY_DURABILITY_BEST_AVAILABLE
};
enum rmw_qos_liveliness_policy_e {
  RMW_QOS_POLICY_LIVELINESS_SYSTEM_DEFAULT = 0,
  RMW_QOS_POLICY_LIVELINESS_AUTOMATIC = 1,
  RMW_QOS_POLICY_LIVELINESS_MANUAL_BY_TOPIC = 3,
  RMW_QOS_POLICY_LIVELINESS_UNKNOWN = 4,
  RMW_QOS_POLICY_LIVELINESS_BEST_AVAILABLE = 5
};
enum { RMW_QOS_POLICY_DEPTH_SYSTEM_DEFAULT = 0 };
#define RMW_DURATION_UNSPECIFIED \
  { 0, 0 }
#define RMW_DURATION_INFINITE \
  { 9223372036LL, 854775807LL }
#define RMW_QOS_DEADLINE_DEFAULT RMW_DURATION_UNSPECIFIED
#define RMW_QOS_LIFESPAN_DEFAULT RMW_DURATION_UNSPECIFIED
#define RMW_QOS_LIVELINESS_LEASE_DURATION_DEFAULT RMW_DURATION_UNSPECIFIED
using rmw_qos_history_policy_t = rmw_qos_history_policy_e;
using rmw_qos_reliability_policy_t = rmw_qos_reliability_policy_e;
using rmw_qos_durability_policy_t = rmw_qos_durability_policy_e;
using rmw_qos_liveliness_policy_t = rmw_qos_liveliness_policy_e;
struct rmw_qos_profile_t {
  rmw_qos_history_policy_e history = RMW_QOS_POLICY_HISTORY_KEEP_LAST;
  std::size_t depth = 10;
  rmw_qos_reliability_policy_e reliability = RMW_QOS_POLICY_RELIABILITY_RELIABLE;
  rmw_qos_durability_policy_e durability = RMW_QOS_POLICY_DURABILITY_VOLATILE;
  rmw_time_t deadline{0, 0}, lifespan{0, 0};
  rmw_qos_liveliness_policy_e liveliness = RMW_QOS_POLICY_LIVELINESS_SYSTEM_DEFAULT;
  rmw_time_t liveliness_lease_duration{0, 0};
  bool avoid_ros_namespace_conventions = false;
};
inline const rmw_qos_profile_t rmw_qos_profile_default{},
    rmw_qos_profile_sensor_data{
        RMW_QOS_POLICY_HISTORY_KEEP_LAST,         5,      RMW_QOS_POLICY_RELIABILITY_BEST_EFFORT,
        RMW_QOS_POLICY_DURABILITY_VOLATILE,       {0, 0}, {0, 0},
        RMW_QOS_POLICY_LIVELINESS_SYSTEM_DEFAULT, {0, 0}, false},
    rmw_qos_profile_services_default{}, rmw_qos_profile_parameters{}, rmw_qos_profile_parameter_events{},
    rmw_qos_profile_system_default{}, rmw_qos_profile_best_available{}, rmw_qos_profile_unknown{};

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
    profile_.history = initial.history_policy;
    profile_.depth = initial.depth;
  }
  QoS(std::size_t depth) { profile_.depth = depth; }  // NOLINT: implicit in ROS
  QoS& history(HistoryPolicy policy) {
    return policy == HistoryPolicy::KeepAll ? keep_all() : history(RMW_QOS_POLICY_HISTORY_KEEP_LAST);
  }
  QoS& history(rmw_qos_history_policy_e policy) { return profile_.history = policy, *this; }
  QoS& keep_last(std::size_t depth) {
    profile_.depth = depth;
    return history(RMW_QOS_POLICY_HISTORY_KEEP_LAST);
  }
  QoS& keep_all() { return history(RMW_QOS_POLICY_HISTORY_KEEP_ALL); }
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
  QoS& deadline(const rmw_time_t& time) { return profile_.deadline = time, *this; }
  QoS& deadline(const Duration& time) { return deadline(time.to_rmw_time()); }
  QoS& lifespan(const rmw_time_t& time) { return profile_.lifespan = time, *this; }
  QoS& lifespan(const Duration& time) { return lifespan(time.to_rmw_time()); }
  QoS& liveliness(rmw_qos_liveliness_policy_e policy) { return profile_.liveliness = policy, *this; }
  QoS& liveliness(LivelinessPolicy policy) {
    return liveliness(policy == LivelinessPolicy::ManualByTopic ? RMW_QOS_POLICY_LIVELINESS_MANUAL_BY_TOPIC
                      : policy == LivelinessPolicy::Automatic   ? RMW_QOS_POLICY_LIVELINESS_AUTOMATIC
                                                                : RMW_QOS_POLICY_LIVELINESS_SYSTEM_DEFAULT);
  }
  QoS& liveliness_lease_duration(const rmw_time_t& time) {
    return profile_.liveliness_lease_duration = time, *this;
  }
  QoS& liveliness_lease_duration(const Duration& time) {
    return liveliness_lease_duration(time.to_rmw_time());
  }
  QoS& avoid_ros_namespace_conventions(bool avoids) {
    return profile_.avoid_ros_namespace_conventions = avoids, *this;
  }

  HistoryPolicy history() const {
    return profile_.history == RMW_QOS_POLICY_HISTORY_KEEP_ALL ? HistoryPolicy::KeepAll
                                                               : HistoryPolicy::KeepLast;
  }
  ReliabilityPolicy reliability() const {
    return polyarm_reliable() ? ReliabilityPolicy::Reliable : ReliabilityPolicy::BestEffort;
  }
  DurabilityPolicy durability() const {
    return polyarm_transient_local() ? DurabilityPolicy::TransientLocal : DurabilityPolicy::Volatile;
  }
  LivelinessPolicy liveliness() const {
    switch (profile_.liveliness) {
      case RMW_QOS_POLICY_LIVELINESS_MANUAL_BY_TOPIC:
        return LivelinessPolicy::ManualByTopic;
      case RMW_QOS_POLICY_LIVELINESS_AUTOMATIC:
        return LivelinessPolicy::Automatic;
      default:
        return LivelinessPolicy::SystemDefault;
    }
  }
  Duration deadline() const { return span_of(profile_.deadline); }
  Duration lifespan() const { return span_of(profile_.lifespan); }
  Duration liveliness_lease_duration() const { return span_of(profile_.liveliness_lease_duration); }
  bool avoid_ros_namespace_conventions() const { return profile_.avoid_ros_namespace_conventions; }
  /// How many messages wait at most; 0: as many as there is room for.
  std::size_t polyarm_depth() const {
    return profile_.history == RMW_QOS_POLICY_HISTORY_KEEP_ALL ? 0 : profile_.depth > 0 ? profile_.depth : 1;
  }
  std::size_t depth() const { return profile_.depth; }
  bool polyarm_reliable() const { return profile_.reliability != RMW_QOS_POLICY_RELIABILITY_BEST_EFFORT; }
  bool polyarm_transient_local() const {
    return profile_.durability == RMW_QOS_POLICY_DURABILITY_TRANSIENT_LOCAL;
  }
  const rmw_qos_profile_t& get_rmw_qos_profile() const { return profile_; }
  rmw_qos_profile_t& get_rmw_qos_profile() { return profile_; }

 private:
  static Duration span_of(const rmw_time_t& time) {
    return Duration::from_nanoseconds(static_cast<std::int64_t>(time.sec * 1'000'000'000 + time.nsec));
  }
  rmw_qos_profile_t profile_;
};
inline bool operator==(const QoS& a, const QoS& b) {
  return a.history() == b.history() && a.depth() == b.depth() && a.reliability() == b.reliability() &&
         a.durability() == b.durability() && a.liveliness() == b.liveliness() &&
         a.deadline() == b.deadline() && a.lifespan() == b.lifespan() &&
         a.liveliness_lease_duration() == b.liveliness_lease_duration() &&
         a.avoid_ros_namespace_conventions() == b.avoid_ros_namespace_conventions();
}
inline bool operator!=(const QoS& a, const QoS& b) {
  return !(a == b);
}

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
