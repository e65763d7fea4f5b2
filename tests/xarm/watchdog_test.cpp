/// The watchdog process of forward mode, in a thread of the test, with the driver's end of its socket.
#include "drivers/xarm/watchdog.hpp"

#include <sys/socket.h>
#include <unistd.h>

#include <thread>

#include "drivers/watchdog/watch.hpp"
#include "tests/support/wire_faults.hpp"
#include "tests/xarm/forward_rig.hpp"

namespace polyarm {
namespace {

using namespace test;
using watchdog::Word;
using xarm::Machine;
using xarm::State;

class Watched {
 public:
  explicit Watched(int timeout_ms, int port = 0) : far(far_options()) {
    int ends[2];
    EXPECT_EQ(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends), 0);
    driver_ = ends[0];
    xarm::WatchdogSettings settings;
    settings.host = "127.0.0.1";
    settings.command_port = port != 0 ? port : far.ports().command;
    settings.timeout_ms = timeout_ms;
    settings.answer_ms = 20'000;
    thread_ = std::thread([settings, socket = ends[1]] {
      xarm::watch(settings, socket);
      ::close(socket);
    });
  }
  ~Watched() { die(); }
  void die() {
    if (driver_ >= 0) ::close(driver_);
    driver_ = -1;
    if (thread_.joinable()) thread_.join();
  }
  void say(Word word) {
    const char byte = static_cast<char>(word);
    EXPECT_EQ(::send(driver_, &byte, 1, MSG_NOSIGNAL), 1);
  }
  Word hear() {
    char bytes[16] = {};
    EXPECT_GE(::recv(driver_, bytes, sizeof bytes, 0), 1);
    return static_cast<Word>(bytes[0]);
  }
  /// Two moves that take half a minute each.
  void move() {
    far.with([](Machine& machine) {
      for (const double to : {-2.0, 2.0}) {
        xarm::UxMove move;
        move.joints = {to, -0.5, -0.6, 0.1, 0.8, 0.4, 0};
        move.speed = 0.1;
        move.acceleration = 1;
        const auto request = encode(move, {});
        machine.answer({1, xarm::kPrivateProtocol, request.reg, request.data});
      }
      return 0;
    });
  }
  int queued() {
    return far.with([](Machine& machine) { return machine.report().queued; });
  }
  FarSide far;

 private:
  int driver_ = -1;
  std::thread thread_;
};

TEST(XarmWatchdog, StopsTheRobotWhenTheDriverHasDied) {
  Watched watched(60'000);
  ASSERT_EQ(watched.hear(), Word::ready);
  watched.say(Word::arm);
  watched.move();
  EXPECT_EQ(watched.queued(), 2);
  watched.die();
  EXPECT_EQ(watched.queued(), 0);
  EXPECT_EQ(watched.far.with([](Machine& m) { return m.state(); }), State::stopped);
}

TEST(XarmWatchdog, StopsTheRobotWhenTheDriverHangs) {
  Watched watched(50);
  ASSERT_EQ(watched.hear(), Word::ready);
  watched.move();
  watched.say(Word::arm);
  EXPECT_EQ(watched.hear(), Word::tripped);
  while (watched.queued() != 0) std::this_thread::yield();
}

/// Also when its connection was closed meanwhile, and when the controller does not take the first attempt.
TEST(XarmWatchdog, TriesUntilTheQueueIsEmpty) {
  Watched watched(60'000);
  ASSERT_EQ(watched.hear(), Word::ready);
  watched.say(Word::arm);
  watched.move();
  watched.far.order("ignore_stop");
  watched.far.order("close_command");
  std::thread later([&] {
    std::uint64_t before = watched.far.requests();
    while (watched.far.requests() < before + 4) std::this_thread::yield();
    watched.far.order("healthy");
  });
  watched.die();
  later.join();
  EXPECT_EQ(watched.queued(), 0);
}

TEST(XarmWatchdog, ADriverThatEndsInOrderLeavesTheRobotAlone) {
  Watched watched(60'000);
  ASSERT_EQ(watched.hear(), Word::ready);
  watched.say(Word::arm);
  watched.say(Word::disarm);
  watched.move();
  watched.say(Word::quit);
  watched.die();
  EXPECT_EQ(watched.queued(), 2);
}

TEST(XarmWatchdog, SaysWhenTheControllerIsNotReached) {
  Watched watched(60'000, closed_port());
  EXPECT_EQ(watched.hear(), Word::no_device);
}

TEST(XarmWatchdog, ReadsItsWords) {
  xarm::WatchdogSettings settings;
  settings.host = "192.168.1.200";
  settings.timeout_ms = 1234;
  auto words = words_of(settings);
  words.insert(words.begin(), "program");
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  xarm::WatchdogSettings back;
  ASSERT_TRUE(settings_from(static_cast<int>(argv.size()), argv.data(), back));
  EXPECT_EQ(back.host, settings.host);
  EXPECT_EQ(back.timeout_ms, 1234);
  EXPECT_FALSE(settings_from(static_cast<int>(argv.size()) - 1, argv.data(), back));
  words[2] = "none";
  argv[2] = words[2].data();
  EXPECT_FALSE(settings_from(static_cast<int>(argv.size()), argv.data(), back));
}

TEST(XarmWatchdog, MustWaitLongerThanAnAnswer) {
  xarm::XarmComponent component;
  EXPECT_THROW(
      component.on_init(xarm_context({{"host", "x"}, {"motion", "forward"}, {"watchdog_ms", "900"}})), Error);
}

}  // namespace
}  // namespace polyarm
