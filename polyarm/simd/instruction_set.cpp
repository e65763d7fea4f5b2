#include "polyarm/simd/instruction_set.hpp"

#include <algorithm>
#include <cstdlib>
#include <string_view>

namespace polyarm::kinematics {

InstructionSet fastest_instructions() noexcept {
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl"))
    return InstructionSet::avx512;
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return InstructionSet::avx2;
#endif
  return InstructionSet::portable;
}

InstructionSet supported(InstructionSet wanted) noexcept {
  return std::min(wanted, fastest_instructions());
}

InstructionSet wanted_instructions() noexcept {
  const char* given = std::getenv("POLYARM_INSTRUCTIONS");
  for (const InstructionSet set : {InstructionSet::portable, InstructionSet::avx2})
    if (given && std::string_view(given) == name(set)) return supported(set);
  return fastest_instructions();
}

const char* name(InstructionSet set) noexcept {
  switch (set) {
    case InstructionSet::portable:
      return "portable";
    case InstructionSet::avx2:
      return "avx2";
    case InstructionSet::avx512:
      return "avx512";
  }
  return "";
}

}  // namespace polyarm::kinematics
