#pragma once

#include <atomic>
#include <string>

namespace midair::base
{

/// Instruction set of a compiled kernel. PLAIN: available on all processors of the family (x86-64:
/// SSE2).
enum class InstructionSet
{
    PLAIN,
    AVX2,  ///< with FMA
    AVX512 ///< F, BW, CD, DQ and VL
};

constexpr InstructionSet kInstructionSets[] = {
    InstructionSet::PLAIN, InstructionSet::AVX2, InstructionSet::AVX512};

/// Returns the name as in OSG_MIDAIR_SIMD: "plain", "avx2" or "avx512".
const char* instructionSetName(InstructionSet set);

/// Returns true if the kernels are compiled for \a set and this processor and operating system
/// support it.
bool isRunnable(InstructionSet set);

/// Returns the set named \a wanted. If empty, unknown or not runnable, returns the best runnable
/// set; for the last two \a message gives the reason.
InstructionSet instructionSetFor(const std::string& wanted, std::string& message);

/// Returns the instruction set of all kernels, by default the best of this processor.
/// OSG_MIDAIR_SIMD=plain, avx2 or avx512 selects another, for debugging and comparison; unknown or
/// unsupported values are reported once on stderr and ignored.
InstructionSet instructionSet();

/// Selects \a set, which must be runnable, for all kernels. For tests; not while another thread
/// computes.
void useInstructionSet(InstructionSet set);

namespace detail
{
/// Index of the set in use; negative before one is chosen.
extern std::atomic<int> setInUse;
int chooseSet();
} // namespace detail

} // namespace midair::base
