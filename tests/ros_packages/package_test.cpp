/// Packages, workspaces, plugin descriptions, interfaces and the check of what is missing.
#include <gtest/gtest.h>

#include <algorithm>

#include "polyarm/ros_packages/check.hpp"
#include "polyarm/ros_packages/module_code.hpp"
#include "tests/support/folder.hpp"

namespace polyarm::ros_packages {
namespace {

std::string manifest(const std::string& name, const std::string& depends = "") {
  return "<package format=\"3\"><name>" + name + "</name><version>1.0.0</version>" + depends +
         "<export><build_type>ament_cmake</build_type></export></package>";
}
const char* kPlugin =
    "<library path=\"libdrive\"><class name=\"acme/Drive\" type=\"acme::Drive\" "
    "base_class_type=\"hardware_interface::SystemInterface\"><description>a "
    "drive</description></class></library>";

TEST(Packages, OfAWorkspaceAreFoundBesideIgnoredAndBuiltOnes) {
  const test::Folder place;
  place.write("src/b/package.xml", manifest("b"));
  place.write("src/a/package.xml", manifest("a"));
  place.write("src/off/package.xml", manifest("off"));
  place.write("src/off/COLCON_IGNORE", "");
  place.write("install/c/package.xml", manifest("c"));
  Problems problems;
  const auto found = find_packages(place.path(), problems);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].name, "a");
  EXPECT_EQ(found[1].name, "b");
}

TEST(Packages, MayHaveALicenceInFrontOfAnInstruction) {
  const test::Folder place;
  place.write(
      "a/package.xml",
      "<?xml version=\"1.0\"?>\n<!-- a licence -->\n<?xml-model href=\"format3.xsd\"?>\n" + manifest("a"));
  EXPECT_EQ(read_package(place.path() / "a/package.xml").name, "a");
}

TEST(Packages, OfTheSameRepositoryAreFoundFromOneOfThem) {
  const test::Folder place;
  place.write("robot/control/arm/package.xml", manifest("arm"));
  place.write("robot/control/base/package.xml", manifest("base"));
  place.write("robot/msgs/package.xml", manifest("robot_msgs"));
  place.write("robot/old/base/package.xml", manifest("base"));
  place.write("other/package.xml", manifest("other"));
  const auto names = [&] {
    Problems problems;
    std::vector<std::string> out;
    const Package arm = read_package(place.path() / "robot/control/arm/package.xml");
    for (const Package& each : packages_beside(arm, problems)) out.push_back(each.name);
    return out;
  };
  EXPECT_EQ(names(), (std::vector<std::string>{"base"}));
  place.write("robot/.git/HEAD", "");
  EXPECT_EQ(names(), (std::vector<std::string>{"base", "robot_msgs"}));  // the nearest of a name
}

TEST(Packages, ThatAreNoneAreRefusedWithTheirLine) {
  const test::Folder place;
  Problems problems;
  EXPECT_THROW(find_packages(place.path(), problems), Error);
  place.write("a/package.xml", "<package>\n<name>a\n");
  place.write("b/package.xml", "<package><name>../b</name></package>");
  find_packages(place.path(), problems);
  ASSERT_EQ(problems.list().size(), 2u);
  EXPECT_GT(problems.list()[0].where.line, 0);
}

TEST(Packages, AreBuiltAfterWhatTheyNeed) {
  const test::Folder place;
  place.write("a/package.xml", manifest("a", "<depend>b</depend><exec_depend>d</exec_depend>"));
  place.write("b/package.xml", manifest("b", "<build_depend>c</build_depend>"));
  place.write("c/package.xml", manifest("c", "<depend>a</depend>"));
  place.write("d/package.xml", manifest("d"));
  Problems problems;
  const auto all = find_packages(place.path(), problems);
  std::vector<std::string> names;
  for (const Package* each : in_build_order(all[0], all)) names.push_back(each->name);
  EXPECT_EQ(names, (std::vector<std::string>{"c", "b", "a"}));
}

