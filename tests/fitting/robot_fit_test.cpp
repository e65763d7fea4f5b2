#include "polyarm/fitting/robot_fit.hpp"

#include <gtest/gtest.h>

#include <array>

#include "polyarm/base/error.hpp"
#include "polyarm/description/urdf.hpp"
#include "tests/support/folder.hpp"

namespace polyarm::fitting {
namespace {

using description::RobotModel;

/// Two links with boxes, `low` and `high` long, the second one turning at the end of the first.
std::string arm(const std::string& prefix, double low, double high, bool with_box = true) {
  const auto link = [&](const std::string& name, double length, bool with) {
    const std::string half = std::to_string(length / 2), size = "0.1 0.1 " + std::to_string(length);
    return "<link name=\"" + prefix + name + "\">" +
           (with ? "<visual><origin xyz=\"0 0 " + half + "\"/><geometry><box size=\"" + size +
                       "\"/></geometry></visual>"
                 : "") +
           "</link>";
  };
  return "<robot name=\"arm\">" + link("lower", low, true) + link("upper", high, with_box) +
         "<joint name=\"" + prefix + "elbow\" type=\"revolute\"><origin xyz=\"0 0 0.5\"/><parent link=\"" +
         prefix + "lower\"/><child link=\"" + prefix +
         "upper\"/><axis xyz=\"0 1 0\"/><limit lower=\"-1\" upper=\"1\" velocity=\"1\" "
         "effort=\"1\"/></joint></robot>";
}

RobotModel model_of(const std::string& urdf) {
  Problems found;
  RobotModel out = description::read_urdf(urdf, "arm.urdf", found);
  EXPECT_FALSE(found.has_errors());
  return out;
}

RobotModel catalogue_arm() {
  RobotModel out = model_of(arm("", 0.5, 0.4));
  out.provenance.reach_m = 1;
  out.links[0].outline.emplace(description::Outline{{-0.05, -0.05, 0}, {0.05, 0.05, 0.5}});
  out.links[1].outline.emplace(description::Outline{{-0.05, -0.05, 0}, {0.05, 0.05, 0.4}});
  return out;
}

TEST(RobotFit, APrefixOfAllNamesDoesNotMatter) {
  const RobotModel model = catalogue_arm();
  for (const char* prefix : {"", "left/", "cell_1_"}) {
    const MeshedRobot found = meshes_of(model, model_of(arm(prefix, 0.5, 0.4)));
    EXPECT_EQ(found.bodies.size(), 2u) << prefix;
  }
}

/// Three links with boxes; `last`: where the second joint is on the second link.
std::string named_arm(const std::array<std::string, 3>& names, double last) {
  std::string out = "<robot name=\"arm\">";
  for (const std::string& name : names)
    out += "<link name=\"" + name +
           "\"><visual><geometry><box size=\"0.1 0.1 0.3\"/></geometry></visual></link>";
  for (std::size_t i = 0; i < 2; ++i)
    out += "<joint name=\"" + names[i] + "_joint\" type=\"revolute\"><origin xyz=\"0 0 " +
           std::to_string(i == 0 ? 0.5 : last) + "\"/><parent link=\"" + names[i] + "\"/><child link=\"" +
           names[i + 1] +
           "\"/><axis xyz=\"0 1 0\"/><limit lower=\"-1\" upper=\"1\" velocity=\"1\" effort=\"1\"/></joint>";
  return out + "</robot>";
}

TEST(RobotFit, OtherNamesDoNotMatterIfTheFramesAreTheSame) {
  const RobotModel model = model_of(named_arm({"base_link", "link_1", "link_2"}, 0.4));
  EXPECT_EQ(meshes_of(model, model_of(named_arm({"base", "s", "l"}, 0.4))).bodies.size(), 3u);
  EXPECT_THROW(meshes_of(model, model_of(named_arm({"base", "s", "l"}, 0.45))), Error);
}

TEST(RobotFit, ALinkWithoutShapeHasNoMesh) {
  const RobotModel model = catalogue_arm();
  const MeshedRobot found = meshes_of(model, model_of(arm("", 0.5, 0.4, false)));
  EXPECT_EQ(found.bodies.size(), 1u);
  const test::Folder folder;
  Problems warnings;
  try {
    measure(model, found, {(folder.path() / "arm.look").string(), "a test"}, warnings);
    FAIL() << "the upper link has no mesh";
  } catch (const Error& e) {
    EXPECT_EQ(e.problems().front().code, "no-mesh");
  }
}

TEST(RobotFit, TheJointsDecideHowFarSizesMayDiffer) {
  const RobotModel model = catalogue_arm();
  const RobotModel longer = model_of(arm("", 0.5, 0.6));
  EXPECT_EQ(meshes_of(model, longer, kOtherRobot).bodies.size(), 2u) << "the joints are the same";
  RobotModel other = longer;
  other.joints[0].origin.position.z = 0.6;
  EXPECT_THROW(meshes_of(model, other, kOtherRobot), Error);
  EXPECT_THROW(meshes_of(model, model_of(arm("", 0.5, 0.9)), kOtherRobot), Error);
  EXPECT_EQ(meshes_of(model, other).bodies.size(), 2u) << "comparing takes all sizes";
}

}  // namespace
}  // namespace polyarm::fitting
