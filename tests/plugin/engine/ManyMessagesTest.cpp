// Messages that come in each frame with other words.
#include "tests/plugin/KitTest.h"

#include <osgMidair/HandSource>

#include <algorithm>
#include <chrono>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

/// Has something else to say in each frame.
struct TalkingHands : HandSource
{
    bool getHands(double, std::vector<Hand>&) override { return false; }
    std::string getStatus() const override { return "talks"; }
    std::vector<std::string> takeMessages() override
    {
        const char letter = static_cast<char>('a' + said % 26);
        return {"marker " + std::string(static_cast<std::size_t>(1 + said++ / 26), letter)};
    }
    int said = 0;
};

} // namespace

TEST(ManyMessages, OfOneKindNeitherHideAFaultNorFillTheLog)
{
    using Clock = std::chrono::steady_clock;
    BoxScene box;
    box.scene->setMetresPerUnit(0.0);
    const osg::ref_ptr<TalkingHands> hands = new TalkingHands;
    box.scene->setHandSource(hands);
    HeadlessViewer viewer(box.scene);
    Notices notices;
    const auto start = Clock::now();
    viewer.frames(300);
    const double took_s = std::chrono::duration<double>(Clock::now() - start).count();
    ASSERT_EQ(hands->said, 300);
    std::uint64_t count = 0;
    std::size_t texts = 0;
    bool isFaultThere = false;
    for (const HapticMessage& message : box.scene->getStatistics().told)
    {
        isFaultThere = isFaultThere || message.code == "settings.silenced";
        if (message.code != "hands.source") continue;
        ++texts;
        count += message.count;
    }
    EXPECT_TRUE(isFaultThere);
    EXPECT_EQ(texts, 8u);
    EXPECT_EQ(count, 300u);
    const std::string text = notices.text();
    std::size_t lines = 0;
    for (std::size_t at = text.find("marker "); at != std::string::npos;
         at = text.find("marker ", at + 1))
        ++lines;
    EXPECT_GE(lines, 8u);
    EXPECT_LE(static_cast<double>(lines), 8.0 + took_s) << "one a second";
    box.scene = nullptr;
    viewer.viewer.setSceneData(nullptr);
}
