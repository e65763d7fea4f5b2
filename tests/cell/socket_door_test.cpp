#include "polyarm/cell/socket_door.hpp"

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <set>
#include <thread>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/realtime/periodic.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm {
namespace {

using cell::SocketDoor;
using test::Json;

/// The far side: a plain client of the socket.
class Peer {
 public:
  explicit Peer(const std::filesystem::path& path) : fd_(::socket(AF_UNIX, SOCK_STREAM, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
    connected = ::connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  }
  ~Peer() { ::close(fd_); }
  bool connected = false;

  /// False when the other side has closed.
  bool say(const std::string& text) {
    for (std::size_t sent = 0; sent < text.size();) {
      const ssize_t n = ::send(fd_, text.data() + sent, text.size() - sent, MSG_NOSIGNAL);
      if (n <= 0) return false;
      sent += static_cast<std::size_t>(n);
    }
    return true;
  }
  void end() { ::shutdown(fd_, SHUT_WR); }
  int fd() const { return fd_; }
  /// Takes what is there now; false at the end.
  bool listen(int wait_limit_ms = 1) {
    pollfd waiting{fd_, POLLIN, 0};
    if (::poll(&waiting, 1, wait_limit_ms) <= 0) return true;
    char buffer[65536];
    const ssize_t n = ::recv(fd_, buffer, sizeof buffer, 0);
    if (n > 0) {
      heard_.append(buffer, static_cast<std::size_t>(n));
      lines_ += static_cast<std::size_t>(std::count(buffer, buffer + n, '\n'));
    }
    return n > 0;
  }
  std::size_t lines() const { return lines_; }
  Json line(std::size_t i) const {
    std::size_t begin = 0;
    for (; i > 0; --i) begin = heard_.find('\n', begin) + 1;
    return Json::parse(heard_.substr(begin, heard_.find('\n', begin) - begin), nullptr, false);
  }

 private:
  int fd_;
  std::size_t lines_ = 0;
  std::string heard_;
};

class SocketDoorTest : public ::testing::Test {
 protected:
  SocketDoorTest() { door = std::make_unique<SocketDoor>("bench", where()); }
  std::filesystem::path where() const { return folder.path() / "polyarm"; }
  /// Ticks the cell until `done`, at most a million times.
  template <typename Done>
  bool until(Done done) {
    for (int ticks = 0; ticks < 1'000'000; ++ticks) {
      std::this_thread::yield();  // the door has a thread of its own
      door->serve(cell.cell().requests());
      cell.tick();
      if (done()) return true;
    }
    return false;
  }
  bool hears(Peer& peer, std::size_t lines) {
    return until([&] {
      peer.listen();
      return peer.lines() >= lines;
    });
  }
  bool is_released(Peer& peer) {
    return until([&] { return !peer.listen(); });
  }

