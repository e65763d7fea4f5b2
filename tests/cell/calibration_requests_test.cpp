/// Requests that calibrate the joints of an arm and the payload of its hand; in lock-step.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "polyarm/base/error.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/kinematics/chain.hpp"
#include "polyarm/setup/robots.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm::cell {
namespace {

using test::Folder;
using test::Json;
using test::LockStepCell;

const char* const kCalibrationPoints =
    "Name: Seen\nPose: RPY\nPoint: 0.3, 0.1, 0.2, 0, 0, 1.5\nName: Home\nJS: joint_1\nPoint: 0\n";
const std::string kNoteOfUser = "# kept\n";

/// The arm of examples/r6bot with a sensor at the flange, which reads 1 2 -30 N and 0.5 -0.25 0 N m.
std::string weighing_arm() {
  std::string out = read_file(test::kSixAxes);
  const auto begin = out.find("<sensor name=\"tcp_fts_sensor\">"), end = out.find("</sensor>", begin);
  std::string sensor = "<sensor name=\"wrist\"><param name=\"frame_id\">tool0</param>";
  const std::pair<const char*, const char*> kStates[] = {{"force.x", "1"},      {"force.y", "2"},
                                                         {"force.z", "-30"},    {"torque.x", "0.5"},
                                                         {"torque.y", "-0.25"}, {"torque.z", "0"}};
  for (const auto& [name, value] : kStates)
    sensor += std::string("<state_interface name=\"") + name + "\"><param name=\"initial_value\">" + value +
              "</param></state_interface>";
  return out.replace(begin, end - begin, sensor);
}

class CalibrationRequests : public ::testing::Test {
 protected:
  CalibrationRequests() { begin(""); }

  /// `keys` of the robot, behind its model.
  void begin(const std::string& keys) {
    cell.reset();
    folder.write("arm.urdf", weighing_arm());
    folder.write("heavy.yaml", "polyarm: tool/1\ntcp: [0, 0, 100mm]\nmass: 1kg\ncenter: [0, 0, 50mm]\n");
    folder.write("cell.yaml", kNoteOfUser +
                                  "polyarm: cell/1\nrobots:\n  arm: {model: arm.urdf, hardware: mock" + keys +
                                  "}\nprogram: main.script\n");
    folder.write("points.points", kCalibrationPoints);
    folder.write("main.script", "load points\n");
    cell = std::make_unique<LockStepCell>(read_cell_file(folder.path()));
    cell->run(0.2);
  }
  Json result(const Json& request) { return cell->result(request); }
  std::string refused(const Json& request) {
    const Json answer = cell->ask(request);
    return answer.value("ok", false) ? "ok"
                                     : answer["error"]["code"].get<std::string>() + ": " +
                                           answer["error"]["what"].get<std::string>();
  }
  std::string cell_text() { return read_file(folder.path() / "cell.yaml"); }
  const CellRobot& robot() {
    Problems problems;
    std::vector<std::string> notes;
    robots =
        resolve_robots(read_cell_file(folder.path()), description::Catalogue({}), false, problems, notes);
    return *robots.front();
  }

