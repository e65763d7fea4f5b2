#include "polyarm/protocol/reference.hpp"

#include <gtest/gtest.h>

#include <cctype>
#include <cstdlib>
#include <string>

#include "polyarm/base/file.hpp"

namespace polyarm::protocol {
namespace {

std::string in_tree(const char* path) {
  return std::string(POLYARM_SOURCE_DIR) + "/" + path;
}

bool updates() {
  return std::getenv("POLYARM_UPDATE") != nullptr;
}

/// Puts `table` in the place of the page's table that begins with the same line.
void replace_table(const std::string& file, const std::string& table) {
  std::string page = read_file(file);
  const auto begin = page.find(table.substr(0, table.find('\n') + 1));
  if (begin == std::string::npos) return;
  auto end = begin;
  while (end < page.size() && page[end] == '|') end = page.find('\n', end) + 1;
  write_file_atomically(file, page.replace(begin, end - begin, table));
}

void expect_table(const char* path, const std::string& table) {
  const std::string file = in_tree(path);
  if (updates()) replace_table(file, table);
  EXPECT_NE(read_file(file).find(table), std::string::npos)
      << path << " is not current: run this test with POLYARM_UPDATE=1";
}

TEST(ReferenceTest, TheDocsHaveTheRequests) {
  const std::string file = in_tree("docs/requests.md"), heading = "\n## All requests\n\n";
  const std::string page = read_file(file);
  const auto begin = page.find(heading);
  ASSERT_NE(begin, std::string::npos);
  const std::string whole = page.substr(0, begin) + heading + request_reference();
  if (updates()) write_file_atomically(file, whole);
  EXPECT_EQ(read_file(file), whole) << "run this test with POLYARM_UPDATE=1";
}

TEST(ReferenceTest, EachRequestIsDescribedInSentences) {
  for (const HelpRow& row : help_rows()) {
    EXPECT_TRUE(row.text.ends_with('.')) << row.request;
    EXPECT_TRUE(std::isupper(static_cast<unsigned char>(row.text.front()))) << row.request;
  }
}

TEST(ReferenceTest, ThePageOfThePendantHasTheRoles) {
  expect_table("docs/pendant.md", role_reference());
}

TEST(ReferenceTest, ThePageHasTheTypes) {
  const std::string file = in_tree("pendant/src/wire/requests.ts");
  if (updates()) write_file_atomically(file, request_typescript());
  EXPECT_EQ(read_file(file), request_typescript()) << "run this test with POLYARM_UPDATE=1";
}

TEST(ReferenceTest, AnswersAreShownWithAllThatIsInThem) {
  for (const HelpRow& row : help_rows())
    if (row.request == "control.chains") {
      EXPECT_EQ(row.result, "[{from: text, to: text, reference: text, active: flag}]");
    }
}

}  // namespace
}  // namespace polyarm::protocol
