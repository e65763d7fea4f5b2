#include "polyarm/data/data_store.hpp"

#include <gtest/gtest.h>

namespace polyarm::data {
namespace {

DataSet set_of(const std::vector<std::pair<std::string, Value>>& values) {
  DataSet out;
  for (const auto& [name, value] : values) out.set(name, value);
  return out;
}

TEST(DataStore, KeepsABoundedNumberOfValuesInItsChanges) {
  DataStore store;
  for (int i = 0; i < 1000; ++i) {
    List list(10'000, Value(i));
    store.set("L", Value(std::move(list)), "program");
  }
  std::size_t values = 0;
  const std::vector<Change> kept = store.changes_since(0);
  for (const Change& change : kept) values += change.now->extent().values;
  EXPECT_LE(values, DataStore::kMostKept);
  EXPECT_GE(kept.size(), 10u);
  EXPECT_EQ(kept.back().version, store.version()) << "the newest are kept";
  for (int i = 0; i < 5000; ++i) store.set("N", i, "program");
  EXPECT_EQ(store.changes_since(0).size(), DataStore::kChangesKept);
}

TEST(DataStore, RefusesMoreNamesThanItsBound) {
  DataStore store;
  for (std::size_t i = 0; i < DataStore::kMostNames; ++i) store.set("n" + std::to_string(i), 1, "page");
  EXPECT_THROW(store.set("one_more", 1, "page"), Error);
  EXPECT_TRUE(store.set("n7", 2, "page")) << "those that are there go on";
}

TEST(DataStore, LoadReplacesWhatCameFromThatFileAndLeavesTheRest) {
  DataStore store;
  store.load("points", set_of({{"Home", Point{}}}), "t");
  store.load("cycle", set_of({{"A", 1}, {"B", 2}}), "t");
  store.load("cycle", set_of({{"B", 3}, {"C", 4}}), "t");
  EXPECT_EQ(store.names(), (std::vector<std::string>{"B", "C", "Home"}));
  EXPECT_EQ(*store.find("B"), Value(3));
}

TEST(DataStore, ASetIsPendingForTheFileThatHoldsTheName) {
  DataStore store;
  store.load("cycle", set_of({{"A", 1}}), "t");
  store.load("points", set_of({{"P", 1}}), "t");
  store.set("P", 2, "program");
  store.set("P", 3, "program");
  store.set("Fresh", true, "program");
  const auto writes = store.take_writes();
  ASSERT_EQ(writes.size(), 2u);
  EXPECT_EQ(writes[0].set + "/" + writes[0].name, "cycle/Fresh");
  EXPECT_EQ(writes[1].set + "/" + writes[1].name, "points/P");
  EXPECT_EQ(writes[1].value, Value(3));
  EXPECT_TRUE(store.take_writes().empty());
}

TEST(DataStore, TheVersionGrowsOnlyWithChanges) {
  DataStore store;
  store.declare_tag("A", 1);
  const auto version = store.version();
  EXPECT_FALSE(store.set("A", 1, "x"));
  EXPECT_EQ(store.version(), version);
  EXPECT_TRUE(store.set("A", 2, "x"));
  EXPECT_GT(store.version(), version);
  const auto changes = store.changes_since(version);
  ASSERT_EQ(changes.size(), 1u);
  EXPECT_EQ(changes[0].name, "A");
  EXPECT_EQ(changes[0].old, Value(1));
  EXPECT_EQ(changes[0].now, Value(2));
  EXPECT_EQ(changes[0].who, "x");
}

TEST(DataStore, ValuesFromOutsideAreNotWrittenBackToTheirFile) {
  DataStore store;
  store.load("cycle", set_of({{"A", 1}}), "t");
  store.take_outside("cycle", {{"A", 2}, {"New", 3}}, "plc");
  EXPECT_EQ(*store.find("A"), Value(2));
  EXPECT_EQ(store.set_of("New"), "cycle");
  EXPECT_TRUE(store.take_writes().empty());
}

TEST(DataStore, AFileDoesNotChangeWhatASensorSays) {
  DataStore store;
  store.declare_tag("Held", true, TagRole::state);
  store.load("cycle", set_of({{"Held", false}}), "t");
  EXPECT_EQ(*store.find("Held"), Value(true));
  const auto writes = store.take_writes();
  ASSERT_EQ(writes.size(), 1u);
  EXPECT_EQ(writes[0].value, Value(true));
}

TEST(DataStore, ATagKeepsTheValueThatAFileBrought) {
  DataStore store;
  store.load("cycle", set_of({{"A", true}}), "t");
  store.declare_tag("A", false, TagRole::command);
  EXPECT_EQ(*store.find("A"), Value(true));
  EXPECT_TRUE(store.is_tag("A"));
  store.load("cycle", DataSet{}, "t");
  EXPECT_NE(store.find("A"), nullptr);
}

TEST(DataStore, AForcedNameKeepsItsValueUntilItIsReleased) {
  DataStore store;
  store.load("cycle", set_of({{"A", false}}), "t");
  store.set_now(5);
  store.force("A", true, "forced");
  EXPECT_TRUE(store.facts("A")->forced);
  EXPECT_EQ(store.facts("A")->changed_by, "forced");
  EXPECT_EQ(store.facts("A")->changed_at, 5);
  store.set("A", false, "program");
  store.set("A", true, "program");
  store.set("A", false, "program");
  EXPECT_EQ(*store.find("A"), Value(true));
  store.release("A", "released");
  EXPECT_EQ(*store.find("A"), Value(false));
  EXPECT_FALSE(store.facts("A")->forced);
  EXPECT_THROW(store.force("A", 3, "forced"), Error);
  EXPECT_THROW(store.force("B", true, "forced"), Error);
  EXPECT_FALSE(store.facts("B"));
}

TEST(DataStore, KeepsOnlyTheLastChanges) {
  DataStore store;
  for (int i = 0; i < 5000; ++i) store.set("A", i, "x");
  EXPECT_EQ(store.changes_since(0).size(), DataStore::kChangesKept);
}

}  // namespace
}  // namespace polyarm::data
