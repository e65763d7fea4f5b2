/// The catalogue as the command shows it: finding, adding, drawing.
#include "polyarm/catalogue/catalogue.hpp"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <array>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <set>

#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/description/tools.hpp"
#include "polyarm/kinematics/chain.hpp"
#include "tests/support/command.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm {
namespace {

namespace fs = std::filesystem;
using test::Finished;
using test::Folder;
using test::run_command;

const std::string kRobots = POLYARM_SOURCE_DIR "/robots";

nlohmann::json found(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "robots");
  arguments.emplace_back("--json");
  return nlohmann::json::parse(run_command(arguments).output);
}

TEST(RobotsCommand, FindsByEveryFigure) {
  const auto robots =
      found({"--maker", "Universal Robots", "--reach", ">=1.2", "--payload", "10..20", "--sort", "-payload"});
  ASSERT_GE(robots.size(), 2u);
  double last = 1e9;
  for (const auto& robot : robots) {
    EXPECT_EQ(robot["maker"], "Universal Robots");
    EXPECT_GE(robot["reach_m"].get<double>(), 1.2);
    EXPECT_LE(robot["payload_kg"].get<double>(), last);
    last = robot["payload_kg"].get<double>();
  }
  EXPECT_LE(last, 20);
  for (const auto& robot : found({"--axes", "7"})) EXPECT_EQ(robot["axes"], 7);
  EXPECT_TRUE(found({"--mass", "<1g"}).empty());
}

TEST(RobotsCommand, SaysWhatIsWrongWithAQuestion) {
  for (const auto& [option, text, piece] :
       {std::array<const char*, 3>{"--reach", "far", "--reach: 'far' is not a range"},
        {"--payload", "3m", "--payload"},
        {"--maker", "fanuk", "did you mean 'fanuc'"},
        {"--sort", "raech", "did you mean 'reach'"}}) {
    const Finished asked = run_command({"robots", option, text});
    EXPECT_NE(asked.exit_code, 0);
    EXPECT_NE(asked.output.find(piece), std::string::npos) << asked.output;
  }
}

TEST(RobotsCommand, ComparesALookWithTheMeshesOfADescription) {
  const Folder folder;
  folder.write("plate.stl",
               "solid plate\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0.1 0 0\nvertex 0 0.1 0\n"
               "endloop\nendfacet\nendsolid plate\n");
  folder.write(
      "arm.urdf.xacro",
      "<robot name=\"arm\" xmlns:xacro=\"http://wiki.ros.org/xacro\"><xacro:arg name=\"link\" "
      "default=\"no_link\"/>"
      "<link name=\"base\"/><link name=\"$(arg link)\"><visual><geometry><mesh filename=\"plate.stl\"/>"
      "</geometry></visual></link><joint name=\"j\" type=\"revolute\"><parent link=\"base\"/>"
      "<child link=\"$(arg link)\"/><axis xyz=\"0 0 1\"/>"
      "<limit lower=\"-1\" upper=\"1\" velocity=\"1\" effort=\"1\"/></joint></robot>\n");
  const std::string file = (folder.path() / "arm.urdf.xacro").string();
  const Finished fit =
      run_command({"robots", "fit", "universal_robots/ur5e", file, "link:=upper_arm_link", "--csv"});
  ASSERT_EQ(fit.exit_code, 0) << fit.output;
  EXPECT_NE(fit.output.find("universal_robots/ur5e,1,"), std::string::npos) << fit.output;
  const std::string look = (folder.path() / "ur5e.look").string();
  const Finished measured =
      run_command({"robots", "fit", "universal_robots/ur5e", file, "link:=upper_arm_link", "--out", look});
  EXPECT_NE(measured.exit_code, 0);
  EXPECT_NE(measured.output.find("than the robot file says"), std::string::npos) << measured.output;
  EXPECT_FALSE(std::filesystem::exists(look)) << "surfaces of another robot are not kept";
  const Finished other = run_command({"robots", "fit", "universal_robots/ur5e", file});
  EXPECT_NE(other.exit_code, 0);
  EXPECT_NE(other.output.find("has no mesh on a link"), std::string::npos) << other.output;
}

