/// Frames and tools from touched places: laws over random truth and noise.
#include "polyarm/calibration/touch.hpp"

#include <gtest/gtest.h>

#include "polyarm/base/error.hpp"
#include "tests/calibration/noise.hpp"

namespace polyarm::calibration {
namespace {

template <typename Call>
std::string refusal(const Call& call) {
  try {
    call();
  } catch (const Error& e) {
    EXPECT_EQ(e.problems().front().code, "bad-points");
    EXPECT_FALSE(e.problems().front().advice.empty());
    return e.problems().front().what;
  }
  return "(not refused)";
}

std::vector<Pose> touching(Noise& noise, const Vec3& tcp, const Vec3& tip, std::size_t n, double sigma,
                           double angle = 0.6) {
  std::vector<Pose> out;
  for (std::size_t i = 0; i < n; ++i) {
    const Quaternion r = noise.turn(noise.within(angle)) * from_rpy(M_PI, 0, 0);
    out.push_back({tip - r * tcp + noise.vector(sigma), r});
  }
  return out;
}

TEST(Tool, IsExactWithoutNoise) {
  Noise noise(1);
  for (int k = 0; k < 200; ++k) {
    const Vec3 tcp = noise.within(0.3), tip = noise.within(1);
    const TouchedTool found = tool_from_poses(touching(noise, tcp, tip, 6, 0));
    EXPECT_LT(norm(found.tcp - tcp), 1e-11);
    EXPECT_LT(norm(found.tip - tip), 1e-11);
    EXPECT_FALSE(found.residuals.outlier);
  }
}

TEST(Tool, ErrorsAgreeWithTheStatedUncertaintyAndHaveNoBias) {
  Noise noise(2);
  const Vec3 tcp{0.02, -0.05, 0.18}, tip{0.5, 0.1, 0.1};
  constexpr int kRuns = 400;
  Vec3 sum;
  double square = 0, stated = 0;
  for (int k = 0; k < kRuns; ++k) {
    const TouchedTool found = tool_from_poses(touching(noise, tcp, tip, 12, 5e-4));
    sum = sum + (found.tcp - tcp);
    square += dot(found.tcp - tcp, found.tcp - tcp);
    stated += found.covariance[0] + found.covariance[4] + found.covariance[8];
  }
  const double sigma = std::sqrt(square / kRuns);
  EXPECT_LT(norm(sum) / kRuns, 3 * sigma / std::sqrt(double(kRuns)));
  EXPECT_NEAR(std::sqrt(stated / kRuns) / sigma, 1, 0.12);
}

TEST(Tool, ErrorsShrinkWithTheSquareRootOfTheNumberOfPoses) {
  Noise noise(3);
  const Vec3 tcp{0.02, -0.05, 0.18}, tip{0.5, 0.1, 0.1};
  const auto error_of = [&](std::size_t n) {
    double square = 0;
    for (int k = 0; k < 200; ++k) {
      const Vec3 off = tool_from_poses(touching(noise, tcp, tip, n, 5e-4)).tcp - tcp;
      square += dot(off, off) / 200;
    }
    return std::sqrt(square);
  };
  EXPECT_NEAR(error_of(10) / error_of(90), 3, 0.6);
}

TEST(Tool, FindsThePoseThatMissedThePlace) {
  Noise noise(4);
  int found = 0, wrong = 0;
  for (int k = 0; k < 100; ++k) {
    std::vector<Pose> poses = touching(noise, {0.02, -0.05, 0.18}, {0.5, 0.1, 0.1}, 8, 3e-4);
    wrong += tool_from_poses(poses).residuals.outlier.has_value();
    poses[5].position = poses[5].position + Vec3{0.006, -0.004, 0.003};
    const auto outlier = tool_from_poses(poses).residuals.outlier;
    found += outlier && outlier->sample == 5;
  }
  EXPECT_GE(found, 95);
  EXPECT_LE(wrong, 4);
}

TEST(Tool, RefusesPosesThatDoNotDetermineIt) {
  Noise noise(5);
  const Vec3 tcp{0, 0, 0.2}, tip{0.5, 0, 0.1};
  EXPECT_NE(refusal([&] { tool_from_poses(touching(noise, tcp, tip, 3, 0)); }).find("four poses"),
            std::string::npos);
  EXPECT_NE(refusal([&] { tool_from_poses(touching(noise, tcp, tip, 9, 0, 0.005)); }).find("hardly differ"),
            std::string::npos);
  std::vector<Pose> about_z;
  for (int i = 0; i < 8; ++i) {
    const Quaternion r = from_axis_angle({0, 0, 1}, 0.4 * i) * from_rpy(M_PI, 0, 0);
    about_z.push_back({tip - r * tcp, r});
  }
  const std::string why = refusal([&] { tool_from_poses(about_z); });
  EXPECT_NE(why.find("about one axis"), std::string::npos) << why;
  EXPECT_NE(why.find("1.00)"), std::string::npos) << why;
}

TEST(Tool, OrientationComesFromMotionsAlongItsAxes) {
  Noise noise(6);
  for (int k = 0; k < 100; ++k) {
    const Pose tcp = noise.any_pose(0.2), start = noise.any_pose(0.8);
    const Vec3 tip = (start * tcp).position;
    const auto after = [&](const Vec3& motion) {  // along the tool's axes, backwards
      const Vec3 shift = (start.rotation * tcp.rotation) * motion;
      return Pose{start.position - shift, start.rotation};
    };
    const Quaternion found =
        tool_rotation(tcp.position, tip, after({0, 0, 0.15}), after({0.1, 0, noise.uniform(-0.02, 0.02)}));
    EXPECT_LT(angle_between(found, tcp.rotation), 1e-7);
  }
}

TEST(Tool, AxisComesFromAFlatFace) {
  Noise noise(7);
  for (int k = 0; k < 100; ++k) {
    const Vec3 axis = normalized(Vec3{noise.normal(0.3), noise.normal(0.3), 1}),
               plane = normalized(noise.vector(1));
    std::vector<Pose> poses;
    for (int i = 0; i < 6; ++i) {
      const Quaternion flat = from_axis_angle(plane, i) * rotation_between(axis, plane);
      poses.push_back({noise.within(1), normalized(noise.turn(noise.vector(1e-3)) * flat)});
    }
    const FlatTool found = axis_from_flat_poses(poses);
    EXPECT_LT(norm(cross(found.axis, axis)), 4e-3);
    EXPECT_GT(dot(found.axis, axis), 0);
    EXPECT_LT(norm(cross(rotation_with_z(found.axis) * Vec3{0, 0, 1}, found.axis)), 1e-9);
  }
}

TEST(Tool, AFlatFaceThatDoesNotTurnIsRefused) {
  const std::vector<Pose> poses{{{}, {}}, {{0.1, 0, 0}, from_rpy(0, 0, 0.05)}};
  EXPECT_NE(refusal([&] { axis_from_flat_poses(poses); }).find("hardly turned"), std::string::npos);
}

TEST(Frame, FromThreePointsContainsThem) {
  Noise noise(8);
  for (int k = 0; k < 200; ++k) {
    const Pose frame = noise.any_pose(1);
    const Pose found = frame_from_points(frame * Vec3{}, frame * Vec3{0.3, 0, 0}, frame * Vec3{0.1, 0.2, 0});
    EXPECT_LT(norm(found.position - frame.position), 1e-12);
    EXPECT_LT(angle_between(found.rotation, frame.rotation), 1e-7);
  }
  EXPECT_NE(refusal([] {
              frame_from_points({}, {0.2, 0, 0}, {0.4, 0.001, 0});
            }).find("on a line"),
            std::string::npos);
  EXPECT_NE(refusal([] {
              frame_from_points({}, {0.0005, 0, 0}, {0, 1, 0});
            }).find("less than 1 mm"),
            std::string::npos);
}

struct Places {
  std::vector<Vec3> known, measured;
};
Places places(Noise& noise, const Pose& frame, std::size_t n, double sigma) {
  Places out;
  for (std::size_t i = 0; i < n; ++i) {
    out.known.push_back(noise.within(0.3));
    out.measured.push_back(frame * out.known.back() + noise.vector(sigma));
  }
  return out;
}

TEST(MatchedFrame, ErrorsShrinkAndAgreeWithTheStatedUncertainty) {
  Noise noise(9);
  const auto error_of = [&](std::size_t n, double& stated) {
    double square = 0;
    stated = 0;
    for (int k = 0; k < 200; ++k) {
      const Pose frame = noise.any_pose(1);
      const Places at = places(noise, frame, n, 1e-3);
      const MatchedFrame found = frame_from_matches(at.known, at.measured);
      const Vec3 off = found.frame.pose.position - frame.position;
      square += dot(off, off) / 200;
      stated += (found.frame.covariance[0] + found.frame.covariance[7] + found.frame.covariance[14]) / 200;
    }
    stated = std::sqrt(stated);
    return std::sqrt(square);
  };
  double few_stated = 0, many_stated = 0;
  const double few = error_of(8, few_stated), many = error_of(72, many_stated);
  EXPECT_NEAR(few / many, 3, 0.6);
  EXPECT_NEAR(few_stated / few, 1, 0.2);
  EXPECT_NEAR(many_stated / many, 1, 0.2);
}

TEST(MatchedFrame, RefusesPlacesOnALineAndFindsTheWrongOne) {
  Noise noise(10);
  const Pose frame = noise.any_pose(1);
  std::vector<Vec3> line, there;
  for (int i = 0; i < 5; ++i) {
    line.push_back({0.1 * i, 0.2 * i, 0});
    there.push_back(frame * line.back());
  }
  EXPECT_NE(refusal([&] { frame_from_matches(line, there); }).find("on one line"), std::string::npos);
  Places at = places(noise, frame, 7, 2e-4);
  at.measured[2] = at.measured[2] + Vec3{0.01, 0, 0};
  const auto outlier = frame_from_matches(at.known, at.measured).residuals.outlier;
  ASSERT_TRUE(outlier);
  EXPECT_EQ(outlier->sample, 2u);
  EXPECT_GT(outlier->improvement, 3);
}

}  // namespace
}  // namespace polyarm::calibration
