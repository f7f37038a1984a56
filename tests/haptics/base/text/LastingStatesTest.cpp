
#include "haptics/base/text/MessageLog.h"

#include <gtest/gtest.h>

using namespace midair::base;

namespace
{

constexpr MessageCode kFar = MessageCode::OBJECT_UNREACHABLE;

} // namespace

TEST(LastingStates, AStateIsNewWhenItBegins)
{
    LastingStates states;
    const auto look = [&](bool holds)
    {
        states.begin();
        const bool isNew = holds && states.note(kFar, 7);
        states.end();
        return isNew;
    };
    EXPECT_TRUE(look(true));
    EXPECT_FALSE(look(true));
    EXPECT_FALSE(look(false));
    EXPECT_TRUE(look(true)) << "it had ended";
}

TEST(LastingStates, TellsObjectsCodesAndReasonsApart)
{
    LastingStates states;
    states.begin();
    EXPECT_TRUE(states.note(kFar, 7));
    EXPECT_FALSE(states.note(kFar, 7)) << "twice in one look";
    EXPECT_TRUE(states.note(kFar, 8));
    EXPECT_TRUE(states.note(MessageCode::OBJECT_UNFELT, 7));
    EXPECT_TRUE(states.note(kFar, 7, "part"));
}

TEST(LastingStates, ALookThatIsBrokenOffChangesNothing)
{
    LastingStates states;
    states.begin();
    states.note(kFar, 7);
    states.end();
    states.begin(); // broken off before anything was noted
    states.begin();
    EXPECT_FALSE(states.note(kFar, 7));
}

TEST(LastingStates, WhatIsKeptGoesOn)
{
    LastingStates states;
    states.begin();
    states.keep(kFar, 7, "part");
    EXPECT_TRUE(states.note(kFar, 7, "part")) << "there was nothing to keep";
    states.end();
    for (int i = 0; i < 3; ++i)
    {
        states.begin();
        states.keep(kFar, 7, "part");
        states.end();
    }
    states.begin();
    EXPECT_FALSE(states.note(kFar, 7, "part"));
}

TEST(Alike, IsOneMessageHoweverManyThereAre)
{
    MessageLog log;
    Alike none;
    none.tell(kFar, "is far", log);
    EXPECT_TRUE(log.all().empty());
    Alike three;
    for (const char* path : {"a", "b", "c"})
        three.add(path);
    three.tell(kFar, "is far", log);
    ASSERT_EQ(log.all().size(), 1U);
    EXPECT_EQ(log.all()[0], "a: is far; so it is with 2 more");
    EXPECT_EQ(log.messages()[0].path, "a");
}
