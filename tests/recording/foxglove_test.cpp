#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <map>
#include <random>
#include <thread>

#include "polyarm/recording/foxglove_server.hpp"
#include "tests/recording/bytes.hpp"

namespace polyarm::recording {
namespace {

using Json = nlohmann::json;

Channel number_channel(const std::string& topic, bool latched = false) {
  return {topic, "cdr", "a/msg/A", "ros2msg", "float64 x", "", latched};
}

/// A server of three channels and one who watches.
struct Bench {
  FoxgloveServer server{{"demo cell", "1.2", "session-7", false, 4}};
  std::shared_ptr<FoxgloveClient> client;
  std::vector<Json> told;
  std::vector<std::string> binary;

  Bench() {
    server.set_channels({number_channel("/a"), number_channel("/b"), number_channel("/text", true)});
    client = server.connect();
    read();
  }
  void read() {
    while (const auto out = client->next()) {
      if (out->binary)
        binary.push_back(*out->body);
      else
        told.push_back(Json::parse(*out->body));
    }
  }
  void ask(const Json& message) {
    client->take_text(message.dump());
    read();
  }
  Json last(const std::string& op) const {
    for (auto i = told.rbegin(); i != told.rend(); ++i)
      if ((*i)["op"] == op) return *i;
    return {};
  }
  std::uint32_t id_of(const std::string& topic) const {
    const Json message = last("advertise");
    for (const Json& each : message["channels"])
      if (each["topic"] == topic) return each["id"];
    return 0;
  }
  void subscribe(std::uint32_t id, const std::string& topic) {
    ask({{"op", "subscribe"}, {"subscriptions", Json::array({{{"id", id}, {"channelId", id_of(topic)}}})}});
  }
};

template <class T>
T number(const std::string& text, std::size_t at) {
  T out;
  std::memcpy(&out, text.data() + at, sizeof out);
  return out;
}

TEST(FoxgloveSubprotocol, IsTheNewNameBeforeTheOldOne) {
  EXPECT_EQ(foxglove_subprotocol("foxglove.websocket.v1, foxglove.sdk.v1"), "foxglove.sdk.v1");
  EXPECT_EQ(foxglove_subprotocol("foxglove.websocket.v1"), "foxglove.websocket.v1");
  EXPECT_EQ(foxglove_subprotocol("foxglove.sdk.v10, mqtt"), "");
  EXPECT_EQ(foxglove_subprotocol(""), "");
}

TEST(FoxgloveServer, TellsWhoComesWhatThereIs) {
  Bench bench;
  ASSERT_GE(bench.told.size(), 2u);
  EXPECT_EQ(bench.told[0]["op"], "serverInfo");
  EXPECT_EQ(bench.told[0]["name"], "demo cell");
  EXPECT_EQ(bench.told[0]["sessionId"], "session-7");
  const Json capabilities = bench.told[0]["capabilities"];
  EXPECT_EQ(std::count(capabilities.begin(), capabilities.end(), "clientPublish"), 0);
  EXPECT_EQ(bench.told[1]["op"], "advertise");
  EXPECT_EQ(bench.told[1]["channels"][0]["topic"], "/a");
  EXPECT_EQ(bench.told[1]["channels"][0]["schemaEncoding"], "ros2msg");
}

TEST(FoxgloveServer, AMessageGoesToWhoAskedForItsChannelWithTheNumberTheyGave) {
  Bench bench;
  EXPECT_FALSE(bench.server.publish(0, 5, bytes_of("nobody")));
  bench.subscribe(41, "/a");
  EXPECT_TRUE(bench.server.wanted(0));
  EXPECT_FALSE(bench.server.wanted(1));
  EXPECT_TRUE(bench.server.publish(0, 77, bytes_of("hello")));
  bench.server.publish(1, 78, bytes_of("other"));
  bench.read();
  ASSERT_EQ(bench.binary.size(), 1u);
  EXPECT_EQ(bench.binary[0][0], 1);
  EXPECT_EQ(number<std::uint32_t>(bench.binary[0], 1), 41u);
  EXPECT_EQ(number<std::uint64_t>(bench.binary[0], 5), 77u);
  EXPECT_EQ(bench.binary[0].substr(13), "hello");
  bench.ask({{"op", "unsubscribe"}, {"subscriptionIds", {41}}});
  EXPECT_FALSE(bench.server.wanted(0));
}

TEST(FoxgloveServer, WhatIsLatchedIsToldToWhoComesLater) {
  Bench bench;
  bench.server.publish(2, 3, bytes_of("<robot/>"));
  bench.subscribe(1, "/text");
  ASSERT_EQ(bench.binary.size(), 1u);
  EXPECT_EQ(bench.binary[0].substr(13), "<robot/>");
}

TEST(FoxgloveServer, NewChannelsTakeThePlaceOfTheOldOnes) {
  Bench bench;
  bench.subscribe(1, "/a");
  const std::uint32_t before = bench.id_of("/a");
  bench.server.set_channels({number_channel("/a")});
  bench.read();
  EXPECT_EQ(bench.last("unadvertise")["channelIds"].size(), 3u);
  EXPECT_NE(bench.id_of("/a"), before) << "a number never means another channel";
  EXPECT_FALSE(bench.server.publish(0, 1, bytes_of("x")));
  bench.subscribe(1, "/a");
  EXPECT_TRUE(bench.server.publish(0, 1, bytes_of("x")));
}

TEST(FoxgloveServer, ParametersAreReadAndNotSet) {
  Bench bench;
  bench.ask({{"op", "subscribeParameterUpdates"}, {"parameterNames", {"robot_description"}}});
  bench.server.set_parameters({{"robot_description", "<robot/>"}, {"rate", 100}});
  bench.read();
  EXPECT_EQ(bench.last("parameterValues")["parameters"],
            Json::array({{{"name", "robot_description"}, {"value", "<robot/>"}}}));
  bench.ask({{"op", "getParameters"}, {"parameterNames", Json::array()}, {"id", "7"}});
  EXPECT_EQ(bench.last("parameterValues")["parameters"].size(), 2u);
  EXPECT_EQ(bench.last("parameterValues")["id"], "7");
  bench.ask({{"op", "setParameters"}, {"parameters", Json::array({{{"name", "rate"}, {"value", 1}}})}});
  EXPECT_EQ(bench.last("status")["level"], 2);
  bench.ask({{"op", "getParameters"}, {"parameterNames", {"rate"}}});
  EXPECT_EQ(bench.last("parameterValues")["parameters"][0]["value"], 100);
}

TEST(FoxgloveServer, AParameterIsToldOnceHoweverOftenItIsNamed) {
  Bench bench;
  bench.server.set_parameters({{"robot_description", std::string(1000, 'x')}});
  bench.ask(
      {{"op", "getParameters"}, {"parameterNames", std::vector<std::string>(900, "robot_description")}});
  EXPECT_EQ(bench.last("parameterValues")["parameters"].size(), 1u);
}

TEST(FoxgloveServer, WhatWaitsForOneWhoNeverReadsIsBounded) {
  Bench bench;
  const std::string text(100'000, 'x');
  bench.ask({{"op", "subscribeParameterUpdates"}, {"parameterNames", Json::array()}});
  bench.server.set_assets([&](const std::string&, const std::function<void(Asset)>& reply) {
    reply({text, ""});
  });
  const std::string fetch = R"({"op":"fetchAsset","uri":"a","requestId":1})";
  for (int n = 0; n < 300; ++n) {
    bench.server.set_parameters({{"robot_description", text + std::to_string(n)}});
    bench.client->take_text(fetch);
  }
  for (int n = 0; n < 300'000; ++n) bench.client->take_text(fetch);  // refused: nobody reads the answers
  std::size_t bytes = 0;
  while (const auto out = bench.client->next()) bytes += out->body->size();
  // Assets that waited for room come while it reads.
  EXPECT_LT(bytes, FoxgloveClient::kMostWaiting + (4 + FoxgloveClient::kMostLater) * text.size());
}

TEST(FoxgloveServer, AnAssetComesWithItsRequestsNumberOrWithAReason) {
  Bench bench;
  int woken = 0;
  bench.server.set_wake([&] { ++woken; });
  bench.server.set_assets([](const std::string& uri, const std::function<void(Asset)>& reply) {
    reply(uri == "package://demo/base.stl" ? Asset{"solid base", ""} : Asset{std::nullopt, "no such mesh"});
  });
  bench.ask({{"op", "fetchAsset"}, {"uri", "package://demo/base.stl"}, {"requestId", 9}});
  bench.ask({{"op", "fetchAsset"}, {"uri", "file:///etc/passwd"}, {"requestId", 10}});
  ASSERT_EQ(bench.binary.size(), 2u);
  EXPECT_EQ(bench.binary[0][0], 4);
  EXPECT_EQ(number<std::uint32_t>(bench.binary[0], 1), 9u);
  EXPECT_EQ(bench.binary[0][5], 0);
  EXPECT_EQ(number<std::uint32_t>(bench.binary[0], 6), 0u);
  EXPECT_EQ(bench.binary[0].substr(10), "solid base");
  EXPECT_EQ(bench.binary[1][5], 1);
  EXPECT_EQ(bench.binary[1].substr(10), "no such mesh");
  EXPECT_EQ(woken, 2);
}

TEST(FoxgloveServer, AssetsOfAllWhoDoNotReadAreBoundedTogether) {
  Bench bench;
  const std::string large(60 << 20, 'x');
  bench.server.set_assets([&](const std::string&, const std::function<void(Asset)>& reply) {
    reply(Asset{large, ""});
  });
  std::vector<std::shared_ptr<FoxgloveClient>> watchers = {bench.client, bench.server.connect(),
                                                           bench.server.connect()};
  for (const auto& each : watchers) {
    while (each->next()) {
    }
    each->take_text(R"({"op":"fetchAsset","uri":"a","requestId":1})");
  }
  const auto answer = [](FoxgloveClient& client) {
    const auto out = client.next();
    return out ? out->body->size() : 0;
  };
  EXPECT_GT(answer(*watchers[0]), large.size());
  EXPECT_GT(answer(*watchers[1]), large.size());
  EXPECT_LT(answer(*watchers[2]), 200u) << "told to ask again";
  watchers[2]->take_text(R"({"op":"fetchAsset","uri":"a","requestId":2})");
  EXPECT_GT(answer(*watchers[2]), large.size()) << "the others have read theirs";
  // Who leaves takes along what waits for it.
  for (int i = 0; i < 5; ++i) {
    auto leaving = bench.server.connect();
    ASSERT_TRUE(leaving);
    while (leaving->next()) {
    }
    leaving->take_text(R"({"op":"fetchAsset","uri":"a","requestId":1})");
  }
  bench.client->take_text(R"({"op":"fetchAsset","uri":"a","requestId":3})");
  EXPECT_GT(answer(*bench.client), large.size());
}

TEST(FoxgloveServer, EachRequestForAnAssetIsAnsweredHoweverMuchWaits) {
  Bench bench;
  const std::string mesh(FoxgloveClient::kMostWaiting, 'x');
  std::vector<std::function<void(Asset)>> readers;
  bool at_once = true;
  bench.server.set_assets([&](const std::string&, const std::function<void(Asset)>& reply) {
    at_once ? reply(Asset{mesh, ""}) : readers.push_back(reply);
  });
  const auto fetch = [&](std::uint32_t id) {
    bench.client->take_text(Json{{"op", "fetchAsset"}, {"uri", "a"}, {"requestId", id}}.dump());
  };
  constexpr std::uint32_t kAsked = FoxgloveClient::kMostLater + 20;
  for (std::uint32_t id = 0; id < kAsked; ++id) fetch(id);
  std::map<std::uint32_t, std::size_t> answers;
  while (const auto out = bench.client->next()) {
    if (!out->binary) continue;
    EXPECT_TRUE(answers.emplace(number<std::uint32_t>(*out->body, 1), out->body->size()).second);
  }
  EXPECT_EQ(answers.size(), kAsked);
  EXPECT_GT(answers[0], mesh.size());
  EXPECT_GT(answers[FoxgloveClient::kMostLater], mesh.size()) << "it waited until there was room";
  EXPECT_LT(answers[kAsked - 1], 200u) << "refused";
  // Files that are being read when the first of them fills the queue come, too.
  at_once = false;
  fetch(1000);
  fetch(1001);
  for (const auto& reply : readers) reply(Asset{mesh, ""});
  int came = 0;
  while (const auto out = bench.client->next()) came += out->body->size() > mesh.size();
  EXPECT_EQ(came, 2);
}

TEST(FoxgloveServer, AnAssetThatComesAfterItsClientHasGoneGoesNowhere) {
  std::function<void(Asset)> later;
  Bench bench;
  bench.server.set_assets([&](const std::string&, std::function<void(Asset)> reply) { later = reply; });
  bench.ask({{"op", "fetchAsset"}, {"uri", "package://demo/base.stl"}, {"requestId", 9}});
  bench.client.reset();
  EXPECT_EQ(bench.server.clients(), 0u);
  ASSERT_TRUE(later);
  later({"late", ""});
}

TEST(FoxgloveServer, WhoReadsTooLittleGetsTheNewestAndNothingGrows) {
  Bench bench;
  bench.subscribe(0, "/a");  // clients count from 0
  const std::string large(10'000, 'x');
  for (std::int64_t i = 0; i < 10'000; ++i) bench.server.publish(0, i, bytes_of(large));
  bench.read();
  EXPECT_GT(bench.client->left_out(), 9'000u);
  EXPECT_LT(bench.binary.size(), 100u);
  EXPECT_EQ(number<std::uint64_t>(bench.binary.back(), 5), 9'999u);
}

TEST(FoxgloveServer, TakesNoMoreClientsThanItMay) {
  Bench bench;
  std::vector<std::shared_ptr<FoxgloveClient>> more;
  for (int i = 0; i < 3; ++i) more.push_back(bench.server.connect());
  EXPECT_TRUE(more.back());
  EXPECT_FALSE(bench.server.connect());
  more.pop_back();
  EXPECT_TRUE(bench.server.connect());
}

TEST(FoxgloveServer, ATimeOfItsOwnIsToldInLockStepAlone) {
  FoxgloveServer own{{"", "", "", true, 4}};
  const auto client = own.connect();
  while (client->next()) {
  }
  own.report_time(12);
  const auto out = client->next();
  ASSERT_TRUE(out && out->binary);
  EXPECT_EQ(*out->body, std::string("\x02\x0c\0\0\0\0\0\0\0", 9));
}

TEST(FoxgloveServer, IsNotPutOffByWhatIsSaidWhileItPublishes) {
  Bench bench;
  std::thread publisher([&] {
    for (std::int64_t i = 0; i < 2000; ++i) bench.server.publish(0, i, bytes_of("x"));
  });
  for (int i = 0; i < 200; ++i) {
    const auto other = bench.server.connect();
    if (!other) continue;
    other->take_text(R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":1}]})");
    while (other->next()) {
    }
  }
  publisher.join();
  EXPECT_EQ(bench.server.clients(), 1u);
}

/// A message that is nearly right: values of other types, keys that are missing, numbers that are none.
Json drawn_value(std::mt19937_64& draw, int depth) {
  switch (draw() % (depth > 2 ? 7 : 9)) {
    case 0:
      return nullptr;
    case 1:
      return draw() % 2 == 0;
    case 2:
      return static_cast<std::uint64_t>(draw() % 6);
    case 3:
      return static_cast<std::int64_t>(draw());
    case 4:
      return 0.5 * static_cast<double>(draw() % 1000);
    case 5:
      return std::string(draw() % 30, static_cast<char>('a' + draw() % 26));
    case 6:
      return "robot_description";
    case 7: {
      Json out = Json::array();
      for (std::uint64_t i = draw() % 4; i > 0; --i) out.push_back(drawn_value(draw, depth + 1));
      return out;
    }
    default: {
      Json out = Json::object();
      for (const char* key : {"id", "channelId", "name", "value"})
        if (draw() % 2 == 0) out[key] = drawn_value(draw, depth + 1);
      return out;
    }
  }
}

TEST(FoxgloveServer, NothingThatAClientSendsBreaksIt) {
  std::mt19937_64 draw(20261122);
  const std::vector<std::string> ops = {"subscribe",
                                        "unsubscribe",
                                        "getParameters",
                                        "setParameters",
                                        "subscribeParameterUpdates",
                                        "unsubscribeParameterUpdates",
                                        "fetchAsset",
                                        "advertise",
                                        "subscribeConnectionGraph",
                                        "nonsense"};
  const std::vector<std::string> keys = {"subscriptions", "subscriptionIds", "parameterNames", "parameters",
                                         "uri",           "requestId",       "channels",       "id"};
  Bench bench;
  bench.server.set_parameters({{"robot_description", "<robot/>"}});
  bench.server.set_assets([](const std::string&, const std::function<void(Asset)>& reply) {
    reply({std::nullopt, "there is none"});
  });
  for (int round = 0; round < 20'000; ++round) {
    Json message{{"op", ops[draw() % ops.size()]}};
    for (const std::string& key : keys)
      if (draw() % 3 == 0) message[key] = drawn_value(draw, 0);
    std::string text = message.dump();
    if (draw() % 4 == 0)  // and cut, or with a byte that is another
      for (std::uint64_t i = draw() % 3 + 1; i > 0 && !text.empty(); --i) {
        if (draw() % 2 == 0)
          text.resize(draw() % text.size());
        else
          text[draw() % text.size()] = static_cast<char>(draw());
      }
    bench.client->take_text(text);
    if (draw() % 8 == 0) bench.client->take_binary(text);
    if (draw() % 4 == 0) bench.server.publish(draw() % 4, round, bytes_of(text));
    if (draw() % 16 == 0) bench.read();
    ASSERT_LE(bench.told.size() + bench.binary.size(), 400'000u);
  }
  bench.read();
  bench.told.clear();
  bench.ask({{"op", "getParameters"}, {"parameterNames", {"robot_description"}}});
  EXPECT_EQ(bench.last("parameterValues")["parameters"][0]["value"], "<robot/>") << "it goes on as before";
}

}  // namespace
}  // namespace polyarm::recording