/// A configuration folder of its own for every command that runs meanwhile.
class OwnConfiguration : public ::testing::Test {
 protected:
  OwnConfiguration() { ::setenv("XDG_CONFIG_HOME", folder_.path().c_str(), 1); }
  ~OwnConfiguration() override { ::unsetenv("XDG_CONFIG_HOME"); }
  const Folder folder_;
};
using RobotsAdd = OwnConfiguration;

TEST_F(RobotsAdd, TakesADescriptionThatThenLoadsEverywhere) {
  const std::string urdf = POLYARM_SOURCE_DIR "/examples/r6bot/r6bot.urdf";
  const Finished added = run_command({"robots", "add", urdf, "--name", "acme/one"});
  ASSERT_EQ(added.exit_code, 0) << added.output;
  EXPECT_EQ(found({"--maker", "acme"}).size(), 1u);
  for (const char* name : {"acme/one", "one"}) {
    EXPECT_EQ(run_command({"describe", name}).exit_code, 0) << name;
    EXPECT_EQ(run_command({"fk", name}).exit_code, 0) << name;
  }
  const auto place = [](const std::string& robot) {
    const std::string pose = run_command({"fk", robot}).output;
    return pose.substr(0, pose.find('\n'));
  };
  EXPECT_EQ(place("acme/one"), place(urdf));
  const Finished again = run_command({"robots", "add", urdf, "--name", "acme/one"});
  EXPECT_EQ(again.exit_code, 1);
  EXPECT_NE(again.output.find("--replace"), std::string::npos) << again.output;
  EXPECT_EQ(run_command({"robots", "add", urdf, "--name", "acme/one", "--replace"}).exit_code, 0);
}

TEST_F(RobotsAdd, ReplacesARobotFileOfTheSameName) {
  const std::string urdf = POLYARM_SOURCE_DIR "/examples/r6bot/r6bot.urdf";
  const fs::path maker = folder_.path() / "polyarm/robots/acme";
  fs::create_directories(maker);
  fs::copy_file(POLYARM_SOURCE_DIR "/robots/universal_robots/ur5e.yaml", maker / "one.yaml");
  fs::copy_file(POLYARM_SOURCE_DIR "/robots/universal_robots/ur5e.look", maker / "one.look");
  EXPECT_EQ(run_command({"robots", "add", urdf, "--name", "acme/one"}).exit_code, 1);
  const Finished added = run_command({"robots", "add", urdf, "--name", "acme/one", "--replace"});
  ASSERT_EQ(added.exit_code, 0) << added.output;
  const Finished described = run_command({"describe", "acme/one"});
  EXPECT_NE(described.output.find("joint_1"), std::string::npos) << described.output;
  EXPECT_EQ(described.output.find("shoulder_pan_joint"), std::string::npos) << described.output;
  EXPECT_FALSE(fs::exists(maker / "one.look"));
}

using Looks = OwnConfiguration;

TEST_F(Looks, ThatAreDamagedAreReportedWhereTheRobotIsRead) {
  const fs::path maker = folder_.path() / "polyarm/robots/acme";
  fs::create_directories(maker);
  fs::copy_file(POLYARM_SOURCE_DIR "/robots/universal_robots/ur5e.yaml", maker / "one.yaml");
  const test::Folder cell;
  cell.write("cell.yaml", "polyarm: cell/1\nrobots:\n  arm: {model: acme/one, hardware: mock}\n");
  const auto output = [&](const std::string& verb) {
    const Finished run = run_command({verb, verb == "check" ? cell.path().string() : "acme/one"});
    EXPECT_EQ(run.exit_code, 0) << run.output;
    return run.output;
  };
  for (const char* verb : {"describe", "check"}) EXPECT_EQ(output(verb).find("one.look"), std::string::npos);
  write_file_atomically(maker / "one.look",
                        "polyarm: look/1\nlinks:\n  forearm_link:\n    - {frame: \"0 0\"}\n");
  for (const char* verb : {"describe", "check"}) {
    const std::string said = output(verb);
    EXPECT_NE(said.find("one.look:4"), std::string::npos) << said;
    EXPECT_NE(said.find("is drawn without its measured surfaces"), std::string::npos) << said;
  }
}

