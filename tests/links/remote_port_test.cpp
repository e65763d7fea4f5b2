/// Links whose protocol is spoken by a process of its own: values, losses, and what a process that has been taken
/// over can do.
#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <csignal>
#include <fstream>
#include <limits>
#include <random>
#include <string>

#include "links/modbus/port.hpp"
#include "polyarm/base/bounds.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/signals/link_exchange.hpp"
#include "polyarm/signals/remote_port.hpp"
#include "tests/links/running_link.hpp"
#include "tests/support/command.hpp"

namespace polyarm::remote_port_tests {
namespace {

using process::Packer;
using process::Unpacker;
using signals::Direction;
using signals::LinkEntry;
using signals::LinkReport;
using signals::LinkTag;
using signals::RemotePort;
using test::eventually;
using test::link_entry;
using test::RunningLink;

std::string program_of(const std::string& kind) {
  return (std::filesystem::path(POLYARM_COMMAND).parent_path() / "drivers" / signals::link_program(kind)).string();
}

/// What the kernel says of a process: "NoNewPrivs" → "1".
std::string status_of(int process, const std::string& key) {
  std::ifstream file("/proc/" + std::to_string(process) + "/status");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with(key + ":")) return line.substr(line.find_first_not_of(" \t", key.size() + 1));
  return "";
}

constexpr const char* kCellServer = R"(
cell:
  modbus: server
  port: PORT
  tags:
    Start: {coil: 0, direction: in}
    Gripper: {coil: 1, direction: both}
    Count: {input: 0, format: uint32}
    Wanted: {holding: 0, format: float32, direction: in, range: [0, 10]}
)";
constexpr const char* kPlcClient = R"(
plc:
  modbus: client
  port: PORT
  poll: 2ms
  tags:
    Go: {coil: 0, direction: out}
    Gripper: {coil: 1, direction: both, first: cell}
    Count: {input: 0, format: uint32}
    Wanted: {holding: 0, format: float32, direction: out}
)";

/// A cell's server in a process of its own, and a PLC in this one.
class RemoteModbus : public testing::Test {
 protected:
  RemoteModbus() {
    const LinkEntry server = link_entry(kCellServer, port);
    auto owned = std::make_unique<RemotePort>(server, program_of("modbus"));
    remote = owned.get();
    cell = std::make_unique<RunningLink>(server, std::move(owned));
    cell->look();
    const LinkEntry client = link_entry(kPlcClient, port);
    plc = std::make_unique<RunningLink>(client, modbus::make_client(client));
  }
  /// Its process id once there is one, and another than `before`.
  int process(int before = 0) {
    EXPECT_TRUE(eventually([&] {
      cell->look();
      if (plc) plc->look();
      return remote->process() > 0 && remote->process() != before;
    }));
    return remote->process();
  }
  int port = test::free_port();
  RemotePort* remote = nullptr;
  std::unique_ptr<RunningLink> cell, plc;
};

TEST_F(RemoteModbus, ValuesGoBothWays) {
  plc->post("Go", true);
  plc->post("Wanted", 2.5);
  cell->post("Count", 70000);
  plc->look();
  EXPECT_TRUE(cell->comes("Start", true));
  EXPECT_TRUE(cell->comes("Wanted", 2.5));
  EXPECT_TRUE(plc->comes("Count", 70000));
  cell->post("Gripper", true);
  EXPECT_TRUE(plc->comes("Gripper", true));
  plc->post("Wanted", 99);
  EXPECT_TRUE(cell->refuses("99 is outside of 0 to 10"));
}

TEST_F(RemoteModbus, ItsProcessHasNoRightsToGainAndEndsWithTheLink) {
  const int child = process();
  ASSERT_TRUE(cell->up());
  EXPECT_EQ(status_of(child, "NoNewPrivs"), "1");
  EXPECT_EQ(status_of(child, "Seccomp"), "2") << "its calls are filtered";
  EXPECT_EQ(status_of(child, "PPid"), std::to_string(::getpid()));
  cell = nullptr;
  EXPECT_EQ(status_of(child, "PPid"), "");
}

