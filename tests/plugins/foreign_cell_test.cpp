/// Somebody else's cell: what it brings does not run, and what it names stays inside its folder, until the
/// user says otherwise.
#include <gtest/gtest.h>

#include <chrono>
#include <nlohmann/json.hpp>

#include "polyarm/base/file.hpp"
#include "tests/support/at_terminal.hpp"
#include "tests/support/command.hpp"
#include "tests/support/folder.hpp"

namespace polyarm {
namespace {

namespace fs = std::filesystem;

bool tells(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}
#define EXPECT_OUTPUT_HAS(text, part) EXPECT_PRED2(tells, text, part)

class ForeignCell : public ::testing::Test {
 protected:
  void SetUp() override {
    ::setenv("XDG_CONFIG_HOME", (place.path() / "settings").c_str(), 1);
    ::setenv("XDG_RUNTIME_DIR", (place.path() / "runtime").c_str(), 1);
    ::setenv("POLYARM_TEST_MARK", mark().c_str(), 1);
    place.write("home/precious.txt", "mine\n");
    fs::create_directories(cell());
  }
  void TearDown() override {
    for (const char* name : {"XDG_CONFIG_HOME", "XDG_RUNTIME_DIR", "POLYARM_TEST_MARK"}) ::unsetenv(name);
  }
  fs::path cell() const { return place.path() / "foreign"; }
  fs::path mark() const { return place.path() / "was-here"; }
  fs::path precious() const { return place.path() / "home" / "precious.txt"; }
  void cell_with(const std::string& more) {
    place.write("foreign/cell.yaml", "polyarm: cell/1\nrate: 100\nrobots: {arm: {model: demo/r6bot}}\n" + more);
  }
  /// A cell with a library that leaves a mark when its code runs.
  void bring_library() {
    fs::copy_file(fs::path(POLYARM_TEST_PLUGINS) / "marking" / "marking.so", library());
    cell_with("plugins: [.]\n");
  }
  fs::path library() const { return cell() / "marking.so"; }
  test::Finished run(std::vector<std::string> more = {}) {
    std::vector<std::string> words = {"run", cell(), "--fast", "--seconds", "0.1"};
    words.insert(words.end(), more.begin(), more.end());
    return test::run_command(words);
  }
  test::Folder place;
};

TEST_F(ForeignCell, RunsNoneOfItsCodeBeforeSomebodyHasApprovedIt) {
  bring_library();
  const auto refused = run();
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_OUTPUT_HAS(refused.output, "that nobody has approved on this machine");
  EXPECT_OUTPUT_HAS(refused.output, "polyarm plugins approve ");
  test::run_command({"check", cell(), "--dry", "--cycles", "1"});
  const auto listed = test::run_command({"plugins", cell(), "--json"});
  EXPECT_EQ(listed.exit_code, 1);
  EXPECT_EQ(nlohmann::json::parse(listed.output)["not_approved"].size(), 1u) << listed.output;
  EXPECT_FALSE(fs::exists(mark())) << "its code has run";

  ASSERT_EQ(test::run_command({"plugins", "approve", library()}).exit_code, 0);
  EXPECT_FALSE(fs::exists(mark())) << "approving does not load";
  const auto done = run();
  EXPECT_EQ(done.exit_code, 0) << done.output;
  EXPECT_TRUE(fs::exists(mark()));
}

TEST_F(ForeignCell, CheckNeverLoadsWhatACellBrings) {
  bring_library();
  ASSERT_EQ(test::run_command({"plugins", "approve", library()}).exit_code, 0);
  const auto checked = test::run_command({"check", cell()});
  EXPECT_EQ(checked.exit_code, 0) << checked.output;
  EXPECT_OUTPUT_HAS(checked.output, "check loads no native code of a cell");
  EXPECT_FALSE(fs::exists(mark()));
}

TEST_F(ForeignCell, AChangedLibraryHasToBeApprovedAgain) {
  bring_library();
  ASSERT_EQ(test::run_command({"plugins", "approve", cell()}).exit_code, 0);
  std::string bytes = read_file(library());
  bytes += "x";  // behind its end, where the loader does not look
  write_file_atomically(library(), bytes);
  EXPECT_EQ(run().exit_code, 1);
  EXPECT_FALSE(fs::exists(mark()));
}

TEST_F(ForeignCell, AFolderForDevelopmentIsBuiltAnewWithoutAQuestion) {
  bring_library();
  ASSERT_EQ(test::run_command({"plugins", "approve", "--development", cell()}).exit_code, 0);
  write_file_atomically(library(), read_file(library()) + "x");
  EXPECT_EQ(run().exit_code, 0);
  EXPECT_TRUE(fs::exists(mark()));
  EXPECT_OUTPUT_HAS(test::run_command({"plugins", "approved"}).output, "folder");
  ASSERT_EQ(test::run_command({"plugins", "revoke", cell()}).exit_code, 0);
  fs::remove(mark());
  EXPECT_EQ(run().exit_code, 1);
  EXPECT_FALSE(fs::exists(mark()));
  EXPECT_EQ(test::run_command({"plugins", "approve", "--development", "/tmp"}).exit_code, 1);
}

TEST_F(ForeignCell, IsAskedForAtATerminalOnce) {
  bring_library();
  {
    test::AtTerminal refusing({"run", cell(), "--fast", "--seconds", "0.1"});
    ASSERT_TRUE(refusing.shows("Type yes or no"));
    refusing.type("no\n");
    EXPECT_EQ(refusing.ends(), 1);
  }
  EXPECT_FALSE(fs::exists(mark()));
  {
    test::AtTerminal agreeing({"run", cell(), "--fast", "--seconds", "0.1"});
    ASSERT_TRUE(agreeing.shows("sha256"));
    ASSERT_TRUE(agreeing.shows("Type yes or no"));
    agreeing.type("yes\n");
    EXPECT_EQ(agreeing.ends(), 0);
  }
  EXPECT_TRUE(fs::exists(mark()));
  EXPECT_EQ(run().exit_code, 0) << "it is remembered";
}

TEST_F(ForeignCell, RecordsIntoItsOwnFolderAlone) {
  cell_with("record: ../home/precious.txt\n");
  const auto refused = run();
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_OUTPUT_HAS(refused.output, "outside its folder");
  EXPECT_OUTPUT_HAS(refused.output, "--allow ");
  EXPECT_EQ(read_file(precious()), "mine\n");
  cell_with("record: sub/a.mcap\n");
  EXPECT_EQ(run().exit_code, 0);
  EXPECT_EQ(fs::status(cell() / "sub/a.mcap").permissions(), fs::perms(0600));
}

TEST_F(ForeignCell, AStateFolderThatIsALinkEmptiesNothing) {
  cell_with("");
  place.write("home/data/precious.txt", "mine\n");
  fs::create_directory_symlink(place.path() / "home", cell() / ".state");
  const auto refused = run();
  EXPECT_EQ(refused.exit_code, 1) << refused.output;
  EXPECT_OUTPUT_HAS(refused.output, "--allow ");
  EXPECT_TRUE(fs::exists(place.path() / "home/data/precious.txt"));
}

TEST_F(ForeignCell, ALinkDeepInItsStateFolderIsRefusedAsWell) {
  cell_with("");
  fs::create_directories(cell() / ".state/versions");
  fs::create_directory_symlink(place.path() / "home", cell() / ".state/versions/main.script");
  const auto refused = run();
  EXPECT_EQ(refused.exit_code, 1) << refused.output;
  EXPECT_OUTPUT_HAS(refused.output, ".state/versions/main.script");
}

TEST_F(ForeignCell, APasswordFromElsewhereIsRefusedOnce) {
  place.write("home/broker.password", "x\n");
  cell_with("signals: signals.yaml\n");
  for (const char* keys : {"password_file: ../home/broker.password",
                           "password_file: ../home/broker.password, tls: {ca: ../home/broker.password}"}) {
    place.write("foreign/signals.yaml", std::string("polyarm: signals/1\nlinks: {broker: {mqtt: client, ") + keys +
                                            ", tags: {A: {topic: a, type: number, direction: in}}}}\n");
    const auto refused = run({"--links"});
    EXPECT_EQ(refused.exit_code, 1);
    const auto at = refused.output.find("broker.password: error:");
    ASSERT_NE(at, std::string::npos) << refused.output;
    EXPECT_EQ(refused.output.find("broker.password: error:", at + 1), std::string::npos) << refused.output;
  }
}

TEST_F(ForeignCell, LinksToNothingAreRefusedInItsStateFolder) {
  cell_with("");
  for (const std::string& target : {(place.path() / "home/missing").string(), std::string("missing")})
    for (const char* link : {".state", ".state/lock.cell.yaml", ".state/data", ".state/logs", ".state/recordings"}) {
      fs::remove_all(cell() / ".state");
      fs::create_directories((cell() / link).parent_path());
      fs::create_symlink(target, cell() / link);
      const auto refused = run();
      EXPECT_EQ(refused.exit_code, 1) << link << " to " << target << ": " << refused.output;
      EXPECT_OUTPUT_HAS(refused.output, std::string(link) + ": error: ");
      EXPECT_FALSE(fs::exists(place.path() / "home/missing"));
    }
}

TEST_F(ForeignCell, ARunWithoutItsLockDoesNotBegin) {
  cell_with("");
  place.write("foreign/other", "");
  fs::create_directories(cell() / ".state");
  fs::create_symlink("../other", cell() / ".state/lock.cell.yaml");
  EXPECT_OUTPUT_HAS(run().output, "this is a link, but a run needs a file for its lock here");
  fs::remove(cell() / ".state/lock.cell.yaml");
  fs::create_directory(cell() / ".state/lock.cell.yaml");
  EXPECT_OUTPUT_HAS(run().output, "the lock of a run cannot be created");
  fs::remove(cell() / ".state/lock.cell.yaml");
  EXPECT_EQ(run().exit_code, 0);
}

TEST_F(ForeignCell, ReadsItsOwnFolderAlone) {
  place.write("home/scene.yaml", "polyarm: scene/1\n");
  for (const std::string& named : {std::string("../home/scene.yaml"), (place.path() / "home/scene.yaml").string(),
                                   std::string("link.yaml")}) {
    cell_with("scene: " + named + "\n");
    std::error_code there;
    fs::create_symlink(place.path() / "home/scene.yaml", cell() / "link.yaml", there);
    const auto refused = run();
    EXPECT_EQ(refused.exit_code, 1) << named;
    EXPECT_OUTPUT_HAS(refused.output, "outside its folder");
    EXPECT_EQ(test::run_command({"check", cell()}).exit_code, 1) << named;
    EXPECT_EQ(run({"--allow", place.path() / "home"}).exit_code, 0) << named;
  }
}

TEST_F(ForeignCell, AProgramThatTheUserNamesMayLieAnywhere) {
  cell_with("");
  const std::string program = place.write("mine/main.script", "log 1\n");
  const auto done = run({"--program", program});
  EXPECT_EQ(done.exit_code, 0) << done.output;
}

TEST_F(ForeignCell, SpeaksWithNoHostBeyondThisMachineUnasked) {
  cell_with("signals: signals.yaml\n");
  place.write("foreign/signals.yaml",
              "polyarm: signals/1\nlinks:\n  plc: {modbus: client, host: 192.0.2.1, beyond_loopback: true, on_loss: go_on, tags: {A: "
              "{coil: 1, direction: in}}}\n");
  const auto refused = run({"--links"});
  EXPECT_EQ(refused.exit_code, 1) << refused.output;
  EXPECT_OUTPUT_HAS(refused.output, "192.0.2.1, which you have not allowed");
  EXPECT_OUTPUT_HAS(refused.output, "--allow host:192.0.2.1");
  EXPECT_FALSE(tells(run({"--links", "--allow", "host:192.0.2.1"}).output, "which you have not allowed"));
}

TEST_F(ForeignCell, APasswordFileOutsideIsNotRead) {
  cell_with("signals: signals.yaml\n");
  const auto with = [&](const std::string& file) {
    place.write("foreign/signals.yaml",
                "polyarm: signals/1\nlinks:\n  broker: {mqtt: client, on_loss: go_on, user: me, password_file: '" + file +
                    "', tags: {A: {topic: a, direction: in}}}\n");
    return run({"--links"});
  };
  EXPECT_OUTPUT_HAS(with("../home/precious.txt").output, "outside its folder");
  EXPECT_OUTPUT_HAS(with("secret:broker").output, "your secret 'broker'");
}

TEST_F(ForeignCell, ASecretOfHardwareIsReadWhenItIsAllowed) {
  place.write("foreign/cell.yaml",
              "polyarm: cell/1\nrate: 250\nrobots: {arm: {model: abb/irb_120, hardware: abb, parameters: {host: "
              "127.0.0.1, rws_port: 1, password_file: \"secret:abb\"}}}\n");
  const fs::path secret = place.write("settings/polyarm/secrets/abb", "word");
  fs::permissions(secret.parent_path(), fs::perms::owner_all);
  fs::permissions(secret, fs::perms::owner_read | fs::perms::owner_write);
  const std::vector<std::string> words = {"run", cell(), "--real", "--seconds", "0.1"};
  EXPECT_OUTPUT_HAS(test::run_command(words).output, "your secret 'abb'");
  auto more = words;
  more.insert(more.end(), {"--allow", "secret:abb"});
  const std::string allowed = test::run_command(more).output;
  EXPECT_FALSE(tells(allowed, "not allowed")) << allowed;
  EXPECT_FALSE(tells(allowed, "outside its folder")) << allowed;
}

TEST_F(ForeignCell, PipesAndDevicesAreRefusedWithWords) {
  cell_with("scene: scene.yaml\n");
  ASSERT_EQ(::system(("mkfifo '" + (cell() / "scene.yaml").string() + "'").c_str()), 0);
  const auto refused = run();
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_OUTPUT_HAS(refused.output, "this is a pipe, a file was expected");
}

/// `before`, then `each` with its number in the place of '#', so many times.
std::string many(std::string before, const std::string& each, int times) {
  for (int i = 0; i < times; ++i)
    for (const char c : each) c == '#' ? before += std::to_string(i) : before += c;
  return before;
}

TEST_F(ForeignCell, FilesOfAnySizeAreRefusedWithWordsAndLittleTime) {
  const auto refuses = [&](const std::string& words) {
    const auto begun = std::chrono::steady_clock::now();
    for (const auto& finished : {run(), test::run_command({"check", cell()})}) {
      EXPECT_EQ(finished.exit_code, 1) << words;
      EXPECT_OUTPUT_HAS(finished.output, words);
      EXPECT_LT(finished.output.size(), 200'000u) << words;
    }
    EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(20)) << words;
  };
  place.write("foreign/cell.yaml", many("polyarm: cell/1\nrobots:\n", " r#: {model: demo/r6bot}\n", 20'000));
  refuses("more than 1024 robots");
  cell_with(std::string(17 << 20, '#'));
  refuses("bytes");
  cell_with("scene: scene.yaml\n");
  place.write("foreign/scene.yaml",
              many("polyarm: scene/1\nfixtures:\n", " f#: {box: [1, 1, 1], at: [5, 5, 5]}\n", 20'000));
  refuses("'fixtures' has more than 2000 entries");
  cell_with("signals: signals.yaml\n");
  place.write("foreign/signals.yaml", many("polyarm: signals/1\nlinks:\n", " l#: {modbus: client}\n", 2000));
  refuses("more than 64 links");
  cell_with("program: job\n");
  place.write("foreign/job.data", "Name: x\nText: " + std::string(17 << 20, 'y') + "\n");
  refuses("more than 16777216 bytes");
  place.write("foreign/cell.yaml", "polyarm: cell/1\nrobots: {arm: {model: r.xacro}}\n");
  place.write("foreign/r.xacro", many("<robot name='r'><g", " a#='1'", 200'000) + "/></robot>");
  refuses("more than 200 attributes");
  place.write("foreign/r.xacro", "<robot name='r' xmlns:xacro='http://www.ros.org/wiki/xacro'><link name='${" +
                                     std::string(1'000'000, '-') + "1}'/></robot>");
  refuses("too long");
}

TEST_F(ForeignCell, ManyTagsAreReadInLittleTime) {
  cell_with("signals: signals.yaml\n");
  place.write("foreign/signals.yaml", many("polyarm: signals/1\ntags:\n", " t#: {initial: 1}\n", 30'000));
  const auto begun = std::chrono::steady_clock::now();
  EXPECT_EQ(test::run_command({"check", cell()}).exit_code, 0);
  EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(15));
}

TEST_F(ForeignCell, TwoRunsOfOneFolderRefuseEachOther) {
  cell_with("");
  test::Command first({"run", cell(), "--wait", "--no-socket", "--json"});
  ASSERT_TRUE(first.wait_for("{"));
  test::Finished second;
  for (int i = 0; i < 50 && second.exit_code != 1; ++i)  // until the first has come so far
    second = test::run_command({"run", cell(), "--seconds", "0.01", "--no-socket"});
  EXPECT_EQ(second.exit_code, 1);
  EXPECT_OUTPUT_HAS(second.output, "another polyarm runs this cell");
  EXPECT_EQ(test::run_command({"check", cell()}).exit_code, 0) << "check runs beside it";
}

}  // namespace
}  // namespace polyarm
