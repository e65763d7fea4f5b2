#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <optional>

#include "fake_host.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/language/parser.hpp"
#include "polyarm/program/checker.hpp"

namespace polyarm::program {
namespace {

std::filesystem::path thesis(const std::string& folder) {
  return std::string(POLYARM_SOURCE_DIR) + "/tests/program/thesis/" + folder;
}

/// A thesis cell with its dummy PLC: the gripper answers, and `world` does what else happens.
struct Cell {
  explicit Cell(const std::string& folder) {
    host.folder = thesis(folder);
    const data::LoadedFiles loaded = data::load_files("cycledata", host.folder);
    Problems problems;
    Program program = parse(read_file(loaded.script), loaded.script.string(), problems);
    KnownNames known;
    known.folder = host.folder;
    known.add(loaded.data.values());
    for (const auto& points : loaded.points) known.add(points.values());
    check(program, known, problems);
    EXPECT_TRUE(problems.list().empty()) << problems.list().front().text();
    interpreter.emplace(std::move(program), host);
  }

  bool is(const std::string& name) const {
    const data::Value* value = host.store.find(name);
    return value && value->as_boolean() && *value->as_boolean();
  }
  void plc(const std::string& name, bool value) { host.store.set(name, value, "plc"); }

  void gripper() {
    const bool on = is("ActivateGripper"), off = is("DeactivateGripper");
    if (!on && !off) return;
    plc("GripperActive", on);
    plc("GripperInactive", !on);
    plc(on ? "ActivateGripper" : "DeactivateGripper", false);
  }

  StepResult run_all(const std::function<void()>& world = {}) {
    return run(*interpreter, host, nanoseconds(600), [&] {
      if (host.store.find("Repeat")) gripper();
      if (world) world();
    });
  }

  FakeHost host;
  std::optional<Interpreter> interpreter;
};

std::size_t count(const std::vector<std::string>& list, const std::string& what) {
  return static_cast<std::size_t>(std::count(list.begin(), list.end(), what));
}

TEST(Thesis, PickAndPlaceVisitsItsPointsInOrderTwice) {
  Cell cell("pick_and_place");
  cell.interpreter->limit_passes(2);
  EXPECT_EQ(cell.run_all().state, TaskState::finished);
  const std::vector<std::string> pass = {"PrePick", "Pick",     "PrePick", "Pass1",
                                         "Pass2",   "PrePlace", "Place",   "PrePlace"};
  std::vector<std::string> expected = {"p0"};
  for (int i = 0; i < 2; ++i) expected.insert(expected.end(), pass.begin(), pass.end());
  EXPECT_EQ(cell.host.moves, expected);
  EXPECT_FALSE(cell.is("Repeat"));
  EXPECT_EQ(cell.interpreter->status().front().passes, 2u);
}

TEST(Thesis, PickAndPlaceEndsWhenThePlcClearsRepeat) {
  Cell cell("pick_and_place");
  EXPECT_EQ(cell.run_all([&] {
                  if (cell.interpreter->status().front().passes == 3) cell.plc("Repeat", false);
                })
                .state,
            TaskState::finished);
  EXPECT_EQ(count(cell.host.moves, "Pick"), 4u);
}

TEST(Thesis, SortingPutsEachKindInItsPlace) {
  Cell cell("sorting");
  cell.interpreter->limit_passes(3);
  std::size_t picked = 0;
  EXPECT_EQ(cell.run_all([&] {
                  const std::size_t picks = count(cell.host.moves, "Pick");
                  if (picks == picked) return;
                  picked = picks;
                  if (picks == 1) cell.plc("Type2", true);
                  if (picks == 2) cell.plc("Type1", true);
                })
                .state,
            TaskState::finished);
  std::vector<std::string> places;
  for (const std::string& move : cell.host.moves)
    if (move.starts_with("Place")) places.push_back(move);
  EXPECT_EQ(places, (std::vector<std::string>{"Place2", "Place1", "Place3"}));
}

TEST(Thesis, BinPickingLoadsAndUnloadsAndSeesThePointWrittenFromOutside) {
  Cell cell("bin_picking");
  cell.interpreter->limit_passes(4);
  const std::string points = (thesis("bin_picking") / "BINpoints.points").string();
  data::Point seen;
  std::size_t loads = 0;
  bool load_next = true;
  EXPECT_EQ(cell.run_all([&] {
                  if (cell.is("AskPickupPoint")) {
                    seen.pose.position.x += 0.01;
                    cell.host.files.at(points).set("pinput", seen);
                    cell.host.store.take_outside(points, {{"pinput", seen}}, "camera");
                    cell.plc("AskPickupPoint", false);
                    cell.plc("PickupPointSet", true);
                  }
                  if (cell.host.loads.size() == loads) return;
                  loads = cell.host.loads.size();
                  if (loads < 2) return;
                  cell.plc(load_next ? "LoadMachine" : "UnloadMachine", true);
                  load_next = !load_next;
                })
                .state,
            TaskState::finished);
  EXPECT_EQ(count(cell.host.moves, "pinput"), 2u);
  EXPECT_EQ(count(cell.host.moves, "p3"), 4u);
  EXPECT_EQ(cell.host.loads.size(), 5u);
  EXPECT_EQ(*cell.host.store.find("pinput"), data::Value(seen));
}

TEST(Thesis, DamagedListingGetsOneErrorForEachDamage) {
  Problems problems;
  parse(read_file(thesis("broken") / "SORscript.script"), "SORscript", problems);
  ASSERT_EQ(problems.list().size(), 2u);
  EXPECT_EQ(problems.list()[0].where.text(), "SORscript:12:1");
  EXPECT_NE(problems.list()[0].what.find("'mait'; did you mean 'wait'?"), std::string::npos);
  EXPECT_EQ(problems.list()[1].where.text(), "SORscript:61:1");
  EXPECT_NE(problems.list()[1].what.find("'endif61'; did you mean 'endif'?"), std::string::npos);
}

}  // namespace
}  // namespace polyarm::program
