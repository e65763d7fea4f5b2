#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <deque>
#include <limits>
#include <random>
#include <span>
#include <stdexcept>
#include <thread>

#include "links/modbus/frame.hpp"
#include "links/modbus/port.hpp"
#include "links/modbus/registers.hpp"
#include "polyarm/base/bounds.hpp"
#include "tests/links/running_link.hpp"

namespace polyarm {
namespace {

using modbus::Format;
using test::link_entry;
using test::Peer;
using test::RunningLink;

TEST(ModbusRegisters, HoldEveryFormatInBothWordOrders) {
  const std::pair<Format, std::vector<double>> cases[] = {{Format::uint16, {0, 1, 65535}},
                                                          {Format::int16, {0, -1, -32768, 32767}},
                                                          {Format::uint32, {0, 65536, 4294967295.0}},
                                                          {Format::int32, {-1, -2147483648.0, 2147483647.0}},
                                                          {Format::float32, {0, -1.5, 1048576.5}},
                                                          {Format::float64, {0, 0.1, -1e300}}};
  for (const auto& [format, numbers] : cases)
    for (const double number : numbers)
      for (const bool low : {false, true}) {
        std::uint16_t words[4] = {};
        modbus::number_into(number, words, format, low);
        EXPECT_EQ(modbus::number_from(words, format, low), number);
      }
  std::uint16_t words[2];
  modbus::number_into(1.0, words, Format::float32, false);
  EXPECT_EQ(words[0], 0x3F80);  // IEEE 754: 1.0 is 3F80 0000, the high word first
  modbus::number_into(1.0, words, Format::float32, true);
  EXPECT_EQ(words[1], 0x3F80);
}

TEST(ModbusRegisters, WhatAFormatCannotHoldIsCutToItsRangeAndNotWrapped) {
  signals::LinkTag tag;
  tag.area = signals::LinkTag::Area::holding;
  tag.type = signals::LinkTag::Type::number;
  tag.format = Format::uint16;
  EXPECT_EQ(modbus::words_of_value(tag, 1e9, false), std::vector<std::uint16_t>{65535});
  EXPECT_EQ(modbus::words_of_value(tag, -5, false), std::vector<std::uint16_t>{0});
  EXPECT_EQ(modbus::words_of_value(tag, std::nan(""), false), std::vector<std::uint16_t>{0});
}

constexpr const char* kLink = R"(
plc:
  modbus: client
  port: PORT
  poll: 5ms
  timeout: 2s
  groups: {slow: 50ms}
  tags:
    Start: {coil: 3, direction: in}
    Gripper: {coil: 4, direction: both}
    Held: {coil: 7, direction: out}
    Door: {discrete: 2}
    Speed: {holding: 0, direction: out, scale: 0.1}
    Force: {holding: 10, format: float32, direction: out}
    Level: {input: 5, format: int16, scale: 0.5, offset: 10, range: [-100, 100]}
    Total: {input: 20, format: uint32, group: slow}
    pick: {holding: 40, format: float32, type: pose, length: mm, angle: deg, direction: in,
           within: [[0, -0.5, 0], [0.6, 0.5, 0.4]]}
)";

class ModbusClient : public testing::Test {
 protected:
  void SetUp() override {
    if (!test::has_pymodbus()) GTEST_SKIP() << "python3-pymodbus is not installed";
    start();
  }
  void start() {
    plc = std::make_unique<Peer>(
        std::vector<std::string>{test::python(), test::modbus_peer(), "server", std::to_string(port)});
    ASSERT_EQ(plc->line(), "serving");
    ASSERT_TRUE(test::eventually([&] { return test::listens(port); }));
  }
  void connect() {
    const signals::LinkEntry entry = link_entry(kLink, port);
    link = std::make_unique<RunningLink>(entry, modbus::make_client(entry));
    ASSERT_TRUE(link->up());
  }
  void set_pose(const std::vector<float>& numbers) {
    std::string words;
    for (const float number : numbers) {
      std::uint16_t pair[2];
      modbus::number_into(number, pair, Format::float32, false);
      words += " " + std::to_string(pair[0]) + " " + std::to_string(pair[1]);
    }
    plc->ask("set hr 40" + words);
  }

