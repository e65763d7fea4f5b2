#include "polyarm/process/confinement.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <thread>

namespace polyarm::process {
namespace {

constexpr int kNotHere = 77;

/// What a process comes to that does `act` after `prepare`: 0 if it was true.
int in_child(const std::function<bool()>& prepare, const std::function<bool()>& act) {
  const pid_t child = ::fork();
  if (child == 0) {
    ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
    if (!prepare()) ::_exit(kNotHere);
    ::_exit(act() ? 0 : 1);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

bool refused(long result, int error = EPERM) {
  return result < 0 && errno == error;
}

class FilteredCalls : public ::testing::Test {
 protected:
  void SetUp() override {
    if (in_child([] { return filter_calls(); }, [] { return true; }) == kNotHere) GTEST_SKIP() << "the system has no filters";
  }
  static bool holds(const std::function<bool()>& act) { return in_child([] { return filter_calls(); }, act) == 0; }
};

TEST_F(FilteredCalls, NoProgramIsStartedAndNoProcessMade) {
  EXPECT_TRUE(holds([] { return refused(::execl("/bin/true", "true", nullptr)); }));
  EXPECT_TRUE(holds([] { return refused(::fork()); }));
  EXPECT_TRUE(holds([] { return refused(::syscall(SYS_clone, SIGCHLD, 0, 0, 0, 0)); }));
}

TEST_F(FilteredCalls, NoOtherProcessIsReached) {
  EXPECT_TRUE(holds([] { return refused(::kill(::getppid(), 0)); }));
  EXPECT_TRUE(holds([] { return refused(::kill(::getppid(), SIGKILL)); }));
  EXPECT_TRUE(holds([] { return refused(::kill(-1, 0)); }));
  EXPECT_TRUE(holds([] { return refused(::syscall(SYS_tgkill, ::getppid(), ::getppid(), SIGKILL)); }));
  EXPECT_TRUE(holds([] { return refused(::syscall(SYS_ptrace, 16, ::getppid(), 0, 0)); }));
  EXPECT_TRUE(holds([] {
    const rlimit none{0, 0};
    return refused(::prlimit(::getppid(), RLIMIT_CPU, &none, nullptr));
  }));
  EXPECT_TRUE(holds([] { return refused(::setpriority(PRIO_PROCESS, static_cast<id_t>(::getppid()), 19)); }));
}

TEST_F(FilteredCalls, NoFileIsWritten) {
  EXPECT_TRUE(holds([] { return refused(::open("/tmp/polyarm-never", O_WRONLY | O_CREAT, 0600), EACCES); }));
  EXPECT_TRUE(holds([] { return refused(::open("/dev/null", O_RDWR), EACCES); }));
  EXPECT_TRUE(holds([] { return refused(::mkdir("/tmp/polyarm-never", 0700)); }));
  EXPECT_TRUE(holds([] { return refused(::unlink("/tmp/polyarm-never")); }));
  EXPECT_TRUE(holds([] { return refused(::rename("/tmp/polyarm-never", "/tmp/polyarm-nor-this")); }));
}

TEST_F(FilteredCalls, NoSocketOfThisMachineIsReached) {
  EXPECT_TRUE(holds([] { return refused(::socket(AF_UNIX, SOCK_STREAM, 0)); }));
  EXPECT_EQ(in_child([] { return filter_calls(true); }, [] { return ::socket(AF_UNIX, SOCK_STREAM, 0) >= 0; }), 0);
}

TEST_F(FilteredCalls, WhatParsesAndTalksGoesOn) {
  EXPECT_TRUE(holds([] { return ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0) >= 0; }));
  EXPECT_TRUE(holds([] { return ::open("/etc/hosts", O_RDONLY | O_CLOEXEC) >= 0; }));
  EXPECT_TRUE(holds([] {
    int ran = 0;
    std::thread([&] { ran = 1; }).join();
    return ran == 1;
  }));
  EXPECT_TRUE(holds([] {
    const std::vector<char> room(64 << 20, 1);
    return room.back() == 1;
  }));
  EXPECT_EQ(in_child([] { return filter_calls(); },
                     [] {
                       std::abort();
                       return true;
                     }),
            128 + SIGABRT)
      << "how it ends can still be told";
}

class Confined : public ::testing::Test {
 protected:
  void SetUp() override {
    if (in_child([] { return confine({}); }, [] { return true; }) == kNotHere)
      GTEST_SKIP() << "the kernel has no Landlock";
    std::filesystem::create_directories(folder_);
    std::ofstream(mine_) << "x";
    std::ofstream(other_) << "x";
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  const std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("polyarm_confined_" + std::to_string(::getpid()));
  const std::filesystem::path mine_ = folder_ / "ca.pem", other_ = folder_ / "token";
};

TEST_F(Confined, OnlyFilesOfTheSystemAndThoseNamedAreRead) {
  const auto opens = [&](const std::filesystem::path& file) {
    return in_child([&] { return confine({{mine_.string()}, {}, {}}); },
                    [&] { return ::open(file.c_str(), O_RDONLY | O_CLOEXEC) >= 0; }) == 0;
  };
  EXPECT_TRUE(opens(mine_));
  EXPECT_TRUE(opens("/etc/hosts"));
  EXPECT_FALSE(opens(other_));
  EXPECT_FALSE(opens("/proc/" + std::to_string(::getpid()) + "/environ")) << "of the cell";
  EXPECT_FALSE(in_child([&] { return confine({{mine_.string()}, {}, {}}); },
                        [&] { return ::open(mine_.c_str(), O_WRONLY | O_CLOEXEC) >= 0; }) == 0);
}

TEST_F(Confined, OnlyPortsThatAreNamedAreReached) {
  const int listening = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof address;
  ASSERT_EQ(::bind(listening, reinterpret_cast<sockaddr*>(&address), length), 0);
  ASSERT_EQ(::listen(listening, 4), 0);
  ASSERT_EQ(::getsockname(listening, reinterpret_cast<sockaddr*>(&address), &length), 0);
  const std::uint16_t port = ntohs(address.sin_port);
  const auto connects = [&](std::vector<std::uint16_t> allowed) {
    return in_child([&] { return confine({{}, allowed, {}}); },
                    [&] {
                      const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
                      return ::connect(fd, reinterpret_cast<const sockaddr*>(&address), length) == 0;
                    }) == 0;
  };
  EXPECT_TRUE(connects({port}));
  const bool other = connects({static_cast<std::uint16_t>(port == 80 ? 81 : 80)});
  ::close(listening);
  if (other) GTEST_SKIP() << "the kernel does not look at ports";
  EXPECT_FALSE(other);
}

}  // namespace
}  // namespace polyarm::process
