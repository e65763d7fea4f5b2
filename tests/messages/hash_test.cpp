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
