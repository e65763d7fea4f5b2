/// The buffer of transforms that plugins look into.
#include <gtest/gtest.h>

#include <cmath>
#include <future>
#include <limits>
#include <random>

#include "rclcpp/rclcpp.hpp"
#include "tf2/utils.hpp"
#include "tf2_eigen/tf2_eigen.hpp"
#include "tf2_ros/buffer.hpp"
#include "tf2_ros/static_transform_broadcaster.hpp"
#include "tf2_ros/transform_broadcaster.hpp"
#include "tf2_ros/transform_listener.hpp"

namespace {

using geometry_msgs::msg::TransformStamped;

std::unique_ptr<tf2_ros::Buffer> make_buffer() {
  return std::make_unique<tf2_ros::Buffer>(std::make_shared<rclcpp::Clock>());
}
TransformStamped stamped(const std::string& parent, const std::string& child, double seconds,
                         const tf2::Transform& pose) {
  TransformStamped out;
  out.header.frame_id = parent, out.child_frame_id = child;
  out.header.stamp = rclcpp::Time(static_cast<std::int64_t>(seconds * 1e9));
  out.transform = tf2::toMsg(pose);
  return out;
}
tf2::Transform shift(double x, double y, double z) {
  return tf2::Transform(tf2::Quaternion::getIdentity(), tf2::Vector3(x, y, z));
}
double distance(const tf2::Transform& a, const tf2::Transform& b) {
  return (a.getOrigin() - b.getOrigin()).length() + a.getRotation().angleShortestPath(b.getRotation());
}

TEST(TransformBuffer, MultipliesTheWayBetweenAnyTwoFrames) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-1, 1);
  const auto buffer = make_buffer();
  // Frame i hangs on a random earlier one; `of_root` is what a look-up must find.
  std::vector<tf2::Transform> of_root = {tf2::Transform()};
  for (int i = 1; i < 40; ++i) {
    const int parent = static_cast<int>(random() % static_cast<unsigned>(i));
    const tf2::Quaternion turn =
        tf2::Quaternion(any(random), any(random), any(random), any(random)).normalized();
    const tf2::Transform pose(turn, tf2::Vector3(any(random), any(random), any(random)));
    of_root.push_back(of_root[static_cast<std::size_t>(parent)] * pose);
    ASSERT_TRUE(buffer->setTransform(stamped("f" + std::to_string(parent), "f" + std::to_string(i), 1, pose),
                                     "", i % 3 == 0));
  }
  for (int i = 0; i < 300; ++i) {
    const auto a = random() % of_root.size(), b = random() % of_root.size();
    const auto found =
        buffer->lookupTransform("f" + std::to_string(a), "/f" + std::to_string(b), tf2::TimePointZero);
    EXPECT_EQ(found.header.frame_id, "f" + std::to_string(a));
    EXPECT_LT(distance(tf2::transform_of(found), of_root[a].inverse() * of_root[b]), 1e-6);
  }
}

TEST(TransformBuffer, InterpolatesBetweenTwoTimesAndNeverBeyondThem) {
  const auto buffer = make_buffer();
  tf2::Quaternion quarter(tf2::Vector3(0, 0, 1), M_PI / 2);
  buffer->setTransform(stamped("map", "base", 10, shift(0, 0, 0)), "");
  buffer->setTransform(stamped("map", "base", 12, tf2::Transform(quarter, tf2::Vector3(4, 0, 0))), "");
  const auto at = [&](double s) { return buffer->lookupTransform("map", "base", tf2::timeFromSec(s)); };
  EXPECT_NEAR(at(10.5).transform.translation.x, 1, 1e-9);
  EXPECT_NEAR(tf2::getYaw(at(11).transform.rotation), M_PI / 4, 1e-9);
  EXPECT_NEAR(at(0).transform.translation.x, 4, 1e-12);  // the newest
  EXPECT_THROW(at(12.1), tf2::ExtrapolationException);
  EXPECT_THROW(at(9.9), tf2::ExtrapolationException);
  buffer->setTransform(stamped("base", "tool", 11, shift(0, 1, 0)), "");
  EXPECT_EQ(buffer->lookupTransform("map", "tool", tf2::TimePointZero).header.stamp.sec,
            11);  // the newest of both
  // Seen from where the base was at 10 s, what it is at 12 s.
  const auto moved =
      buffer->lookupTransform("base", tf2::timeFromSec(10), "base", tf2::timeFromSec(12), "map");
  EXPECT_NEAR(moved.transform.translation.x, 4, 1e-9);
}

