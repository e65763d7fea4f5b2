#include "polyarm/descent/descent_lanes.hpp"

#include "polyarm/descent/descent_kernels.hpp"
#include "polyarm/simd/instruction_set.hpp"

namespace polyarm::kinematics {

namespace {

const DescentKernels& kernels_for(InstructionSet set) {
#if defined(__x86_64__)
  switch (set) {
    case InstructionSet::avx512:
      return lanes_avx512::kDescentKernels;
    case InstructionSet::avx2:
      return lanes_avx2::kDescentKernels;
    case InstructionSet::portable:
      break;
  }
#endif
  return lanes_portable::kDescentKernels;
}

const DescentKernels& kKernels = kernels_for(wanted_instructions());

}  // namespace

int descend(const DescentArm& arm, const DescentRules& rules, const DescentTask* task,
            Descents& all) noexcept {
  return (task ? kKernels.task : kKernels.whole)(arm, rules, task, all);
}

int descend(InstructionSet set, const DescentArm& arm, const DescentRules& rules, const DescentTask* task,
            Descents& all) noexcept {
  const DescentKernels& kernels = kernels_for(set);
  return (task ? kernels.task : kernels.whole)(arm, rules, task, all);
}

bool descend_alone(const DescentArm& arm, const DescentRules& rules, const double* target,
                   SingleDescent& one) noexcept {
  return arm.single.possible && kKernels.single(arm, rules, target, one);
}

bool descend_alone(InstructionSet set, const DescentArm& arm, const DescentRules& rules, const double* target,
                   SingleDescent& one) noexcept {
  return arm.single.possible && kernels_for(set).single(arm, rules, target, one);
}

int slide(const DescentArm& arm, const SlideRules& rules, Slides& all) noexcept {
  return kKernels.slide(arm, rules, all);
}

void see_ends(const DescentArm& arm, const EndTable& table) noexcept {
  kKernels.ends(arm, table);
}

void measure(const DescentArm& arm, const DescentTask* task, Descents& all) noexcept {
  (task ? kKernels.measure_task : kKernels.measure_whole)(arm, task, all);
}

void find_near(const FeatureTable& table, const float* at, const float* beyond, NearPoints& out) noexcept {
  kKernels.near(table, at, beyond, out);
}

void find_states(const FeatureTable& table, const float* values, const StatesWanted& wanted,
                 StatesNear& out) noexcept {
  kKernels.states(table, values, wanted, out);
}

}  // namespace polyarm::kinematics