  int port = test::free_port();
  std::unique_ptr<Peer> plc;
  std::unique_ptr<RunningLink> link;
};

TEST_F(ModbusClient, ReadsEveryTableOfAServerOfAnother) {
  plc->ask("set co 3 1");
  plc->ask("set di 2 1");
  plc->ask("set ir 5 65532");  // -4
  plc->ask("set ir 20 1 2");   // 65538
  connect();
  EXPECT_TRUE(link->comes("Start", true));
  EXPECT_TRUE(link->comes("Door", true));
  EXPECT_TRUE(link->comes("Level", 8));
  EXPECT_TRUE(link->comes("Total", 65538));
  plc->ask("set co 3 0");
  EXPECT_TRUE(link->comes("Start", false));
}

TEST_F(ModbusClient, WritesCoilsAndScaledRegisters) {
  connect();
  link->post("Held", true);
  link->post("Speed", 12.3);
  link->post("Force", 1.0);
  ASSERT_TRUE(link->given());
  EXPECT_EQ(plc->ask("get co 7 1"), "1");
  EXPECT_EQ(plc->ask("get hr 0 1"), "123");
  EXPECT_EQ(plc->ask("get hr 10 2"), "16256 0");
}

TEST_F(ModbusClient, ACoilOfBothSidesIsWhatWhoeverChangedItLastWants) {
  plc->ask("set co 4 1");
  link = nullptr;
  const signals::LinkEntry entry = link_entry(kLink, port);
  link = std::make_unique<RunningLink>(entry, modbus::make_client(entry));
  link->post("Gripper", false);  // before the first connection: the far side's counts
  ASSERT_TRUE(link->comes("Gripper", true));
  link->post("Gripper", false);
  ASSERT_TRUE(link->given());
  EXPECT_EQ(plc->ask("get co 4 1"), "0");
  plc->ask("set co 4 1");
  EXPECT_TRUE(link->comes("Gripper", true));
}

TEST_F(ModbusClient, APoseComesWholeOrNotAtAll) {
  set_pose({300, -100, 50, 180, 0, 90});
  connect();
  ASSERT_TRUE(test::eventually([&] { return link->look(), link->values.contains("pick"); }));
  const Pose pose = link->values.at("pick").as_point()->pose;
  EXPECT_NEAR(pose.position.x, 0.3, 1e-6);
  EXPECT_NEAR(pose.position.y, -0.1, 1e-6);
  const data::Value before = link->values.at("pick");
  set_pose({std::numeric_limits<float>::quiet_NaN(), -100, 50, 180, 0, 90});
  EXPECT_TRUE(link->refuses("not finite"));
  set_pose({900, -100, 50, 180, 0, 90});
  EXPECT_TRUE(link->refuses("x = 0.9 m is outside"));
  EXPECT_EQ(link->values.at("pick"), before);
}

TEST_F(ModbusClient, ANumberOutOfItsRangeIsRefusedAndTheOldOneStays) {
  plc->ask("set ir 5 20");
  connect();
  ASSERT_TRUE(link->comes("Level", 20));
  plc->ask("set ir 5 2000");
  EXPECT_TRUE(link->refuses("1010 is outside of -100 to 100"));
  EXPECT_EQ(link->values.at("Level"), data::Value(20));
}

TEST_F(ModbusClient, ALostServerIsToldAndFoundAgainAndGetsWhatItMissed) {
  connect();
  link->post("Held", true);
  ASSERT_TRUE(link->given());
  plc->end(SIGKILL);
  ASSERT_TRUE(link->down());
  link->look();
  ASSERT_EQ(link->losses.size(), 1u);
  link->post("Speed", 5.0);
  start();
  ASSERT_TRUE(link->up());
  ASSERT_TRUE(link->given());
  EXPECT_EQ(plc->ask("get co 7 1"), "1") << "what it was told before, it is told again";
  EXPECT_EQ(plc->ask("get hr 0 1"), "50");
}

TEST(ModbusLink, NobodyThereSaysWhereAndWhy) {
  const int port = test::free_port();
  const signals::LinkEntry entry = link_entry(kLink, port);
  RunningLink link(entry, modbus::make_client(entry));
  ASSERT_TRUE(test::eventually(
      [&] { return link.look(), link.link().state().reason.find("refused") != std::string::npos; }));
  EXPECT_NE(link.link().state().reason.find("127.0.0.1:" + std::to_string(port)), std::string::npos);
}

/// A far side that answers whatever is asked with bytes that mean nothing.
class Babbler {
 public:
  Babbler() {
    listening_ = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t length = sizeof address;
    if (::bind(listening_, reinterpret_cast<sockaddr*>(&address), length) != 0 ||
        ::listen(listening_, 4) != 0 ||
        ::getsockname(listening_, reinterpret_cast<sockaddr*>(&address), &length) != 0)
      throw std::runtime_error("no port");
    port = ntohs(address.sin_port);
    thread_ = std::thread([this] { babble(); });
  }
  ~Babbler() {
    ::shutdown(listening_, SHUT_RDWR);
    thread_.join();
    ::close(listening_);
  }
  int port = 0;

