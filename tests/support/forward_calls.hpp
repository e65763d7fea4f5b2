#pragma once
/// What the control loop calls in each cycle of a driver in forward mode. `Rig` is a driver on its simulated
/// controller, made from parameters.
#include <gtest/gtest.h>

#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "polyarm/hardware/component.hpp"
#include "polyarm/hardware/forward_moves.hpp"

namespace polyarm::test {

template <class Rig>
class ForwardCalls : public Rig {
 public:
  explicit ForwardCalls(std::map<std::string, std::string> parameters = {})
      : Rig(forward(std::move(parameters))) {
    moves = this->component.forward_moves(hardware::kForwardLayout);
  }
  /// One cycle; the commands are the measured joints, as the trajectory controller commands them.
  hardware::ReturnType pass(double pace = 1) {
    moves->set_pace(pace);
    hardware::ReturnType result = this->read();
    this->hold();
    if (result == hardware::ReturnType::ok) result = this->component.write(this->cycle, this->commands);
    if (result == hardware::ReturnType::error) this->component.on_error();
    return result;
  }
  ::testing::AssertionResult passes(int cycles, double pace = 1) {
    for (int i = 0; i < cycles; ++i)
      if (pass(pace) == hardware::ReturnType::error)
        return ::testing::AssertionFailure() << i << ": " << this->component.reason();
    return ::testing::AssertionSuccess();
  }
  template <typename Until>
  ::testing::AssertionResult passes_until(Until until, double pace = 1, int most = 8000) {
    for (int i = 0; i < most; ++i) {
      if (pass(pace) == hardware::ReturnType::error)
        return ::testing::AssertionFailure() << i << ": " << this->component.reason();
      if (until()) return ::testing::AssertionSuccess();
    }
    return ::testing::AssertionFailure() << "not within " << most << " cycles";
  }
  bool done() const { return moves->flow().done == id && moves->flow().idle && moves->flow().standing; }

  hardware::ForwardMoves* moves = nullptr;
  std::uint64_t id = 0;  ///< of the newest move

 private:
  static std::map<std::string, std::string> forward(std::map<std::string, std::string> parameters) {
    parameters["motion"] = "forward";
    return parameters;
  }
};

}  // namespace polyarm::test