using RobotsRemove = OwnConfiguration;

TEST_F(RobotsRemove, TakesAwayWhatWasAddedAndNothingElse) {
  const std::string urdf = POLYARM_SOURCE_DIR "/examples/r6bot/r6bot.urdf";
  for (const char* name : {"acme/one", "acme/two"})
    ASSERT_EQ(run_command({"robots", "add", urdf, "--name", name}).exit_code, 0);
  const Finished removed = run_command({"robots", "remove", "acme/one"});
  EXPECT_EQ(removed.exit_code, 0) << removed.output;
  const auto left = found({"--maker", "acme"});
  ASSERT_EQ(left.size(), 1u);
  EXPECT_EQ(left[0]["name"], "acme/two");
  EXPECT_EQ(run_command({"robots", "remove", "acme/two"}).exit_code, 0);
  EXPECT_FALSE(fs::exists(folder_.path() / "polyarm/robots/acme"));
}

TEST_F(RobotsRemove, SaysWhatThereIsWhereTheNameIsNone) {
  const std::string urdf = POLYARM_SOURCE_DIR "/examples/r6bot/r6bot.urdf";
  ASSERT_EQ(run_command({"robots", "add", urdf, "--name", "acme/one"}).exit_code, 0);
  for (const auto& [name, piece] : {std::array<const char*, 2>{"acme/oen", "did you mean 'acme/one'"},
                                    {"universal_robots/ur5e", "there are: acme/one"},
                                    {"../acme/one", "is not a name"}}) {
    const Finished asked = run_command({"robots", "remove", name});
    EXPECT_NE(asked.exit_code, 0) << name;
    EXPECT_NE(asked.output.find(piece), std::string::npos) << asked.output;
  }
  EXPECT_EQ(found({"--maker", "acme"}).size(), 1u);
}

TEST_F(RobotsAdd, RefusesWhatIsNoArmWithReasons) {
  const auto refused = [&](const std::string& joints, const char* piece) {
    const std::string urdf = folder_.write(
        "arm.urdf", "<robot name=\"a\"><link name=\"base\"/><link name=\"tip\"/>" + joints + "</robot>");
    const Finished added = run_command({"robots", "add", urdf});
    EXPECT_NE(added.exit_code, 0) << joints;
    EXPECT_NE(added.output.find(piece), std::string::npos) << added.output;
    EXPECT_FALSE(fs::exists(folder_.path() / "polyarm")) << joints;
  };
  const std::string ends = "<parent link=\"base\"/><child link=\"tip\"/>";
  refused("<joint name=\"j\" type=\"fixed\">" + ends + "</joint>", "no joint that moves");
  refused("<joint name=\"j\" type=\"prismatic\">" + ends + "</joint>", "'j'");
  refused("<joint name=\"j\" type=\"floating\">" + ends + "</joint>", "j");
  refused("<joint name=\"j\" type=\"revolute\"><parent link=\"base\"/><child link=\"tp\"/></joint>", "tp");
}

TEST_F(RobotsAdd, RefusesANameThatIsNone) {
  const std::string urdf = POLYARM_SOURCE_DIR "/examples/r6bot/r6bot.urdf";
  for (const char* name : {"one", "Acme/One", "../one/two", "a/b/c", "/one"})
    EXPECT_NE(run_command({"robots", "add", urdf, "--name", name}).exit_code, 0) << name;
}

// --- pictures

