#pragma once
/// The kernels of descent_lanes.hpp, compiled once for each instruction set (descent_*.cpp). Private to this
/// room.
#include "polyarm/descent/descent_lanes.hpp"

namespace polyarm::kinematics {

struct DescentKernels {
  using Descend = int (*)(const DescentArm&, const DescentRules&, const DescentTask*, Descents&);
  using Measure = void (*)(const DescentArm&, const DescentTask*, Descents&);
  Descend whole, task;
  Measure measure_whole, measure_task;
  void (*ends)(const DescentArm&, const EndTable&);
  void (*near)(const FeatureTable&, const float*, const float*, NearPoints&);
  bool (*single)(const DescentArm&, const DescentRules&, const double* target, SingleDescent&);
  void (*states)(const FeatureTable&, const float*, const StatesWanted&, StatesNear&);
  int (*slide)(const DescentArm&, const SlideRules&, Slides&);
};

namespace lanes_portable {
extern const DescentKernels kDescentKernels;
}
namespace lanes_avx2 {
extern const DescentKernels kDescentKernels;
}
namespace lanes_avx512 {
extern const DescentKernels kDescentKernels;
}

}  // namespace polyarm::kinematics