TEST_F(RemoteModbus, KilledItIsALostLinkThatComesBackWithAllThatItHad) {
  plc->post("Go", true);
  plc->post("Wanted", 7);
  cell->post("Count", 5);
  plc->look();
  ASSERT_TRUE(cell->comes("Start", true));
  ASSERT_TRUE(cell->comes("Wanted", 7));
  ASSERT_TRUE(plc->comes("Count", 5));
  for (int round = 1, child = 0; round <= 3; ++round) {
    child = process(child);
    ASSERT_TRUE(cell->up());
    plc->values.clear();
    cell->values.clear();
    ASSERT_EQ(::kill(child, round == 1 ? SIGABRT : SIGKILL), 0);
    ASSERT_TRUE(eventually([&] { return cell->look(), cell->losses.size() == static_cast<std::size_t>(round); }));
    EXPECT_NE(cell->losses.back().find(round == 1 ? "(polyarm_link_modbus) was ended by SIGABRT"
                                                  : "(polyarm_link_modbus) was ended by SIGKILL"),
              std::string::npos)
        << cell->losses.back();
    EXPECT_TRUE(plc->comes("Count", 5)) << "what the cell had set is offered again";
    cell->look();
    EXPECT_TRUE(cell->values.empty()) << "and nothing comes that the PLC had not changed";
  }
  plc->post("Wanted", 3);
  EXPECT_TRUE(cell->comes("Wanted", 3));
}

TEST_F(RemoteModbus, AServerThatIsMadeAnewStillHoldsWhatAMasterWroteOnce) {
  plc->post("Wanted", 7);
  plc->look();
  ASSERT_TRUE(cell->comes("Wanted", 7));
  plc = nullptr;
  const int child = process();
  ASSERT_EQ(::kill(child, SIGKILL), 0);
  ASSERT_TRUE(eventually([&] { return cell->look(), remote->process() > 0 && remote->process() != child; }));
  const LinkEntry reader = link_entry(
      "plc: {modbus: client, port: PORT, poll: 2ms, tags: {Seen: {holding: 0, format: float32, direction: in}}}", port);
  RunningLink other(reader, modbus::make_client(reader));
  EXPECT_TRUE(other.comes("Seen", 7));
}

TEST_F(RemoteModbus, AProcessThatNoLongerAnswersIsEndedAndStartedAgain) {
  const LinkEntry entry = link_entry(
      "plc: {modbus: server, port: PORT, timeout: 20ms, tags: {A: {coil: 0, direction: in}}}", test::free_port());
  signals::RemotePortOptions options;
  options.patience = 300'000'000;
  RemotePort port(entry, program_of("modbus"), options);
  port.open();
  const int child = port.process();
  ASSERT_GT(child, 0);
  ::kill(child, SIGSTOP);
  LinkReport news;
  try {
    port.exchange({}, 0, 0, news);
    FAIL() << "a stopped process has answered";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("did not answer for"), std::string::npos) << e.what();
  }
  EXPECT_EQ(status_of(child, "PPid"), "");
  port.open();
  EXPECT_NO_THROW(port.exchange({}, 0, 0, news));
}

constexpr const char* kHangs = "hangs: it sent nothing for 1 s, and was ended";

TEST_F(RemoteModbus, AServersProcessThatIsStoppedIsALostLinkAndStartedAgain) {
  plc->post("Wanted", 7);
  cell->post("Count", 5);
  plc->look();
  ASSERT_TRUE(cell->comes("Wanted", 7));
  ASSERT_TRUE(plc->comes("Count", 5));
  const int child = process();
  plc->values.clear();
  ASSERT_EQ(::kill(child, SIGSTOP), 0);
  ASSERT_TRUE(cell->down());
  ASSERT_TRUE(eventually([&] { return cell->look(), cell->losses.size() == 1; }));
  EXPECT_NE(cell->losses[0].find(kHangs), std::string::npos) << cell->losses[0];
  EXPECT_EQ(status_of(child, "PPid"), "") << "it is still there";
  ASSERT_TRUE(cell->up());
  EXPECT_NE(process(child), child);
  EXPECT_TRUE(plc->comes("Count", 5)) << "what the cell had set is offered again";
}

TEST(RemotePortTest, AClientsProcessThatIsStoppedIsALostLinkAndStartedAgain) {
  const int port = test::free_port();
  const LinkEntry server = link_entry(kCellServer, port), client = link_entry(kPlcClient, port);
  RunningLink far(server, modbus::make_server(server));
  far.look();
  auto owned = std::make_unique<RemotePort>(client, program_of("modbus"));
  RemotePort& remote = *owned;
  RunningLink cell(client, std::move(owned));
  far.post("Count", 3);
  ASSERT_TRUE(cell.comes("Count", 3));
  const int child = remote.process();
  ASSERT_EQ(::kill(child, SIGSTOP), 0);
  ASSERT_TRUE(eventually([&] { return cell.look(), cell.losses.size() == 1; }));
  EXPECT_NE(cell.losses[0].find(kHangs), std::string::npos) << cell.losses[0];
  far.post("Count", 4);
  ASSERT_TRUE(cell.comes("Count", 4));
  EXPECT_NE(remote.process(), child);
}

