/// 3MF: units, colours, components, and archives that are damaged or made to do harm.
#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <random>

#include "polyarm/base/error.hpp"
#include "polyarm/meshes/mesh.hpp"
#include "polyarm/meshes/zip_archive.hpp"
#include "tests/support/folder.hpp"

namespace polyarm::meshes {
namespace {

using test::Folder;

std::string little_endian(std::size_t value, int count) {
  std::string out;
  for (int i = 0; i < count; ++i) out += static_cast<char>(value >> (8 * i));
  return out;
}

std::string deflated(const std::string& text) {
  std::string out(compressBound(text.size()) + 64, '\0');
  z_stream stream{};
  deflateInit2(&stream, 9, Z_DEFLATED, -MAX_WBITS, 9, Z_DEFAULT_STRATEGY);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

struct File {
  std::string name, text;
  std::size_t said_size = 0;  ///< 0: its size
};

/// A ZIP archive; every second file is stored, the others are deflated.
std::string zip(const std::vector<File>& files) {
  std::string out, list;
  bool stored = false;
  for (const File& file : files) {
    const std::string data = stored ? file.text : deflated(file.text);
    const auto sum =
        crc32(0, reinterpret_cast<const Bytef*>(file.text.data()), static_cast<uInt>(file.text.size()));
    const std::size_t size = file.said_size ? file.said_size : file.text.size();
    const std::string facts = little_endian(0, 2) + little_endian(stored ? 0 : 8, 2) + little_endian(0, 4) +
                              little_endian(sum, 4) + little_endian(data.size(), 4) + little_endian(size, 4) +
                              little_endian(file.name.size(), 2) + little_endian(0, 2);
    list += "PK\x01\x02" + little_endian(20, 2) + little_endian(20, 2) + facts + little_endian(0, 2) +
            little_endian(0, 4) + little_endian(0, 4) + little_endian(out.size(), 4) + file.name;
    out += "PK\x03\x04" + little_endian(20, 2) + facts + file.name + data;
    stored = !stored;
  }
  return out + list + "PK\x05\x06" + little_endian(0, 4) + little_endian(files.size(), 2) +
         little_endian(files.size(), 2) + little_endian(list.size(), 4) + little_endian(out.size(), 4) +
         little_endian(0, 2);
}

const char* kRelationships =
    R"(<?xml version="1.0"?><Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
<Relationship Target="/3D/part.model" Id="rel0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>)";

/// A tetrahedron with edges of 1, 2 and 3 units.
const char* kTetrahedron =
    R"(<mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/><vertex x="0" y="2" z="0"/><vertex x="0" y="0" z="3"/></vertices>
<triangles><triangle v1="0" v2="2" v3="1"/><triangle v1="0" v2="1" v3="3" pid="5" p1="1"/><triangle v1="0" v2="3" v3="2"/><triangle v1="1" v2="2" v3="3"/></triangles></mesh>)";

std::string model(const std::string& unit, const std::string& more = {},
                  const std::string& items = R"(<item objectid="1"/>)") {
  return R"(<?xml version="1.0" encoding="UTF-8"?><model unit=")" + unit +
         R"(" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><!-- > --><resources>
<basematerials id="5"><base name="a" displaycolor="#FF0000"/><base name="b" displaycolor="#00FF0080"/></basematerials>
<object id="1" type="model" pid="5" pindex="0">)" +
         kTetrahedron + "</object>" + more + "</resources><build>" + items + "</build></model>";
}

std::string archive(const std::string& model) {
  return zip({{"_rels/.rels", kRelationships}, {"3D/part.model", model}, {"../../evil", "x"}});
}

std::array<float, 3> upper_corner(const Mesh& mesh) {
  std::array<float, 3> out{};
  for (const MeshPart& part : mesh)
    for (const auto& p : part.positions)
      for (std::size_t k = 0; k < 3; ++k) out[k] = std::max(out[k], p[k]);
  return out;
}