  /// What a device sees of a target on the hand of an arm with these joint errors.
  Json poses(std::size_t n, const std::vector<double>& errors, double noise = 1e-5) {
    const description::RobotModel& model = robot().model;
    const kinematics::Chain chain(model, model.tool_link());
    std::mt19937 draw(7);
    std::normal_distribution<double> spread(0, noise);
    std::uniform_real_distribution<double> angle(-1.5, 1.5);
    Json out = Json::array();
    for (std::size_t k = 0; k < n; ++k) {
      std::vector<double> q, real;
      Json joints;
      for (std::size_t j = 0; j < chain.joints(); ++j) {
        q.push_back(angle(draw));
        real.push_back(q.back() + errors[j]);
        joints[model.joint_names()[j]] = q.back();
      }
      const Pose at = chain.forward(real) * Pose{{0.01, 0.02, 0.03}, from_rpy(0.1, 0.2, 0.3)};
      const Quaternion& r = at.rotation;
      const Vec3 p = at.position + Vec3{spread(draw), spread(draw), spread(draw)};
      out.push_back(
          {{"joints", joints}, {"measured", {{"p", {p.x, p.y, p.z}}, {"q", {r.x, r.y, r.z, r.w}}}}});
    }
    return out;
  }
  /// Readings of a load at rest, with the sensor's zero elsewhere.
  static Json forces(std::size_t n, double mass, const Vec3& center, std::size_t wrong = 1000) {
    std::mt19937 draw(3);
    std::normal_distribution<double> any(0, 1), noise(0, 0.01);
    Json out = Json::array();
    for (std::size_t k = 0; k < n; ++k) {
      const Quaternion r = normalized(Quaternion{any(draw), any(draw), any(draw), any(draw)});
      Vec3 f = inverse(r) * Vec3{0, 0, -mass * 9.81};
      const Vec3 m = cross(center, f) + Vec3{0.1, 0.2, -0.1};
      f = f + Vec3{3 + noise(draw), -2 + noise(draw), 1 + noise(draw)};
      if (k == wrong) f.x += 5;
      out.push_back({{"flange", {{"p", {0, 0, 0}}, {"q", {r.x, r.y, r.z, r.w}}}},
                     {"force", {f.x, f.y, f.z}},
                     {"torque", {m.x, m.y, m.z}}});
    }
    return out;
  }