TEST(TransformBuffer, SaysWhatIsWrong) {
  const auto buffer = make_buffer();
  buffer->setTransform(stamped("map", "base", 1, shift(1, 0, 0)), "", true);
  buffer->setTransform(stamped("other", "thing", 1, shift(1, 0, 0)), "", true);
  EXPECT_THROW(buffer->lookupTransform("map", "nothing", tf2::TimePointZero), tf2::LookupException);
  EXPECT_THROW(buffer->lookupTransform("map", "thing", tf2::TimePointZero), tf2::ConnectivityException);
  std::string reason;
  EXPECT_FALSE(buffer->canTransform("map", "nothing", tf2::TimePointZero, &reason));
  EXPECT_NE(reason.find("nothing"), std::string::npos);
  buffer->setTransform(stamped("base", "map", 1, shift(1, 0, 0)), "", true);  // a circle
  EXPECT_THROW(buffer->lookupTransform("map", "thing", tf2::TimePointZero), tf2::LookupException);
}

TEST(TransformBuffer, RefusesWhatIsNoTransformAndKeepsAtMostTenSeconds) {
  const auto buffer = make_buffer();
  TransformStamped bad = stamped("map", "base", 1, shift(std::numeric_limits<double>::quiet_NaN(), 0, 0));
  EXPECT_FALSE(buffer->setTransform(bad, ""));
  bad = stamped("map", "base", 1, shift(0, 0, 0));
  bad.transform.rotation.w = 0;
  EXPECT_FALSE(buffer->setTransform(bad, ""));
  EXPECT_FALSE(buffer->setTransform(stamped("base", "base", 1, shift(0, 0, 0)), ""));
  EXPECT_FALSE(buffer->setTransform(stamped("", "base", 1, shift(0, 0, 0)), ""));
  bad = stamped("map", "base", 1, shift(0, 0, 0));
  bad.header.stamp.sec = -1;
  EXPECT_FALSE(buffer->setTransform(bad, ""));
  for (int i = 0; i < 200; ++i)
    buffer->setTransform(stamped("map", "base", 100 + 0.1 * i, shift(i, 0, 0)), "");
  EXPECT_FALSE(buffer->canTransform("map", "base", tf2::timeFromSec(105)));
  EXPECT_TRUE(buffer->canTransform("map", "base", tf2::timeFromSec(112)));
  EXPECT_FALSE(buffer->setTransform(stamped("map", "base", 101, shift(0, 0, 0)), ""));
}

TEST(TransformBuffer, WaitsForATransformUntilItsTimeout) {
  const auto buffer = make_buffer();
  auto waiting = std::async(std::launch::async, [&] {
    return buffer->lookupTransform("map", "base", rclcpp::Time(0, 0, RCL_ROS_TIME), rclcpp::Duration(60, 0));
  });
  buffer->setTransform(stamped("map", "base", 5, shift(7, 0, 0)), "");
  EXPECT_EQ(waiting.get().transform.translation.x, 7);
  EXPECT_THROW(buffer->lookupTransform("map", "tool", tf2::TimePointZero, tf2::durationFromSec(0.001)),
               tf2::LookupException);
  EXPECT_FALSE(buffer->canTransform("map", "tool", tf2::TimePointZero, std::chrono::milliseconds(1)));
}

TEST(TransformBuffer, TransformsMessagesByTheirHeader) {
  const auto buffer = make_buffer();
  buffer->setTransform(stamped("map", "base", 0, shift(1, 2, 3)), "", true);
  geometry_msgs::msg::PoseStamped pose;
  pose.header.frame_id = "base";
  pose.pose.position.x = 0.5;
  const auto moved = buffer->transform(pose, "map");
  EXPECT_EQ(moved.header.frame_id, "map");
  EXPECT_EQ(moved.pose.position.x, 1.5);
  EXPECT_EQ(moved.pose.position.z, 3);
}