 private:
  void babble() {
    for (unsigned k = 1;; ++k) {
      const int client = ::accept(listening_, nullptr, nullptr);
      if (client < 0) return;
      char asked[300];
      std::string rubbish;
      for (unsigned i = 0; i < 1 + k * 17 % 300; ++i) rubbish += static_cast<char>(k * 91 + i * i * 7);
      if (::recv(client, asked, sizeof asked, 0) > 0)
        (void)!::send(client, rubbish.data(), rubbish.size(), MSG_NOSIGNAL);
      ::close(client);
    }
  }
  int listening_ = -1;
  std::thread thread_;
};

TEST(ModbusLink, APlcThatSendsRubbishIsALostLinkAndNoValueComesOfIt) {
  Babbler plc;
  const signals::LinkEntry entry = link_entry(
      "plc: {modbus: client, port: PORT, poll: 1ms, timeout: 200ms, tags: {A: {holding: 0, format: float32, "
      "direction: "
      "in, range: [0, 1]}, B: {coil: 0, direction: both}}}",
      plc.port);
  RunningLink link(entry, modbus::make_client(entry));
  ASSERT_TRUE(test::eventually([&] {
    return link.look(), link.link().state().losses + link.losses.size() > 0 ||
                            link.link().state().reason.find("did not answer") != std::string::npos;
  }));
  link.look();
  EXPECT_TRUE(link.values.empty());
}

constexpr const char* kServer = R"(
master:
  modbus: server
  port: PORT
  tags:
    Start: {coil: 0, direction: in}
    Gripper: {coil: 1, direction: both}
    Running: {discrete: 0}
    Count: {input: 0, format: uint32}
    Wanted: {holding: 0, format: float32, direction: in, range: [0, 10]}
    Ours: {holding: 8, direction: out}
)";

class ModbusServer : public testing::Test {
 protected:
  void SetUp() override {
    const signals::LinkEntry entry = link_entry(kServer, port);
    link = std::make_unique<RunningLink>(entry, modbus::make_server(entry));
    link->look();
    ASSERT_TRUE(test::eventually([&] { return test::listens(port); }));
  }
  int port = test::free_port();
  std::unique_ptr<RunningLink> link;
};

/// A connection of nobody's library: one that asks, or one that says nothing.
class Connection {
 public:
  explicit Connection(int port) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const timeval patience{5, 0};
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    EXPECT_EQ(::connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  }
  ~Connection() { ::close(socket_); }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  /// Whether it is told coil 0.
  bool asks() {
    const std::uint8_t request[] = {0, 1, 0, 0, 0, 6, 1, 1, 0, 0, 0, 1};
    std::uint8_t answer[32];
    return ::send(socket_, request, sizeof request, MSG_NOSIGNAL) == sizeof request &&
           ::recv(socket_, answer, sizeof answer, 0) == 10 && answer[7] == 1;
  }
  bool is_closed() {
    std::uint8_t byte = 0;
    return ::recv(socket_, &byte, 1, 0) == 0;
  }
  bool is_open_now() {
    std::uint8_t byte = 0;
    return ::recv(socket_, &byte, 1, MSG_DONTWAIT | MSG_PEEK) < 0 && errno == EAGAIN;
  }
  void say(const std::vector<std::uint8_t>& what) {
    EXPECT_EQ(::send(socket_, what.data(), what.size(), MSG_NOSIGNAL), static_cast<ssize_t>(what.size()));
  }
  /// How many bytes there are to hear, in `bytes`.
  ssize_t heard_now() { return last = ::recv(socket_, bytes, sizeof bytes, MSG_DONTWAIT); }

