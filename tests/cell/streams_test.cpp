#include "polyarm/io/streams.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <unistd.h>

#include <string>

#include "polyarm/base/error.hpp"
#include "polyarm/yaml/yaml.hpp"

namespace polyarm::cell {
namespace {

sockaddr_in loopback(int port) {
  sockaddr_in out{};
  out.sin_family = AF_INET;
  out.sin_port = htons(static_cast<std::uint16_t>(port));
  out.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return out;
}

/// A socket that listens on loopback at a free port.
struct Server {
  int file = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0), client = -1;
  int port = 0;
  Server() {
    sockaddr_in address = loopback(0);
    socklen_t size = sizeof address;
    EXPECT_EQ(bind(file, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    EXPECT_EQ(listen(file, 1), 0);
    EXPECT_EQ(getsockname(file, reinterpret_cast<sockaddr*>(&address), &size), 0);
    port = ntohs(address.sin_port);
  }
  ~Server() { close(file), end_client(); }
  void end_client() {
    if (client >= 0) close(std::exchange(client, -1));
  }
  void accept_one() { client = accept(file, nullptr, nullptr); }
};

/// Ticks until it is so; the machine may be busy.
template <typename So>
bool comes(Stream& stream, So so) {
  static long long now = 0;
  for (int i = 0; i < 20000; ++i) {
    stream.tick(now += 1'000'000);
    if (so()) return true;
    usleep(200);
  }
  return false;
}
void write_all(int file, const std::string& text) {
  ASSERT_EQ(::send(file, text.data(), text.size(), MSG_NOSIGNAL), static_cast<ssize_t>(text.size()));
}

StreamEntry client_of(int port) {
  StreamEntry out;
  out.name = "scanner";
  out.port = port;
  return out;
}

TEST(Streams, AClientReceivesLinesAndSends) {
  Server server;
  Stream stream(client_of(server.port));
  ASSERT_TRUE(comes(stream, [&] { return stream.connected(); }));
  server.accept_one();
  write_all(server.client, "12;ok\r\nsec");
  ASSERT_TRUE(comes(stream, [&] { return stream.has_line(); }));
  write_all(server.client, "ond\n");
  EXPECT_EQ(stream.next_line(), "12;ok");
  ASSERT_TRUE(comes(stream, [&] { return stream.has_line(); }));
  EXPECT_EQ(stream.next_line(), "second");
  EXPECT_EQ(stream.next_line(), "");
  stream.send("TRIGGER\n");
  char got[16] = {};
  EXPECT_EQ(recv(server.client, got, sizeof got, 0), 8);
  EXPECT_EQ(std::string(got), "TRIGGER\n");
}

TEST(Streams, AClientConnectsAgain) {
  Server server;
  Stream stream(client_of(server.port));
  ASSERT_TRUE(comes(stream, [&] { return stream.connected(); }));
  server.accept_one();
  server.end_client();
  ASSERT_TRUE(comes(stream, [&] { return !stream.connected(); }));
  EXPECT_THROW(stream.send("x"), Error);
  ASSERT_TRUE(comes(stream, [&] { return stream.connected(); }));
}

TEST(Streams, AServerHasOneClient) {
  StreamEntry entry = client_of(0);
  entry.kind = StreamEntry::Kind::listen;
  Stream stream(entry);
  stream.tick(0);
  for (const char* text : {"first\n", "second\n"}) {
    const int client = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const sockaddr_in address = loopback(stream.port());
    ASSERT_EQ(connect(client, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    write_all(client, text);
    ASSERT_TRUE(comes(stream, [&] { return stream.has_line(); }));
    EXPECT_EQ(stream.next_line() + "\n", text);
    close(client);
  }
}

TEST(Streams, LongLinesAndManyLinesAreDropped) {
  Server server;
  Stream stream(client_of(server.port));
  ASSERT_TRUE(comes(stream, [&] { return stream.connected(); }));
  server.accept_one();
  write_all(server.client, std::string(40'000, 'a'));
  for (int i = 0; i < 3; ++i) {
    comes(stream, [] { return true; });
    write_all(server.client, std::string(40'000, 'a'));
  }
  write_all(server.client, "\nshort\n");
  ASSERT_TRUE(comes(stream, [&] { return stream.has_line(); }));
  EXPECT_EQ(stream.next_line(), "short");
  EXPECT_EQ(stream.dropped(), 1u);
  std::string many;
  for (std::size_t i = 0; i < Stream::kMostLines + 5; ++i) many += std::to_string(i) + "\n";
  write_all(server.client, many);
  ASSERT_TRUE(comes(stream, [&] { return stream.dropped() == 6; }));
  EXPECT_EQ(stream.next_line(), "5");
}

TEST(Streams, AStreamThatCannotOpenFailsItsProgramButNotTheCell) {
  Server taken;
  StreamEntry entry = client_of(taken.port);
  entry.kind = StreamEntry::Kind::listen;
  Streams streams({entry}, {true, false});
  constexpr long long kSecond = 1'000'000'000;
  EXPECT_THROW(streams.used("scanner", kSecond), Error);
  EXPECT_NO_THROW(streams.tick(2 * kSecond));
  EXPECT_FALSE(streams.used("scanner", 2 * kSecond).connected());
}

TEST(Streams, EntriesAreChecked) {
  const auto refusal = [](const std::string& text) {
    Problems problems;
    read_streams(Yaml::parse("streams:\n" + text, "cell.yaml")["streams"], problems);
    return problems.list().empty() ? std::string{} : problems.list().front().what;
  };
  EXPECT_EQ(refusal("  s: {connect: \"127.0.0.1:2000\"}"), "");
  EXPECT_EQ(refusal("  s: {listen: 2000, ends_with: \"\\r\"}"), "");
  EXPECT_EQ(refusal("  s: {connect: \"camera:2000\"}"), "'camera' is no IPv4 address");
  EXPECT_EQ(refusal("  s: {connect: \"127.0.0.1:70000\"}"), "'127.0.0.1:70000' has no port from 1 to 65535");
  EXPECT_EQ(refusal("  s: {baud: 9600}"), "the stream 's' needs one of connect, listen and device");
}

TEST(Streams, NothingOpensInLockStepAndDevicesOnlyForReal) {
  StreamEntry device = client_of(1);
  device.kind = StreamEntry::Kind::device;
  device.device = "/dev/null";
  Streams closed({client_of(1)}, {false, false});
  EXPECT_THROW(closed.used("scanner", 0), Error);
  Streams unreal({device}, {true, false});
  EXPECT_THROW(unreal.used("scanner", 0), Error);
  EXPECT_THROW(unreal.used("scaner", 0), Error);
  EXPECT_FALSE(closed.is_connected("scanner", 0)) << "a program that asks goes on";
  EXPECT_FALSE(unreal.is_connected("scanner", 0));
  EXPECT_THROW(closed.is_connected("scaner", 0), Error);
}

}  // namespace
}  // namespace polyarm::cell
