/// Users who log in: passwords, roles, ends of log-ins, and what the audit log says about them.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <thread>

#include "polyarm/access/gate.hpp"
#include "polyarm/access/logins.hpp"
#include "polyarm/access/token.hpp"
#include "polyarm/protocol/request.hpp"
#include "polyarm/server/pendant.hpp"
#include "polyarm/server/sessions.hpp"
#include "polyarm/setup/cell_file.hpp"
#include "polyarm/users/password.hpp"
#include "tests/support/lock_step_cell.hpp"
#include "tests/support/web_peer.hpp"

namespace polyarm::server {
namespace {

using protocol::Role;
using test::Json;
using test::LockStepCell;
using test::WebPeer;

/// One hash for all tests: making one takes long.
const std::string& hash() {
  static const std::string made = users::hash_of("right password");
  return made;
}

void add_users(const std::filesystem::path& file) {
  users::change_users(file, [](users::UserList& list) {
    list.add({"vera", Role::watch, hash()});
    list.add({"otto", Role::operate, hash()});
    list.add({"petra", Role::program, hash()});
    list.add({"ada", Role::administer, hash()});
  });
}

class UsersOfACell : public ::testing::Test {
 protected:
  UsersOfACell() {
    const std::string arm = std::string(POLYARM_SOURCE_DIR) + "/examples/r6bot/r6bot.urdf";
    folder.write("cell/cell.yaml", "polyarm: cell/1\nrobots:\n  arm: {model: " + arm + ", hardware: mock}\n");
    folder.write("cell/work.script", "wait 1s\n");
    add_users(folder.path() / "users");
    audit = std::make_unique<users::AuditLog>(folder.path() / "audit");
    lock_step = std::make_unique<LockStepCell>(cell::read_cell_file(folder.path() / "cell"));
    PendantOptions options;
    options.port = 0;
    options.token = "secret";
    options.users = folder.path() / "users";
    options.audit = audit.get();
    pendant = std::make_unique<Pendant>(options, nobody);
    pendant->attach(lock_step->cell().view());
    lock_step->run(0.05);
  }
  ~UsersOfACell() override { pendant->detach(); }

  static std::string base64(const std::string& text) {
    static const char* const letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    for (std::size_t i = 0; i < text.size(); i += 3) {
      std::uint32_t bits = 0;
      for (std::size_t k = 0; k < 3; ++k)
        bits = (bits << 8) | (i + k < text.size() ? static_cast<unsigned char>(text[i + k]) : 0u);
      for (std::size_t k = 0; k < 4; ++k)
        out += i + k <= text.size() ? letters[(bits >> (18 - 6 * k)) & 63] : '=';
    }
    return out;
  }
  std::string log_in(const std::string& name, const std::string& password,
                     std::vector<std::string> more = {}) {
    more.push_back("Authorization: Basic " + base64(name + ":" + password));
    return WebPeer::fetch(pendant->port(), "/api/login", more, "POST");
  }
  /// "polyarm_token_PORT=…" of the answer; empty: none.
  static std::string cookie_of(const std::string& answer) {
    const auto at = answer.find("Set-Cookie: ");
    return at == std::string::npos ? "" : answer.substr(at + 12, answer.find(';', at) - at - 12);
  }
  std::unique_ptr<WebPeer> connect(const std::string& name) {
    auto peer = std::make_unique<WebPeer>(pendant->port());
    const std::string cookie = cookie_of(log_in(name, "right password"));
    EXPECT_FALSE(cookie.empty()) << name;
    EXPECT_EQ(peer->upgrade({"Cookie: " + cookie, "Origin: http://" + peer->host()}), 101);
    return peer;
  }
  Json ask(WebPeer& peer, Json request) {
    const int id = ++last_;
    request["id"] = id;
    peer.send(request);
    for (int n = 0; n < 20'000 && peer.answer(id).is_null() && !peer.closed(); ++n) {
      pendant->serve();
      if (n % 5 == 4) lock_step->tick();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      peer.listen();
      peer.take();
    }
    return peer.answer(id);
  }
  static std::string code(const Json& answer) {
    return answer.is_null()            ? "none"
           : answer.value("ok", false) ? "ok"
                                       : answer["error"]["code"].get<std::string>();
  }
  std::vector<Json> log() {
    audit->flush();
    std::vector<Json> out;
    users::read_audit(folder.path() / "audit",
                      [&](const std::string& line) { out.push_back(Json::parse(line)); });
    return out;
  }

