#pragma once

#include <atomic>
#include <string>

namespace midair::base
{

/// Instruction set that a kernel is compiled for. PLAIN: available on all processors of the family
/// (x86-64: SSE2).
enum class InstructionSet
{
    PLAIN,
    AVX2,  ///< with FMA
    AVX512 ///< F, BW, CD, DQ and VL
};

constexpr InstructionSet kInstructionSets[] = {
    InstructionSet::PLAIN, InstructionSet::AVX2, InstructionSet::AVX512};

/// Returns the name as OSG_MIDAIR_SIMD takes it: "plain", "avx2" or "avx512".
const char* instructionSetName(InstructionSet set);

/// Returns true if the kernels are compiled for \a set, and this processor and operating system
/// support it.
bool isRunnable(InstructionSet set);

/// Returns the set that \a wanted names. If it is empty, unknown or not runnable, returns the best
/// runnable set; for the last two \a message says why.
InstructionSet instructionSetFor(const std::string& wanted, std::string& message);

/// Returns the set that kernels run with, by default the best of this processor.
/// OSG_MIDAIR_SIMD=plain, avx2 or avx512 selects another one, for debugging and comparison; a value
/// that is unknown or not runnable is reported once on stderr and ignored.
InstructionSet instructionSet();

/// Makes kernels run with \a set, which must be runnable, from now on. For tests; not while another
/// thread computes.
void useInstructionSet(InstructionSet set);

namespace detail
{
/// Number of the set in use; negative before it is chosen.
extern std::atomic<int> setInUse;
int chooseSet();
} // namespace detail

} // namespace midair::base
