#include "polyarm/catalogue/catalogue_query.hpp"

#include <gtest/gtest.h>

#include "tests/description/support.hpp"

namespace polyarm::description::catalogue_query_test {
namespace {

CatalogueEntry robot(const std::string& name, const std::string& maker, int axes, std::optional<double> reach,
                     std::optional<double> payload, std::optional<double> mass) {
  CatalogueEntry out;
  out.name = name;
  out.maker = maker;
  out.model = name.substr(name.find('/') + 1);
  out.axes = axes;
  out.reach_m = reach;
  out.payload_kg = payload;
  out.mass_kg = mass;
  return out;
}

std::vector<CatalogueEntry> four() {
  return {robot("big_arms/two", "Big Arms", 6, 2.5, 100, 900),
          robot("big_arms/one", "Big Arms", 6, 1.2, 5, 30),
          robot("small/scara", "Small", 4, 0.5, 3, std::nullopt),
          robot("small/odd", "Small", 7, std::nullopt, std::nullopt, 12)};
}

std::string names_of(const CatalogueQuery& query) {
  std::string out;
  for (const CatalogueEntry& found : find_robots(four(), query)) out += found.model + " ";
  return out;
}

Range range(const char* text, BareNumber bare = BareNumber::at_least) {
  return parse_range(text, "--reach", Dimension::length, bare);
}

TEST(Range, TakesComparisonsAndUnits) {
  EXPECT_TRUE(range(">=1.2").contains(1.2));
  EXPECT_FALSE(range(">1.2").contains(1.2));
  EXPECT_TRUE(range(" <= 500mm").contains(0.5));
  EXPECT_FALSE(range("<500mm").contains(0.5));
  EXPECT_TRUE(range("0.5..70cm").contains(0.6));
  EXPECT_FALSE(range("0.5..70cm").contains(0.71));
  EXPECT_TRUE(range("=1").contains(1));
  EXPECT_FALSE(range("=1").contains(1.1));
}

TEST(Range, ABareNumberIsAtLeastOrExactlyThat) {
  EXPECT_TRUE(range("1").contains(2));
  EXPECT_FALSE(range("1").contains(0.9));
  EXPECT_FALSE(range("1", BareNumber::exactly).contains(2));
}

TEST(Range, RefusesWhatIsNone) {
  for (const char* text : {"", "far", ">=", "1..", "..2", "2..1", ">=5kg", "1.2.3", "=>1"}) try {
      range(text);
      ADD_FAILURE() << "'" << text << "' was taken";
    } catch (const Error& e) {
      EXPECT_TRUE(test::has(e.what(), "--reach")) << e.what();
    }
}

TEST(CatalogueQuery, FindsByMakerHoweverItIsSpelled) {
  for (const char* maker : {"Big Arms", "big_arms", "big arms", "BIG-ARMS"})
    EXPECT_EQ(names_of({.maker = maker}), "one two ") << maker;
}

TEST(CatalogueQuery, NamesTheNearestMaker) {
  try {
    find_robots(four(), {.maker = "big_arm"});
    FAIL() << "was found";
  } catch (const Error& e) {
    EXPECT_TRUE(test::has(e.what(), "did you mean 'big_arms'"));
  }
}

TEST(CatalogueQuery, RobotsWithoutAFigureAreInNoRangeOfIt) {
  CatalogueQuery query;
  query.reach_m = range(">=0");
  EXPECT_EQ(names_of(query), "one two scara ");
  query.payload_kg = parse_range("<=5", "--payload", Dimension::mass, BareNumber::at_least);
  EXPECT_EQ(names_of(query), "one scara ");
}

TEST(CatalogueQuery, SortsEitherWayWithUnknownFiguresLast) {
  EXPECT_EQ(names_of({.sort = "reach"}), "scara one two odd ");
  EXPECT_EQ(names_of({.sort = "-reach"}), "two one scara odd ");
  EXPECT_EQ(names_of({.sort = "mass"}), "odd one two scara ");
  EXPECT_EQ(names_of({.sort = "-name"}), "scara odd two one ");
  try {
    find_robots(four(), {.sort = "paylod"});
    FAIL() << "was sorted";
  } catch (const Error& e) {
    EXPECT_TRUE(test::has(e.what(), "did you mean 'payload'"));
  }
}

}  // namespace
}  // namespace polyarm::description::catalogue_query_test