TEST(Packages, ThatOnlyTheBuildFileNamesAreBuiltToo) {
  const test::Folder place;
  place.write("a/package.xml", manifest("a", "<exec_depend>d</exec_depend>"));
  place.write(
      "a/CMakeLists.txt",
      "find_package(b REQUIRED)  # and e\nif(BUILD_TESTING)\n  if(X)\n  endif()\n  find_package(e)\nendif()\n"
      "set(NEEDED\n  c\n)\nmessage(\"e\")\n");
  for (const std::string name : {"b", "c", "d", "e"}) place.write(name + "/package.xml", manifest(name));
  Problems problems;
  const auto all = find_packages(place.path(), problems);
  std::vector<std::string> names;
  for (const Package* each : in_build_order(all[0], all)) names.push_back(each->name);
  EXPECT_EQ(names, (std::vector<std::string>{"b", "c", "a"}));
}

TEST(Packages, WithFiltersOrKinematicsForAnotherAreItsHelpers) {
  const test::Folder place;
  const auto describe = [&](const std::string& name, const std::string& base) {
    place.write(name + "/package.xml", manifest(name));
    place.write(name + "/x.xml", "<library path=\"" + name + "\"><class name=\"" + name + "/X\" type=\"" +
                                     name + "::X\" base_class_type=\"" + base + "\"/></library>");
  };
  place.write("arm/package.xml", manifest("arm", "<depend>kin</depend>"));
  place.write("kin/package.xml", manifest("kin"));
  describe("kin_kdl", "kin::Kinematics");
  describe("sieve", "filters::FilterBase&lt;double&gt;");
  describe("panel", "rviz_common::Panel");
  Problems problems;
  const auto all = find_packages(place.path(), problems);
  auto order = in_build_order(all[0], all);
  const auto helpers = helpers_of(order, all);
  ASSERT_EQ(helpers.size(), 1u);  // no filters: arm does not use them
  EXPECT_EQ(helpers[0]->name, "kin_kdl");
  order.insert(order.begin(), helpers[0]);
  const std::string code = module_code(all[0], {}, order, {}),
                    build = module_cmake(all[0], {}, order, Kit(), {});
  EXPECT_NE(code.find("described_types()[\"kin_kdl/X\"] = \"kin_kdl::X\""), std::string::npos) << code;
  EXPECT_NE(build.find("polyarm_ros_whole(kin_kdl)"), std::string::npos) << build;
}

TEST(PluginDescription, NamesClassesTheirLibraryAndTheirBase) {
  const test::Folder place;
  place.write("package.xml", manifest("acme"));
  place.write("acme.xml", kPlugin);
  place.write("other.xml", "<robot><joint/></robot>");
  place.write("test/of_tests.xml", kPlugin);
  const auto classes = plugin_classes(read_package(place.path() / "package.xml"));
  ASSERT_EQ(classes.size(), 1u);
  EXPECT_EQ(classes[0].name, "acme/Drive");
  EXPECT_EQ(classes[0].library, "drive");
  EXPECT_TRUE(classes[0].is_hardware());
}

