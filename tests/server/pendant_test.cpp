/// The pendant's server in front of a whole cell, in lock-step: time is the cell's.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <random>
#include <thread>

#include "polyarm/protocol/reference.hpp"
#include "polyarm/realtime/periodic.hpp"
#include "polyarm/server/assets.hpp"
#include "tests/server/pendant_rig.hpp"

namespace polyarm::server {
namespace {

TEST_F(PendantTest, TheWayOfAMoveIsToldWithWhereItGoes) {
  const auto peer = connect();
  ask(*peer, {{"request", "session.hello"}});
  ask(*peer, {{"request", "session.take"}});
  const double before = joint();
  const Json first = ask(*peer, {{"request", "points.here"}})["result"]["joints"];
  Json second = first;
  second["joint_2"] = before + 0.4;
  Json third = second;
  third["joint_1"] = 0.5;
  peer->send({{"id", 900},
              {"request", "move"},
              {"points", Json::array({{{"joints", second}}, {{"joints", third}}})},
              {"rests", true}});
  const auto target = [](const Json& plan, const char* joint) {
    return plan["plans"].contains("arm") ? plan["plans"]["arm"]["target"]["joints"][joint].get<double>() : -9;
  };
  ASSERT_TRUE(heard(*peer, "plan",
                    [&](const Json& plan) {
                      return std::abs(target(plan, "joint_2") - before - 0.4) < 1e-3 &&
                             target(plan, "joint_1") < 0.1;
                    }))
      << peer->event("plan") << peer->answer(900);
  const Json path = peer->event("plan")["plans"]["arm"]["path"];
  ASSERT_GE(path.size(), 20u);
  const Pose tcp = cell->cell().tcp(0);
  EXPECT_NEAR(path[0][0].get<double>(), tcp.position.x, 0.05) << "it begins where the robot was";
  EXPECT_TRUE(heard(*peer, "plan", [&](const Json& plan) {
    return plan["plans"].contains("arm") &&
           plan["plans"]["arm"].value("clear", Json::array()).size() == path.size();
  })) << "the distances along it follow";
  EXPECT_TRUE(heard(*peer, "plan", [&](const Json& plan) { return target(plan, "joint_1") > 0.49; }));
  EXPECT_TRUE(heard(*peer, "plan", [](const Json& plan) { return plan["plans"].empty(); }))
      << "it has arrived";
}

TEST_F(PendantTest, ALinkBecomesACookieThatOpensEverything) {
  const std::string link = pendant->link();
  const std::string came = WebPeer::fetch(pendant->port(), link.substr(link.find("/?")));
  EXPECT_EQ(WebPeer::status(came), 302);
  const auto at = came.find("Set-Cookie: ");
  ASSERT_NE(at, std::string::npos) << came;
  const std::string cookie = came.substr(at + 12, came.find(';', at) - at - 12);
  for (const char* word : {"HttpOnly", "SameSite=Strict", "Path=/"})
    EXPECT_NE(came.find(word), std::string::npos);
  EXPECT_EQ(WebPeer::status(WebPeer::fetch(pendant->port(), "/api/cell", {"Cookie: " + cookie})), 200);
  EXPECT_EQ(WebPeer::status(WebPeer::fetch(pendant->port(), "/?token=wrong")), 403);
  EXPECT_EQ(WebPeer::status(WebPeer::fetch(pendant->port(), "/api/cell")), 401);
  const std::string page = WebPeer::fetch(pendant->port(), "/");
  EXPECT_EQ(WebPeer::status(page), 200);
  EXPECT_NE(page.find("Content-Security-Policy: default-src 'self'"), std::string::npos);
}

/// The page's own files are public, as docs/pendant.md says; nothing of the cell is.
TEST_F(PendantTest, WithoutATokenThereIsThePageAndNothingOfTheCell) {
  const std::string link = pendant->link(), token = link.substr(link.find("token=") + 6);
  for (const char* path : {"/", "/help/"}) {
    const std::string answer = WebPeer::fetch(pendant->port(), path);
    EXPECT_NE(WebPeer::status(answer), 401) << path;
    EXPECT_EQ(answer.find("token=" + token), std::string::npos) << path;
    EXPECT_EQ(answer.find(cell->cell().file().folder.string()), std::string::npos) << path;
    EXPECT_EQ(answer.find("Set-Cookie"), std::string::npos) << path;
  }
  for (const char* path : {"/api/cell", "/api/requests", "/api/catalogue", "/api/project", "/api/none", "/api/"})
    EXPECT_EQ(WebPeer::status(WebPeer::fetch(pendant->port(), path)), 401) << path;
}

TEST_F(PendantTest, ThePageIsDecompressedForWhoTakesNoGzip) {
  const auto page = [&](const std::string& encoding) {
    std::vector<std::string> headers;
    if (!encoding.empty()) headers.push_back("Accept-Encoding: " + encoding);
    return WebPeer::fetch(pendant->port(), "/", headers);
  };
  const auto is_compressed = [](const std::string& answer) {
    return answer.find("Content-Encoding: gzip") != std::string::npos;
  };
  for (const char* none : {"", "identity", "gzip;q=0", "br, gzip; q=0.0"}) {
    const std::string answer = page(none);
    EXPECT_FALSE(is_compressed(answer)) << none;
    EXPECT_NE(body(answer).find("<!doctype html"), std::string::npos) << none;
  }
  const std::string answer = page("gzip");
  if (is_compressed(answer)) {  // a build without a page has nothing to compress
    EXPECT_NE(answer.find("Vary: Accept-Encoding"), std::string::npos);
    EXPECT_EQ(body(answer).substr(0, 2), "\x1f\x8b");
  }
}

TEST_F(PendantTest, TheHelpIsServedWithoutAToken) {
  if (server::embedded_help().empty()) GTEST_SKIP() << "this build has no page";
  EXPECT_NE(body(WebPeer::fetch(pendant->port(), "/help/")).find("<h1 id=\"documentation\">"), std::string::npos);
  EXPECT_EQ(WebPeer::status(WebPeer::fetch(pendant->port(), "/help/stops.html")), 200);
  EXPECT_EQ(WebPeer::status(WebPeer::fetch(pendant->port(), "/help")), 302);
  EXPECT_EQ(WebPeer::status(WebPeer::fetch(pendant->port(), "/help/no-such-page.html")), 404);
  EXPECT_EQ(WebPeer::status(WebPeer::fetch(pendant->port(), "/helpless/")), 404);
}

TEST_F(PendantTest, TheFolderOfTheCellIsWholeHoweverItWasNamed) {
  pendant->detach();
  cell = std::make_unique<LockStepCell>(cell::read_cell_file(std::filesystem::relative(folder.path())));
  pendant->attach(cell->cell().view());
  const Json cell_now = Json::parse(body(fetch("/api/cell")));
  EXPECT_EQ(cell_now["folder"], std::filesystem::canonical(folder.path()).string());
}

TEST_F(PendantTest, TheCellItsModelAndItsSceneAreThereToBeDrawn) {
  const Json cell_now = Json::parse(body(fetch("/api/cell")));
  ASSERT_EQ(cell_now["robots"].size(), 1u);
  EXPECT_EQ(cell_now["robots"][0]["name"], "arm");
  EXPECT_EQ(cell_now["robots"][0]["joints"][1]["interface"], "arm/joint_2");
  const Json model = Json::parse(body(fetch(cell_now["robots"][0]["model"])));
  EXPECT_EQ(model["root"], "world");
  EXPECT_EQ(model["joints"].size() + 1, model["links"].size());
  for (const Json& joint : model["joints"]) EXPECT_EQ(joint["origin"]["q"].size(), 4u);
  EXPECT_TRUE(Json::parse(body(fetch("/api/scene"))).contains("fixtures"));
  EXPECT_EQ(Json::parse(body(fetch("/api/requests"))).size(), protocol::help_rows().size());
  for (const char* path :
       {"/api/model/other", "/api/mesh/0.glb", "/api/", "/api/cell/", "/assets/../api/cell"})
    EXPECT_NE(WebPeer::status(fetch(path)), 200) << path;
}

TEST_F(PendantTest, StateFramesSayWhatTheirLayoutSays) {
  const auto peer = connect();
  ask(*peer, {{"request", "session.watch"}, {"rate", 60}});
  ASSERT_TRUE(until([&] {
    peer->listen();
    peer->take();
    return peer->frames > 3;
  }));
  const Json layout = peer->event("layout");
  ASSERT_TRUE(layout.contains("fields"));
  const std::string& frame = peer->last_frame;
  ASSERT_EQ(frame.size(), 16 + 4 * layout["fields"].size());
  std::uint16_t id = 0;
  std::memcpy(&id, frame.data() + 2, sizeof id);
  EXPECT_EQ(frame[0], 1);
  EXPECT_EQ(id, layout["id"].get<int>());
  bool found = false;
  for (std::size_t i = 0; i < layout["fields"].size(); ++i) {
    if (layout["fields"][i]["name"] != "arm/joint_2/position") continue;
    float value = 0;
    std::memcpy(&value, frame.data() + 16 + 4 * i, sizeof value);
    EXPECT_FLOAT_EQ(value, static_cast<float>(joint()));
    EXPECT_EQ(layout["fields"][i]["unit"], "rad");
    found = true;
  }
  EXPECT_TRUE(found);
}

TEST_F(PendantTest, RequestsOfTheTableAreAnsweredAsOnTheLocalSocket) {
  const auto peer = connect();
  const Json listed = ask(*peer, {{"request", "control.list"}});
  ASSERT_EQ(code(listed), "ok");
  EXPECT_EQ(listed["result"], cell->result({{"request", "control.list"}}));
  EXPECT_EQ(code(ask(*peer, {{"request", "control.lis"}})), "unknown-request");
  peer->say(WebPeer::frame("no json"));
  peer->say(WebPeer::frame(std::string(100'000, '[')));
  peer->say(WebPeer::frame("{\"request\": 7}"));
  EXPECT_EQ(code(ask(*peer, {{"request", "session.watch"}, {"rate", "fast"}})), "bad-argument");
  EXPECT_EQ(code(ask(*peer, {{"request", "session.hello"}, {"name", 7}})), "bad-argument");
  EXPECT_EQ(std::count_if(peer->answers.begin(), peer->answers.end(),
                          [&](const Json& answer) { return code(answer) == "bad-request"; }),
            3);
}

TEST_F(PendantTest, OnlyWhoHoldsControlMovesAndEverybodyStops) {
  const auto one = connect(), two = connect();
  EXPECT_EQ(code(ask(*one, {{"request", "control.override"}, {"percent", 50}})), "no-control");
  EXPECT_EQ(code(begin_jog(*one)), "no-control");
  EXPECT_EQ(code(ask(*one, {{"request", "jog.step"}, {"axis", 0}, {"amount", 0.1}})), "no-control");
  EXPECT_TRUE(ask(*one, {{"request", "session.take"}})["result"]["you_hold"].get<bool>());
  EXPECT_EQ(code(ask(*one, {{"request", "control.override"}, {"percent", 50}})), "ok");
  EXPECT_EQ(code(ask(*two, {{"request", "control.override"}, {"percent", 100}})), "no-control");
  EXPECT_EQ(code(ask(*two, {{"request", "health"}})), "ok");
  EXPECT_EQ(code(ask(*two, {{"request", "control.hold"}})), "ok");
  EXPECT_TRUE(until([&] { return cell->cell().snapshot().state == control::RunState::held; }));
}

TEST_F(PendantTest, ControlIsHandedOverByConsentOrWhenTheHolderIsGone) {
  const auto one = connect(), two = connect();
  ask(*one, {{"request", "session.hello"}, {"name", "tablet"}});
  ask(*one, {{"request", "session.take"}});
  const Json asked = ask(*two, {{"request", "session.take"}});
  EXPECT_FALSE(asked["result"]["you_hold"].get<bool>());
  EXPECT_EQ(asked["result"]["holder"]["name"], "tablet");
  EXPECT_TRUE(heard(*one, "asked"));
  EXPECT_EQ(code(ask(*one, {{"request", "session.answer"}, {"give", false}})), "ok");
  EXPECT_TRUE(heard(*two, "control", [](const Json& e) { return e["what"] == "refused"; }));
  ask(*two, {{"request", "session.take"}});
  ask(*one, {{"request", "session.answer"}, {"give", true}});
  EXPECT_TRUE(heard(*two, "control", [](const Json& e) { return e["you_hold"] == true; }));
  EXPECT_EQ(code(ask(*two, {{"request", "control.override"}, {"percent", 60}})), "ok");
  two->close_connection();
  ask(*one, {{"request", "session.hello"}});
  EXPECT_TRUE(
      heard(*one, "status", [](const Json& e) { return e["holder"].is_null() && e["clients"] == 1; }));
  EXPECT_TRUE(ask(*one, {{"request", "session.take"}})["result"]["you_hold"].get<bool>());
}

TEST_F(PendantTest, AHeldKeyMovesAsLongAsHeartbeatsCome) {
  const auto peer = connect();
  ask(*peer, {{"request", "session.take"}});
  const Json begun = begin_jog(*peer);
  ASSERT_EQ(code(begun), "ok") << begun;
  const double before = joint();
  for (int i = 0; i < 20; ++i) {
    beat(*peer, begun["result"]["jog"]);
    run(0.05);
    EXPECT_FALSE(standing()) << i;
  }
  EXPECT_GT(joint(), before + 0.1);
  EXPECT_EQ(code(ask(*peer, {{"request", "jog.end"}, {"jog", begun["result"]["jog"]}})), "ok");
  run(1);
  EXPECT_TRUE(standing());
  EXPECT_TRUE(heard(*peer, "jog", [](const Json& e) { return e["over"] == true && e["why"] == "released"; }));
}

/// The time from the last heartbeat to rest, s of the cell. At teaching speed.
double time_to_rest(PendantTest&, test::OpenCell& cell, const std::function<void()>& tick) {
  const Nanoseconds since = cell.now();
  for (int n = 0; n < 1000 && !cell.jogging().status(0).standing; ++n) tick();
  return seconds(cell.now() - since);
}

TEST_F(PendantTest, WithoutAHeartbeatItStandsInAQuarterOfASecondAndANewPressIsNeeded) {
  cell->cell().set_profile("reduced");
  for (const int axis : {0, 1, 2, 3, 4, 5}) {
    const auto peer = connect();
    ask(*peer, {{"request", "session.take"}});
    const Json begun =
        ask(*peer, {{"request", "jog.begin"}, {"mode", "joint"}, {"axis", axis}, {"direction", 1}});
    ASSERT_EQ(code(begun), "ok") << begun;
    const Json jog = begun["result"]["jog"];
    for (int i = 0; i < 8; ++i) {
      beat(*peer, jog);
      run(0.05);
    }
    beat(*peer, jog);
    EXPECT_FALSE(standing());
    EXPECT_LE(time_to_rest(*this, cell->cell(), [&] { tick(); }), 0.25) << "axis " << axis;
    EXPECT_TRUE(standing());
    const double stood = joint();
    beat(*peer, jog);
    run(0.3);
    EXPECT_NEAR(joint(), stood, 1e-6) << "a heartbeat that comes too late moves nothing";
    EXPECT_TRUE(heard(*peer, "jog", [](const Json& e) { return e["over"] == true && e["why"] == "lost"; }));
    EXPECT_EQ(code(begin_jog(*peer)), "ok") << "pressed again";
    peer->close_connection();
    run(1);
    until([&] { return pendant->counts().clients == 0; });
    cell->run(1);
  }
}

TEST_F(PendantTest, WhoIsKilledWhileJoggingLeavesItAtRestAtOnce) {
  cell->cell().set_profile("reduced");
  const auto peer = connect();
  ask(*peer, {{"request", "session.take"}});
  const Json begun = begin_jog(*peer);
  for (int i = 0; i < 10; ++i) {
    beat(*peer, begun["result"]["jog"]);
    run(0.05);
  }
  beat(*peer, begun["result"]["jog"]);
  peer->close_connection();
  ASSERT_TRUE(served_until([&] { return pendant->counts().clients == 0; }));
  EXPECT_FALSE(standing());
  const double after = time_to_rest(*this, cell->cell(), [&] { tick(); });
  EXPECT_LT(after, 0.2) << "braking alone, not only when its heartbeats are missed";
  EXPECT_TRUE(standing());
}

TEST_F(PendantTest, AServerThatIsFrozenLeavesItAtRest) {
  cell->cell().set_profile("reduced");
  const auto peer = connect();
  ask(*peer, {{"request", "session.take"}});
  const Json begun = begin_jog(*peer);
  for (int i = 0; i < 10; ++i) {
    beat(*peer, begun["result"]["jog"]);
    run(0.05);
  }
  beat(*peer, begun["result"]["jog"]);
  EXPECT_LE(time_to_rest(*this, cell->cell(), [&] { cell->tick(); }), 0.25) << "nobody serves any more";
  EXPECT_TRUE(standing());
}

TEST_F(PendantTest, WhoLosesControlLosesTheKeyThatIsHeld) {
  const auto one = connect(), two = connect();
  ask(*one, {{"request", "session.take"}});
  const Json begun = begin_jog(*one);
  beat(*one, begun["result"]["jog"]);
  run(0.05);
  EXPECT_FALSE(standing());
  EXPECT_TRUE(ask(*two, {{"request", "session.take"}, {"force", true}})["result"]["you_hold"].get<bool>());
  EXPECT_TRUE(heard(*one, "jog", [](const Json& e) { return e["over"] == true; }));
  EXPECT_TRUE(heard(*one, "control", [](const Json& e) { return e["what"] == "taken"; }));
  run(0.5);
  EXPECT_TRUE(standing());
}

TEST_F(PendantTest, OneCannotBeatForAnother) {
  const auto one = connect(), two = connect();
  ask(*one, {{"request", "session.take"}});
  const Json begun = begin_jog(*one);
  for (int i = 0; i < 10; ++i) {
    beat(*two, begun["result"]["jog"]);
    run(0.05);
  }
  EXPECT_TRUE(standing());
}

TEST_F(PendantTest, StepsAndTheTcpMoveInTheirFrames) {
  const auto peer = connect();
  ask(*peer, {{"request", "session.take"}});
  for (const int axis : {1, 2, 4})
    EXPECT_EQ(code(ask(*peer, {{"request", "jog.step"}, {"mode", "joint"}, {"axis", axis}, {"amount", 0.6}})),
              "ok");
  const Pose before = cell->cell().tcp(0);
  const Json stepped = ask(
      *peer, {{"request", "jog.step"}, {"mode", "tcp"}, {"frame", "base"}, {"axis", 0}, {"amount", -0.03}});
  ASSERT_EQ(code(stepped), "ok") << stepped;
  const Vec3 way = cell->cell().tcp(0).position - before.position;
  EXPECT_NEAR(way.x, -0.03, 1e-4);
  EXPECT_NEAR(way.y, 0, 1e-4);
  EXPECT_EQ(
      code(ask(*peer,
               {{"request", "jog.step"}, {"mode", "tcp"}, {"frame", "moon"}, {"axis", 0}, {"amount", 0.1}})),
      "unknown-frame");
  EXPECT_EQ(code(ask(*peer, {{"request", "jog.begin"}, {"mode", "joint"}, {"axis", 17}})), "bad-argument");
  EXPECT_EQ(code(ask(*peer, {{"request", "jog.begin"}, {"mode", "sideways"}, {"axis", 0}})), "bad-argument");
  EXPECT_EQ(code(ask(*peer, {{"request", "jog.begin"}, {"robot", "leg"}, {"axis", 0}})), "unknown-robot");
  const Json begun =
      ask(*peer, {{"request", "jog.begin"}, {"mode", "tcp"}, {"axis", {0, 0, 1, 0, 0, 0}}, {"speed", 0.1}});
  ASSERT_EQ(code(begun), "ok") << begun;
  const double z = cell->cell().tcp(0).position.z;
  for (int i = 0; i < 10; ++i) {
    beat(*peer, begun["result"]["jog"]);
    run(0.05);
  }
  EXPECT_GT(cell->cell().tcp(0).position.z, z + 0.01);
}

TEST_F(PendantTest, GoesToAPlaceByJointsOrInALineAndSaysBeforehandWhereItCannot) {
  cell->cell().set_profile(
      "reduced");  // the TCP's speed is limited on the way, which has to leave it straight
  const auto peer = connect();
  ask(*peer, {{"request", "session.take"}});
  const auto go = [&](Json place, const char* kind, double& off_joints, double& off_line) {
    run(0.5);
    place["request"] = "jog.goto";
    place["kind"] = kind;
    const auto joints = [&] {
      std::vector<double> q;
      for (int j = 1; j <= 6; ++j)
        q.push_back(cell->value_of("states", "arm/joint_" + std::to_string(j) + "/position"));
      return q;
    };
    place["dry"] = true;
    const Json looked = ask(*peer, place);
    ASSERT_EQ(code(looked), "ok") << looked;
    std::vector<double> to;
    for (int j = 1; j <= 6; ++j)
      to.push_back(looked["result"]["joints"]["joint_" + std::to_string(j)].get<double>());
    const auto end = looked["result"]["pose"]["p"].get<std::vector<double>>();
    const std::vector<double> from = joints();
    const Vec3 began = cell->cell().tcp(0).position, way = Vec3{end[0], end[1], end[2]} - began;
    place.erase("dry");
    const Json begun = ask(*peer, place);
    ASSERT_EQ(code(begun), "ok") << begun;
    off_joints = off_line = 0;
    for (int i = 0; i < 1000 && !is_over(*peer, begun["result"]["jog"]); ++i) {
      if (i % 5 == 0) beat(*peer, begun["result"]["jog"]);
      run(0.01);
      const Vec3 gone = cell->cell().tcp(0).position - began;
      off_line = std::max(off_line, norm(cross(gone, way)) / norm(way));
      const std::vector<double> now = joints();
      double length = 0, along = 0, off = 0;
      for (std::size_t j = 0; j < 6; ++j) length += (to[j] - from[j]) * (to[j] - from[j]);
      for (std::size_t j = 0; j < 6; ++j) along += (now[j] - from[j]) * (to[j] - from[j]) / length;
      for (std::size_t j = 0; j < 6; ++j)
        off = std::max(off, std::abs(now[j] - from[j] - along * (to[j] - from[j])));
      off_joints = std::max(off_joints, off);
    }
    EXPECT_TRUE(
        heard(*peer, "jog", [](const Json& e) { return e["over"] == true && e["why"] == "arrived"; }));
    EXPECT_LT(norm(cell->cell().tcp(0).position - began - way), 2e-4);
  };
  double off_joints = 0, off_line = 0;
  go({{"joints", {{"joint_1", 0.4}, {"joint_2", 0.7}, {"joint_3", 0.5}, {"joint_5", 0.6}}}}, "joint",
     off_joints, off_line);
  EXPECT_LT(off_joints, 1e-3) << "the way that was shown";
  const Pose here = cell->cell().tcp(0);
  const Json near{{"pose",
                   {{"p", {here.position.x - 0.05, here.position.y + 0.1, here.position.z - 0.1}},
                    {"q", {here.rotation.x, here.rotation.y, here.rotation.z, here.rotation.w}}}}};
  go(near, "line", off_joints, off_line);
  EXPECT_LT(off_line, 2e-4);
  EXPECT_GT(off_joints, 0.005);
  go({{"pose", {{"p", {here.position.x, here.position.y, here.position.z}}, {"q", near["pose"]["q"]}}}},
     "joint", off_joints, off_line);
  EXPECT_GT(off_line, 0.002) << "by the joints it is not a line";
  EXPECT_LT(off_joints, 5e-3);

  const Json far{
      {"request", "jog.goto"}, {"kind", "line"}, {"pose", {{"p", {5, 0, 0}}, {"q", {0, 0, 0, 1}}}}};
  const Json refused = ask(*peer, far);
  EXPECT_FALSE(refused["ok"].get<bool>());
  EXPECT_NE(refused["error"]["what"].get<std::string>().find("the path meets a singularity"),
            std::string::npos)
      << refused;

  run(0.3);
  EXPECT_TRUE(standing());
}

TEST_F(PendantTest, EventsSayWhatChangesAndToWhoComesLateAllThereIs) {
  const auto peer = connect();
  ask(*peer, {{"request", "session.hello"}});
  EXPECT_TRUE(heard(*peer, "status", [](const Json& e) { return e["state"] == "running"; }));
  cell->cell().loop().supervisor().latch().request(realtime::StopKind::controlled);
  run(0.1);
  EXPECT_TRUE(heard(*peer, "status", [](const Json& e) { return e["state"] == "held" && e["held"] != ""; }));
  pendant->observer().on_problem(1'000'000'000, {"fault", {"a.script", 3, 1}, "it broke", "mend it"});
  EXPECT_TRUE(heard(*peer, "alarm", [](const Json& e) {
    return e["what"] == "it broke" && e["advice"] == "mend it" && e["where"]["line"] == 3;
  }));
  const auto late = connect();
  ask(*late, {{"request", "session.hello"}});
  EXPECT_TRUE(heard(*late, "alarm"));
  EXPECT_TRUE(
      heard(*late, "log", [](const Json& e) { return e.dump().find("it broke") != std::string::npos; }));
}

/// Whatever it says itself: the name is the one that the others see.
TEST_F(PendantTest, WhoChangesATagIsToldByName) {
  data::DataSet work;
  work.set("Go", false);
  cell->cell().store().load("work", work, "test");
  const auto tablet = connect();
  ask(*tablet, {{"request", "session.hello"}, {"name", "Tablet 4"}});
  ask(*tablet, {{"request", "session.take"}});
  EXPECT_EQ(code(ask(*tablet, {{"request", "tags.set"}, {"name", "Go"}, {"value", true}, {"by", "nobody"}})),
            "ok");
  EXPECT_EQ(cell->cell().store().facts("Go")->changed_by, "Tablet 4");
}

TEST_F(PendantTest, BetweenTwoCellsRequestsAreRefusedAndTheNextOneIsServed) {
  const auto peer = connect();
  ask(*peer, {{"request", "session.hello"}});
  ask(*peer, {{"request", "session.watch"}, {"rate", 30}});
  ASSERT_TRUE(heard(*peer, "layout"));
  const int first = peer->event("layout")["id"];
  pendant->detach();
  EXPECT_EQ(code(ask(*peer, {{"request", "health"}})), "no-cell");
  EXPECT_TRUE(heard(*peer, "status", [](const Json& e) { return e["cell"].is_null(); }));
  EXPECT_EQ(WebPeer::status(fetch("/api/cell")), 503);
  cell = std::make_unique<LockStepCell>(cell::read_cell_file(folder.path()));
  pendant->attach(cell->cell().view());
  EXPECT_TRUE(heard(*peer, "layout", [&](const Json& e) { return e["id"] != first; }));
  EXPECT_EQ(code(ask(*peer, {{"request", "health"}})), "ok");
}

TEST_F(PendantTest, NoiseOnTheSocketIsAnsweredAndChangesNothing) {
  std::vector<std::string> names = {"jog.begin",       "jog.step",       "jog.end",       "jog.beat",
                                    "session.take",    "session.answer", "session.watch", "session.hello",
                                    "session.release", "help",           "control.list"};
  const Json values[] = {Json(),
                         0,
                         -1,
                         1e300,
                         "x",
                         Json::array(),
                         Json::object(),
                         true,
                         Json::array({1, 2, 3, 4, 5, 6}),
                         "base",
                         std::string(1000, 'a'),
                         Json::array({Json::array()}),
                         18446744073709551615ull};
  const char* keys[] = {"id",     "robot", "mode", "axis", "frame", "direction", "speed",
                        "amount", "jog",   "rate", "give", "force", "name"};
  std::mt19937 random(3);
  const auto peer = connect();
  for (int n = 0; n < 2000; ++n) {
    Json request{{"request", names[random() % names.size()]}};
    for (unsigned i = random() % 6; i > 0; --i)
      request[keys[random() % std::size(keys)]] = values[random() % std::size(values)];
    peer->send(request);
    if (n % 50 == 0) {
      tick();
      peer->listen();
      peer->take();
      std::this_thread::sleep_for(std::chrono::milliseconds(60));  // so many a second are taken from one
    }
  }
  EXPECT_EQ(code(ask(*peer, {{"request", "health"}})), "ok");
}

/// One ring, one look, and no tick: a request does not wait for the time.
TEST_F(PendantTest, ARequestRingsTheBellAndIsTakenWithoutATick) {
  const auto bell = std::make_shared<realtime::Bell>();
  pendant->set_wakeup(bell);
  const auto peer = connect();
  const Nanoseconds time = cell->cell().now();
  for (int i = 1; i <= 20; ++i) {
    const std::uint64_t before = pendant->counts().requests;
    peer->send({{"request", "health"}, {"id", i}});
    ASSERT_TRUE(bell->wait_until(realtime::monotonic_now() + 60'000'000'000)) << "nobody rang";
    pendant->take();
    EXPECT_EQ(pendant->counts().requests, before + 1);
  }
  EXPECT_EQ(cell->cell().now(), time);
  EXPECT_TRUE(served_until([&] {
    peer->listen();
    peer->take();
    return !peer->answer(20).is_null();
  }));
  pendant->set_wakeup(nullptr);
}

}  // namespace
}  // namespace polyarm::server
