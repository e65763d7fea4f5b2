/// The simulated controller as a client sees it.
#include <chrono>

#include "tests/ur/rig.hpp"

namespace polyarm {
namespace {

using namespace test;
using ur::PackageType;

ur::FarSideOptions any_ports() {
  ur::FarSideOptions options;
  options.machine.facts = ur::facts_of(ur_model());
  options.rtde = options.dashboard = options.primary = options.secondary = 0;
  return options;
}

/// A client that waits for what it needs.
class Client {
 public:
  explicit Client(int port) { socket_ = wire::connect_tcp("127.0.0.1", port, 5'000'000'000, why_); }
  bool send(const std::vector<std::uint8_t>& bytes) { return wire::send_frame(socket_.number(), bytes); }
  bool send(const std::string& text) { return wire::send_frame(socket_.number(), text); }
  std::string line() {
    for (;;) {
      if (const std::size_t end = text_.find('\n'); end != std::string::npos) {
        const std::string out = text_.substr(0, end);
        text_.erase(0, end + 1);
        return out;
      }
      if (!more()) return "(closed)";
    }
  }
  /// The payload of the next package of this type.
  std::vector<std::uint8_t> package(PackageType type) {
    for (;;) {
      for (auto at = found_.begin(); at != found_.end(); ++at)
        if (at->first == type) {
          const auto out = at->second;
          found_.erase(at);
          return out;
        }
      if (!more()) return {};
      frames_.feed({reinterpret_cast<const std::uint8_t*>(text_.data()), text_.size()},
                   [&](PackageType came, wire::Bytes payload) {
                     found_.emplace_back(came, std::vector(payload.begin(), payload.end()));
                   });
      text_.clear();
    }
  }

 private:
  bool more() {
    std::array<std::uint8_t, 4096> bytes;
    if (!wire::wait_readable(socket_.number(), 10'000'000'000)) return false;
    const wire::Received got = wire::receive(socket_.number(), bytes);
    text_.append(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(got.count));
    return got.got == wire::Got::bytes;
  }
  std::string why_, text_;
  Descriptor socket_;
  ur::FrameStream frames_;
  std::vector<std::pair<PackageType, std::vector<std::uint8_t>>> found_;
};

std::vector<std::uint8_t> octets(const std::string& text) {
  return {text.begin(), text.end()};
}

TEST(FarSide, NegotiatesVersionsRecipesAndSendsData) {
  FarSide far(any_ports());
  Client client(far.rtde_port());
  client.send(ur::frame(PackageType::protocol_version, wire::Writer().u16(3)));
  EXPECT_EQ(client.package(PackageType::protocol_version), octets(std::string(1, '\0')));
  client.send(ur::frame(PackageType::protocol_version, wire::Writer().u16(2)));
  EXPECT_EQ(client.package(PackageType::protocol_version), octets("\x01"));
  client.send(ur::frame(PackageType::setup_outputs, wire::Writer().f64(500).text("actual_q,nonsense")));
  EXPECT_EQ(client.package(PackageType::setup_outputs), octets(std::string(1, '\0') + "VECTOR6D,NOT_FOUND"));
  client.send(ur::frame(PackageType::start));
  EXPECT_EQ(client.package(PackageType::start), octets(std::string(1, '\0'))) << "nothing to send";
  client.send(ur::frame(PackageType::setup_outputs, wire::Writer().f64(500).text("timestamp,robot_mode")));
  EXPECT_EQ(client.package(PackageType::setup_outputs), octets("\x01"
                                                               "DOUBLE,INT32"));
  client.send(ur::frame(PackageType::start));
  EXPECT_EQ(client.package(PackageType::start), octets("\x01"));
  const auto data = client.package(PackageType::data);
  ASSERT_EQ(data.size(), 1u + 8 + 4);
  EXPECT_EQ(data[0], 1) << "the recipe";
  EXPECT_EQ(data[12], ur::running);
  client.send(ur::frame(PackageType::pause));
  EXPECT_EQ(client.package(PackageType::pause), octets("\x01"));
}

TEST(FarSide, ProtocolOneHasNoFrequencyAndNoRecipe) {
  FarSide far(any_ports());
  Client client(far.rtde_port());
  client.send(ur::frame(PackageType::protocol_version, wire::Writer().u16(1)));
  client.package(PackageType::protocol_version);
  client.send(ur::frame(PackageType::setup_outputs, octets("timestamp")));
  EXPECT_EQ(client.package(PackageType::setup_outputs), octets("DOUBLE"));
  client.send(ur::frame(PackageType::start));
  client.package(PackageType::start);
  EXPECT_EQ(client.package(PackageType::data).size(), 8u);
}

TEST(FarSide, InputsBelongToOneClientUntilItGoes) {
  FarSide far(any_ports());
  const auto ask = [](Client& client) {
    client.send(ur::frame(PackageType::protocol_version, wire::Writer().u16(2)));
    client.package(PackageType::protocol_version);
    client.send(ur::frame(PackageType::setup_inputs, octets("input_int_register_24")));
    return client.package(PackageType::setup_inputs);
  };
  {
    Client first(far.rtde_port()), second(far.rtde_port());
    EXPECT_EQ(ask(first), octets("\x01"
                                 "INT32"));
    EXPECT_EQ(ask(second), octets(std::string(1, '\0') + "IN_USE"));
  }
  for (;;) {  // the controller notices the end of a connection when it reads next
    Client third(far.rtde_port());
    if (ask(third) == octets("\x01"
                             "INT32"))
      break;
  }
}

TEST(FarSide, TheDashboardSwitchesTheRobotOnAndUnlocksIt) {
  ur::FarSideOptions options = any_ports();
  options.machine.on = false;
  FarSide far(options);
  far.hold_clock(true);
  Client client(far.dashboard_port());
  const auto ask = [&](const std::string& line) {
    client.send(line + "\n");
    return client.line();
  };
  EXPECT_EQ(client.line(), "Connected: Universal Robots Dashboard Server");
  EXPECT_EQ(ask("robotmode"), "Robotmode: POWER_OFF");
  EXPECT_EQ(ask("power on"), "Powering on");
  EXPECT_EQ(ask("robotmode"), "Robotmode: IDLE");
  EXPECT_EQ(ask("brake release"), "Brake releasing");
  EXPECT_EQ(ask("robotmode"), "Robotmode: RUNNING");
  far.order("protective_stop");
  EXPECT_EQ(ask("safetystatus"), "Safetystatus: PROTECTIVE_STOP");
  EXPECT_NE(ask("unlock protective stop").find("until 5s"), std::string::npos);
  for (int i = 0; i < 2600; ++i) far.step();
  EXPECT_EQ(ask("unlock protective stop"), "Protective stop releasing");
  EXPECT_EQ(ask("safetymode"), "Safetymode: NORMAL");
  far.order("local");
  EXPECT_NE(ask("power off").find("not allowed"), std::string::npos);
  EXPECT_EQ(ask("is in remote control"), "false");
  EXPECT_NE(ask("make coffee").find("could not understand"), std::string::npos);
  EXPECT_EQ(ask("quit"), "Disconnected");
}

TEST(FarSide, ForeignBytesOnAnyPortHarmNobody) {
  FarSide far(any_ports());
  std::uint32_t seed = 1;
  for (int round = 0; round < 50; ++round) {
    std::vector<std::uint8_t> bytes(1 + round % 60);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>((seed = seed * 1664525u + 1013904223u) >> 24);
    if (round % 2) bytes[0] = 0, bytes[bytes.size() / 2] = "VvMUOISP"[round % 8];
    for (const int port : {far.rtde_port(), far.primary_port(), far.dashboard_port()}) {
      Client client(port);
      client.send(bytes);
    }
  }
  Client client(far.dashboard_port());
  EXPECT_EQ(client.line(), "Connected: Universal Robots Dashboard Server");
}

TEST(FarSide, AWrongFaultIsRefusedWithTheRightNames) {
  FarSide far(any_ports());
  try {
    far.order("protectiv_stop");
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("did you mean 'protective_stop'"), std::string::npos) << e.what();
  }
  EXPECT_THROW(far.order("late=-3"), Error);
  EXPECT_THROW(far.order("late=x"), Error);
}

TEST(FarSide, IdleConnectionsKeepNoDriverAway) {
  UrRig rig;
  std::vector<Client> idle;
  FarSide& far = rig.far();
  for (std::uint32_t i = 0; i < bounds::kFarSideClients; ++i)
    for (const int port : {far.rtde_port(), far.primary_port(), far.secondary_port(), far.dashboard_port()})
      idle.emplace_back(port);
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(20, [](int) {}));
  EXPECT_EQ(Client(far.dashboard_port()).line(), "Connected: Universal Robots Dashboard Server");
}

TEST(FarSide, APortThatIsTakenIsNamed) {
  FarSide far(any_ports());
  ur::FarSideOptions second = any_ports();
  second.rtde = far.rtde_port();
  try {
    FarSide other(second);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.problems().front().code, "no-port");
    EXPECT_NE(std::string(e.what()).find(std::to_string(far.rtde_port())), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace polyarm