std::string refusal(const std::string& bytes) {
  try {
    read_3mf(bytes, "a.3mf");
  } catch (const Error& e) {
    return e.what();
  }
  return {};
}

TEST(ThreeMf, ComesInMetresOfItsUnitWithItsColours) {
  Folder folder;
  for (const auto& [unit, metres] :
       {std::pair{"millimeter", 1e-3}, {"inch", 0.0254}, {"meter", 1.0}, {"micron", 1e-6}}) {
    const Mesh mesh = read_mesh(folder.write("a.3MF", archive(model(unit))));
    const auto size = upper_corner(mesh);
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_NEAR(size[k], (1.0 + static_cast<double>(k)) * metres, 1e-6 * metres) << unit;
    ASSERT_EQ(mesh.size(), 2u) << "one part for each colour";
    EXPECT_EQ(mesh[0].color, (std::array<float, 4>{1, 0, 0, 1}));
    EXPECT_NEAR(mesh[1].color[3], 128 / 255.0, 1e-6);
    EXPECT_EQ(mesh[0].triangles.size() + mesh[1].triangles.size(), 12u);
  }
}

TEST(ThreeMf, ComponentsStandWhereTheirTransformsSay) {
  const std::string twice =
      R"(<object id="2"><components><component objectid="1"/><component objectid="1" transform="1 0 0 0 1 0 0 0 1 10 20 30"/></components></object>
<object id="3" type="support">)" +
      std::string(kTetrahedron) + "</object>";
  const Mesh mesh = read_3mf(
      archive(model("millimeter", twice,
                    R"(<item objectid="2" transform="0 1 0 -1 0 0 0 0 1 0 0 0"/><item objectid="3"/>)")),
      "a");
  std::size_t triangles = 0;
  for (const MeshPart& part : mesh) triangles += part.triangles.size() / 3;
  EXPECT_EQ(triangles, 8u) << "what supports others is left out";
  const auto size = upper_corner(mesh);
  EXPECT_NEAR(size[1], 11e-3, 1e-6) << "turned by a quarter about z after it was moved";
  EXPECT_NEAR(size[2], 33e-3, 1e-6);
}

TEST(ThreeMf, AMirroredItemIsNotInsideOut) {
  const auto volume = [](const Mesh& mesh) {
    double out = 0;
    for (const MeshPart& part : mesh)
      for (std::size_t i = 0; i + 2 < part.triangles.size(); i += 3) {
        const auto at = [&](std::size_t k) {
          const auto& p = part.positions[part.triangles[i + k]];
          return Vec3{p[0], p[1], p[2]};
        };
        out += dot(at(0), cross(at(1), at(2))) / 6;
      }
    return out;
  };
  EXPECT_NEAR(volume(read_3mf(archive(model("meter")), "a")), 1, 1e-5);
  EXPECT_NEAR(
      volume(read_3mf(
          archive(model("meter", "", R"(<item objectid="1" transform="-1 0 0 0 1 0 0 0 1 0 0 0"/>)")), "a")),
      1, 1e-5);
}

TEST(ThreeMf, ComponentsMayBeInOtherFilesOfTheArchive) {
  const std::string root =
      R"(<model unit="meter"><resources/><build><item objectid="1" p:path="/3D/Objects/b.model"/></build></model>)";
  const std::string bytes =
      zip({{"_rels/.rels", kRelationships}, {"3D/part.model", root}, {"3D/Objects/b.model", model("inch")}});
  EXPECT_NEAR(upper_corner(read_3mf(bytes, "a"))[2], 3, 1e-6) << "the unit of the first model holds";
}