TEST(TransformListener, HearsTheBroadcastersOfItsModule) {
  const auto buffer = make_buffer();
  const tf2_ros::TransformListener listener(*buffer);
  const auto node = std::make_shared<rclcpp::Node>("sender");
  tf2_ros::TransformBroadcaster moving(node);
  tf2_ros::StaticTransformBroadcaster fixed(node);
  moving.sendTransform(stamped("map", "base", 3, shift(1, 0, 0)));
  fixed.sendTransform(stamped("base", "camera", 0, shift(0, 0, 1)));
  const auto found = buffer->lookupTransform("map", "camera", tf2::TimePointZero, tf2::durationFromSec(60));
  EXPECT_EQ(found.transform.translation.x, 1);
  EXPECT_EQ(found.transform.translation.z, 1);
}

TEST(TransformsOfEigen, AreThoseOfMessages) {
  const Eigen::Isometry3d pose =
      Eigen::Translation3d(1, 2, 3) * Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitY());
  const TransformStamped message = tf2::eigenToTransform(pose);
  EXPECT_TRUE(tf2::transformToEigen(message).isApprox(pose, 1e-12));
  EXPECT_TRUE(tf2::transformToEigen(tf2::eigenToTransform(Eigen::Affine3d(pose))).isApprox(pose, 1e-12));
  Eigen::Affine3d back;
  tf2::fromMsg(tf2::toMsg(pose), back);
  EXPECT_TRUE(back.isApprox(Eigen::Affine3d(pose), 1e-12));
  const Eigen::Vector3d point(0.1, 0.2, 0.3);
  Eigen::Vector3d moved;
  tf2::doTransform(point, moved, message);
  EXPECT_TRUE(moved.isApprox(pose * point, 1e-12));
}

TEST(StampedValues, BecomeMessagesAndComeBack) {
  const tf2::TimePoint at(std::chrono::nanoseconds(-1500000001));  // before 1970
  EXPECT_EQ(tf2::toMsg(at).sec, -2);
  EXPECT_EQ(tf2::toMsg(at).nanosec, 499999999u);
  EXPECT_EQ(tf2::fromMsg(tf2::toMsg(at)), at);

  const tf2::Stamped<tf2::Transform> pose(shift(1, 2, 3), at, "base");
  tf2::Stamped<tf2::Transform> back;
  tf2::fromMsg(tf2::toMsg(pose), back);  // TransformStamped
  EXPECT_EQ(back.frame_id_, "base");
  EXPECT_EQ(tf2::getTimestamp(tf2::toMsg(pose)), at);
  EXPECT_LT(distance(back, pose), 1e-12);
  geometry_msgs::msg::PoseStamped message;
  EXPECT_EQ(tf2::toMsg(pose, message).pose.position.y, 2);
  EXPECT_EQ(tf2::getFrameId(message), "base");

  TransformStamped turn;
  turn.header.frame_id = "world";
  turn.transform.rotation.z = 1, turn.transform.rotation.w = 0;  // half a turn
  const tf2::Stamped<Eigen::Vector3d> point(Eigen::Vector3d(1, 2, 3), at, "base");
  tf2::Stamped<Eigen::Vector3d> moved;
  tf2::doTransform(point, moved, turn);
  const geometry_msgs::msg::PointStamped out = tf2::toMsg(moved);
  EXPECT_EQ(out.header.frame_id, "world");
  EXPECT_NEAR(out.point.x, -1, 1e-12);
  Eigen::Vector3d plain;
  tf2::convert(out.point, plain);
  EXPECT_NEAR(plain.y(), -2, 1e-12);
  Eigen::Isometry3d frame;
  tf2::convert(message.pose, frame);
  EXPECT_NEAR(frame.translation().z(), 3, 1e-12);
  const tf2::Stamped<Eigen::Isometry3d> placed(frame, at, "base");
  EXPECT_EQ(tf2::toMsg(placed).pose.position, message.pose.position);
}

}  // namespace