  test::Folder folder;
  test::LockStepCell cell{"controller_manager: {ros__parameters: {update_rate: 1000}}"};
  std::unique_ptr<SocketDoor> door;
};

TEST_F(SocketDoorTest, BelongsToItsUserAlone) {
  EXPECT_EQ(door->path(), where() / "bench.sock");
  struct stat status {};
  ASSERT_EQ(::stat(door->path().c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0600u);
  ASSERT_EQ(::stat(where().c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0700u);
}

TEST_F(SocketDoorTest, RefusesAFolderThatOthersCanReach) {
  const std::filesystem::path open = folder.path() / "open";
  ::mkdir(open.c_str(), 0755);
  ::chmod(open.c_str(), 0755);
  EXPECT_THROW(SocketDoor("bench", open), Error);
  std::filesystem::create_directory_symlink(where(), folder.path() / "link");
  EXPECT_THROW(SocketDoor("bench", folder.path() / "link"), Error);
}

TEST_F(SocketDoorTest, TwoCellsOfOneNameGetTwoSockets) {
  const SocketDoor second("bench", where()), third("bench", where());
  EXPECT_EQ(second.path().filename(), "bench-2.sock");
  EXPECT_EQ(third.path().filename(), "bench-3.sock");
}

TEST_F(SocketDoorTest, ManyThatOpenAtOnceNeverShareASocket) {
  std::vector<std::unique_ptr<SocketDoor>> doors(12);
  std::vector<std::thread> threads;
  for (auto& mine : doors)
    threads.emplace_back([&mine, this] { mine = std::make_unique<SocketDoor>("crowd", where()); });
  for (std::thread& thread : threads) thread.join();
  std::set<std::string> paths;
  for (const auto& mine : doors) paths.insert(mine->path());
  EXPECT_EQ(paths.size(), doors.size());
  for (const std::string& path : paths) EXPECT_TRUE(Peer(path).connected) << path;
}

TEST_F(SocketDoorTest, ReplacesWhatAKilledCellLeft) {
  const std::filesystem::path stale = where() / "stale.sock";
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, stale.c_str(), sizeof address.sun_path - 1);
  const int fd = ::socket(AF_UNIX, SOCK_STREAM, 0);
  ASSERT_EQ(::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  ::close(fd);  // bound, and nobody listens any more
  ASSERT_TRUE(std::filesystem::exists(stale));
  const SocketDoor again("stale", where());
  EXPECT_EQ(again.path(), stale);
  EXPECT_TRUE(Peer(stale).connected);
}

TEST_F(SocketDoorTest, LeavesNothingBehindButNotAnothersSocket) {
  const std::filesystem::path path = door->path();
  std::filesystem::remove(path);
  const SocketDoor other("bench", where());  // somebody took the name
  ASSERT_EQ(other.path(), path);
  door.reset();
  EXPECT_TRUE(std::filesystem::exists(path)) << "it is the other's";
  EXPECT_TRUE(Peer(path).connected);
}

TEST_F(SocketDoorTest, NamesBecomeFileNames) {
  EXPECT_EQ(SocketDoor("my cell/../x", where()).path().filename(), "my_cell____x.sock");
  EXPECT_EQ(SocketDoor("", where()).path().filename(), "cell.sock");
  EXPECT_LT(SocketDoor(std::string(5000, 'n'), where()).path().filename().string().size(), 80u);
  EXPECT_THROW(SocketDoor("x", folder.path() / std::string(120, 'd')), Error) << "too long for a socket";
}

TEST_F(SocketDoorTest, AnswersEveryLineInOrder) {
  Peer peer(door->path());
  ASSERT_TRUE(peer.connected);
  std::string all;
  for (int i = 0; i < 500; ++i) all += R"({"request":"health","id":)" + std::to_string(i) + "}\n";
  ASSERT_TRUE(peer.say(all));
  ASSERT_TRUE(hears(peer, 500));
  for (int i = 0; i < 500; ++i) EXPECT_EQ(peer.line(static_cast<std::size_t>(i))["id"], i);
}

TEST_F(SocketDoorTest, StopsByTheThousandKeepTheCellForNoTick) {
  Peer peer(door->path());
  std::string all;
  for (int i = 0; i < 5000; ++i) all += "{\"request\":\"control.hold\"}\n";
  std::thread talker([&] { peer.say(all); });
  for (std::size_t serves = 1; peer.lines() < 5000 && serves < 1'000'000; ++serves) {
    std::this_thread::yield();
    door->serve(cell.cell().requests());
    peer.listen(0);
    ASSERT_LE(peer.lines(), serves * (bounds::kUrgentLines + bounds::kSocketLinesATick));
  }
  talker.join();
  EXPECT_EQ(peer.lines(), 5000u) << "each is answered";
}

TEST_F(SocketDoorTest, ALineMayComeInPieces) {
  Peer peer(door->path());
  for (const char c : std::string("\n\n{\"request\":\"control.types\"}\n")) {
    ASSERT_TRUE(peer.say(std::string(1, c)));
    door->serve(cell.cell().requests());
  }
  ASSERT_TRUE(hears(peer, 1));
  EXPECT_TRUE(peer.line(0)["ok"].get<bool>());
  EXPECT_EQ(peer.lines(), 1u) << "empty lines are no requests";
}

TEST_F(SocketDoorTest, WhoHasSaidAllIsAnsweredAndThenLetGo) {
  Peer peer(door->path());
  peer.say("{\"request\":\"control.switch\",\"deactivate\":\"joint_trajectory_controller\"}\n");
  peer.end();
  ASSERT_TRUE(is_released(peer));
  ASSERT_EQ(peer.lines(), 1u);
  EXPECT_TRUE(peer.line(0)["ok"].get<bool>()) << peer.line(0);
}

TEST_F(SocketDoorTest, WhoLeavesEndsItsWatch) {
  {
    Peer peer(door->path());
    peer.say("{\"request\":\"watch\",\"name\":\"joint_states\",\"rate\":500}\n");
    ASSERT_TRUE(hears(peer, 3));
    EXPECT_EQ(cell.cell().requests().open(), 1u);
  }
  EXPECT_TRUE(until([&] { return cell.cell().requests().open() == 0; }));
}

TEST_F(SocketDoorTest, ALineWithoutEndIsCutOff) {
  Peer peer(door->path());
  std::thread talker([&] { peer.say(std::string(3 << 20, 'x')); });
  EXPECT_TRUE(is_released(peer));
  talker.join();
  EXPECT_EQ(peer.lines() ? peer.line(0)["error"]["code"] : Json("too-long"), "too-long");
}

TEST_F(SocketDoorTest, WhatIsTooLongIsRefusedWithItsId) {
  const std::string room(2 << 20, 'x');
  for (const std::string begin :
       {R"({"id":7,"request":"health","x":")", R"({"a":{"id":1},"id":"seven","x":")", R"({"x":")", "x"}) {
    Peer peer(door->path());
    std::thread talker([&] { peer.say(begin + room + "\"}\n"); });
    EXPECT_TRUE(is_released(peer));
    talker.join();
    if (!peer.lines()) continue;  // the end came before the answer could be read
    const Json id = begin.find("seven") != std::string::npos ? Json("seven")
                    : begin.find("id") != std::string::npos  ? Json(7)
                                                             : Json();
    EXPECT_EQ(peer.line(0)["error"]["code"], "too-long");
    EXPECT_EQ(peer.line(0).value("id", Json()), id) << begin;
  }
}

TEST_F(SocketDoorTest, AMegabyteInOneLineIsCarried) {
  Peer peer(door->path());
  const std::string room(1'000'000, ' ');
  std::thread talker([&] { peer.say("{\"request\":\"health\"," + room + "\"id\":7}\n"); });
  EXPECT_TRUE(hears(peer, 1));
  talker.join();
  EXPECT_EQ(peer.line(0)["id"], 7);
}

TEST_F(SocketDoorTest, WhoNeverReadsIsDroppedAndOthersAreServed) {
  Peer deaf(door->path()), other(door->path());
  other.say("{\"request\":\"help\"}\n");
  ASSERT_TRUE(hears(other, 1));
  const std::size_t answer = other.line(0).dump().size();
  std::string lines;  // what they are answered with is more than may be unread, here and in the system
  for (std::size_t bytes = 0; bytes < bounds::kSocketUnreadBytes + (4 << 20); bytes += answer)
    lines += "{\"request\":\"help\"}\n";
  std::atomic<bool> said{false};
  std::thread talker([&] {
    deaf.say(lines);
    said = true;
  });
  for (std::size_t i = 2; i <= 40; ++i) {
    other.say("{\"request\":\"health\"}\n");
    EXPECT_TRUE(hears(other, i));
  }
  EXPECT_TRUE(until([&] { return said.load(); }));
  talker.join();
  EXPECT_TRUE(until([&] { return !deaf.say("\n"); }));
  EXPECT_EQ(other.lines(), 40u);
}

TEST_F(SocketDoorTest, AFloodIsHeldBackNotSwallowed) {
  constexpr std::size_t kFlood = 5000;
  Peer flood(door->path());
  std::string lines;
  for (std::size_t i = 0; i < kFlood; ++i)
    lines += "{\"request\":\"control.chains\",\"id\":" + std::to_string(i) + "}\n";
  std::thread talker([&] { flood.say(lines); });
  EXPECT_TRUE(hears(flood, kFlood));
  talker.join();
  EXPECT_EQ(flood.line(kFlood - 1)["id"], kFlood - 1);
}

TEST_F(SocketDoorTest, MoreClientsThanItTakesAreTurnedAway) {
  std::vector<std::unique_ptr<Peer>> peers;
  for (int i = 0; i < 80; ++i) peers.push_back(std::make_unique<Peer>(door->path()));
  int answered = 0;
  for (auto& peer : peers) peer->say("{\"request\":\"control.chains\"}\n");
  until([&] {
    answered = 0;
    for (auto& peer : peers) {
      peer->listen(0);
      answered += peer->lines() > 0 ? 1 : 0;
    }
    return answered >= 64;
  });
  EXPECT_EQ(answered, 64);
  peers.clear();
  EXPECT_TRUE(until([&] {
    Peer fresh(door->path());
    fresh.say("{\"request\":\"control.chains\"}\n");
    for (int n = 0; n < 20 && fresh.lines() == 0; ++n) {
      door->serve(cell.cell().requests());
      if (!fresh.listen(5)) break;
    }
    return fresh.lines() > 0;
  })) << "places that are free again are given away again";
}

TEST_F(SocketDoorTest, OpenRequestsOutliveTheDoorWithoutHarm) {
  Peer peer(door->path());
  peer.say("{\"request\":\"watch\",\"name\":\"joint_states\"}\n");
  ASSERT_TRUE(hears(peer, 1));
  door.reset();
  cell.run(0.5);
  EXPECT_EQ(cell.cell().requests().open(), 0u);
}

/// One ring, one look, and no tick: a request does not wait for the time.
TEST_F(SocketDoorTest, ALineRingsTheBellAndIsAnsweredWithoutATick) {
  const auto bell = std::make_shared<realtime::Bell>();
  door->set_wakeup(bell);
  Peer peer(door->path());
  for (std::size_t i = 1; i <= 20; ++i) {
    ASSERT_TRUE(peer.say("{\"request\":\"control.chains\"}\n"));
    ASSERT_TRUE(bell->wait_until(realtime::monotonic_now() + 60'000'000'000)) << "nobody rang";
    door->serve(cell.cell().requests());
    for (int n = 0; n < 60 && peer.lines() < i; ++n) peer.listen(1000);
    ASSERT_EQ(peer.lines(), i);
  }
  door->set_wakeup(nullptr);
  ASSERT_TRUE(peer.say("{\"request\":\"control.chains\"}\n"));
  EXPECT_TRUE(hears(peer, 21));
  EXPECT_FALSE(bell->wait_until(0)) << "it is rung no more";
}

}  // namespace
}  // namespace polyarm
