/// docs/ros-users.md says which hardware plays which plugin as the table in the code has it.
#include <gtest/gtest.h>

#include <map>
#include <string>

#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/ros_files/hardware_names.hpp"

namespace polyarm::ros_files::hardware_page_test {
namespace {

/// Each plugin between ` of the table's first column, with its second column.
std::map<std::string, std::string> rows_of_the_page() {
  std::map<std::string, std::string> out;
  bool in_table = false;
  for (const std::string& line :
       split_words(read_file(std::string(POLYARM_SOURCE_DIR) + "/docs/ros-users.md"), "\n")) {
    if (line.starts_with("| plugin |")) in_table = true;
    if (!line.starts_with("|")) in_table = false;
    const auto middle = line.find(" | ");
    if (!in_table || middle == std::string::npos) continue;
    const auto words = split_words(line.substr(0, middle), "`");
    for (std::size_t i = 1; i < words.size(); ++i)
      if (words[i].find('/') != std::string::npos) out[words[i]] = line.substr(middle + 3);
  }
  return out;
}

TEST(Hardware, OfAnotherNameIsSuggestedOnlyIfItMayBeMeant) {
  const auto suggests = [](const std::string& plugin) {
    return choose_hardware(plugin, "block").note.find("did you mean") != std::string::npos;
  };
  EXPECT_TRUE(suggests("gz_ros2_control/GazeboSimSytem"));
  EXPECT_TRUE(suggests("gz_ros2_contrl/GazeboSimSystem"));
  EXPECT_TRUE(suggests("gz_ros2_control::GazeboSimSystem"));
  EXPECT_FALSE(suggests("go_ros2_control/GoSimSystem"));  // another robot's
}

TEST(HardwarePage, ListsThePluginsThatAreKnownAndWhatPlaysThem) {
  const auto rows = rows_of_the_page();
  EXPECT_EQ(rows.size(), hardware_aliases().size());
  for (const HardwareAlias& alias : hardware_aliases()) {
    const auto row = rows.find(alias.plugin);
    ASSERT_NE(row, rows.end()) << alias.plugin << " is missing on the page";
    EXPECT_NE(row->second.find(alias.driver), std::string::npos) << alias.plugin << ": " << row->second;
    EXPECT_NE(row->second.find(alias.real), std::string::npos) << alias.plugin << ": " << row->second;
  }
}

}  // namespace
}  // namespace polyarm::ros_files::hardware_page_test