  std::uint8_t bytes[64]{};
  ssize_t last = 0;

 private:
  int socket_;
};

TEST_F(ModbusServer, ConnectionsThatAskNothingLockNobodyOut) {
  Connection plc(port);
  ASSERT_TRUE(plc.asks());
  std::deque<Connection> idle;
  for (int i = 0; i < 50; ++i) {
    idle.emplace_back(port);
    ASSERT_TRUE(plc.asks()) << "after " << i << " idle ones, who asks is still there";
  }
  Connection late(port);
  EXPECT_TRUE(late.asks()) << "and who comes late is let in";
  EXPECT_TRUE(plc.asks());
  EXPECT_TRUE(idle.front().is_closed()) << "the one that was silent for longest";
}

/// A server without a thread, so that the test has its clock.
class SteppedModbusServer : public testing::Test {
 protected:
  SteppedModbusServer() : server(modbus::make_server(link_entry(kServer, port))) { server->open(); }
  /// A round at `now`, ms; what has come is there.
  void step(int now) {
    signals::LinkReport news;
    server->exchange({}, Nanoseconds{now} * 1'000'000, 20'000'000, news);
  }
  /// Whether it is answered within a few rounds at one time.
  bool answers(Connection& client, int now) {
    client.say({0, 1, 0, 0, 0, 6, 1, 1, 0, 0, 0, 1});
    for (int i = 0; i < 50; ++i) {
      step(now);
      if (client.heard_now() == 10) return true;
    }
    return false;
  }
  int port = test::free_port();
  std::unique_ptr<signals::LinkPort> server;
};

TEST_F(SteppedModbusServer, UnfinishedRequestsDelayNobodyAndAreClosedInTime) {
  std::deque<Connection> unfinished;
  for (std::uint8_t i = 0; i < 10; ++i) {
    unfinished.emplace_back(port);
    std::vector<std::uint8_t> begin{0, 1, 0, 0, 0, 6, 1, 1, 0, 0, 0, 1};
    begin.resize(std::size_t{1} + i);
    unfinished.back().say(begin);
  }
  Connection good(port);
  for (int i = 0; i < 12; ++i) step(0);  // all are accepted
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(answers(good, 10 * i)) << i;
  for (Connection& each : unfinished) EXPECT_TRUE(each.is_open_now()) << "it was answered while they were there";
  unfinished.front().say({1, 0, 0, 0, 6, 1, 1, 0, 0, 0, 1});
  for (int i = 0; i < 50 && unfinished.front().heard_now() != 10; ++i) step(300);
  EXPECT_EQ(unfinished.front().last, 10) << "one that ends is answered";
  step(static_cast<int>(bounds::kModbusFrame_ms) + 1);
  for (std::size_t i = 1; i < unfinished.size(); ++i) EXPECT_TRUE(unfinished[i].is_closed()) << i;
  EXPECT_TRUE(answers(good, static_cast<int>(bounds::kModbusFrame_ms) + 10));
  EXPECT_TRUE(answers(unfinished.front(), static_cast<int>(bounds::kModbusFrame_ms) + 20));
}

TEST_F(SteppedModbusServer, SeveralRequestsInOnePieceAndOneInManyAreAllAnswered) {
  Connection client(port);
  const std::vector<std::uint8_t> request{0, 1, 0, 0, 0, 6, 1, 1, 0, 0, 0, 1};
  std::vector<std::uint8_t> three;
  for (int i = 0; i < 3; ++i) three.insert(three.end(), request.begin(), request.end());
  client.say(three);
  ssize_t answered = 0;
  for (int i = 0; i < 50 && answered < 30; ++i) step(i), answered += std::max<ssize_t>(0, client.heard_now());
  EXPECT_EQ(answered, 30);
  for (const std::uint8_t byte : request) client.say({byte}), step(60);
  for (int i = 0; i < 50 && client.heard_now() != 10; ++i) step(70);
  EXPECT_EQ(client.last, 10);
}