TEST(PluginDescription, WithAMisspelledBaseClassIsNamed) {
  const test::Folder place;
  const auto warnings = [&](const std::string& base, const std::string& beside = "other") {
    std::string text = kPlugin;
    const std::string written = "hardware_interface::SystemInterface";
    text.replace(text.find(written), written.size(), base);
    place.write("package.xml", manifest("acme"));
    place.write("acme.xml", text);
    Problems problems;
    place.write("beside/package.xml", manifest(beside));
    check_bases(read_package(place.path() / "package.xml"),
                {read_package(place.path() / "beside/package.xml")}, problems);
    return problems.list();
  };
  ASSERT_EQ(warnings("controller_iAnterface::ControllerInterface").size(), 1u);
  const Problem problem = warnings("hardware_interface::SystemInterfaces").front();
  EXPECT_EQ(problem.where.line, 1);
  EXPECT_NE(problem.what.find("'hardware_interface::SystemInterfaces' of acme/Drive"), std::string::npos);
  EXPECT_NE(problem.advice.find("\"hardware_interface::SystemInterface\""), std::string::npos);
  EXPECT_TRUE(warnings("hardware_interface::SystemInterface").empty());
  EXPECT_TRUE(warnings("filters::FilterBase&lt;double&gt;").empty());
  EXPECT_TRUE(warnings("acme::Driver").empty());
  for (const char* exists :
       {"my_hardware_interface::ToolInterface", "my_hardware_interface::SystemInterface",
        "robot_interface::SystemInterface", "controller_interface::ControllerInterfaceBase"})
    EXPECT_TRUE(warnings(exists).empty()) << exists;
  EXPECT_EQ(warnings("hardware_interfaces::SystemInterface").size(), 1u);
  EXPECT_TRUE(warnings("hardware_interfaces::SystemInterface", "hardware_interfaces").empty());
  for (const char* old : {"controller_interface::ControllerBase", "hardware_interface::RobotHW"}) {
    ASSERT_EQ(warnings(old).size(), 1u) << old;
    EXPECT_NE(warnings(old).front().what.find("ROS 1"), std::string::npos) << warnings(old).front().text();
  }
}

TEST(Interfaces, AreNamedAsRosNamesTheirFiles) {
  EXPECT_EQ(header_name("Float64MultiArray"), "float64_multi_array");
  EXPECT_EQ(header_name("UInt32"), "u_int32");
  EXPECT_EQ(header_name("ColorRGBA"), "color_rgba");
  EXPECT_EQ(header_name("MultiDOFCommand"), "multi_dof_command");
  EXPECT_EQ(header_name("PointCloud2"), "point_cloud2");
}

TEST(Interfaces, BecomeStructsWithConstantsDefaultsAndArrays) {
  const std::string code = header_code({"acme",
                                        "msg",
                                        "Wear",
                                        "std_msgs/Header header\nfloat64[3] turns\nstring<=8[] names # many\n"
                                        "uint8 WORN=1\nstring WHO = \"a # b\"\nfloat64 w 1.0\nOther other\n",
                                        {}});
  for (const char* part :
       {"#include \"std_msgs/msg/header.hpp\"", "#include \"acme/msg/other.hpp\"",
        "std::array<double, 3> turns{};", "std::vector<std::string> names{};",
        "static constexpr std::uint8_t WORN = 1;", "static inline const std::string WHO = \"a # b\";",
        "double w{1.0};", "acme::msg::Other other{};"})
    EXPECT_NE(code.find(part), std::string::npos) << part << "\n" << code;
}

TEST(Interfaces, HaveTheDefaultsOfArraysAndOfBoundedTexts) {
  const std::string code =
      header_code({"acme",
                   "msg",
                   "Start",
                   "float64[3] way [1, 2.5, -3]\nbool[] on [true, False]\nstring[] who [\"a, b\", 'c']\n"
                   "string<=5 mode \"fast\"\nwstring sign \"x\"\nuint8[] none []\nwstring MARK=\"y\"\n",
                   {}});
  for (const char* part : {"std::array<double, 3> way{1, 2.5, -3};", "std::vector<bool> on{true, false};",
                           "std::vector<std::string> who{\"a, b\", \"c\"};", "std::string mode{\"fast\"};",
                           "std::u16string sign{u\"x\"};", "std::vector<std::uint8_t> none{};",
                           "static inline const std::u16string MARK = u\"y\";"})
    EXPECT_NE(code.find(part), std::string::npos) << part << "\n" << code;
  EXPECT_THROW(header_code({"acme", "msg", "Start", "float64[2] way 1, 2\n", {}}), Error);
  EXPECT_THROW(header_code({"acme", "msg", "Start", "float64[2] way [1, f()]\n", {}}), Error);
}