  Folder folder;
  std::unique_ptr<LockStepCell> cell;
  CellRobots robots;
};

const std::vector<double> kJointErrors{0, 0.01, -0.02, 0.015, 0.005, 0};

TEST_F(CalibrationRequests, ASampleHasJointsFlangeAndWhatTheDeviceSaw) {
  const Json seen = result({{"request", "calibrate.sample"}, {"marker", "Seen"}});
  EXPECT_EQ(seen["joints"].size(), 6u) << seen;
  EXPECT_NEAR(seen["measured"]["p"][2].get<double>(), 0.2, 1e-12);
  EXPECT_GT(seen["age"].get<double>(), 0.1);
  EXPECT_FALSE(seen.contains("force"));
  EXPECT_EQ(refused({{"request", "calibrate.sample"}, {"marker", "Home"}}),
            "bad-points: 'Home' is a joint state");
}

TEST_F(CalibrationRequests, ForcesAreTheMeanOfHalfASecondAtTheFlange) {
  const double before = seconds(cell->cell().loop().cycle().time);
  const Json felt = result({{"request", "calibrate.sample"}, {"forces", true}});
  EXPECT_GT(seconds(cell->cell().loop().cycle().time), before + 0.5);
  ASSERT_TRUE(felt.contains("force")) << felt;
  EXPECT_NEAR(felt["force"][2].get<double>(), -30, 1e-9);
  EXPECT_NEAR(felt["torque"][0].get<double>(), 0.5, 1e-9);
  EXPECT_NEAR(felt["noise"].get<double>(), 0, 1e-6);
}

TEST_F(CalibrationRequests, AMovingRobotGivesNoSample) {
  folder.write("main.script", "load points\nmovej joints(1rad, 0.5rad, 0, 0, 0, 0)\n");
  cell = std::make_unique<LockStepCell>(read_cell_file(folder.path()));
  cell->run(0.3);
  ASSERT_FALSE(cell->cell().snapshot().standing);
  EXPECT_EQ(refused({{"request", "calibrate.sample"}}), "moving: 'arm' moves");

  folder.write("main.script", "movej joints(1rad, 0.5rad, 0, 0, 0, 0), robot other\n");
  folder.write("cell.yaml",
               "polyarm: cell/1\nrobots:\n  arm: {model: arm.urdf, hardware: mock}\n"
               "  other: {model: arm.urdf, hardware: mock, at: [0, 2, 0]}\nprogram: main.script\n");
  cell = std::make_unique<LockStepCell>(read_cell_file(folder.path()));
  cell->run(0.3);
  ASSERT_FALSE(cell->cell().snapshot().standing);
  EXPECT_EQ(refused({{"request", "calibrate.sample"}, {"robot", "arm"}}),
            "moving: something in the cell moves");
}

TEST_F(CalibrationRequests, WithoutForcesThatIsSaid) {
  folder.write("cell.yaml", "polyarm: cell/1\nrobots:\n  arm: {model: " + test::kSixAxes +
                                ", hardware: mock}\nprogram: main.script\n");
  cell = std::make_unique<LockStepCell>(read_cell_file(folder.path()));
  EXPECT_TRUE(refused({{"request", "calibrate.sample"}, {"forces", true}}).starts_with("no-force-reading: "));
}

TEST_F(CalibrationRequests, JointOffsetsAreFoundStoredUsedAndTakenBack) {
  const std::string before = cell_text();
  const Json samples = poses(30, kJointErrors);
  Json ask{{"request", "calibrate.joints"}, {"samples", samples}, {"in_base", true}, {"dry", true}};
  const Json found = result(ask);
  ASSERT_EQ(found["joints"].size(), 6u) << found;
  for (std::size_t j = 1; j < 5; ++j) {
    EXPECT_TRUE(found["joints"][j]["identifiable"].get<bool>()) << found["joints"][j];
    EXPECT_NEAR(found["joints"][j]["offset"].get<double>(), kJointErrors[j], 1e-4);
  }
  EXPECT_FALSE(found["joints"][5]["identifiable"].get<bool>()) << "the target on the hand turns with it";
  EXPECT_GT(found["position_before"].get<double>(), 50 * found["position_rms"].get<double>());
  EXPECT_GT(found["shift"].get<double>(), 1e-3);
  EXPECT_FALSE(found.contains("outlier"));
  EXPECT_EQ(cell_text(), before) << "it was only looked at";

  ask["dry"] = false;
  EXPECT_EQ(result(ask)["file"], "arm_calibration.yaml");
  EXPECT_NE(cell_text().find("calibration: arm_calibration.yaml"), std::string::npos);
  EXPECT_TRUE(cell_text().starts_with(kNoteOfUser));
  // The cell that starts again has the corrected arm: the same samples agree with it.
  const Json again{{"request", "calibrate.joints"},
                   {"samples", samples},
                   {"in_base", true},
                   {"check", true},
                   {"dry", true}};
  EXPECT_GT(result(again)["position_rms"].get<double>(), 1e-3) << "not yet";
  cell = std::make_unique<LockStepCell>(read_cell_file(folder.path()));
  const Json fits = result(again);
  EXPECT_LT(fits["position_rms"].get<double>(), 1e-4) << fits;
  EXPECT_EQ(fits["joints"].size(), 0u);

  EXPECT_EQ(result(ask)["file"], "arm_calibration_2.yaml") << "the geometry in use stays for the undo";
  EXPECT_EQ(result({{"request", "calibrate.undo"}})["key"], "calibration");
  EXPECT_NE(cell_text().find("calibration: arm_calibration.yaml"), std::string::npos);
  EXPECT_EQ(result({{"request", "calibrate.undo"}})["robot"], "arm");
  EXPECT_EQ(cell_text(), before);
  EXPECT_TRUE(refused({{"request", "calibrate.undo"}}).starts_with("no-history"));
}

TEST_F(CalibrationRequests, PosesThatDoNotDetermineTheArmAreRefusedWithTheReason) {
  const auto why = [&](const Json& samples) {
    return refused({{"request", "calibrate.joints"}, {"samples", samples}, {"dry", true}});
  };
  EXPECT_EQ(why(poses(3, kJointErrors)), "bad-points: 18 numbers need 4 poses, here are 3");
  Json same = Json::array();
  for (int k = 0; k < 20; ++k) same.push_back(poses(1, kJointErrors)[0]);
  EXPECT_TRUE(why(same).starts_with("bad-points: ")) << why(same);
  Json half = poses(30, kJointErrors);
  half[4]["joints"].erase("joint_3");
  EXPECT_EQ(why(half), "bad-argument: 'joints' of a sample has no number for the joint 'joint_3'");
  EXPECT_EQ(why("none").substr(0, 12), "bad-argument");
}

TEST_F(CalibrationRequests, ASampleThatContradictsTheOthersIsNamedAndNothingIsStored) {
  const std::string before = cell_text();
  Json samples = poses(30, kJointErrors);
  samples[11]["measured"]["p"][0] = samples[11]["measured"]["p"][0].get<double>() + 0.01;
  Json ask{{"request", "calibrate.joints"}, {"samples", samples}, {"dry", true}};
  EXPECT_EQ(result(ask)["outlier"], 11.0);
  ask["dry"] = false;
  EXPECT_TRUE(refused(ask).starts_with("bad-points: sample 12 contradicts the others"));
  Json weighed{{"request", "calibrate.payload"}, {"samples", forces(12, 2, {0, 0, 0.1}, 7)}};
  EXPECT_TRUE(refused(weighed).starts_with("bad-points: sample 8 contradicts the others"));
  EXPECT_EQ(cell_text(), before);
}

TEST_F(CalibrationRequests, APayloadIsWhatTheHandCarriesBesidesItsTool) {
  begin(", tool: heavy");
  const std::string before = cell_text();
  // 1 kg of the tool at 50 mm, and 2 kg at 200 mm.
  const Json samples = forces(12, 3, {0, 0, 0.15});
  Json ask{{"request", "calibrate.payload"}, {"samples", samples}, {"dry", true}};
  const Json found = result(ask);
  EXPECT_NEAR(found["mass"].get<double>(), 2, 0.01) << found;
  EXPECT_NEAR(found["center"][2].get<double>(), 0.2, 0.002);
  EXPECT_EQ(found["tool_mass"], 1.0);
  EXPECT_EQ(found["unit"], "N");
  EXPECT_EQ(found["residuals"].size(), 12u);
  EXPECT_EQ(cell_text(), before);
  Json check{{"request", "calibrate.payload"}, {"samples", samples}, {"check", true}, {"dry", true}};
  EXPECT_GT(result(check)["rms"].get<double>(), 5) << "the cell does not know of the 2 kg yet";
  ask["dry"] = false;
  EXPECT_EQ(result(ask)["file"], "cell.yaml");
  cell = std::make_unique<LockStepCell>(read_cell_file(folder.path()));
  EXPECT_LT(result(check)["rms"].get<double>(), 0.1);
  EXPECT_EQ(result({{"request", "calibrate.undo"}})["key"], "payload");
  EXPECT_EQ(cell_text(), before);
}

TEST_F(CalibrationRequests, AHandThatCarriesNothingOrDoesNotTurnIsRefused) {
  begin(", tool: heavy");
  const auto why = [&](const Json& samples) {
    return refused({{"request", "calibrate.payload"}, {"samples", samples}, {"dry", true}});
  };
  EXPECT_NE(why(forces(12, 1, {0, 0, 0.05})).find("nothing is left for a payload"), std::string::npos);
  Json same = Json::array();
  for (int k = 0; k < 12; ++k) same.push_back(forces(1, 3, {0, 0, 0.1})[0]);
  EXPECT_NE(why(same).find("hardly changes its direction"), std::string::npos) << why(same);
  EXPECT_EQ(why(Json::array()), "bad-points: there are no samples");
}

TEST_F(CalibrationRequests, AnUndoNeverLosesAnotherChange) {
  const Json ask{{"request", "calibrate.payload"}, {"samples", forces(12, 2, {0, 0, 0.1})}};
  ASSERT_TRUE(result(ask).contains("file"));
  folder.write("cell.yaml", cell_text() + "# a note\n");
  const std::string changed = cell_text();
  EXPECT_TRUE(refused({{"request", "calibrate.undo"}}).starts_with("changed-meanwhile"));
  EXPECT_EQ(cell_text(), changed);
}

}  // namespace
}  // namespace polyarm::cell