/// What was heard ages while the process is asked, and not only once it answers.
TEST(RemotePortTest, AValueGrowsStaleWhileTheProcessHangs) {
  struct Asked : signals::LinkPort {
    std::atomic<int>& rounds;
    std::atomic<bool>& over;
    Asked(std::atomic<int>& r, std::atomic<bool>& o) : rounds(r), over(o) {}
    void open() override {}
    void close() noexcept override {}
    bool waits() const override { return true; }
    void exchange(const std::vector<signals::LinkValue>&, Nanoseconds, Nanoseconds, LinkReport& news) override {
      if (++rounds == 1) return news.seen.push_back(0);
      while (!over) ::usleep(1000);
    }
  };
  LinkEntry entry = link_entry(
      "broker: {mqtt: client, port: PORT, tags: {Level: {topic: l, type: number, direction: in, stale: 50ms}}}", 1);
  std::atomic<int> rounds{0};
  std::atomic<bool> over{false};
  RunningLink cell(entry, std::make_unique<Asked>(rounds, over));
  ASSERT_TRUE(eventually([&] { return cell.look(), rounds == 2; }));
  EXPECT_TRUE(eventually([&] { return cell.link().state().stale[0] != 0; }, 5));
  EXPECT_EQ(rounds, 2);
  over = true;
}

TEST(RemotePortTest, AFarSideThatIsNotThereIsSaidAsEver) {
  const int port = test::free_port();
  const LinkEntry entry = link_entry(kPlcClient, port);
  RemotePort remote(entry, program_of("modbus"));
  try {
    remote.open();
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("127.0.0.1:" + std::to_string(port) + " cannot be reached"), std::string::npos)
        << e.what();
  }
}

TEST(RemotePortTest, AProgramThatIsNoneOfOursIsALostLink) {
  RemotePort port(link_entry(kPlcClient, 1), "/bin/false");
  EXPECT_THROW(port.open(), Error);
  RemotePort missing(link_entry(kPlcClient, 1), "/no/such/program");
  EXPECT_THROW(missing.open(), Error);
}

TEST(RemotePortTest, ACellThatEndsDoesNotWaitForAFarSideThatTakesItsTime) {
  const LinkEntry entry = link_entry(kPlcClient, 1);
  RemotePort port(entry, "/bin/cat");  // which answers nothing
  port.give_up();
  EXPECT_THROW(port.open(), Error);
}

TEST(RemoteMqtt, APasswordGoesToTheProcessAndNoFile) {
  const auto folder = std::filesystem::temp_directory_path() / ("polyarm_remote_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  LinkEntry entry =
      link_entry("broker: {mqtt: client, port: PORT, user: me, tags: {A: {topic: a, direction: in}}}", 1);
  entry.password_file = (folder / "broker.password").string();
  EXPECT_THROW(RemotePort(entry, program_of("mqtt")), Error) << "told when the cell is built";
  write_file_atomically(entry.password_file, "open sesame\n");
  EXPECT_NO_THROW(RemotePort(entry, program_of("mqtt")));
  std::filesystem::remove_all(folder);
}

TEST(RemoteMqtt, StoppedItIsALostLinkAndItsValuesComeAgain) {
  if (!test::has_mosquitto()) GTEST_SKIP() << "mosquitto is not installed";
  const int port = test::free_port();
  test::Peer broker(std::vector<std::string>{"/usr/sbin/mosquitto", "-p", std::to_string(port)});
  ASSERT_TRUE(eventually([&] { return test::listens(port); }));
  const LinkEntry entry = link_entry(
      "broker: {mqtt: client, port: PORT, tags: {Kind: {topic: kind, type: text, direction: both, retain: true}}}",
      port);
  auto owned = std::make_unique<RemotePort>(entry, program_of("mqtt"));
  RemotePort& remote = *owned;
  RunningLink cell(entry, std::move(owned));
  cell.post("Kind", "red");
  ASSERT_TRUE(cell.up());
  ASSERT_TRUE(cell.given());
  const int child = remote.process();
  ASSERT_EQ(::kill(child, SIGSTOP), 0);
  ASSERT_TRUE(eventually([&] { return cell.look(), cell.losses.size() == 1; }));
  EXPECT_NE(cell.losses[0].find(kHangs), std::string::npos) << cell.losses[0];
  cell.post("Kind", "blue");
  ASSERT_TRUE(cell.given());
  EXPECT_NE(remote.process(), child);
  RunningLink other(entry, std::make_unique<RemotePort>(entry, program_of("mqtt")));
  EXPECT_TRUE(other.comes("Kind", "blue"));
}

TEST(RemoteMqtt, KilledItIsALostLinkAndItsValuesComeAgain) {
  if (!test::has_mosquitto()) GTEST_SKIP() << "mosquitto is not installed";
  const int port = test::free_port();
  test::Peer broker(std::vector<std::string>{"/usr/sbin/mosquitto", "-p", std::to_string(port)});
  ASSERT_TRUE(eventually([&] { return test::listens(port); }));
  const LinkEntry entry = link_entry(R"(
broker: {mqtt: client, port: PORT, tags: {Kind: {topic: kind, type: text, direction: both, retain: true},
  Level: {topic: level, type: number, direction: in}}}
)",
                                     port);
  auto owned = std::make_unique<RemotePort>(entry, program_of("mqtt"));
  RemotePort& remote = *owned;
  RunningLink cell(entry, std::move(owned));
  ASSERT_TRUE(cell.up());
  cell.post("Kind", "red");
  ASSERT_TRUE(cell.given());
  const int child = remote.process();
  ASSERT_EQ(::kill(child, SIGKILL), 0);
  ASSERT_TRUE(eventually([&] { return cell.look(), cell.losses.size() == 1; }));
  EXPECT_NE(cell.losses[0].find("(polyarm_link_mqtt) was ended by SIGKILL"), std::string::npos) << cell.losses[0];
  ASSERT_TRUE(cell.up());
  EXPECT_NE(remote.process(), child);
  RunningLink other(entry, std::make_unique<RemotePort>(entry, program_of("mqtt")));
  EXPECT_TRUE(other.comes("Kind", "red"));
}

