#include <memory>
#include <random>
#include <set>

#include "polyarm/base/bounds.hpp"
#include "polyarm/protocol/controllers.hpp"
#include "polyarm/protocol/messages.hpp"
#include "polyarm/protocol/reference.hpp"
#include "tests/cell/requests_cell.hpp"

namespace polyarm {
namespace {

using test::error_of;
using test::FailingMock;
using test::Json;
using test::kSharedJoint;
using test::LockStepCell;
using test::RequestsTest;
using test::what_of;

Json trajectory(double to, double seconds) {
  return {{"joint_names", {"joint_1", "joint_2"}},
          {"points", {{{"positions", {to, -to}}, {"time_from_start", seconds}}}}};
}

TEST_F(RequestsTest, EveryRowHasASentenceAndAnswersSomething) {
  std::set<std::string> names;
  for (const protocol::HelpRow& row : protocol::help_rows()) {
    EXPECT_TRUE(names.insert(row.request).second) << row.request << " stands twice";
    EXPECT_GT(row.text.size(), 8u) << row.request;
    EXPECT_GT(row.result.size(), 1u) << row.request;
    const auto answers = cell.give(Json{{"request", row.request}});
    cell.tick();
    for (int more = 0; answers->empty() && more < 10'000; ++more) {  // some go to the cell's worker
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      cell.tick();
    }
    EXPECT_FALSE(answers->empty()) << row.request;
  }
  EXPECT_EQ(names.size(), cell.result({{"request", "help"}}).size());
}

TEST_F(RequestsTest, WrongRequestsAreAnsweredWithASentence) {
  EXPECT_EQ(error_of(cell.ask({{"request", "control.lst"}})), "unknown-request");
  EXPECT_NE(what_of(cell.ask({{"request", "control.lst"}})).find("did you mean 'control.list'"),
            std::string::npos);
  EXPECT_NE(
      what_of(cell.ask({{"request", "control.switch"}, {"activat", "tail"}})).find("did you mean 'activate'"),
      std::string::npos);
  EXPECT_NE(what_of(cell.ask({{"request", "control.unload"}})).find("needs 'name'"), std::string::npos);
  EXPECT_NE(
      what_of(cell.ask({{"request", "watch"}, {"name", 3}})).find("'name' of watch is not of type text"),
      std::string::npos);
  EXPECT_EQ(error_of(cell.ask({{"request", "control.unload"}, {"name", "tial"}})), "unknown-controller");
  for (const char* line :
       {"", "[]", "7", "\"control.list\"", "{", "{\"request\":", "{\"request\":null}", "\x01\xff"}) {
    const auto answers = cell.give(std::string(line));
    ASSERT_EQ(answers->size(), 1u) << line;
    EXPECT_FALSE(answers->front()["ok"].get<bool>());
  }
}

/// As the door of ROS 2 asks: neither side is printed and parsed.
TEST_F(RequestsTest, AskersInThisProcessGiveAndGetStructs) {
  std::vector<protocol::Reply> replies;
  const auto keep = [&](const protocol::Reply& reply) {
    replies.push_back(reply);
    return true;
  };
  cell.cell().requests().ask(protocol::ControlList{}, keep);
  cell.cell().requests().ask(protocol::ControlUnload{"nothing"}, keep);
  cell.tick();
  ASSERT_EQ(replies.size(), 2u);
  EXPECT_FALSE(replies[0].answer->as<protocol::ControlList>().empty());
  EXPECT_EQ(replies[1].refusal->problems().front().code, "unknown-controller");
}

TEST_F(RequestsTest, LargeRequestsOfThisProcessCountTowardsTheBound) {
  std::vector<protocol::Reply> replies;
  const auto keep = [&](const protocol::Reply& reply) {
    replies.push_back(reply);
    return true;
  };
  cell.cell().requests().ask(protocol::ControlList{}, keep, nullptr, bounds::kOpenRequestBytes + 1);
  cell.tick();
  ASSERT_EQ(replies.size(), 1u);
  ASSERT_TRUE(replies[0].refusal);
  EXPECT_EQ(replies[0].refusal->problems().front().code, "busy");
}

/// Texts from the network may be no UTF-8: that is a message that cannot be read, not a fault of the cell.
TEST_F(RequestsTest, TextsThatAreNoUtf8AreAnsweredInWords) {
  Json message = trajectory(0.1, 1);
  message["joint_names"] = {"joint_1", "\xff\xfe"};
  protocol::SendMessage request;
  request.to = "follow";
  request.message = protocol::Message(message);
  std::vector<protocol::Reply> replies;
  cell.cell().requests().ask(request, [&](const protocol::Reply& reply) {
    replies.push_back(reply);
    return true;
  });
  for (int i = 0; replies.empty() && i < 100; ++i) cell.tick();
  ASSERT_EQ(replies.size(), 1u);
  ASSERT_TRUE(replies[0].refusal);
  const Problem& problem = replies[0].refusal->problems().front();
  EXPECT_NE(problem.code, "internal") << problem.what;
}

TEST(StreamedCommands, ThatStopComingAreToldOnceAndSeen) {
  std::string controllers = kSharedJoint;
  controllers.replace(controllers.find("    interface_name: position"), 28,
                      "    interface_name: position\n    command_timeout: 0.2");
  LockStepCell cell{controllers};
  const auto stale = [&cell] {
    for (const Json& c : cell.result({{"request", "control.list"}}))
      if (c["name"] == "tail") return c["stale"].get<bool>();
    return false;
  };
  cell.ask({{"request", "control.switch"},
            {"activate", "tail"},
            {"deactivate", "tail_too"},
            {"strictness", "best_effort"}});
  ASSERT_EQ(cell.state_of("tail"), "active");
  cell.run(1);
  EXPECT_FALSE(stale());
  const auto send = [&cell] {
    EXPECT_TRUE(cell.ask({{"request", "send"}, {"to", "tail/commands"}, {"message", {0.1, 0.1}}})["ok"]);
  };
  send();
  cell.run(0.1);
  EXPECT_FALSE(stale());
  cell.run(2);
  EXPECT_TRUE(stale());
  EXPECT_EQ(cell.told("the controller tail receives nothing new"), 1);
  EXPECT_EQ(cell.result({{"request", "health"}})["state"], "running") << "the cell goes on";
  send();
  cell.run(0.02);
  EXPECT_FALSE(stale());
}

TEST_F(RequestsTest, AnIdComesBack) {
  EXPECT_EQ(cell.ask({{"request", "health"}, {"id", {1, "a"}}})["id"], Json({1, "a"}));
  EXPECT_EQ(cell.ask({{"request", "nothing"}, {"id", 7}})["id"], 7);
}

TEST_F(RequestsTest, DeepNestingIsRefusedAndDoesNotExhaustTheStack) {
  for (const std::string& open : {std::string("["), std::string("{\"a\":")}) {
    std::string deep;
    for (int i = 0; i < 200'000; ++i) deep += open;
    const auto answers = cell.give("{\"request\":\"health\",\"id\":" + deep);
    ASSERT_EQ(answers->size(), 1u);
    EXPECT_EQ(error_of(answers->front()), "bad-request");
  }
  std::string closed =
      "{\"request\":\"health\",\"id\":" + std::string(1000, '[') + std::string(1000, ']') + "}";
  EXPECT_EQ(error_of(cell.give(closed)->front()), "bad-request");
  // Brackets in a text are no nesting.
  EXPECT_TRUE(cell.ask({{"request", "health"}, {"id", std::string(200, '[')}})["ok"].get<bool>());
}

TEST_F(RequestsTest, RandomRequestsAreAnsweredAndBreakNothing) {
  std::mt19937 random(20);
  const std::vector<std::string> words = {
      "request", "name",       "activate", "deactivate", "follow", "tail",       "state",    "rate",
      "goal",    "to",         "message",  "values",     "dry",    "nan",        "-1",       "1e308",
      "active",  "strictness", "type",     "file",       "key",    "parameters", "inactive", "joint_states"};
  const auto word = [&] { return words[random() % words.size()]; };
  const auto value = [&]() -> Json {
    switch (random() % 7) {
      case 0:
        return word();
      case 1:
        return 1e300 * (static_cast<double>(random() % 3) - 1);
      case 2:
        return nullptr;
      case 3:
        return random() % 2 == 0;
      case 4:
        return {word(), word()};
      case 5:
        return {{word(), word()}};
      default:
        return static_cast<int>(random() % 5) - 2;
    }
  };
  const auto table = protocol::help_rows();
  for (int n = 0; n < 4000; ++n) {
    const protocol::HelpRow& row = table[random() % table.size()];
    Json request{{"request", row.request}};
    for (const protocol::HelpArgument& a : row.arguments)
      if (random() % 5) request[a.name] = random() % 3 ? Json(word()) : value();
    if (random() % 10 == 0) request[word()] = value();
    std::string line = request.dump();
    if (random() % 5 == 0) line[random() % line.size()] = static_cast<char>(random() % 256);
    bool answered = false;
    cell.cell().requests().handle(line, [&](const std::string&) {
      answered = true;
      return false;  // nobody listens on
    });
    if (n % 4 == 0) cell.tick();
  }
  EXPECT_TRUE(cell.ask({{"request", "control.list"}})["ok"].get<bool>());
}

TEST(RequestsOutside, AFaultEndsARunThatWorksTowardsAnEndButNotACellThatWaitsForOthers) {
  for (const bool outside : {false, true}) {
    LockStepCell cell(kSharedJoint, outside);
    const std::string name = cell.result({{"request", "hardware.list"}})[0]["name"];
    FailingMock::fails = true;
    cell.run(0.02);
    FailingMock::fails = false;
    EXPECT_EQ(cell.result({{"request", "health"}})["state"], "fault");
    EXPECT_EQ(cell.cell().failure().has_value(), !outside);
    if (!outside) continue;
    EXPECT_EQ(cell.result({{"request", "hardware.recover"}, {"name", name}})["state"], "active");
    cell.result({{"request", "control.recover"}});
    const Json started = cell.ask({{"request", "control.switch"}, {"activate", {"follow", "tail"}}});
    EXPECT_TRUE(started["ok"].get<bool>())
        << started << cell.result({{"request", "hardware.list"}})[0]["state"]
        << cell.result({{"request", "health"}})["cause"];
    cell.result({{"request", "control.resume"}});
    EXPECT_TRUE(
        cell.ask({{"request", "send"}, {"to", "tail"}, {"message", "data: [0.1, 0.1]"}})["ok"].get<bool>());
    cell.run(1);
    EXPECT_NEAR(cell.value_of("states", "arm/joint_6/position"), 0.1, 1e-9);
    FailingMock::fails = true;  // and again
    cell.run(0.02);
    FailingMock::fails = false;
    EXPECT_EQ(cell.result({{"request", "hardware.recover"}, {"name", name}})["fallen"].size(), 2u);
  }
}

TEST(RequestsOutside, ALongMessageIsReadBesideTheTick) {
  LockStepCell cell(kSharedJoint, true);
  Json points = Json::array();
  for (int i = 1; i <= 2000; ++i)
    points.push_back({{"positions", {1e-4 * i, 0}}, {"time_from_start", 0.001 * i}});
  const auto answers =
      cell.give(Json{{"request", "send"},
                     {"to", "follow"},
                     {"message", {{"joint_names", {"joint_1", "joint_2"}}, {"points", points}}}});
  for (int ticks = 0; ticks < 10'000'000 && answers->empty(); ++ticks) cell.tick();
  ASSERT_EQ(answers->size(), 1u);
  EXPECT_TRUE(answers->front()["ok"].get<bool>()) << answers->front();
  cell.run(3);
  EXPECT_NEAR(cell.value_of("states", "arm/joint_1/position"), 0.2, 1e-6);
}

TEST_F(RequestsTest, AMessageMovesTheJoints) {
  EXPECT_EQ(cell.result({{"request", "send"}, {"to", "tail"}, {"message", {{"data", {0.25, -0.5}}}}})["to"],
            "tail/commands");
  cell.run(1);
  EXPECT_NEAR(cell.value_of("states", "arm/joint_5/position"), 0.25, 1e-9);
  EXPECT_NEAR(cell.value_of("states", "arm/joint_6/position"), -0.5, 1e-9);
  // As text in YAML, as ROS 1 has it, to a topic.
  EXPECT_TRUE(cell.ask({{"request", "send"}, {"to", "/tail/commands"}, {"message", "data: [0.1, 0.2]"}})["ok"]
                  .get<bool>());
  cell.run(1);
  EXPECT_NEAR(cell.value_of("states", "arm/joint_6/position"), 0.2, 1e-9);
}

TEST_F(RequestsTest, NamesOfRosLeadToControllers) {
  const auto goes_to = [&](const std::string& to) {
    const Json answer = cell.ask({{"request", "send"}, {"to", to}, {"message", trajectory(0.1, 1)}});
    return answer["ok"].get<bool>() ? answer["result"].value("to", "") : what_of(answer);
  };
  EXPECT_EQ(goes_to("follow"), "follow/joint_trajectory");
  EXPECT_EQ(goes_to("follow/joint_trajectory"), "follow/joint_trajectory");
  EXPECT_EQ(goes_to("/follow/joint_trajectory"), "follow/joint_trajectory");
  EXPECT_EQ(goes_to("/MyRobot/follow/command"), "follow/command");
  EXPECT_EQ(goes_to("/joint_trajectory"), "follow/joint_trajectory");
  EXPECT_NE(goes_to("/folow/joint_trajectory").find("did you mean 'follow/joint_trajectory'"),
            std::string::npos);
  EXPECT_EQ(error_of(cell.ask({{"request", "send"}, {"to", "/commands"}, {"message", "data: [1]"}})),
            "which-controller");
  EXPECT_EQ(error_of(cell.ask({{"request", "send"}, {"to", ""}, {"message", "data: [1]"}})), "unknown-name");
}

TEST_F(RequestsTest, WhoIsNotActiveTakesNoMessages) {
  const Json answer = cell.ask({{"request", "send"}, {"to", "tail_too"}, {"message", "data: [0.1]"}});
  EXPECT_EQ(error_of(answer), "not-active");
  EXPECT_NE(answer["error"]["advice"].get<std::string>().find("polyarm control state tail_too active"),
            std::string::npos);
}

TEST_F(RequestsTest, AGoalIsAcceptedFollowedAndFinished) {
  const auto answers =
      cell.give(Json{{"request", "send"}, {"to", "follow"}, {"message", trajectory(0.3, 1)}, {"goal", true}});
  cell.run(1.2);
  ASSERT_GE(answers->size(), 5u);
  EXPECT_EQ(answers->front()["result"]["status"], "accepted");
  int feedback = 0;
  for (const Json& answer : *answers)
    if (answer["result"].contains("feedback")) {
      ++feedback;
      EXPECT_TRUE(answer["more"].get<bool>());
      EXPECT_TRUE(answer["result"]["feedback"]["error"]["positions"].is_array());
    }
  EXPECT_NEAR(feedback, 20, 3);  // twenty times a second, as from ros2_control
  EXPECT_EQ(answers->back()["result"]["status"], "succeeded");
  EXPECT_EQ(answers->back()["result"]["error_code"], 0);
  EXPECT_FALSE(answers->back().contains("more"));
  EXPECT_NEAR(cell.value_of("states", "arm/joint_2/position"), -0.3, 1e-6);
}

TEST_F(RequestsTest, ItIsToldWhereATrajectoryWillBe) {
  const auto ask = [&](Json request) {
    request["request"] = "query";
    request["name"] = "follow";
    const auto answers = cell.give(std::move(request));
    cell.run(0.01);
    return answers->empty() ? Json() : answers->back();
  };
  EXPECT_EQ(ask(Json::object())["error"]["code"], "no-trajectory") << "nothing is under way";
  cell.give(Json{{"request", "send"}, {"to", "follow"}, {"message", trajectory(0.3, 1)}, {"goal", true}});
  cell.run(0.2);
  const double now = seconds(cell.cell().now());
  const Json soon = ask({{"at", now + 0.4}})["result"];
  const Json at_once = ask(Json::object())["result"];
  ASSERT_EQ(soon["joints"].size(), soon["position"].size());
  const auto moved = [](const Json& sample) {
    double out = 0;
    for (const Json& position : sample["position"]) out = std::max(out, std::abs(position.get<double>()));
    return out;
  };
  EXPECT_GT(moved(soon), moved(at_once) + 0.05);
  cell.run(0.4 - 0.02);
  EXPECT_NEAR(moved(ask(Json::object())["result"]), moved(soon), 0.01) << "it is where it was foretold";
  EXPECT_EQ(ask({{"at", now + 5}})["error"]["code"], "no-trajectory") << "it is over by then";
  cell.run(2);
  EXPECT_EQ(ask({{"name", "follow"}})["error"]["code"], "no-trajectory");
}

TEST_F(RequestsTest, AGoalIsCanceled) {
  const auto answers =
      cell.give(Json{{"request", "send"}, {"to", "follow"}, {"message", trajectory(1, 5)}, {"goal", true}});
  cell.run(0.5);
  const Json goal = answers->front()["result"]["goal"];
  EXPECT_TRUE(cell.ask({{"request", "goal.cancel"}, {"to", "follow"}, {"goal", goal}})["ok"].get<bool>());
  cell.run(0.2);
  EXPECT_EQ(answers->back()["result"]["status"], "canceled") << answers->back();
  EXPECT_EQ(answers->back()["result"]["error_code"], 0);
  EXPECT_EQ(error_of(cell.ask({{"request", "goal.cancel"}, {"to", "follow"}, {"goal", 99}})), "no-goal");
  EXPECT_EQ(error_of(cell.ask({{"request", "goal.cancel"}, {"to", "follow"}, {"goal", -1.5}})), "no-goal");
}

TEST_F(RequestsTest, ABadGoalIsRefusedAtOnce) {
  Json wrong = trajectory(0.1, 1);
  wrong["joint_names"][1] = "joint_9";
  EXPECT_FALSE(cell.ask({{"request", "send"}, {"to", "follow"}, {"message", wrong}, {"goal", true}})["ok"]
                   .get<bool>());
  EXPECT_EQ(
      error_of(cell.ask({{"request", "send"}, {"to", "tail"}, {"message", "data: [1, 2]"}, {"goal", true}})),
      "no-action");
}

TEST_F(RequestsTest, AWatchGoesOnAtItsRateUntilNobodyListens) {
  cell.run(0.05);
  const auto answers = cell.give(Json{{"request", "watch"}, {"name", "joint_states"}, {"rate", 20}});
  cell.run(1);
  EXPECT_NEAR(static_cast<double>(answers->size()), 20, 2);
  const Json& message = answers->back()["result"];
  ASSERT_EQ(message["name"].size(), 6u);
  EXPECT_EQ(message["name"][0], "joint_1");
  EXPECT_EQ(message["position"].size(), 6u);
  EXPECT_TRUE(message["effort"][0].is_null()) << "no number is null";
  EXPECT_TRUE(message["header"]["stamp"].contains("nanosec"));
  EXPECT_EQ(cell.cell().requests().open(), 1u);
  int seen = 0;
  cell.cell().requests().handle(R"({"request":"watch","name":"joint_states"})",
                                [&](const std::string&) { return ++seen < 3; });
  cell.run(1);
  EXPECT_EQ(seen, 3);
  EXPECT_EQ(cell.cell().requests().open(), 1u);
  EXPECT_EQ(error_of(cell.ask({{"request", "watch"}, {"name", "joint_states"}, {"rate", 0}})),
            "bad-argument");
  EXPECT_EQ(error_of(cell.ask({{"request", "watch"}, {"name", "joint_sates"}})), "unknown-name");
}

TEST_F(RequestsTest, TwoWatchersAndAGoalSeeTheSameMessages) {
  cell.run(0.05);
  const Json request{{"request", "watch"}, {"name", "follow/controller_state"}, {"rate", 20}};
  const auto one = cell.give(request), two = cell.give(request);
  const auto goal =
      cell.give(Json{{"request", "send"}, {"to", "follow"}, {"message", trajectory(0.3, 1)}, {"goal", true}});
  cell.run(1.2);
  EXPECT_EQ(one->size(), two->size());
  EXPECT_NEAR(static_cast<double>(one->size()), 24, 3);
  EXPECT_GE(goal->size(), 8u) << "its feedback does not go to the watchers";
}

TEST_F(RequestsTest, AnswersOfOneAskerComeInOrderAndAStopPasses) {
  const int me = 0, other = 0;
  std::vector<std::string> order;
  const auto give = [&](const Json& request, const std::string& name, const void* from) {
    cell.cell().requests().handle(
        request.dump(),
        [&order, name](const std::string&) {
          order.push_back(name);
          return true;
        },
        from);
  };
  give({{"request", "control.switch"}, {"activate", "tail_too"}, {"strictness", "force"}}, "switch", &me);
  give({{"request", "control.state"}, {"name", "tail_too"}, {"state", "unconfigured"}}, "state", &me);
  give({{"request", "nonsense"}}, "nonsense", &me);
  give({{"request", "health"}}, "health", &me);
  give({{"request", "health"}}, "other", &other);
  give({{"request", "control.hold"}}, "hold", &me);
  EXPECT_EQ(order, (std::vector<std::string>{"other", "hold"}));
  cell.run(0.1);
  EXPECT_EQ(order, (std::vector<std::string>{"other", "hold", "switch", "state", "nonsense", "health"}));
  EXPECT_EQ(cell.state_of("tail_too"), "unconfigured");
}

TEST_F(RequestsTest, TooManyOpenRequestsAreRefusedAndNotKept) {
  const Json watch{{"request", "watch"}, {"name", "joint_states"}, {"rate", 0.001}};
  for (std::size_t i = 0; i < bounds::kOpenRequests; ++i) cell.give(watch);
  EXPECT_EQ(error_of(cell.give(watch)->front()), "busy");
  EXPECT_EQ(cell.cell().requests().open(), bounds::kOpenRequests);
}

TEST_F(RequestsTest, OneConnectionDoesNotKeepOthersOut) {
  const int me = 0, other = 0;
  std::shared_ptr<std::vector<Json>> last;
  for (std::size_t i = 0; i <= bounds::kOpenRequestsOfOne; ++i) {
    last = cell.give(Json{{"request", "watch"}, {"name", "joint_states"}, {"rate", 0.001}, {"id", i}}, &me);
    cell.run(0.01);
  }
  ASSERT_FALSE(last->empty());
  EXPECT_EQ(error_of(last->back()), "busy");
  const auto others = cell.give(Json{{"request", "health"}}, &other);
  ASSERT_FALSE(others->empty());
  EXPECT_TRUE(others->front()["ok"].get<bool>());
  cell.cell().requests().end(&me, Json(std::size_t{0}));
  cell.run(0.01);
  EXPECT_EQ(cell.cell().requests().open(), bounds::kOpenRequestsOfOne - 1) << "one has ended";
}

TEST_F(RequestsTest, ARequestThatIsEndedBeforeItsAnswerIsStillWitnessed) {
  const int me = 0;
  std::vector<std::string> codes;
  cell.cell().requests().set_witness([&](const void*, const protocol::Request&) {
    return [&](const protocol::Reply& reply) {
      codes.push_back(reply.refusal ? reply.refusal->problems().front().code : "done");
    };
  });
  cell.give(Json{{"request", "program.check"}, {"name", "new.script"}, {"text", "wait 1s"}, {"id", 5}}, &me);
  cell.cell().requests().end(&me, Json(std::size_t{5}));  // while a worker checks
  cell.run(0.01);
  ASSERT_EQ(codes.size(), 1u);
  EXPECT_TRUE(codes[0] == "ended" || codes[0] == "done") << codes[0];
}

TEST_F(RequestsTest, WhatIsKeptOfARequestIsShort) {
  const std::string long_id(1000, 'x');
  EXPECT_EQ(error_of(cell.give(Json{{"request", "health"}, {"id", long_id}})->front()), "bad-request");
  EXPECT_EQ(error_of(cell.give(Json{{"request", "health"}, {"id", Json(std::vector<int>(200, 7))}})->front()),
            "bad-request");
  const Json refused = cell.give(Json{{"request", std::string(500'000, 'x')}})->front();
  EXPECT_EQ(error_of(refused), "unknown-request");
  EXPECT_LT(refused.dump().size(), 3 * bounds::kErrorTextBytes) << "what was wrong is quoted, but not whole";
}

TEST_F(RequestsTest, ControllersAreNotLoadedWithoutEnd) {
  std::string last = "ok";
  for (std::size_t i = 0; i <= bounds::kLoadedControllers && last == "ok"; ++i) {
    const Json answer = cell.give(Json{{"request", "control.load"},
                                       {"name", "broadcaster" + std::to_string(i)},
                                       {"type", "joint_state_broadcaster/JointStateBroadcaster"}})
                            ->front();
    last = answer["ok"].get<bool>() ? "ok" : error_of(answer);
  }
  EXPECT_EQ(last, "too-many");
  EXPECT_EQ(cell.cell().loop().controllers().list().size(), bounds::kLoadedControllers);
}

TEST_F(RequestsTest, APersonHoldsAndResumesAMotion) {
  cell.give(Json{{"request", "send"}, {"to", "follow"}, {"message", trajectory(1, 2)}});
  cell.run(0.5);
  cell.result({{"request", "control.hold"}});
  cell.run(3);
  EXPECT_EQ(cell.result({{"request", "health"}})["state"], "held");
  const double held = cell.value_of("states", "arm/joint_1/position");
  EXPECT_GT(held, 0.05);
  EXPECT_LT(held, 0.9);
  cell.run(1);
  EXPECT_EQ(cell.value_of("states", "arm/joint_1/position"), held) << "nothing resumes by itself";
  cell.result({{"request", "control.resume"}});
  cell.run(3);
  EXPECT_NEAR(cell.value_of("states", "arm/joint_1/position"), 1, 1e-6);
  cell.result({{"request", "control.stop"}});
  cell.run(0.5);
  EXPECT_NE(cell.result({{"request", "health"}})["state"], "running");
}

TEST_F(RequestsTest, LimitsNameWhatTookHold) {
  EXPECT_EQ(cell.result({{"request", "limits"}}).size(), 0u);
  cell.result({{"request", "send"}, {"to", "tail"}, {"message", {{"data", {0, 1.5}}}}});
  cell.run(3);
  bool found = false;
  for (const Json& limit : cell.result({{"request", "limits"}}))
    if (limit["interface"] == "arm/joint_6/position") {
      found = true;
      EXPECT_GT(limit["count"].get<int>(), 0);
      EXPECT_LT(limit["given"].get<double>(), limit["asked"].get<double>());
    }
  EXPECT_TRUE(found);
  EXPECT_GT(cell.result({{"request", "health"}})["clamps"].get<int>(), 0);
}

}  // namespace
}  // namespace polyarm
