#include "links/mqtt/sparkplug.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <deque>
#include <fstream>
#include <functional>
#include <random>

#include "links/mqtt/connection.hpp"
#include "links/mqtt/port.hpp"
#include "tests/links/running_link.hpp"
#include "tests/support/damaged.hpp"
#include "tests/support/folder.hpp"

namespace polyarm::mqtt {
namespace {

using test::link_entry;
using test::RunningLink;

SparkplugPayload sample() {
  SparkplugPayload out;
  out.time_ms = 1'700'000'000'123;
  out.seq = 200;
  out.metrics.push_back({"bdSeq", {}, 8, 5, std::uint64_t{255}});
  out.metrics.push_back({"arm/speed", 1, 10, {}, 0.25});
  out.metrics.push_back({"", 2, 11, {}, true});
  out.metrics.push_back({"state", 3, 12, {}, std::string("running")});
  out.metrics.push_back({"unknown", 4, 10, {}, std::monostate{}});
  return out;
}

TEST(SparkplugPayload, IsReadAsItWasWritten) {
  const SparkplugPayload before = sample();
  const auto after = decoded(encoded(before));
  ASSERT_TRUE(after);
  EXPECT_EQ(after->time_ms, before.time_ms);
  EXPECT_EQ(after->seq, before.seq);
  ASSERT_EQ(after->metrics.size(), before.metrics.size());
  for (std::size_t i = 0; i < before.metrics.size(); ++i) {
    EXPECT_EQ(after->metrics[i].name, before.metrics[i].name);
    EXPECT_EQ(after->metrics[i].alias, before.metrics[i].alias);
    EXPECT_EQ(after->metrics[i].type, before.metrics[i].type);
    EXPECT_EQ(after->metrics[i].value, before.metrics[i].value);
  }
}

TEST(SparkplugPayload, HasTheBytesOfTheSpecification) {
  SparkplugPayload payload;
  payload.time_ms = 1;
  payload.seq = 0;
  payload.metrics.push_back({"a", 7, 11, {}, true});
  EXPECT_EQ(encoded(payload), std::string("\x08\x01\x12\x09\x0a\x01"
                                          "a\x10\x07\x20\x0b\x70\x01\x18\x00",
                                          15));
}

TEST(SparkplugPayload, SignedWholeNumbersOfOthersAreRead) {
  const auto payload =
      decoded(std::string("\x12\x0d\x20\x04\x58\xff\xff\xff\xff\xff\xff\xff\xff\xff\x01", 15));
  ASSERT_TRUE(payload);
  EXPECT_EQ(std::get<double>(payload->metrics.at(0).value), -1);
}

TEST(SparkplugPayload, AnyBytesAreReadOrRefused) {
  const std::string good = encoded(sample());
  std::mt19937 random(7);
  for (int n = 0; n < 100'000; ++n) {
    const auto payload = decoded(
        test::damaged(good, {"\x12\xff", "\xff\xff\xff\xff\x0f", std::string("\0", 1), "\x12"}, 20, random));
    EXPECT_TRUE(!payload || payload->metrics.size() <= kMostMetrics);
  }
  SparkplugPayload many;
  many.metrics.resize(kMostMetrics + 1);
  EXPECT_FALSE(decoded(encoded(many)));
}

TEST(HostState, IsReadFromJson) {
  EXPECT_TRUE(host_state(R"({"online":true,"timestamp":12})")->online);
  EXPECT_EQ(host_state(R"({"online":false,"timestamp":12})")->time_ms, 12u);
  for (const char* wrong : {"", "ONLINE", "[]", R"({"online":1})", "{\"online\":"})
    EXPECT_FALSE(host_state(wrong)) << wrong;
}

/// A host application that keeps every message.
class Host {
 public:
  explicit Host(int port) {
    entry.host = "127.0.0.1";
    entry.port = port;
    entry.timeout = 20'000'000'000;
    broker.open(std::nullopt);
    broker.subscribe({{"spBv1.0/#", 1}});
  }
  struct Message {
    std::string topic;
    SparkplugPayload payload;
  };
  /// Waits for a message that fits; nothing after a long time.
  const Message* comes(const std::function<bool(const Message&)>& fits) {
    const Message* found = nullptr;
    test::eventually([&] {
      broker.loop(1);
      for (const Message& each : messages)
        if (!found && fits(each)) found = &each;
      return found != nullptr;
    });
    return found;
  }
  const Message* comes(const std::string& topic) {
    return comes([&](const Message& each) { return each.topic == topic; });
  }
  void command(const std::string& topic, Metric metric, bool retain = false) {
    SparkplugPayload payload;
    payload.metrics.push_back(std::move(metric));
    broker.publish(topic, encoded(payload), 0, retain);
    broker.loop(0);
  }
  void say_state(const std::string& text) {
    broker.publish("spBv1.0/STATE/scada", text, 1, true);
    for (int n = 0; n < 5; ++n) broker.loop(1);
  }

