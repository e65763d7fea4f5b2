/// What a cell wants to reach, told before it is opened; and what may be allowed from a distance.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <memory>

#include "polyarm/base/file.hpp"
#include "polyarm/cell/known_cells.hpp"
#include "polyarm/setup/cell_file.hpp"
#include "polyarm/setup/cell_reach.hpp"
#include "polyarm/base/approvals.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm::cell {
namespace {

namespace fs = std::filesystem;
using test::Folder;
using test::Json;
using test::LockStepCell;

constexpr const char* kSignals =
    "polyarm: signals/1\n"
    "links:\n  broker: {mqtt: client, host: 192.0.2.7, beyond_loopback: true, on_loss: go_on, user: me, password_file: 'secret:broker', "
    "tags: {A: {topic: a, direction: in}}}\n";

class ReachOfCells : public ::testing::Test {
 protected:
  ReachOfCells() {
    ::setenv("XDG_CONFIG_HOME", home.path().c_str(), 1);
    ::setenv("XDG_DATA_HOME", home.path().c_str(), 1);
    write_cell("own", "");
    write_cell("theirs", "signals: signals.yaml\n");
    home.write("cells/theirs/signals.yaml", kSignals);
    cell = std::make_unique<LockStepCell>(read_cell_file(folder_of("own")));
    cell->run(0.05);
  }
  ~ReachOfCells() override {
    ::unsetenv("XDG_CONFIG_HOME");
    ::unsetenv("XDG_DATA_HOME");
  }
  fs::path folder_of(const std::string& name) const { return home.path() / "cells" / name; }
  void write_cell(const std::string& name, const std::string& more) {
    fs::create_directories(folder_of(name));
    home.write("cells/" + name + "/cell.yaml",
               "polyarm: cell/1\nrobots:\n  arm: {model: " + test::kSixAxes + ", hardware: mock}\n" + more);
  }
  Json reach(Json more = Json::object()) {
    Json request{{"request", "cell.reach"}, {"folder", folder_of("theirs").string()}};
    request.update(more);
    return cell->ask(request);
  }
  static bool wants(const Json& answer, const std::string& kind, const std::string& what) {
    for (const Json& each : answer["result"]["wants"])
      if (each["kind"] == kind && each["what"] == what) return true;
    return false;
  }
  static std::string code(const Json& answer) {
    return answer.value("ok", false) ? "ok" : answer["error"]["code"].get<std::string>();
  }

