#include "polyarm/data/taught_frames.hpp"

#include <gtest/gtest.h>

#include <random>

#include "polyarm/base/error.hpp"

namespace polyarm::data {
namespace {

class Draw {
 public:
  double real(double most) { return std::uniform_real_distribution(-most, most)(random_); }
  Vec3 vector(double most) { return {real(most), real(most), real(most)}; }
  Pose pose() { return {vector(1), normalized(Quaternion{real(1), real(1), real(1), real(1)})}; }

 private:
  std::mt19937 random_{17};
};

TEST(FrameFromPoints, FindsTheFrameThatThePointsWereTakenFrom) {
  Draw draw;
  for (int k = 0; k < 1000; ++k) {
    const Pose frame = draw.pose();
    const double x = 0.01 + std::abs(draw.real(1)), y = 0.05 + std::abs(draw.real(1));
    const Pose found =
        frame_from_points(frame.position, frame * Vec3{x, 0, 0}, frame * Vec3{draw.real(0.5), y, 0});
    EXPECT_LT(norm(found.position - frame.position), 1e-12);
    EXPECT_LT(angle_between(found.rotation, frame.rotation), 1e-7);
  }
}

TEST(FrameFromPoints, RefusesPointsThatSayNoFrame) {
  EXPECT_THROW(frame_from_points({0, 0, 0}, {0.0005, 0, 0}, {0, 1, 0}), Error);
  EXPECT_THROW(frame_from_points({0, 0, 0}, {1, 0, 0}, {2, 0, 0}), Error);
}

TEST(ToolFromPoses, FindsTheTcpAndTellsWhatIsLeft) {
  Draw draw;
  for (int k = 0; k < 200; ++k) {
    const Vec3 tcp = draw.vector(0.3), tip = draw.vector(1);
    std::vector<Pose> poses;
    for (int i = 0; i < 5; ++i) {
      const Quaternion turn = draw.pose().rotation;
      poses.push_back({tip - turn * tcp, turn});
    }
    const TaughtTool exact = tool_from_poses(poses);
    EXPECT_LT(norm(exact.tcp - tcp), 1e-9);
    EXPECT_LT(exact.largest, 1e-9);
    for (Pose& pose : poses) pose.position = pose.position + draw.vector(0.001);
    const TaughtTool noisy = tool_from_poses(poses);
    EXPECT_LT(norm(noisy.tcp - tcp), 0.02);
    EXPECT_GT(noisy.rms, 1e-6);
    EXPECT_LT(noisy.largest, 0.003);
    EXPECT_EQ(noisy.residuals.size(), 5u);
  }
}

TEST(ToolFromPoses, RefusesPosesThatDoNotSayIt) {
  const Pose same{{0.1, 0.2, 0.3}, {}};
  const Pose four[] = {same, same, same, same};
  EXPECT_THROW(tool_from_poses(four), Error);
  EXPECT_THROW(tool_from_poses(std::span(four, 3)), Error);
  std::vector<Pose> about_one_axis;
  for (const double angle : {0.0, 0.5, 1.0, 1.5})
    about_one_axis.push_back({{0, 0, 0}, from_axis_angle({0, 0, 1}, angle)});
  EXPECT_THROW(tool_from_poses(about_one_axis), Error);
}

}  // namespace
}  // namespace polyarm::data
