#pragma once

#include <atomic>
#include <string>

namespace midair::base
{

/// What a kernel is compiled for. PLAIN: what every processor of the family has (x86-64: SSE2).
enum class InstructionSet
{
    PLAIN,
    AVX2,  ///< with FMA
    AVX512 ///< F, BW, CD, DQ and VL
};

constexpr InstructionSet kInstructionSets[] = {
    InstructionSet::PLAIN, InstructionSet::AVX2, InstructionSet::AVX512};

/// "plain", "avx2" or "avx512": what OSG_MIDAIR_SIMD takes.
const char* instructionSetName(InstructionSet set);

/// True if the kernels are compiled for \a set and this processor, and its operating system, run
/// it.
bool isRunnable(InstructionSet set);

/// The set that \a wanted names; the best runnable one where it is empty, unknown or not runnable,
/// and why in \a message.
InstructionSet instructionSetFor(const std::string& wanted, std::string& message);

/// What kernels run with: by default the best that this processor has. The user's
/// OSG_MIDAIR_SIMD=plain, avx2 or avx512 takes another, to find faults and to compare; a value that
/// is unknown or not runnable is told on stderr once and ignored.
InstructionSet instructionSet();

/// Kernels run with \a set from now on. For tests: not while another thread computes. \a set has to
/// be runnable.
void useInstructionSet(InstructionSet set);

namespace detail
{
/// The set's number; below 0 as long as nobody asked.
extern std::atomic<int> setInUse;
int chooseSet();
} // namespace detail

} // namespace midair::base
