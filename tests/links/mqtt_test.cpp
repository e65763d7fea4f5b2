#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <fstream>
#include <random>
#include <thread>

#include "links/mqtt/payload.hpp"
#include "links/mqtt/port.hpp"
#include "polyarm/base/file.hpp"
#include "tests/links/running_link.hpp"

namespace polyarm {
namespace {

using signals::LinkTag;
using test::link_entry;
using test::Peer;
using test::RunningLink;

LinkTag tag_of(LinkTag::Type type, bool json, const std::string& field = {}) {
  LinkTag tag;
  tag.topic = "t";
  tag.type = type;
  tag.json = json;
  tag.field = field;
  tag.format = LinkTag::Format::float64;
  return tag;
}

std::string refusal(const LinkTag& tag, const std::string& payload) {
  std::string why;
  EXPECT_FALSE(mqtt::value_of_payload(tag, payload, why)) << payload;
  return why;
}

data::Value taken(const LinkTag& tag, const std::string& payload) {
  std::string why;
  const auto value = mqtt::value_of_payload(tag, payload, why);
  EXPECT_TRUE(value) << payload << ": " << why;
  return value.value_or("nothing");
}

/// A broker that takes the connection and answers the first subscription with this code.
class OneSubscription {
 public:
  explicit OneSubscription(char code) : listening_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof at;
    EXPECT_EQ(::bind(listening_, reinterpret_cast<sockaddr*>(&at), size), 0);
    EXPECT_EQ(::listen(listening_, 1), 0);
    ::getsockname(listening_, reinterpret_cast<sockaddr*>(&at), &size);
    port = ntohs(at.sin_port);
    thread_ = std::thread([this, code] { serve(code); });
  }
  ~OneSubscription() {
    ::shutdown(listening_, SHUT_RDWR);
    thread_.join();
    ::close(listening_);
  }
  int port = 0;

