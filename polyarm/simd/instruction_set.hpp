#pragma once
/// The vector instruction sets that kernels are compiled for. The program chooses one when it runs. Any
/// thread; nothing throws.

namespace polyarm::kinematics {

/// portable: what every processor of the architecture has (SSE2 on x86-64: two numbers at a time, no fused
/// multiply-add). avx2: AVX2 and FMA, four numbers. avx512: AVX-512 F, DQ and VL, eight numbers. One
/// instruction set gives the same results in every run; different sets differ in the last digits.
enum class InstructionSet { portable, avx2, avx512 };

/// The widest set that this processor has.
InstructionSet fastest_instructions() noexcept;
/// `wanted` if the processor has it, else the widest set that it has.
InstructionSet supported(InstructionSet wanted) noexcept;
/// The set named by the environment variable POLYARM_INSTRUCTIONS ("portable", "avx2", "avx512"), reduced to
/// what the processor has; the widest if the variable is not set. For measurements: the closed forms read it
/// once, at program start.
InstructionSet wanted_instructions() noexcept;
/// "portable", "avx2", "avx512".
const char* name(InstructionSet set) noexcept;

}  // namespace polyarm::kinematics
