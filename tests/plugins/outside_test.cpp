/// What `polyarm new` writes, outside this tree: configured, built, tested and run.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "polyarm/base/file.hpp"
#include "tests/support/command.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm {
namespace {

namespace fs = std::filesystem;

struct Shell {
  int exit_code = -1;
  std::string output;
};
Shell shell(const std::string& line) {
  Shell out;
  std::FILE* pipe = ::popen((line + " 2>&1").c_str(), "r");
  if (!pipe) return out;
  char buffer[4096];
  while (std::fgets(buffer, sizeof buffer, pipe)) out.output += buffer;
  const int status = ::pclose(pipe);
  out.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128;
  return out;
}
void expect_done(const std::string& line) {
  const Shell done = shell(line);
  ASSERT_EQ(done.exit_code, 0) << line << "\n" << done.output;
}
std::string quoted(const fs::path& path) {
  return "'" + path.string() + "'";
}

/// Configures, builds and tests the folder with `found_by`, how CMake is told where Polyarm is.
void build(const fs::path& folder, const std::string& found_by) {
  const std::string to = " " + quoted(folder / "build");
  ASSERT_NO_FATAL_FAILURE(expect_done(std::string(POLYARM_CMAKE) + " -S " + quoted(folder) + " -B" + to +
                                      " -G '" + POLYARM_GENERATOR + "' -DCMAKE_BUILD_TYPE=None " + found_by +
                                      " -DCMAKE_CXX_FLAGS='" + POLYARM_FLAGS + "'" + POLYARM_LAUNCHER));
  ASSERT_NO_FATAL_FAILURE(expect_done(std::string(POLYARM_CMAKE) + " --build" + to));
  ASSERT_NO_FATAL_FAILURE(
      expect_done(std::string(POLYARM_CTEST) + " --no-tests=error --output-on-failure --test-dir" + to));
}

TEST(New, WritesHardwareAndControllersThatBuildPassAndRunOutsideTheTree) {
  const test::Folder place;
  ::setenv("XDG_CONFIG_HOME", (place.path() / "settings").c_str(), 1);  // `new` approves what it writes
  ::setenv("CCACHE_BASEDIR", place.path().c_str(), 1);  // what was compiled in an earlier run is found again
  const fs::path installed = place.path() / "prefix", arm = place.path() / "arm",
                 follow = place.path() / "follow";
  ASSERT_EQ(test::run_command({"new", "hardware", "MyArm", "--vendor", "acme", "--folder", arm}).exit_code,
            0);
  ASSERT_EQ(test::run_command({"new", "controller", "follow_me", "--folder", follow}).exit_code, 0);

  // A controller against the build folder.
  ASSERT_NO_FATAL_FAILURE(build(follow, "-Dpolyarm_DIR='" POLYARM_BUILD "'"));

  // Hardware against an installation, with the headers that are installed and no others.
  ASSERT_NO_FATAL_FAILURE(expect_done(std::string(POLYARM_CMAKE) +
                                      " --install '" POLYARM_BUILD "' --prefix " + quoted(installed)));
  ASSERT_NO_FATAL_FAILURE(build(arm, "-DCMAKE_PREFIX_PATH=" + quoted(installed)));
  for (const auto& file : fs::recursive_directory_iterator(installed / "include")) {
    if (!file.is_regular_file()) continue;
    for (const char* foreign : {"<Eigen", "yaml-cpp", "<fmt/", "nlohmann", "gtest"})
      EXPECT_EQ(read_file(file.path()).find(foreign), std::string::npos) << file.path() << " has " << foreign;
  }

  // Both in one cell, under the installed command, which finds the hardware in its own folder.
  fs::create_directories(installed / "lib/polyarm/plugins");
  fs::copy_file(arm / "build/my_arm.so", installed / "lib/polyarm/plugins/my_arm.so");
  const fs::path cell = place.path() / "cell";
  fs::create_directories(cell);
  fs::copy_file(arm / "robot.urdf", cell / "robot.urdf");
  fs::copy_file(follow / "controllers.yaml", cell / "controllers.yaml");
  fs::copy_file(follow / "move.yaml", cell / "move.yaml");
  write_file_atomically(
      cell / "cell.yaml",
      "polyarm: cell/1\nrate: 100\nplugins: [../follow/build]\ncontrollers: controllers.yaml\n"
      "robots: {arm: {model: robot.urdf, hardware: declared}}\nsend: {follow_me: move.yaml}\n");
  const std::string command = quoted(installed / "bin/polyarm");
  const Shell run = shell(command + " run " + quoted(cell) + " --fast --json");
  EXPECT_EQ(run.exit_code, 0) << run.output;
  EXPECT_NE(run.output.find("MyArm with 2 joints, pretended"), std::string::npos) << run.output;
  EXPECT_EQ(run.output.find("simulated by"), std::string::npos) << run.output;
  const Shell listed = shell(command + " plugins " + quoted(cell) + " --json");
  EXPECT_EQ(listed.exit_code, 0) << listed.output;
  const auto plugins = nlohmann::json::parse(listed.output)["plugins"];
  ASSERT_EQ(plugins.size(), 2u) << listed.output;
  EXPECT_EQ(plugins[0]["entries"][0]["name"], "follow_me/FollowMe");
  EXPECT_EQ(plugins[1]["entries"][0]["name"], "acme/MyArm");
}

TEST(New, NeverWritesOverAnything) {
  const test::Folder place;
  place.write("notes.txt", "mine");
  const auto refused = test::run_command({"new", "hardware", "arm", "--folder", place.path()});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.output.find("nothing was written"), std::string::npos) << refused.output;
  EXPECT_EQ(std::distance(fs::directory_iterator(place.path()), {}), 1);
  EXPECT_EQ(read_file(place.path() / "notes.txt"), "mine");
}

