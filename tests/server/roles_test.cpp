/// Who may ask what: every request, at every role, in front of a whole cell.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <set>
#include <thread>

#include "polyarm/access/token.hpp"
#include "polyarm/base/bounds.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/protocol/request.hpp"
#include "polyarm/server/pendant.hpp"
#include "polyarm/server/sessions.hpp"
#include "polyarm/setup/cell_file.hpp"
#include "tests/support/lock_step_cell.hpp"
#include "tests/support/web_peer.hpp"

namespace polyarm::server {
namespace {

using protocol::Role;
using test::Json;
using test::LockStepCell;
using test::WebPeer;

class RolesInACell : public ::testing::Test {
 protected:
  RolesInACell() {
    const std::string arm = std::string(POLYARM_SOURCE_DIR) + "/examples/r6bot/r6bot.urdf";
    folder.write("cell.yaml", "polyarm: cell/1\nrobots:\n  arm: {model: " + arm + ", hardware: mock}\n");
    folder.write("work.script", "wait 1s\n");
    lock_step = std::make_unique<LockStepCell>(cell::read_cell_file(folder.path()));
    PendantOptions options;
    options.port = 0;
    options.token = "secret";
    pendant = std::make_unique<Pendant>(options, nobody);
    pendant->attach(lock_step->cell().view());
    lock_step->run(0.05);
  }
  ~RolesInACell() override { pendant->detach(); }

  std::unique_ptr<WebPeer> connect(Role role) {
    auto peer = std::make_unique<WebPeer>(pendant->port());
    EXPECT_EQ(peer->upgrade({"Authorization: Bearer " + token_for("secret", role)}), 101);
    return peer;
  }
  Json ask(WebPeer& peer, Json request) {
    const int id = ++last_;
    request["id"] = id;
    peer.send(request);
    for (int n = 0; n < 20'000 && peer.answer(id).is_null(); ++n) {
      pendant->serve();
      if (n % 5 == 4) lock_step->tick();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      peer.listen();
      peer.take();
    }
    return peer.answer(id);
  }
  std::string code(const Json& answer) {
    return answer.value("ok", false) ? "ok"
           : answer.is_null()        ? "none"
                                     : answer["error"]["code"].get<std::string>();
  }
  /// The request with the argument with which it does more than read.
  static Json asked(const protocol::Facts& facts) {
    Json out{{"request", facts.name}};
    if (facts.watch_without) out[facts.watch_without] = true;
    return out;
  }
  static std::vector<protocol::Facts> above(Role role) {
    std::vector<protocol::Facts> out;
    for (const protocol::RequestType* type : protocol::request_types())
      if (type->facts->role > role) out.push_back(*type->facts);
    return out;
  }

