/// The port with a site of the test's own behind it.
#include "polyarm/server/port.hpp"

#include <gtest/gtest.h>

#include <mutex>
#include <random>
#include <thread>

#include "polyarm/base/error.hpp"
#include "tests/support/web_peer.hpp"

namespace polyarm::server {
namespace {

using test::WebPeer;

const std::vector<std::string> kBearer = {"Authorization: Bearer secret"};

class Echo : public Site {
 public:
  bool is_open(const std::string&, const std::string& path) const override { return path == "/open"; }
  std::size_t most_body(const std::string& method, const std::string&) const override {
    return method == "PUT" ? 1000 : 0;
  }
  void handle(HttpRequest request, std::function<void(HttpReply)> reply) override {
    reply(plain(200, request.method + " " + request.path + " " + request.body));
  }
  std::shared_ptr<Client> welcome(const std::string& from, bool local) override {
    const std::lock_guard lock(mutex);
    if (clients.size() >= most) return nullptr;
    clients.push_back(std::make_shared<Client>(clients.size() + 1, from, local));
    return clients.back();
  }
  std::shared_ptr<Client> client(std::size_t i) {
    const std::lock_guard lock(mutex);
    return i < clients.size() ? clients[i] : nullptr;
  }
  std::mutex mutex;
  std::vector<std::shared_ptr<Client>> clients;
  std::size_t most = 100;
};

class PortTest : public ::testing::Test {
 protected:
  void open(PortOptions options = {}) {
    options.rules.token = "secret";
    port = std::make_unique<Port>(options, site);
  }
  int status(const std::string& target, const std::vector<std::string>& headers = kBearer,
             const std::string& method = "GET", const std::string& body = "") {
    return WebPeer::status(WebPeer::fetch(port->number(), target, headers, method, body));
  }
  /// Until it is so; a test that waits for what never comes ends after 20 s.
  template <typename Done>
  bool until(Done done) {
    for (int n = 0; n < 20'000; ++n) {
      if (done()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return done();
  }

  Echo site;
  std::unique_ptr<Port> port;
};

TEST_F(PortTest, ServesWhoShowsTheTokenAndNobodyElse) {
  open();
  EXPECT_EQ(status("/x"), 200);
  EXPECT_EQ(status("/x", {}), 401);
  EXPECT_EQ(status("/x", {"Authorization: Bearer wrong"}), 403);
  EXPECT_EQ(status("/open", {}), 200);
  EXPECT_EQ(status("/open", {"Host: evil.example"}), 421);
  EXPECT_EQ(status("/x", {"Host: evil.example", kBearer[0]}), 421);
  EXPECT_EQ(status("/x", {"Origin: http://evil.example", kBearer[0]}), 403);
  EXPECT_EQ(status("/../etc/passwd"), 400);
  EXPECT_EQ(status("/%2e%2e/etc/passwd"), 400);
}

TEST_F(PortTest, BodiesAndHeadsHaveABound) {
  open();
  EXPECT_EQ(status("/x", kBearer, "PUT", std::string(1000, 'x')), 200);
  EXPECT_EQ(status("/x", kBearer, "PUT", std::string(1001, 'x')), 413);
  EXPECT_EQ(status("/x", kBearer, "POST", "x"), 413);
  EXPECT_EQ(status("/x", {kBearer[0], "X: " + std::string(20'000, 'x')}), 400);
  WebPeer chunked(port->number());
  chunked.say("PUT /x HTTP/1.1\r\nHost: localhost\r\n" + kBearer[0] +
              "\r\nTransfer-Encoding: chunked\r\n\r\n");
  for (int i = 0; i < 100; ++i) chunked.say("64\r\n" + std::string(100, 'x') + "\r\n");
  EXPECT_EQ(WebPeer::status(chunked.rest()), 413);
}

TEST_F(PortTest, ASocketNeedsTokenAndOriginOfTheHost) {
  open();
  const auto upgrade = [&](std::vector<std::string> headers, const std::string& target = "/ws") {
    WebPeer peer(port->number());
    return peer.upgrade(headers, target);
  };
  const std::string cookie = "Cookie: polyarm_token_" + std::to_string(port->number()) + "=secret";
  const std::string own = "Origin: http://localhost:" + std::to_string(port->number());
  EXPECT_EQ(upgrade({cookie, own}), 101);
  EXPECT_EQ(upgrade(kBearer), 101);
  EXPECT_EQ(upgrade({}, "/ws?token=secret"), 101);
  EXPECT_EQ(upgrade({}), 401);
  EXPECT_EQ(upgrade({cookie}), 403);
  EXPECT_EQ(upgrade({cookie, "Origin: http://evil.example"}), 403);
  EXPECT_EQ(upgrade({cookie, "Origin: http://evil.example", "Host: evil.example"}), 421);
  EXPECT_EQ(upgrade({kBearer[0], "Origin: http://evil.example"}), 403);
  EXPECT_EQ(upgrade(kBearer, "/other"), 404);
  site.most = 0;
  EXPECT_EQ(upgrade(kBearer), 503);
}

TEST_F(PortTest, WhoSendsAHeadDropByDropIsSentAway) {
  PortOptions options;
  options.head_s = 0.2;
  open(options);
  WebPeer slow(port->number());
  slow.say("GET / HTTP/1.1\r\n");
  for (int i = 0; i < 20'000 && slow.listen(1); ++i) slow.say("X");
  EXPECT_TRUE(slow.closed());
  EXPECT_TRUE(until([&] { return port->counts().timed_out > 0; }));
}

TEST_F(PortTest, MoreConnectionsThanThereMayBeAreClosed) {
  PortOptions options;
  options.most_connections = 4;
  open(options);
  std::vector<std::unique_ptr<WebPeer>> peers;
  for (int i = 0; i < 4; ++i) {
    peers.push_back(std::make_unique<WebPeer>(port->number()));
    ASSERT_EQ(peers.back()->upgrade(kBearer), 101);
  }
  WebPeer one_more(port->number());
  EXPECT_EQ(one_more.rest(), "");
  EXPECT_TRUE(one_more.closed());
  peers.clear();
  EXPECT_TRUE(until([&] { return WebPeer::status(WebPeer::fetch(port->number(), "/x", kBearer)) == 200; }));
}

TEST_F(PortTest, MessagesHaveABound) {
  open();
  WebPeer peer(port->number());
  ASSERT_EQ(peer.upgrade(kBearer), 101);
  peer.say(WebPeer::frame(std::string(1 << 20, 'x')));
  EXPECT_TRUE(until([&] { return site.client(0)->lines(1).size() == 1; }));
  peer.say(WebPeer::frame(std::string((1 << 20) + 1, 'x')));
  EXPECT_TRUE(until([&] { return site.client(0)->gone(); }));
}

TEST_F(PortTest, NothingIsReadFromWhoHasEnoughWaiting) {
  open();
  WebPeer peer(port->number());
  ASSERT_EQ(peer.upgrade(kBearer), 101);
  std::string all;
  for (std::size_t i = 0; i < 3 * Client::kMostLines; ++i) all += WebPeer::frame(std::to_string(i));
  peer.say(all);
  ASSERT_TRUE(until([&] { return !site.client(0)->has_room(); }));
  std::vector<std::string> lines;
  EXPECT_TRUE(until([&] {
    const auto some = site.client(0)->lines(1000);
    EXPECT_LE(some.size(), Client::kMostLines);
    lines.insert(lines.end(), some.begin(), some.end());
    port->wake();
    return lines.size() == 3 * Client::kMostLines;
  }));
  EXPECT_EQ(lines.back(), std::to_string(3 * Client::kMostLines - 1));
}

TEST_F(PortTest, AStuckClientSlowsNobodyAndGetsTheLatestWhenItReadsAgain) {
  open();
  std::vector<std::unique_ptr<WebPeer>> peers;
  for (int i = 0; i < 20; ++i) {
    peers.push_back(std::make_unique<WebPeer>(port->number(), i == 0 ? 4096 : 0));
    ASSERT_EQ(peers.back()->upgrade(kBearer), 101);
  }
  ASSERT_TRUE(until([&] { return site.client(19) != nullptr; }));
  int sent = 0;
  const auto send_one = [&] {
    const auto frame = std::make_shared<const std::string>(std::to_string(++sent) + std::string(20'000, '.'));
    for (std::size_t i = 0; i < 20; ++i) site.client(i)->put_state(frame);
    port->wake();
  };
  EXPECT_TRUE(until([&] {
    send_one();
    bool all = site.client(0)->frames_left_out() > 20;
    for (std::size_t i = 1; i < 20; ++i) {
      while (peers[i]->listen(0) && peers[i]->heard.size() > 65536) peers[i]->take();
      peers[i]->take();
      all = all && peers[i]->frames > 30;
    }
    return all;
  }));
  EXPECT_TRUE(until([&] {
    peers[0]->listen(1);
    peers[0]->take();
    return peers[0]->frames > 0 && std::stoi(peers[0]->last_frame) == sent;
  })) << "after what the system had kept comes the newest";
  EXPECT_LT(peers[0]->frames, sent - 20);
}

TEST_F(PortTest, WhateverBytesComeOthersAreServed) {
  open();
  std::mt19937 random(11);
  const std::string pieces[] = {"GET ",
                                "PUT ",
                                "/x",
                                " HTTP/1.1\r\n",
                                "\r\n",
                                "Host: localhost\r\n",
                                kBearer[0] + "\r\n",
                                "Content-Length: ",
                                "-1",
                                "99999999999999999999",
                                "Transfer-Encoding: chunked\r\n",
                                "Upgrade: websocket\r\nConnection: Upgrade\r\n",
                                "Sec-WebSocket-Key: x\r\n",
                                "0\r\n\r\n",
                                "Expect: 100-continue\r\n",
                                std::string(1, '\0'),
                                "\xff\xfe"};
  for (int n = 0; n < 300; ++n) {
    WebPeer peer(port->number());
    std::string text;
    for (unsigned i = random() % 14; i > 0; --i)
      text += random() % 5 ? pieces[random() % std::size(pieces)]
                           : std::string(random() % 9, static_cast<char>(random()));
    peer.say(text);
    if (n % 3 == 0) peer.listen(1);
  }
  for (int n = 0; n < 100; ++n) {
    WebPeer peer(port->number());
    ASSERT_EQ(peer.upgrade(kBearer), 101);
    std::string text;
    for (unsigned i = 1 + random() % 60; i > 0; --i) text += static_cast<char>(random());
    if (n % 2) text = WebPeer::frame(text, static_cast<int>(random() % 16));
    peer.say(text);
    if (n % 3 == 0) peer.listen(1);
  }
  EXPECT_EQ(status("/x"), 200);
}

TEST_F(PortTest, APortThatIsTakenIsSaid) {
  open();
  PortOptions same;
  same.port = port->number();
  try {
    Port second(same, site);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.problems().front().code, "no-port");
    EXPECT_NE(e.problems().front().advice.find("--port"), std::string::npos);
  }
}

TEST_F(PortTest, AtItsEndEverybodyIsToldGoodbye) {
  open();
  WebPeer peer(port->number());
  ASSERT_EQ(peer.upgrade(kBearer), 101);
  ASSERT_TRUE(until([&] { return site.client(0) != nullptr; }));
  port.reset();
  peer.rest(2000);
  peer.take();
  EXPECT_EQ(peer.close_code, 1001);
  EXPECT_TRUE(site.client(0)->gone());
}

}  // namespace
}  // namespace polyarm::server