TEST(New, RefusesNamesThatWouldNotCompile) {
  const test::Folder place;
  for (const char* name : {"7up", "my-arm", "test", "../arm", "Ärm", "a__b"}) {
    const auto refused =
        test::run_command({"new", "controller", name, "--folder", (place.path() / "new").string()});
    EXPECT_EQ(refused.exit_code, 1) << name;
    EXPECT_NE(refused.output.find("cannot be the name"), std::string::npos) << refused.output;
  }
  EXPECT_FALSE(fs::exists(place.path() / "new"));
}

TEST(PluginsVerb, ListsWhatWasFoundAndWhatWasRefusedAndWhy) {
  const std::string at = POLYARM_TEST_PLUGINS;
  const auto listed =
      test::run_command({"plugins", "--plugins", at + "/both", "--plugins", at + "/newer_minor", "--json"});
  EXPECT_EQ(listed.exit_code, 1);
  const auto told = nlohmann::json::parse(listed.output);
  EXPECT_EQ(told["plugins"][0]["name"], "both");
  EXPECT_EQ(told["plugins"][0]["entries"][1]["kind"], "controller");
  EXPECT_EQ(told["refused"][0]["file"], at + "/newer_minor/newer_minor.so");
  EXPECT_NE(told["refused"][0]["reason"].get<std::string>().find("1.1"), std::string::npos);
}

TEST(PluginsVerb, LooksWherePolyarmPluginsSaysAndNotInTheWorkingDirectory) {
  const std::string at = POLYARM_TEST_PLUGINS;
  const auto count = [](const Shell& done) { return nlohmann::json::parse(done.output)["plugins"].size(); };
  EXPECT_EQ(count(shell("cd '" + at + "/both' && '" POLYARM_COMMAND "' plugins --json")), 0u);
  EXPECT_EQ(count(shell("cd / && POLYARM_PLUGINS='" + at +
                        "/both::/no/such' '" POLYARM_COMMAND "' plugins --json")),
            1u);
}

}  // namespace
}  // namespace polyarm
