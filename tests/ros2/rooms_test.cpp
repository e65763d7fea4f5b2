/// Nothing below the door knows that there is one to ROS 2.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace polyarm::ros2 {
namespace {

TEST(Ros2Rooms, NeitherControlNorCellIncludesAnythingOfTheDoorOrItsMiddleware) {
  int files = 0;
  for (const char* room :
       {"base", "realtime", "hardware", "controllers", "control", "moves", "jog", "protocol", "cell"})
    for (const auto& entry : std::filesystem::recursive_directory_iterator(std::string(POLYARM_SOURCE_DIR) +
                                                                           "/polyarm/" + room)) {
      if (!entry.is_regular_file()) continue;
      ++files;
      std::ifstream file(entry.path());
      const std::string text{std::istreambuf_iterator<char>(file), {}};
      for (const char* word : {"polyarm/ros2/", "polyarm/messages/", "polyarm::ros2", "fastdds", "fastrtps"})
        EXPECT_EQ(text.find(word), std::string::npos) << entry.path() << " has " << word;
    }
  EXPECT_GT(files, 100);
}

}  // namespace
}  // namespace polyarm::ros2
