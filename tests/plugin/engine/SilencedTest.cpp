// What users are told of a field that a cap silences.
#include "tests/plugin/KitTest.h"

#include <osgMidair/HapticStatistics>

#include <gtest/gtest.h>

TEST(Silenced, ByACapIsToldOnceByStatisticsAndReport)
{
    BoxScene box;
    box.scene->setMaxPressure(0.01); // one transducer at its lowest level gives more
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    for (int step = 1; step <= 5; ++step)
    {
        const auto before = box.result();
        box.move(1e-3 * step);
        ASSERT_TRUE(viewer.framesUntil([&] { return box.result() != before; }));
        const osgMidair::HapticStatistics statistics = box.scene->getStatistics();
        EXPECT_EQ(statistics.stop, "silenced");
        EXPECT_EQ(statistics.capFactor, 0.0);
        EXPECT_EQ(statistics.rms, 1.0);
        EXPECT_EQ(statistics.max, 1.0);
        EXPECT_EQ(statistics.level_Pa, 0.0);
        EXPECT_EQ(statistics.loudness, 0.0);
        ASSERT_EQ(statistics.messages.size(), 1u) << statistics.messages.back();
        EXPECT_NE(statistics.messages[0].find("raise MaxPressure above that"), std::string::npos)
            << statistics.messages[0];
    }
}
