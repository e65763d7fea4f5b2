/// Requests that upload meshes and write them into the scene of a cell; in lock-step.
#include <gtest/gtest.h>

#include <filesystem>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/description/scene_file.hpp"
#include "polyarm/setup/cell_file.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm::cell {
namespace {

namespace fs = std::filesystem;
using test::Folder;
using test::Json;
using test::LockStepCell;

const std::string kBlock =
    "solid b\nfacet normal 0 0 0\nouter loop\nvertex 0 0 -5\nvertex 40 0 -5\nvertex 0 20 "
    "-5\nendloop\nendfacet\n"
    "facet normal 0 0 0\nouter loop\nvertex 0 0 -5\nvertex 0 20 -5\nvertex 0 0 "
    "10\nendloop\nendfacet\nendsolid b\n";

std::string base64(const std::string& bytes) {
  constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = 0;
    for (std::size_t k = 0; k < 3; ++k)
      three = three << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      out += i + k > bytes.size() ? '=' : kDigits[three >> (18 - 6 * k) & 63];
  }
  return out;
}

class SceneRequests : public ::testing::Test {
 protected:
  SceneRequests() { begin({}); }
  /// A cell with this scene; empty: none.
  void begin(const std::string& scene) {
    if (!scene.empty()) folder.write("scene.yaml", scene);
    folder.write("cell.yaml", "polyarm: cell/1\nrobots:\n  arm: {model: " + test::kSixAxes +
                                  ", hardware: mock}\n" + (scene.empty() ? "" : "scene: scene.yaml\n"));
    cell = std::make_unique<LockStepCell>(read_cell_file(folder.path()));
    cell->run(6);
  }
  Json upload(const std::string& name, const std::string& bytes, std::size_t offset = 0, bool last = true) {
    return cell->ask({{"request", "scene.upload"},
                      {"name", name},
                      {"offset", offset},
                      {"data", base64(bytes)},
                      {"last", last}});
  }
  Json add(const Json& more) {
    Json request{{"request", "scene.add"}, {"name", "block"},       {"file", "meshes/block.stl"},
                 {"unit", "mm"},           {"at", {0.5, 0, 0.005}}, {"rpy", {0, 0, 0}}};
    request.update(more);
    return cell->ask(request);
  }
  static std::string code(const Json& answer) {
    return answer.value("ok", false) ? "ok" : answer["error"]["code"].get<std::string>();
  }
  std::string text(const std::string& file) { return read_file(folder.path() / file); }

  Folder folder;
  std::unique_ptr<LockStepCell> cell;
};

TEST_F(SceneRequests, AMeshIsUploadedInPiecesAndItsSizeIsReturned) {
  EXPECT_EQ(upload("block.stl", kBlock.substr(0, 60), 0, false)["result"]["bytes"], 60);
  EXPECT_EQ(code(upload("block.stl", "x", 10, false)), "bad-offset");
  const Json done = upload("block.stl", kBlock.substr(60), 60)["result"];
  EXPECT_EQ(done["file"], "meshes/block.stl");
  EXPECT_EQ(done["mesh"]["size"], Json({40.0, 20.0, 15.0}));
  EXPECT_EQ(done["mesh"]["lower"], Json({0.0, 0.0, -5.0}));
  EXPECT_EQ(done["mesh"]["triangles"], 2);
  EXPECT_EQ(done["mesh"]["likely"], "mm");
  EXPECT_FALSE(done["mesh"]["metres"]);
  EXPECT_EQ(text("meshes/block.stl"), kBlock);
  EXPECT_EQ(code(upload("block.stl", kBlock)), "ok") << "the same file again";
  std::string other = kBlock;
  other.replace(other.find("40"), 2, "30");
  EXPECT_EQ(code(upload("block.stl", other)), "exists");
}

