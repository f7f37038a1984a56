
#include "haptics/base/text/MessageLog.h"
#include "tests/haptics/base/threads/SetClock.h"

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
    log.sayOfAll({}, about(kFar, "a", "is far"));
    EXPECT_TRUE(log.all().empty());
    for (const std::uint64_t object : {1, 2, 3})
        log.begins({kFar, object});
    log.sayOfAll({{kFar, 1}, {kFar, 2}, {kFar, 3}}, about(kFar, "a", "is far"));
    ASSERT_EQ(log.all().size(), 1U);
    EXPECT_EQ(log.all()[0].find("a: is far; "), 0U) << log.all()[0];
    EXPECT_NE(log.all()[0].find(" 2 more"), std::string::npos) << log.all()[0];
    EXPECT_EQ(log.messages()[0].path, "a");
    log.ends({kFar, 1});
    log.ends({kFar, 3});
    EXPECT_TRUE(log.messages()[0].isActive) << "one of them holds";
    log.ends({kFar, 2});
    EXPECT_FALSE(log.messages()[0].isActive);
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

TEST(MessageLog, AMessageIsActiveUntilItsTopicEnds)
{
    midair::test::SetClock clock(5.0);
    MessageLog log({}, clock);
    log.begins({kFar, 7});
    log.say({kFar, 7}, about(kFar, "a", "is far"));
    clock.jump(4.0);
    EXPECT_TRUE(log.messages()[0].isActive);
    EXPECT_EQ(log.messages()[0].since_s, 5.0);
    EXPECT_EQ(log.messages()[0].until_s, 0.0);
    log.ends({kFar, 7});
    log.ends({kFar, 7});
    EXPECT_FALSE(log.messages()[0].isActive);
    EXPECT_EQ(log.messages()[0].until_s, 9.0);
    clock.jump(2.0);
    log.begins({kFar, 7});
    log.say({kFar, 7}, about(kFar, "a", "is far"));
    EXPECT_TRUE(log.messages()[0].isActive);
    EXPECT_EQ(log.messages()[0].since_s, 11.0);
    EXPECT_EQ(log.messages()[0].until_s, 0.0);
    EXPECT_EQ(log.messages()[0].count, 2U);
    log.endsOf(7);
    EXPECT_FALSE(log.messages()[0].isActive);
}

TEST(MessageLog, WhatHasHappenedIsNeverActive)
{
    MessageLog log;
    log.say({MessageCode::DEVICE_OPENED, "device: open"});
    EXPECT_FALSE(log.messages()[0].isActive);
    EXPECT_EQ(log.messages()[0].until_s, 0.0);
    log.begins({MessageCode::CALLBACK_THREW});
    log.say({MessageCode::CALLBACK_THREW}, {MessageCode::CALLBACK_THREW, "it throws"});
    EXPECT_TRUE(log.messages()[1].isActive) << "it is said of a topic";
}

TEST(MessageLog, WhatIsSaidNowEndsWhatIsNot)
{
    MessageLog log;
    const Topic topic{MessageCode::SETTINGS_INVALID};
    const Message one{MessageCode::SETTINGS_INVALID, "cycle is wrong"};
    const Message two{MessageCode::CAP_PRESSURE, "held down to 200 Pa"};
    log.sayNow(topic, {one, two});
    log.sayNow(topic, {one, two});
    EXPECT_EQ(log.messages()[0].count, 1U) << "it goes on";
    std::uint64_t seen = log.changes();
    log.sayNow(topic, {one, {MessageCode::CAP_PRESSURE, "held down to 100 Pa"}});
    EXPECT_EQ(log.messages()[1].text, "held down to 100 Pa");
    EXPECT_TRUE(log.changedSince(seen).empty()) << "a newer number is no change";
    log.sayNow(topic, {two});
    EXPECT_FALSE(log.messages()[0].isActive);
    EXPECT_TRUE(log.messages()[1].isActive);
    const std::vector<Message> changed = log.changedSince(seen);
    ASSERT_EQ(changed.size(), 1U);
    EXPECT_EQ(changed[0].text, one.text);
    log.forgetEnded();
    EXPECT_EQ(log.all(), std::vector<std::string>{two.text});
}

TEST(MessageLog, AFieldEndsWhatIsNotSaidOfIt)
{
    MessageLog log;
    log.say({MessageCode::SOLVER_REFUSED, "too many points"});
    log.say({MessageCode::DEVICE_LOST, "unplugged"});
    log.begins({MessageCode::FIELD_SILENCED});
    log.say({MessageCode::FIELD_SILENCED}, {MessageCode::FIELD_SILENCED, "too quiet"});
    const std::uint64_t before = MessageLog::saidNow();
    log.say({MessageCode::FIELD_FAILED, "it threw"});
    log.endField(before);
    const std::vector<Message> all = log.messages();
    EXPECT_FALSE(all[0].isActive);
    EXPECT_TRUE(all[1].isActive) << "it is not of a field";
    EXPECT_TRUE(all[2].isActive) << "its topic holds";
    EXPECT_TRUE(all[3].isActive) << "it was said since";
    log.end(MessageCode::DEVICE_LOST);
    EXPECT_FALSE(log.messages()[1].isActive);
}

TEST(MessageLog, ALookEndsWhatItDoesNotNote)
{
    MessageLog log;
    const auto look = [&](bool holds)
    {
        log.beginLook();
        if (holds) log.note({kFar, 7}, about(kFar, "a", "is far"));
        log.endLook();
        return log.messages()[0].isActive;
    };
    EXPECT_TRUE(look(true));
    EXPECT_TRUE(look(true));
    EXPECT_EQ(log.messages()[0].count, 1U);
    EXPECT_FALSE(look(false));
    EXPECT_TRUE(look(true));
    log.beginLook(); // broken off
    EXPECT_TRUE(log.messages()[0].isActive);
    EXPECT_TRUE(look(true));
}

TEST(MessageLog, TakesOverWhatEndsInTheOther)
{
    MessageLog other;
    MessageLog log;
    other.say({MessageCode::DEVICE_LOST, "unplugged"});
    log.takeNew(other.messages());
    EXPECT_TRUE(log.messages()[0].isActive);
    other.end(MessageCode::DEVICE_LOST);
    log.takeNew(other.messages());
    EXPECT_FALSE(log.messages()[0].isActive);
    other.say({MessageCode::DEVICE_LOST, "a stall"});
    log.takeNew(other.messages());
    EXPECT_TRUE(log.messages()[0].isActive);
    EXPECT_EQ(log.messages()[0].count, 2U);
    log.takeNew({}); // there is another one, that has said nothing
    EXPECT_FALSE(log.messages()[0].isActive);
    MessageLog third;
    third.say({MessageCode::DEVICE_LOST, "unplugged"});
    log.takeNew(third.messages());
    EXPECT_TRUE(log.messages()[0].isActive);
}
