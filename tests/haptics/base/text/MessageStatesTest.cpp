
#include "haptics/base/text/MessageLog.h"

#include <gtest/gtest.h>

using namespace midair::base;

namespace
{

constexpr MessageCode kFar = MessageCode::OBJECT_UNREACHABLE;

} // namespace

TEST(MessageLog, AStateIsNewWhenItBegins)
{
    MessageLog states;
    const auto look = [&](bool holds)
    {
        states.beginLook();
        const bool isNew = holds && states.note({kFar, 7});
        states.endLook();
        return isNew;
    };
    EXPECT_TRUE(look(true));
    EXPECT_FALSE(look(true));
    EXPECT_FALSE(look(false));
    EXPECT_TRUE(look(true)) << "it had ended";
}

TEST(MessageLog, TellsObjectsCodesAndReasonsApart)
{
    MessageLog states;
    states.beginLook();
    EXPECT_TRUE(states.note({kFar, 7}));
    EXPECT_FALSE(states.note({kFar, 7})) << "twice in one look";
    EXPECT_TRUE(states.note({kFar, 8}));
    EXPECT_TRUE(states.note({MessageCode::OBJECT_UNFELT, 7}));
    EXPECT_TRUE(states.note({kFar, 7, "part"}));
}

TEST(MessageLog, ALookThatIsBrokenOffChangesNothing)
{
    MessageLog states;
    states.beginLook();
    states.note({kFar, 7});
    states.endLook();
    states.beginLook(); // broken off before anything was noted
    states.beginLook();
    EXPECT_FALSE(states.note({kFar, 7}));
}

TEST(MessageLog, WhatIsKeptGoesOn)
{
    MessageLog states;
    states.beginLook();
    states.keepNoted({kFar, 7, "part"});
    EXPECT_TRUE(states.note({kFar, 7, "part"})) << "there was nothing to keep";
    states.endLook();
    for (int i = 0; i < 3; ++i)
    {
        states.beginLook();
        states.keepNoted({kFar, 7, "part"});
        states.endLook();
    }
    states.beginLook();
    EXPECT_FALSE(states.note({kFar, 7, "part"}));
}

TEST(MessageLog, SaysOfManyThatAreAlikeOnce)
{
    MessageLog log;
    log.sayOfAll(kFar, {}, "is far");
    EXPECT_TRUE(log.all().empty());
    log.sayOfAll(kFar, {"a", "b", "c"}, "is far");
    ASSERT_EQ(log.all().size(), 1U);
    EXPECT_EQ(log.all()[0], "a: is far; so it is with 2 more");
    EXPECT_EQ(log.messages()[0].path, "a");
}

TEST(MessageLog, AStateBeginsAgainOnceItHasEnded)
{
    MessageLog log;
    EXPECT_FALSE(log.begins({kFar}, false));
    EXPECT_TRUE(log.begins({kFar}));
    EXPECT_FALSE(log.begins({kFar}));
    EXPECT_TRUE(log.begins({kFar, 0, "part"})) << "another reason";
    log.ends({kFar});
    EXPECT_TRUE(log.begins({kFar})) << "it had ended";
    EXPECT_FALSE(log.begins({kFar, 0, "part"}));
    log.beginLook();
    log.endLook();
    EXPECT_FALSE(log.begins({kFar})) << "a look ends only what is noted in looks";
}
