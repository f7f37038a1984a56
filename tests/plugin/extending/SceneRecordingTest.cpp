// A scene on `record:`: its recording outlives changes of the array, and a full disk is told.
#include "device/recording/Recording.h"
#include "tests/plugin/KitTest.h"

#include <osgMidair/ArrayDescription>
#include <osgMidair/DeviceCallback>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <set>

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

using namespace osgMidair;

namespace
{

/// A folder of the test's own.
struct RecordedFolder
{
    const std::filesystem::path path = std::filesystem::path(testing::TempDir()) /
                                       ("midair-recorded-" + std::to_string(::getpid()));
    RecordedFolder() { std::filesystem::create_directories(path); }
    ~RecordedFolder() { std::filesystem::remove_all(path); }
    std::string file(const char* name) const { return (path / name).string(); }
};

std::string bytesOf(const std::string& file)
{
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

ArrayDescription boards(int count)
{
    ArrayDescription array;
    array.name = "boards";
    array.addGrid({0, 0, 0}, {0, 0, 2}, {1, 0, 0}, 8, 10, 0.0105);
    if (count > 1) array.addGrid({0, 0, 0.3}, {0, 0, -1}, {1, 0, 0}, 8, 10, 0.0105);
    return array;
}

void saveTo(const std::string& file, const ArrayDescription& array)
{
    std::string error;
    ASSERT_TRUE(array.save(file, error)) << error;
}

/// What a recording holds: its fields, and how many of them have some transducer silent.
struct Held
{
    int fields = 0;
    int silences = 0;
    int without17 = 0;
    midair::device::recording::Stop end = midair::device::recording::Stop::MORE;
};

Held read(const std::string& file)
{
    namespace recording = midair::device::recording;
    const std::string bytes = bytesOf(file);
    recording::Reader reader(bytes, file);
    recording::Entry entry;
    Held held;
    while ((held.end = reader.next(entry)) == recording::Stop::MORE)
    {
        if (entry.kind == recording::Kind::SILENCE) ++held.silences;
        if (entry.kind != recording::Kind::FIELD) continue;
        ++held.fields;
        if (entry.signal.duty[17] == 0) ++held.without17;
    }
    return held;
}

/// Notes the states that it is told of.
struct States : DeviceCallback
{
    void changed(const DeviceChange& change) override
    {
        seen.insert(change.now);
        if (change.now == ArrayState::LOST) status = change.status;
    }
    std::set<ArrayState> seen;
    std::string status;

protected:
    ~States() override = default;
};

/// Limits what files may hold, as a full disk does.
struct FullDisk
{
    explicit FullDisk(rlim_t bytes)
    {
        std::signal(SIGXFSZ, SIG_IGN);
        ::getrlimit(RLIMIT_FSIZE, &before);
        const rlimit small{bytes, before.rlim_max};
        ::setrlimit(RLIMIT_FSIZE, &small);
    }
    ~FullDisk() { ::setrlimit(RLIMIT_FSIZE, &before); }
    rlimit before{};
};

} // namespace

TEST(SceneRecording, GoesOnWhereTheArrayChanges)
{
    const RecordedFolder folder;
    const std::string array = folder.file("array.json");
    const std::string file = folder.file("show.recording");
    saveTo(array, boards(2));
    std::string before;
    {
        BoxScene box;
        box.scene->setArray(array);
        box.scene->setDevice("record:" + file);
        HeadlessViewer viewer(box.scene);
        ASSERT_TRUE(viewer.framesUntil(
            [&] { return box.scene->getStatistics().state == ArrayState::PLAYING; }));
        before = bytesOf(file);
        ASSERT_GT(before.size(), 160u);
        // The file of the array changes ..
        ArrayDescription other = boards(2);
        other.dead = {17};
        saveTo(array, other);
        ASSERT_TRUE(viewer.framesUntil([&] { return says(*box.scene, "was read again: 159 of"); }));
        ASSERT_TRUE(viewer.framesUntil(
            [&] { return box.scene->getStatistics().state == ArrayState::PLAYING; }));
        // .. and so do the settings, which open the device anew as well.
        const auto result = box.result();
        box.scene->setDead("21");
        ASSERT_TRUE(viewer.framesUntil(
            [&]
            {
                return box.result() && box.result() != result && box.points() > 0 &&
                       box.scene->getStatistics().state == ArrayState::PLAYING;
            }));
    }
    EXPECT_EQ(bytesOf(file).substr(0, before.size()), before) << "what was recorded is there";
    const Held held = read(file);
    EXPECT_EQ(held.end, midair::device::recording::Stop::END);
    EXPECT_GE(held.silences, 3) << "a pause at each change, and the end";
    EXPECT_GE(held.without17, 2);
    EXPECT_GT(held.fields, held.without17);
}

TEST(SceneRecording, EndsWhereTheArrayHasAnotherSizeAndStays)
{
    const RecordedFolder folder;
    const std::string array = folder.file("array.json");
    const std::string file = folder.file("show.recording");
    saveTo(array, boards(2));
    BoxScene box;
    box.scene->setArray(array);
    box.scene->setDevice("record:" + file);
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil(
        [&] { return box.scene->getStatistics().state == ArrayState::PLAYING; }));
    const std::string before = bytesOf(file);
    saveTo(array, boards(1));
    EXPECT_TRUE(viewer.framesUntil(
        [&] { return says(*box.scene, "for 160 transducers") && says(*box.scene, "has 80"); }));
    EXPECT_NE(box.scene->getStatistics().state, ArrayState::PLAYING);
    EXPECT_EQ(bytesOf(file).substr(0, before.size()), before);
    EXPECT_EQ(read(file).end, midair::device::recording::Stop::END);
}

