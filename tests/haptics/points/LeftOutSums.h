#pragma once

#include "haptics/points/ControlPointSelector.h"

#include <array>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

namespace midair::haptics::test
{

/// Expects that what is left out of each object adds up to its points, and to the report's counts.
inline void expectLeftOutAddsUp(const std::vector<PosedObject>& objects, const SelectionReport& r)
{
    std::array<int, 5> all{};
    for (std::size_t i = 0; i < objects.size(); ++i)
    {
        const LeftOutPoints& o = r.leftOut.at(i);
        const std::array<int, 5> out{
            o.notFinite, o.noTarget, o.outOfWorkspace, o.crowded, o.overBudget};
        EXPECT_EQ(std::accumulate(out.begin(), out.end(), r.perObject.at(i)),
                  objects[i].positions.cols());
        for (std::size_t k = 0; k < all.size(); ++k)
            all[k] += out[k];
    }
    const std::array<int, 5> wanted{r.notFinite,
                                    r.noTarget,
                                    r.tooClose + r.behind + r.atReflector + r.outOfReach,
                                    r.spacedOut + r.crowdThinned + r.crowdMerged + r.crowdDropped,
                                    r.overBudget};
    EXPECT_EQ(all, wanted);
}

} // namespace midair::haptics::test
