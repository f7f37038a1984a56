// The child of a program that plays scenes of the kit.
#include "tests/Forked.h"
#include "tests/plugin/KitTest.h"

#include <osgMidair/Recording>

#include <filesystem>
#include <memory>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

bool isClosed(const HapticScene& scene)
{
    return scene.getStatistics().state == ArrayState::CLOSED && !scene.getField() &&
           ::says(scene, "the program has forked");
}

} // namespace

TEST(HapticScene, InTheChildOfAForkIsClosedAndTheParentPlaysOn)
{
    const std::string file = testing::TempDir() + "scene.midair";
    BoxScene box;
    box.scene->setDevice("record:" + file);
    auto viewer = std::make_unique<HeadlessViewer>(box.scene);
    ASSERT_TRUE(viewer->framesUntil(
        [&] { return box.scene->getStatistics().state == ArrayState::PLAYING; }));
    ASSERT_TRUE(box.scene->waitForField(60.0));
    const auto bytes = std::filesystem::file_size(file);
    const auto work = [&]
    {
        if (!isClosed(*box.scene)) return 1;
        box.scene->setMuted(true);
        box.scene->silence();
        viewer->frames(3);
        if (!isClosed(*box.scene)) return 2;
        if (box.scene->waitForField(1e6)) return 3;
        std::string why;
        const osg::ref_ptr<const HapticField> field = box.scene->solve(&why);
        if (!field || field->getPoints().empty()) return 4;
        // A scene of its own plays.
        BoxScene own;
        {
            HeadlessViewer other(own.scene);
            if (!other.framesUntil(
                    [&] { return own.scene->getStatistics().state == ArrayState::PLAYING; }))
                return 5;
        }
        viewer.reset();
        box.transform = nullptr;
        box.surface = nullptr;
        box.scene = nullptr;
        return 0;
    };
    EXPECT_EQ(inChild(work), 0);
    EXPECT_EQ(std::filesystem::file_size(file), bytes) << "the child has written to it";
    EXPECT_EQ(box.scene->getStatistics().state, ArrayState::PLAYING);
    const auto sent = box.scene->getStatistics().fields.sent;
    box.move(0.02);
    EXPECT_TRUE(viewer->framesUntil([&] { return box.scene->getStatistics().fields.sent > sent; }));
}

TEST(Recording, InTheChildOfAForkIsTheParents)
{
    const std::string file = testing::TempDir() + "own.midair";
    std::string error;
    osg::ref_ptr<Recorder> recorder = Recorder::open(file, 2, error);
    ASSERT_TRUE(recorder) << error;
    ASSERT_TRUE(recorder->record({{1.0F, 0.0F}, {0.0F, 1.0F}}));
    const auto bytes = std::filesystem::file_size(file);
    EXPECT_EQ(inChild(
                  [&]
                  {
                      if (recorder->record({{0.5F, 0.0F}, {0.0F, 0.5F}})) return 1;
                      recorder->silence();
                      if (recorder->getStatus().find("forked") == std::string::npos) return 2;
                      recorder = nullptr;
                      return 0;
                  }),
              0);
    EXPECT_EQ(std::filesystem::file_size(file), bytes);
    recorder = nullptr;
    PlayerOptions options;
    options.loop = true;
    osg::ref_ptr<Player> player = Player::open(file, "sim:", error, options);
    ASSERT_TRUE(player) << error;
    EXPECT_EQ(inChild(
                  [&]
                  {
                      player->setMuted(true);
                      player->stop();
                      if (!player->isFinished()) return 1;
                      if (player->getStatus().find("forked") == std::string::npos) return 2;
                      player = nullptr;
                      return 0;
                  }),
              0);
    EXPECT_FALSE(player->isFinished());
}
