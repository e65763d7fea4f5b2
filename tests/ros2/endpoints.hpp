#pragma once
/// What is on the wire, as clients of both middlewares are told by its discovery, and what should be, by the
/// names and types of ROS 2.
#include <mutex>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/messages/type_info.hpp"
#include "tests/ros2/raw_cyclone.hpp"
#include "tests/ros2/rmw_fast.hpp"

namespace polyarm::ros2::test {

/// One endpoint of one node.
struct Endpoint {
  std::string topic, type;  ///< of DDS
  bool writes = false, reliable = true, latched = false;
  std::string hash;  ///< "RIHS01_…"
  auto operator<=>(const Endpoint&) const = default;
};
using Endpoints = std::multiset<Endpoint>;

inline std::string text_of(const Endpoint& e) {
  return std::string(e.writes ? "writes " : "reads ") + e.topic + " " + e.type +
         (e.reliable ? "" : " best effort") + (e.latched ? " transient local" : "") + " " + e.hash;
}
/// What stands in one and not in the other.
inline std::string difference(const Endpoints& wanted, const Endpoints& seen) {
  std::string out;
  Endpoints missing = wanted, more = seen;
  for (const Endpoint& e : seen)
    if (const auto at = missing.find(e); at != missing.end()) missing.erase(at);
  for (const Endpoint& e : wanted)
    if (const auto at = more.find(e); at != more.end()) more.erase(at);
  for (const Endpoint& e : missing) out += "missing: " + text_of(e) + "\n";
  for (const Endpoint& e : more) out += "not expected: " + text_of(e) + "\n";
  return out;
}

inline std::string hash_in(const std::string& user_data) {
  const std::size_t at = user_data.find("typehash=");
  return at == std::string::npos ? "" : user_data.substr(at + 9, user_data.find(';', at) - at - 9);
}

/// "sensor_msgs/msg/JointState" is "sensor_msgs::msg::dds_::JointState_" there.
inline std::string dds_name(const std::string& type) {
  const std::size_t first = type.find('/'), last = type.rfind('/');
  return type.substr(0, first) + "::" + type.substr(first + 1, last - first - 1) +
         "::dds_::" + type.substr(last + 1) + "_";
}

/// The endpoints that nodes of ROS 2 have, by what they are for.
class Wanted {
 public:
  Endpoints all;

