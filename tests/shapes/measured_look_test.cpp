#include "polyarm/shapes/measured_look.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "polyarm/base/error.hpp"
#include "tests/support/folder.hpp"

namespace polyarm::shapes {
namespace {

MeasuredLook example() {
  MeasuredLook out;
  out.source = "a drawing";
  MeasuredLoft tube{"arm", "", {{0.1, 0.2, -0.3}, from_axis_angle({0, 1, 0}, 0.7)}, {}};
  MeasuredSection circle{-0.05, {}};
  circle.extent.fill(0.06);
  tube.sections.push_back(circle);
  circle.at = 0.25;
  circle.extent.fill(0.04);
  tube.sections.push_back(circle);
  MeasuredLoft box{"hand", "#0a80ff", {}, tube.sections};
  for (MeasuredSection& section : box.sections)
    for (std::size_t k = 0; k < kTangents; ++k) section.extent[k] = 0.05 + 0.001 * static_cast<double>(k % 8);
  out.lofts = {tube, box};
  return out;
}

class MeasuredLookFile : public ::testing::Test {
 protected:
  std::string written(const std::string& text) { return folder_.write("arm.look", text); }
  test::Folder folder_;
};

TEST_F(MeasuredLookFile, IsReadAsItWasWritten) {
  const MeasuredLook look = example(), read = read_measured_look(written(text_of(look)));
  EXPECT_EQ(read.source, look.source);
  ASSERT_EQ(read.lofts.size(), look.lofts.size());
  for (std::size_t i = 0; i < look.lofts.size(); ++i) {
    const MeasuredLoft &a = look.lofts[i], &b = read.lofts[i];
    EXPECT_EQ(a.link, b.link);
    EXPECT_EQ(a.paint, b.paint);
    EXPECT_LT(norm(a.frame.position - b.frame.position), 1e-4);
    EXPECT_NEAR(std::abs(a.frame.rotation.w), std::abs(b.frame.rotation.w), 1e-4);
    ASSERT_EQ(a.sections.size(), b.sections.size());
    for (std::size_t s = 0; s < a.sections.size(); ++s) {
      EXPECT_NEAR(a.sections[s].at, b.sections[s].at, 1e-4);
      for (std::size_t k = 0; k < kTangents; ++k)
        EXPECT_NEAR(a.sections[s].extent[k], b.sections[s].extent[k], 1e-4);
    }
  }
  EXPECT_EQ(text_of(read), text_of(look)) << "reading and writing again changes nothing";
}

TEST_F(MeasuredLookFile, SaysWhereItIsWrong) {
  const std::string head = "polyarm: look/1\nlinks:\n  arm:\n    - ";
  for (const char* wrong :
       {"{frame: \"0 0 0 0 0 0\", sections: \"0 1, 5 1\"}",
        "{frame: \"0 0 0 0 0 0 0\", sections: \"0 1, 5 1\"}", "{frame: \"0 0 0 0 0 0 1\", sections: \"0 1\"}",
        "{frame: \"0 0 0 0 0 0 1\", sections: \"5 1, 0 1\"}",
        "{frame: \"0 0 0 0 0 0 1\", sections: \"0 1 2, 5 1\"}",
        "{frame: \"0 0 0 0 0 0 1\", sections: \"0 1x, 5 1\"}",
        "{frame: \"0 0 0 0 0 0 1\", sections: \"0 99999999, 5 1\"}", "{sections: \"0 1, 5 1\"}",
        "{frame: \"0 0 0 0 0 0 1\"}", "{paint: red, frame: \"0 0 0 0 0 0 1\", sections: \"0 1, 5 1\"}",
        "{frame: \"0 0 0 0 0 0 1\", sections: \"0 1, 5 1\", hat: 1}"}) {
    try {
      read_measured_look(written(head + wrong + "\n"));
      if (std::string(wrong).find("hat") == std::string::npos) ADD_FAILURE() << wrong << " was accepted";
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find("arm.look:4"), std::string::npos) << e.what();
    }
  }
  EXPECT_THROW(read_measured_look(written("polyarm: robot/1\n")), Error);
}

TEST_F(MeasuredLookFile, KeepsNamesAndSourcesThatYamlWouldReadOtherwise) {
  MeasuredLook look = example();
  look.source = "a \"drawing\" in C:\\cad: 1";
  look.lofts[0].link = "null";
  look.lofts[1].link = "left: #1 \"a\"";
  const MeasuredLook read = read_measured_look(written(text_of(look)));
  EXPECT_EQ(read.source, look.source);
  ASSERT_EQ(read.lofts.size(), 2u);
  EXPECT_EQ(read.lofts[0].link, "null");
  EXPECT_EQ(read.lofts[1].link, look.lofts[1].link);
}

TEST_F(MeasuredLookFile, RefusesMoreThanAnyRobotNeeds) {
  MeasuredLook look = example();
  look.lofts.resize(1);
  MeasuredLoft& loft = look.lofts[0];
  const MeasuredSection section = loft.sections[0];
  loft.sections.clear();
  for (int i = 0; i < 64; ++i) {
    loft.sections.push_back(section);
    loft.sections.back().at = 0.01 * i;
  }
  EXPECT_NO_THROW(read_measured_look(written(text_of(look))));
  loft.sections.push_back(section);
  loft.sections.back().at = 1;
  EXPECT_THROW(read_measured_look(written(text_of(look))), Error);
  look.lofts.assign(400, example().lofts[0]);
  EXPECT_NO_THROW(read_measured_look(written(text_of(look))));
  look.lofts.push_back(look.lofts[0]);
  EXPECT_THROW(read_measured_look(written(text_of(look))), Error);
}

TEST_F(MeasuredLookFile, DamagedFilesEndInAnErrorOrAMesh) {
  const std::string text = text_of(example());
  std::mt19937 random(11);
  for (int i = 0; i < 2000; ++i) {
    std::string damaged = text;
    for (int k = 0; k < 3; ++k) {
      const std::size_t at = random() % damaged.size();
      switch (random() % 3) {
        case 0:
          damaged[at] = static_cast<char>(random() % 256);
          break;
        case 1:
          damaged.erase(at, 1 + random() % 9);
          break;
        default:
          damaged.insert(at, std::string("0123456789 ,-").substr(random() % 12, 2));
          break;
      }
    }
    try {
      const MeasuredLook look = read_measured_look(written(damaged));
      Solid solid;
      for (const MeasuredLoft& loft : look.lofts) add_loft(solid, loft, {});
      for (const meshes::MeshPart& part : solid.take())
        for (const auto& p : part.positions)
          ASSERT_TRUE(std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]));
    } catch (const Error&) {
    }
  }
}

}  // namespace
}  // namespace polyarm::shapes