  signals::LinkEntry entry;
  std::deque<Message> messages;
  Connection broker{entry, [this](const mosquitto_message& message) {
                      const std::string bytes(static_cast<const char*>(message.payload),
                                              static_cast<std::size_t>(message.payloadlen));
                      if (std::string(message.topic).find("/STATE/") != std::string::npos) return;
                      const auto payload = decoded(bytes);
                      EXPECT_TRUE(payload) << message.topic;
                      if (payload) messages.push_back({message.topic, *payload});
                    }};
};

const Metric* find(const SparkplugPayload& payload, const std::string& name) {
  for (const Metric& each : payload.metrics)
    if (each.name == name) return &each;
  return nullptr;
}

class SparkplugBroker : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!test::has_mosquitto()) GTEST_SKIP() << "mosquitto is not installed";
    std::ofstream(folder.path() / "broker.conf")
        << "listener " << port << " 127.0.0.1\nallow_anonymous true\nuser root\nlog_type none\n";
    start();
  }
  void start() {
    broker = std::make_unique<test::Peer>(
        std::vector<std::string>{"/usr/sbin/mosquitto", "-c", (folder.path() / "broker.conf").string()});
    ASSERT_TRUE(test::eventually([&] { return test::listens(port); }));
  }
  std::unique_ptr<RunningLink> node(const std::string& more = "") {
    const signals::LinkEntry entry = link_entry(text(more), port);
    return std::make_unique<RunningLink>(entry, make_client(entry));
  }
  static std::string text(const std::string& more = "") {
    return "site: {mqtt: sparkplug, port: PORT, group: plant, node: cell1, timeout: 2s, " + more +
           "tags: {State: {type: text, direction: out}, Speed: {device: arm, metric: speed, type: number, "
           "direction: both}, "
           "Ready: {device: arm, direction: out}}}";
  }
  test::Folder folder;
  int port = test::free_port();
  std::unique_ptr<test::Peer> broker;
};

TEST_F(SparkplugBroker, TheNodeIsBornWithNamesAndThenSendsAliasesInOrder) {
  Host host(port);
  const auto cell = node();
  ASSERT_TRUE(cell->up());
  const auto* const birth = host.comes("spBv1.0/plant/NBIRTH/cell1");
  ASSERT_TRUE(birth);
  EXPECT_EQ(birth->payload.seq, 0u);
  ASSERT_TRUE(find(birth->payload, "bdSeq"));
  ASSERT_TRUE(find(birth->payload, "Node Control/Rebirth"));
  const std::uint64_t alias = find(birth->payload, "State")->alias.value();
  const auto* const device = host.comes("spBv1.0/plant/DBIRTH/cell1/arm");
  ASSERT_TRUE(device);
  EXPECT_EQ(device->payload.seq, 1u);
  EXPECT_EQ(find(device->payload, "speed")->type, 10u);
  EXPECT_EQ(find(device->payload, "Ready")->type, 11u);
  cell->post("State", "running");
  const auto* const data = host.comes("spBv1.0/plant/NDATA/cell1");
  ASSERT_TRUE(data);
  ASSERT_EQ(data->payload.metrics.size(), 1u);
  EXPECT_EQ(data->payload.metrics[0].alias, alias);
  EXPECT_EQ(data->payload.metrics[0].name, "");
  EXPECT_EQ(std::get<std::string>(data->payload.metrics[0].value), "running");
  cell->post("Ready", true);
  ASSERT_TRUE(host.comes("spBv1.0/plant/DDATA/cell1/arm"));
  std::uint64_t next = 0;
  for (const auto& each : host.messages) EXPECT_EQ(each.payload.seq, next++ % 256) << each.topic;
}

