#include "polyarm/server/client.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

namespace polyarm::server {
namespace {

Text text(const std::string& of) {
  return std::make_shared<const std::string>(of);
}

TEST(ClientTest, OfStatesTheLatestIsSentAndTheOthersAreCounted) {
  Client client(1, {"here"});
  for (int i = 0; i < 100; ++i) client.put_state(text(std::to_string(i)));
  auto out = client.next();
  ASSERT_TRUE(out);
  EXPECT_EQ(*out->body, "99");
  EXPECT_TRUE(out->binary);
  EXPECT_FALSE(client.next());
  EXPECT_EQ(client.omitted_frames(), 99u);
}

TEST(ClientTest, ANewerEventTakesThePlaceOfOneThatWaitsButLinesAndAnswersDoNot) {
  Client client(1, {"here"});
  client.put(Kind::status, text("old"));
  client.answer("answer 1");
  EXPECT_TRUE(client.waits(Kind::status));
  client.put(Kind::status, text("new"));
  client.answer("answer 2");
  client.put(Kind::log, text("line 1"));
  client.put(Kind::log, text("line 2"));
  std::string all;
  while (const auto out = client.next()) all += *out->body + ";";
  EXPECT_EQ(all, "new;answer 1;answer 2;line 1;line 2;");
  EXPECT_FALSE(client.waits(Kind::status));
}

TEST(ClientTest, WhoReadsNothingIsNotKept) {
  Client client(1, {"here"});
  const std::string large(1 << 20, 'x');
  int kept = 0;
  while (client.answer(large) && kept < 100) ++kept;
  EXPECT_LT(kept, 20);
  EXPECT_TRUE(client.gone());
  EXPECT_FALSE(client.answer("more"));
}

TEST(ClientTest, EventsForWhoReadsNothingAreLeftOutAndCounted) {
  Client client(1, {"here"});
  for (int i = 0; i < 100'000; ++i) client.put(Kind::log, text("a line"));
  EXPECT_FALSE(client.gone());
  EXPECT_GT(client.omitted_events(), 90'000u);
}

TEST(ClientTest, LinesThatComeTooFastEndIt) {
  Client client(1, {"here"});
  int taken = 0;
  while (client.take("{}", 100.0) && taken < 100'000) ++taken;
  EXPECT_EQ(taken, static_cast<int>(Client::kBurst));
  EXPECT_TRUE(client.take("{}", 101.0)) << "a second later there is room again";
}

TEST(ClientTest, TheCellTakesLinesInOrder) {
  Client client(1, {"here"});
  for (int i = 0; i < 3; ++i) client.take(std::to_string(i), 1.0);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(client.line()->text, std::to_string(i));
  EXPECT_FALSE(client.line());
}

TEST(ClientTest, StopsHoldsAndHeartbeatsDoNotWaitBehindLines) {
  Client client(1, {"here"});
  const std::string resume = R"({"request":"control.resume"})", stop = R"({"id":1,"request":"control.stop"})";
  client.take(resume, 1.0);
  for (int i = 0; i < 5; ++i) client.take(R"({"request":"jog.beat","jog":4})", 1.0);
  client.take(stop, 1.0);
  client.take(resume, 1.0);
  EXPECT_EQ(client.urgent(), (std::vector<std::string>{R"({"request":"jog.beat","jog":4})", stop}));
  EXPECT_TRUE(client.line()->before_stop) << "it must not resume what was stopped after it was sent";
  EXPECT_FALSE(client.line()->before_stop);
}

TEST(ClientTest, AStopIsTakenFromWhoHasSentTooMuch) {
  Client client(1, {"here"});
  while (client.take("{}", 100.0)) {
  }
  EXPECT_TRUE(client.take(R"({"request":"control.stop"})", 100.0));
  EXPECT_EQ(client.urgent().size(), 1u);
}

TEST(ClientTest, WhatOnlyQuotesAStopIsNone) {
  Client client(1, {"here"});
  client.take(R"({"request":"files.write","text":"control.stop"})", 1.0);
  EXPECT_TRUE(client.urgent().empty());
  EXPECT_TRUE(client.line());
}

TEST(ClientTest, LinesThatWaitHaveABoundAndAreRefusedWithWords) {
  Client client(1, {"here"});
  const std::string large(1 << 20, 'x');
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(client.take(large, 1.0));
  const auto refused = client.next();
  ASSERT_TRUE(refused);
  EXPECT_NE(refused->body->find("\"busy\""), std::string::npos);
  std::size_t kept = 0;
  while (const auto line = client.line()) kept += line->text.size();
  EXPECT_LE(kept, bounds::kClientInBytes);
  EXPECT_GE(kept, bounds::kClientInBytes / 2);
}

TEST(ClientTest, AllTogetherHaveABound) {
  const auto all = std::make_shared<Waiting>();
  std::vector<std::unique_ptr<Client>> clients;
  for (std::uint64_t i = 1; i <= 40; ++i) {
    clients.push_back(std::make_unique<Client>(i, Client::Side{"here"}, nullptr, all));
    for (int n = 0; n < 3; ++n) clients.back()->take(std::string(1 << 20, 'x'), 1.0);
  }
  EXPECT_LE(all->in, bounds::kAllInBytes);
  clients.clear();
  EXPECT_EQ(all->in, 0u);
  EXPECT_EQ(all->out, 0u);
}

}  // namespace
}  // namespace polyarm::server
