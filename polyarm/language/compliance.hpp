#pragma once
/// How a tool yields to forces, as a program says it with comply(). SI units; any thread.
#include <array>
#include <span>

#include "polyarm/data/value.hpp"

namespace polyarm::program {

struct Compliance {
  std::array<bool, 6> axes{};         ///< x y z rx ry rz of the flange
  std::array<double, 6> push{};       ///< N, with which the tool presses along its axes
  double stiffness = 0, damping = 0;  ///< N/m and N s/m
  double most = 0;                    ///< N: a larger force ends it with an error
  double reach = 0;                   ///< m
};

/// From the arguments of comply(), of the types of its parameters and in their order. Throws OperationError.
Compliance compliance_of(std::span<const data::Value> arguments);

}  // namespace polyarm::program