 private:
  void serve(char code) const {
    const int client = ::accept(listening_, nullptr, nullptr);
    if (client < 0) return;
    std::array<char, 512> bytes{};
    if (::recv(client, bytes.data(), bytes.size(), 0) > 0) {
      ::send(client, "\x20\x02\x00\x00", 4, MSG_NOSIGNAL);
      if (::recv(client, bytes.data(), bytes.size(), 0) > 3) {  // 82 LENGTH, then the number of the message
        const char reply[] = {'\x90', 3, bytes[2], bytes[3], code};
        ::send(client, reply, sizeof reply, MSG_NOSIGNAL);
      }
      while (::recv(client, bytes.data(), bytes.size(), 0) > 0) {
      }
    }
    ::close(client);
  }
  int listening_;
  std::thread thread_;
};

TEST(MqttClient, ARefusedSubscriptionIsAnErrorWithItsTopic) {
  const char* const text =
      "mes: {mqtt: client, host: 127.0.0.1, port: PORT, timeout: 60s, "
      "tags: {Order: {topic: mes/order, type: text, direction: in}}}";
  {
    const OneSubscription granted(0);
    EXPECT_NO_THROW(mqtt::make_client(link_entry(text, granted.port))->open());
  }
  const OneSubscription refused('\x80');
  const auto client = mqtt::make_client(link_entry(text, refused.port));
  try {
    client->open();
    FAIL() << "it takes a refused subscription for a connection";
  } catch (const Error& e) {
    EXPECT_EQ(e.problems().front().code, "link-lost");
    EXPECT_NE(std::string(e.what()).find("refuses the subscription to 'mes/order'"), std::string::npos)
        << e.what();
  }
}

TEST(MqttPayload, PlainTextIsABooleanANumberOrAText) {
  EXPECT_EQ(taken(tag_of(LinkTag::Type::boolean, false), "ON"), data::Value(true));
  EXPECT_EQ(taken(tag_of(LinkTag::Type::boolean, false), "0"), data::Value(false));
  EXPECT_EQ(taken(tag_of(LinkTag::Type::number, false), " 2.5 "), data::Value(2.5));
  EXPECT_EQ(taken(tag_of(LinkTag::Type::text, false), "red part"), data::Value("red part"));
  EXPECT_NE(refusal(tag_of(LinkTag::Type::number, false), "warm").find("'warm' is not a number"),
            std::string::npos);
  EXPECT_NE(refusal(tag_of(LinkTag::Type::boolean, false), "2"), "");
}

TEST(MqttPayload, JsonIsTakenFromItsField) {
  const LinkTag tag = tag_of(LinkTag::Type::number, true, "count.total");
  EXPECT_EQ(taken(tag, R"({"count": {"total": 3}})"), data::Value(3));
  EXPECT_NE(refusal(tag, R"({"count": 3})").find("no field"), std::string::npos);
  EXPECT_NE(refusal(tag, R"({"count": {"total": "3"}})").find("not a number"), std::string::npos);
  EXPECT_NE(refusal(tag, "{").find("no JSON"), std::string::npos);
  EXPECT_EQ(mqtt::payload_of(tag, 3), R"({"count":{"total":3.0}})");
}

TEST(MqttPayload, APoseIsWholeOrNotTaken) {
  const LinkTag tag = tag_of(LinkTag::Type::pose, true);
  const data::Value pose = taken(tag, R"({"x": 0.1, "y": 0.2, "z": 0.3, "rx": 0, "ry": 0, "rz": 1})");
  EXPECT_NEAR(pose.as_point()->pose.position.y, 0.2, 1e-12);
  EXPECT_TRUE(taken(tag, "[0.1, 0.2, 0.3, 0, 0, 0, 1]").as_point()->quaternion_given);
  EXPECT_EQ(
      mqtt::value_of_payload(tag, mqtt::payload_of(tag, pose), *new std::string)->as_point()->pose.position,
      pose.as_point()->pose.position);
  for (const char* broken :
       {R"({"x": 0.1, "y": 0.2})", "[1, 2, 3]", "[1, 2, 3, 4, 5, \"6\"]", "[0, 0, 0, 0, 0, 0, 0]", "7",
        "null", R"({"x": 0.1, "y": 0.2, "z": 0.3, "rx": 0, "ry": 0, "rz": 180})", "[1e999, 0, 0, 0, 0, 0]"})
    EXPECT_NE(refusal(tag, broken), "") << broken;
}

TEST(MqttPayload, NoMessageWhateverItIsThrows) {
  std::mt19937 random(5);
  const LinkTag tags[] = {tag_of(LinkTag::Type::pose, true), tag_of(LinkTag::Type::number, true, "a.b"),
                          tag_of(LinkTag::Type::pose, false), tag_of(LinkTag::Type::boolean, false)};
  const std::string alphabet = "[]{}\",:0123456789.eE+-abtrufalsnl\\ \n\xff\x01";
  for (int k = 0; k < 20000; ++k) {
    std::string payload;
    for (std::size_t n = random() % 40; n > 0; --n) payload += alphabet[random() % alphabet.size()];
    std::string why;
    EXPECT_NO_THROW(mqtt::value_of_payload(tags[random() % 4], payload, why)) << payload;
  }
}

class Broker : public testing::Test {
 protected:
  void SetUp() override {
    if (!test::has_mosquitto()) GTEST_SKIP() << "mosquitto is not installed";
    std::string pattern = (std::filesystem::temp_directory_path() / "polyarm_XXXXXX").string();
    folder = ::mkdtemp(pattern.data());
    configure("");
    start();
  }
  void TearDown() override {
    broker = nullptr;
    std::error_code ignored;
    if (!folder.empty()) std::filesystem::remove_all(folder, ignored);
  }
  void configure(const std::string& more) {
    std::ofstream(folder / "broker.conf")
        << "listener " << port << " 127.0.0.1\nallow_anonymous true\nuser root\n"
        << "log_type none\n"
        << more;
  }
  void start() {
    broker = std::make_unique<Peer>(
        std::vector<std::string>{"/usr/sbin/mosquitto", "-c", (folder / "broker.conf").string()});
    ASSERT_TRUE(test::eventually([&] { return test::listens(port); }));
  }
  std::unique_ptr<RunningLink> linked(const std::string& text) {
    const signals::LinkEntry entry = link_entry(text, port);
    auto out = std::make_unique<RunningLink>(entry, mqtt::make_client(entry));
    EXPECT_TRUE(out->up()) << out->link().state().reason;
    return out;
  }

  int port = test::free_port();
  std::filesystem::path folder;
  std::unique_ptr<Peer> broker;
};

constexpr const char* kCell = R"(
cell:
  mqtt: client
  port: PORT
  will: {topic: cell/state, text: gone}
  tags:
    Count: {topic: cell/count, type: number, direction: out, retain: true}
    Kind: {topic: vision/kind, type: text, direction: in}
    Speed: {topic: belt/speed, type: number, json: true, field: v, direction: both}
    pick: {topic: vision/pose, type: pose, direction: in, within: [[0, -1, 0], [1, 1, 1]]}
)";
constexpr const char* kOther = R"(
other:
  mqtt: client
  port: PORT
  tags:
    Count: {topic: cell/count, type: number, direction: in}
    Kind: {topic: vision/kind, type: text, direction: out}
    Speed: {topic: belt/speed, type: number, json: true, field: v, direction: both}
    State: {topic: cell/state, type: text, direction: in}
    Raw: {topic: vision/pose, type: text, direction: out, qos: 2}
)";

