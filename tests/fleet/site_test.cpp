/// A site of cells that run in this process: their states, silent cells, and programs for several.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <atomic>
#include <iterator>
#include <memory>
#include <random>
#include <thread>

#include "polyarm/access/tls.hpp"
#include "polyarm/access/token.hpp"
#include "polyarm/fleet/cell_client.hpp"
#include "polyarm/fleet/deployment.hpp"
#include "polyarm/fleet/site_page.hpp"
#include "polyarm/fleet/site_watch.hpp"
#include "polyarm/server/pendant.hpp"
#include "polyarm/setup/cell_file.hpp"
#include "tests/support/damaged.hpp"
#include "tests/support/lock_step_cell.hpp"
#include "tests/support/web_peer.hpp"

namespace polyarm::fleet {
namespace {

using Json = nlohmann::json;

/// A cell with its port, served by a thread until the end.
class ServedCell {
 public:
  explicit ServedCell(const std::string& program = "while 1 == 1\n  wait 1s\nend\n", bool tls = false) {
    const std::string arm = std::string(POLYARM_SOURCE_DIR) + "/examples/r6bot/r6bot.urdf";
    folder.write("cell.yaml", "polyarm: cell/1\nrobots:\n  arm: {model: " + arm + ", hardware: mock}\n");
    folder.write("work.script", program);
    server::PendantOptions options;
    options.port = 0;
    options.token = "secret";
    options.version = "7";
    if (tls) {
      const server::Certificate made = server::kept_certificate(home_.path(), "press");
      options.certificate = made.chain;
      options.key = made.key;
      std::copy_if(made.fingerprint.begin(), made.fingerprint.end(), std::back_inserter(fingerprint_),
                   [](char c) { return c != ':'; });
    }
    pendant = std::make_unique<server::Pendant>(options, nobody);
    port = pendant->port();
    thread_ = std::thread([this] {
      test::LockStepCell cell(cell::read_cell_file(folder.path()));
      pendant->attach(cell.cell().view());
      while (!over_) {
        pendant->serve();
        if (!frozen) cell.tick();
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
      pendant->detach();
    });
  }
  ~ServedCell() {
    over_ = true;
    thread_.join();
  }
  SiteCell entry(const std::string& name) const {
    SiteCell out;
    out.name = name;
    out.host = "127.0.0.1";
    out.port = port;
    out.token = "secret";
    out.ideal_cycle_s = 1;
    out.tls = !fingerprint_.empty();
    out.fingerprint = fingerprint_;
    return out;
  }
  std::string text(const std::string& file = "work.script") const { return read_file(folder.path() / file); }

  struct Nobody : cell::Observer {};
  Nobody nobody;
  test::Folder folder;
  std::unique_ptr<server::Pendant> pendant;
  std::uint16_t port = 0;
  std::atomic<bool> frozen{false};

 private:
  test::Folder home_;
  std::string fingerprint_;
  std::atomic<bool> over_{false};
  std::thread thread_;
};

/// A port where nobody listens.
SiteCell silent_cell() {
  SiteCell out;
  out.name = "silent";
  out.host = "127.0.0.1";
  out.port = 1;
  out.token = "secret";
  return out;
}

std::vector<CellReport> look(const Site& site) {
  const SiteWatch watch(site, 0, 20);
  watch.wait_for_first();
  return watch.reports();
}

TEST(SiteStatus, ShowsWhatEachCellDoesAndNamesTheSilentOne) {
  const ServedCell press, oven;
  const auto reports = look({"hall", {press.entry("press"), silent_cell(), oven.entry("oven")}});
  ASSERT_EQ(reports.size(), 3u);
  EXPECT_TRUE(reports[0].answers) << reports[0].trouble;
  EXPECT_EQ(reports[0].summary["state"], "running");
  EXPECT_EQ(reports[0].summary["version"], "7");
  EXPECT_FALSE(reports[1].answers);
  EXPECT_NE(reports[1].trouble.find("cannot be reached"), std::string::npos) << reports[1].trouble;
  EXPECT_TRUE(reports[2].answers);
  const std::string table = table_of(reports);
  EXPECT_NE(table.find("2 of 3 cells answer"), std::string::npos) << table;
}

TEST(SiteOverTls, ACellIsKnownByItsCertificateAndAnotherOneGetsNothing) {
  const std::string work = "while 1 == 1\n  wait 1s\nend\n", changed = "wait 2s\n";
  const ServedCell press(work, true);
  EXPECT_TRUE(look({"hall", {press.entry("press")}})[0].answers);
  SiteCell wrong = press.entry("press");
  wrong.fingerprint[0] = wrong.fingerprint[0] == '0' ? '1' : '0';
  const auto reports = look({"hall", {wrong}});
  EXPECT_FALSE(reports[0].answers);
  EXPECT_NE(reports[0].trouble.find("has another certificate"), std::string::npos) << reports[0].trouble;
  EXPECT_NE(reports[0].trouble.find(":" + wrong.fingerprint.substr(2, 2) + ":"), std::string::npos)
      << "as the cell prints it: " << reports[0].trouble;
  auto planned = plan({wrong}, "work.script", changed, 20);
  EXPECT_EQ(planned[0].state, Deployed::State::refused);
  write({wrong}, planned, "work.script", changed, true, 20);
  EXPECT_EQ(press.text(), work);
  planned = plan({press.entry("press")}, "work.script", changed, 20);
  write({press.entry("press")}, planned, "work.script", changed, false, 20);
  EXPECT_EQ(planned[0].state, Deployed::State::written) << planned[0].why;
  EXPECT_EQ(press.text(), changed);
}

TEST(SiteStatus, AWrongTokenIsARefusalInWords) {
  const ServedCell press;
  SiteCell wrong = press.entry("press");
  wrong.token = "guess";
  const auto reports = look({"hall", {wrong}});
  EXPECT_FALSE(reports[0].answers);
  EXPECT_NE(reports[0].trouble.find("403"), std::string::npos) << reports[0].trouble;
}

TEST(SiteStatus, ACellThatGoesAndComesBackIsSeenWithItsLastValuesMeanwhile) {
  auto press = std::make_unique<ServedCell>();
  const Site site{"hall", {press->entry("press")}};
  const SiteWatch watch(site, 0.02, 20);
  const auto becomes = [&](bool answers) {
    for (int n = 0; n < 20'000; ++n) {
      const auto reports = watch.reports();
      if (reports[0].asked && reports[0].answers == answers) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return false;
  };
  ASSERT_TRUE(becomes(true));
  press.reset();
  ASSERT_TRUE(becomes(false));
  EXPECT_TRUE(watch.reports()[0].summary.is_object()) << "the last values are kept";
  EXPECT_GT(watch.reports()[0].age_s, 0);
}

TEST(AnswersOfStrangers, AreReadWithoutWhatIsNestedTooDeep) {
  const Json answer = parse_answer("{\"state\":\"running\",\"x\":" + std::string(1'000'000, '[') +
                                   std::string(1'000'000, ']') + "}");
  EXPECT_EQ(answer["state"], "running");
  EXPECT_LT(Json(answer).dump().size(), 200u);
  EXPECT_FALSE(parse_answer("{\"state\":").is_object());
}

TEST(SitePageOfCells, ShowsAllCellsToThisMachineOnly) {
  const ServedCell press;
  const Site site{"hall <1>", {press.entry("press"), silent_cell()}};
  const SiteWatch watch(site, 0, 20);
  watch.wait_for_first();
  const SitePage page(watch, site.name, 0);
  using test::WebPeer;
  EXPECT_EQ(WebPeer::status(WebPeer::fetch(page.port(), "/")), 200);
  const std::string answer = WebPeer::fetch(page.port(), "/api/site");
  const Json json = Json::parse(answer.substr(answer.find("\r\n\r\n") + 4));
  EXPECT_EQ(json["name"], "hall <1>");
  EXPECT_EQ(json["cells"][0]["answers"], true);
  EXPECT_EQ(json["cells"][1]["answers"], false);
  EXPECT_EQ(answer.find("secret"), std::string::npos) << "no token is shown";
  const std::string script = WebPeer::fetch(page.port(), "/site.js");
  EXPECT_EQ(WebPeer::status(script), 200);
  EXPECT_EQ(script.find("innerHTML"), std::string::npos) << "words of cells stay text";
  EXPECT_EQ(WebPeer::status(WebPeer::fetch(page.port(), "/", {"Host: evil.example"})), 421);
  EXPECT_NE(WebPeer::status(WebPeer::fetch(page.port(), "/", {}, "POST")), 200);
}

TEST(Deployment, WritesToEachCellAfterAllChecksAndStartsNothing) {
  const ServedCell press, oven;
  const std::vector<SiteCell> cells = {press.entry("press"), oven.entry("oven")};
  const std::string text = "wait 2s\n";
  auto planned = plan(cells, "work.script", text, 20);
  for (const Deployed& each : planned) {
    EXPECT_EQ(each.state, Deployed::State::ready) << each.why;
    EXPECT_NE(std::find(each.diff.begin(), each.diff.end(), "+wait 2s"), each.diff.end());
  }
  EXPECT_NE(press.text(), text) << "a plan writes nothing";
  write(cells, planned, "work.script", text, false, 20);
  for (const Deployed& each : planned) EXPECT_EQ(each.state, Deployed::State::written) << each.why;
  EXPECT_EQ(press.text(), text);
  EXPECT_EQ(oven.text(), text);
  EXPECT_EQ(plan(cells, "work.script", text, 20)[0].state, Deployed::State::same);
  auto fresh = plan(cells, "other.script", text, 20);
  ASSERT_EQ(fresh[0].state, Deployed::State::ready) << fresh[0].why;
  write(cells, fresh, "other.script", text, false, 20);
  EXPECT_EQ(press.text("other.script"), text);
}

TEST(Deployment, AProgramWithErrorsASilentCellAndAWatchersTokenAreNamed) {
  const ServedCell press;
  SiteCell watcher = press.entry("watcher");
  watcher.token = server::token_for("secret", protocol::Role::watch);
  const std::vector<SiteCell> cells = {press.entry("press"), silent_cell(), watcher};
  auto faulty = plan(cells, "work.script", "this is no program (\n", 20);
  EXPECT_EQ(faulty[0].state, Deployed::State::faulty);
  EXPECT_FALSE(faulty[0].problems.empty());
  EXPECT_EQ(faulty[1].state, Deployed::State::refused);
  const std::string before = press.text();
  write(cells, faulty, "work.script", "this is no program (\n", false, 20);
  EXPECT_EQ(press.text(), before) << "nothing is written where the check fails";
  auto good = plan(cells, "work.script", "wait 3s\n", 20);
  EXPECT_EQ(good[2].state, Deployed::State::ready);
  good[0].state = Deployed::State::same;  // only the watcher writes
  write(cells, good, "work.script", "wait 3s\n", false, 20);
  EXPECT_EQ(good[2].state, Deployed::State::refused);
  EXPECT_NE(good[2].why.find("no-role"), std::string::npos) << good[2].why;
  EXPECT_EQ(press.text(), before);
}

TEST(Deployment, AFileThatChangedMeanwhileIsNotOverwritten) {
  const ServedCell press;
  const std::vector<SiteCell> cells = {press.entry("press")};
  auto planned = plan(cells, "work.script", "wait 2s\n", 20);
  press.folder.write("work.script", "wait 9s\n");
  write(cells, planned, "work.script", "wait 2s\n", false, 20);
  EXPECT_EQ(planned[0].state, Deployed::State::refused);
  EXPECT_NE(planned[0].why.find("changed-meanwhile"), std::string::npos) << planned[0].why;
  EXPECT_EQ(press.text(), "wait 9s\n");
}

TEST(Difference, ShowsWhatGoesAndWhatComes) {
  EXPECT_TRUE(difference("a\nb\n", "a\nb\n").empty());
  EXPECT_EQ(difference("a\nb\nc\n", "a\nx\nc\n"), (std::vector<std::string>{"-b", "+x"}));
  EXPECT_EQ(difference("", "a\n"), (std::vector<std::string>{"+a"}));
  EXPECT_EQ(difference("a\nb\n", ""), (std::vector<std::string>{"-a", "-b"}));
  EXPECT_EQ(difference(std::string(3000, '\n'), "x\n", 5).size(), 6u);
}

TEST(OeeFigures, AreSharesOfTimePassesAndParts) {
  const Json summary{{"working_s", 60},
                     {"no_cell_s", 10},
                     {"state_s", {{"running", 80}, {"held", 10}}},
                     {"passes", 5},
                     {"parts", {{"good", 9}, {"bad", 1}}}};
  const Oee oee = oee_of(summary, 10);
  EXPECT_NEAR(*oee.availability, 0.6, 1e-12);
  EXPECT_NEAR(*oee.performance, 50.0 / 60, 1e-12);
  EXPECT_NEAR(*oee.quality, 0.9, 1e-12);
  EXPECT_NEAR(*oee.whole, 0.6 * 50 / 60 * 0.9, 1e-12);
  EXPECT_FALSE(oee_of(summary, 0).performance) << "performance needs an ideal cycle";
  EXPECT_FALSE(oee_of(Json(), 1).availability);
  EXPECT_FALSE(
      oee_of(Json{{"working_s", "many"}, {"state_s", 3}, {"parts", Json::array()}, {"passes", -1}}, 1).whole);
}

class SiteFile : public ::testing::Test {
 protected:
  SiteFile() {
    folder.write("token", "http://localhost:8765/?token=abc_DEF-123\n");
    ::chmod((folder.path() / "token").c_str(), 0600);
  }
  std::string code(const std::string& cell) {
    try {
      read_site_file(folder.write("site.yaml", "polyarm: site/1\ncells:\n  a: " + cell + "\n"));
    } catch (const Error& e) {
      return e.problems().front().code;
    }
    return "none";
  }
  test::Folder folder;
};

TEST_F(SiteFile, NamesCellsTheirAddressesAndTokens) {
  const Site site =
      read_site_file(folder.write("site.yaml",
                                  "polyarm: site/1\nname: hall\ncells:\n  a: {address: "
                                  "'http://localhost:8765', token_file: token, ideal_cycle: 12s}\n"
                                  "  b: {address: 'https://[fe80::1]', token_file: token, fingerprint: '" +
                                      std::string(64, 'a') + "'}\n"));
  ASSERT_EQ(site.cells.size(), 2u);
  EXPECT_EQ(site.cells[0].token, "abc_DEF-123");
  EXPECT_EQ(site.cells[0].ideal_cycle_s, 12);
  EXPECT_EQ(site.cells[1].host, "fe80::1");
  EXPECT_EQ(site.cells[1].port, 8765);
  EXPECT_TRUE(site.cells[1].tls);
  EXPECT_EQ(site.cells[1].fingerprint, std::string(64, 'A'));
}

TEST_F(SiteFile, WhatWouldShowATokenOrIsWrongIsRefused) {
  EXPECT_EQ(code("{address: 'http://10.0.0.5', token_file: token}"), "bad-site") << "in clear";
  EXPECT_EQ(code("{address: 'http://127.example.org', token_file: token}"), "bad-site")
      << "no address of this machine";
  EXPECT_EQ(code("{address: 'https://10.0.0.5', token_file: token}"), "bad-site") << "no fingerprint";
  EXPECT_EQ(code("{address: 'ftp://x', token_file: token}"), "bad-site");
  EXPECT_EQ(code("{address: 'http://localhost:99999', token_file: token}"), "bad-site");
  EXPECT_EQ(code("{address: 'http://localhost', token_file: missing}"), "bad-token");
  EXPECT_NE(code("{address: 'http://localhost'}"), "none");
  EXPECT_EQ(code("{address: 'http://localhost:1', token_file: token}\n"
                 "  a: {address: 'http://localhost:2', token_file: token}"),
            "duplicate-name");
  ::chmod((folder.path() / "token").c_str(), 0644);
  EXPECT_EQ(code("{address: 'http://localhost', token_file: token}"), "bad-token") << "others may read it";
}

TEST_F(SiteFile, AnyTextIsReadOrRefused) {
  const std::string good =
      "polyarm: site/1\nname: hall\ncells:\n  a: {address: 'http://localhost:8765', token_file: token, "
      "ideal_cycle: 12s}\n";
  std::mt19937 random(3);
  for (int n = 0; n < 3000; ++n) {
    try {
      read_site_file(folder.write(
          "site.yaml", test::damaged(good, {"{", "[", ": ", "'", "https://", "\n  b: "}, 15, random)));
    } catch (const Error&) {
    }
  }
}

}  // namespace
}  // namespace polyarm::fleet
