#pragma once
/// The kernels of closed_form.hpp, compiled once for each set of instructions (branches_*.cpp). Used inside
/// this room only.
#include "polyarm/kinematics/closed_form.hpp"

namespace polyarm::kinematics {

struct BranchKernels {
  void (*solve)(const BranchJob&, Branches&);
  void (*polish)(const BranchJob&, Branches&);
  bool (*quick)(const QuickJob&, const LaneArm&, const Pose&, const double*, QuickAnswers&);
  void (*nearest)(const QuickJob&, const LaneArm&, std::span<const Pose>, const double*, QuickAnswers*);
};

namespace lanes_portable {
extern const BranchKernels kBranchKernels;
}
namespace lanes_avx2 {
extern const BranchKernels kBranchKernels;
}
namespace lanes_avx512 {
extern const BranchKernels kBranchKernels;
}

}  // namespace polyarm::kinematics
