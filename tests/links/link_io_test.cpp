/// How a link deals with a far side that cannot be reached, or that drops its connections.
#include <gtest/gtest.h>

#include "polyarm/base/error.hpp"
#include "polyarm/signals/link.hpp"

namespace polyarm::signals {
namespace {

constexpr Nanoseconds kStep = 10'000'000, kSecond = 1'000'000'000;

struct Script {
  bool reachable = true;
  int rounds = 1;  ///< of a connection until it is dropped
  int opened = 0;
};

class ScriptedPort : public LinkPort {
 public:
  explicit ScriptedPort(Script& script) : script_(script) {}
  void open() override {
    if (!script_.reachable) throw Error("link-lost", "mqtt at 10.0.0.1:1883 cannot be reached: refused");
    ++script_.opened;
    left_ = script_.rounds;
  }
  void close() noexcept override {}
  void exchange(const std::vector<LinkValue>&, Nanoseconds, Nanoseconds, LinkReport& news) override {
    if (left_-- <= 0) throw Error("link-lost", "mqtt at 10.0.0.1:1883 is gone: protocol error");
    news.alive = true;
  }

 private:
  Script& script_;
  int left_ = 0;
};

struct Stepped {
  explicit Stepped(Script& script) : link(entry(), std::make_unique<ScriptedPort>(script), {false}) {}
  static LinkEntry entry() {
    LinkEntry out;
    out.name = "mes";
    return out;
  }
  void run(Nanoseconds duration) {
    for (const Nanoseconds end = now + duration; now < end; now += kStep) {
      link.step(now);
      for (LinkEvent& event : link.take_events())
        if (event.kind == LinkEvent::Kind::note) notes.push_back(event.text);
    }
  }
  Link link;
  Nanoseconds now = 0;
  std::vector<std::string> notes;
};

TEST(LinkIo, AFarSideThatWasNeverReachedIsReportedOnceWithTheReason) {
  Script script;
  script.reachable = false;
  Stepped stepped(script);
  stepped.run(kSecond / 2);
  EXPECT_TRUE(stepped.notes.empty()) << "it may start a moment later";
  stepped.run(60 * kSecond);
  ASSERT_EQ(stepped.notes.size(), 1u);
  EXPECT_EQ(stepped.notes[0], "it is not connected yet: mqtt at 10.0.0.1:1883 cannot be reached: refused");
}

TEST(LinkIo, AFarSideThatDropsEachConnectionIsAskedMoreAndMoreRarely) {
  Script script;
  script.rounds = 3;
  Stepped stepped(script);
  stepped.run(60 * kSecond);
  EXPECT_GE(script.opened, 8);
  EXPECT_LE(script.opened, 20) << "without pauses that grow there are hundreds";
}

TEST(LinkIo, AfterAConnectionThatLastedItIsTriedAgainSoon) {
  Script script;
  script.rounds = 1000;  // 10 s
  Stepped stepped(script);
  stepped.run(45 * kSecond);
  EXPECT_EQ(script.opened, 5) << "four losses, each with the first pause";
}

}  // namespace
}  // namespace polyarm::signals
