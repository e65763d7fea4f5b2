/// The port with a site of the test's own behind it.
#include "polyarm/server/port.hpp"

#include <gtest/gtest.h>
#include <openssl/evp.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>
#include <sys/resource.h>

#include <mutex>
#include <random>
#include <thread>

#include "polyarm/access/tls.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/server/http_text.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/web_peer.hpp"

namespace polyarm::server {
namespace {

using test::WebPeer;

const std::vector<std::string> kCredentials = {"Authorization: Bearer secret"};

class Echo : public Site {
 public:
  bool is_open(const std::string&, const std::string& path) const override { return path == "/open"; }
  std::size_t most_body(const std::string& method, const std::string&) const override {
    return method == "PUT" ? 1000 : 0;
  }
  void handle(HttpRequest request, std::function<void(HttpReply)> reply) override {
    reply(plain(200, request.method + " " + request.path + " " + request.body));
  }
  std::shared_ptr<Client> welcome(Client::Side side) override {
    const std::lock_guard lock(mutex);
    if (clients.size() >= most) return nullptr;
    clients.push_back(std::make_shared<Client>(clients.size() + 1, std::move(side)));
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
  int status(const std::string& target, const std::vector<std::string>& headers = kCredentials,
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
  EXPECT_EQ(status("/x", {"Host: evil.example", kCredentials[0]}), 421);
  EXPECT_EQ(status("/x", {"Origin: http://evil.example", kCredentials[0]}), 403);
  EXPECT_EQ(status("/../etc/passwd"), 400);
  EXPECT_EQ(status("/%2e%2e/etc/passwd"), 400);
}

TEST_F(PortTest, BodiesAndHeadsHaveABound) {
  open();
  EXPECT_EQ(status("/x", kCredentials, "PUT", std::string(1000, 'x')), 200);
  EXPECT_EQ(status("/x", kCredentials, "PUT", std::string(1001, 'x')), 413);
  EXPECT_EQ(status("/x", kCredentials, "POST", "x"), 413);
  EXPECT_EQ(status("/x", {kCredentials[0], "X: " + std::string(20'000, 'x')}), 400);
  WebPeer chunked(port->number());
  chunked.say("PUT /x HTTP/1.1\r\nHost: localhost\r\n" + kCredentials[0] +
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
  EXPECT_EQ(upgrade(kCredentials), 101);
  EXPECT_EQ(upgrade({}, "/ws?token=secret"), 101);
  EXPECT_EQ(upgrade({}), 401);
  EXPECT_EQ(upgrade({cookie}), 403);
  EXPECT_EQ(upgrade({cookie, "Origin: http://evil.example"}), 403);
  EXPECT_EQ(upgrade({cookie, "Origin: http://evil.example", "Host: evil.example"}), 421);
  EXPECT_EQ(upgrade({kCredentials[0], "Origin: http://evil.example"}), 403);
  EXPECT_EQ(upgrade(kCredentials, "/other"), 404);
  site.most = 0;
  EXPECT_EQ(upgrade(kCredentials), 503);
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

TEST_F(PortTest, MoreConnectionsThanThereMayBeAreRefused) {
  PortOptions options;
  options.most_connections = 4;
  open(options);
  std::vector<std::unique_ptr<WebPeer>> peers;
  for (int i = 0; i < 4; ++i) {
    peers.push_back(std::make_unique<WebPeer>(port->number()));
    ASSERT_EQ(peers.back()->upgrade(kCredentials), 101);
  }
  EXPECT_EQ(WebPeer::status(WebPeer::fetch(port->number(), "/x", kCredentials)), 503);
  peers.clear();
  EXPECT_TRUE(until([&] { return WebPeer::status(WebPeer::fetch(port->number(), "/x", kCredentials)) == 200; }));
}

TEST_F(PortTest, WhoShowsNoTokenKeepsNobodyOut) {
  open();
  std::vector<std::unique_ptr<WebPeer>> strangers;
  for (std::size_t i = 0; i < bounds::kUnauthenticated + 100; ++i) {
    strangers.push_back(std::make_unique<WebPeer>(port->number()));
    strangers.back()->say("GET /x HTTP/1.1\r\n");
  }
  EXPECT_EQ(status("/x"), 200);
  std::size_t closed = 0;
  EXPECT_TRUE(until([&] {
    closed = 0;
    for (const auto& each : strangers) closed += each->listen() ? 0 : 1;
    return closed >= 100;
  })) << closed;
}

TEST_F(PortTest, OnlyWhoTakesGzipGetsIt) {
  EXPECT_TRUE(accepts_gzip("gzip, deflate, br"));
  EXPECT_TRUE(accepts_gzip("deflate, GZIP;q=0.5"));
  EXPECT_TRUE(accepts_gzip("*"));
  EXPECT_FALSE(accepts_gzip(""));
  EXPECT_FALSE(accepts_gzip("identity"));
  EXPECT_FALSE(accepts_gzip("gzip;q=0"));
  EXPECT_FALSE(accepts_gzip("gzip; q=0.000, *"));
  EXPECT_FALSE(accepts_gzip("*;q=0"));
  EXPECT_FALSE(accepts_gzip("notgzip"));
}

/// CPU time of this process, s.
double cpu_time() {
  rusage used{};
  ::getrusage(RUSAGE_SELF, &used);
  const auto s = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return s(used.ru_utime) + s(used.ru_stime);
}

TEST_F(PortTest, WithoutDescriptorsItTurnsPeopleAwayAndDoesNotSpin) {
  open();
  EXPECT_EQ(status("/x"), 200);
  std::vector<int> sockets;
  for (int i = 0; i < 5; ++i) sockets.push_back(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  const int next = ::dup(0);
  ::close(next);
  rlimit before{};
  ::getrlimit(RLIMIT_NOFILE, &before);
  rlimit none = before;
  none.rlim_cur = static_cast<rlim_t>(next);
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &none), 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port->number());
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const double cpu = cpu_time();
  for (const int each : sockets)
    EXPECT_EQ(::connect(each, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  char byte = 0;
  EXPECT_LE(::recv(sockets.front(), &byte, 1, 0), 0) << "it was accepted and closed";
  EXPECT_LE(::recv(sockets.back(), &byte, 1, 0), 0);
  EXPECT_LT(cpu_time() - cpu, 0.2) << "five of them take half a second";
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
  for (const int each : sockets) ::close(each);
  EXPECT_TRUE(until([&] { return status("/x") == 200; }));
}

/// A request through TLS on a connection of its own; the answer, and the fingerprint of the certificate.
std::string fetch_tls(std::uint16_t port, const std::string& head, std::string& fingerprint) {
  WebPeer peer(port);
  SSL_CTX* const context = ::SSL_CTX_new(::TLS_client_method());
  SSL* const tls = ::SSL_new(context);
  ::SSL_set_fd(tls, peer.descriptor());
  std::string out;
  fingerprint.clear();
  if (::SSL_connect(tls) == 1) {
    X509* const shown = ::SSL_get1_peer_certificate(tls);
    unsigned char digest[EVP_MAX_MD_SIZE];
    unsigned size = 0;
    ::X509_digest(shown, ::EVP_sha256(), digest, &size);
    ::X509_free(shown);
    char text[4];
    for (unsigned i = 0; i < size; ++i) {
      std::snprintf(text, sizeof text, "%s%02X", i > 0 ? ":" : "", digest[i]);
      fingerprint += text;
    }
    ::SSL_write(tls, head.data(), static_cast<int>(head.size()));
    char buffer[4096];
    for (int n; (n = ::SSL_read(tls, buffer, sizeof buffer)) > 0;)
      out.append(buffer, static_cast<std::size_t>(n));
  }
  ::SSL_free(tls);
  ::SSL_CTX_free(context);
  return out;
}

class TlsTest : public PortTest {
 protected:
  TlsTest() : made(kept_certificate(folder.path(), "bench")) {
    options.certificate = made.chain;
    options.key = made.key;
  }
  std::string host() const { return "localhost:" + std::to_string(port->number()); }
  std::string head(const std::string& first, const std::string& more) const {
    return first + " HTTP/1.1\r\nAuthorization: Bearer secret\r\nHost: " + host() + "\r\n" + more + "\r\n";
  }
  int status_through_tls(const std::string& more) {
    return WebPeer::status(
        fetch_tls(port->number(), head("GET /x", "Connection: close\r\n" + more), fingerprint));
  }
  test::Folder folder;
  Certificate made;
  PortOptions options;
  std::string fingerprint;
};

TEST_F(TlsTest, OnePortSpeaksTlsAndToThisMachineInClear) {
  open(options);
  EXPECT_EQ(status("/x"), 200);
  EXPECT_EQ(status_through_tls(""), 200);
  EXPECT_EQ(fingerprint, made.fingerprint);
  EXPECT_EQ(status_through_tls("Origin: https://" + host() + "\r\n"), 200);
  EXPECT_EQ(status_through_tls("Origin: http://" + host() + "\r\n"), 403) << "not the page that was served";
}

TEST_F(TlsTest, WebSocketsGoThroughIt) {
  open(options);
  std::thread farewell([&] {
    until([&] { return site.client(0) && site.client(0)->line(); });
    site.client(0)->answer("{\"ok\":true}");
    port->wake();
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    site.client(0)->leave();
    port->wake();
  });
  const std::string opened = fetch_tls(port->number(),
                                       head("GET /ws",
                                            "Upgrade: websocket\r\nConnection: Upgrade\r\n"
                                            "Sec-WebSocket-Version: 13\r\n"
                                            "Sec-WebSocket-Key: AAECAwQFBgcICQoLDA0ODw==\r\n") +
                                           WebPeer::frame("{}"),
                                       fingerprint);
  farewell.join();
  EXPECT_EQ(WebPeer::status(opened), 101);
  EXPECT_NE(opened.find("{\"ok\":true}"), std::string::npos);
}

TEST_F(TlsTest, OthersThanThisMachineAreNotServedInClear) {
  options.local_in_clear = false;  // this machine is treated as another
  open(options);
  EXPECT_EQ(status("/x"), 403);
  EXPECT_EQ(status_through_tls(""), 200);
}

TEST_F(TlsTest, WhoBeginsNoHandshakeIsSentAway) {
  options.head_s = 0.2;
  open(options);
  WebPeer silent(port->number());
  EXPECT_EQ(silent.rest(), "");
  WebPeer slow(port->number());
  slow.say("\x16\x03\x01");
  while (slow.listen(20'000)) {
  }
  EXPECT_TRUE(until([&] { return port->counts().timed_out >= 2; }));
}

TEST_F(TlsTest, ACertificateIsKeptAndMadeAnewWhereItIsNoGood) {
  EXPECT_EQ(kept_certificate(folder.path(), "bench").fingerprint, made.fingerprint);
  const auto key = folder.path() / "pendant-key.pem", chain = folder.path() / "pendant-certificate.pem";
  EXPECT_EQ(read_certificate(chain, key).fingerprint, made.fingerprint);
  EXPECT_THROW(read_certificate(chain, chain), Error);
  EXPECT_THROW(read_certificate("/dev/zero", key), Error);
  std::filesystem::permissions(key, std::filesystem::perms::all);
  EXPECT_NE(kept_certificate(folder.path(), "bench").fingerprint, made.fingerprint)
      << "others could read its key";
}

TEST_F(PortTest, FramesThatComeWithTheHeadOfTheUpgradeAreTaken) {
  open();
  WebPeer peer(port->number());
  peer.say("GET /ws HTTP/1.1\r\nAuthorization: Bearer secret\r\nHost: localhost:" +
           std::to_string(port->number()) +
           "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
           "Sec-WebSocket-Key: AAECAwQFBgcICQoLDA0ODw==\r\n\r\n" +
           WebPeer::frame("{\"a\":1}") + WebPeer::frame("{\"b\":2}") + WebPeer::frame("{\"c\":3}").substr(0, 4));
  peer.say(WebPeer::frame("{\"c\":3}").substr(4));
  for (const char* each : {"{\"a\":1}", "{\"b\":2}", "{\"c\":3}"}) {
    std::optional<Client::Line> line;
    EXPECT_TRUE(until([&] { return site.client(0) && (line = site.client(0)->line()); })) << each;
    EXPECT_EQ(line.value_or(Client::Line{}).text, each);
  }
}

TEST_F(PortTest, MessagesHaveABound) {
  open();
  WebPeer peer(port->number());
  ASSERT_EQ(peer.upgrade(kCredentials), 101);
  peer.say(WebPeer::frame(std::string(1 << 20, 'x')));
  EXPECT_TRUE(until([&] { return site.client(0)->line().has_value(); }));
  peer.say(WebPeer::frame(std::string((1 << 20) + 1, 'x')));
  EXPECT_TRUE(until([&] { return site.client(0)->gone(); }));
}

TEST_F(PortTest, AStuckClientSlowsNobodyAndGetsTheLatestWhenItReadsAgain) {
  open();
  std::vector<std::unique_ptr<WebPeer>> peers;
  for (int i = 0; i < 20; ++i) {
    peers.push_back(std::make_unique<WebPeer>(port->number(), i == 0 ? 4096 : 0));
    ASSERT_EQ(peers.back()->upgrade(kCredentials), 101);
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
    bool all = site.client(0)->omitted_frames() > 20;
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
                                kCredentials[0] + "\r\n",
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
    ASSERT_EQ(peer.upgrade(kCredentials), 101);
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
  ASSERT_EQ(peer.upgrade(kCredentials), 101);
  ASSERT_TRUE(until([&] { return site.client(0) != nullptr; }));
  port.reset();
  peer.rest(2000);
  peer.take();
  EXPECT_EQ(peer.close_code, 1001);
  EXPECT_TRUE(site.client(0)->gone());
}

}  // namespace
}  // namespace polyarm::server
