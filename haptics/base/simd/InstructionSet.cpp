#include "haptics/base/simd/InstructionSet.h"

#include "haptics/base/UserEnvironment.h"

#include <cstdio>

namespace midair::base
{

namespace detail
{

std::atomic<int> setInUse{-1};

int chooseSet()
{
    static const int chosen = []
    {
        std::string message;
        const InstructionSet set =
            instructionSetFor(userVariable("OSG_MIDAIR_SIMD").value_or(""), message);
        if (!message.empty()) std::fprintf(stderr, "osgMidair: %s\n", message.c_str());
        return static_cast<int>(set);
    }();
    int none = -1;
    setInUse.compare_exchange_strong(none, chosen);
    return setInUse;
}

} // namespace detail

const char* instructionSetName(InstructionSet set)
{
    switch (set)
    {
    case InstructionSet::AVX512:
        return "avx512";
    case InstructionSet::AVX2:
        return "avx2";
    case InstructionSet::PLAIN:
        break;
    }
    return "plain";
}

bool isRunnable(InstructionSet set)
{
#ifdef MIDAIR_HAS_SIMD
    __builtin_cpu_init(); // in case a constructor of a static object asks
    const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
    switch (set)
    {
    case InstructionSet::AVX512:
        return avx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
               __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
               __builtin_cpu_supports("avx512vl");
    case InstructionSet::AVX2:
        return avx2;
    case InstructionSet::PLAIN:
        break;
    }
#endif
    return set == InstructionSet::PLAIN;
}

InstructionSet instructionSetFor(const std::string& wanted, std::string& message)
{
    message.clear();
    InstructionSet best = InstructionSet::PLAIN;
    bool known = wanted.empty();
    for (const InstructionSet set : kInstructionSets)
    {
        const bool named = wanted == instructionSetName(set);
        known = known || named;
        if (!isRunnable(set)) continue;
        if (named) return set;
        best = set;
    }
    const std::string instead = std::string("; it runs with ") + instructionSetName(best);
    if (!known)
        message = "OSG_MIDAIR_SIMD is '" + wanted + "', it must be plain, avx2 or avx512" + instead;
    else if (!wanted.empty())
        message = "OSG_MIDAIR_SIMD is " + wanted +
                  ", which this processor or this build doesn't have" + instead;
    return best;
}

InstructionSet instructionSet()
{
    const int set = detail::setInUse.load(std::memory_order_relaxed);
    return static_cast<InstructionSet>(set < 0 ? detail::chooseSet() : set);
}

void useInstructionSet(InstructionSet set)
{
    detail::setInUse = static_cast<int>(set);
}

} // namespace midair::base
