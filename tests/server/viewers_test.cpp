/// Tools of others on the pendant's port: who is let in, what they are told, and meshes for the page.
#include "polyarm/server/viewers.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "polyarm/access/gate.hpp"
#include "polyarm/base/bounds.hpp"
#include "polyarm/server/pendant.hpp"
#include "polyarm/server/stream.hpp"
#include "tests/support/lock_step_cell.hpp"
#include "tests/support/node_peers.hpp"
#include "tests/support/web_peer.hpp"

namespace polyarm::server {
namespace {

using test::Json;
using test::WebPeer;

GateRules rules() {
  GateRules out;
  out.token = "the-token";
  out.cookie = "polyarm_token_1";
  return out;
}

Head viewer_head(const std::string& origin, const std::string& target, const std::string& cookie = "") {
  Head out;
  out.method = "GET";
  out.target = target;
  out.host = "localhost:1";
  out.origin = origin;
  out.cookie = cookie;
  return out;
}

TEST(ViewerGate, APageOfAnotherToolMayWatchWhereItShowsTheTokenItself) {
  const std::string cookie = "polyarm_token_1=the-token";
  EXPECT_EQ(judge_viewer(viewer_head("https://app.foxglove.dev", "/?token=the-token"), rules()).status, 200);
  EXPECT_EQ(judge_viewer(viewer_head("", "/?token=the-token"), rules()).status, 200);
  EXPECT_EQ(judge_viewer(viewer_head("https://app.foxglove.dev", "/?token=wrong"), rules()).status, 403);
  EXPECT_EQ(judge_viewer(viewer_head("https://app.foxglove.dev", "/", cookie), rules()).status, 403)
      << "a cookie is sent by the browser, whoever asks for it";
  EXPECT_EQ(judge_viewer(viewer_head("", "/"), rules()).status, 401);
  Head elsewhere = viewer_head("", "/?token=the-token");
  elsewhere.host = "evil.example";
  EXPECT_EQ(judge_viewer(elsewhere, rules()).status, 421);
}

class ViewersTest : public ::testing::Test {
 protected:
  ViewersTest() {
    folder.write("base.stl",
                 "solid base\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
                 "endloop\nendfacet\nendsolid\n");
    folder.write("robot.urdf", R"(<robot name="r"><link name="base_link"><visual><geometry>
<mesh filename="base.stl"/></geometry></visual></link>
<link name="arm_link"><visual><geometry><box size="1 1 1"/></geometry></visual></link>
<joint name="joint_1" type="revolute"><parent link="base_link"/><child link="arm_link"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" velocity="1" effort="1"/></joint></robot>)");
    folder.write("cell.yaml", "polyarm: cell/1\nrobots:\n  arm: {model: robot.urdf, hardware: mock}\n");
    cell = std::make_unique<test::LockStepCell>(cell::read_cell_file(folder.path()));
    PendantOptions options;
    options.port = 0;
    options.token = "secret";
    pendant = std::make_unique<Pendant>(options, nobody);
    pendant->attach(cell->cell().view());
    cell->run(0.05);
  }
  ~ViewersTest() override { pendant->detach(); }