  Wanted& publishes(const std::string& topic, const std::string& type, bool latched = false) {
    return add("rt" + topic, type, true, true, latched);
  }
  Wanted& hears(const std::string& topic, const std::string& type, bool reliable = true) {
    return add("rt" + topic, type, false, reliable, false);
  }
  Wanted& serves(const std::string& service, const std::string& type) {
    services.push_back({service, type});
    add("rq" + service + "Request", type + "_Request", false, true, false);
    return add("rr" + service + "Reply", type + "_Response", true, true, false);
  }
  Wanted& acts(const std::string& action, const std::string& type) {
    const std::string base = action + "/_action/";
    serves(base + "send_goal", type + "_SendGoal").serves(base + "get_result", type + "_GetResult");
    serves(base + "cancel_goal", "action_msgs/srv/CancelGoal");
    publishes(base + "feedback", type + "_FeedbackMessage");
    return publishes(base + "status", "action_msgs/msg/GoalStatusArray", true);
  }
  /// What every node has.
  Wanted& node(const std::string& name) {
    const std::pair<const char*, const char*> parameters[] = {
        {"list_parameters", "ListParameters"},
        {"get_parameters", "GetParameters"},
        {"get_parameter_types", "GetParameterTypes"},
        {"describe_parameters", "DescribeParameters"},
        {"set_parameters", "SetParameters"},
        {"set_parameters_atomically", "SetParametersAtomically"}};
    for (const auto& [service, type] : parameters)
      serves(name + "/" + service, std::string("rcl_interfaces/srv/") + type);
    serves(name + "/get_type_description", "type_description_interfaces/srv/GetTypeDescription");
    return publishes("/parameter_events", "rcl_interfaces/msg/ParameterEvent");
  }
  Wanted& controller(const std::string& name) {
    node(name);
    const std::pair<const char*, const char*> life[] = {
        {"get_state", "GetState"},
        {"change_state", "ChangeState"},
        {"get_available_states", "GetAvailableStates"},
        {"get_available_transitions", "GetAvailableTransitions"},
        {"get_transition_graph", "GetAvailableTransitions"}};
    for (const auto& [service, type] : life)
      serves(name + "/" + service, std::string("lifecycle_msgs/srv/") + type);
    return publishes(name + "/transition_event", "lifecycle_msgs/msg/TransitionEvent");
  }
  Wanted& trajectory_controller(const std::string& name) {
    controller(name).hears(name + "/joint_trajectory", "trajectory_msgs/msg/JointTrajectory");
    hears(name + "/command", "trajectory_msgs/msg/JointTrajectory");
    hears(name + "/speed_scaling_input", "control_msgs/msg/SpeedScalingFactor");
    publishes(name + "/controller_state", "control_msgs/msg/JointTrajectoryControllerState");
    serves(name + "/query_state", "control_msgs/srv/QueryTrajectoryState");
    return acts(name + "/follow_joint_trajectory", "control_msgs/action/FollowJointTrajectory");
  }
  Wanted& state_broadcaster(const std::string& name) {
    return controller(name)
        .publishes("/joint_states", "sensor_msgs/msg/JointState")
        .publishes("/dynamic_joint_states", "control_msgs/msg/DynamicJointState");
  }
  /// What every cell has.
  Wanted& cell(bool program) {
    add("ros_discovery_info", "rmw_dds_common/msg/ParticipantEntitiesInfo", true, true, true);
    node("/robot_state_publisher").publishes("/tf", "tf2_msgs/msg/TFMessage");
    publishes("/tf_static", "tf2_msgs/msg/TFMessage", true);
    publishes("/robot_description", "std_msgs/msg/String", true);
    node("/polyarm").publishes("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray");
    publishes("/rosout", "rcl_interfaces/msg/Log", true);
    for (const char* verb : {"stop", "hold", "resume", "discard", "recover"})
      serves(std::string("/polyarm/") + verb, "std_srvs/srv/Trigger");
    if (program)
      for (const char* verb : {"start", "pause", "stop"})
        serves(std::string("/polyarm/program/") + verb, "std_srvs/srv/Trigger");
    node("/controller_manager");
    publishes("/controller_manager/activity", "controller_manager_msgs/msg/ControllerManagerActivity", true);
    for (const char* type :
         {"ListControllers", "ListControllerTypes", "ListHardwareComponents", "ListHardwareInterfaces",
          "LoadController", "ConfigureController", "CleanupController", "UnloadController",
          "SwitchController", "SetHardwareComponentState", "ReloadControllerLibraries"})
      serves("/controller_manager/" + snake(type), std::string("controller_manager_msgs/srv/") + type);
    return *this;
  }

  struct Service {
    std::string name, type;
  };
  std::vector<Service> services;

 private:
  /// "ListControllers" is "list_controllers".
  static std::string snake(const std::string& type) {
    std::string out;
    for (const char c : type) {
      if (std::isupper(static_cast<unsigned char>(c)) && !out.empty()) out += '_';
      out += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
    return out;
  }
  Wanted& add(const std::string& topic, const std::string& type, bool writes, bool reliable, bool latched) {
    const messages::TypeInfo* info = messages::find_type(type);
    all.insert({topic, dds_name(type), writes, reliable, latched, info ? info->hash : "no such type"});
    return *this;
  }
};

#ifdef POLYARM_RMW_FAST
/// As a node on Fast DDS is told.
class FastDiscovery : public dds::DomainParticipantListener {
 public:
  Endpoints seen() const {
    const std::lock_guard lock(mutex_);
    return seen_;
  }