  struct Nobody : cell::Observer {};
  Nobody nobody;
  test::Folder folder;
  std::unique_ptr<LockStepCell> lock_step;
  std::unique_ptr<Pendant> pendant;
  int last_ = 0;
};

TEST_F(RolesInACell, WithoutControlNothingIsDoneThatIsMoreThanTelling) {
  const auto holder = connect(Role::administer), watcher = connect(Role::administer);
  ASSERT_EQ(code(ask(*holder, {{"request", "session.take"}})), "ok");
  for (const protocol::Facts& row : above(Role::watch))
    EXPECT_EQ(code(ask(*watcher, asked(row))), "no-control") << row.name;
  EXPECT_FALSE(std::filesystem::exists(folder.path() / ".state" / "drafts"));
  EXPECT_FALSE(lock_step->cell().restart());
}

TEST_F(RolesInACell, ALinkAllowsNoMoreThanItsRoleEvenInControl) {
  for (const Role role : {Role::operate, Role::program}) {
    const auto peer = connect(role);
    EXPECT_EQ(ask(*peer, {{"request", "session.hello"}})["result"]["role"], protocol::name(role));
    ASSERT_TRUE(ask(*peer, {{"request", "session.take"}})["result"]["you_hold"].get<bool>());
    for (const protocol::Facts& row : above(role))
      EXPECT_EQ(code(ask(*peer, asked(row))), "no-role") << row.name;
    EXPECT_EQ(code(ask(*peer, {{"request", "control.override"}, {"percent", 50}})), "ok");
    ask(*peer, {{"request", "session.release"}});
  }
}

TEST_F(RolesInACell, WhoMayOnlyWatchIsToldEverythingAndStops) {
  const auto watcher = connect(Role::watch);
  EXPECT_EQ(code(ask(*watcher, {{"request", "session.take"}})), "no-role");
  for (const protocol::Facts& row : above(Role::watch))
    EXPECT_EQ(code(ask(*watcher, asked(row))), "no-role") << row.name;
  EXPECT_EQ(code(ask(*watcher, {{"request", "health"}})), "ok");
  EXPECT_EQ(code(ask(*watcher, {{"request", "control.override"}})), "ok") << "without percent it only tells";
  EXPECT_EQ(code(ask(*watcher, {{"request", "control.stop"}})), "ok");
  lock_step->run(0.1);
  EXPECT_EQ(lock_step->cell().snapshot().state, control::RunState::held);
}

/// Who reads the log must not learn a link that allows more.
TEST_F(RolesInACell, NoLinkIsInWhatAWatcherReads) {
  lock_step->cell().view().tell("pendant: " + pendant->link());
  pendant->observer().on_note("pendant: " + pendant->link());
  lock_step->run(0.05);
  const auto watcher = connect(Role::watch);
  const Json events = ask(*watcher, {{"request", "events"}, {"since", 0}});
  EXPECT_NE(events.dump().find("pendant: http"), std::string::npos) << events;
  EXPECT_EQ(events.dump().find("token=secret"), std::string::npos) << events;
  // The log of the page: all lines come after session.watch.
  ask(*watcher, {{"request", "session.hello"}, {"name", "watcher"}});
  ask(*watcher, {{"request", "session.watch"}, {"rate", 10}});
  Json log;
  for (int n = 0; n < 2000 && log.is_null(); ++n) {
    ask(*watcher, {{"request", "health"}});
    log = watcher->event("log");
  }
  EXPECT_NE(log.dump().find("pendant: http"), std::string::npos) << log;
  EXPECT_EQ(log.dump().find("token=secret"), std::string::npos) << log;
}

TEST_F(RolesInACell, TheProjectIsReadAndReplacedByThoseWhoMay) {
  const auto status = [&](Role role, const std::string& method) {
    return WebPeer::status(WebPeer::fetch(pendant->port(), "/api/project.zip?name=x",
                                          {"Authorization: Bearer " + token_for("secret", role)}, method,
                                          method == "PUT" ? "no zip" : ""));
  };
  EXPECT_EQ(status(Role::watch, "GET"), 403);
  EXPECT_EQ(status(Role::program, "PUT"), 403);
  EXPECT_EQ(status(Role::administer, "PUT"), 400) << "it is not a zip, but was looked at";
}

TEST_F(RolesInACell, ADraftIsOfWhoWroteIt) {
  const auto peer = connect(Role::administer);
  ask(*peer, {{"request", "session.hello"}, {"name", "Tablet 4"}});
  ask(*peer, {{"request", "session.take"}});
  ASSERT_EQ(code(ask(*peer, {{"request", "files.draft"},
                             {"name", "work.script"},
                             {"text", "wait 2s"},
                             {"by", "somebody else"}})),
            "ok");
  EXPECT_EQ(ask(*peer, {{"request", "files.read"}, {"name", "work.script"}})["result"]["draft"]["by"], "Tablet 4");
}

TEST_F(RolesInACell, DraftsHaveABound) {
  const auto peer = connect(Role::administer);
  ask(*peer, {{"request", "session.take"}});
  std::string last = "ok";
  for (std::size_t i = 0; i <= bounds::kDraftsBytes / 800'000 + 1 && last == "ok"; ++i)
    last = code(ask(*peer, {{"request", "files.draft"},
                            {"name", "draft" + std::to_string(i) + ".script"},
                            {"text", std::string(800'000, 'x')}}));
  EXPECT_EQ(last, "too-large");
}

TEST_F(RolesInACell, SeatsForWatchersRunOutBeforeThoseForControl) {
  std::vector<std::unique_ptr<WebPeer>> watchers;
  for (std::size_t i = 0; i < bounds::kPageClients; ++i) watchers.push_back(connect(Role::watch));
  WebPeer one_more(pendant->port()), operating(pendant->port());
  EXPECT_EQ(one_more.upgrade({"Authorization: Bearer " + token_for("secret", Role::watch)}), 503);
  EXPECT_EQ(operating.upgrade({"Authorization: Bearer secret"}), 101);
  EXPECT_TRUE(ask(operating, {{"request", "session.take"}})["result"]["you_hold"].get<bool>());
}

/// Sessions without a port, so that what comes in within one tick is known.
class ManyClients : public RolesInACell {
 protected:
  ManyClients() : sessions(nobody, "7") {
    sessions.attach(lock_step->cell().view());
    for (int i = 0; i < 100; ++i) clients.push_back(sessions.welcome({"client", true, Role::administer}));
  }
  ~ManyClients() override { sessions.detach(); }
  /// The answers that wait to be sent to it.
  std::vector<Json> answers(std::size_t client) {
    std::vector<Json> out;
    while (const auto each = clients[client]->next())
      if (!each->binary) out.push_back(Json::parse(*each->body));
    return out;
  }
  Sessions sessions;
  std::vector<std::shared_ptr<Client>> clients;
};

TEST_F(ManyClients, AStopIsTakenInTheSameTickHoweverMuchOthersAsk) {
  for (std::size_t i = 0; i < clients.size(); ++i)
    for (std::size_t n = 0; n < bounds::kClientBurst - 1; ++n)
      ASSERT_TRUE(clients[i]->take(R"({"id":1,"request":"points"})", 100.0));
  for (std::size_t i : {std::size_t{99}, std::size_t{0}, std::size_t{50}}) {
    clients[i]->take(R"({"id":"stop","request":"control.stop"})", 100.0);
    sessions.serve();
    bool answered = false;
    for (const Json& each : answers(i)) answered = answered || each["id"] == "stop";
    EXPECT_TRUE(answered) << i;
    lock_step->tick();
  }
  lock_step->run(0.1);
  EXPECT_EQ(lock_step->cell().snapshot().state, control::RunState::held);
}

TEST_F(ManyClients, EachHasItsTurn) {
  for (std::size_t n = 0; n < bounds::kClientBurst; ++n) clients[0]->take(R"({"id":1,"request":"points"})", 100.0);
  for (std::size_t i = 1; i < clients.size(); ++i)
    clients[i]->take(R"({"id":2,"request":"session.hello"})", 100.0);
  std::set<std::size_t> answered;
  for (int tick = 0; tick < 400 && answered.size() < 99; ++tick) {
    sessions.serve();
    lock_step->tick();
    for (std::size_t i = 1; i < clients.size(); ++i)
      if (!answers(i).empty()) answered.insert(i);
  }
  EXPECT_EQ(answered.size(), 99u);
  EXPECT_LT(answers(0).size(), bounds::kClientBurst) << "the chatty one is not done before the others";
}

TEST_F(ManyClients, WhatWasSentBeforeAStopDoesNotMoveWhatItStopped) {
  clients[0]->take(R"({"id":1,"request":"session.take"})", 100.0);
  sessions.serve();
  clients[0]->take(R"({"id":2,"request":"control.resume"})", 100.0);
  clients[0]->take(R"({"id":3,"request":"control.stop"})", 100.0);
  sessions.serve();
  lock_step->run(0.1);
  std::string resumed;
  for (const Json& each : answers(0))
    if (each["id"] == 2) resumed = code(each);
  EXPECT_EQ(resumed, "overtaken");
  EXPECT_EQ(lock_step->cell().snapshot().state, control::RunState::held);
}

TEST_F(ManyClients, WhoHasNoControlSendsShortRequests) {
  clients[0]->take("{\"id\":1,\"request\":\"program.check\",\"name\":\"work.script\",\"text\":\"" +
                       std::string(bounds::kWatcherRequestBytes, '#') + "\"}",
                   100.0);
  sessions.serve();
  const auto told = answers(0);
  ASSERT_FALSE(told.empty());
  EXPECT_EQ(code(told.front()), "too-long");
}

TEST_F(ManyClients, EndingWhatIsNotOpenKeepsNothing) {
  clients[0]->take(R"({"id":1,"request":"session.watch","rate":0})", 100.0);
  for (int i = 0; i < 100; ++i)
    clients[0]->take("{\"id\":2,\"request\":\"session.end\",\"of\":\"" + std::string(100'000, 'x') + "\"}", 100.0);
  for (int i = 0; i < 400; ++i) sessions.serve();
  EXPECT_EQ(lock_step->cell().requests().open(), 0u);
  EXPECT_GE(answers(0).size(), 30u) << "all that there was room for were answered";
}

}  // namespace
}  // namespace polyarm::server
