/// Sensors on serial lines in a cell on the wall clock, told by their broadcasters to another process.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "polyarm/base/file.hpp"
#include "polyarm/yaml/yaml.hpp"
#include "tests/sensors/far_sides.hpp"
#include "tests/support/command.hpp"

namespace polyarm {
namespace {

using test::Command;
using test::run_command;

class SensorsInACell : public ::testing::Test {
 protected:
  SensorsInACell() {
    ::setenv("XDG_RUNTIME_DIR", copy.path().c_str(), 1);
    imu.start();
    gnss.start();
    write_file_atomically(copy.file("cart.urdf"), urdf());
    write_file_atomically(
        copy.file("cell.yaml"),
        "polyarm: cell/1\nrate: 200\nrobots:\n  cart: {model: cart.urdf, hardware: declared}\n"
        "controllers: [controllers.yaml]\n");
    write_file_atomically(copy.file("controllers.yaml"), R"(
controller_manager:
  ros__parameters:
    level: {type: imu_sensor_broadcaster/IMUSensorBroadcaster}
    place: {type: gps_sensor_broadcaster/GPSSensorBroadcaster}
    course: {type: state_interfaces_broadcaster/StateInterfacesBroadcaster}
level:
  ros__parameters:
    sensor_name: imu
    frame_id: imu_link
    static_covariance_angular_velocity: [0.01, 0, 0, 0, 0.01, 0, 0, 0, 0.01]
place:
  ros__parameters: {sensor_name: gps, frame_id: gps_link, read_covariance_from_interface: true}
course:
  ros__parameters: {interfaces: [gps/velocity.east, gps/velocity.north]}
)");
  }
  ~SensorsInACell() override { ::unsetenv("XDG_RUNTIME_DIR"); }

  std::string urdf() const {
    std::string imu_states, gps_states;
    for (const char* group : {"orientation", "angular_velocity", "linear_acceleration"})
      for (const char* axis : {"x", "y", "z", "w"})
        if (std::string(axis) != "w" || std::string(group) == "orientation")
          imu_states += "<state_interface name=\"" + std::string(group) + "." + axis + "\"/>";
    for (const char* name :
         {"status", "service", "latitude", "longitude", "altitude", "latitude_covariance",
          "longitude_covariance", "altitude_covariance", "velocity.east", "velocity.north"})
      gps_states += "<state_interface name=\"" + std::string(name) + "\"/>";
    return R"(<robot name="cart"><link name="base_link"/>
<ros2_control name="inertial" type="sensor">
  <hardware><plugin>serial_imu</plugin><param name="port">)" +
           imu.path() + R"(</param></hardware>
  <sensor name="imu">)" +
           imu_states + R"(</sensor>
</ros2_control>
<ros2_control name="satellites" type="sensor">
  <hardware><plugin>ublox_gnss</plugin><param name="port">)" +
           gnss.path() + R"(</param><param name="rate">10</param></hardware>
  <sensor name="gps">)" +
           gps_states + R"(</sensor>
</ros2_control></robot>)";
  }

  /// Watches until a message of the controller shows `text`; what it printed.
  static std::string watched(const std::string& controller, const std::string& text) {
    std::string said;
    for (int tries = 0; tries < 200; ++tries) {  // each waits for a message
      said = run_command({"watch", controller, "--count", "1"}).output;
      if (said.find(text) != std::string::npos) break;
    }
    return said;
  }

  test::FakeImu imu;
  test::FakeReceiver gnss;
  test::ExampleCopy copy{"pick_and_place"};
};

TEST_F(SensorsInACell, AreWatchedThroughTheirBroadcasters) {
  Command cell({"run", copy.path(), "--json", "--seconds", "60"});
  ASSERT_TRUE(cell.wait_for("u-blox receiver on")) << cell.wait().output;
  const std::string attitude = watched("level", "0.70710");
  EXPECT_NE(attitude.find("0.70710"), std::string::npos) << attitude;
  EXPECT_NE(attitude.find("9.80665"), std::string::npos) << attitude;
  EXPECT_NE(attitude.find("imu_link"), std::string::npos) << attitude;
  const std::string place = watched("place", "47.37");
  EXPECT_NE(place.find("47.37"), std::string::npos) << place;
  EXPECT_NE(place.find("2.25"), std::string::npos) << "the receiver's own covariance: " << place;
  const std::string course = watched("course", "-2");
  EXPECT_NE(course.find("-2"), std::string::npos) << course;
}

