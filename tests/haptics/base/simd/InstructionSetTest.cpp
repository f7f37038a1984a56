#include "haptics/base/simd/Kernel.h"
#include "tests/haptics/base/simd/OnEverySet.h"

#include <gtest/gtest.h>

using namespace midair::base;

namespace
{

int plainForm(int x)
{
    return x;
}
int avx2Form(int x)
{
    return 10 + x;
}
int avx512Form(int x)
{
    return 100 + x;
}
float plainForm(float x)
{
    return x + 0.5F;
}

} // namespace

TEST(InstructionSet, TheBestOneIsTakenWhereNoneIsWanted)
{
    std::string message = "before";
    const InstructionSet best = instructionSetFor("", message);
    EXPECT_EQ(message, "");
    EXPECT_TRUE(isRunnable(best));
    for (const InstructionSet set : kInstructionSets)
        EXPECT_TRUE(!isRunnable(set) || best >= set) << instructionSetName(set);
}

TEST(InstructionSet, AWantedOneIsTakenIfItRuns)
{
    for (const InstructionSet set : kInstructionSets)
    {
        std::string message;
        const InstructionSet taken = instructionSetFor(instructionSetName(set), message);
        if (isRunnable(set))
        {
            EXPECT_EQ(taken, set);
            EXPECT_EQ(message, "");
        }
        else
        {
            EXPECT_EQ(taken, instructionSetFor("", message));
            instructionSetFor(instructionSetName(set), message);
            EXPECT_NE(message.find("doesn't have"), std::string::npos) << message;
        }
    }
    EXPECT_TRUE(isRunnable(InstructionSet::PLAIN));
}

TEST(InstructionSet, AnUnknownOneIsNotTakenAndTold)
{
    std::string message;
    EXPECT_EQ(instructionSetFor("AVX2", message), instructionSetFor("", message));
    instructionSetFor("AVX2", message);
    EXPECT_EQ(message.find("OSG_MIDAIR_SIMD is 'AVX2', it must be plain, avx2 or avx512; it runs"),
              0U)
        << message;
}

TEST(InstructionSet, AllSetsAreCompiledForThisFamilyOfProcessors)
{
#if !defined(__x86_64__)
    GTEST_SKIP() << "only x86-64 has more than one";
#elif !defined(MIDAIR_HAS_SIMD)
    GTEST_SKIP() << "this build leaves them out: MIDAIR_SIMD is off";
#else
    EXPECT_EQ(isRunnable(InstructionSet::AVX2),
              __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"));
#endif
}

MIDAIR_ON_EVERY_SET(KernelForm);

TEST_P(KernelForm, IsThatOfTheSetInUse)
{
    const Kernel<int(int)> kernel(plainForm, avx2Form, avx512Form);
    const int offsets[] = {0, 10, 100};
    EXPECT_EQ(kernel(7), 7 + offsets[static_cast<int>(GetParam())]);
    EXPECT_EQ(instructionSet(), GetParam());
}

TEST_P(KernelForm, IsChosenByTheArguments)
{
    const Kernel<int(int), float(float)> kernel({plainForm, avx2Form, avx512Form},
                                                {plainForm, plainForm, plainForm});
    const int offsets[] = {0, 10, 100};
    EXPECT_EQ(kernel(7), 7 + offsets[static_cast<int>(GetParam())]);
    EXPECT_EQ(kernel(7.0F), 7.5F);
}
