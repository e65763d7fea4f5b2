/// All that cells have on the wire, as clients of both middlewares see it, against the list that the names
/// and types of ROS 2 give; each service asked, each topic heard, and goals sent by each of them.
#include "tests/ros2/rmw_fast.hpp"
#include "tests/ros2/ros2_cell.hpp"

#if defined(POLYARM_CYCLONE) && defined(POLYARM_RMW_FAST)
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <map>

#include "tests/ros2/endpoints.hpp"
#include "tests/ros2/example.hpp"

namespace polyarm::ros2 {
namespace {

using test::Endpoints;
using test::RawCyclone;
using test::RmwNode;
using test::Wanted;

/// Discovery of a domain by both.
void expect_on_the_wire(std::uint32_t domain, const Wanted& wanted) {
  test::FastDiscovery of_fast;
  RmwNode node(domain, RmwNode::Range::localhost, &of_fast);
  RawCyclone cyclone(domain);
  test::CycloneDiscovery of_cyclone(cyclone.cyclone());
  wait([&] { return of_fast.seen() == wanted.all && of_cyclone.seen() == wanted.all; }, 10);
  EXPECT_EQ(test::difference(wanted.all, of_fast.seen()), "") << "as a node on Fast DDS sees it";
  EXPECT_EQ(test::difference(wanted.all, of_cyclone.seen()), "") << "as a node on Cyclone DDS sees it";
}

/// The UR5e of Ros2Cell.
Wanted arm() {
  Wanted out;
  out.cell(false).state_broadcaster("/joint_state_broadcaster").trajectory_controller("/arm_controller");
  out.controller("/forward").hears("/forward/commands", "std_msgs/msg/Float64MultiArray");
  out.hears("/forward/command", "std_msgs/msg/Float64");
  return out;
}

TEST_F(Ros2Cell, HasOnTheWireWhatTheListSays) {
  expect_on_the_wire(domain_, arm());
}

TEST(Ros2Example, R6botHasOnTheWireWhatTheListSays) {
  test::Example example("r6bot");
  Wanted wanted;
  wanted.cell(false).state_broadcaster("/joint_state_broadcaster");
  wanted.controller("/r6bot_controller")
      .hears("/r6bot_controller/joint_trajectory", "trajectory_msgs/msg/JointTrajectory");
  expect_on_the_wire(example.domain(), wanted);
}

TEST(Ros2Example, JetbotHasOnTheWireWhatTheListSays) {
  test::Example example("jetbot");
  const std::string base = "/jetbot_base_controller";
  Wanted wanted;
  wanted.cell(false).state_broadcaster("/joint_state_broadcaster").controller(base);
  for (const std::string& topic : {base + "/cmd_vel", std::string("/cmd_vel")})
    wanted.hears(topic, "geometry_msgs/msg/TwistStamped", false);
  wanted.publishes(base + "/odom", "nav_msgs/msg/Odometry").publishes("/odom", "nav_msgs/msg/Odometry");
  wanted.publishes("/tf", "tf2_msgs/msg/TFMessage");
  wanted.publishes(base + "/cmd_vel_out", "geometry_msgs/msg/TwistStamped");
  wanted.hears(base + "/cmd_vel_unstamped", "geometry_msgs/msg/Twist", false);
  wanted.hears(base + "/set_odometry", "std_msgs/msg/Float64MultiArray");
  wanted.serves(base + "/set_odometry", "control_msgs/srv/SetOdometry");
  wanted.serves(base + "/reset_odometry", "std_srvs/srv/Empty");
  expect_on_the_wire(example.domain(), wanted);
}

/// The types in which a topic of the jetbot is read, while others publish on it.
class ReadTypes : public ::testing::Test {
 protected:
  using Types = std::set<std::string>;
  bool become(const test::Example& example, const std::string& topic, const Types& wanted) {
    if (!cyclone_) cyclone_.emplace(example.domain()), readers_.emplace(*cyclone_);
    const bool became = wait([&] { return readers_->types(topic) == wanted; }, 10);
    if (!became)
      for (const std::string& type : readers_->types(topic)) ADD_FAILURE() << topic << " is read as " << type;
    return became;
  }
  const Types stamped{"geometry_msgs::msg::dds_::TwistStamped_"}, plain{"geometry_msgs::msg::dds_::Twist_"};
  const Types both{*stamped.begin(), *plain.begin()};
  std::optional<test::Cyclone> cyclone_;
  std::optional<test::CycloneReaders> readers_;
};

/// `ros2 topic echo /cmd_vel` and `ros2 bag record -a` refuse a topic of two types.
TEST_F(ReadTypes, OfATwistAreThoseThatOthersPublish) {
  const test::Example example("jetbot");
  ASSERT_TRUE(become(example, "rt/cmd_vel", stamped)) << "the current type, while nobody publishes";
  {
    RmwNode other(example.domain(), RmwNode::Range::localhost);
    other.writer("rt/cmd_vel", *plain.begin());
    EXPECT_TRUE(become(example, "rt/cmd_vel", plain));
    EXPECT_EQ(readers_->types("rt/jetbot_base_controller/cmd_vel"), stamped) << "each topic for itself";
    RmwNode third(example.domain(), RmwNode::Range::localhost);
    third.writer("rt/cmd_vel", *stamped.begin());
    EXPECT_TRUE(become(example, "rt/cmd_vel", both)) << "each that is published is heard";
  }
  EXPECT_TRUE(become(example, "rt/cmd_vel", stamped)) << "as before, when they have left";
  const test::Cyclone cyclone(example.domain());
  cyclone.writer(geometry_msgs_msg_dds__Twist__desc, "rt/cmd_vel");
  EXPECT_TRUE(become(example, "rt/cmd_vel", plain)) << "of the other middleware, too";
}

/// Fast DDS ignores how Cyclone announces a departure: that of a publisher whose node stays was never noticed.
TEST_F(ReadTypes, OfATwistEndWithAPublisherOnCycloneWhoseNodeStays) {
  const test::Example example("jetbot");
  const test::Cyclone cyclone(example.domain());
  const dds_entity_t publisher = cyclone.writer(geometry_msgs_msg_dds__Twist__desc, "rt/cmd_vel");
  ASSERT_TRUE(become(example, "rt/cmd_vel", plain));
  dds_delete(publisher);
  EXPECT_TRUE(become(example, "rt/cmd_vel", stamped));
}

TEST_F(ReadTypes, OfATwistAreBothWhereTheCellSaysSo) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::temp_directory_path() / ("polyarm_ros2_both_" + std::to_string(::getpid()));
  fs::copy(std::string(POLYARM_SOURCE_DIR) + "/examples/jetbot", folder, fs::copy_options::recursive);
  std::ofstream(folder / "cell.yaml", std::ios::app) << "ros2: {cmd_vel: both}\n";
  {
    const test::Example example(folder.string());
    EXPECT_TRUE(become(example, "rt/cmd_vel", both));
  }
  fs::remove_all(folder);
}

TEST(Ros2Example, PickAndPlaceHasOnTheWireWhatTheListSays) {
  test::Example example("pick_and_place");
  Wanted wanted;
  wanted.cell(true).state_broadcaster("/joint_state_broadcaster");
  wanted.trajectory_controller("/joint_trajectory_controller");
  wanted.controller("/io").hears("/io/commands", "std_msgs/msg/Float64MultiArray");
  wanted.hears("/io/command", "std_msgs/msg/Float64");
  expect_on_the_wire(example.domain(), wanted);
}

/// What a service is asked, and whether its answer is the right one.
struct Question {
  json request;
  std::function<bool(const json& answer)> right;
};

/// By the end of the service's name. Nothing of it changes the cell.
std::map<std::string, Question> questions() {
  const auto ok_is = [](const char* field, bool wanted) {
    return [field, wanted](const json& answer) { return answer[field] == wanted; };
  };
  const auto any = [](const char* list, const char* field, const json& value) {
    return [list, field, value](const json& answer) {
      return std::any_of(answer[list].begin(), answer[list].end(),
                         [&](const json& each) { return each[field] == value; });
    };
  };
  const json sim{"use_sim_time"}, set = {{"parameters", {{{"name", "no_such"}, {"value", {{"type", 2}}}}}}};
  return {
      {"list_parameters",
       {{},
        [](const json& a) {
          return std::count(a["result"]["names"].begin(), a["result"]["names"].end(), "use_sim_time") == 1;
        }}},
      {"get_parameters", {{{"names", sim}}, [](const json& a) { return a["values"][0]["type"] == 1; }}},
      {"get_parameter_types", {{{"names", sim}}, [](const json& a) { return a["types"] == json{1}; }}},
      {"describe_parameters", {{{"names", sim}}, any("descriptors", "name", "use_sim_time")}},
      {"set_parameters", {set, any("results", "successful", false)}},
      {"set_parameters_atomically", {set, [](const json& a) { return a["result"]["successful"] == false; }}},
      {"get_type_description", {{{"type_name", "std_msgs/msg/String"}}, ok_is("successful", true)}},
      {"get_state", {{}, [](const json& a) { return a["current_state"]["id"].get<int>() >= 2; }}},
      {"change_state", {{{"transition", {{"id", 77}}}}, ok_is("success", false)}},
      {"get_available_states", {{}, any("available_states", "label", "errorprocessing")}},
      {"get_available_transitions", {{}, [](const json& a) { return !a["available_transitions"].empty(); }}},
      {"get_transition_graph", {{}, [](const json& a) { return a["available_transitions"].size() == 16; }}},
      {"query_state", {{}, ok_is("success", false)}},  // nothing is under way
      {"send_goal",
       {{{"goal", {{"trajectory", {{"joint_names", {"no_joint"}}}}}}}, ok_is("accepted", false)}},
      {"get_result", {{{"goal_id", id(99)}}, [](const json& a) { return a["status"] == 0; }}},
      {"cancel_goal",
       {{{"goal_info", {{"goal_id", id(99)}}}}, [](const json& a) { return a["return_code"] == 2; }}},
      {"stop", {{}, ok_is("success", true)}},
      {"hold", {{}, ok_is("success", true)}},
      {"resume", {{}, ok_is("success", true)}},
      {"discard", {{}, [](const json& a) { return a["success"].is_boolean(); }}},
      {"recover", {{}, [](const json& a) { return a["success"].is_boolean(); }}},
      {"list_controllers", {{}, any("controller", "name", "arm_controller")}},
      {"list_controller_types",
       {{},
        [](const json& a) {
          return a["types"].size() > 10 && a["types"].size() == a["base_classes"].size();
        }}},
      {"list_hardware_components", {{}, any("component", "type", "system")}},
      {"list_hardware_interfaces", {{}, any("command_interfaces", "name", "elbow_joint/position")}},
      {"load_controller", {{{"name", "nothing"}}, ok_is("ok", false)}},
      {"configure_controller", {{{"name", "nothing"}}, ok_is("ok", false)}},
      {"cleanup_controller", {{{"name", "nothing"}}, ok_is("ok", false)}},
      {"unload_controller", {{{"name", "nothing"}}, ok_is("ok", false)}},
      {"switch_controller", {{}, ok_is("ok", true)}},
      {"set_hardware_component_state", {{{"name", "nothing"}}, ok_is("ok", false)}},
      {"reload_controller_libraries", {{}, ok_is("ok", false)}},
  };
}

/// Asks by either client, whose class has the same functions.
template <class Client>
json ask(Client& client, const Wanted::Service& service, const json& request) {
  const messages::TypeInfo& asked = *messages::find_type(service.type + "_Request");
  const messages::TypeInfo& answered = *messages::find_type(service.type + "_Response");
  typename Client::Caller caller(client, service.name, test::dds_name(asked.name),
                                 test::dds_name(answered.name));
  EXPECT_TRUE(wait([&] { return caller.ready(); })) << service.name;
  caller.ask(messages::from_json(asked, request));
  std::optional<std::vector<std::byte>> payload;
  wait([&] { return (payload = caller.answer()).has_value(); }, 10);
  EXPECT_TRUE(payload.has_value()) << service.name;
  json out;
  if (payload) {
    EXPECT_EQ(messages::to_json(answered, *payload, out), messages::CdrError::none) << service.name;
  }
  return out;
}

TEST_F(Ros2Cell, EachServiceAnswersAClientOfEachMiddleware) {
  RmwNode fast(domain_, RmwNode::Range::localhost);
  RawCyclone cyclone(domain_);
  const auto table = questions();
  for (const Wanted::Service& service : arm().services) {
    SCOPED_TRACE(service.name);
    const auto question = table.find(service.name.substr(service.name.rfind('/') + 1));
    ASSERT_NE(question, table.end()) << "nobody has written a question";
    const json of_fast = ask(fast, service, question->second.request);
    EXPECT_TRUE(question->second.right(of_fast)) << of_fast;
    const json of_cyclone = ask(cyclone, service, question->second.request);
    EXPECT_TRUE(question->second.right(of_cyclone)) << of_cyclone;
  }
}

/// What makes rare messages come: a parameter, a life cycle, and a goal.
void stir(Client& client) {
  client.call("/arm_controller/set_parameters", "rcl_interfaces/srv/SetParameters",
              {{"parameters",
                {{{"name", "constraints.goal_time"}, {"value", {{"type", 3}, {"double_value", 3.0}}}}}}});
  for (const auto& [on, off] :
       {std::pair{"forward", "arm_controller"}, std::pair{"arm_controller", "forward"}})
    client.call("/controller_manager/switch_controller", "controller_manager_msgs/srv/SwitchController",
                {{"activate_controllers", {on}}, {"deactivate_controllers", {off}}, {"strictness", 2}});
  client.call("/joint_state_broadcaster/change_state", "lifecycle_msgs/srv/ChangeState",
              {{"transition", {{"label", "deactivate"}}}});
  client.call("/joint_state_broadcaster/change_state", "lifecycle_msgs/srv/ChangeState",
              {{"transition", {{"label", "activate"}}}});
  client.call(kAction + "send_goal", kType + "_SendGoal", {{"goal_id", id(1)}, {"goal", goal_to(0.3, 0.5)}});
}

TEST_F(Ros2Cell, EachTopicIsHeardByAClientOfEachMiddleware) {
  RmwNode fast(domain_, RmwNode::Range::localhost);
  RawCyclone cyclone(domain_);
  struct Heard {
    std::string topic;
    const messages::TypeInfo* type;
    eprosima::fastdds::dds::DataReader* fast;
    dds_entity_t cyclone;
    bool by_fast = false, by_cyclone = false;
  };
  std::map<std::string, std::string> types;  // of DDS → ROS
  for (const messages::TypeInfo* type : messages::types()) types[type->dds_name] = type->name;
  std::map<std::string, Heard> topics;
  for (const test::Endpoint& e : arm().all)
    if (e.writes && (e.topic.starts_with("rt/") || e.topic == "ros_discovery_info") &&
        !topics.contains(e.topic))
      topics[e.topic] = {e.topic, messages::find_type(types.at(e.type)),
                         fast.reader(e.topic, e.type, e.latched), cyclone.reader(e.topic, e.type, e.latched)};
  ASSERT_GE(topics.size(), 15u);
  const auto listened_to = [&](const Heard& each) {
    eprosima::fastdds::dds::SubscriptionMatchedStatus by_fast;
    dds_subscription_matched_status_t by_cyclone;
    each.fast->get_subscription_matched_status(by_fast);
    dds_get_subscription_matched_status(each.cyclone, &by_cyclone);
    return by_fast.current_count > 0 && by_cyclone.current_count > 0;
  };
  ASSERT_TRUE(wait([&] {
    return std::all_of(topics.begin(), topics.end(),
                       [&](const auto& each) { return listened_to(each.second); });
  }));
  const auto readable = [](const messages::TypeInfo& type, const std::vector<std::byte>& payload) {
    json message;
    return messages::to_json(type, payload, message) == messages::CdrError::none;
  };
  const auto all_heard = [&] {
    bool all = true;
    for (auto& [name, each] : topics) {
      if (const auto payload = RmwNode::take(*each.fast)) each.by_fast |= readable(*each.type, *payload);
      if (const auto payload = RawCyclone::take(each.cyclone))
        each.by_cyclone |= readable(*each.type, *payload);
      all = all && each.by_fast && each.by_cyclone;
    }
    return all;
  };
  // The other side may know of this reader later than this reader of it.
  for (int round = 0; round < 10 && !wait(all_heard, 2); ++round) stir(*client_);
  for (const auto& [name, each] : topics) {
    EXPECT_TRUE(each.by_fast) << name;
    EXPECT_TRUE(each.by_cyclone) << name;
  }
}

/// Goals from beginning to end: the one that is ended by its client, and the one that gets there.
template <class Client>
void send_goals(Client& client, int first) {
  const auto call = [&](const char* name, const std::string& type, const json& request) {
    return ask(client, {kAction + name, type}, request);
  };
  const auto send = [&](int number, const json& goal) {
    return call("send_goal", kType + "_SendGoal", {{"goal_id", id(number)}, {"goal", goal}})["accepted"];
  };
  const auto result = [&](int number) {
    return call("get_result", kType + "_GetResult", {{"goal_id", id(number)}});
  };
  EXPECT_EQ(send(first, goal_to(1.0, 20)), true);
  const json cancelled =
      call("cancel_goal", "action_msgs/srv/CancelGoal", {{"goal_info", {{"goal_id", id(first)}}}});
  EXPECT_EQ(cancelled["return_code"], 0);
  EXPECT_EQ(cancelled["goals_canceling"].size(), 1u);
  EXPECT_EQ(result(first)["status"], 5);
  EXPECT_EQ(send(first + 1, goal_to(0.1, 0.5)), true);
  const json reached = result(first + 1);
  EXPECT_EQ(reached["status"], 4);
  EXPECT_EQ(reached["result"]["error_code"], 0);
  const json none = call("cancel_goal", "action_msgs/srv/CancelGoal", json::object());
  EXPECT_EQ(none["return_code"], 0) << "to cancel all where there are none is not a fault";
  EXPECT_TRUE(none["goals_canceling"].empty());
}

TEST_F(Ros2Cell, EachMiddlewaresClientSendsCancelsAndIsTold) {
  RmwNode fast(domain_, RmwNode::Range::localhost);
  RawCyclone cyclone(domain_);
  send_goals(fast, 10);
  send_goals(cyclone, 20);
}

}  // namespace
}  // namespace polyarm::ros2
#endif
