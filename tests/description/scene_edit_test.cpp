#include "polyarm/description/scene_edit.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "polyarm/base/error.hpp"
#include "polyarm/yaml/yaml.hpp"

namespace polyarm::description {
namespace {

MeshEntry entry(double mass = 0) {
  MeshEntry out{"block", "meshes/my \"block\".stl", "mm", {0.5, 0, 0.25}, {0, 0, 1.5}, 1, mass};
  return out;
}

std::vector<std::string> names(const std::string& text, const char* section) {
  return Yaml::parse(text, "scene.yaml")[section].keys();
}

TEST(SceneEdit, PutsAnEntryIntoEveryFormOfASection) {
  for (const std::string text :
       {"polyarm: scene/1\n", "polyarm: scene/1", "polyarm: scene/1\nfixtures:\n  table: {box: [1, 1, 1]}\n",
        "polyarm: scene/1\nfixtures:\n    # first\n    table:\n      box: [1, 1, 1]\n    shelf: {box: [1, 1, "
        "1]}\nfloor: false\n",
        "polyarm: scene/1\nfixtures: {table: {box: [1, 1, 1]}, shelf: {box: [1, 1, 1]}}\n",
        "fixtures: {\n  table: {box: [1, 1, 1]}}\npolyarm: scene/1\n"}) {
    const std::string out = with_mesh(text, "scene.yaml", entry());
    std::vector<std::string> expected = names(text, "fixtures"), found = names(out, "fixtures");
    expected.push_back("block");
    std::sort(expected.begin(), expected.end());
    std::sort(found.begin(), found.end());
    EXPECT_EQ(found, expected) << out;
    const Yaml block = Yaml::parse(out, "scene.yaml")["fixtures"]["block"];
    EXPECT_EQ(block["mesh"]["file"].text(), "meshes/my \"block\".stl");
    EXPECT_EQ(block["mesh"]["unit"].text(), "mm");
    EXPECT_NEAR(block.pose().position.z, 0.25, 1e-12);
  }
}

TEST(SceneEdit, AMassMakesItAPart) {
  const std::string out =
      with_mesh("polyarm: scene/1\nfixtures:\n  table: {box: [1, 1, 1]}\n", "scene.yaml", entry(0.2));
  EXPECT_EQ(names(out, "parts"), std::vector<std::string>{"block"});
  EXPECT_EQ(names(out, "fixtures"), std::vector<std::string>{"table"});
}

TEST(SceneEdit, RefusesWhatItCannotKeep) {
  EXPECT_THROW(with_mesh("polyarm: scene/1\nparts: {block: {}}\n", "scene.yaml", entry()), Error)
      << "as a part already";
  EXPECT_THROW(with_mesh("polyarm: scene/1\nfixtures:\n", "scene.yaml", entry()), Error)
      << "twice the same key";
  EXPECT_THROW(with_mesh("polyarm: scene/1\nfixtures: [1, 2]\n", "scene.yaml", entry()), Error);
  for (const char* name : {"", "1st", "a b", "a: b", "a}", "ä", "-"}) {
    MeshEntry bad = entry();
    bad.name = name;
    EXPECT_THROW(with_mesh("polyarm: scene/1\n", "scene.yaml", bad), Error) << name;
  }
}

}  // namespace
}  // namespace polyarm::description