TEST_F(SceneRequests, WhatIsNoMeshIsNotKept) {
  for (const auto& [name, wanted] : {std::pair{"../evil.stl", "bad-path"},
                                     {"/etc/x.stl", "bad-path"},
                                     {".hidden.stl", "bad-path"},
                                     {"a/b.stl", "bad-path"},
                                     {"run.sh", "unknown-mesh"},
                                     {"cell.yaml", "unknown-mesh"}})
    EXPECT_EQ(code(upload(name, kBlock)), wanted) << name;
  EXPECT_EQ(code(upload("bad.stl", "nothing")), "bad-mesh");
  EXPECT_EQ(code(upload("bad.png", "nothing")), "bad-image");
  EXPECT_EQ(
      code(cell->ask(
          {{"request", "scene.upload"}, {"name", "a.stl"}, {"offset", 0}, {"data", "!!!!"}, {"last", true}})),
      "bad-request");
  EXPECT_FALSE(fs::exists(folder.path() / "meshes" / "bad.stl"));
  EXPECT_FALSE(fs::exists(folder.path() / "meshes" / "bad.png"));
  EXPECT_TRUE(fs::is_empty(folder.path() / ".state" / "uploads"));
}

TEST_F(SceneRequests, AFolderOfMeshesThatLeadsElsewhereIsRefused) {
  Folder elsewhere;
  fs::create_directory_symlink(elsewhere.path(), folder.path() / "meshes");
  EXPECT_EQ(code(upload("block.stl", kBlock)), "bad-path");
  EXPECT_TRUE(fs::is_empty(elsewhere.path()));
}

TEST_F(SceneRequests, AMeshIsWrittenIntoTheSceneBesideWhatIsThere) {
  begin("polyarm: scene/1\n# the table\nfixtures:\n  table: {box: [1, 1, 0.1], at: [0, 0, -0.2]}  # oak\n");
  ASSERT_EQ(code(upload("block.stl", kBlock)), "ok");
  const Json answer = add({{"rpy", {0, 0, 1.5}}});
  ASSERT_EQ(code(answer), "ok") << answer;
  ASSERT_EQ(code(add({{"name", "block_2"}, {"mass", 0.2}})), "ok");
  const std::string now = text("scene.yaml");
  EXPECT_NE(now.find("# the table\n"), std::string::npos);
  EXPECT_NE(now.find("# oak"), std::string::npos);
  const description::Scene scene = description::read_scene((folder.path() / "scene.yaml").string());
  ASSERT_EQ(scene.fixtures.size(), 2u);
  const description::Fixture& block =
      scene.fixtures[0].name == "block" ? scene.fixtures[0] : scene.fixtures[1];
  EXPECT_EQ(block.name, "block");
  EXPECT_NEAR(block.shapes[0].scale.x, 1e-3, 1e-12);
  EXPECT_NEAR(block.pose.position.x, 0.5, 1e-12);
  ASSERT_EQ(scene.parts.size(), 1u);
  EXPECT_NEAR(scene.parts[0].mass, 0.2, 1e-12);
  begin(now);  // the cell runs with it
  EXPECT_EQ(cell->ask({{"request", "files.versions"}, {"name", "scene.yaml"}})["result"]["versions"].size(),
            2u);
}

TEST_F(SceneRequests, ACellStoresNoMoreThanItsBounds) {
  fs::create_directories(folder.path() / "meshes");
  const auto fill = [&](const std::string& name, std::uintmax_t bytes) {
    folder.write("meshes/" + name, "");
    fs::resize_file(folder.path() / "meshes" / name, bytes);
  };
  fill("large.stl", bounds::kSceneFilesBytes - 10);
  EXPECT_EQ(code(upload("block.stl", kBlock)), "too-large") << "all of them together";
  EXPECT_FALSE(fs::exists(folder.path() / "meshes/block.stl"));
  fill("large.stl", 0);
  ASSERT_EQ(code(upload("block.stl", kBlock)), "ok");
  fs::create_directories(folder.path() / ".state/uploads");
  folder.write(".state/uploads/other.stl", "");
  fs::resize_file(folder.path() / ".state/uploads/other.stl", bounds::kSceneFilesBytes);
  EXPECT_EQ(code(upload("b.stl", kBlock)), "too-large") << "unfinished ones, too";
  fs::remove(folder.path() / ".state/uploads/other.stl");
  for (std::size_t n = 0; n < bounds::kSceneFiles; ++n) fill("m" + std::to_string(n) + ".stl", 0);
  EXPECT_EQ(code(upload("b.stl", kBlock)), "too-many");
  EXPECT_EQ(code(upload("block.stl", kBlock)), "ok") << "it is there";
}