  template <typename Done>
  bool until(Done done) {
    for (int n = 0; n < 20'000 && !done(); ++n) {
      pendant->serve();
      cell->tick();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return done();
  }

  cell::Observer nobody;
  test::Folder folder;
  std::unique_ptr<test::LockStepCell> cell;
  std::unique_ptr<Pendant> pendant;
};

/// Their messages are parsed on the thread that reads everybody's stops.
TEST(ViewerBounds, LongMessagesAndManyBytesEndTheConnection) {
  Viewers viewers("1.0");
  const std::string small = R"({"op":"getParameters","parameterNames":[]})";
  const auto one = viewers.welcome();
  EXPECT_EQ(one->take(small, false, 1), nullptr);
  EXPECT_STREQ(one->take(std::string(bounds::kViewerRequestBytes + 1, ' '), false, 1), "the message is too long");
  const auto other = viewers.welcome();
  const std::string large(bounds::kViewerRequestBytes, ' ');
  std::size_t taken = 0;
  while (taken < 1000 && other->take(large, false, 1) == nullptr) ++taken;
  EXPECT_EQ(taken, bounds::kViewerBurstBytes / bounds::kViewerRequestBytes);
  const auto steady = viewers.welcome();
  for (int i = 0; i < 200; ++i)
    ASSERT_EQ(steady->take(large, false, 1 + i * static_cast<double>(bounds::kViewerRequestBytes) /
                                                 bounds::kViewerBytesASecond),
              nullptr);
}

TEST_F(ViewersTest, AreToldWhatTheCellSays) {
  WebPeer peer(pendant->port());
  ASSERT_EQ(peer.upgrade({"Origin: https://app.foxglove.dev", "Sec-WebSocket-Protocol: foxglove.sdk.v1"},
                         "/?token=secret"),
            101);
  EXPECT_TRUE(until([&] {
    peer.listen();
    return peer.heard.find("serverInfo") != std::string::npos &&
           peer.heard.find("/joint_states") != std::string::npos;
  }));
  peer.say(WebPeer::frame(R"({"op":"subscribe","subscriptions":[{"id":7,"channelId":1}]})"));
  const std::string message("\x01\x07\0\0\0", 5);  // its opcode and the subscription
  EXPECT_TRUE(until([&] {
    peer.listen();
    return peer.heard.find(message) != std::string::npos;
  }));
}

TEST_F(ViewersTest, AClientOfOthersReadsWhatItIsTold) {
  std::string why;
  const std::filesystem::path folder_of_peers = test::peers(why);
  if (folder_of_peers.empty()) GTEST_SKIP() << why;
  for (const std::string protocol : {"foxglove.sdk.v1", "foxglove.websocket.v1"}) {
    Json said;
    std::atomic<bool> over{false};
    std::thread client([&] {
      said = test::node(folder_of_peers, "watch.mjs 'ws://127.0.0.1:" + std::to_string(pendant->port()) +
                                             "/?token=secret' " + protocol + " https://app.foxglove.dev");
      over = true;
    });
    while (!over) {
      pendant->serve();
      cell->tick();
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    client.join();
    EXPECT_EQ(said["subprotocol"], protocol);
    EXPECT_GE(said["messages"]["/joint_states"]["count"], 50);
    EXPECT_EQ(said["messages"]["/joint_states"]["position"].size(), 1u);
    EXPECT_EQ(said["messages"]["/tf_static"]["count"], 1);
    EXPECT_GT(said["parameters"]["robot_description"], 100);
  }
}

TEST_F(ViewersTest, ComeInWithTheTokenAlone) {
  const std::vector<std::string> headers = {"Sec-WebSocket-Protocol: foxglove.sdk.v1"};
  EXPECT_EQ(WebPeer(pendant->port()).upgrade(headers, "/"), 401);
  EXPECT_EQ(WebPeer(pendant->port()).upgrade(headers, "/?token=other"), 403);
  EXPECT_EQ(WebPeer(pendant->port()).upgrade({"Sec-WebSocket-Protocol: other"}, "/?token=secret"), 404);
}

TEST_F(ViewersTest, APageIsGivenTheMeshesOfItsRobots) {
  const std::vector<std::string> bearer = {"Authorization: Bearer secret"};
  const std::string model = WebPeer::fetch(pendant->port(), "/api/model/arm", bearer);
  const Json links = Json::parse(model.substr(model.find("\r\n\r\n") + 4))["links"];
  const Json visual = links[0]["visuals"][0];
  EXPECT_EQ(visual["shape"], "mesh");
  EXPECT_EQ(visual["node"], "base_link");
  EXPECT_EQ(links[1]["visuals"][0]["shape"], "box");
  const std::string glb = WebPeer::fetch(pendant->port(), visual["mesh"].get<std::string>(), bearer);
  EXPECT_EQ(WebPeer::status(glb), 200);
  EXPECT_NE(glb.find("model/gltf-binary"), std::string::npos);
  EXPECT_EQ(glb.substr(glb.find("\r\n\r\n") + 4, 4), "glTF");
  EXPECT_EQ(WebPeer::status(WebPeer::fetch(pendant->port(), "/api/mesh/0000.glb", bearer)), 404);
  EXPECT_EQ(WebPeer::status(WebPeer::fetch(pendant->port(), visual["mesh"].get<std::string>())), 401);
}

}  // namespace
}  // namespace polyarm::server
