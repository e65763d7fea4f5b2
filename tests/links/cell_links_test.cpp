#include <gtest/gtest.h>
#include <signal.h>

#include <nlohmann/json.hpp>

#include "drivers/mock/mock.hpp"
#include "links/modbus/port.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/hardware/driver_loader.hpp"
#include "tests/links/running_link.hpp"
#include "tests/support/open_cell.hpp"

namespace polyarm {
namespace {

using Json = nlohmann::json;
using control::RunState;

/// A cell in lock-step whose PLC is a Modbus server in this process.
class LinkedCell : public testing::Test, public cell::Observer {
 protected:
  void SetUp() override {
    hardware::register_driver(
        "mock", [] { return std::unique_ptr<hardware::Component>(new drivers::MockComponent); });
    std::string pattern = (std::filesystem::temp_directory_path() / "polyarm_XXXXXX").string();
    folder = ::mkdtemp(pattern.data());
    start_plc();
  }
  void TearDown() override {
    if (running) running->loop().end();
    running.reset();
    std::filesystem::remove_all(folder);
  }
  void on_problem(Nanoseconds, const Problem& problem) override { told += problem.text() + "\n"; }
  void on_note(const std::string& text) override { told += text + "\n"; }

  void start_plc() {
    const signals::LinkEntry entry = test::link_entry(R"(
cell: {modbus: server, port: PORT, tags: {Start: {coil: 0, direction: out}, Belt: {holding: 0, direction: in},
       Alive: {coil: 1, direction: in}, PlcAlive: {coil: 2, direction: out}, Held: {coil: 3, direction: in}}})",
                                                      port);
    plc = std::make_unique<test::RunningLink>(entry, modbus::make_server(entry));
    plc->look();
    ASSERT_TRUE(test::eventually([&] { return test::listens(port); }));
  }
  void start_cell(const std::string& program, const std::string& more = "", const std::string& cell_more = "",
                  const std::string& link_more = "") {
    const std::string urdf = std::string(POLYARM_SOURCE_DIR) + "/examples/r6bot/r6bot.urdf";
    write_file_atomically(folder / "cell.yaml",
                          "polyarm: cell/1\nrobots: {arm: {model: " + urdf +
                              ", hardware: mock}}\nsignals: signals.yaml\nprogram: main.script\n" +
                              cell_more);
    write_file_atomically(folder / "main.script", program);
    write_file_atomically(
        folder / "signals.yaml",
        "polyarm: signals/1\ntags:\n  Belt: {initial: 0, type: number, on_hold: 7, on_stop: 9, unit: "
        "m/s}\n  IsHeld: {state: cell/held}\n" +
            more + "links:\n  plc:\n    modbus: client\n    port: " + std::to_string(port) +
            "\n    timeout: 2s\n" + link_more +
            "    tags: {Start: {coil: 0, direction: in}, Belt: {holding: 0, "
            "direction: out}, Alive: {coil: 1, direction: out}, PlcAlive: {coil: 2, direction: in}, "
            "IsHeld: {coil: 3, direction: out}}\n");
    cell::CellOptions options;
    options.lock_step = options.links = true;
    running = std::make_unique<test::OpenCell>(cell::read_cell_file(folder / "cell.yaml"),
                                               description::Catalogue({}), options, *this);
    running->loop().begin();
  }
  void tick() {
    const Nanoseconds until = running->loop().cycle().time + cell::Cell::kTick;
    running->tick(running->loop().cycle().time);
    while (running->loop().cycle().time < until) running->loop().step_next();
  }
  /// The cell goes on until it is so.
  bool becomes(const std::function<bool()>& so) {
    return test::eventually([&] {
      for (int k = 0; k < 5; ++k) tick();
      plc->look();
      return so();
    });
  }
  RunState state() { return running->snapshot().state; }
  bool says(const std::string& part) const { return told.find(part) != std::string::npos; }
  bool plc_has(const std::string& name, const data::Value& value) {
    return plc->values.contains(name) && plc->values.at(name) == value;
  }
  /// The first answer; the asker stays while `there` is true.
  Json ask(const Json& request, const bool* there = nullptr) {
    auto out = std::make_shared<Json>();
    running->requests().handle(request.dump(), [out, there](const std::string& line) {
      if (out->is_null()) *out = Json::parse(line);
      return !there || *there;
    });
    for (int k = 0; k < 100 && out->is_null(); ++k) tick();
    return out->value("ok", false) ? (*out)["result"] : *out;
  }