TEST_F(SensorsInACell, ACableThatIsPulledIsAFaultThatNamesSensorAndPort) {
  Command cell({"run", copy.path(), "--json", "--seconds", "60"});
  ASSERT_TRUE(cell.wait_for("u-blox receiver on")) << cell.wait().output;
  const std::string port = imu.path();
  watched("level", "0.70710");
  imu.stop();
  imu.pty.close_connection();
  EXPECT_TRUE(cell.wait_for("unplugged"));
  cell.signal(SIGTERM);
  const std::string said = cell.wait().output;
  EXPECT_NE(said.find("on " + port + ": the port is gone"), std::string::npos) << said;
}

TEST_F(SensorsInACell, ACellDoesNotStartWhereADeviceIsMissing) {
  imu.stop();
  gnss.stop();
  gnss.pty.close_connection();
  imu.silent = true;
  const auto said = run_command({"run", copy.path()});
  EXPECT_EQ(said.exit_code, 1);
  EXPECT_NE(said.output.find("inertial"), std::string::npos) << said.output;
}

TEST_F(SensorsInACell, ADriverIsTriedOnItsDeviceAndTheReportCanBeSent) {
  const std::string file = copy.file("report.yaml").string();
  const auto tried = run_command({"drivers", "test", "ublox_gnss", "port=" + gnss.path(), "rate=10",
                                  "--seconds", "0.5", "--report", file});
  EXPECT_EQ(tried.exit_code, 0) << tried.output;
  EXPECT_NE(tried.output.find("HPG 1.32"), std::string::npos) << tried.output;
  EXPECT_NE(tried.output.find("trial/gps/frames"), std::string::npos) << tried.output;
  const Yaml report = Yaml::load(file);
  EXPECT_EQ(report["result"].text(), "passed");
  EXPECT_EQ(report["parameters"]["rate"].text(), "10");
  const auto wrong = run_command(
      {"drivers", "test", "serial_imu", "port=" + gnss.path(), "start_timeout=0.2", "--report", file});
  EXPECT_EQ(wrong.exit_code, 1) << wrong.output;
  EXPECT_NE(wrong.output.find("no WIT frames"), std::string::npos) << wrong.output;
  EXPECT_EQ(Yaml::load(file)["result"].text(), "failed");
}

TEST(DriversCommand, TakesTheOnlyBlockOfADescriptionAsACellDoes) {
  const test::ExampleCopy copy("so101");
  const auto tried =
      run_command({"drivers", "test", "feetech_fake", "--description", copy.file("so101.urdf").string(),
                   "--seconds", "0.3", "--report", copy.file("report.yaml").string()});
  EXPECT_EQ(tried.exit_code, 0) << tried.output;
  EXPECT_NE(tried.output.find("6 joints"), std::string::npos) << tried.output;
}

TEST(DriversCommand, ListsEachDriverWithItsParametersAndItsProof) {
  const auto said = run_command({"drivers", "--json"});
  ASSERT_EQ(said.exit_code, 0) << said.output;
  std::vector<std::string> names;
  for (const auto& driver : said.result()) {
    names.push_back(driver["name"]);
    if (driver["name"] != "serial_imu" && driver["name"] != "ublox_gnss") continue;
    EXPECT_NE(driver["proof"].get<std::string>().find("never on hardware"), std::string::npos);
    EXPECT_EQ(driver["real"], false);
    EXPECT_GE(driver["parameters"].size(), 6u);
    EXPECT_EQ(driver["parameters"][0]["name"], "port");
    EXPECT_TRUE(driver["parameters"][0]["default"].is_null());
  }
  for (const char* name : {"mock", "serial_imu", "ublox_gnss"})
    EXPECT_NE(std::find(names.begin(), names.end(), name), names.end()) << name;
}

}  // namespace
}  // namespace polyarm