/// Equal but for numbers, which may differ in their last place from one compiler to another.
void expect_alike(const std::string& a, const std::string& b, const std::string& file) {
  std::size_t i = 0, k = 0;
  const auto digit = [](char c) {
    return std::isdigit(static_cast<unsigned char>(c)) || c == '.' || c == '-';
  };
  while (i < a.size() && k < b.size()) {
    if (digit(a[i]) && digit(b[k])) {
      std::size_t ni = i, nk = k;
      while (ni < a.size() && digit(a[ni])) ++ni;
      while (nk < b.size() && digit(b[nk])) ++nk;
      const std::string x = a.substr(i, ni - i), y = b.substr(k, nk - k);
      if (x != y) {
        const auto nx = parse_number(x), ny = parse_number(y);
        ASSERT_TRUE(nx && ny && std::abs(*nx - *ny) < 0.11) << file << ": " << x << " and " << y;
      }
      i = ni;
      k = nk;
      continue;
    }
    ASSERT_EQ(a[i], b[k]) << file << " near " << a.substr(i, 40);
    ++i;
    ++k;
  }
  EXPECT_EQ(a.size() - i, b.size() - k) << file;
}

std::set<std::string> files_in(const fs::path& folder) {
  std::set<std::string> out;
  for (const auto& file : fs::recursive_directory_iterator(folder))
    if (file.is_regular_file()) out.insert(fs::relative(file.path(), folder).string());
  return out;
}