// --- what may be said

LinkEntry entry_of_all_kinds() {
  return link_entry(R"(
broker:
  mqtt: client
  port: PORT
  user: me
  will: {topic: gone, text: bye}
  tags:
    Flag: {topic: flag, type: bool, direction: in}
    Level: {topic: level, type: number, direction: both, range: [-1, 5]}
    Kind: {topic: kind, type: text, direction: in, json: true, field: a.b}
    Place: {topic: place, type: pose, direction: in, within: [[0, 0, 0], [1, 1, 1]]}
    Out: {topic: out, type: number, direction: out}
)",
                    1883);
}

TEST(LinkExchange, AnEntryArrivesWhole) {
  LinkEntry entry = entry_of_all_kinds();
  entry.password = "secret";
  entry.groups = {{"slow", 5}, {"fast", 7}};
  std::vector<std::byte> bytes, again;
  Packer first(bytes);
  signals::pack(first, entry);
  Unpacker in(bytes);
  const LinkEntry copy = signals::unpack_entry(in);
  ASSERT_TRUE(in.good());
  EXPECT_TRUE(in.rest().empty());
  Packer second(again);
  signals::pack(second, copy);
  EXPECT_EQ(bytes, again);
  EXPECT_EQ(copy.tags.at(2).field, "a.b");
  EXPECT_EQ(copy.password, "secret");
  EXPECT_EQ(copy.groups.at("fast"), 7);
}

bool accepted(const LinkReport& news) {
  std::vector<std::byte> bytes;
  Packer out(bytes);
  signals::pack(out, news);
  Unpacker in(bytes);
  LinkReport got;
  return signals::unpack_reports(in, entry_of_all_kinds(), got);
}

LinkReport with(std::size_t tag, data::Value value) {
  LinkReport out;
  out.values.push_back({tag, std::move(value)});
  return out;
}

TEST(LinkExchange, OnlyWhatAPortMayBringIsTaken) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  data::Point place;
  place.pose.position = {0.5, 0.5, 0.5};
  EXPECT_TRUE(accepted(with(0, true)));
  EXPECT_TRUE(accepted(with(1, 5)));
  EXPECT_TRUE(accepted(with(2, "red")));
  EXPECT_TRUE(accepted(with(3, place)));
  EXPECT_FALSE(accepted(with(5, true))) << "no such tag";
  EXPECT_FALSE(accepted(with(0, 1))) << "another kind";
  EXPECT_FALSE(accepted(with(1, nan)));
  EXPECT_FALSE(accepted(with(1, 5.5))) << "out of its range";
  EXPECT_FALSE(accepted(with(2, std::string(bounds::kTextBytes + 1, 'x'))));
  EXPECT_FALSE(accepted(with(4, 1))) << "it goes out";
  place.pose.position.x = 1.5;
  EXPECT_FALSE(accepted(with(3, place))) << "outside of `within`";
  place.pose.position.x = 0.5;
  place.pose.rotation = {0, 0, 0, 0};
  EXPECT_FALSE(accepted(with(3, place))) << "no rotation";
  LinkReport unknown;
  unknown.seen.push_back(7);
  EXPECT_FALSE(accepted(unknown));
  unknown = {};
  unknown.refuse(7, "why");
  EXPECT_FALSE(accepted(unknown));
}

