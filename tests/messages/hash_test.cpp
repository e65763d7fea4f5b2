#include <gtest/gtest.h>

#include <map>
#include <string>

#include "polyarm/messages/generator/model.hpp"
#include "polyarm/messages/types.hpp"

namespace polyarm::messages {
namespace {

struct Published {
  const char* type;
  const char* hash;
};
void PrintTo(const Published& published, std::ostream* out) {
  *out << published.type;
}

class TypeHash : public ::testing::TestWithParam<Published> {};

/// As the packages of Jazzy and Kilted install them (share/<package>/msg/<Name>.json, type_hashes).
TEST_P(TypeHash, IsThatWhichItsPackagePublishes) {
  const TypeInfo* type = find_type(GetParam().type);
  ASSERT_NE(type, nullptr);
  EXPECT_STREQ(type->hash, GetParam().hash);
}

INSTANTIATE_TEST_SUITE_P(
    Of, TypeHash,
    ::testing::Values(Published{"std_msgs/msg/String",
                                "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"},
                      Published{"std_msgs/msg/Header",
                                "RIHS01_f49fb3ae2cf070f793645ff749683ac6b06203e41c891e17701b1cb597ce6a01"},
                      Published{"builtin_interfaces/msg/Time",
                                "RIHS01_b106235e25a4c5ed35098aa0a61a3ee9c9b18d197f398b0e4206cea9acf9c197"},
                      Published{"std_msgs/msg/Float64MultiArray",
                                "RIHS01_1025ddc6b9552d191f89ef1a8d2f60f3d373e28b283d8891ddcc974e8c55397f"},
                      Published{"std_msgs/msg/MultiArrayLayout",
                                "RIHS01_4c66e6f78e740ac103a94cf63259f968e48c617e7699e829b63c21a5cb50dac6"},
                      Published{"std_msgs/msg/MultiArrayDimension",
                                "RIHS01_5e773a60a4c7fc8a54985f307c7837aa2994252a126c301957a24e31282c9cbe"},
                      Published{"sensor_msgs/msg/JointState",
                                "RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e"},
                      Published{"diagnostic_msgs/msg/KeyValue",
                                "RIHS01_d68081eaa540288c5440753baecef0c4e16e81a5f78ad68902ded5100413bb42"},
                      Published{"trajectory_msgs/msg/JointTrajectory",
                                "RIHS01_179b33eba59d676f6d967ac71fe35e7ca2f64b2f3928f4a018cec115e213796e"}));

/// As the generator of ROS 2 Jazzy makes them from moveit_msgs 2.6.
INSTANTIATE_TEST_SUITE_P(
    OfMoveIt, TypeHash,
    ::testing::Values(Published{"moveit_msgs/action/MoveGroup_SendGoal_Request",
                                "RIHS01_02e8af2a61d8fe3044deddcbdffd536e96c2d822e64338c49397798ea665ac90"},
                      Published{"moveit_msgs/action/MoveGroup_GetResult_Response",
                                "RIHS01_c13439db4b8be0a7056e604be863d5f4b6265cdb64887e26e12cfa5622c58682"},
                      Published{"moveit_msgs/action/MoveGroup_FeedbackMessage",
                                "RIHS01_c5b66e44e3b976db5536bf3eb773d83238c1d1d8c53ccaa7ccba28fad55fa352"},
                      Published{"moveit_msgs/action/ExecuteTrajectory_SendGoal_Request",
                                "RIHS01_f9361ba84219ba7bf04c87513b2c15fed8984d9cb32c93a53756ffc7a009d4fd"},
                      Published{"moveit_msgs/action/ExecuteTrajectory_GetResult_Response",
                                "RIHS01_cb1255b75ffb4c41fbb1410198eb2df784f4c80f883da76eaa3ff60d51be9e8f"},
                      Published{"moveit_msgs/srv/GetMotionPlan_Request",
                                "RIHS01_607f444bd22f6ed971c85c76a1fdd44cc556d6bcc0f1d501449bb01aef7df60a"},
                      Published{"moveit_msgs/srv/GetMotionPlan_Response",
                                "RIHS01_b5980d78fafab3a2c20a85d2cb306e1f9fe06ef3d49fa7a47803f229fb89f5a2"},
                      Published{"moveit_msgs/srv/GetPositionIK_Request",
                                "RIHS01_2fc6ac96ee9a8523466c443f06e7c76c47bd3e6b8698edc517ea82cf0b56e747"},
                      Published{"moveit_msgs/srv/GetPositionIK_Response",
                                "RIHS01_e80acd352080518d3498cc09f4dd84e0303e31128237de11d4019c8a5937b19f"},
                      Published{"moveit_msgs/srv/GetPositionFK_Request",
                                "RIHS01_03282430a957ca7dd7e8a84b4f13225c39c467ec79efb77d9554e7b8d4cd6055"},
                      Published{"moveit_msgs/srv/GetPositionFK_Response",
                                "RIHS01_a1b88541679d04b392399fb4633adb55afaea22d3d5c38c79ad65f7cae6f4f2c"},
                      Published{"moveit_msgs/srv/GetCartesianPath_Request",
                                "RIHS01_f82f5681778f78140f106beefcea74d2ce34c5e4bb048b56c90758e0d2d41384"},
                      Published{"moveit_msgs/srv/GetCartesianPath_Response",
                                "RIHS01_e2dc0013e5a4c0893c54b13b0efa5997041852006a5bafdb44e11224a4cfa46b"},
                      Published{"moveit_msgs/srv/GetStateValidity_Request",
                                "RIHS01_189b312daa94b06344969f688adc5935f3ab08208e57024e6187d5c620f5aeae"},
                      Published{"moveit_msgs/srv/GetStateValidity_Response",
                                "RIHS01_2ad22d068a72cb1b17d1a6056aded2ffcaa01136b598cd1dc74fc025fbee2ecc"},
                      Published{"moveit_msgs/srv/ApplyPlanningScene_Request",
                                "RIHS01_4303c6065226e57f263fe7e1c03df94ea3ddbc120001cbbc4e757d7801da0a56"},
                      Published{"moveit_msgs/srv/ApplyPlanningScene_Response",
                                "RIHS01_8e618d93f6779a2e3f95d84c363f8cc996297b586b683a53750879506e8eaaf1"},
                      Published{"moveit_msgs/srv/GetPlanningScene_Request",
                                "RIHS01_ac8ce45f7638bcc6d6661f66e836e4edd218107682f68e3292dac1f79f29c1ec"},
                      Published{"moveit_msgs/srv/GetPlanningScene_Response",
                                "RIHS01_8a2b63777b386eeffec08730a19dae73e4950fec294825d9d53f24b935e6ec95"},
                      Published{"moveit_msgs/srv/QueryPlannerInterfaces_Request",
                                "RIHS01_716b549d7743097c7f87e1b6071706cd3aefc0a2fca50496126b2ce22aa7abe7"},
                      Published{"moveit_msgs/srv/QueryPlannerInterfaces_Response",
                                "RIHS01_72a60b95e3c8b5e0cfad472ae82aa973020d3262fb3e8d2dbcba6d3435643f3f"},
                      Published{"moveit_msgs/srv/GetPlannerParams_Request",
                                "RIHS01_d5c5aa547967f14f3ff0dd58a0d68bab7fd2cf20a1c2e7a83c450d0c8b10c995"},
                      Published{"moveit_msgs/srv/GetPlannerParams_Response",
                                "RIHS01_921fb430660ce892948737a028e2392739f9db365ed88eaada0c93124e16f3b1"},
                      Published{"moveit_msgs/srv/SetPlannerParams_Request",
                                "RIHS01_7fa8975b116962593514d146e0ab5b3e5d52264dec750400279d25b6311c780d"},
                      Published{"moveit_msgs/srv/SetPlannerParams_Response",
                                "RIHS01_2d0d0e5813f0d9bc3816e44a46deb1d3cee3c3c7abd7e44a7dc316987a182bf4"},
                      Published{"moveit_msgs/msg/PlanningScene",
                                "RIHS01_0f58540ad5eab4b9ea827d53b763c793d8cabd202b3b301fcee25afa4ce1bd80"},
                      Published{"moveit_msgs/msg/DisplayTrajectory",
                                "RIHS01_dd351cbd6d9986eb019306910ec09236a136a02dbc0b3465707cb62f2d56e22b"},
                      Published{"moveit_msgs/msg/CollisionObject",
                                "RIHS01_74b0acd6d56be032bf4f764b2c2633f50588b5fb2bd71e97206c59052747cf7e"},
                      Published{"moveit_msgs/msg/AttachedCollisionObject",
                                "RIHS01_7fdfe7951a33a857f20fc42c9ed410a38d06dd0c209ac774ecea746dc487dc41"},
                      Published{"moveit_msgs/msg/MoveItErrorCodes",
                                "RIHS01_dcda8a9950cf6dd6ac221c2c0d2509f52f136afa0403dd19beacdf07e83e4a07"}));

/// A service as a whole, which is not in the list, of its parts: checks requests without fields, char, and
/// bounded sequences against a hash that is published.
TEST(TypeHash, OfAServiceAsAWholeIsThePublishedOne) {
  using generator::Field;
  using generator::Shape;
  const auto field = [](const char* type, const char* name, Shape shape = Shape::single,
                        std::uint32_t n = 0) {
    return Field{type, name, shape, n, ""};
  };
  const generator::Type time{
      "builtin_interfaces/msg/Time", {}, {field("int32", "sec"), field("uint32", "nanosec")}};
  const generator::Type info{
      "service_msgs/msg/ServiceEventInfo",
      {},
      {field("uint8", "event_type"), field("builtin_interfaces/msg/Time", "stamp"),
       field("char", "client_gid", Shape::array, 16), field("int64", "sequence_number")}};
  const generator::Type request{"std_srvs/srv/Trigger_Request", {}, {}};
  const generator::Type response{
      "std_srvs/srv/Trigger_Response", {}, {field("bool", "success"), field("string", "message")}};
  const generator::Type event{"std_srvs/srv/Trigger_Event",
                              {},
                              {field("service_msgs/msg/ServiceEventInfo", "info"),
                               field("std_srvs/srv/Trigger_Request", "request", Shape::bounded, 1),
                               field("std_srvs/srv/Trigger_Response", "response", Shape::bounded, 1)}};
  const generator::Type whole{"std_srvs/srv/Trigger",
                              {},
                              {field("std_srvs/srv/Trigger_Request", "request_message"),
                               field("std_srvs/srv/Trigger_Response", "response_message"),
                               field("std_srvs/srv/Trigger_Event", "event_message")}};
  std::map<std::string, const generator::Type*> all;
  for (const generator::Type* type : {&time, &info, &request, &response, &event, &whole})
    all[type->name] = type;
  EXPECT_EQ(generator::type_hash(whole, all),
            "RIHS01_eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f");
  EXPECT_EQ(generator::type_hash(request, all), type_info<std_srvs::srv::Trigger::Request>().hash);
}

}  // namespace
}  // namespace polyarm::messages
