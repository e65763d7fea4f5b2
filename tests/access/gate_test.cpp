#include "polyarm/access/gate.hpp"

#include <gtest/gtest.h>

#include <random>

#include "polyarm/access/token.hpp"

namespace polyarm::server {
namespace {

GateRules gate_rules() {
  GateRules out;
  out.token = "the-token";
  out.cookie = "polyarm_token_1";
  return out;
}

Head head(const std::string& host, const std::string& origin = "", const std::string& cookie = "",
          const std::string& target = "/ws") {
  Head out;
  out.method = "GET";
  out.target = target;
  out.host = host;
  out.origin = origin;
  out.cookie = cookie;
  return out;
}

TEST(GateTest, OnLoopbackOnlyNamesOfThisMachineItselfAreServed) {
  for (const char* host :
       {"localhost", "localhost:8765", "LOCALHOST:1", "127.0.0.1:8765", "127.1.2.3", "[::1]:80"})
    EXPECT_TRUE(host_allowed(host, gate_rules())) << host;
  for (const char* host : {"", "evil.example", "localhost.evil.example", "192.168.1.7:8765",
                           "127.0.0.1.evil.example", "127.0.0", "127.0.0.256", "localhost:", "localhost:x",
                           "localhost:123456", "[::1", "[::1]x", "[fe80::1]", "localhost:80:80"})
    EXPECT_FALSE(host_allowed(host, gate_rules())) << host;
}

TEST(GateTest, BeyondLoopbackAddressesAndOwnNamesAreServedButNoOtherName) {
  GateRules open = gate_rules();
  open.loopback = false;
  open.names = {"bench", "bench.local"};
  for (const char* host : {"192.168.1.7:8765", "bench:8765", "Bench.local", "[fe80::1]:8765", "localhost"})
    EXPECT_TRUE(host_allowed(host, open)) << host;
  for (const char* host : {"evil.example", "bench.evil.example", "1.2.3", "[fe80::z]"})
    EXPECT_FALSE(host_allowed(host, open)) << host;
}

TEST(GateTest, APageFromElsewhereIsNotLetInWhateverItCarries) {
  const std::string cookie = "polyarm_token_1=the-token";
  EXPECT_EQ(judge(head("localhost:1", "http://localhost:1", cookie), gate_rules(), true).status, 200);
  EXPECT_EQ(judge(head("localhost:1", "http://localhost:2", cookie), gate_rules(), true).status, 403);
  EXPECT_EQ(judge(head("localhost:1", "https://localhost:1", cookie), gate_rules(), true).status, 403);
  EXPECT_EQ(judge(head("localhost:1", "null", cookie), gate_rules(), true).status, 403);
  EXPECT_EQ(
      judge(head("localhost:1", "http://evil.example", cookie, "/ws?token=the-token"), gate_rules(), true)
          .status,
      403);
  EXPECT_EQ(judge(head("evil.example", "http://evil.example", cookie), gate_rules(), true).status, 421);
  Head sneaky = head("localhost:1", "", cookie, "/api/cell");
  sneaky.fetch_site = "cross-site";
  EXPECT_EQ(judge(sneaky, gate_rules(), false).status, 403);
  sneaky.fetch_site = "same-origin";
  EXPECT_EQ(judge(sneaky, gate_rules(), false).status, 200);
}

TEST(GateTest, ACookieAloneDoesNotOpenASocketWithoutItsOrigin) {
  EXPECT_EQ(judge(head("localhost:1", "", "polyarm_token_1=the-token"), gate_rules(), true).status, 403);
  EXPECT_EQ(judge(head("localhost:1", "", "polyarm_token_1=the-token"), gate_rules(), false).status, 200);
  EXPECT_EQ(judge(head("localhost:1", "", "", "/ws?token=the-token"), gate_rules(), true).status, 200);
  Head program = head("localhost:1");
  program.authorization = "Bearer the-token";
  EXPECT_EQ(judge(program, gate_rules(), true).status, 200);
}

TEST(GateTest, TheTokenIsNeededWholeAndWhereItBelongs) {
  EXPECT_EQ(judge(head("localhost"), gate_rules(), false).status, 401);
  EXPECT_EQ(judge(head("localhost", "", "polyarm_token_1=the-toke"), gate_rules(), false).status, 403);
  EXPECT_EQ(judge(head("localhost", "", "polyarm_token_1=the-token2"), gate_rules(), false).status, 403);
  EXPECT_EQ(judge(head("localhost", "", "other=the-token"), gate_rules(), false).status, 401);
  EXPECT_EQ(judge(head("localhost", "", "a=b; polyarm_token_1=the-token; c=d"), gate_rules(), false).status,
            200);
  EXPECT_EQ(judge(head("localhost", "", "xpolyarm_token_1=the-token"), gate_rules(), false).status, 401);
}

TEST(GateTest, APathNeverLeadsOutOfWhatIsServed) {
  EXPECT_EQ(path_of("/a/b.js?x=/../y"), "/a/b.js");
  EXPECT_EQ(path_of("/a%20b"), "/a b");
  for (const char* target : {"", "a", "/../x", "/a/../../x", "/..", "/%2e%2e/x", "/a/%2E%2E", "/a\\b",
                             "/a%5c..%5cb", "/a%00b", "/a%2", "/a%zz", "http://x/y", "*"})
    EXPECT_EQ(path_of(target), "") << target;
  EXPECT_EQ(path_of("/a/..b/c.."), "/a/..b/c..") << "these are names";
}

TEST(GateTest, WhateverComesIsAnsweredAndLeadsNowhere) {
  std::mt19937 random(7);
  const std::string pieces[] = {"/", "..",        "%2e",       "%2E",  "%",    "%0",  "?", "=",
                                "&", "#",         "token",     "\\",   ";",    " ",   ":", "[",
                                "]", "127.0.0.1", "localhost", "\x01", "\xff", "%00", "a"};
  for (int n = 0; n < 20'000; ++n) {
    std::string text = random() % 2 ? "/" : "";
    for (unsigned i = random() % 12; i > 0; --i)
      text +=
          random() % 4 ? pieces[random() % std::size(pieces)] : std::string(1, static_cast<char>(random()));
    const std::string path = path_of(text);
    if (!path.empty()) {
      EXPECT_EQ(path[0], '/');
      EXPECT_EQ((path + "/").find("/../"), std::string::npos) << text;
    }
    query_value(text, "token");
    Head seen = head(text, text, text, text);
    EXPECT_NE(judge(seen, gate_rules(), true).status, 200) << text;
  }
}

TEST(TokenTest, TokensAreLongAndNeverTheSame) {
  const std::string a = make_token(), b = make_token();
  EXPECT_EQ(a.size(), 43u);
  EXPECT_NE(a, b);
  EXPECT_TRUE(same_token(a, a));
  EXPECT_FALSE(same_token(a, b));
  EXPECT_FALSE(same_token(a, a.substr(1)));
  EXPECT_FALSE(same_token("", a));
}

}  // namespace
}  // namespace polyarm::server