TEST_F(SteppedModbusServer, WhatIsNoModbusIsClosedAndWhatCannotBeIsAnException) {
  const std::vector<std::uint8_t> broken[] = {
      {0, 1, 0, 1, 0, 6, 1, 1, 0, 0, 0, 1},              // another protocol
      {0, 1, 7},                                         // the same, and more may come
      {0, 1, 0, 0, 0, 1, 1},                             // no function
      {0, 1, 0, 0, 0, 255},                              // longer than any
      {0, 1, 0, 0, 255, 255},                            //
      {0, 1, 0, 0, 0, 7, 1, 1, 0, 0, 0, 1, 0},           // a byte too many for its function
      {0, 1, 0, 0, 0, 5, 1, 3, 0, 0, 0},                 // one too few
      {0, 1, 0, 0, 0, 9, 1, 16, 0, 0, 0, 1, 4, 0, 1},    // says four bytes, has two
      {0, 1, 0, 0, 0, 3, 1, 15, 0},                      // ends before its count
      {0, 1, 0, 0, 0, 13, 1, 23, 0, 0, 0, 1, 0, 0, 0, 1, 4, 0, 1}};
  for (const auto& bytes : broken) {
    Connection client(port);
    client.say(bytes);
    for (int i = 0; i < 50 && client.is_open_now(); ++i) step(0);
    EXPECT_FALSE(client.is_open_now()) << testing::PrintToString(bytes);
  }
  const std::pair<std::vector<std::uint8_t>, int> refused[] = {
      {{0, 1, 0, 0, 0, 2, 1, 99}, 1},                              // no such function
      {{0, 1, 0, 0, 0, 6, 1, 1, 0, 0, 0, 0}, 3},                   // no coils
      {{0, 1, 0, 0, 0, 6, 1, 3, 0, 0, 0, 126}, 3},                 // more registers than there may be
      {{0, 1, 0, 0, 0, 6, 1, 5, 0, 0, 1, 2}, 3},                   // neither on nor off
      {{0, 1, 0, 0, 0, 9, 1, 16, 0, 0, 0, 2, 2, 0, 1}, 3},         // two registers in two bytes
      {{0, 1, 0, 0, 0, 6, 1, 3, 99, 0, 0, 1}, 2}};                 // no such address
  Connection client(port);
  for (const auto& [bytes, code] : refused) {
    client.say(bytes);
    for (int i = 0; i < 50 && client.heard_now() != 9; ++i) step(0);
    ASSERT_EQ(client.last, 9) << testing::PrintToString(bytes);
    EXPECT_EQ(client.bytes[7], bytes[7] | 0x80);
    EXPECT_EQ(client.bytes[8], code) << testing::PrintToString(bytes);
  }
  EXPECT_TRUE(answers(client, 0)) << "and the connection stays";
}

TEST(ModbusFrame, NoBytesAreReadBeyondTheirEndAndNoFrameIsLongerThanTheyAre) {
  std::mt19937 random(7);
  for (int round = 0; round < 200'000; ++round) {
    std::vector<std::uint8_t> bytes(random() % 300);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random() % 4 == 0 ? random() : random() % 8);
    if (bytes.size() > 6 && random() % 2 == 0) {
      bytes[2] = bytes[3] = bytes[4] = 0;
      bytes[5] = static_cast<std::uint8_t>(bytes.size() - 6);
    }
    const modbus::Frame frame = modbus::first_frame(bytes);
    ASSERT_LE(frame.length, bytes.size());
    if (frame.kind == modbus::Frame::Kind::request) ASSERT_GE(frame.length, 12u);
    const std::vector<std::uint8_t> cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(frame.length));
    if (frame.length > 0) {
      EXPECT_EQ(modbus::first_frame(std::span(cut).first(frame.length - 1)).kind, modbus::Frame::Kind::unfinished);
    }
  }
}

class RequestedModbusServer : public ModbusServer {
 protected:
  void SetUp() override {
    if (!test::has_pymodbus()) GTEST_SKIP() << "python3-pymodbus is not installed";
    ModbusServer::SetUp();
    master = std::make_unique<Peer>(
        std::vector<std::string>{test::python(), test::modbus_peer(), "client", std::to_string(port)});
    ASSERT_EQ(master->line(), "connected");
  }
  std::unique_ptr<Peer> master;
};

