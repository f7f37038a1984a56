#pragma once

#include "engine-bridge/hands/openxr/OpenXrHandSource.h"
#include "tests/Eventually.h"
#include "tests/fake-openxr/FakeHands.h"

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace midair::bridge
{

inline const Eigen::Vector3d kTip(0.1, 1.2, -0.3);

inline Hand handAt(int id, const Eigen::Vector3d& tip)
{
    return openHandWithIndexTipAt(id, tip, Eigen::Quaterniond::Identity());
}

/// A source of the fake runtime, and what it gives and says.
class OpenXrHands : public testing::Test
{
protected:
    void SetUp() override
    {
        useFakeRuntime();
        options.retry_s = 0.01;
    }

    void TearDown() override
    {
        FakeAccess()->blocked.clear();
        source.reset();
        const FakeAccess fake;
        EXPECT_EQ(fake->misuse, std::vector<std::string>());
        EXPECT_EQ(fake->alive, 0);
    }

    void open(const Eigen::Isometry3d& placement = OpenXrHandSource::upright())
    {
        source = std::make_unique<OpenXrHandSource>(options, placement);
    }

    void show(int id, const Hand& hand)
    {
        const FakeAccess fake;
        fake->hands.at(static_cast<std::size_t>(id)) = fakeHand(hand);
    }

    /// Asks for frames until \a done.
    bool framesUntil(const std::function<bool()>& done)
    {
        return eventually(
            [&]
            {
                source->frameAt(7.0, frame);
                for (const std::string& message : source->takeMessages())
                    said.push_back(message);
                return done();
            });
    }

    bool handsCome(std::size_t count)
    {
        return framesUntil([&] { return frame.hands.size() == count; });
    }

    /// What is said when nothing else comes.
    std::string message()
    {
        open();
        EXPECT_TRUE(framesUntil([&] { return !said.empty(); }));
        EXPECT_TRUE(frame.hands.empty());
        EXPECT_EQ(said.size(), 1u);
        return said.empty() ? "" : said[0];
    }

    OpenXrOptions options;
    std::unique_ptr<OpenXrHandSource> source;
    HandFrame frame;
    std::vector<std::string> said;
};

} // namespace midair::bridge
