// Files with more scenes than can play: threads and memory have a bound, and the rest is told.
#include "plugin/engine/SceneOwners.h"
#include "tests/plugin/KitTest.h"

#include <osg/Sequence>
#include <osg/Switch>

#include <algorithm>
#include <fstream>
#include <set>
#include <vector>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

/// A number in kB or of threads from /proc/self/status.
long ofProcess(const std::string& name)
{
    std::ifstream status("/proc/self/status");
    std::string word;
    while (status >> word)
        if (word == name + ":")
        {
            long number = 0;
            status >> number;
            return number;
        }
    return 0;
}

/// Scenes beside each other.
struct Many
{
    osg::ref_ptr<osg::Switch> root = new osg::Switch;
    std::vector<osg::ref_ptr<HapticScene>> scenes;

    explicit Many(int count)
    {
        for (int i = 0; i < count; ++i)
        {
            BoxScene box;
            box.scene->setName("scene " + std::to_string(i));
            box.scene->setDevice("null:");
            root->addChild(box.scene);
            scenes.push_back(box.scene);
        }
    }

    std::set<int> playing() const
    {
        std::set<int> all;
        for (std::size_t i = 0; i < scenes.size(); ++i)
            if (scenes[i]->getStatistics().state == ArrayState::PLAYING)
                all.insert(static_cast<int>(i));
        return all;
    }
};

constexpr std::size_t kMost = PlayingPlace::kMost;

} // namespace

TEST(ManyScenes, TakeNoMoreThreadsAndMemoryThanThoseThatPlay)
{
    long threads[2] = {};
    long memory_kB[2] = {};
    for (int i = 0; i < 2; ++i)
    {
        const Many many(i == 0 ? static_cast<int>(kMost) : 400);
        const long before_kB = ofProcess("VmRSS");
        HeadlessViewer viewer(many.root);
        ASSERT_TRUE(viewer.framesUntil([&] { return many.playing().size() == kMost; }));
        viewer.frames(3);
        EXPECT_EQ(many.playing().size(), kMost);
        threads[i] = ofProcess("Threads");
        memory_kB[i] = ofProcess("VmRSS") - before_kB;
    }
    EXPECT_LE(threads[1], threads[0]) << "none for a scene that doesn't play";
    EXPECT_LE(memory_kB[1], memory_kB[0] + 400 * 100) << "kB of " << memory_kB[0];
}

TEST(ManyScenes, ThoseThatDoNotPlayAreToldByNameOnce)
{
    const Notices notices;
    const Many many(20);
    HeadlessViewer viewer(many.root);
    ASSERT_TRUE(viewer.framesUntil([&] { return many.playing().size() == kMost; }));
    viewer.frames(50);
    const std::set<int> playing = many.playing();
    for (int i = 0; i < 20; ++i)
    {
        const std::string name = "the HapticScene \"scene " + std::to_string(i) + "\"";
        const std::string what = name + " is not played: ";
        const HapticStatistics statistics = many.scenes[i]->getStatistics();
        const bool plays = playing.count(i) > 0;
        EXPECT_EQ(says(*many.scenes[i], what), !plays) << i;
        const std::size_t first = notices.text().find(what);
        EXPECT_EQ(first == std::string::npos, plays) << i;
        if (plays) continue;
        EXPECT_EQ(notices.text().find(what, first + 1), std::string::npos) << i;
        ASSERT_EQ(statistics.told.size(), 1u);
        EXPECT_EQ(statistics.told[0].code, "scene.limit");
        EXPECT_EQ(statistics.told[0].count, 1u);
        EXPECT_FALSE(many.scenes[i]->getGrantedSettings().enabled);
    }
}

TEST(ManyScenes, APlaceThatIsFreeIsTaken)
{
    Many many(18);
    HeadlessViewer viewer(many.root);
    ASSERT_TRUE(viewer.framesUntil([&] { return many.playing().size() == kMost; }));
    const int first = *many.playing().begin();
    // Removed and still held, switched off, and deleted.
    many.root->removeChild(many.scenes[first]);
    EXPECT_TRUE(viewer.framesUntil(
        [&] { return many.playing().size() == kMost && many.playing().count(first) == 0; }));
    const int second = *many.playing().begin();
    many.root->setChildValue(many.scenes[second], false);
    EXPECT_TRUE(viewer.framesUntil(
        [&] { return many.playing().size() == kMost && many.playing().count(second) == 0; }));
    const long threads = ofProcess("Threads");
    many.root->setChildValue(many.scenes[second], true);
    many.root->addChild(many.scenes[first]);
    viewer.frames(20);
    EXPECT_EQ(many.playing().size(), kMost) << "they wait";
    EXPECT_LE(ofProcess("Threads"), threads);
    const int third = *many.playing().begin();
    many.root->removeChild(many.scenes[third]);
    many.scenes.erase(many.scenes.begin() + third);
    EXPECT_TRUE(viewer.framesUntil([&] { return many.playing().size() == kMost; }));
}

TEST(ManyScenes, ThoseThatAreShownInTurnLeaveTheirPlaces)
{
    Many many(40);
    many.root->setAllChildrenOff();
    HeadlessViewer viewer(many.root);
    for (int i = 0; i < 40; ++i)
    {
        many.root->setSingleChildOn(i);
        ASSERT_TRUE(viewer.framesUntil([&] { return many.playing() == std::set<int>{i}; })) << i;
    }
    EXPECT_LE(ofProcess("Threads"), 4 * static_cast<long>(kMost));
}

TEST(ManyScenes, ThoseThatAreDisabledOrInsideAnotherTakeNoPlace)
{
    Many many(40);
    for (int i = 0; i < 20; ++i)
        many.scenes[i]->setEnabled(false);
    osg::ref_ptr<HapticScene> outer = new HapticScene;
    outer->setName("outer");
    outer->setArray("board");
    outer->setDevice("null:");
    for (int i = 20; i < 39; ++i)
    {
        many.root->removeChild(many.scenes[i]);
        outer->addChild(many.scenes[i]);
    }
    many.root->addChild(outer);
    HeadlessViewer viewer(many.root);
    EXPECT_TRUE(viewer.framesUntil([&] { return many.playing() == std::set<int>{39}; }));
    EXPECT_TRUE(
        viewer.framesUntil([&] { return outer->getStatistics().state == ArrayState::PLAYING; }));
    // Put around scenes that play, it takes over.
    Many others(16);
    osg::ref_ptr<osg::Group> beside = new osg::Group;
    for (const auto& scene : others.scenes)
        beside->addChild(scene);
    viewer.viewer.setSceneData(beside);
    EXPECT_TRUE(viewer.framesUntil([&] { return others.playing().size() == kMost; }));
    osg::ref_ptr<HapticScene> around = new HapticScene;
    around->setArray("board");
    around->setDevice("null:");
    around->addChild(beside);
    viewer.viewer.setSceneData(around);
    EXPECT_TRUE(viewer.framesUntil(
        [&] {
            return around->getStatistics().state == ArrayState::PLAYING && others.playing().empty();
        }));
}
