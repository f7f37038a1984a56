#pragma once

#include "haptics/base/simd/InstructionSet.h"

#include <ostream>
#include <string>

#include <gtest/gtest.h>

namespace midair::base
{

/// Tests that run once with each instruction set that this processor has.
class OnEverySet : public testing::TestWithParam<InstructionSet>
{
protected:
    void SetUp() override
    {
        if (!isRunnable(GetParam()))
            GTEST_SKIP() << "this processor or this build has no "
                         << instructionSetName(GetParam());
        useInstructionSet(GetParam());
    }
    void TearDown() override { useInstructionSet(_before); }

private:
    InstructionSet _before = instructionSet();
};

/// For names of tests.
inline void PrintTo(InstructionSet set, std::ostream* out)
{
    *out << instructionSetName(set);
}

inline std::string setNameOf(const testing::TestParamInfo<InstructionSet>& info)
{
    return instructionSetName(info.param);
}

/// Defines the suite \a name.
#define MIDAIR_ON_EVERY_SET(name)                                                                  \
    class name : public midair::base::OnEverySet                                                   \
    {                                                                                              \
    };                                                                                             \
    INSTANTIATE_TEST_SUITE_P(                                                                      \
        With, name, testing::ValuesIn(midair::base::kInstructionSets), midair::base::setNameOf)

} // namespace midair::base