TEST_F(SparkplugBroker, OnlyTagsThatMayComeInTakeCommands) {
  Host host(port);
  const auto cell = node();
  ASSERT_TRUE(cell->up());
  ASSERT_TRUE(host.comes("spBv1.0/plant/DBIRTH/cell1/arm"));
  host.command("spBv1.0/plant/DCMD/cell1/arm", {"speed", {}, 10, {}, 0.5});
  EXPECT_TRUE(cell->comes("Speed", 0.5));
  EXPECT_TRUE(host.comes("spBv1.0/plant/DDATA/cell1/arm")) << "the value that was taken is shown";
  host.command("spBv1.0/plant/DCMD/cell1/arm", {"Ready", {}, 11, {}, true});
  EXPECT_TRUE(cell->refuses("direction is out"));
  host.command("spBv1.0/plant/NCMD/cell1", {"State", {}, 12, {}, std::string("x")});
  host.command("spBv1.0/plant/DCMD/cell1/arm", {"speed", {}, 12, {}, std::string("fast")});
  EXPECT_TRUE(cell->refuses("another type"));
  EXPECT_FALSE(cell->values.contains("State"));
  EXPECT_FALSE(cell->values.contains("Ready"));
  EXPECT_EQ(cell->values.at("Speed"), data::Value(0.5));
}

TEST_F(SparkplugBroker, ACommandThatTheBrokerKeptIsNotCarriedOutAtTheNextConnection) {
  Host host(port);
  host.command("spBv1.0/plant/DCMD/cell1/arm", {"speed", {}, 10, {}, 0.9}, true);
  ASSERT_TRUE(host.comes("spBv1.0/plant/DCMD/cell1/arm")) << "the broker has it";
  const auto cell = node();
  ASSERT_TRUE(cell->up());
  ASSERT_TRUE(host.comes("spBv1.0/plant/DBIRTH/cell1/arm"));
  host.command("spBv1.0/plant/DCMD/cell1/arm", {"speed", {}, 10, {}, 0.5});
  EXPECT_TRUE(cell->comes("Speed", 0.5));
  EXPECT_FALSE(std::any_of(host.messages.begin(), host.messages.end(), [](const auto& each) {
    return each.topic == "spBv1.0/plant/DDATA/cell1/arm" &&
           each.payload.metrics.at(0).value == decltype(Metric::value)(0.9);
  })) << "a value that was taken would be shown";
}

TEST_F(SparkplugBroker, ARebirthIsAnsweredWithAllValues) {
  Host host(port);
  const auto cell = node();
  ASSERT_TRUE(cell->up());
  cell->post("State", "held");
  ASSERT_TRUE(host.comes("spBv1.0/plant/NDATA/cell1"));
  host.messages.clear();
  host.command("spBv1.0/plant/NCMD/cell1", {"Node Control/Rebirth", {}, 11, {}, true});
  const auto* const birth = host.comes("spBv1.0/plant/NBIRTH/cell1");
  ASSERT_TRUE(birth);
  EXPECT_EQ(birth->payload.seq, 0u);
  EXPECT_EQ(std::get<std::string>(find(birth->payload, "State")->value), "held");
  EXPECT_TRUE(host.comes("spBv1.0/plant/DBIRTH/cell1/arm"));
}