TEST(SceneRecording, AnotherSceneBeginsAnew)
{
    const RecordedFolder folder;
    const std::string file = folder.file("show.recording");
    for (int i = 0; i < 2; ++i)
    {
        BoxScene box;
        box.scene->setDevice("record:" + file);
        HeadlessViewer viewer(box.scene);
        ASSERT_TRUE(viewer.framesUntil(
            [&] { return box.scene->getStatistics().state == ArrayState::PLAYING; }));
    }
    EXPECT_EQ(read(file).silences, 1);
}

TEST(SceneRecording, AFullDiskIsToldHoweverFieldsArePlayed)
{
    struct Case
    {
        const char* name;
        std::function<void(BoxScene&)> set;
        bool isMoving;
    };
    const Case cases[] = {
        {"a field that is held, then another", [](BoxScene&) {}, true},
        {"cycle", [](BoxScene& box) { box.scene->setCycle(4); }, false},
        {"cycle, moving", [](BoxScene& box) { box.scene->setCycle(4); }, true},
        {"modulation", [](BoxScene& box) { box.surface->setModulationFrequency(200.0); }, false},
        {"subsets", [](BoxScene& box) { box.scene->setSubsets(2); }, true},
    };
    const RecordedFolder folder;
    for (const Case& one : cases)
    {
        BoxScene box;
        const osg::ref_ptr<States> states = new States;
        box.scene->setDevice("record:" + folder.file("show.recording"));
        box.scene->setDeviceCallback(states);
        one.set(box);
        HeadlessViewer viewer(box.scene);
        double x_m = 0.0;
        const auto comes = [&](const std::function<bool()>& done)
        {
            return viewer.framesUntil(
                [&]
                {
                    if (one.isMoving) box.move(x_m = x_m > 0.01 ? 0.0 : x_m + 0.001);
                    return done();
                });
        };
        ASSERT_TRUE(comes([&] { return box.scene->getStatistics().state == ArrayState::PLAYING; }))
            << one.name;
        {
            const FullDisk full(bytesOf(folder.file("show.recording")).size() + 50);
            EXPECT_TRUE(comes([&] { return states->seen.count(ArrayState::LOST) > 0; }))
                << one.name;
        }
        const HapticStatistics statistics = box.scene->getStatistics();
        EXPECT_EQ(statistics.state, ArrayState::LOST) << one.name;
        EXPECT_NE(states->status.find("File too large"), std::string::npos) << states->status;
        EXPECT_TRUE(comes([&] { return says(*box.scene, "device: lost: writing failed after"); }))
            << one.name;
        EXPECT_GE(statistics.fields.faults, 1u) << one.name;
    }
}
