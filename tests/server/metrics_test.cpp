/// What Prometheus and the page of a site read from a cell.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <regex>
#include <set>
#include <sstream>
#include <thread>

#include "polyarm/server/metrics_text.hpp"
#include "polyarm/server/pendant.hpp"
#include "polyarm/setup/cell_file.hpp"
#include "tests/support/lock_step_cell.hpp"
#include "tests/support/web_peer.hpp"

namespace polyarm::server {
namespace {

using test::Json;
using test::LockStepCell;
using test::WebPeer;

TEST(MetricsText, EscapesLabelsAndWritesNumbersAsPrometheusReadsThem) {
  MetricsText out;
  out.family("a_total", "counter", "help");
  out.sample(2, {{"x", "a\"b\\c\nd"}, {"y", "z"}});
  out.sample(std::numeric_limits<double>::quiet_NaN());
  out.sample(std::numeric_limits<double>::infinity());
  EXPECT_EQ(out.text().find("# HELP a_total help\n# TYPE a_total counter\na_total{x=\"a\\\"b\\\\c"), 0u)
      << out.text();
  EXPECT_NE(out.text().find("\",y=\"z\"} 2\na_total NaN\na_total +Inf\n"), std::string::npos) << out.text();
}

class MetricsOfACell : public ::testing::Test {
 protected:
  void begin(std::optional<PendantOptions::Metrics> metrics) {
    const std::string arm = std::string(POLYARM_SOURCE_DIR) + "/examples/r6bot/r6bot.urdf";
    folder.write("cell.yaml", "polyarm: cell/1\nrobots:\n  arm: {model: " + arm + ", hardware: mock}\n");
    lock_step = std::make_unique<LockStepCell>(cell::read_cell_file(folder.path()));
    PendantOptions options;
    options.port = 0;
    options.token = "secret";
    options.version = "7";
    options.metrics = std::move(metrics);
    pendant = std::make_unique<Pendant>(options, nobody);
    pendant->attach(lock_step->cell().view());
    lock_step->run(0.05);
  }
  void TearDown() override {
    if (pendant) pendant->detach();
  }
  std::string fetch(std::uint16_t port, const std::string& target,
                    const std::vector<std::string>& headers = {}) {
    std::string answer;
    std::atomic<bool> done{false};
    std::thread peer([&] {
      answer = WebPeer::fetch(port, target, headers);
      done = true;
    });
    while (!done) {
      pendant->serve();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    peer.join();
    return answer;
  }
  static std::string body(const std::string& answer) { return answer.substr(answer.find("\r\n\r\n") + 4); }

  struct Nobody : cell::Observer {};
  Nobody nobody;
  test::Folder folder;
  std::unique_ptr<LockStepCell> lock_step;
  std::unique_ptr<Pendant> pendant;
};

TEST_F(MetricsOfACell, AreNotServedUnlessAsked) {
  begin(std::nullopt);
  EXPECT_EQ(pendant->metrics_port(), 0);
  EXPECT_EQ(WebPeer::status(fetch(pendant->port(), "/metrics")), 404);
}

TEST_F(MetricsOfACell, HaveTheFormatAndTheNamesOfThePage) {
  begin(PendantOptions::Metrics{"127.0.0.1", 0});
  const std::string answer = fetch(pendant->metrics_port(), "/metrics");
  ASSERT_EQ(WebPeer::status(answer), 200);
  EXPECT_NE(answer.find("Content-Type: text/plain; version=0.0.4"), std::string::npos);
  const std::string page = read_file(std::string(POLYARM_SOURCE_DIR) + "/docs/metrics.md");
  const std::regex sample(R"(([a-z_]+)(\{([a-z]+="([^"\\]|\\.)*",?)+\})? (NaN|[+-]Inf|[-+0-9.e]+))");
  std::map<std::string, std::string> types;
  std::set<std::string> seen;
  std::istringstream lines(body(answer));
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string hash, what, name, type;
    if (line.starts_with("# TYPE ")) {
      words >> hash >> what >> name >> type;
      EXPECT_TRUE(types.emplace(name, type).second) << "twice: " << name;
      EXPECT_EQ(type == "counter", name.ends_with("_total")) << name;
      EXPECT_NE(page.find("`" + name + "`"), std::string::npos) << name << " is not in docs/metrics.md";
    } else if (!line.starts_with("# HELP ")) {
      std::smatch parts;
      ASSERT_TRUE(std::regex_match(line, parts, sample)) << line;
      EXPECT_TRUE(types.contains(parts[1])) << line;
      EXPECT_TRUE(seen.insert(line.substr(0, line.rfind(' '))).second) << "twice: " << line;
    }
  }
  EXPECT_GT(types.size(), 25u);
  EXPECT_NE(answer.find("polyarm_up 1\n"), std::string::npos);
  EXPECT_NE(answer.find("polyarm_state{state=\"running\"} 1\n"), std::string::npos);
}

TEST_F(MetricsOfACell, NothingElseIsServedThere) {
  begin(PendantOptions::Metrics{"127.0.0.1", 0});
  const std::uint16_t port = pendant->metrics_port();
  for (const char* path : {"/", "/api/cell", "/api/summary", "/ws"})
    EXPECT_NE(WebPeer::status(fetch(port, path)), 200) << path;
  EXPECT_EQ(WebPeer::status(fetch(port, "/metrics", {"Host: evil.example"})), 421);
  WebPeer peer(port);
  EXPECT_NE(peer.upgrade({"Authorization: Bearer secret"}), 101);
}

TEST_F(MetricsOfACell, AStopAndAFaultAreCountedAndWithoutACellTheyStay) {
  begin(PendantOptions::Metrics{"127.0.0.1", 0});
  lock_step->cell().view().requests().ask(protocol::ControlStop{},
                                          [](const protocol::Reply&) { return true; });
  lock_step->run(0.2);
  const Json summary =
      Json::parse(body(fetch(pendant->port(), "/api/summary", {"Authorization: Bearer secret"})));
  EXPECT_EQ(summary["state"], "held");
  EXPECT_NE(summary["cause"]["what"], "");
  EXPECT_EQ(summary["robots"][0], "arm");
  EXPECT_EQ(WebPeer::status(fetch(pendant->port(), "/api/summary")), 401);
  pendant->detach();
  const std::string after = fetch(pendant->metrics_port(), "/metrics");
  EXPECT_NE(after.find("polyarm_up 0\n"), std::string::npos);
  EXPECT_NE(after.find("polyarm_state_seconds_total{state=\"held\"}"), std::string::npos);
}

}  // namespace
}  // namespace polyarm::server
