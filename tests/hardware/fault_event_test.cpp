#include "polyarm/hardware/fault_event.hpp"

#include <gtest/gtest.h>

namespace polyarm::hardware {
namespace {

TEST(FaultEvents, KeepTheOldestWhenThereIsNoMoreRoom) {
  FaultEvents faults;
  faults.make_room(1000);
  for (std::int32_t i = 0; i < 100'000; ++i) faults.push({StopCause::component, i});
  ASSERT_GE(faults.list().size(), 1000u);
  ASSERT_LT(faults.list().size(), 100'000u) << "a cycle allocates nothing";
  for (std::size_t i = 0; i < faults.list().size(); ++i)
    ASSERT_EQ(faults.list()[i].component, static_cast<std::int32_t>(i));
  faults.clear();
  EXPECT_TRUE(faults.empty());
}

TEST(FaultEvents, DeactivationIsReportedAsAFailedComponent) {
  for (int cause = 0; cause < kStopCauses; ++cause) {
    const auto each = static_cast<StopCause>(cause);
    EXPECT_EQ(reported(each), each == StopCause::deactivated ? StopCause::component : each);
  }
}

}  // namespace
}  // namespace polyarm::hardware