TEST_F(RequestedModbusServer, OffersWhatTheCellSetsAndTakesWhatIsWritten) {
  link->post("Running", true);
  link->post("Count", 65537);
  ASSERT_TRUE(link->given());
  EXPECT_EQ(master->ask("read di 0 1"), "1");
  EXPECT_EQ(master->ask("read ir 0 2"), "1 1");
  EXPECT_TRUE(link->up());
  EXPECT_EQ(master->ask("write co 0 1"), "done");
  EXPECT_TRUE(link->comes("Start", true));
  EXPECT_EQ(master->ask("write hr 0 16256 0"), "done");
  EXPECT_TRUE(link->comes("Wanted", 1));
}

TEST_F(RequestedModbusServer, ACoilOfBothSidesGoesBothWays) {
  EXPECT_EQ(master->ask("write co 1 1"), "done");
  ASSERT_TRUE(link->comes("Gripper", true));
  link->post("Gripper", false);
  ASSERT_TRUE(link->given());
  EXPECT_EQ(master->ask("read co 1 1"), "0");
}

TEST_F(RequestedModbusServer, WhatIsTheCellsToSayIsPutRight) {
  link->post("Ours", 7);
  ASSERT_TRUE(link->given());
  EXPECT_EQ(master->ask("write hr 8 99"), "done");
  EXPECT_TRUE(test::eventually([&] { return master->ask("read hr 8 1") == "7"; }));
}

TEST_F(RequestedModbusServer, AnAddressThatThereIsNotIsAnExceptionAndTheLinkStays) {
  EXPECT_TRUE(master->ask("read hr 5000 2").starts_with("error"));
  EXPECT_EQ(master->ask("read hr 8 1"), "0");
  EXPECT_TRUE(link->up());
}

TEST_F(RequestedModbusServer, RubbishIsNoRequestAndSpoilsNothing) {
  EXPECT_EQ(master->ask("write hr 0 16256 0"), "done");
  ASSERT_TRUE(link->comes("Wanted", 1));
  for (int k = 0; k < 20; ++k) {
    const int fd = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    ASSERT_EQ(::connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    std::string rubbish;
    for (int i = 0; i < 30 + 13 * k; ++i) rubbish += static_cast<char>(k * 37 + i * 101);
    (void)!::send(fd, rubbish.data(), rubbish.size(), MSG_NOSIGNAL);
    ::close(fd);
  }
  EXPECT_EQ(master->ask("write co 0 1"), "done");
  EXPECT_TRUE(link->comes("Start", true));
  link->look();
  EXPECT_EQ(link->values.at("Wanted"), data::Value(1));
}

TEST_F(RequestedModbusServer, AMasterThatWritesANumberThatIsNoneIsRefused) {
  EXPECT_EQ(master->ask("write hr 0 32704 0"), "done");  // NaN
  EXPECT_TRUE(link->refuses("not a finite number"));
  EXPECT_EQ(master->ask("write hr 0 17000 0"), "done");
  EXPECT_TRUE(link->refuses("is outside of 0 to 10"));
  EXPECT_FALSE(link->values.contains("Wanted"));
}

TEST(ModbusBothEnds, OneCellAsksAnother) {
  const int port = test::free_port();
  const signals::LinkEntry server = link_entry(kServer, port);
  RunningLink there(server, modbus::make_server(server));
  const signals::LinkEntry client = link_entry(R"(
cell:
  modbus: client
  port: PORT
  poll: 2ms
  tags: {Go: {coil: 0, direction: out}, Gripper: {coil: 1, direction: both, first: cell}, Runs: {discrete: 0}}
)",
                                               port);
  RunningLink here(client, modbus::make_client(client));
  there.look();
  here.post("Go", true);
  here.post("Gripper", true);
  here.look();
  EXPECT_TRUE(there.comes("Start", true));
  EXPECT_TRUE(there.comes("Gripper", true)) << "the cell's value counts first where the link says so";
  there.post("Running", true);
  EXPECT_TRUE(here.comes("Runs", true));
}

}  // namespace
}  // namespace polyarm