  struct Nobody : cell::Observer {};
  Nobody nobody;
  test::Folder folder;
  std::unique_ptr<users::AuditLog> audit;
  std::unique_ptr<LockStepCell> lock_step;
  std::unique_ptr<Pendant> pendant;
  int last_ = 0;
};

TEST_F(UsersOfACell, MaySendWhatTheirRoleAllowsAndNothingElse) {
  const std::pair<const char*, Role> all[] = {
      {"vera", Role::watch}, {"otto", Role::operate}, {"petra", Role::program}, {"ada", Role::administer}};
  for (const auto& [name, role] : all) {
    const auto peer = connect(name);
    const Json hello = ask(*peer, {{"request", "session.hello"}, {"name", "tablet"}})["result"];
    EXPECT_EQ(hello["role"], protocol::name(role));
    EXPECT_EQ(code(ask(*peer, {{"request", "session.take"}})), role == Role::watch ? "no-role" : "ok");
    for (const protocol::RequestType* type : protocol::request_types()) {
      Json request{{"request", type->facts->name}};
      if (type->facts->watch_without) request[type->facts->watch_without] = true;
      if (type->facts->role <= role) continue;
      EXPECT_EQ(code(ask(*peer, request)), "no-role") << name << ": " << type->facts->name;
    }
    EXPECT_EQ(code(ask(*peer, {{"request", "control.override"}, {"percent", 50}})),
              role == Role::watch ? "no-role" : "ok");
    ask(*peer, {{"request", "session.release"}});
  }
}

TEST_F(UsersOfACell, AreNamedWhereOthersSeeWhoHasControl) {
  const auto otto = connect("otto"), vera = connect("vera");
  ask(*otto, {{"request", "session.hello"}, {"name", "I am ada"}});
  ask(*otto, {{"request", "session.take"}});
  EXPECT_EQ(ask(*vera, {{"request", "session.hello"}})["result"]["holder"]["name"], "otto (I am ada)");
  EXPECT_EQ(code(ask(*vera, {{"request", "control.stop"}})), "ok") << "everybody stops";
}

TEST_F(UsersOfACell, AStopThatWasSentBeforeTheClientLeftIsCarriedOut) {
  Sessions sessions(nobody, "7");
  sessions.attach(lock_step->cell().view());
  const auto client = sessions.welcome({"127.0.0.1", true, Role::watch});
  ASSERT_TRUE(client->take(R"({"id": 1, "request": "control.stop"})", 1));
  client->leave();
  sessions.serve();
  lock_step->run(0.2);
  EXPECT_EQ(lock_step->cell().view().snapshot().state, control::RunState::held);
  sessions.detach();
}

TEST_F(UsersOfACell, WrongPasswordsAreRefusedAndSlowedDown) {
  EXPECT_EQ(WebPeer::status(log_in("otto", "wrong password")), 403);
  EXPECT_EQ(WebPeer::status(log_in("nobody", "right password")), 403);
  EXPECT_EQ(WebPeer::status(WebPeer::fetch(pendant->port(), "/api/login", {}, "POST")), 400);
  EXPECT_EQ(WebPeer::status(log_in("otto", "right password", {"Origin: http://evil.example"})), 403);
  EXPECT_EQ(WebPeer::status(log_in("otto", "right password", {"Sec-Fetch-Site: cross-site"})), 403);
  EXPECT_EQ(WebPeer::status(log_in("otto", "right password", {"Host: evil.example"})), 421);
  int slowed = 0;
  for (int n = 0; n < 8; ++n) slowed += WebPeer::status(log_in("otto", "wrong password")) == 429 ? 1 : 0;
  EXPECT_GE(slowed, 1);
  EXPECT_NE(WebPeer::fetch(pendant->port(), "/api/login").find(R"({"users":true})"), std::string::npos);
}

TEST_F(UsersOfACell, APageWithALinkNeedNotLogIn) {
  const auto enters = [&](const std::string& authorization) {
    return WebPeer::fetch(pendant->port(), "/api/login", {"Authorization: " + authorization})
               .find(R"("enters":true)") != std::string::npos;
  };
  EXPECT_TRUE(enters("Bearer secret"));
  EXPECT_TRUE(enters("Bearer " + token_for("secret", Role::watch)));
  EXPECT_FALSE(enters("Bearer wrong"));
  EXPECT_FALSE(enters("Basic " + base64("otto:right password")));
  const std::string cookie = cookie_of(log_in("otto", "right password"));
  EXPECT_TRUE(enters("Bearer " + cookie.substr(cookie.find('=') + 1)));
}

TEST_F(UsersOfACell, ALogOutAndARemovedUserEndTheConnection) {
  const std::string cookie = cookie_of(log_in("otto", "right password"));
  WebPeer peer(pendant->port());
  ASSERT_EQ(peer.upgrade({"Cookie: " + cookie, "Origin: http://" + peer.host()}), 101);
  ASSERT_EQ(code(ask(peer, {{"request", "health"}})), "ok");
  EXPECT_EQ(WebPeer::status(WebPeer::fetch(pendant->port(), "/api/logout",
                                           {"Cookie: " + cookie, "Origin: http://" + peer.host()}, "POST")),
            200);
  // With the code of a policy: the port says goodbye, and does not wait for a ping that is not answered.
  const auto ends = [&](WebPeer& each) {
    for (int n = 0; n < 20'000 && !each.closed() && each.close_code == 0; ++n) {
      pendant->serve();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      each.listen();
      each.take();
    }
    return each.close_code == 1008;
  };
  EXPECT_TRUE(ends(peer));
  WebPeer again(pendant->port());
  EXPECT_EQ(again.upgrade({"Cookie: " + cookie, "Origin: http://" + again.host()}), 403);
  const auto vera = connect("vera");
  users::change_users(folder.path() / "users", [](users::UserList& list) { list.remove("vera"); });
  EXPECT_TRUE(ends(*vera));
}

TEST_F(UsersOfACell, AViewerOfAnotherToolEndsWithTheLogInToo) {
  const std::string cookie = cookie_of(log_in("otto", "right password"));
  WebPeer viewer(pendant->port());
  ASSERT_EQ(viewer.upgrade({"Authorization: Bearer " + cookie.substr(cookie.find('=') + 1),
                            "Sec-WebSocket-Protocol: foxglove.sdk.v1"}),
            101);
  users::change_users(folder.path() / "users", [](users::UserList& list) { list.remove("otto"); });
  for (int n = 0; n < 20'000 && !viewer.closed() && viewer.close_code == 0; ++n) {
    pendant->serve();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    viewer.listen();
    viewer.take();
  }
  EXPECT_EQ(viewer.close_code, 1008);
}

TEST_F(UsersOfACell, ARestartEndsNoLinkAndUsersCannotGuessIt) {
  WebPeer peer(pendant->port());
  EXPECT_EQ(peer.upgrade({"Authorization: Bearer secret"}), 101) << "the link of the terminal still works";
  WebPeer other(pendant->port());
  EXPECT_EQ(other.upgrade({"Authorization: Basic " + base64("otto:right password")}), 401)
      << "a password opens nothing but the log-in";
}

TEST_F(UsersOfACell, EveryChangeAndEveryRefusalIsLoggedWithTheName) {
  log_in("otto", "wrong password");
  const auto otto = connect("otto");
  ask(*otto, {{"request", "session.take"}});
  ask(*otto, {{"request", "health"}});
  ask(*otto, {{"request", "files.write"}, {"name", "work.script"}, {"text", "wait 2s"}});
  const auto entries = log();
  const auto has = [&](const char* who, const char* request, const std::string& outcome) {
    return std::any_of(entries.begin(), entries.end(), [&](const Json& each) {
      return each["who"] == who && each["request"] == request && each["outcome"] == outcome;
    });
  };
  EXPECT_TRUE(has("otto", "log-in", "wrong-password"));
  EXPECT_TRUE(has("otto", "log-in", "done"));
  EXPECT_TRUE(has("otto", "session.take", "done"));
  EXPECT_TRUE(has("otto", "files.write", "no-role"));
  EXPECT_FALSE(std::any_of(entries.begin(), entries.end(),
                           [](const Json& each) { return each["request"] == "health"; }));
  for (const Json& each : entries) {
    EXPECT_EQ(each.dump().find("right password"), std::string::npos);
    EXPECT_EQ(each.dump().find("wrong password"), std::string::npos);
  }
}

}  // namespace
}  // namespace polyarm::server
