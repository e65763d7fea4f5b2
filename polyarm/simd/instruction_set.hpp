#pragma once
/// The vector instructions that this room's kernels are compiled for; one is chosen when the program runs.

namespace polyarm::kinematics {

/// portable: what every processor of the architecture has (SSE2 on x86-64, two numbers at a time, no fused
/// multiply-add); avx2: AVX2 and FMA, four; avx512: AVX-512 F, DQ and VL, eight. Results are the same from
/// run to run on one of them, and differ in the last digits between them.
enum class InstructionSet { portable, avx2, avx512 };

/// The widest that this processor has.
InstructionSet fastest_instructions() noexcept;
/// The wider of the two never comes out: `wanted` where the processor has it, else the widest that it has.
InstructionSet supported(InstructionSet wanted) noexcept;
/// What the environment's POLYARM_INSTRUCTIONS names ("portable", "avx2", "avx512"), or less where the
/// processor has not so much; the widest where it names nothing. For measuring: the closed forms ask once,
/// when the program starts.
InstructionSet wanted_instructions() noexcept;
/// "portable", "avx2", "avx512".
const char* name(InstructionSet set) noexcept;

}  // namespace polyarm::kinematics
