#include "polyarm/recording/live_view.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <map>

#include "tests/recording/demo.hpp"

namespace polyarm::recording {
namespace {

using test::Demo;
using test::Json;

TEST(LiveView, TellsWatchersWhatTheCellDoesAndGivesNoOtherFiles) {
  Demo demo;
  test::LockStepCell bench(demo.file());
  FoxgloveServer server{{"demo", "9.9", "1", true, 8}};
  auto view = std::make_unique<LiveView>(bench.cell().view(), server);
  const auto client = server.connect();
  std::map<std::string, std::uint32_t> ids;
  std::vector<std::string> binary;
  Json parameters, asset;
  const auto read = [&] {
    while (const auto out = client->next()) {
      if (out->binary) {
        binary.push_back(*out->body);
        continue;
      }
      const Json message = Json::parse(*out->body);
      if (message["op"] == "advertise")
        for (const Json& each : message["channels"]) ids[each["topic"]] = each["id"];
      if (message["op"] == "parameterValues") parameters = message["parameters"];
    }
  };
  read();
  ASSERT_TRUE(ids.contains("/joint_states") && ids.contains("/tags/Lamp") &&
              ids.contains("/robot_description"));
  Json subscriptions = Json::array();
  for (const char* topic : {"/joint_states", "/tags/Lamp", "/robot_description"})
    subscriptions.push_back({{"id", ids[topic] + 100}, {"channelId", ids[topic]}});
  client->take_text(Json{{"op", "subscribe"}, {"subscriptions", subscriptions}}.dump());
  client->take_text(Json{{"op", "getParameters"}, {"parameterNames", {"robot_description"}}}.dump());
  std::map<std::uint32_t, int> count;
  for (int i = 0; i < 500; ++i) {
    view->serve();
    bench.tick();
    read();
  }
  for (const std::string& message : binary)
    if (message[0] == 1) {
      std::uint32_t subscription;
      std::memcpy(&subscription, message.data() + 1, 4);
      ++count[subscription];
    }
  EXPECT_NEAR(count[ids["/joint_states"] + 100], 50, 2) << "50 a second";
  EXPECT_GE(count[ids["/tags/Lamp"] + 100], 1);
  EXPECT_EQ(count[ids["/robot_description"] + 100], 1);
  EXPECT_NE(parameters[0]["value"].get<std::string>().find("<robot"), std::string::npos);
  view.reset();
  EXPECT_EQ(server.clients(), 1u);
}

}  // namespace
}  // namespace polyarm::recording