TEST(Interfaces, MayHaveFieldsWithAnyName) {
  const std::string code = header_code({"acme", "msg", "Note", "string value\nfloat64 o\n", {}});
  EXPECT_NE(code.find("value = given_"), std::string::npos) << code;
  EXPECT_NE(code.find("o == other_.o"), std::string::npos) << code;
  EXPECT_NE(code.find("using Note_ = Note;"), std::string::npos) << code;
}

TEST(Interfaces, OfTheListForPluginsReplaceThoseThatPolyarmSpeaks) {
  const Kit kit;
  int found = 0;
  for (const Interface& each : kit.interfaces())
    if (each.name == "FollowJointTrajectory") {
      ++found;
      EXPECT_NE(each.text.find("int32 index"), std::string::npos) << each.text;
    }
  EXPECT_EQ(found, 1);
  EXPECT_TRUE(kit.has_header("std_msgs/msg/detail/float64__struct.hpp"));
}

TEST(Interfaces, OfServicesAndActionsHaveTheirParts) {
  EXPECT_NE(
      header_code({"a", "srv", "Set", "bool on\n---\nbool done", {}}).find("using Response = Set_Response;"),
      std::string::npos);
  EXPECT_NE(header_code({"a", "action", "Go", "int8 x\n---\n---\nint8 y", {}})
                .find("using Feedback = Go_Feedback;"),
            std::string::npos);
}

TEST(Interfaces, ThatAreNoneAreRefusedWithTheirLine) {
  for (const char* text :
       {"int8", "int8 9x", "a/b/c/d x", "int8 X=\");system(\"", "bool a\n---\n---", "x;y z", "int8 q};int"}) {
    try {
      header_code({"a", "srv", "Bad", text, {"Bad.srv", 1}});
      ADD_FAILURE() << text;
    } catch (const Error& e) {
      EXPECT_EQ(e.problems().front().code, "bad-interface") << text;
      EXPECT_GT(e.problems().front().where.line, 0) << text;
    }
  }
}

TEST(Check, NamesMissingHeadersAndNamesOnceWithTheirPlaceAndAdvice) {
  const test::Folder place;
  place.write("acme/package.xml", manifest("acme"));
  place.write("acme/acme.xml", kPlugin);
  place.write("acme/CMakeLists.txt",
              "find_package(Eigen3 REQUIRED)\nadd_library(drive SHARED src/drive.cpp)\n");
  place.write("acme/include/acme/drive.hpp",
              "#include <hardware_interface/system_interface.hpp>\n#include <nowhere/far.hpp>  // \"a comment\" > here\n");
  place.write("acme/src/drive.cpp",
              "#include \"acme/drive.hpp\"\n#include <vector>\n#include <serial/serial.h>\n#include "
              "<serial/serial.h>\n"
              "// rclcpp::NotInACode\nrclcpp::Telepathy mind;\nrclcpp::Node* node;\n");
  place.write("acme/src/other.cpp", "#include <ros/ros.h>\n");
  Problems problems, found;
  const auto all = find_packages(place.path(), problems);
  check_package(all[0], all, Kit(), found);
  std::vector<std::string> texts;
  for (const Problem& p : found.list())
    if (p.severity == Severity::error) texts.push_back(p.text());
  ASSERT_EQ(texts.size(), 3u) << (texts.empty() ? "" : texts.back());
  const auto has = [&](const std::string& part) {
    return std::any_of(texts.begin(), texts.end(),
                       [&](const std::string& t) { return t.find(part) != std::string::npos; });
  };
  EXPECT_TRUE(has("src/drive.cpp:3")) << texts[0];
  EXPECT_TRUE(has("wjwwood/serial"));
  EXPECT_TRUE(has("src/drive.cpp:6: error: Polyarm has no rclcpp::Telepathy"));
  EXPECT_TRUE(has("drive.hpp:2: error: no header 'nowhere/far.hpp'"));
}

