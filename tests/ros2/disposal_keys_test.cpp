/// Departures as discovery of Cyclone DDS writes them, byte for byte, and anything else left alone.
#include "polyarm/participant/disposal_keys.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "tests/ros2/rtps_fuzz.hpp"

namespace polyarm::ros2 {
namespace {

using Octets = std::vector<std::uint8_t>;

Octets operator+(Octets a, const Octets& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

const Octets kGuid{1, 0x10, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 0, 0, 0x14, 3};
const Octets kHeader = Octets{'R', 'T', 'P', 'S', 2, 5, 1, 0x10} + Octets(kGuid.begin(), kGuid.begin() + 12);
const Octets kTimestamp{0x09, 0x01, 8, 0, 1, 2, 3, 4, 5, 6, 7, 8};
const Octets kHeartbeat{0x07, 0x01, 4, 0, 9, 9, 9, 9};
/// PID_STATUS_INFO: disposed and unregistered.
const Octets kGone{0x71, 0, 4, 0, 0, 0, 0, 3, 1, 0, 0, 0};
const Octets kWriters{0, 0, 3, 0xc2}, kReaders{0, 0, 4, 0xc2}, kParticipants{0, 1, 0, 0xc2};

Octets fields(const Octets& writer) {
  return Octets{0, 0, 16, 0, 0, 0, 0, 0} + writer + Octets{0, 0, 0, 0, 5, 0, 0, 0};
}
Octets listed(std::uint8_t id) {
  return Octets{0, 3, 0, 0, id, 0, 16, 0} + kGuid + Octets{1, 0, 0, 0};
}
/// A DATA submessage with inline QoS and a key alone.
Octets gone(const Octets& writer, const Octets& key, std::uint8_t flags = 0x0b) {
  const Octets body = fields(writer) + kGone + key;
  return Octets{0x15, flags, static_cast<std::uint8_t>(body.size()), 0} + body;
}

TEST(DisposalKeys, OfEndpointsAndParticipantsBecomeTheirGuid) {
  const std::pair<Octets, std::uint8_t> each[] = {{kWriters, 0x5a}, {kReaders, 0x5a}, {kParticipants, 0x50}};
  for (const auto& [writer, id] : each) {
    Octets out;
    ASSERT_TRUE(with_plain_keys(kHeader + kTimestamp + gone(writer, listed(id)), out));
    EXPECT_EQ(out, kHeader + kTimestamp + gone(writer, kGuid));
  }
}

TEST(DisposalKeys, WhatComesBeforeAndAfterStays) {
  const Octets key = listed(0x5a);
  Octets out;
  ASSERT_TRUE(with_plain_keys(
      kHeader + gone(kWriters, key) + kHeartbeat + gone(kReaders, key) + kTimestamp + kHeartbeat, out));
  EXPECT_EQ(out,
            kHeader + gone(kWriters, kGuid) + kHeartbeat + gone(kReaders, kGuid) + kTimestamp + kHeartbeat);
}

TEST(DisposalKeys, OfBigEndianAndOfASubmessageUpToTheEndAreRead) {
  Octets big = Octets{0, 0, 0, 16, 0, 0, 0, 0} + kWriters + Octets{0, 0, 0, 0, 0, 0, 0, 5};
  const Octets key = Octets{0, 2, 0, 0, 0, 0x5a, 0, 16} + kGuid + Octets{0, 1, 0, 0};
  Octets out;
  ASSERT_TRUE(
      (with_plain_keys(kHeader + Octets{0x15, 0x08, 0, 0} + big + key, out)));  // length 0: to the end
  EXPECT_EQ(out, (kHeader + Octets{0x15, 0x08, 0, 36} + big + kGuid));
}

TEST(DisposalKeys, AnythingElseIsLeftAlone) {
  const Octets key = listed(0x5a);
  const Octets short_key = gone(kWriters, kGuid), not_discovery = gone({0, 0, 0x12, 3}, key);
  const Octets with_data = gone(kWriters, key, 0x07), other_parameter = gone(kWriters, listed(0x15));
  const Octets plain_cdr = gone(kWriters, Octets{0, 1, 0, 0} + kGuid);
  for (const Octets& submessage :
       {short_key, not_discovery, with_data, other_parameter, plain_cdr, kTimestamp}) {
    Octets out{7};
    EXPECT_FALSE(with_plain_keys(kHeader + submessage, out));
    EXPECT_EQ(out, Octets{7});
  }
}

TEST(DisposalKeys, MessagesCutOffAnywhereAreLeftAloneOrGrowNoLonger) {
  const Octets whole = kHeader + kTimestamp + gone(kWriters, listed(0x5a)) + kHeartbeat;
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const Octets cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    Octets out;
    if (with_plain_keys(cut, out)) {
      EXPECT_EQ(out.size() + 12, cut.size()) << size;
    }
  }
}

/// Mutated packets of every kind: read within their bounds (sanitizers), and at most shortened.
TEST(DisposalKeys, MutatedPacketsAreReadWithinTheirBounds) {
  test::RtpsFuzz fuzz(11, {}, {});
  for (int i = 0; i < 50'000; ++i) {
    const Octets packet =
        fuzz.packet(test::kSubmessages[static_cast<std::size_t>(i) % test::kSubmessages.size()]);
    Octets out;
    if (with_plain_keys(packet, out)) {
      ASSERT_LT(out.size(), packet.size());
      ASSERT_TRUE(std::equal(out.begin(), out.begin() + 20, packet.begin()));
    }
  }
}

}  // namespace
}  // namespace polyarm::ros2
