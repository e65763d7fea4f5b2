#include "polyarm/hardware/device_lock.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>

#include "polyarm/base/error.hpp"

namespace polyarm::hardware {
namespace {

std::string device(const char* name) {
  return std::string("test-") + name + "-" + std::to_string(getpid());
}

std::string refusal(const std::string& name) {
  try {
    const DeviceLock second(name, "the second");
    return {};
  } catch (const Error& e) {
    EXPECT_EQ(e.problems().at(0).code, "device-in-use");
    return e.what();
  }
}

TEST(DeviceLock, ASecondHolderIsToldWhoHasIt) {
  const std::string name = device("bus");
  const DeviceLock first(name, "the cell lab, component wheels");
  EXPECT_TRUE(first.held());
  const std::string said = refusal(name);
  EXPECT_NE(said.find("the cell lab, component wheels (process " + std::to_string(getpid())),
            std::string::npos)
      << said;
  EXPECT_NE(said.find(name), std::string::npos);
}

TEST(DeviceLock, IsFreeAgainWhenItsHolderIsGone) {
  const std::string name = device("gone");
  { const DeviceLock first(name, "the first"); }
  EXPECT_EQ(refusal(name), "");
}

TEST(DeviceLock, AKilledHolderLetsGo) {
  const std::string name = device("killed");
  int pipe_ends[2];
  ASSERT_EQ(pipe(pipe_ends), 0);
  const pid_t child = fork();
  if (child == 0) {
    const DeviceLock held(name, "the child");
    const char ready = 1;
    if (write(pipe_ends[1], &ready, 1) != 1) _exit(1);
    pause();
  }
  char ready = 0;
  ASSERT_EQ(read(pipe_ends[0], &ready, 1), 1);
  EXPECT_NE(refusal(name).find("the child"), std::string::npos);
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  EXPECT_EQ(refusal(name), "");
  close(pipe_ends[0]);
  close(pipe_ends[1]);
}

TEST(DeviceLock, TwoNamesOfOneDeviceMeet) {
  const auto link = std::filesystem::temp_directory_path() / device("link");
  std::filesystem::create_symlink("/dev/null", link);
  {
    const DeviceLock first("/dev/null", "the first");
    EXPECT_NE(refusal(link.string()).find("the first"), std::string::npos);
  }
  std::filesystem::remove(link);
}

TEST(DeviceLock, ItsHolderIsSeenWithoutTouchingIt) {
  const std::string name = device("seen");
  EXPECT_EQ(DeviceLock::holder(name), "");
  {
    const DeviceLock first(name, "the first");
    EXPECT_EQ(DeviceLock::holder(name), "the first (process " + std::to_string(getpid()) + ")");
    EXPECT_NE(refusal(name), "") << "it is held still";
  }
  EXPECT_EQ(DeviceLock::holder(name), "") << "the name that is left behind holds nothing";
}

TEST(DeviceLock, MovesWithItsHolder) {
  const std::string name = device("moved");
  DeviceLock kept;
  {
    DeviceLock first(name, "the first");
    kept = std::move(first);
  }
  EXPECT_NE(refusal(name), "");
}

}  // namespace
}  // namespace polyarm::hardware
