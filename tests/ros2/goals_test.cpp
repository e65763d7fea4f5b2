/// What becomes of goals, as ROS 2's clients are told; and simulated time, namespaces, queries.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "tests/ros2/own_cell.hpp"
#include "tests/ros2/ros2_cell.hpp"

namespace polyarm::ros2 {
namespace {

json send_to(Client& client, int number, const json& goal) {
  return client.call(kAction + "send_goal", kType + "_SendGoal", {{"goal_id", id(number)}, {"goal", goal}});
}
json result_of(Client& client, int number) {
  return client.call(kAction + "get_result", kType + "_GetResult", {{"goal_id", id(number)}});
}
bool change(Client& client, const std::vector<std::string>& on, const std::vector<std::string>& off) {
  return client
      .call("/controller_manager/switch_controller", kManager + "SwitchController",
            {{"activate_controllers", on}, {"deactivate_controllers", off}, {"strictness", 2}})["ok"]
      .get<bool>();
}

/// A client knows of its goal only when it has the answer: what it heard of its status before is lost to it.
TEST_F(Ros2Cell, TheStatusOfAGoalIsToldAgainToWhoHasItsAnswer) {
  const auto status = client_->listen(kAction + "status", "action_msgs/GoalStatusArray", {true, true, 1});
  ASSERT_EQ(send_to(*client_, 1, goal_to(0.5, 30))["accepted"], true);
  ASSERT_TRUE(wait([&] { return status->heard() && !status->latest()["status_list"].empty(); }));
  const std::size_t before = status->count();
  ASSERT_TRUE(wait([&] { return status->count() > before; })) << "while the goal goes on";
  EXPECT_EQ(status->latest()["status_list"][0]["status"], 2);
}

TEST_F(Ros2Cell, AGoalForAControllerThatIsNotActiveIsRefusedAndNotDoneLater) {
  const auto joints = client_->listen("/joint_states", "sensor_msgs/JointState");
  const auto log = client_->listen("/rosout", "rcl_interfaces/Log", {true, true, 1000});
  ASSERT_TRUE(change(*client_, {}, {"arm_controller"}));
  EXPECT_EQ(send_to(*client_, 1, goal_to(0.5, 1))["accepted"], false);
  ASSERT_TRUE(wait([&] {
    for (const json& line : log->since(0))
      if (line["msg"].get<std::string>().find("is inactive and takes no messages") != std::string::npos)
        return true;
    return false;
  })) << "the reason is told";
  ASSERT_TRUE(wait([&] { return joints->heard(); }));
  const json before = joints->latest()["position"];
  ASSERT_TRUE(change(*client_, {"arm_controller"}, {}));
  const std::size_t count = joints->count();
  ASSERT_TRUE(wait([&] { return joints->count() > count + 200; }));
  EXPECT_EQ(joints->latest()["position"], before);
}

/// A goal at the very moment of a switch is answered, and where it was taken, its end is told.
TEST_F(Ros2Cell, GoalsAmidSwitchesAreAllAnswered) {
  Client other(domain_);
  for (int i = 0; i < 12; ++i) {
    std::thread switching([&] {
      change(other, {}, {"arm_controller"});
      change(other, {"arm_controller"}, {});
    });
    const json sent = send_to(*client_, i, goal_to(0.1 * (i % 3), 0.3));
    switching.join();
    if (!sent["accepted"].get<bool>()) continue;
    const json result = result_of(*client_, i);
    EXPECT_TRUE(result["status"] == 4 || result["status"] == 6) << result;
  }
}

TEST_F(Ros2Cell, WhyAGoalEndedIsSaid) {
  ASSERT_EQ(send_to(*client_, 1, goal_to(1.0, 20))["accepted"], true);
  ASSERT_EQ(send_to(*client_, 2, goal_to(0.5, 20))["accepted"], true);
  const json preempted = result_of(*client_, 1);
  EXPECT_EQ(preempted["status"], 6);
  EXPECT_EQ(preempted["result"]["error_code"], -1);
  EXPECT_NE(preempted["result"]["error_string"].get<std::string>().find("another goal took its place"),
            std::string::npos)
      << preempted;
  ASSERT_TRUE(change(*client_, {}, {"arm_controller"}));
  const json deactivated = result_of(*client_, 2);
  EXPECT_EQ(deactivated["status"], 6);
  EXPECT_NE(deactivated["result"]["error_string"].get<std::string>().find("not active any more"),
            std::string::npos)
      << deactivated;
}

/// Twenty times a second, by the stamps of what it tells.
TEST_F(Ros2Cell, FeedbackComesAsOftenAsFromRos2Control) {
  const auto feedback = client_->listen(kAction + "feedback", kType + "_FeedbackMessage");
  ASSERT_EQ(send_to(*client_, 1, goal_to(1.0, 3))["accepted"], true);
  ASSERT_EQ(result_of(*client_, 1)["status"], 4);
  std::vector<double> between;
  double last = 0;
  for (const json& each : feedback->since(0)) {
    const json& stamp = each["feedback"]["header"]["stamp"];
    const double now = stamp["sec"].get<double>() + 1e-9 * stamp["nanosec"].get<double>();
    if (last > 0) between.push_back(now - last);
    last = now;
    EXPECT_EQ(each["feedback"]["desired"]["positions"].size(), 6u);
    EXPECT_EQ(each["feedback"]["error"]["positions"].size(), 6u);
  }
  ASSERT_GT(between.size(), 20u);
  std::nth_element(between.begin(), between.begin() + 10, between.end());
  EXPECT_NEAR(between[10], 0.05, 0.0045);
}

TEST_F(Ros2Cell, WhereATrajectoryWillBeCanBeAsked) {
  const auto ask = [&](const json& time) {
    return client_->call("/arm_controller/query_state", "control_msgs/srv/QueryTrajectoryState",
                         {{"time", time}});
  };
  const auto joints = client_->listen("/joint_states", "sensor_msgs/JointState");
  ASSERT_TRUE(wait([&] { return joints->heard(); }));
  EXPECT_FALSE(ask(json::object())["success"].get<bool>()) << "nothing is under way";
  const double from = joints->latest()["position"][0];
  ASSERT_EQ(send_to(*client_, 1, goal_to(from + 1.0, 20))["accepted"], true);
  json stamp = joints->latest()["header"]["stamp"];
  stamp["sec"] = stamp["sec"].get<int>() + 10;
  const json half = ask(stamp);
  ASSERT_TRUE(half["success"].get<bool>()) << half;
  EXPECT_EQ(half["name"].size(), 6u);
  EXPECT_EQ(half["name"][0], "shoulder_pan_joint");
  EXPECT_GT(half["position"][0].get<double>(), from + 0.3);
  EXPECT_LT(half["position"][0].get<double>(), from + 0.7);
  EXPECT_GT(half["velocity"][0].get<double>(), 0.01);
  stamp["sec"] = stamp["sec"].get<int>() + 100;
  const json late = ask(stamp);
  EXPECT_FALSE(late["success"].get<bool>());
  EXPECT_NE(late["message"], "");
}

/// Its joint stays at 0 whatever it is told, so that tolerances are hurt.
const char* const kLazy = R"(<robot name="lazy">
  <link name="base_link"/><link name="upper"/>
  <joint name="shoulder" type="revolute"><parent link="base_link"/><child link="upper"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" velocity="2" effort="1"/></joint>
  <ros2_control name="lazy" type="system">
    <hardware><plugin>mock_components/GenericSystem</plugin></hardware>
    <joint name="shoulder"><command_interface name="position"/><state_interface name="position"/><state_interface name="velocity"/></joint>
  </ros2_control></robot>)";

TEST(Ros2Goals, TolerancesOfAGoalAreKeptAndToldInItsResult) {
  test::OwnCell cell(
      test::OwnCell::Files{
          {"cell.yaml",
           "polyarm: cell/1\nrate: 200\nrobots:\n  lazy: {model: lazy.urdf, hardware: declared}\n"
           "controllers: controllers.yaml\n"},
          {"lazy.urdf", kLazy},
          {"controllers.yaml",
           "controller_manager:\n  ros__parameters:\n"
           "    arm_controller: {type: joint_trajectory_controller/JointTrajectoryController}\n"
           "arm_controller:\n  ros__parameters: {joints: [shoulder], command_interfaces: "
           "[position], state_interfaces: [position, velocity]}\n"}},
      {"--fault", "lazy/shoulder/position=0"});
  Client& client = *cell.client;
  const auto goal = [](double to, const char* kind, double tolerance, double time) {
    json out{{"trajectory",
              {{"joint_names", {"shoulder"}},
               {"points", json::array({{{"positions", {to}}, {"time_from_start", 0.5}}})}}},
             {"goal_time_tolerance", time}};
    if (*kind) out[kind] = json::array({{{"name", "shoulder"}, {"position", tolerance}}});
    return out;
  };
  ASSERT_EQ(send_to(client, 1, goal(0.2, "", 0, 0))["accepted"], true);
  EXPECT_EQ(result_of(client, 1)["result"]["error_code"], 0) << "nobody minds";
  ASSERT_EQ(send_to(client, 2, goal(0.4, "goal_tolerance", 0.01, 0.2))["accepted"], true);
  const json late = result_of(client, 2);
  EXPECT_EQ(late["status"], 6);
  EXPECT_EQ(late["result"]["error_code"], -5) << late;
  const std::string why = late["result"]["error_string"];
  for (const char* part : {"GOAL_TOLERANCE_VIOLATED", "shoulder", "0.01"})
    EXPECT_NE(why.find(part), std::string::npos) << why;
  ASSERT_EQ(send_to(client, 3, goal(0.6, "path_tolerance", 0.05, 0))["accepted"], true);
  EXPECT_EQ(result_of(client, 3)["result"]["error_code"], -4);
  ASSERT_EQ(send_to(client, 4, goal(0.2, "goal_tolerance", 0.3, 0.2))["accepted"], true);
  EXPECT_EQ(result_of(client, 4)["status"], 4);
}

TEST(Ros2Time, InLockStepStampsAreThoseOfTheClock) {
  test::OwnCell cell(
      test::OwnCell::Files{
          {"cell.yaml",
           "polyarm: cell/1\nrate: 500\nrobots:\n  arm: {model: universal_robots/ur5e, hardware: mock}\n"}},
      {"--fast", "--seconds", "100000"});
  const auto clock = cell.client->listen("/clock", "rosgraph_msgs/Clock", {false, false, 1});
  const auto joints = cell.client->listen("/joint_states", "sensor_msgs/JointState", {false, false, 5});
  ASSERT_TRUE(wait([&] { return clock->count() > 100 && joints->count() > 10; }));
  const auto time = [](const json& stamp) {
    return stamp["sec"].get<double>() + 1e-9 * stamp["nanosec"].get<double>();
  };
  double last = -1;
  for (const json& tick : clock->since(0)) {
    EXPECT_GT(time(tick["clock"]), last) << "it never goes back";
    last = time(tick["clock"]);
  }
  EXPECT_LT(last, 200'000) << "it counts from the start of the cell";
  const json state = joints->latest();
  EXPECT_LE(time(state["header"]["stamp"]), time(clock->latest()["clock"]));
  const json asked = cell.call("/controller_manager/get_parameters", "rcl_interfaces/srv/GetParameters",
                               {{"names", {"use_sim_time"}}});
  EXPECT_EQ(asked["values"][0]["bool_value"], true);
}

TEST(Ros2Names, ANamespaceStandsBeforeEveryName) {
  test::OwnCell cell(test::OwnCell::Files{
      {"cell.yaml",
       "polyarm: cell/1\nrate: 500\nrobots:\n  arm: {model: universal_robots/ur5e, hardware: mock}\n"
       "ros2: {namespace: line/one}\n"}});
  const auto joints = cell.client->listen("/line/one/joint_states", "sensor_msgs/JointState");
  const auto description =
      cell.client->listen("/line/one/robot_description", "std_msgs/String", {true, true, 1});
  EXPECT_TRUE(wait([&] { return joints->heard() && description->heard(); }));
  const json listed =
      cell.call("/line/one/controller_manager/list_controllers", kManager + "ListControllers");
  EXPECT_EQ(listed["controller"].size(), 2u);
  std::mutex mutex;
  std::set<std::string> spaces;
  const auto& type = *messages::find_type("rmw_dds_common/msg/ParticipantEntitiesInfo");
  Participant& wire = cell.client->participant();
  const auto reader =
      wire.add_reader("ros_discovery_info", type.dds_name, {true, true, 1}, "", [&](const Sample& sample) {
        json info;
        if (messages::to_json(type, sample.payload, info) != messages::CdrError::none) return;
        const std::lock_guard lock(mutex);
        spaces.clear();
        for (const json& node : info["node_entities_info_seq"]) spaces.insert(node["node_namespace"]);
      });
  EXPECT_TRUE(wait([&] {
    const std::lock_guard lock(mutex);
    return spaces == std::set<std::string>{"/line/one"};
  }));
  wire.remove(reader);
}

/// As the spawner of Jazzy does it: what it sets, several files one over the other, and in which states.
TEST_F(Ros2Cell, ASpawnerSetsAllThatItSetsAndLaterFilesHaveTheLastWord) {
  std::ofstream(folder_ / "first.yaml")
      << "/**:\n  ros__parameters: {interface_name: velocity}\nsecond:\n  ros__parameters: {type: "
         "forward_command_controller/ForwardCommandController, joints: [elbow_joint]}\n";
  std::ofstream(folder_ / "last.yaml")
      << "/second:\n  ros__parameters: {joints: [wrist_1_joint], interface_name: position}\n";
  const auto set = [&](const std::string& name, const std::vector<std::string>& values) {
    return call("/controller_manager/set_parameters", "rcl_interfaces/srv/SetParameters",
                {{"parameters",
                  {{{"name", name},
                    {"value", {{"type", 9}, {"string_array_value", values}}}}}}})["results"][0]["successful"]
        .get<bool>();
  };
  EXPECT_TRUE(set("second.node_options_args", {"--ros-args", "-r", "a:=b"}));
  EXPECT_TRUE(set("second.fallback_controllers", {"forward"}));
  EXPECT_TRUE(
      set("second.params_file", {(folder_ / "first.yaml").string(), (folder_ / "last.yaml").string()}));
  EXPECT_FALSE(set("second.no_such", {"x"}));
  ASSERT_TRUE(
      call("/controller_manager/load_controller", kManager + "LoadController", {{"name", "second"}})["ok"]
          .get<bool>());
  EXPECT_EQ(states()["second"], "unconfigured") << "loaded is not configured";
  ASSERT_TRUE(call("/controller_manager/configure_controller", kManager + "ConfigureController",
                   {{"name", "second"}})["ok"]
                  .get<bool>());
  EXPECT_EQ(states()["second"], "inactive");
  const json values = call("/second/get_parameters", "rcl_interfaces/srv/GetParameters",
                           {{"names", {"joints", "interface_name"}}})["values"];
  EXPECT_EQ(values[0]["string_array_value"], json{"wrist_1_joint"});
  EXPECT_EQ(values[1]["string_value"], "position");
}

TEST_F(Ros2Cell, ListsOfParametersHaveDepthsAndPrefixes) {
  const auto names = [&](const json& prefixes, int depth) {
    return call("/arm_controller/list_parameters", "rcl_interfaces/srv/ListParameters",
                {{"prefixes", prefixes}, {"depth", depth}})["result"];
  };
  const auto has = [](const json& list, const char* name) {
    return std::count(list.begin(), list.end(), name) == 1;
  };
  const json all = names(json::array(), 0), top = names(json::array(), 1);
  EXPECT_TRUE(has(all["names"], "constraints.elbow_joint.goal"));
  EXPECT_TRUE(has(all["prefixes"], "constraints.elbow_joint"));
  EXPECT_TRUE(has(top["names"], "joints"));
  EXPECT_FALSE(has(top["names"], "constraints.goal_time")) << "it is two deep";
  const json below = names({"constraints"}, 1);
  EXPECT_TRUE(has(below["names"], "constraints.goal_time"));
  EXPECT_FALSE(has(below["names"], "constraints.elbow_joint.goal"));
  EXPECT_FALSE(has(below["names"], "joints"));
}

TEST_F(Ros2Cell, ChangesOfParametersAndLifeCyclesAreTold) {
  const auto events = client_->listen("/parameter_events", "rcl_interfaces/ParameterEvent");
  const auto changes = client_->listen("/forward/transition_event", "lifecycle_msgs/TransitionEvent");
  const auto set = [&](double value) {
    return call("/arm_controller/set_parameters_atomically", "rcl_interfaces/srv/SetParametersAtomically",
                {{"parameters",
                  {{{"name", "constraints.goal_time"},
                    {"value", {{"type", 3}, {"double_value", value}}}}}}})["result"]["successful"];
  };
  ASSERT_TRUE(wait([&] {
    EXPECT_EQ(set(1.5), true);
    return events->heard();
  }));
  const json event = events->latest();
  EXPECT_EQ(event["node"], "/arm_controller");
  EXPECT_EQ(event["changed_parameters"][0]["name"], "constraints.goal_time");
  EXPECT_EQ(event["changed_parameters"][0]["value"]["double_value"], 1.5);
  ASSERT_TRUE(wait([&] {
    change(*client_, {"forward"}, {"arm_controller"});
    change(*client_, {"arm_controller"}, {"forward"});
    return changes->count() >= 4;
  }));
  const auto told = changes->since(0);
  std::set<int> ids;
  for (const json& each : told) ids.insert(each["transition"]["id"].get<int>());
  for (const int id : {3, 30, 4, 40}) EXPECT_TRUE(ids.contains(id)) << id;
}

TEST_F(Ros2Cell, ATextThatIsNoUtf8IsAnsweredLikeAnyOther) {
  EXPECT_FALSE(call("/controller_manager/load_controller", kManager + "LoadController",
                    {{"name", std::string("\xff\xfe\x80")}})["ok"]
                   .get<bool>());
  EXPECT_FALSE(change(*client_, {std::string("\xc3(")}, {}));
  json goal = goal_to(0.5, 1);
  goal["trajectory"]["joint_names"][0] = std::string("\xf0\x28\x8c\x28");
  EXPECT_EQ(send_to(*client_, 1, goal)["accepted"], false);
  EXPECT_EQ(states()["arm_controller"], "active");
}

/// Nothing at work is taken away unless it is said; then everything is.
TEST_F(Ros2Cell, LibrariesAreLoadedAnewWhenNothingIsActiveOrItIsForced) {
  const auto reload = [&](bool force) {
    return call("/controller_manager/reload_controller_libraries", kManager + "ReloadControllerLibraries",
                {{"force_kill", force}})["ok"]
        .get<bool>();
  };
  EXPECT_FALSE(reload(false));
  EXPECT_EQ(states()["arm_controller"], "active");
  EXPECT_TRUE(reload(true));
  EXPECT_TRUE(states().empty());
}

}  // namespace
}  // namespace polyarm::ros2
