#include "polyarm/data/value.hpp"

#include <gtest/gtest.h>

#include <string_view>
#include <thread>

namespace polyarm::data {
namespace {

std::vector<Value> one_of_each() {
  return {true,
          Number{0.04, Dimension::length},
          "text",
          List{1, "two", List{3}},
          JointState{{"elbow"}, {0.5}},
          Point{{{1, 2, 3}, {}}, false},
          Record{{"a", "b"}, {1, List{2}}}};
}

TEST(Value, IsTwoWordsAndItsKind) {
  EXPECT_LE(sizeof(Value), 3 * sizeof(double));
}

TEST(Value, CopiesAreEqualAndShareWhatIsLarge) {
  for (const Value& value : one_of_each()) {
    const Value copy = value;
    EXPECT_EQ(copy, value);
    EXPECT_EQ(copy.kind(), value.kind());
    EXPECT_EQ(copy.text(), value.text());
  }
  const Value text(std::string(1000, 'x'));
  const Value copy = text;
  EXPECT_EQ(copy.as_text(), text.as_text());
}

TEST(Value, IsOfOneKindOnly) {
  const std::vector<Value> values = one_of_each();
  for (std::size_t i = 0; i < values.size(); ++i) {
    EXPECT_EQ(static_cast<std::size_t>(values[i].kind()), i);
    EXPECT_EQ(values[i].as_boolean() != nullptr, i == 0);
    EXPECT_EQ(values[i].as_number() != nullptr, i == 1);
    EXPECT_EQ(values[i].as_text() != nullptr, i == 2);
    EXPECT_EQ(values[i].as_list() != nullptr, i == 3);
    EXPECT_EQ(values[i].as_joints() != nullptr, i == 4);
    EXPECT_EQ(values[i].as_point() != nullptr, i == 5);
    EXPECT_EQ(values[i].as_record() != nullptr, i == 6);
    for (std::size_t j = 0; j < values.size(); ++j) EXPECT_EQ(values[i] == values[j], i == j);
  }
}

TEST(Value, AssignmentReplacesEveryKindByEveryOther) {
  for (const Value& before : one_of_each())
    for (const Value& after : one_of_each()) {
      Value value = before;
      const Value kept = value;
      value = after;
      EXPECT_EQ(value, after);
      EXPECT_EQ(kept, before);
      value = std::move(value);
      EXPECT_EQ(value, after);
      Value moved = std::move(value);
      EXPECT_EQ(moved, after);
      value = before;
      EXPECT_EQ(value, before);
    }
}

TEST(Value, MayBecomeAPartOfItself) {
  Value list = List{1, List{2, "inner"}};
  list = Value((*list.as_list())[1]);
  EXPECT_EQ(list.text(), "[2, inner]");
  list = std::move((*list.own_parts())[1]);
  EXPECT_EQ(list, Value("inner"));
}

TEST(Value, AChangedPartLeavesCopiesAsTheyWere) {
  Value list = List{1, 2, 3};
  const Value before = list;
  (*list.own_parts())[1] = 20;
  list.append(Value("four"));
  EXPECT_EQ(list.text(), "[1, 20, 3, four]");
  EXPECT_EQ(before.text(), "[1, 2, 3]");
  Value record = Record{{"a", "b"}, {1, 2}};
  const Value other = record;
  (*record.own_parts())[0] = "x";
  EXPECT_EQ(record.text(), "{a = x, b = 2}");
  EXPECT_EQ(other.text(), "{a = 1, b = 2}");
  Value text = "ab";
  const Value shorter = text;
  text.append(std::string_view("cd"));
  EXPECT_EQ(text, Value("abcd"));
  EXPECT_EQ(shorter, Value("ab"));
  EXPECT_EQ(Value(1).own_parts(), nullptr);
}

TEST(Value, APartThatNobodySharesIsChangedInPlace) {
  Value list = List{1, 2, 3};
  const List* const where = list.as_list();
  (*list.own_parts())[0] = 5;
  list.append(6);
  EXPECT_EQ(list.as_list(), where);
}

TEST(Value, KnowsHowMuchIsInIt) {
  const auto extent = [](const Value& value) {
    return std::pair(value.extent().values, value.extent().depth);
  };
  EXPECT_EQ(extent(1), std::pair(1u, 0u));
  EXPECT_EQ(extent(List{}), std::pair(1u, 1u));
  EXPECT_EQ(extent(List{1, 2}), std::pair(3u, 1u));
  EXPECT_EQ(extent(List{1, List{2, Record{{"a"}, {3}}}}), std::pair(6u, 3u));
  Value list = List{1};
  EXPECT_EQ(extent(list), std::pair(2u, 1u));
  const Value copy = list;
  list.append(2);
  EXPECT_EQ(extent(list), std::pair(3u, 1u));
  EXPECT_EQ(extent(copy), std::pair(2u, 1u));
  list.append(List{List{5}});
  EXPECT_EQ(extent(list), std::pair(6u, 3u));
}

TEST(Value, CopiesMayBeLetGoByOtherThreads) {
  const Value shared = List{std::string(100, 'x'), List{1, 2, 3}};
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i)
    threads.emplace_back([copy = shared] {
      for (int turn = 0; turn < 1000; ++turn) {
        Value mine = copy;
        mine.append(turn);
        const Value inner = (*mine.as_list())[1];
        ASSERT_EQ(inner.as_list()->size(), 3u);
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(shared.as_list()->size(), 2u);
}

TEST(Value, TellsItsBeginning) {
  EXPECT_EQ(Value(List(5000, Value(1))).excerpt(10), "[1, 1, 1, …");
  EXPECT_EQ(Value(List{1, 2}).excerpt(10), "[1, 2]");
  EXPECT_EQ(Value("äöü").excerpt(3), "ä…") << "never half a letter";
  EXPECT_EQ(Value(std::string(100, 'x')).excerpt(3), "xxx…");
}

TEST(Value, OfLargeListsAreFreedLittleByLittleWhereSomebodyKeepsThem) {
  const Value shared("text");
  List parts(1000, shared);
  parts.push_back(Value(List(1000, Value("another"))));
  Remains remains;
  {
    const Remains::Keeping keeping(remains);
    Value list(std::move(parts));
    list = false;
    EXPECT_FALSE(remains.empty());
    Value small(List{shared, shared});
    small = false;
  }
  int steps = 0, calls = 0;
  for (; !remains.empty(); ++calls) {
    const int taken = remains.free(800);
    EXPECT_LE(taken, 800 + Remains::kShared);
    steps += taken;
  }
  EXPECT_GE(steps, 2000 * Remains::kShared);
  EXPECT_GE(calls, 20);
  EXPECT_TRUE(shared.is_alone());
}

}  // namespace
}  // namespace polyarm::data
