#include "polyarm/server/client.hpp"

#include <gtest/gtest.h>

namespace polyarm::server {
namespace {

Text text(const std::string& of) {
  return std::make_shared<const std::string>(of);
}

TEST(ClientTest, OfStatesTheLatestIsSentAndTheOthersAreCounted) {
  Client client(1, "here", true);
  for (int i = 0; i < 100; ++i) client.put_state(text(std::to_string(i)));
  auto out = client.next();
  ASSERT_TRUE(out);
  EXPECT_EQ(*out->body, "99");
  EXPECT_TRUE(out->binary);
  EXPECT_FALSE(client.next());
  EXPECT_EQ(client.frames_left_out(), 99u);
}

TEST(ClientTest, ANewerEventTakesThePlaceOfOneThatWaitsButLinesAndAnswersDoNot) {
  Client client(1, "here", true);
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
  Client client(1, "here", true);
  const std::string large(1 << 20, 'x');
  int kept = 0;
  while (client.answer(large) && kept < 100) ++kept;
  EXPECT_LT(kept, 20);
  EXPECT_TRUE(client.gone());
  EXPECT_FALSE(client.answer("more"));
}

TEST(ClientTest, EventsForWhoReadsNothingAreLeftOutAndCounted) {
  Client client(1, "here", true);
  for (int i = 0; i < 100'000; ++i) client.put(Kind::log, text("a line"));
  EXPECT_FALSE(client.gone());
  EXPECT_GT(client.events_left_out(), 90'000u);
}

TEST(ClientTest, LinesThatComeTooFastEndIt) {
  Client client(1, "here", true);
  int taken = 0;
  while (client.take("{}", 100.0) && taken < 100'000) ++taken;
  EXPECT_EQ(taken, static_cast<int>(Client::kBurst));
  EXPECT_FALSE(client.has_room());
  EXPECT_TRUE(client.take("{}", 101.0)) << "a second later there is room again";
}

TEST(ClientTest, TheCellTakesLinesInOrderAndSoManyAtOnce) {
  Client client(1, "here", true);
  for (int i = 0; i < 70; ++i) client.take(std::to_string(i), 1.0);
  EXPECT_EQ(client.lines(2), (std::vector<std::string>{"0", "1"}));
  EXPECT_EQ(client.lines(100).size(), 68u);
  EXPECT_TRUE(client.take_wake()) << "who could not be read may be read again";
}

}  // namespace
}  // namespace polyarm::server
