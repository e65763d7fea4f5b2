/// From simulation to the arm on its wire and back, asked for over the pendant's port.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "drivers/feetech/family.hpp"
#include "tests/servos/arm_on_a_wire.hpp"
#include "tests/support/web_peer.hpp"

namespace polyarm {
namespace {

using test::ArmOnAWire;
using Json = nlohmann::json;
using test::WebPeer;

/// The command with a pendant, and a client that holds control.
class Connect : public ::testing::Test {
 protected:
  void begin() {
    ::setenv("XDG_RUNTIME_DIR", arm.copy.path().c_str(), 1);
    cell.emplace(std::vector<std::string>{"run", arm.copy.path(), "--pendant", "--port", "0", "--no-socket"});
    const std::string line = cell->line_with("pendant: http://localhost:");
    ASSERT_NE(line, "");
    const std::string link = line.substr(line.find("http://localhost:") + 17);
    client.emplace(static_cast<std::uint16_t>(std::stoi(link)));
    std::string token = link.substr(link.find("token=") + 6);
    token = token.substr(0, token.find_first_of(" \r\n"));
    ASSERT_EQ(client->upgrade({"Authorization: Bearer " + token}), 101);
    ask({{"request", "session.hello"}, {"name", "test"}});
    ASSERT_TRUE(ask({{"request", "session.take"}, {"force", true}})["result"]["you_hold"]);
    ASSERT_TRUE(status_is([](const Json& s) { return s["simulated"] == true; }));
  }
  Json ask(Json request) {
    request["id"] = ++last_;
    client->send(request);
    until([&] { return !client->answer(last_).is_null(); });
    return client->answer(last_);
  }
  bool until(const std::function<bool()>& done) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (!done() && std::chrono::steady_clock::now() < end && client->listen(20)) client->take();
    return done();
  }
  bool status_is(const std::function<bool(const Json&)>& is) {
    return until([&] {
      const Json status = client->event("status");
      return status.contains("simulated") && is(status);
    });
  }
  int servo(const servo_bus::Register& reg) { return arm.bus.get(5, reg); }

  ArmOnAWire arm;
  const servo_bus::Family& family = feetech::sts_family();
  std::optional<test::Command> cell;
  std::optional<WebPeer> client;
  int last_ = 0;
};

TEST_F(Connect, ComesUpHeldAndDisarmedAndMovesNothingBeforeAPersonLetsIt) {
  begin();
  const Json seen = ask({{"request", "cell.connect"}})["result"];
  ASSERT_EQ(seen["hardware"].size(), 1u) << seen;
  EXPECT_EQ(seen["hardware"][0]["driver"], "feetech");
  EXPECT_EQ(seen["hardware"][0]["devices"][0]["path"], arm.bus.path()) << seen;
  EXPECT_EQ(seen["possible"], true);
  EXPECT_EQ(arm.bus.instructions(), 0u) << "who looks touches nothing";

  ASSERT_EQ(ask({{"request", "cell.connect"}, {"real", true}})["result"]["asked"], "real");
  ASSERT_TRUE(status_is([](const Json& s) { return s["simulated"] == false && s["state"] == "held"; }));
  EXPECT_EQ(client->event("status")["armed"], false);
  EXPECT_EQ(servo(family.torque), 0);
  EXPECT_EQ(ask({{"request", "cell.connect"}, {"real", true}})["error"]["code"], "connected-already");

  EXPECT_EQ(ask({{"request", "control.arm"}})["result"]["joints"].size(), 6u);
  EXPECT_EQ(servo(family.torque), 0) << "comparing arms nothing";
  ASSERT_EQ(ask({{"request", "control.arm"}, {"confirmed", true}})["ok"], true);
  ASSERT_TRUE(arm.bus.wait(5, family.torque, [](int value) { return value == 1; }));
  ASSERT_TRUE(arm.bus.wait_for_instructions(arm.bus.instructions() + 300));
  EXPECT_EQ(servo(family.present_position), 2048) << "it is held";

  EXPECT_EQ(ask({{"request", "control.resume"}})["ok"], true);
  ASSERT_TRUE(status_is([](const Json& s) { return s["state"] == "running"; }));
  ASSERT_TRUE(ask({{"request", "cell.connect"}, {"real", false}})["ok"]);
  EXPECT_TRUE(status_is([](const Json& s) { return s["simulated"] == true && s["state"] == "running"; }));
}

TEST_F(Connect, WhatIsNotPluggedInIsSaidInOneSentenceAndTheSimulationGoesOn) {
  test::change(arm.copy, arm.bus.path(), "/dev/ttyNone7");
  begin();
  const Json seen = ask({{"request", "cell.connect"}})["result"];
  EXPECT_EQ(seen["possible"], false);
  const Json refused = ask({{"request", "cell.connect"}, {"real", true}});
  EXPECT_EQ(refused["error"]["code"], "no-device");
  EXPECT_EQ(refused["error"]["what"], seen["why"]);
  EXPECT_NE(seen["why"].get<std::string>().find("'/dev/ttyNone7' does not exist"), std::string::npos) << seen;
  EXPECT_EQ(client->event("status")["simulated"], true);
}

TEST_F(Connect, HardwareThatDoesNotAnswerLeavesTheCellSimulated) {
  test::change(arm.copy, "answer_timeout_ms: 500", "answer_timeout_ms: 20");
  begin();
  arm.bus.cut_off();
  ASSERT_EQ(ask({{"request", "cell.connect"}, {"real", true}})["ok"], true);
  ASSERT_TRUE(until([&] {
    for (const Json& event : client->events)
      if (event.dump().find("the cell is simulated again") != std::string::npos) return true;
    return false;
  }));
  EXPECT_TRUE(status_is([](const Json& s) { return s["simulated"] == true && s["state"] == "running"; }));
  const auto tells_why = [](const Json& event) {
    return event["event"] == "log" && event.dump().find("servo 1 on") != std::string::npos;
  };
  EXPECT_TRUE(std::any_of(client->events.begin(), client->events.end(), tells_why)) << Json(client->events);
}

TEST_F(Connect, ACellThatNamesNoRealHardwareSaysWhereToNameIt) {
  test::change(arm.copy, "hardware: feetech", "hardware: feetech_fake");
  begin();
  const Json refused = ask({{"request", "cell.connect"}, {"real", true}})["error"];
  EXPECT_EQ(refused["code"], "no-real-hardware");
  EXPECT_EQ(refused["what"], "the cell names no real hardware: 'arm' is 'feetech_fake'");
}

}  // namespace
}  // namespace polyarm