TEST(LinkExchange, WordsOfTheOtherSideAreOneLineThatATerminalBears) {
  LinkReport news;
  news.refuse(0, "\033[2Jgone\nroot: \xff" + std::string(5000, 'x'));
  std::vector<std::byte> bytes;
  Packer out(bytes);
  signals::pack(out, news);
  Unpacker in(bytes);
  LinkReport got;
  ASSERT_TRUE(signals::unpack_reports(in, entry_of_all_kinds(), got));
  EXPECT_EQ(got.refused.at(0).second.find_first_of("\033\n"), std::string::npos);
  EXPECT_LT(got.refused.at(0).second.size(), 2000u);
}

TEST(LinkExchange, AHundredThousandMutatedAnswersBringNothingThatIsForbidden) {
  const LinkEntry entry = entry_of_all_kinds();
  data::Point place;
  place.pose.position = {0.5, 0.5, 0.5};
  LinkReport news = with(0, true);
  news.values.push_back({1, 2});
  news.values.push_back({2, "red"});
  news.values.push_back({3, place});
  news.seen = {0, 1, 2, 3};
  news.refuse(1, "why");
  news.notes = {"a note"};
  std::vector<std::byte> whole;
  Packer out(whole);
  signals::pack(out, news);
  std::mt19937 random(7);
  std::size_t taken = 0;
  for (int i = 0; i < 100'000; ++i) {
    std::vector<std::byte> bytes = whole;
    for (unsigned k = 1 + random() % 4; k > 0; --k) bytes[random() % bytes.size()] = static_cast<std::byte>(random());
    if (random() % 8 == 0) bytes.resize(random() % bytes.size());
    Unpacker in(bytes);
    LinkReport got;
    if (!signals::unpack_reports(in, entry, got)) continue;
    ++taken;
    for (const auto& each : got.values) {
      ASSERT_LT(each.tag, 4u);
      if (const auto* number = each.value.as_number()) {
        ASSERT_TRUE(number->value >= -1 && number->value <= 5);
      }
      if (const auto* point = each.value.as_point()) {
        ASSERT_FALSE(entry.tags[3].within.refuses(point->pose));
      }
    }
  }
  EXPECT_GT(taken, 1000u) << "texts and flags may differ";
}

// --- a port that brings too much

class Flooding : public signals::LinkPort {
 public:
  void open() override {}
  void close() noexcept override {}
  void exchange(const std::vector<signals::LinkValue>&, Nanoseconds, Nanoseconds, LinkReport& news) override {
    for (int i = 0; i < 3000; ++i) {
      news.values.push_back({0, ++count});
      news.refuse(1, "rubbish " + std::to_string(count));
    }
  }
  int count = 0;
};

TEST(LinkBounds, ACellThatDoesNotLookKeepsTheLatestOfEachTagAndFewRefusals) {
  const LinkEntry entry = link_entry(
      "far: {mqtt: client, port: PORT, tags: {A: {topic: a, type: number, direction: in}, B: {topic: b, type: number, "
      "direction: in}}}",
      1);
  auto owned = std::make_unique<Flooding>();
  Flooding& port = *owned;
  signals::LinkOptions options;
  options.thread = false;
  signals::Link link(entry, std::move(owned), options);
  for (int i = 0; i < 100; ++i) link.step(1'000'000'000 + i * 1'000'000);
  const auto events = link.take_events();
  EXPECT_LE(events.size(), bounds::kLinkEvents + 3000);
  double last = 0;
  std::size_t refusals = 0;
  for (const auto& event : events) {
    if (event.kind == signals::LinkEvent::Kind::value) last = event.value.as_number()->value;
    refusals += event.kind == signals::LinkEvent::Kind::refused ? 1 : 0;
  }
  EXPECT_EQ(last, port.count);
  EXPECT_LE(refusals, bounds::kLinkRefusals);
  link.step(2'500'000'000);
  bool counted = false;
  for (const auto& event : link.take_events())
    counted = counted || event.text.find("more values were not taken") != std::string::npos;
  EXPECT_TRUE(counted);
}

}  // namespace
}  // namespace polyarm::remote_port_tests