  int port = test::free_port();
  std::filesystem::path folder;
  std::string told;
  std::unique_ptr<test::RunningLink> plc;
  std::unique_ptr<test::OpenCell> running;
};

/// Its encoder is a tag of the link, which keeps its value when the link is lost.
TEST_F(LinkedCell, ABeltWhoseEncoderComesOverALostLinkHoldsTheCellAndDoesNotStand) {
  start_cell("set Belt = 3\nwhile true\n  let n = waiting_parts(\"line\")\n  wait 10ms\nend\n",
             "  Start: {initial: false}\n", "belts:\n  line: {encoder: Start, from: 0, to: 1}\n",
             "    on_loss: go_on\n");
  ASSERT_TRUE(becomes([&] { return plc_has("Belt", 3); })) << told;
  EXPECT_EQ(state(), RunState::running) << told;
  plc = nullptr;
  ASSERT_TRUE(test::eventually([&] { return tick(), state() == RunState::held; })) << told;
  EXPECT_TRUE(says("the encoder of the belt 'line' comes over the link 'plc', which is lost")) << told;
}

constexpr const char* kWaits = "set Belt = 3\nwait Start\nset Belt = 4\nwait not Start\n";

TEST_F(LinkedCell, AProgramThatWaitsIsHeldWhenItsLinkIsLostAndGoesOnWhenAPersonResumes) {
  start_cell(kWaits);
  ASSERT_TRUE(becomes([&] { return plc_has("Belt", 3); }));
  EXPECT_EQ(state(), RunState::running);
  plc = nullptr;
  ASSERT_TRUE(test::eventually([&] { return tick(), state() == RunState::held; }));
  EXPECT_TRUE(says("the link 'plc' is lost: modbus at 127.0.0.1")) << told;
  start_plc();
  plc->post("Start", true);
  ASSERT_TRUE(becomes([&] {
    return running->store().find("Start")->as_boolean() && *running->store().find("Start")->as_boolean();
  }));
  EXPECT_EQ(state(), RunState::held) << "nothing resumes by itself";
  EXPECT_TRUE(plc_has("Belt", 7)) << "on_hold, told anew to a PLC that had forgotten";
  ask({{"request", "control.resume"}});
  EXPECT_TRUE(becomes([&] { return plc_has("Belt", 4); }));
}

TEST_F(LinkedCell, AProgramWhoseLinkWasNeverConnectedSaysThatItWaitsForIt) {
  plc = nullptr;
  start_cell(kWaits);
  ASSERT_TRUE(test::eventually([&] {
    tick();
    return says("the programs begin when the link 'plc' is connected: modbus at 127.0.0.1");
  })) << told;
  const Json waits = ask({{"request", "program"}});
  EXPECT_EQ(waits["state"], "waiting") << waits;
  EXPECT_EQ(waits["sentence"], "waits for the link 'plc'");
  EXPECT_EQ(waits["tasks"][0]["waits_for"], "link");
  EXPECT_EQ(waits["tasks"][0]["text"], "plc");
  start_plc();
  ASSERT_TRUE(becomes([&] { return plc_has("Belt", 3); })) << told;
  EXPECT_EQ(ask({{"request", "program"}})["tasks"][0]["waits_for"], "condition");
}

TEST_F(LinkedCell, AProcessOfALinkThatIsKilledIsALossLikeAnyOther) {
  start_cell(kWaits);
  ASSERT_TRUE(becomes([&] { return plc_has("Belt", 3); }));
  const int process = test::link_process_of(::getpid());
  ASSERT_GT(process, 0) << "the library that parses what the PLC sends is in a process of its own";
  ASSERT_EQ(::kill(process, SIGKILL), 0);
  ASSERT_TRUE(test::eventually([&] { return tick(), plc->look(), state() == RunState::held; }));
  EXPECT_TRUE(says("the link 'plc' is lost: modbus at 127.0.0.1")) << told;
  EXPECT_TRUE(says("(polyarm_link_modbus) was ended by SIGKILL")) << told;
  ASSERT_TRUE(becomes([&] { return says("the link 'plc' is connected again"); })) << told;
  EXPECT_EQ(state(), RunState::held) << "nothing resumes by itself";
  plc->post("Start", true);
  ask({{"request", "control.resume"}});
  EXPECT_TRUE(becomes([&] { return plc_has("Belt", 4); }));
}

TEST_F(LinkedCell, WhoResumesWhileTheLinkIsLostIsHeldAgain) {
  start_cell(kWaits);
  ASSERT_TRUE(becomes([&] { return plc_has("Belt", 3); }));
  plc = nullptr;
  ASSERT_TRUE(test::eventually([&] { return tick(), state() == RunState::held; }));
  ask({{"request", "control.resume"}});
  ASSERT_TRUE(test::eventually([&] { return tick(), state() == RunState::held; }));
  for (int k = 0; k < 20; ++k) tick();
  EXPECT_EQ(state(), RunState::held);
  EXPECT_FALSE(running->program()->ended());
}

TEST_F(LinkedCell, OutputsHaveWhatTheirRulesSayAtHoldAndEnd) {
  start_cell("set Belt = 3\nwait Start\n");
  ASSERT_TRUE(becomes([&] { return plc_has("Belt", 3); }));
  ask({{"request", "control.hold"}});
  EXPECT_TRUE(becomes([&] { return plc_has("Belt", 7) && plc_has("Held", true); }));
  EXPECT_EQ(*running->store().find("Belt"), data::Value(3)) << "the tag keeps what the program set";
  ask({{"request", "control.resume"}});
  EXPECT_TRUE(becomes([&] { return plc_has("Belt", 3); }));
  plc->post("Start", true);
  EXPECT_TRUE(becomes([&] { return plc_has("Belt", 9); }));
  EXPECT_TRUE(becomes([&] { return running->finished(); }));
}

TEST_F(LinkedCell, GivesItsHeartbeatAndHoldsWhenTheOtherOneStops) {
  start_cell(kWaits, "heartbeat: {tag: Alive, every: 20ms}\nwatch: {PlcAlive: 500ms}\n");
  ASSERT_TRUE(becomes([&] { return plc_has("Alive", true); }));
  ASSERT_TRUE(becomes([&] { return plc_has("Alive", false); }));
  for (int k = 0; k < 300; ++k) tick();
  EXPECT_EQ(state(), RunState::running) << "a heartbeat that never was is not missed";
  plc->post("PlcAlive", true);
  ASSERT_TRUE(becomes([&] { return *running->store().find("PlcAlive") == data::Value(true); }));
  EXPECT_TRUE(becomes([&] { return state() == RunState::held; }));
  EXPECT_TRUE(says("the heartbeat 'PlcAlive' has not changed for 0.5 s")) << told;
}

TEST_F(LinkedCell, ItsHeartbeatStopsWhenTheControlLoopDoes) {
  start_cell(kWaits, "heartbeat: {tag: Alive, every: 20ms}\n");
  ASSERT_TRUE(becomes([&] { return plc_has("Alive", true); }));
  const Nanoseconds now = running->loop().cycle().time;
  const std::uint64_t before = running->store().version();
  running->tick(now);
  for (int k = 1; k < 100; ++k)
    running->tick(now + k * cell::Cell::kTick);  // the cell lives, the loop does not
  EXPECT_LE(running->store().version(), before + 2);
}

TEST_F(LinkedCell, TellsEveryTagWithItsFactsAndLinks) {
  start_cell(kWaits);
  ASSERT_TRUE(becomes([&] { return plc_has("Belt", 3); }));
  const Json all = ask({{"request", "tags.list"}, {"names", {"Belt", "Start"}}});
  const Json &belt = all["tags"][0], &start = all["tags"][1];
  EXPECT_EQ(belt["type"], "number");
  EXPECT_EQ(belt["unit"], "m/s");
  EXPECT_EQ(belt["value"], 3.0);
  EXPECT_EQ(belt["direction"], "out");
  EXPECT_EQ(belt["changed_by"], "program");
  EXPECT_EQ(belt["rules"]["on_hold"], 7.0);
  EXPECT_EQ(start["source"], "cell, link plc");
  EXPECT_EQ(start["quality"], "good");
  EXPECT_EQ(all["links"][0]["up"], true);
  plc = nullptr;
  ASSERT_TRUE(test::eventually([&] { return tick(), state() == RunState::held; }));
  const Json lost = ask({{"request", "tags.list"}, {"names", {"Start"}}});
  EXPECT_EQ(lost["tags"][0]["quality"], "stale");
  EXPECT_EQ(lost["links"][0]["up"], false);
}

TEST_F(LinkedCell, AForcedTagEndsWithTheSessionOfWhoForcedIt) {
  start_cell(kWaits);
  ASSERT_TRUE(becomes([&] { return plc_has("Belt", 3); }));
  bool there = true;
  const Json forced = ask({{"request", "tags.force"}, {"name", "Start"}, {"value", true}}, &there);
  EXPECT_EQ(forced["forced"], true) << forced;
  EXPECT_TRUE(becomes([&] { return plc_has("Belt", 4); })) << "the program sees what is forced";
  EXPECT_EQ(ask({{"request", "tags.force"}, {"name", "Start"}, {"value", true}})["error"]["code"], "in-use");
  EXPECT_EQ(ask({{"request", "tags.force"}, {"name", "Belt"}, {"value", "x"}})["error"]["code"],
            "bad-argument");
  there = false;
  EXPECT_TRUE(becomes([&] { return running->program()->ended(); })) << "released, Start is false again";
  EXPECT_TRUE(says("'Start' is no longer forced"));
}

TEST_F(LinkedCell, SaysWhatItsLinksCannotBring) {
  EXPECT_THROW(start_cell("wait Start\n", "  Start: {initial: 3}\n"), Error);
  try {
    start_cell("wait Start\n", "  Start: {state: program/running}\n");
    ADD_FAILURE();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("comes from the hardware"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace polyarm