TEST(Check, NamesOfHardwareThatAMissingHeaderMayDeclareAreNotPolyarmsFault) {
  for (const bool foreign : {true, false}) {
    const test::Folder place;
    place.write("acme/package.xml", manifest("acme"));
    place.write("acme/acme.xml", kPlugin);
    place.write("acme/CMakeLists.txt", "add_library(drive SHARED src/drive.cpp)\n");
    place.write("acme/src/drive.cpp",
                std::string(foreign ? "#include <maker/words.hpp>\n" : "#include <vector>\n") +
                    "auto name = hardware_interface::SPRING_FORCE;\n");
    Problems problems, found;
    const auto all = find_packages(place.path(), problems);
    check_package(all[0], all, Kit(), found);
    ASSERT_EQ(found.list().size(), 1u);
    EXPECT_EQ(found.list()[0].text().find("hardware_interface::SPRING_FORCE") == std::string::npos, foreign)
        << found.list()[0].text();
  }
}

TEST(Check, AHeaderThatOneFileNeedsAnywayIsMissingThoughAnotherNamesItBetweenIfs) {
  const test::Folder place;
  place.write("acme/package.xml", manifest("acme"));
  place.write("acme/acme.xml", kPlugin);
  place.write("acme/CMakeLists.txt", "add_library(drive SHARED src/drive.cpp)\n");
  place.write("acme/src/drive.cpp", "#include \"pins.h\"\n#include \"maybe.h\"\n");
  place.write("acme/src/maybe.h", "#pragma once\n#ifdef PI\n#include <wiringPi.h>\n#endif\n");
  place.write("acme/src/pins.h", "#pragma once\n#include <wiringPi.h>\n");
  Problems problems, found;
  const auto all = find_packages(place.path(), problems);
  check_package(all[0], all, Kit(), found);
  ASSERT_EQ(found.list().size(), 2u);
  EXPECT_EQ(found.list()[0].severity, Severity::warning);
  EXPECT_EQ(found.list()[1].severity, Severity::error);
}

TEST(Check, SaysWhereARepositoryGetsItsOtherPackages) {
  const test::Folder place;
  std::filesystem::create_directories(place.path() / "repository/.git");
  place.write("repository/build.repos",
              "repositories:\n  external/springs:\n    type: git\n    url: "
              "\"https://host.example/maker/springs_ros.git\"\n"
              "    version: main\n");
  place.write("repository/acme/package.xml", manifest("acme"));
  place.write("repository/acme/acme.xml", kPlugin);
  place.write("repository/acme/CMakeLists.txt",
              "find_package(springs_ros REQUIRED)\nadd_library(drive SHARED src/drive.cpp)\n");
  place.write("repository/acme/src/drive.cpp", "#include <springs/coil.hpp>\n");
  Problems problems, found;
  const auto all = find_packages(place.path() / "repository", problems);
  check_package(all[0], all, Kit(), found);
  ASSERT_EQ(found.list().size(), 2u);
  for (const Problem& p : found.list())
    EXPECT_NE(
        p.text().find("https://host.example/maker/springs_ros.git into the same workspace: build.repos"),
        std::string::npos)
        << p.text();
}

