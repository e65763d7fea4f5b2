/// Rows in SQLite: kept, merged, never mixed.
#include "polyarm/sweeps/store.hpp"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <fstream>

namespace polyarm::sweeps {
namespace {

namespace fs = std::filesystem;

class StoreTest : public testing::Test {
 protected:
  StoreTest() {
    std::string name = (fs::temp_directory_path() / "polyarm-store-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
  }
  ~StoreTest() override { fs::remove_all(folder_); }
  fs::path folder_;
};

Row row(const std::string& key, double cycle) {
  Row out;
  out.key = key;
  out.ended = "completed";
  out.cycle_s = cycle;
  out.cause = "a \"cause\", with a comma\nand a line";
  return out;
}

TEST_F(StoreTest, KeepsEachColumnOfARow) {
  Row all = row("k", 1.25);
  double next = 1;
  for (const Column& column : columns()) {
    if (column.number) all.*column.number = next += 0.1;
    if (column.text && column.name != "key") all.*column.text = "text of " + column.name;
  }
  {
    Store store(folder_ / "a.sqlite", Store::Open::write);
    store.add(all);
  }
  const Store store(folder_ / "a.sqlite", Store::Open::read);
  const auto back = store.find("k");
  ASSERT_TRUE(back);
  EXPECT_EQ(to_json(*back), to_json(all));
  EXPECT_EQ(to_json(*row_from_json(to_json(all))), to_json(all));
}

TEST_F(StoreTest, ARowThatIsThereStays) {
  Store store(folder_ / "a.sqlite", Store::Open::write);
  store.add(row("k", 1));
  store.add(row("k", 2));
  EXPECT_EQ(store.count(), 1u);
  EXPECT_EQ(*store.find("k")->cycle_s, 1);
  EXPECT_FALSE(store.find("other"));
  EXPECT_FALSE(store.find("k")->clearance_m);
}

TEST_F(StoreTest, MergingTwiceAddsNothing) {
  {
    Store a(folder_ / "a.sqlite", Store::Open::write);
    a.set_inputs({{"cell.yaml", "1"}});
    a.add(row("1", 1)), a.add(row("2", 1));
  }
  Store all(folder_ / "all.sqlite", Store::Open::write);
  all.set_inputs({{"cell.yaml", "1"}});
  all.add(row("2", 1)), all.add(row("3", 1));
  EXPECT_EQ(all.merge(folder_ / "a.sqlite"), 1u);
  EXPECT_EQ(all.merge(folder_ / "a.sqlite"), 0u);
  EXPECT_EQ(all.count(), 3u);
}

TEST_F(StoreTest, RowsOfOtherInputsAreNotMerged) {
  {
    Store a(folder_ / "a.sqlite", Store::Open::write);
    a.set_inputs({{"cell.yaml", "1"}});
    a.add(row("1", 1));
  }
  Store all(folder_ / "all.sqlite", Store::Open::write);
  all.set_inputs({{"cell.yaml", "2"}});
  try {
    all.merge(folder_ / "a.sqlite");
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.problems().front().code, "changed-inputs");
    EXPECT_NE(std::string(e.what()).find("cell.yaml"), std::string::npos);
  }
  EXPECT_EQ(all.count(), 0u);
}

TEST_F(StoreTest, AFileThatIsNoDatabaseIsAnError) {
  std::ofstream(folder_ / "a.sqlite") << std::string(5000, 'x');
  EXPECT_THROW(Store(folder_ / "a.sqlite", Store::Open::write), Error);
  EXPECT_THROW(Store(folder_ / "none.sqlite", Store::Open::read), Error);
}

TEST(Csv, QuotesWhatNeedsIt) {
  const std::string line = csv_line(row("k", 0.1));
  EXPECT_NE(line.find("\"a \"\"cause\"\", with a comma\nand a line\""), std::string::npos) << line;
  EXPECT_NE(line.find(",0.1,"), std::string::npos) << line;
}

TEST(Inputs, ChangesNameWhatDiffers) {
  EXPECT_EQ(changes({{"a", "1"}, {"b", "1"}, {"d", "1"}}, {{"a", "1"}, {"b", "2"}, {"c", "1"}}),
            (std::vector<std::string>{"b", "c", "d"}));
}

}  // namespace
}  // namespace polyarm::sweeps