TEST(RobotsPage, WhatIsInTheDocsIsWhatTheCommandWrites) {
  const Folder folder;
  const Finished written = run_command({"robots", "page", folder.path().string(), "--catalogue", kRobots});
  ASSERT_EQ(written.exit_code, 0) << written.output;
  const fs::path docs = POLYARM_SOURCE_DIR "/docs/robots";
  ASSERT_EQ(files_in(folder.path()), files_in(docs));
  std::size_t pictures = 0, bytes = 0;
  for (const std::string& file : files_in(docs)) {
    const std::string text = read_file((folder.path() / file).string());
    const std::string known = read_file((docs / file).string());
    if (file.ends_with(".svg")) {
      // Another compiler rounds some pixels in another way.
      EXPECT_NEAR(static_cast<double>(text.size()), static_cast<double>(known.size()), 0.03 * static_cast<double>(known.size())) << file;
      EXPECT_EQ(text.substr(0, text.find("<image")), known.substr(0, known.find("<image"))) << file;
    } else {
      expect_alike(text, known, file);
    }
    if (HasFatalFailure()) return;
    pictures += file.ends_with(".svg");
    bytes += text.size();
    EXPECT_TRUE(!file.ends_with(".svg") || text.size() < 15'000) << file;
  }
  EXPECT_EQ(pictures, found({}).size());
  EXPECT_LT(bytes, 5'000'000u);
}

TEST(RobotsPicture, ShowsTheStateThatIsAskedFor) {
  const std::string home = run_command({"robots", "picture", "universal_robots/ur3"}).output;
  const std::string other =
      run_command({"robots", "picture", "universal_robots/ur3", "--joints", "0", "-1.57", "0", "0", "0", "0"})
          .output;
  EXPECT_TRUE(home.starts_with("<svg")) << home.substr(0, 200);
  EXPECT_TRUE(other.starts_with("<svg"));
  EXPECT_NE(home, other);
  EXPECT_NE(run_command({"robots", "picture", "universal_robots/ur3", "--joints", "0"}).exit_code, 0);
}

// --- workspace

std::vector<std::vector<std::string>> rows_of(const std::string& csv) {
  std::vector<std::vector<std::string>> out;
  for (const std::string& line : split_words(csv, "\n")) out.push_back(split_fields(line, ','));
  return out;
}

double value(const std::string& field) {
  return parse_number(field).value_or(NAN);
}

/// How many cells were reached; every one of them is where it says, with the tool down where that is asked.
std::size_t checked_map(const std::string& robot, const std::string& orientation) {
  const Folder folder;
  const std::string data = (folder.path() / "map.csv").string();
  const Finished made = run_command({"workspace", robot, "--resolution", "16", "--orientation", orientation,
                                     "--plane", "xz", "--at", "0.05", "--data", data});
  EXPECT_EQ(made.exit_code, 0) << made.output;
  const auto model = description::Catalogue({kRobots}).load(robot);
  const kinematics::Chain chain(model, model.tool_link());
  const auto rows = rows_of(read_file(data));
  EXPECT_EQ(rows.size(), 16u * 16 + 1);
  std::size_t reached = 0;
  for (std::size_t k = 1; k < rows.size(); ++k) {
    if (rows[k].at(3) != "1") continue;
    ++reached;
    std::vector<double> q;
    for (std::size_t i = 6; i < rows[k].size(); ++i) q.push_back(value(rows[k][i]));
    const Pose pose = chain.forward(q);
    EXPECT_LT(norm(pose.position - Vec3{value(rows[k][0]), value(rows[k][1]), value(rows[k][2])}), 1e-4);
    EXPECT_GE(value(rows[k][4]), 0);
    if (orientation == "down") {
      EXPECT_LT((pose.rotation * Vec3{0, 0, 1}).z, -0.9999);
    }
  }
  return reached;
}

TEST(Workspace, CellsThatAreReachedAreReached) {
  const std::size_t down = checked_map("universal_robots/ur5e", "down");
  const std::size_t any = checked_map("universal_robots/ur5e", "any");
  EXPECT_GT(down, 30u);
  EXPECT_GT(any, down);
  EXPECT_GT(checked_map("trossen_robotics/px100", "any"), 20u);  // four axes, by iteration
}

/// The robot of a cell where it stands, with its tool; what its workspace forbids is not reached.
TEST(Workspace, OfACellKeepsToItsPlaceItsToolAndItsZones) {
  const Folder folder;
  folder.write("cell.yaml",
               "polyarm: cell/1\nrobots:\n"
               "  arm: {model: universal_robots/ur5e, tool: suction_cup, at: [1, 0, 0.5]}\n"
               "workspace: {floor: {plane: [0, 0, 0.4], normal: [0, 0, 1]}}\n");
  const std::string data = (folder.path() / "map.csv").string();
  const Finished made =
      run_command({"workspace", "--cell", folder.path().string(), "--resolution", "20", "--data", data});
  ASSERT_EQ(made.exit_code, 0) << made.output;
  const auto model = description::Catalogue({kRobots}).load("universal_robots/ur5e");
  const kinematics::Chain chain(model, model.tool_link(), {{1, 0, 0.5}, {}},
                                description::find_tool("suction_cup", ".").tcp);
  const auto rows = rows_of(read_file(data));
  std::size_t reached = 0;
  for (std::size_t k = 1; k < rows.size(); ++k) {
    if (rows[k].at(3) != "1") continue;
    ++reached;
    const Vec3 place{value(rows[k][0]), value(rows[k][1]), value(rows[k][2])};
    EXPECT_GE(place.z, 0.4);
    std::vector<double> q;
    for (std::size_t i = 6; i < rows[k].size(); ++i) q.push_back(value(rows[k][i]));
    EXPECT_LT(norm(chain.forward(q).position - place), 1e-4);
  }
  EXPECT_GT(reached, 30u);
  const Finished other =
      run_command({"workspace", "amr", "--cell", folder.path().string(), "--resolution", "4"});
  EXPECT_NE(other.exit_code, 0);
  EXPECT_NE(other.output.find("did you mean 'arm'"), std::string::npos) << other.output;
}

TEST(Workspace, WritesPicturesAndRefusesWhatIsNone) {
  const Folder folder;
  const std::string png = (folder.path() / "map.png").string(), svg = (folder.path() / "map.svg").string();
  const std::vector<std::string> ask{"workspace", "abb/irb_120", "--resolution", "10", "--image"};
  const auto with = [&](const std::string& file) {
    std::vector<std::string> line = ask;
    line.push_back(file);
    return run_command(line);
  };
  EXPECT_EQ(with(png).exit_code, 0);
  EXPECT_EQ(with(svg).exit_code, 0);
  EXPECT_TRUE(read_file(png).starts_with("\x89PNG"));
  EXPECT_TRUE(read_file(svg).starts_with("<svg"));
  const Finished refused = with((folder.path() / "map.gif").string());
  EXPECT_NE(refused.exit_code, 0);
  EXPECT_NE(refused.output.find(".svg nor .png"), std::string::npos) << refused.output;
}

}  // namespace
}  // namespace polyarm
