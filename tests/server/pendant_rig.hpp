#pragma once
/// A pendant's server in front of a whole cell in lock-step, for tests: time is the cell's.
#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "polyarm/server/pendant.hpp"
#include "polyarm/setup/cell_file.hpp"
#include "tests/support/lock_step_cell.hpp"
#include "tests/support/web_peer.hpp"

namespace polyarm::server {

using test::Folder;
using test::Json;
using test::LockStepCell;
using test::WebPeer;

inline const std::string kArm = std::string(POLYARM_SOURCE_DIR) + "/examples/r6bot/r6bot.urdf";
inline const std::vector<std::string> kBearer = {"Authorization: Bearer secret"};

class PendantTest : public ::testing::Test {
 protected:
  PendantTest() {
    folder.write("cell.yaml", "polyarm: cell/1\nrobots:\n  arm: {model: " + kArm + ", hardware: mock}\n");
    cell = std::make_unique<LockStepCell>(cell::read_cell_file(folder.path()));
    PendantOptions options;
    options.port = 0;
    options.token = "secret";
    options.version = "7";
    pendant = std::make_unique<Pendant>(options, nobody);
    pendant->attach(cell->cell().view());
    cell->run(0.05);
  }
  ~PendantTest() override { pendant->detach(); }

  void tick() {
    pendant->serve();
    cell->tick();
  }
  void run(double s) {
    for (Nanoseconds end = cell->cell().now() + nanoseconds(s); cell->cell().now() < end;) tick();
  }
  /// Serves, with a tick of the cell now and then, until it is so.
  template <typename Done>
  bool until(Done done) {
    for (int n = 0; n < 20'000; ++n) {
      if (done()) return true;
      pendant->serve();
      if (n % 20 == 19) cell->tick();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return done();
  }
  /// The same without time passing in the cell.
  template <typename Done>
  bool served_until(Done done) {
    for (int n = 0; n < 20'000; ++n) {
      if (done()) return true;
      pendant->serve();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return done();
  }
  std::unique_ptr<WebPeer> connect() {
    auto peer = std::make_unique<WebPeer>(pendant->port());
    EXPECT_EQ(peer->upgrade(kBearer), 101);
    return peer;
  }
  Json ask(WebPeer& peer, Json request) {
    const int id = ++last_;
    request["id"] = id;
    peer.send(request);
    until([&] {
      peer.listen();
      peer.take();
      const Json answer = peer.answer(id);
      return !answer.is_null() && !answer.value("more", false);
    });
    return peer.answer(id);
  }
  std::string code(const Json& answer) {
    return answer.value("ok", false) ? "ok"
           : answer.is_null()        ? "none"
                                     : answer["error"]["code"].get<std::string>();
  }
  bool heard(WebPeer& peer, const std::string& event, const std::function<bool(const Json&)>& is = {}) {
    return until([&] {
      peer.listen();
      peer.take();
      const Json seen = peer.event(event);
      return !seen.is_null() && (!is || is(seen));
    });
  }
  static bool is_over(WebPeer& peer, const Json& jog) {
    peer.listen();
    peer.take();
    const Json seen = peer.event("jog");
    return !seen.is_null() && seen["jog"] == jog && seen["over"] == true;
  }
  bool standing() { return cell->cell().jogging().status(0).standing; }
  double joint() { return cell->value_of("states", "arm/joint_2/position"); }
  Json begin_jog(WebPeer& peer) {
    return ask(peer,
               {{"request", "jog.begin"}, {"mode", "joint"}, {"axis", 1}, {"direction", 1}, {"speed", 1.0}});
  }
  /// A heartbeat, which the cell has taken.
  void beat(WebPeer& peer, const Json& jog) {
    const std::uint64_t before = pendant->counts().requests;
    peer.send({{"request", "jog.beat"}, {"jog", jog}});
    ASSERT_TRUE(served_until([&] { return pendant->counts().requests > before; }));
  }
  std::string fetch(const std::string& path) { return WebPeer::fetch(pendant->port(), path, kBearer); }
  static std::string body(const std::string& answer) { return answer.substr(answer.find("\r\n\r\n") + 4); }

  struct Nobody : cell::Observer {};
  Nobody nobody;
  Folder folder;
  std::unique_ptr<LockStepCell> cell;
  std::unique_ptr<Pendant> pendant;
  int last_ = 0;
};

}  // namespace polyarm::server
