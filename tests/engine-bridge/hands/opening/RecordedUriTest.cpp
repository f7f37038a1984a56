#include "engine-bridge/hands/opening/HandOpening.h"

#include <gtest/gtest.h>

using midair::bridge::RecordedUri;

TEST(RecordedUri, SaysFileAndLoop)
{
    const auto once = RecordedUri::parse("recorded:hand.csv");
    ASSERT_TRUE(once);
    EXPECT_EQ(once->file, "hand.csv");
    EXPECT_FALSE(once->loops);
    const auto loop = RecordedUri::parse("recorded:my hands/a?b.csv?loop");
    ASSERT_TRUE(loop);
    EXPECT_EQ(loop->file, "my hands/a?b.csv");
    EXPECT_TRUE(loop->loops);
    for (const char* text : {"recorded:hand.csv", "recorded:hand.csv?loop", "recorded:"})
        EXPECT_EQ(RecordedUri::parse(text)->text(), text);
}

TEST(RecordedUri, NothingBeforeTheLoopIsAFileOfThatName)
{
    const auto only = RecordedUri::parse("recorded:?loop");
    ASSERT_TRUE(only);
    EXPECT_EQ(only->file, "?loop");
    EXPECT_FALSE(only->loops);
}

TEST(RecordedUri, OthersAreNone)
{
    for (const char* uri : {"", "none", "openxr:", "hand.csv?loop", "record:hand.csv"})
        EXPECT_FALSE(RecordedUri::parse(uri)) << uri;
}