TEST(ThreeMf, WhatIsDamagedOrHostileIsRefusedWithASentence) {
  EXPECT_NE(refusal("nothing").find("a.3mf"), std::string::npos);
  EXPECT_NE(refusal("nothing").find("export it again"), std::string::npos);
  EXPECT_NE(refusal(zip({{"a", "b"}})).find("3D/3dmodel.model"), std::string::npos);
  EXPECT_NE(refusal(archive("<html/>")).find("<model>"), std::string::npos);
  EXPECT_NE(refusal(archive("")), "");
  EXPECT_NE(refusal(archive(model("parsec"))).find("unit"), std::string::npos);
  EXPECT_NE(refusal(archive(model("meter", "", R"(<item objectid="9"/>)"))).find("'9'"), std::string::npos);
  EXPECT_NE(refusal(archive(model("meter", "", R"(<item objectid="1" transform="1 2 3"/>)"))).find("twelve"),
            std::string::npos);
  EXPECT_NE(refusal(archive(model("meter", "", ""))).find("builds nothing"), std::string::npos);
  EXPECT_NE(
      refusal(
          archive(
              R"(<model><resources><object id="1"><mesh><vertices/><triangles><triangle v1="0" v2="1" v3="2"/></triangles></mesh></object></resources></model>)"))
          .find("corner"),
      std::string::npos);
  const std::string entities =
      R"(<?xml version="1.0"?><!DOCTYPE lolz [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;">]><model>&b;</model>)";
  EXPECT_NE(refusal(archive(entities)).find("document type"), std::string::npos);
}

TEST(ThreeMf, ObjectsThatUnfoldAreRefused) {
  std::string more;  // each shows the one before ten times
  for (int i = 2; i < 12; ++i) {
    more += "<object id=\"" + std::to_string(i) + "\"><components>";
    for (int k = 0; k < 10; ++k) more += "<component objectid=\"" + std::to_string(i - 1) + "\"/>";
    more += "</components></object>";
  }
  EXPECT_NE(refusal(archive(model("meter", more, R"(<item objectid="11"/>)"))).find("more than 10,000 parts"),
            std::string::npos);
  const std::string circle =
      R"(<object id="2"><components><component objectid="3"/></components></object><object id="3"><components><component objectid="2"/></components></object>)";
  EXPECT_NE(refusal(archive(model("meter", circle, R"(<item objectid="2"/>)"))).find("too deep"),
            std::string::npos);
}

TEST(ThreeMf, AnArchiveThatUnpacksToMoreThanAMeshMayHaveIsRefused) {
  const std::string zeros(200 << 20, '0');
  const std::string bomb = zip({{"_rels/.rels", kRelationships}, {"x", ""}, {"3D/part.model", zeros}});
  ASSERT_LT(bomb.size(), 1u << 20);
  EXPECT_NE(refusal(bomb).find("too large"), std::string::npos);
  const std::string liar = zip({{"_rels/.rels", kRelationships}, {"x", ""}, {"3D/part.model", zeros, 1000}});
  EXPECT_NE(refusal(liar).find("damaged"), std::string::npos) << "it has more bytes than it says";
}

TEST(ThreeMf, NoFileBreaksTheReader) {
  const std::string whole = archive(model("millimeter"));
  const std::string text = model("millimeter");
  std::mt19937_64 draw(11);
  int taken = 0;
  for (int round = 0; round < 6000; ++round) {
    // Every second time the model is damaged before it is packed, so that its reader sees it.
    std::string bytes = round % 2 ? whole : text;
    for (std::uint64_t i = 1 + draw() % 3; i > 0; --i) {
      const std::size_t at = draw() % bytes.size();
      if (draw() % 8 == 0)
        bytes.resize(at + 1);
      else if (draw() % 4 == 0)
        bytes.insert(at, bytes.substr(draw() % bytes.size(), draw() % 50));
      else
        bytes[at] = static_cast<char>(draw());
    }
    try {
      Mesh mesh = read_3mf(round % 2 ? bytes : archive(bytes), "x");
      for (MeshPart& part : mesh) {
        tidy(part);
        for (const std::uint32_t corner : part.triangles) ASSERT_LT(corner, part.positions.size());
      }
      ++taken;
    } catch (const Error&) {
    }
  }
  EXPECT_GT(taken, 100);
}

}  // namespace
}  // namespace polyarm::meshes