TEST_F(SparkplugBroker, TheDeathOfAKilledNodeHasTheNumberOfItsBirth) {
  Host host(port);
  const pid_t child = ::fork();
  if (child == 0) {
    const signals::LinkEntry entry = link_entry(text(), port);
    auto dying = make_client(entry);
    dying->open();
    signals::LinkReport news;
    for (int n = 0; n < 20; ++n) dying->exchange({}, 0, 1'000'000, news);
    ::raise(SIGKILL);
  }
  ::waitpid(child, nullptr, 0);
  const auto* const birth = host.comes("spBv1.0/plant/NBIRTH/cell1");
  const auto* const death = host.comes("spBv1.0/plant/NDEATH/cell1");
  ASSERT_TRUE(birth && death);
  EXPECT_FALSE(death->payload.seq) << "a will has no sequence number";
  EXPECT_EQ(std::get<std::uint64_t>(find(death->payload, "bdSeq")->value),
            std::get<std::uint64_t>(find(birth->payload, "bdSeq")->value));
}

TEST_F(SparkplugBroker, ANodeThatLeavesSaysSoItself) {
  Host host(port);
  node()->up();
  EXPECT_TRUE(host.comes("spBv1.0/plant/NDEATH/cell1"));
}

TEST_F(SparkplugBroker, AfterTheBrokerWasKilledTheNodeIsBornAgainWithItsLatestValues) {
  const auto cell = node();
  ASSERT_TRUE(cell->up());
  cell->post("State", "first");
  ASSERT_TRUE(cell->given());
  broker.reset();
  ASSERT_TRUE(cell->down());
  cell->post("State", "second");
  start();
  Host host(port);
  ASSERT_TRUE(cell->up());
  host.command("spBv1.0/plant/NCMD/cell1", {"Node Control/Rebirth", {}, 11, {}, true});
  EXPECT_TRUE(host.comes([](const Host::Message& each) {
    const Metric* const state = find(each.payload, "State");
    return state && state->value == decltype(state->value)(std::string("second"));
  }));
}

TEST_F(SparkplugBroker, WithAPrimaryHostTheNodeIsThereOnlyWhileThatIsOnline) {
  Host host(port);
  const auto cell = node("primary_host: scada, ");
  EXPECT_TRUE(test::eventually([&] {
    cell->look();
    return cell->link().state().reason.find("primary host") != std::string::npos;
  }));
  EXPECT_TRUE(host.messages.empty());
  host.say_state(R"({"online":true,"timestamp":100})");
  EXPECT_TRUE(host.comes("spBv1.0/plant/NBIRTH/cell1"));
  host.say_state(R"({"online":false,"timestamp":50})");
  host.command("spBv1.0/plant/NCMD/cell1", {"Node Control/Rebirth", {}, 11, {}, true});
  EXPECT_FALSE(std::any_of(host.messages.begin(), host.messages.end(), [](const auto& each) {
    return each.topic.find("NDEATH") != std::string::npos;
  })) << "an older state of the host changes nothing";
  host.say_state(R"({"online":false,"timestamp":200})");
  EXPECT_TRUE(host.comes("spBv1.0/plant/NDEATH/cell1"));
}

TEST(SparkplugLinks, WrongEntriesAreRefusedWithAReason) {
  const auto wrong = [](const std::string& entry) {
    try {
      link_entry("site: {mqtt: sparkplug, port: 1883, " + entry + "}", 1883);
    } catch (const Error& e) {
      return e.problems().front().code;
    }
    return std::string("none");
  };
  EXPECT_EQ(wrong("group: plant, tags: {A: {direction: out}}"), "none");
  EXPECT_NE(wrong("tags: {A: {direction: out}}"), "none") << "no group";
  EXPECT_EQ(wrong("group: a/b, tags: {A: {direction: out}}"), "bad-link");
  EXPECT_EQ(wrong("group: plant, tags: {A: {direction: out, device: '#'}}"), "bad-link");
  EXPECT_EQ(wrong("group: plant, tags: {A: {direction: out, type: pose}}"), "bad-link");
  EXPECT_NE(wrong("group: plant, tags: {A: {}}"), "none") << "no direction: nothing may come in by itself";
}

}  // namespace
}  // namespace polyarm::mqtt
