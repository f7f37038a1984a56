// What a scene's settings make of the options that its fields are solved with.
#include "haptics/propagation/Exposure.h"
#include "tests/plugin/KitTest.h"

#include <gtest/gtest.h>

using namespace osgMidair;

TEST(EngineSettings, WhatIsHeardOfAHeldFieldFollowsTheFieldRate)
{
    for (const double rate_Hz : {200.0, 20000.0})
    {
        BoxScene box;
        box.scene->setFieldRate(rate_Hz);
        HeadlessViewer viewer(box.scene);
        ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
        const auto first = box.result();
        box.move(0.03);
        ASSERT_TRUE(viewer.framesUntil([&] { return box.result() != first; }));
        const auto result = box.result();
        ASSERT_GT(result->report().driveChange, 0.0);
        EXPECT_DOUBLE_EQ(result->report().audibleChange,
                         result->report().driveChange * midair::haptics::audibleShare(rate_Hz));
    }
    EXPECT_NE(midair::haptics::audibleShare(200.0), midair::haptics::audibleShare(20000.0));
}
