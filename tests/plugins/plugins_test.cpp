#include "polyarm/plugins/plugins.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "polyarm/cell/check.hpp"
#include "polyarm/hardware/driver_loader.hpp"
#include "polyarm/hardware/hardware.hpp"
#include "polyarm/plugins/types.hpp"
#include "polyarm/protocol/type.hpp"
#include "polyarm/ros_files/hardware_names.hpp"
#include "polyarm/base/approvals.hpp"
#include "polyarm/base/reach.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm {
namespace {

using test::Json;

std::filesystem::path folder_of(const std::string& library) {
  return std::filesystem::path(POLYARM_TEST_PLUGINS) / library;
}
void load(const std::string& library) {
  plugins::load_folder(folder_of(library));
}
const plugins::Plugin* found(const std::string& name) {
  for (const plugins::Plugin& plugin : plugins::found())
    if (plugin.name == name) return &plugin;
  return nullptr;
}
const plugins::Refusal* refused(const std::string& library) {
  for (const plugins::Refusal& refusal : plugins::refused())
    if (refusal.file.stem() == library) return &refusal;
  return nullptr;
}
template <typename Step>
std::string thrown_by(Step step) {
  try {
    step();
  } catch (const Error& e) {
    return e.what();
  }
  return "nothing was thrown";
}
#define EXPECT_TEXT_HAS(text, part) EXPECT_NE(std::string(text).find(part), std::string::npos) << (text)

struct Row {
  const char* library;
  const char* reason;
  const char* advice;
};
class Refused : public ::testing::TestWithParam<Row> {};

TEST_P(Refused, WithTheReasonAndTheRestGoesOn) {
  load("both");  // names that are taken
  load(GetParam().library);
  const plugins::Refusal* const refusal = refused(GetParam().library);
  ASSERT_NE(refusal, nullptr);
  EXPECT_EQ(refusal->file, folder_of(GetParam().library) / (std::string(GetParam().library) + ".so"));
  EXPECT_TEXT_HAS(refusal->reason, GetParam().reason);
  EXPECT_TEXT_HAS(refusal->advice, GetParam().advice);
  EXPECT_NE(found("both"), nullptr);
  EXPECT_FALSE(hardware::driver_available("table/Follower"));
  EXPECT_FALSE(hardware::driver_available("things/Another"));
  EXPECT_EQ(controllers::find_controller_type("things/New"), nullptr) << "part of a refused plugin is in use";
}

INSTANTIATE_TEST_SUITE_P(
    Table, Refused,
    ::testing::Values(
        Row{"no_symbol", "exports no polyarm_plugin", "POLYARM_PLUGIN"},
        Row{"missing_function", "undefined symbol", "build it again against this Polyarm"},
        Row{"other_major", "plugin interface 2.0, this Polyarm has 1.0", "Polyarm"},
        Row{"newer_minor", "plugin interface 1.1, this Polyarm has 1.0", "newer Polyarm"},
        Row{"other_abi", "built with Clang 19.1.7 for 'Itanium C++ ABI, 64 bit, libc++'",
            "build it again with"},
        Row{"other_layout", "'table/Follower' was built with headers whose types have other sizes",
            "build it again"},
        Row{"other_controller_layout", "'table/Holder' was built with headers", "build it again"},
        Row{"no_factory", "entry 1 of its table has holes", "POLYARM_HARDWARE"},
        Row{"other_kind", "'table/Planner' is neither hardware nor a controller but kind 9", ""},
        Row{"throws", "its polyarm_plugin threw: not today", ""}, Row{"no_table", "returns no table", ""},
        Row{"no_slash", "'follower' is not a name for a type", "vendor/Type"},
        Row{"same_plugin", "there is a plugin 'both' already: ", "rename"},
        Row{"same_type", "the name 'things/Follower' is taken by ", "a name of its own"}),
    [](const auto& row) { return std::string(row.param.library); });

TEST(Plugins, AFileThatDoesNotLoadIsToldWithTheLoadersWords) {
  const test::Folder folder;
  folder.write("broken.so", "this is not a shared library");
  folder.write("notes.txt", "nor is this, and it does not say so");
  plugins::load_folder(folder.path());
  ASSERT_NE(refused("broken"), nullptr);
  EXPECT_TEXT_HAS(refused("broken")->reason, "cannot be loaded: ");
  EXPECT_EQ(refused("notes"), nullptr);
}

TEST(Plugins, AFolderThatIsNotThereIsToldOnce) {
  plugins::load_folder("/no/such/folder_of_plugins");
  plugins::load_folder("/no/such/folder_of_plugins");
  EXPECT_EQ(std::count_if(plugins::refused().begin(), plugins::refused().end(),
                          [](const auto& r) { return r.file == "/no/such/folder_of_plugins"; }),
            1);
}

TEST(Plugins, OneLibraryMayBringHardwareAndControllers) {
  load("both");
  load("both");  // seen before
  const plugins::Plugin* const both = found("both");
  ASSERT_NE(both, nullptr);
  EXPECT_EQ(both->version, "1.2.3");
  EXPECT_EQ(refused("both"), nullptr);
  ASSERT_EQ(both->entries.size(), 2u);
  EXPECT_EQ(both->entries[0].kind, hardware::PluginKind::hardware);
  EXPECT_EQ(both->entries[1].name, "things/Holder");
  EXPECT_NE(hardware::make_driver("things/Follower"), nullptr);
  controllers::Parameters parameters;
  EXPECT_NE(controllers::make_controller("things/Holder", parameters), nullptr);
}

TEST(Plugins, UnknownNamesGetTheNearestAmongThoseOfPlugins) {
  load("both");
  EXPECT_TEXT_HAS(thrown_by([] { hardware::make_driver("things/Folower"); }), "did you mean 'things/Follower'");
  controllers::Parameters parameters;
  EXPECT_TEXT_HAS(thrown_by([&] { controllers::make_controller("things/Holdr", parameters); }),
              "did you mean 'things/Holder'");
}

TEST(Plugins, ANameInADescriptionIsThePluginsOrGetsTheNearest) {
  load("both");
  EXPECT_EQ(ros_files::choose_hardware("things/Follower", "block").driver, "things/Follower");
  EXPECT_EQ(ros_files::choose_hardware("things/Follower", "block").note, "");
  EXPECT_TEXT_HAS(ros_files::choose_hardware("things/Folower", "block").note, "did you mean 'things/Follower'");
}

TEST(Plugins, NamesWithASlashAreNeverPaths) {
  EXPECT_FALSE(hardware::driver_available("../drivers/polyarm_driver_mujoco"));
  EXPECT_FALSE(hardware::driver_available("x/../mujoco"));
}

TEST(Plugins, AFactoryThatThrowsIsReportedWithTheFile) {
  load("throwing_factory");
  const std::string said = thrown_by([] { hardware::make_driver("throwing/Hardware"); });
  EXPECT_TEXT_HAS(said, "throwing_factory.so: making 'throwing/Hardware' it threw: no licence found");
  controllers::Parameters parameters;
  EXPECT_TEXT_HAS(thrown_by([&] { controllers::make_controller("throwing/Controller", parameters); }),
              "threw: something that is not a std::exception");
}

// --- callbacks that throw, in a cell ---

/// What was refused in other tests is told again in each cell; this is the one with the code.
Problem one_of(const std::vector<Problem>& problems, const std::string& code) {
  for (const Problem& problem : problems)
    if (problem.code == code) return problem;
  return {"none", {}, "nothing was told with the code " + code, {}};
}

/// A folder with a cell of one r6bot on things/Follower.
class ACell : public ::testing::Test {
 protected:
  void SetUp() override {
    ::setenv("XDG_CONFIG_HOME", settings.path().c_str(), 1);
    approve({"folder", resolved(folder_of("both")).string(), {}});
    hardware::register_driver(
        "mock", [] { return std::unique_ptr<hardware::Component>(new drivers::MockComponent); });
  }
  void write(const std::string& parameters, const std::string& controller_parameters = "",
             const std::string& type = "things/Follower", const std::string& kind = "things/Holder") {
    folder.write("cell.yaml", "polyarm: cell/1\nrate: 100\nplugins: [" + folder_of("both").string() +
                                  "]\ncontrollers: controllers.yaml\nrobots:\n  arm: {model: demo/r6bot, "
                                  "hardware: " +
                                  type + ", parameters: {" + parameters + "}}\n");
    folder.write("controllers.yaml", "controller_manager:\n  ros__parameters:\n    hold: {type: " + kind +
                                         "}\nhold:\n  ros__parameters:\n    joint: joint_2\n" +
                                         controller_parameters);
  }
  static description::Catalogue catalogue() {
    return description::Catalogue({std::string(POLYARM_SOURCE_DIR) + "/robots"});
  }
  std::unique_ptr<test::OpenCell> make() {
    cell::CellOptions options;
    options.lock_step = true;
    return std::make_unique<test::OpenCell>(cell::read_cell_file(folder.path()), catalogue(), options,
                                            observer);
  }
  test::Folder folder, settings;
  cell::Observer observer;
};

TEST_F(ACell, RunsHardwareAndControllerOfAPlugin) {
  write("");
  const auto cell = make();
  for (int i = 0; i < 3; ++i) cell->loop().step_next();
  const auto at = cell->loop().table().find_state("arm/joint_2/position");
  ASSERT_TRUE(at);
  EXPECT_GT(cell->loop().table().states()[*at], 0.25) << "the controller's command has reached the hardware";
}

/// Keeps what a run's first lines say.
class Notes : public cell::Observer {
 public:
  void on_note(const std::string& text) override { all += text + "\n"; }
  std::string all;
};

TEST_F(ACell, TellsAtOnceWhatOverranItsBudgetAndThenNotEveryTime) {
  write("slow: yes}, budget: 0.01ms, arguments: {");
  Notes notes;
  cell::CellOptions options;
  options.lock_step = true;
  test::OpenCell cell(cell::read_cell_file(folder.path()), catalogue(), options, notes);
  for (int i = 0; i < 8; ++i) cell.loop().step_next();
  cell.tick(cell.loop().cycle().time);
  EXPECT_TEXT_HAS(notes.all, "read took 0.0");
  EXPECT_TEXT_HAS(notes.all, " ms in cycle 0, its budget is 0.010 ms (is_async=\"true\"");
  EXPECT_EQ(notes.all.find(" ms in cycle 1,"), std::string::npos) << notes.all;
  for (int i = 0; i < 2; ++i) cell.loop().step_next();
  cell.tick(cell.loop().cycle().time);
  EXPECT_TEXT_HAS(notes.all, "; 10 times now");
  EXPECT_EQ(notes.all.find("hold: "), std::string::npos) << "nobody gave the controller a budget";
}

TEST_F(ACell, NothingIsTimedWithoutABudget) {
  write("slow: yes");
  Notes notes;
  cell::CellOptions options;
  options.lock_step = true;
  test::OpenCell cell(cell::read_cell_file(folder.path()), catalogue(), options, notes);
  for (int i = 0; i < 9; ++i) cell.loop().step_next();
  cell.tick(cell.loop().cycle().time);
  EXPECT_EQ(notes.all.find("budget"), std::string::npos) << notes.all;
}

struct Trip {
  const char* callback;
  const char* text;
};
class Tripping : public ACell, public ::testing::WithParamInterface<Trip> {};

TEST_P(Tripping, IsToldAndDoesNotEndTheProcess) {
  write(std::string("throws: ") + GetParam().callback);
  const std::string said = thrown_by([&] { make(); });
  EXPECT_TEXT_HAS(said, GetParam().text);
}
INSTANTIATE_TEST_SUITE_P(
    Table, Tripping,
    ::testing::Values(Trip{"on_init", "on_init, threw: tripped in on_init"},
                      Trip{"on_configure",
                           "could not be configured and is unconfigured: it threw: tripped in on_configure"},
                      Trip{"on_activate",
                           "could not be activated and is unconfigured: it threw: tripped in on_activate"},
                      Trip{"on_deactivate", "nothing was thrown"},  // shutting down goes on
                      Trip{"on_shutdown", "nothing was thrown"}),
    [](const auto& row) { return std::string(row.param.callback); });

TEST(Callbacks, OneThatThrowsInOnErrorIsFinalized) {
  load("both");
  hardware::InterfaceTable table;
  realtime::Jobs jobs;
  hardware::Hardware host(table, jobs);
  hardware::ComponentContext context;
  context.name = "bad";
  context.parameters["throws"] = "on_error";
  host.add(hardware::make_driver("things/Follower"), context);
  host.configure_and_activate();
  host.run(0, hardware::Step::error);
  EXPECT_EQ(host.state_of(0), hardware::LifecycleState::finalized);
}

TEST(Callbacks, OneThatThrowsInOnCleanupAsksOnError) {
  load("both");
  hardware::InterfaceTable table;
  realtime::Jobs jobs;
  hardware::Hardware host(table, jobs);
  hardware::ComponentContext context;
  context.name = "bad";
  context.parameters["throws"] = "on_cleanup";
  host.add(hardware::make_driver("things/Follower"), context, {});
  host.run(0, hardware::Step::configure);
  host.begin_cleanup(0);
  EXPECT_TEXT_HAS(thrown_by([&] { host.run(0, hardware::Step::cleanup); }), "it threw: tripped in on_cleanup");
  EXPECT_EQ(host.state_of(0), hardware::LifecycleState::unconfigured);
}

TEST_F(ACell, ToldOfAControllerThatThrowsWhatIsNoException) {
  write("", "    throws: on_configure\n");
  const auto cell = make();  // the rest of the cell starts
  std::string said;
  for (const auto& event : cell->events().events()) said += protocol::any_of(event).dump();
  EXPECT_TEXT_HAS(said, "the controller 'hold', on_configure, threw: something that is not a std::exception");
}

TEST_F(ACell, AControllerThatThrowsInOnCleanupIsUnconfigured) {
  write("", "    throws: on_cleanup\n");
  const auto cell = make();
  control::ControllerManager& manager = cell->loop().controllers();
  manager.deactivate("hold");
  EXPECT_TEXT_HAS(thrown_by([&] { manager.cleanup("hold"); }), "on_cleanup, threw: tripped in on_cleanup");
  EXPECT_NO_THROW(manager.configure("hold"));
}

/// Check loads no code of a cell: it knows what plugins offer once a run of this process has loaded them.
TEST_F(ACell, HardwareThatThereIsNotIsNamed) {
  write("", "", "things/Follow");
  EXPECT_TEXT_HAS(thrown_by([&] { make(); }), "did you mean 'things/Follower'");
  const cell::CheckResult checked = cell::check(folder.path(), {}, catalogue(), {});
  ASSERT_TRUE(checked.has_errors());
  const Problem problem = one_of(checked.problems, "unknown-driver");
  EXPECT_EQ(problem.where.line, 6);
  EXPECT_TEXT_HAS(problem.what, "did you mean 'things/Follower'");
}

TEST_F(ACell, NamesAFolderThatIsNotThereWithItsLine) {
  write("");
  folder.write("cell.yaml", "polyarm: cell/1\nplugins: [biuld]\nrobots: {arm: {model: demo/r6bot}}\n");
  const cell::CheckResult checked = cell::check(folder.path(), {}, catalogue(), {});
  EXPECT_FALSE(checked.has_errors()) << "a cell that needs no plugin runs without it";
  const std::string told = one_of(checked.problems, "no-folder").text();
  EXPECT_TEXT_HAS(told, "cell.yaml:2:");
  EXPECT_TEXT_HAS(told, "'biuld' is not a folder with plugins");
}

}  // namespace
}  // namespace polyarm
