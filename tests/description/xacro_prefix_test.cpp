// Elements of xacro without their prefix, as files from before ROS Noetic have them.
#include <gtest/gtest.h>
#include <tinyxml2.h>

#include "polyarm/xacro/xacro.hpp"
#include "tests/support/folder.hpp"

namespace polyarm::description::xacro_prefix_test {
namespace {

/// Without blanks between elements.
std::string compact(const std::string& xml) {
  tinyxml2::XMLDocument document;
  EXPECT_EQ(document.Parse(xml.c_str()), tinyxml2::XML_SUCCESS) << xml;
  tinyxml2::XMLPrinter printer(nullptr, true);
  document.RootElement()->Accept(&printer);
  return printer.CStr();
}

std::string root_of(const std::string& inner) {
  return "<a xmlns:xacro=\"http://www.ros.org/wiki/xacro\">" + inner + "</a>";
}

std::string expanded(const std::string& inner) {
  Problems warnings;
  const std::string out = compact(expand_xacro_text(root_of(inner), "robot.xacro", {}, warnings));
  EXPECT_TRUE(warnings.list().empty()) << warnings.list().front().text();
  return out;
}

TEST(XacroPrefix, ElementsWithoutItAreReadWithAWarning) {
  const polyarm::test::Folder folder;
  folder.write("limits.xacro", "<robot><property name=\"most\" value=\"${2 * M}\"/></robot>");
  const std::string file = folder.write(
      "arm.xacro", root_of("<property name=\"M\" value=\"1.5\"/><include filename=\"limits.xacro\"/>"
                           "<include filename=\"none.xacro\"/>"
                           "<macro name=\"part\" params=\"name *origin\"><link name=\"${name}\">"
                           "<insert_block name=\"origin\"/></link></macro>"
                           "<part name=\"a\"><origin xyz=\"${most} 0 0\"/></part>"
                           "<if value=\"1\"><b/></if><unless value=\"1\"><c/></unless>"));
  Problems warnings;
  EXPECT_EQ(compact(expand_xacro(file, {}, warnings)),
            "<a><link name=\"a\"><origin xyz=\"3.0 0 0\"/></link><b/></a>");
  ASSERT_EQ(warnings.list().size(), 8u);  // one for each tag, and the file that is missing
  EXPECT_NE(warnings.list().front().text().find("<property> has no prefix; it is read as <xacro:property>"),
            std::string::npos);
}

TEST(XacroPrefix, WordsOfOthersAreNotTakenForXacro) {
  const std::string others =
      "<gazebo><plugin><property name=\"a\" value=\"1\"/><include filename=\"b.sdf\"/></plugin></gazebo>"
      "<ros2_control><if value=\"1\"/></ros2_control><property name=\"no_value\"/><property name=\"\" "
      "value=\"1\"/><include><uri>model://c</uri></include>";
  EXPECT_EQ(expanded(others), "<a>" + others + "</a>");
  EXPECT_EQ(expanded("<xacro:macro name=\"link\" params=\"x\"><l x=\"${x}\"/></xacro:macro>"
                     "<link name=\"a\"/><xacro:link x=\"2\"/>"),
            "<a><link name=\"a\"/><l x=\"2\"/></a>");
}

}  // namespace
}  // namespace polyarm::description::xacro_prefix_test