TEST(Check, FindsWhatTheEnvironmentNamesAndModulesOfCMake) {
  const test::Folder place;
  // colcon needs no build type either; and code may include the controller manager's header for what it
  // brings.
  place.write("acme/package.xml",
              "<package format=\"3\"><name>acme</name><version>1.0.0</version>"
              "<buildtool_depend>ament_cmake</buildtool_depend></package>");
  place.write("acme/acme.xml", kPlugin);
  place.write("acme/CMakeLists.txt",
              "find_package(PkgConfig REQUIRED)\nfind_package(springs REQUIRED)\n"
              "add_library(drive SHARED src/drive.cpp)\n");
  place.write("acme/src/drive.cpp",
              "#include <controller_manager/controller_manager.hpp>\n#include <springs/coil.hpp>\n"
              "#include <ropes/rope.hpp>\ncontroller_manager::ControllerManager* far;\n");
  place.write("opt/include/springs/coil.hpp", "");
  place.write("opt/lib/cmake/springs/springsConfig.cmake", "");
  place.write("more/ropes/rope.hpp", "");
  const auto missing = [&] {
    Problems problems, found;
    const auto all = find_packages(place.path() / "acme", problems);
    check_package(all[0], all, Kit(), found);
    std::string out;
    for (const Problem& each : found.list()) out += each.text() + "\n";
    return out;
  };
  const std::string before = missing();
  for (const char* each : {"no package 'springs'", "'springs/coil.hpp'", "'ropes/rope.hpp'"})
    EXPECT_NE(before.find(each), std::string::npos) << before;
  for (const char* each : {"ROS 1", "PkgConfig", "controller_manager.hpp'"})
    EXPECT_EQ(before.find(each), std::string::npos) << before;
  ::setenv("CMAKE_PREFIX_PATH", ("/nowhere;" + (place.path() / "opt").string()).c_str(), 1);
  ::setenv("CPATH", ("relative:" + (place.path() / "more").string()).c_str(), 1);
  const std::string after = missing();
  ::unsetenv("CMAKE_PREFIX_PATH");
  ::unsetenv("CPATH");
  EXPECT_EQ(std::count(after.begin(), after.end(), '\n'), 1) << after;
  EXPECT_NE(after.find("Polyarm has no controller_manager::ControllerManager"), std::string::npos) << after;
}

TEST(Check, LeavesOtherSystemsAndReadsVariablesAndFoldersBeside) {
  const test::Folder place;
  place.write("acme/package.xml", manifest("acme"));
  place.write("acme/acme.xml", kPlugin);
  place.write("shared/bus.hpp", "#pragma once\n");
  place.write("acme/CMakeLists.txt",
              "set(SOURCES src/drive.cpp)\nadd_library(drive SHARED ${SOURCES})\n"
              "target_include_directories(drive PRIVATE ../shared)\nset(NAME gains)\n"
              "set(NAME ${NAME} more)\nset(TARGET ${NAME}_parameters)\n"
              "generate_parameter_library(${TARGET} src/${TARGET}.yaml)\nset(TARGET drive)\n"
              "configure_file(config.h.in ${CMAKE_BINARY_DIR}/config.h)\n");
  place.write("acme/src/drive.cpp",
              "#include <bus.hpp>\n#include <std_msgs/msg/detail/bool__builder.hpp>\n#ifdef _WIN32\n"
              "#include <windows.h>\n#endif\n#include <nowhere.h>\n#include <gains_parameters.hpp>\n"
              "#include <acme/config.h>\n#include <std_msgs/msg/bool.h>\n#include <angles/angles/angles.h>\n"
              "#include <std_msgs/std_msgs/msg/bool.hpp>\n");
  place.write("acme/src/demo.cpp", "#include <ros/ros.h>\n");
  Problems problems, found;
  const auto all = find_packages(place.path(), problems);
  check_package(all[0], all, Kit(), found);
  std::vector<std::string> texts;
  for (const Problem& p : found.list())
    if (p.severity == Severity::error) texts.push_back(p.text());
  ASSERT_EQ(texts.size(), 1u) << (texts.empty() ? "" : texts.back());
  EXPECT_NE(texts[0].find("drive.cpp:6: error: no header 'nowhere.h'"), std::string::npos) << texts[0];
}