TEST_F(SceneRequests, LinksInTheFolderOfUploadsLeadNowhere) {
  const fs::path state = folder.path() / ".state";
  folder.write("elsewhere/kept.stl", "kept");
  fs::create_directories(state / "uploads");
  fs::create_symlink(folder.path() / "elsewhere/kept.stl", state / "uploads/a.stl");
  EXPECT_EQ(code(upload("a.stl", "more", 4, false)), "bad-path");
  EXPECT_EQ(read_file(folder.path() / "elsewhere/kept.stl"), "kept");
  fs::remove_all(state / "uploads");
  fs::create_directory_symlink(folder.path() / "elsewhere", state / "uploads");
  EXPECT_EQ(code(upload("kept.stl", kBlock)), "bad-path");
  EXPECT_EQ(read_file(folder.path() / "elsewhere/kept.stl"), "kept");
}

TEST_F(SceneRequests, ACellWithoutASceneGetsOneWithItsFloor) {
  ASSERT_EQ(code(upload("block.stl", kBlock)), "ok");
  const Json answer = add(Json::object());
  ASSERT_EQ(code(answer), "ok") << answer;
  EXPECT_NE(text("cell.yaml").find("\nscene: scene.yaml\n"), std::string::npos);
  EXPECT_NE(text("scene.yaml").find("floor: {height: "), std::string::npos);
  ASSERT_EQ(code(add({{"name", "second"}, {"scale", 2}})), "ok") << "before the cell starts again";
  EXPECT_EQ(description::read_scene((folder.path() / "scene.yaml").string()).fixtures.size(), 2u);
  const std::string cell_file = text("cell.yaml");
  EXPECT_EQ(cell_file.find("scene: scene.yaml"), cell_file.rfind("scene: scene.yaml")) << "named once";
}

TEST_F(SceneRequests, WhatTheSceneCannotTakeIsRefusedAndChangesNothing) {
  const std::string before =
      "polyarm: scene/1\nparts: {cube: {box: [0.1, 0.1, 0.1], at: [1, 1, 1], mass: 0.1}}\n";
  begin(before);
  ASSERT_EQ(code(upload("block.stl", kBlock)), "ok");
  EXPECT_EQ(code(add({{"name", "cube"}})), "exists");
  EXPECT_EQ(code(add({{"name", "no: word"}})), "bad-name");
  EXPECT_EQ(code(add({{"name", "a}, b: {"}})), "bad-name");
  EXPECT_EQ(code(add({{"file", "meshes/other.stl"}})), "no-mesh");
  EXPECT_EQ(code(add({{"file", "../block.stl"}})), "no-mesh");
  EXPECT_EQ(code(add({{"unit", "parsec"}})), "bad-value");
  EXPECT_EQ(code(add({{"mass", -1}})), "bad-value");
  EXPECT_EQ(code(add({{"scale", 0}})), "bad-value");
  EXPECT_EQ(code(add({{"at", {1e9, 0, 0}}})), "bad-value");
  EXPECT_EQ(text("scene.yaml"), before);
  EXPECT_EQ(code(add({{"mass", 0.3}})), "ok") << "into a map in one line";
  EXPECT_EQ(description::read_scene((folder.path() / "scene.yaml").string()).parts.size(), 2u);
}

}  // namespace
}  // namespace polyarm::cell
