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
  ASSERT_GE(all.size(), 46u);
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

/// The rooms of a cell, without `base` and the like.
const std::set<std::string> kRoomsOfACell{"io",        "setup",  "machine",  "tasks",
                                          "operation", "inside", "requests", "cell"};

/// What others than the command may include of a cell: the view, its requests and what these answer with.
TEST(Arrows, DoorsSeeTheViewOfACellAndNotItsOwners) {
  const std::set<std::string> allowed{"setup/cell_file",  "setup/door",    "setup/observer",
                                      "setup/recorder",   "setup/robots",  "operation/held_motions",
                                      "cell/known_cells", "machine/stops", "inside/view",
                                      "io/worker",        "io/free_space", "setup/bodies"};
  const std::string begin = "#include \"polyarm/";
  for (const char* room : {"server", "ros2", "recording"})
    for (const auto& entry : fs::recursive_directory_iterator(kRooms / room)) {
      if (!entry.is_regular_file()) continue;
      const std::string text = read_file(entry.path());
      for (auto at = text.find(begin); at != std::string::npos; at = text.find(begin, at + 1)) {
        const auto name = at + begin.size();
        const std::string header = text.substr(name, text.find(".hpp", name) - name);
        if (!kRoomsOfACell.contains(header.substr(0, header.find('/')))) continue;
        EXPECT_TRUE(allowed.contains(header)) << entry.path() << " includes " << header << ".hpp";
      }
    }
}

TEST(Arrows, NoRoomHasMoreThanFortyFiles) {
  for (const auto& [room, uses] : declared()) {
    std::size_t files = 0;
    for (const auto& entry : fs::directory_iterator(kRooms / room)) files += entry.is_regular_file();
    EXPECT_LE(files, 40u) << room << " is too big: split it";
  }
}

TEST(Arrows, ThePageOfTheArchitectureNamesEachRoom) {
  const std::string page = read_file(fs::path(POLYARM_SOURCE_DIR) / "ARCHITECTURE.md");
  for (const auto& [room, uses] : declared())
    EXPECT_NE(page.find("`" + room + "`"), std::string::npos) << room;
}

}  // namespace
}  // namespace polyarm