TEST(Check, ReadsTheSourcesOfALibraryWhosePathsAreComposed) {
  const test::Folder place;
  place.write("acme/package.xml", manifest("acme"));
  place.write("acme/acme.xml", kPlugin);
  place.write("acme/CMakeLists.txt",
              "project(acme)\nset(CODE ${CMAKE_CURRENT_SOURCE_DIR}/src)\n"
              "add_library(drive SHARED src/${PROJECT_NAME}/drive.cpp ${CODE}/more.cpp)\n");
  place.write("acme/src/acme/drive.cpp", "#include <bits/stdc++.h>\n");
  place.write("acme/src/more.cpp", "#include <nowhere.h>\n");
  place.write("acme/src/node.cpp", "#include <ros/ros.h>\n");
  Problems problems, found;
  const auto all = find_packages(place.path(), problems);
  check_package(all[0], all, Kit(), found);
  ASSERT_EQ(found.list().size(), 1u) << found.list()[0].text();
  EXPECT_NE(found.list()[0].text().find("more.cpp:1: error: no header 'nowhere.h'"), std::string::npos);
}

TEST(PackageBounds, AreOnTheirPage) {
  const std::string page = read_file(std::string(POLYARM_SOURCE_DIR) + "/docs/bounds.md");
  EXPECT_NE(page.find(bounds_table()), std::string::npos) << bounds_table();
}

TEST(Module, HasAnEntryForAController) {
  Package package;
  package.name = "acme", package.version = "1";
  const std::vector<PluginClass> classes{
      {"acme/Spin", "acme::Spin", "controller_interface::ChainableControllerInterface", "spins", "acme", {}},
      {"acme/Sieve", "acme::Sieve", "filters::FilterBase<double>", "", "acme", {}}};
  const std::string code = module_code(package, classes, {&package}, {});
  EXPECT_NE(code.find("make_controller(\"acme::Spin\")"), std::string::npos) << code;
  const std::string build = module_cmake(package, classes, {&package}, Kit(), {});
  EXPECT_NE(build.find("polyarm_ros_wrapper(controller)"), std::string::npos) << build;
  EXPECT_EQ(build.find("polyarm_ros_wrapper(component)"), std::string::npos) << build;
  EXPECT_NE(code.find("described_types()[\"acme/Sieve\"]"), std::string::npos) << code;
}

TEST(Module, KnowsWhoOverridesTheLifeCycleOfFoxy) {
  const test::Folder place;
  const auto foxy = [&](const std::string& code) {
    place.write("drive/package.xml", manifest("drive"));
    place.write("drive/src/drive.hpp", code);
    return overrides_configure(read_package(place.path() / "drive/package.xml"));
  };
  const std::string body =
      " { return_type configure(const HardwareInfo&) override; return_type start() override; return_type "
      "stop() "
      "override; };\n";
  EXPECT_TRUE(foxy("class Drive : public SystemInterface" + body));
  EXPECT_TRUE(foxy("class Drive : public hardware_interface::SensorInterface" + body));
  EXPECT_FALSE(foxy("class Drive : public BaseInterface<SystemInterface>" + body));
  EXPECT_FALSE(
      foxy("class Drive : public SystemInterface { CallbackReturn on_init(const HardwareInfo&) override; "
           "void configure(); void start(); void stop(); };\n"));
}

TEST(Module, NamesAreTextInItsCode) {
  Package package;
  package.name = "acme", package.version = "1\"; evil";
  const std::vector<PluginClass> classes{
      {"a/B\"", "a::B", "hardware_interface::SystemInterface", "line\nline", "", {}}};
  const std::string code = module_code(package, classes, {&package}, {});
  EXPECT_NE(code.find("\"1\\\"; evil\""), std::string::npos) << code;
  EXPECT_NE(code.find("\"a/B\\\"\""), std::string::npos) << code;
  EXPECT_NE(code.find("\"line line\""), std::string::npos) << code;
}

}  // namespace
}  // namespace polyarm::ros_packages