  Folder home;
  std::unique_ptr<LockStepCell> cell;
};

TEST_F(ReachOfCells, OneThatIsNotOpenIsToldOf) {
  const Json told = reach();
  ASSERT_EQ(code(told), "ok") << told;
  EXPECT_TRUE(wants(told, "host", "192.0.2.7")) << told;
  EXPECT_TRUE(wants(told, "secret", "broker")) << told;
  EXPECT_TRUE(cell->result({{"request", "cell.reach"}})["wants"].empty()) << "the open one wants nothing";
}

TEST_F(ReachOfCells, HostsAndSecretsAreAllowedForThatCellAlone) {
  ASSERT_EQ(code(reach({{"allow", {"host:192.0.2.7", "secret:broker"}}})), "ok");
  const std::string theirs = fs::canonical(folder_of("theirs")).string();
  EXPECT_TRUE(is_approved({"host", theirs, "192.0.2.7"}));
  EXPECT_TRUE(is_approved({"secret", theirs, "broker"}));
  EXPECT_EQ(approvals().size(), 2u);
  EXPECT_FALSE(is_approved({"host", fs::canonical(folder_of("own")).string(), "192.0.2.7"}));
}

TEST_F(ReachOfCells, NothingElseIsAllowedFromADistance) {
  EXPECT_EQ(code(reach({{"allow", {"file:/tmp/elsewhere/run.mcap"}}})), "not-here");
  EXPECT_EQ(code(reach({{"allow", {"plugin:arm.so"}}})), "not-here");
  EXPECT_EQ(code(reach({{"allow", {"host:192.0.2.8"}}})), "not-wanted");
  EXPECT_TRUE(approvals().empty());
  EXPECT_EQ(code(cell->ask({{"request", "cell.reach"}, {"folder", "/etc"}})), "unknown-cell");
}

/// In a process of its own, since nothing takes confine() back.
TEST_F(ReachOfCells, WhatOneCellMayReachTheNextOneOfThisProcessMayNot) {
  const auto admitted = [](const CellFile& file) {
    signals::Signals read = signals::load_signals((file.folder / file.signals).string());
    Problems problems;
    admit_links(file, read, problems);
    return problems.list().empty() ? "ok" : problems.list().front().code;
  };
  home.write("cells/theirs/signals.yaml",
             "polyarm: signals/1\nlinks:\n  plc: {modbus: client, host: 192.0.2.7, beyond_loopback: true, tags: "
             "{A: {coil: 0, direction: in}}}\n");
  home.write("cells/more/signals.yaml", read_file(folder_of("theirs") / "signals.yaml"));
  write_cell("more", "signals: signals.yaml\n");
  home.write("secret.txt", "x");
  approve({"host", fs::canonical(folder_of("theirs")).string(), "192.0.2.7"});
  approve({"path", fs::canonical(folder_of("theirs")).string(), (home.path() / "secret.txt").string()});
  EXPECT_EXIT(
      {
        polyarm::reach().confine();
        auto theirs = std::make_unique<CellFile>(read_cell_file(folder_of("theirs")));
        if (admitted(*theirs) != "ok") std::exit(1);
        if (!polyarm::reach().allows(home.path() / "secret.txt", home.path() / "secret.txt", Reach::Use::read))
          std::exit(2);
        theirs.reset();
        const CellFile more = read_cell_file(folder_of("more"));
        if (admitted(more) != "host-not-allowed") std::exit(3);
        if (polyarm::reach().allows(home.path() / "secret.txt", home.path() / "secret.txt", Reach::Use::read))
          std::exit(4);
        std::exit(0);
      },
      testing::ExitedWithCode(0), "");
}

TEST_F(ReachOfCells, ADoorBuildsTheCellWithNothingFromElsewhere) {
  home.write("elsewhere/arm.urdf", "<robot name='a'/>");
  home.write("elsewhere/cell.yaml", "polyarm: cell/1\n");
  home.write("elsewhere/job.script", "wait 1s\n");
  const auto asked = [&](const Json& more) {
    Json request{{"request", "cell.restart"}};
    request.update(more);
    return code(cell->ask(request));
  };
  EXPECT_EQ(asked({{"program", "/etc/passwd"}}), "outside-cell");
  EXPECT_EQ(asked({{"program", "../../elsewhere/job.script"}}), "outside-cell");
  EXPECT_EQ(asked({{"cell", (home.path() / "elsewhere").string()}}), "unknown-cell");
  EXPECT_EQ(asked({{"cell", "/etc/passwd"}}), "unknown-cell");
  EXPECT_EQ(asked({{"robot", "arm=" + (home.path() / "elsewhere/arm.urdf").string()}}), "outside-cell");
  fs::create_symlink(home.path() / "elsewhere/job.script", folder_of("own") / "link.script");
  EXPECT_EQ(asked({{"program", "link.script"}}), "outside-cell");
  EXPECT_FALSE(cell->cell().restart());
  home.write("cells/own/job.script", "wait 1s\n");
  EXPECT_EQ(asked({{"cell", folder_of("theirs").string()}}), "ok");
  EXPECT_EQ(asked({{"program", "job.script"}, {"robot", "abb/irb_120"}}), "ok");
}

TEST_F(ReachOfCells, ADryRunReadsNoScriptThatALinkLeadsOutTo) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");  // a fork would lack the thread that an earlier dry run left
  home.write("elsewhere/job.script", "movej SecretPoint\n");
  fs::create_symlink(home.path() / "elsewhere/job.script", folder_of("own") / "other.script");
  home.write("cells/own/job.script", "include \"other.script\"\n");
  cell = nullptr;  // its lock
  EXPECT_EXIT(
      {
        polyarm::reach().confine();
        polyarm::reach().allow_reading(POLYARM_SOURCE_DIR);
        cell = std::make_unique<LockStepCell>(read_cell_file(folder_of("own")));
        const Json told = cell->ask({{"request", "program.dry"}, {"name", "job.script"}});
        std::_Exit(told.dump().find("SecretPoint") == std::string::npos ? 0 : 1);
      },
      testing::ExitedWithCode(0), "");
}

TEST_F(ReachOfCells, AListThatCannotBeWholeSaysSo) {
  EXPECT_TRUE(reach()["result"]["unread"].is_null());
  home.write("cells/theirs/signals.yaml", "polyarm: signals/1\nlinks:\n  broker: {mqtt: client, host: 192.0.2.7}\n");
  EXPECT_NE(reach()["result"]["unread"].get<std::string>().find("signals.yaml:3"), std::string::npos);
}

TEST_F(ReachOfCells, CellsAreListedWhileNoneIsOpen) {
  fs::create_directories(home.path() / "polyarm/cells");
  fs::rename(folder_of("theirs"), home.path() / "polyarm/cells/theirs");
  ASSERT_FALSE(known_cells({}).cells.empty());
  const std::string folder = (home.path() / "polyarm/cells/theirs").string();
  EXPECT_FALSE(reach_of_cell({}, folder, {}).wants.empty());
}

}  // namespace
}  // namespace polyarm::cell