 private:
  using Writer = fast::WriterDiscoveryInfo;
  using Reader = fast::ReaderDiscoveryInfo;
  void on_publisher_discovery(dds::DomainParticipant*, Writer&& info) override {
    if (info.status == Writer::DISCOVERED_WRITER) add(info.info, true);
  }
  void on_subscriber_discovery(dds::DomainParticipant*, Reader&& info) override {
    if (info.status == Reader::DISCOVERED_READER) add(info.info, false);
  }
  template <class Info>
  void add(const Info& info, bool writes) {
    const auto& user = info.m_qos.m_userData.data_vec();
    const std::lock_guard lock(mutex_);
    seen_.insert({info.topicName().to_string(), info.typeName().to_string(), writes,
                  info.m_qos.m_reliability.kind == dds::RELIABLE_RELIABILITY_QOS,
                  info.m_qos.m_durability.kind == dds::TRANSIENT_LOCAL_DURABILITY_QOS,
                  hash_in({user.begin(), user.end()})});
  }
  mutable std::mutex mutex_;
  Endpoints seen_;
};
#endif

/// As a node on Cyclone DDS is told.
class CycloneDiscovery {
 public:
  explicit CycloneDiscovery(const Cyclone& cyclone) {
    for (const auto& [topic, writes] : {std::pair{DDS_BUILTIN_TOPIC_DCPSPUBLICATION, true},
                                        std::pair{DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION, false}})
      readers_.push_back({dds_create_reader(cyclone.participant(), topic, nullptr, nullptr), writes});
  }
  Endpoints seen() {
    for (const auto& [reader, writes] : readers_)
      while (test::take<dds_builtintopic_endpoint_t>(
          reader, [&, writes = writes](const auto& e) { add(e, writes); })) {
      }
    return seen_;
  }

 private:
  void add(const dds_builtintopic_endpoint_t& e, bool writes) {
    if (std::string_view(e.topic_name).starts_with("DCPS")) return;  // of Cyclone itself
    dds_reliability_kind_t reliability{};
    dds_durability_kind_t durability{};
    dds_duration_t blocking{};
    dds_qget_reliability(e.qos, &reliability, &blocking);
    dds_qget_durability(e.qos, &durability);
    void* data = nullptr;
    size_t size = 0;
    dds_qget_userdata(e.qos, &data, &size);
    const std::string user = data ? std::string(static_cast<const char*>(data), size) : "";
    dds_free(data);
    seen_.insert({e.topic_name, e.type_name, writes, reliability == DDS_RELIABILITY_RELIABLE,
                  durability == DDS_DURABILITY_TRANSIENT_LOCAL, hash_in(user)});
  }
  std::vector<std::pair<dds_entity_t, bool>> readers_;
  Endpoints seen_;
};

/// Who reads what at the moment, as a node on Cyclone DDS knows it.
class CycloneReaders {
 public:
  explicit CycloneReaders(const Cyclone& cyclone)
      : reader_{
            dds_create_reader(cyclone.participant(), DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION, nullptr, nullptr)} {}
  /// The types in which a topic is read, as DDS calls both.
  std::set<std::string> types(const std::string& topic) const {
    constexpr std::uint32_t kAlive = DDS_ANY_SAMPLE_STATE | DDS_ANY_VIEW_STATE | DDS_ALIVE_INSTANCE_STATE;
    std::vector<void*> samples(kMost, nullptr);
    std::vector<dds_sample_info_t> infos(kMost);
    const auto count = dds_read_mask(reader_, samples.data(), infos.data(), kMost, kMost, kAlive);
    std::set<std::string> out;
    for (int i = 0; i < count; ++i) {
      const auto& e = *static_cast<const dds_builtintopic_endpoint_t*>(samples[static_cast<std::size_t>(i)]);
      if (e.topic_name == topic) out.insert(e.type_name);
    }
    if (count > 0) dds_return_loan(reader_, samples.data(), count);
    return out;
  }

 private:
  static constexpr std::uint32_t kMost = 1000;
  dds_entity_t reader_;
};

}  // namespace polyarm::ros2::test
