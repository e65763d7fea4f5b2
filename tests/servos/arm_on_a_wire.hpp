#pragma once
/// The example of an SO-101 whose servos are on a pty.
#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "drivers/servo_bus/fake_bus.hpp"
#include "polyarm/base/file.hpp"
#include "tests/support/command.hpp"

namespace polyarm::test {

/// In the cell's file.
inline void change(const ExampleCopy& copy, const std::string& from, const std::string& to) {
  std::string text = read_file(copy.file("cell.yaml"));
  ASSERT_NE(text.find(from), std::string::npos);
  text.replace(text.find(from), from.size(), to);
  write_file_atomically(copy.file("cell.yaml"), text);
}

/// The servos of an arm on a pty, and the example's cell that drives them.
struct ArmOnAWire {
  servo_bus::FakeBus bus{servo_bus::Wire::feetech, {1, 2, 3, 4, 5, 6}};
  ExampleCopy copy{"so101"};
  ArmOnAWire() {
    change(copy, "hardware: mock", "hardware: feetech");
    change(copy, "/dev/ttyACM0", bus.path() + "\n      answer_timeout_ms: 500");
    std::ofstream(copy.file("calibration.yaml"))
        << "polyarm: servo_calibration/1\nfamily: feetech\njoints:\n  wrist_roll: {id: 5, direction: -1}\n";
  }
};

}  // namespace polyarm::test
