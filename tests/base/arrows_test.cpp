/// The rooms and the arrows between them are those that CMake declares.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>
#include <string>

#include "polyarm/base/file.hpp"

namespace polyarm {
namespace {

namespace fs = std::filesystem;
using Arrows = std::map<std::string, std::set<std::string>>;

const fs::path kRooms = fs::path(POLYARM_SOURCE_DIR) / "polyarm";

/// `polyarm_room(NAME USES A B LIBRARIES …)` of one CMake file, added to `out`.
void add_declared(const fs::path& file, Arrows& out) {
  const std::string text = read_file(file), call = "polyarm_room(";
  for (auto at = text.find(call); at != std::string::npos; at = text.find(call, at + 1)) {
    const auto begin = at + call.size();
    std::istringstream words(text.substr(begin, text.find(')', begin) - begin));
    std::string room, word;
    words >> room;
    std::set<std::string>& uses = out[room];
    bool takes = false;
    while (words >> word && word != "LIBRARIES") {
      if (takes) uses.insert(word);
      takes = takes || word == "USES";
    }
  }
}

Arrows declared() {
  Arrows out;
  add_declared(kRooms / "CMakeLists.txt", out);
  for (const char* file : {"messages/messages.cmake", "server/server.cmake"})
    add_declared(kRooms / file, out);
  return out;
}

/// Rooms whose headers the files of a room include.
std::set<std::string> included(const std::string& room) {
  std::set<std::string> out;
  const std::string begin = "#include \"polyarm/";
  for (const auto& entry : fs::recursive_directory_iterator(kRooms / room)) {
    if (!entry.is_regular_file()) continue;
    const std::string text = read_file(entry.path());
    for (auto at = text.find(begin); at != std::string::npos; at = text.find(begin, at + 1)) {
      const auto name = at + begin.size();
      out.insert(text.substr(name, text.find('/', name) - name));
    }
  }
  out.erase(room);
  return out;
}

TEST(Arrows, EachRoomDeclaresTheRoomsThatItIncludesAndNoOther) {
  const Arrows all = declared();
  ASSERT_GE(all.size(), 28u);
  for (const auto& [room, uses] : all) {
    const std::set<std::string> found = included(room);
    for (const std::string& other : found)
      EXPECT_TRUE(uses.contains(other))
          << room << " includes " << other << ": add it to its USES, or leave it";
    for (const std::string& other : uses)
      EXPECT_TRUE(found.contains(other)) << room << " declares " << other << " and includes nothing of it";
  }
}

TEST(Arrows, GoOneWay) {
  Arrows left = declared();
  for (bool again = true; again && !left.empty();) {
    again = false;
    for (auto room = left.begin(); room != left.end();) {
      const bool free = std::none_of(room->second.begin(), room->second.end(),
                                     [&](const std::string& other) { return left.contains(other); });
      again = again || free;
      room = free ? left.erase(room) : std::next(room);
    }
  }
  for (const auto& [room, uses] : left) ADD_FAILURE() << room << " is part of a circle of rooms";
}

/// What others than the command may include of the cell: the view, its requests and what these answer with.
TEST(Arrows, DoorsSeeTheViewOfACellAndNotItsOwners) {
  const std::set<std::string> allowed{"cell_file", "door",   "held_motions", "known_cells", "observer",
                                      "recorder",  "robots", "stops",        "view",        "worker"};
  const std::string begin = "#include \"polyarm/cell/";
  for (const char* room : {"server", "ros2", "recording"})
    for (const auto& entry : fs::recursive_directory_iterator(kRooms / room)) {
      if (!entry.is_regular_file()) continue;
      const std::string text = read_file(entry.path());
      for (auto at = text.find(begin); at != std::string::npos; at = text.find(begin, at + 1)) {
        const auto name = at + begin.size();
        const std::string header = text.substr(name, text.find(".hpp", name) - name);
        EXPECT_TRUE(allowed.contains(header)) << entry.path() << " includes cell/" << header << ".hpp";
      }
    }
}

TEST(Arrows, ThePageOfTheArchitectureNamesEachRoom) {
  const std::string page = read_file(fs::path(POLYARM_SOURCE_DIR) / "ARCHITECTURE.md");
  for (const auto& [room, uses] : declared())
    EXPECT_NE(page.find("`" + room + "`"), std::string::npos) << room;
}

}  // namespace
}  // namespace polyarm
