/// Cameras on the hand and beside the robot: laws over random truth and noise.
#include "polyarm/calibration/hand_eye.hpp"

#include <gtest/gtest.h>

#include "polyarm/base/error.hpp"
#include "tests/calibration/noise.hpp"

namespace polyarm::calibration {
namespace {

struct Truth {
  Pose camera, marker;
};

std::vector<Sighting> sightings(Noise& noise, const Truth& truth, CameraPlace place, std::size_t n,
                                double position, double rotation, double angle = 0.6) {
  std::vector<Sighting> out;
  for (std::size_t i = 0; i < n; ++i) {
    const Pose flange{Vec3{0.5, 0, 0.4} + noise.within(0.15),
                      noise.turn(noise.within(angle)) * from_rpy(M_PI, 0, 0)};
    const Pose seen = place == CameraPlace::on_hand ? inverse(flange * truth.camera) * truth.marker
                                                    : inverse(truth.camera) * flange * truth.marker;
    out.push_back({flange, noise.measured(seen, position, rotation)});
  }
  return out;
}
Truth any_truth(Noise& noise) {
  return {noise.any_pose(0.1), noise.any_pose(0.5)};
}
constexpr CameraPlace kBoth[] = {CameraPlace::on_hand, CameraPlace::beside};

TEST(HandEye, IsExactWithoutNoise) {
  Noise noise(1);
  for (const CameraPlace place : kBoth)
    for (int k = 0; k < 100; ++k) {
      const Truth truth = any_truth(noise);
      const HandEye found = hand_eye(sightings(noise, truth, place, 5, 0, 0), place);
      EXPECT_LT(norm(found.camera.pose.position - truth.camera.position), 1e-8);
      EXPECT_LT(angle_between(found.camera.pose.rotation, truth.camera.rotation), 1e-7);
      EXPECT_LT(norm(found.marker.pose.position - truth.marker.position), 1e-8);
      EXPECT_FALSE(found.residuals.outlier);
    }
}

TEST(HandEye, ErrorsAgreeWithTheStatedUncertaintyAndHaveNoBias) {
  for (const CameraPlace place : kBoth) {
    Noise noise(2);
    const Truth truth = any_truth(noise);
    constexpr int kRuns = 150;
    Vec3 sum, turn;
    double square = 0, angle = 0, stated = 0, stated_angle = 0;
    for (int k = 0; k < kRuns; ++k) {
      const HandEye found = hand_eye(sightings(noise, truth, place, 15, 1e-3, 3e-3), place);
      const Vec3 off = found.camera.pose.position - truth.camera.position;
      const Vec3 by = to_rotation_vector(found.camera.pose.rotation * inverse(truth.camera.rotation));
      sum = sum + off;
      turn = turn + by;
      square += dot(off, off) / kRuns;
      angle += dot(by, by) / kRuns;
      const auto& c = found.camera.covariance;
      stated += (c[0] + c[7] + c[14]) / kRuns;
      stated_angle += (c[21] + c[28] + c[35]) / kRuns;
    }
    EXPECT_LT(norm(sum) / kRuns, 3 * std::sqrt(square / kRuns));
    EXPECT_LT(norm(turn) / kRuns, 3 * std::sqrt(angle / kRuns));
    EXPECT_NEAR(std::sqrt(stated / square), 1, 0.2);
    EXPECT_NEAR(std::sqrt(stated_angle / angle), 1, 0.2);
  }
}

TEST(HandEye, ErrorsShrinkWithTheSquareRootOfTheNumberOfSightings) {
  Noise noise(3);
  const auto error_of = [&](std::size_t n) {
    double square = 0;
    for (int k = 0; k < 60; ++k) {
      const Truth truth = any_truth(noise);
      const HandEye found =
          hand_eye(sightings(noise, truth, CameraPlace::on_hand, n, 1e-3, 3e-3), CameraPlace::on_hand);
      const Vec3 off = found.camera.pose.position - truth.camera.position;
      square += dot(off, off) / 60;
    }
    return std::sqrt(square);
  };
  EXPECT_NEAR(error_of(10) / error_of(40), 2, 0.6);
}

TEST(HandEye, FindsTheSightingThatDoesNotFit) {
  Noise noise(4);
  int found = 0, wrong = 0;
  for (int k = 0; k < 50; ++k) {
    auto all = sightings(noise, any_truth(noise), CameraPlace::on_hand, 10, 5e-4, 2e-3);
    wrong += hand_eye(all, CameraPlace::on_hand).residuals.outlier.has_value();
    all[3].marker = noise.measured(all[3].marker, 0.01, 0.04);
    const auto outlier = hand_eye(all, CameraPlace::on_hand).residuals.outlier;
    found += outlier && outlier->sample == 3;
  }
  EXPECT_GE(found, 47);
  EXPECT_LE(wrong, 3);
}

std::string refusal(std::span<const Sighting> all) {
  try {
    hand_eye(all, CameraPlace::on_hand);
  } catch (const Error& e) {
    EXPECT_FALSE(e.problems().front().advice.empty());
    return e.problems().front().what;
  }
  return "(not refused)";
}

TEST(HandEye, RefusesSightingsThatDoNotDetermineIt) {
  Noise noise(5);
  const Truth truth = any_truth(noise);
  const auto few = sightings(noise, truth, CameraPlace::on_hand, 2, 0, 0);
  EXPECT_NE(refusal(few).find("three sightings"), std::string::npos);
  const auto small = sightings(noise, truth, CameraPlace::on_hand, 12, 1e-3, 2e-3, 0.03);
  EXPECT_NE(refusal(small).find("turned by"), std::string::npos);
  std::vector<Sighting> about_one;
  for (int i = 0; i < 10; ++i) {
    const Pose flange{noise.within(0.4), from_axis_angle(normalized(Vec3{1, 2, 3}), 0.2 * i)};
    about_one.push_back({flange, noise.measured(inverse(flange * truth.camera) * truth.marker, 1e-3, 2e-3)});
  }
  EXPECT_NE(refusal(about_one).find("about one axis"), std::string::npos);
}

TEST(NextPose, LowersTheUncertaintyMoreThanTheAverageTurn) {
  Noise noise(6);
  double best = 0, random = 0;
  for (int k = 0; k < 20; ++k) {
    const Truth truth = any_truth(noise);
    auto all = sightings(noise, truth, CameraPlace::on_hand, 5, 1e-3, 3e-3, 0.3);
    const HandEye before = hand_eye(all, CameraPlace::on_hand);
    const NextPose next = next_sighting(all, CameraPlace::on_hand, before);
    EXPECT_LT(next.sigma_then, next.sigma_now);
    const auto error_with = [&](const Pose& flange) {
      double square = 0;
      for (int i = 0; i < 20; ++i) {
        std::vector<Sighting> more;
        for (const Sighting& each : all)
          more.push_back(
              {each.flange, noise.measured(inverse(each.flange * truth.camera) * truth.marker, 1e-3, 3e-3)});
        more.push_back({flange, noise.measured(inverse(flange * truth.camera) * truth.marker, 1e-3, 3e-3)});
        const Vec3 off = hand_eye(more, CameraPlace::on_hand).camera.pose.position - truth.camera.position;
        square += dot(off, off);
      }
      return square;
    };
    best += error_with(next.flange);
    random += error_with(sightings(noise, truth, CameraPlace::on_hand, 1, 0, 0, 0.3).front().flange);
  }
  EXPECT_LT(best, 0.8 * random);
}

}  // namespace
}  // namespace polyarm::calibration
