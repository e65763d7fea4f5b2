#include <gtest/gtest.h>

#include "tests/links/running_link.hpp"

namespace polyarm {
namespace {

using test::link_entry;

std::string wrong_with(const std::string& text) {
  try {
    link_entry(text, 1502);
  } catch (const Error& e) {
    return e.what();
  }
  return "nothing";
}

std::string wrong_tag(const std::string& tag) {
  return wrong_with("plc: {modbus: client, tags: {A: {" + tag + "}}}");
}

TEST(LinksFile, ReadsAModbusLink) {
  const signals::LinkEntry entry = link_entry(
      "plc: {modbus: client, port: 502, unit: 3, poll: 20ms, word_order: low_first, on_loss: go_on, groups: "
      "{slow: "
      "1s}, tags: {A: {holding: 4, format: float32, direction: in, group: slow}}}",
      0);
  EXPECT_EQ(entry.unit, 3);
  EXPECT_EQ(entry.poll, 20'000'000);
  EXPECT_TRUE(entry.low_word_first);
  EXPECT_EQ(entry.on_loss, signals::LinkEntry::OnLoss::go_on);
  EXPECT_EQ(entry.tags.at(0).registers(), 2);
}

TEST(LinksFile, GoesBeyondThisMachineOnlyWhenToldSo) {
  EXPECT_NE(wrong_with("plc: {modbus: client, host: 192.168.0.5}").find("beyond this machine"),
            std::string::npos);
  EXPECT_EQ(link_entry("plc: {modbus: client, host: 192.168.0.5, beyond_loopback: true}", 0).host,
            "192.168.0.5");
  EXPECT_NE(wrong_with("plc: {modbus: server, host: 0.0.0.0}").find("beyond this machine"),
            std::string::npos);
}

TEST(LinksFile, ReportsTheProblem) {
  EXPECT_NE(wrong_with("plc: {host: 127.0.0.1}").find("has no protocol"), std::string::npos);
  EXPECT_NE(wrong_tag("direction: in").find("has no place"), std::string::npos);
  EXPECT_NE(wrong_tag("coil: 1").find("has no direction"), std::string::npos);
  EXPECT_NE(wrong_tag("coil: 70000, direction: in").find("from 0 to 65535"), std::string::npos);
  EXPECT_NE(wrong_tag("input: 1, direction: out").find("go in only"), std::string::npos);
  EXPECT_NE(wrong_tag("holding: 1, direction: in, format: flaot32").find("did you mean 'float32'"),
            std::string::npos);
  EXPECT_NE(wrong_tag("coil: 1, direction: in, type: number").find("a bit holds a bool"), std::string::npos);
  EXPECT_NE(wrong_tag("holding: 1, direction: in, group: slow").find("no poll group"), std::string::npos);
  EXPECT_NE(wrong_tag("holding: 1, direction: in, scale: 0").find("cannot be 0"), std::string::npos);
  EXPECT_NE(
      wrong_with(
          "plc: {modbus: client, tags: {A: {holding: 0, format: float32, direction: in}, B: {holding: 1, "
          "direction: in}}}")
          .find("share an address"),
      std::string::npos);
  EXPECT_NE(wrong_with("b: {mqtt: client, tags: {A: {topic: a/#, direction: in}}}")
                .find("not a topic of one value"),
            std::string::npos);
}

}  // namespace
}  // namespace polyarm
