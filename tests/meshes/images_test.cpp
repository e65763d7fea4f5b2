/// Images on meshes: where they may lie, which are taken, and that they reach the picture whole.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "polyarm/meshes/glb_writer.hpp"
#include "polyarm/meshes/image.hpp"
#include "polyarm/meshes/mesh.hpp"
#include "polyarm/meshes/mesh_process.hpp"
#include "tests/support/folder.hpp"

namespace polyarm::meshes {
namespace {

namespace fs = std::filesystem;
using test::Folder;

std::string big_endian(std::uint32_t value) {
  std::string out;
  for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>(value >> shift);
  return out;
}

/// The head of a PNG; its data are not looked at.
std::string png(std::uint32_t width, std::uint32_t height) {
  return std::string("\x89PNG\r\n\x1a\n", 8) + big_endian(13) + "IHDR" + big_endian(width) +
         big_endian(height) + std::string("\x08\x02\x00\x00\x00", 5) + "CRC!" + "data";
}

std::string jpeg(unsigned width, unsigned height) {
  std::string out("\xff\xd8\xff\xe0\x00\x04xx", 8);
  out += std::string("\xff\xc0\x00\x11\x08", 5);
  for (const unsigned side : {height, width}) {
    out += static_cast<char>(side >> 8);
    out += static_cast<char>(side & 255);
  }
  return out + std::string(10, '\x01');
}

std::string obj() {
  return "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 0.75\nusemtl wood\nf 1/1 2/2 3/3\n";
}

std::string collada() {
  return R"(<COLLADA version="1.4.1"><asset><unit meter="1"/></asset>
<library_images><image id="i"><init_from>wood.png</init_from></image></library_images>
<library_effects><effect id="e"><profile_COMMON>
<newparam sid="surface"><surface type="2D"><init_from>i</init_from></surface></newparam>
<newparam sid="sampler"><sampler2D><source>surface</source></sampler2D></newparam>
<technique sid="t"><lambert><diffuse><texture texture="sampler" texcoord="UV"/></diffuse></lambert></technique>
</profile_COMMON></effect></library_effects>
<library_materials><material id="m"><instance_effect url="#e"/></material></library_materials>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array count="9">0 0 0 1 0 0 0 1 0</float_array><technique_common><accessor stride="3"/></technique_common></source>
<source id="t"><float_array count="6">0 0 1 0 0 0.75</float_array><technique_common><accessor stride="2"/></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles material="s" count="1"><input semantic="VERTEX" source="#v" offset="0"/><input semantic="TEXCOORD" source="#t" offset="1"/>
<p>0 0 1 1 2 2</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="vs"><node><instance_geometry url="#g"><bind_material><technique_common>
<instance_material symbol="s" target="#m"/></technique_common></bind_material></instance_geometry></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#vs"/></scene></COLLADA>)";
}

void expect_wood(const Mesh& mesh, const std::string& bytes) {
  ASSERT_EQ(mesh.size(), 1u);
  ASSERT_TRUE(mesh[0].image);
  EXPECT_EQ(*mesh[0].image, bytes);
  ASSERT_EQ(mesh[0].texcoords.size(), mesh[0].positions.size());
  for (std::size_t i = 0; i < 3; ++i) {
    const float expected = mesh[0].positions[i][1] > 0.5 ? 0.25f : 1;
    EXPECT_NEAR(mesh[0].texcoords[i][1], expected, 1e-6) << "from the upper edge";
  }
  for (const float each : mesh[0].color) EXPECT_NEAR(each, 1, 1e-6) << "the image alone gives the colour";
}

TEST(Images, OfObjAndColladaCoverTheirTriangles) {
  Folder folder;
  folder.write("a.mtl", "newmtl wood\nKd 0.2 0.2 0.2\nmap_Kd -s 1 1 1 wood.png\n");
  folder.write("wood.png", png(64, 32));
  for (const std::string& file : {folder.write("a.obj", obj()), folder.write("a.dae", collada())}) {
    Problems notes;
    expect_wood(read_mesh(file, &notes), png(64, 32));
    EXPECT_TRUE(notes.list().empty());
    EXPECT_FALSE(read_mesh(file)[0].image) << "nobody draws it";
  }
}

TEST(Images, APlaceThatIsNotThereCostsTheImageOnly) {
  Folder folder;
  folder.write("a.mtl", "newmtl wood\nmap_Kd wood.png\n");
  folder.write("wood.png", png(64, 32));
  std::string text = obj();
  text.replace(text.find("3/3"), 3, "3/9");
  std::string scene = collada();
  scene.replace(scene.find("0 0 1 1 2 2"), 11, "0 0 1 1 2 9");
  for (const fs::path& file :
       {fs::path(folder.write("a.obj", text)), fs::path(folder.write("a.dae", scene))}) {
    Problems notes;
    const Mesh mesh = read_mesh(file, &notes);
    ASSERT_EQ(mesh.size(), 1u);
    EXPECT_EQ(mesh[0].triangles.size(), 3u);
    EXPECT_FALSE(mesh[0].image);
    EXPECT_TRUE(mesh[0].texcoords.empty());
  }
}

TEST(Images, AreWrittenOnceIntoAGlb) {
  Folder folder;
  folder.write("a.mtl", "newmtl wood\nmap_Kd wood.png\n");
  folder.write("wood.png", png(64, 32));
  Problems notes;
  const Mesh mesh = read_mesh(folder.write("a.obj", obj()), &notes);
  const std::string glb = write_glb({{"one", mesh}, {"two", mesh}});
  const auto size = static_cast<std::size_t>(static_cast<unsigned char>(glb[12])) +
                    256 * static_cast<unsigned char>(glb[13]);
  const nlohmann::json json = nlohmann::json::parse(glb.substr(20, size));
  ASSERT_EQ(json["images"].size(), 1u);
  EXPECT_EQ(json["images"][0]["mimeType"], "image/png");
  EXPECT_EQ(json["materials"].size(), 1u);
  EXPECT_EQ(json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"], 0);
  const auto& view = json["bufferViews"][json["images"][0]["bufferView"].get<int>()];
  EXPECT_EQ(
      glb.substr(28 + size + view["byteOffset"].get<std::size_t>(), view["byteLength"].get<std::size_t>()),
      png(64, 32));
  EXPECT_TRUE(json["meshes"][0]["primitives"][0]["attributes"].contains("TEXCOORD_0"));
}

TEST(Images, OutsideThePackageAreNotRead) {
  Folder folder;
  folder.write("wood.png", png(8, 8));
  folder.write("package/package.xml", "<package/>");
  folder.write("package/textures/wood.png", png(8, 8));
  const fs::path mesh = folder.write("package/meshes/a.obj", obj());
  Problems notes;
  EXPECT_TRUE(read_image(mesh, "../textures/wood.png", notes));
  EXPECT_TRUE(read_image(mesh, "..\\textures\\wood.png", notes)) << "as Windows writes it";
  EXPECT_TRUE(notes.list().empty());
  fs::create_symlink(folder.path() / "wood.png", folder.path() / "package/meshes/link.png");
  for (const std::string& name :
       {std::string("../../wood.png"), (folder.path() / "wood.png").string(),
        "file://" + (folder.path() / "wood.png").string(), std::string("link.png")}) {
    Problems refused;
    EXPECT_FALSE(read_image(mesh, name, refused)) << name;
    ASSERT_EQ(refused.list().size(), 1u) << name;
    EXPECT_EQ(refused.list()[0].severity, Severity::warning);
    EXPECT_NE(refused.list()[0].what.find("outside"), std::string::npos) << refused.list()[0].what;
  }
  fs::remove(folder.path() / "package/package.xml");
  Problems refused;
  EXPECT_FALSE(read_image(mesh, "../textures/wood.png", refused)) << "without a package, its own folder only";
}

TEST(Images, ThatAreTooLargeOrNoneAreRefusedByTheirHeader) {
  EXPECT_EQ(why_no_image(png(4096, 1)), "");
  EXPECT_EQ(why_no_image(jpeg(640, 480)), "");
  EXPECT_NE(why_no_image(png(4097, 1)).find("4097"), std::string::npos);
  EXPECT_NE(why_no_image(png(0x7fffffff, 0x7fffffff)), "");
  EXPECT_NE(why_no_image(jpeg(65535, 65535)).find("65535"), std::string::npos);
  EXPECT_NE(why_no_image(png(0, 4)), "");
  EXPECT_NE(why_no_image("GIF89a"), "");
  EXPECT_NE(why_no_image(""), "");
  EXPECT_NE(why_no_image(png(4, 4).substr(0, 20)), "");
  EXPECT_NE(why_no_image(jpeg(4, 4).substr(0, 12)), "");
  EXPECT_NE(why_no_image(png(4, 4) + std::string(kMostImageBytes, 'x')), "");
}

TEST(Images, ComeThroughTheAnswerOfTheProcessOrAreLeftOut) {
  MeshPart part;
  part.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  part.triangles = {0, 1, 2};
  part.texcoords = {{0, 0}, {1, 0}, {0, 1}};
  part.image = std::make_shared<const std::string>(png(4, 4));
  std::vector<std::byte> message;
  pack_mesh({part, part}, message);
  Mesh mesh;
  ASSERT_TRUE(unpack_mesh(message, mesh));
  ASSERT_TRUE(mesh[1].image);
  EXPECT_EQ(mesh[0].image, mesh[1].image) << "one image for both";
  EXPECT_EQ(*mesh[1].image, png(4, 4));
  part.image = std::make_shared<const std::string>(png(60000, 60000));
  pack_mesh({part}, message);
  ASSERT_TRUE(unpack_mesh(message, mesh));
  EXPECT_FALSE(mesh[0].image);
  tidy(mesh[0]);
  EXPECT_TRUE(mesh[0].texcoords.empty());
}

#ifdef POLYARM_MESH_IMPORT
TEST(Images, OfAGlbAreTakenFromTheFile) {
  Folder folder;
  folder.write("a.mtl", "newmtl wood\nmap_Kd wood.png\n");
  folder.write("wood.png", png(64, 32));
  Problems notes;
  const Mesh mesh = read_mesh(folder.write("a.obj", obj()), &notes);
  const Mesh read = read_mesh(folder.write("a.glb", write_glb({{"one", mesh}})), &notes);
  expect_wood(read, png(64, 32));
}
#endif

}  // namespace
}  // namespace polyarm::meshes
