/// Launch files whose packages have their files deeper in the sources than in the installation.
#include <gtest/gtest.h>

#include "polyarm/launch/python_launch.hpp"
#include "polyarm/xacro/packages.hpp"
#include "tests/support/folder.hpp"

namespace polyarm::ros_files::package_layout_test {
namespace {

/// The layout of ros2_control's examples: CMake installs description/urdf as urdf, and bringup/config as
/// config.
struct Package {
  Package() {
    folder.write("p1/package.xml", "<package><name>p1</name></package>");
    folder.write("p1/description/urdf/a.urdf", "<robot name='a'/>");
    folder.write("p1/bringup/config/c.yaml", "controller_manager:\n  ros__parameters: {}\n");
  }
  std::filesystem::path at(const std::string& inside) const { return folder.path() / "p1" / inside; }
  PythonLaunch read(const std::string& name, const std::string& text) const {
    const std::filesystem::path path = folder.write("p1/bringup/launch/" + name, text);
    return read_python_launch(text, path, {}, description::packages_near(path));
  }
  test::Folder folder;
};

constexpr const char* kNode =
    "c = PathJoinSubstitution([FindPackageShare('p1'), 'config', 'c.yaml'])\n"
    "d = Command(['xacro ', PathJoinSubstitution([FindPackageShare('p1'), 'urdf', 'a.urdf']), ' file:=', "
    "c])\n"
    "Node(package='controller_manager', executable='ros2_control_node', parameters=[c])\n";

void expect_found(const Package& package, const PythonLaunch& launch) {
  ASSERT_EQ(launch.descriptions.size(), 1u);
  EXPECT_EQ(launch.descriptions[0].file, package.at("description/urdf/a.urdf"));
  ASSERT_EQ(launch.parameters.size(), 1u);
  EXPECT_EQ(launch.parameters[0].file, package.at("bringup/config/c.yaml"));
  EXPECT_TRUE(launch.not_taken.empty());
}

TEST(PackageLayout, FilesAreFoundWhereTheSourcesHaveThem) {
  const Package package;
  const PythonLaunch launch = package.read("l.launch.py", kNode);
  expect_found(package, launch);
  const std::vector<std::pair<std::string, std::string>> arguments{
      {"file", package.at("bringup/config/c.yaml").string()}};
  EXPECT_EQ(launch.descriptions[0].arguments, arguments) << "values of xacro that name files, too";
}

TEST(PackageLayout, IncludedLaunchFilesAreFoundWithTheirPaths) {
  const Package package;
  package.folder.write("p1/bringup/launch/inner.launch.py", kNode);
  expect_found(package, package.read("l.launch.py",
                                     "IncludeLaunchDescription(PythonLaunchDescriptionSource("
                                     "[FindPackageShare('p1'), '/launch/inner.launch.py']))\n"));
}

TEST(PackageLayout, APathThatIsHandedToAnIncludedFileIsFound) {
  const Package package;
  package.folder.write("p1/bringup/launch/inner.launch.py",
                       "d = Command(['cat ', LaunchConfiguration('model')])\n"
                       "Node(package='controller_manager', parameters=[LaunchConfiguration('file')])\n");
  expect_found(package, package.read("l.launch.py",
                                     "p = get_package_share_directory('p1')\n"
                                     "IncludeLaunchDescription(p + '/launch/inner.launch.py', "
                                     "launch_arguments={'model': p + '/urdf/a.urdf', "
                                     "'file': os.path.join(p, 'config', 'c.yaml')}.items())\n"));
}

TEST(PackageLayout, HoldsForLaunchFilesInXml) {
  const Package package;
  expect_found(package,
               package.read("l.launch.xml",
                            "<launch><node pkg='controller_manager' exec='ros2_control_node'>\n"
                            "<param name='robot_description' value=\"$(command 'xacro $(find-pkg-share "
                            "p1)/urdf/a.urdf')\"/>\n"
                            "<param from='$(find-pkg-share p1)/config/c.yaml'/></node></launch>\n"));
}

TEST(PackageLayout, OfSeveralFilesNoneIsChosen) {
  const Package package;
  package.folder.write("p1/other/urdf/a.urdf", "<robot name='b'/>");
  const PythonLaunch launch = package.read("l.launch.py", kNode);
  ASSERT_EQ(launch.descriptions.size(), 1u);
  EXPECT_EQ(launch.descriptions[0].file, package.at("urdf/a.urdf"));
}

}  // namespace
}  // namespace polyarm::ros_files::package_layout_test