TEST_F(Broker, CarriesValuesBothWays) {
  const auto cell = linked(kCell), other = linked(kOther);
  cell->post("Count", 3);
  EXPECT_TRUE(other->comes("Count", 3));
  other->post("Kind", "red");
  EXPECT_TRUE(cell->comes("Kind", "red"));
  other->post("Speed", 0.5);
  EXPECT_TRUE(cell->comes("Speed", 0.5));
  cell->post("Speed", 0.25);
  EXPECT_TRUE(other->comes("Speed", 0.25));
}

TEST_F(Broker, KeepsWhatIsRetainedForWhoComesLater) {
  const auto cell = linked(kCell);
  cell->post("Count", 7);
  ASSERT_TRUE(cell->given());
  EXPECT_TRUE(linked(kOther)->comes("Count", 7));
}

TEST_F(Broker, TellsTheLastWillOfWhoDiesAndNotOfWhoLeaves) {
  const auto other = linked(kOther);
  linked(kCell) = nullptr;  // leaves
  {
    const pid_t child = ::fork();
    if (child == 0) {  // dies
      const signals::LinkEntry entry = link_entry(kCell, port);
      auto dying = mqtt::make_client(entry);
      dying->open();
      ::raise(SIGKILL);
    }
    other->look();
    EXPECT_FALSE(other->values.contains("State")) << "it said goodbye";
    ::waitpid(child, nullptr, 0);
  }
  EXPECT_TRUE(other->comes("State", "gone"));
}

TEST_F(Broker, RefusesRubbishAndKeepsTheLastGoodPose) {
  const auto cell = linked(kCell), other = linked(kOther);
  other->post("Raw", R"([0.3, 0, 0.1, 0, 0, 0])");
  ASSERT_TRUE(test::eventually([&] { return cell->look(), cell->values.contains("pick"); }));
  const data::Value good = cell->values.at("pick");
  for (const auto& [text, why] : {std::pair{"[9, 0, 0, 0, 0, 0]", "outside"},
                                  {"\x01\x02\xff", "no JSON"},
                                  {"{\"x\": 0.1}", "no complete pose"}}) {
    other->post("Raw", text);
    EXPECT_TRUE(cell->refuses(why)) << text;
  }
  EXPECT_EQ(cell->values.at("pick"), good);
}

TEST_F(Broker, ThatDiesIsToldAndFoundAgain) {
  const auto cell = linked(kCell);
  broker->end(SIGKILL);
  ASSERT_TRUE(cell->down());
  cell->look();
  EXPECT_EQ(cell->losses.size(), 1u);
  cell->post("Count", 9);
  start();
  ASSERT_TRUE(cell->up());
  EXPECT_TRUE(linked(kOther)->comes("Count", 9)) << "what was set while it was gone";
}

TEST_F(Broker, IsAskedOverTls) {
  if (std::system("openssl version > /dev/null 2>&1") != 0) GTEST_SKIP() << "openssl is not installed";
  const std::string at = folder.string();
  ASSERT_EQ(std::system(("openssl req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=localhost -addext "
                         "subjectAltName=DNS:localhost,IP:127.0.0.1 -keyout " +
                         at + "/key.pem -out " + at + "/cert.pem > /dev/null 2>&1")
                            .c_str()),
            0);
  broker = nullptr;
  configure("certfile " + at + "/cert.pem\nkeyfile " + at + "/key.pem\n");
  start();
  const std::string cell = ": {mqtt: client, host: 127.0.0.1, port: PORT, tls: {ca: " + at +
                           "/cert.pem}, tags: {Count: {topic: c, type: number, direction: both}}}";
  const auto first = linked("one" + cell), second = linked("two" + cell);
  first->post("Count", 4);
  EXPECT_TRUE(second->comes("Count", 4));
  const signals::LinkEntry strange =
      link_entry("cell: {mqtt: client, host: localhost, port: PORT, tls: true, tags: {}}", port);
  RunningLink unknown(strange, mqtt::make_client(strange));
  EXPECT_TRUE(test::eventually([&] {
    return unknown.look(),
           unknown.link().state().reason.find("yet") == std::string::npos && !unknown.link().state().up;
  })) << "a broker whose certificate nobody vouches for is not trusted";
}

}  // namespace
}  // namespace polyarm
