/// docs/ros2-compatibility.md says what the registry has.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/plugins/types.hpp"

namespace polyarm::controllers::compatibility_page_test {
namespace {

/// Before any test has made types of its own known.
const std::size_t kBuiltIn = controller_types().size();

/// The rows of the tables whose head begins with "| type |": first cell without `, second cell.
std::vector<std::map<std::string, std::string>> tables() {
  std::vector<std::map<std::string, std::string>> out;
  bool in_table = false;
  for (const std::string& line :
       split_words(read_file(std::string(POLYARM_SOURCE_DIR) + "/docs/ros2-compatibility.md"), "\n")) {
    if (line.starts_with("| type |")) {
      out.emplace_back();
      in_table = true;
    } else if (!line.starts_with("|")) {
      in_table = false;
    } else if (in_table && line.starts_with("| `")) {
      const auto end = line.find("` | ");
      out.back()[line.substr(3, end - 3)] = line.substr(end + 4, line.size() - end - 6);
    }
  }
  return out;
}

TEST(CompatibilityPage, ListsTheControllersThatThereAre) {
  const auto listed = tables();
  ASSERT_EQ(listed.size(), 2u);
  EXPECT_EQ(listed[0].size(), kBuiltIn);
  for (std::size_t i = 0; i < kBuiltIn; ++i) {
    const ControllerType& type = controller_types()[i];
    const auto row = listed[0].find(type.name);
    ASSERT_NE(row, listed[0].end()) << type.name << " is missing on the page";
    EXPECT_EQ(row->second, type.summary) << type.name;
  }
}

TEST(CompatibilityPage, NamesAsMissingOnlyWhatIsMissing) {
  const auto listed = tables();
  ASSERT_EQ(listed.size(), 2u);
  for (const auto& [type, instead] : listed[1]) {
    EXPECT_EQ(find_controller_type(type), nullptr) << type << " is here";
    const auto quote = instead.find('`');
    if (quote == std::string::npos) continue;
    const std::string other = instead.substr(quote + 1, instead.find('`', quote + 1) - quote - 1);
    EXPECT_NE(find_controller_type(other), nullptr) << other << " is offered for " << type;
  }
}

}  // namespace
}  // namespace polyarm::controllers::compatibility_page_test
