// Code that a scene would run, files that it would write, read or wait for.
#include "haptics/array/TransducerArray.h"
#include "plugin/engine/SceneAccess.h"
#include "tests/hostile/Hostile.h"

#include <osgMidair/HapticDevice>
#include <osgMidair/HapticOverlays>

#include <osg/Group>

#include <sys/stat.h>

using namespace osgMidair;

namespace
{

const std::string kPrecious = "my thesis\n";

std::string recordTo(const std::string& file)
{
    return "record:" + file;
}

} // namespace

TEST_P(Hostile, NoCodeIsLoaded)
{
    const Variable mark("MIDAIR_EVIL_MARK", _place.outside("mark"));
    std::filesystem::copy_file(MIDAIR_EVIL_LOADER, _place.beside("evil.so"));
    for (const char* trust : {"", "scene"})
        for (const std::string& loader : {_place.beside("evil.so"), std::string("./evil.so")})
            for (const bool enabled : {true, false})
            {
                const Variable trusted("OSG_MIDAIR_TRUST", trust);
                const auto scene = fromFile(
                    [&](HapticScene& s)
                    {
                        s.setHands("openxr:?loader=" + loader);
                        s.setEnabled(enabled);
                    });
                viewBriefly(*scene);
                EXPECT_FALSE(std::filesystem::exists(_place.outside("mark"))) << loader;
                EXPECT_TRUE(says(*scene, "asks for the hands \"openxr:?loader="))
                    << messages(*scene);
            }
}

// Or the tests above would see nothing whatever happens. Once: a library's constructors run once a
// program.
TEST(HostileControl, TheUsersOwnLoaderIsLoaded)
{
    const Workplace place;
    const Variable mark("MIDAIR_EVIL_MARK", place.outside("mark"));
    const Variable hands("OSG_MIDAIR_HANDS", "openxr:?loader=" MIDAIR_EVIL_LOADER);
    BoxScene box;
    HeadlessViewer viewer(box.scene);
    EXPECT_TRUE(viewer.framesUntil([&] { return std::filesystem::exists(place.outside("mark")); }));
}

TEST_P(Hostile, NoFileIsWritten)
{
    const std::string victim = Workplace::write(_place.outside("victim"), kPrecious);
    for (const char* trust : {"", "scene"})
        for (const std::string& path : {victim, std::string("../victim"), std::string("victim")})
        {
            const Variable trusted("OSG_MIDAIR_TRUST", trust);
            const auto scene = fromFile([&](HapticScene& s) { s.setDevice(recordTo(path)); });
            const auto viewer = view(*scene);
            EXPECT_TRUE(simulates(*scene)) << scene->getStatistics().device;
            EXPECT_TRUE(says(*scene, "asks for the device \"record:")) << messages(*scene);
            EXPECT_EQ(Workplace::read(victim), kPrecious);
            EXPECT_FALSE(std::filesystem::exists("victim"));
        }
}

TEST_P(Hostile, NoFileIsWrittenByAListOrANestedUri)
{
    const std::string victim = Workplace::write(_place.outside("victim"), kPrecious);
    for (const std::string& uri : {"sim:," + recordTo(victim),
                                   "null:," + recordTo(victim),
                                   "play:" + victim + "?to=" + recordTo(victim),
                                   " " + recordTo(victim),
                                   "RECORD:" + victim})
    {
        const auto scene = fromFile([&](HapticScene& s) { s.setDevice(uri); });
        const auto viewer = view(*scene);
        EXPECT_TRUE(simulates(*scene)) << uri << ": " << scene->getStatistics().device;
        EXPECT_EQ(Workplace::read(victim), kPrecious);
    }
}

TEST_P(Hostile, NoFileIsWrittenFromBelowAnotherScene)
{
    const std::string victim = Workplace::write(_place.outside("victim"), kPrecious);
    const auto inner = fromFile([&](HapticScene& s) { s.setDevice(recordTo(victim)); });
    const osg::ref_ptr<HapticScene> outer = new HapticScene;
    outer->setArray("board");
    outer->addChild(inner);
    const auto viewer = view(*outer);
    EXPECT_EQ(Workplace::read(victim), kPrecious);
    EXPECT_GT(SceneAccess::latestResult(*outer)->points.size(), 0) << "what is inside is felt";
    EXPECT_TRUE(says(*inner, "is inside another HapticScene, which plays it")) << messages(*inner);
}

TEST_P(Hostile, NoFileIsWrittenUnderAViewersDevice)
{
    const std::string victim = Workplace::write(_place.outside("victim"), kPrecious);
    const auto inner = fromFile([&](HapticScene& s) { s.setDevice(recordTo(victim)); });
    HapticSettings settings;
    settings.array = "board";
    settings.device = "null:";
    const osg::ref_ptr<HapticDevice> device = new HapticDevice(settings);
    HeadlessViewer viewer(inner);
    viewer.viewer.addDevice(device);
    EXPECT_TRUE(viewer.framesUntil([&] { return SceneAccess::latestResult(*device) != nullptr; }));
    viewer.frames(20);
    EXPECT_EQ(Workplace::read(victim), kPrecious);
    EXPECT_GT(SceneAccess::latestResult(*device)->points.size(), 0);
    EXPECT_EQ(SceneAccess::latestResult(*inner), nullptr) << "the scene itself plays nothing";
    EXPECT_TRUE(says(*inner, "a viewer's --device")) << messages(*inner);
}

TEST_P(Hostile, NoFileIsWrittenWithOptionsOrWhenDisabled)
{
    const std::string victim = Workplace::write(_place.outside("victim"), kPrecious);
    const auto given =
        fromFile([&](HapticScene& s) { s.setDevice(recordTo(victim)); }, "device=null:");
    const auto viewer = view(*given);
    EXPECT_EQ(given->getStatistics().device.rfind("null:", 0), 0u) << "an option is the user's";
    const auto disabled = fromFile(
        [&](HapticScene& s)
        {
            s.setDevice(recordTo(victim));
            s.setEnabled(false);
        });
    viewBriefly(*disabled);
    EXPECT_EQ(Workplace::read(victim), kPrecious);

    // The same file through the pseudo-loader.
    const CommandLine options("device=null: array=board");
    const osg::ref_ptr<osg::Node> wrapped =
        osgDB::readRefNodeFile(_place.beside(std::string("scene.") + GetParam()) + ".haptic");
    ASSERT_TRUE(wrapped);
    viewBriefly(*wrapped);
    EXPECT_EQ(Workplace::read(victim), kPrecious);
}

TEST_P(Hostile, WhatIsDisabledOpensNothing)
{
    // Set by the program, so granted; disabled all the same.
    const std::string file = _place.outside("fields");
    BoxScene box;
    box.scene->setDevice(recordTo(file));
    box.scene->setEnabled(false);
    viewBriefly(*box.scene);
    EXPECT_FALSE(std::filesystem::exists(file));
    const Variable enabled("OSG_MIDAIR_ENABLED", "false");
    BoxScene again;
    again.scene->setDevice(recordTo(file));
    viewBriefly(*again.scene);
    EXPECT_FALSE(std::filesystem::exists(file));
}

TEST_P(Hostile, NoAbsoluteOrOutsideFileIsRead)
{
    const std::string outside = _place.outside("array.json");
    midair::haptics::TransducerArray::singleBoard().save(outside);
    std::filesystem::create_symlink(outside, _place.beside("link.json"));
    std::filesystem::create_directory_symlink(_place.outside("."), _place.beside("folder"));
    ASSERT_EQ(mkfifo(_place.beside("pipe.json").c_str(), 0600), 0);
    for (const std::string& array : {outside,
                                     std::string("../array.json"),
                                     std::string("link.json"),
                                     std::string("folder/array.json"),
                                     std::string("pipe.json"),
                                     std::string("/dev/zero"),
                                     std::string("../../../../../../dev/zero")})
    {
        const auto scene = fromFile([&](HapticScene& s) { s.setArray(array); });
        const auto viewer = view(*scene);
        EXPECT_EQ(SceneAccess::engine(*scene).array(), nullptr) << array;
        EXPECT_TRUE(says(*scene, "asks for the array \"" + array + "\"")) << messages(*scene);
        EXPECT_TRUE(says(*scene, "nothing is played")) << messages(*scene);
    }
}

TEST_P(Hostile, WhatLiesBesideTheSceneIsRead)
{
    std::filesystem::create_directory(_place.beside("arrays"));
    midair::haptics::TransducerArray::singleBoard().save(_place.beside("arrays/own.json"));
    const auto scene = fromFile([](HapticScene& s) { s.setArray("arrays/own.json"); });
    const auto viewer = view(*scene);
    ASSERT_NE(SceneAccess::engine(*scene).array(), nullptr) << messages(*scene);
    EXPECT_EQ(SceneAccess::engine(*scene).array()->size(), 249);
}

TEST_P(Hostile, RecordingsOfHandsAreReadFromBesideTheSceneAlone)
{
    const std::string hands = "time_s,hand,joint,x,y,z,qx,qy,qz,qw,radius_m,position_valid,"
                              "orientation_valid\n0,1,index_tip,0,0,0.19,0,0,0,1,0.007,1,1\n"
                              "0.1,1,index_tip,0,0,0.19,0,0,0,1,0.007,1,1\n";
    Workplace::write(_place.outside("hands.csv"), hands);
    Workplace::write(_place.beside("hands.csv"), hands);
    std::filesystem::create_symlink(_place.outside("hands.csv"), _place.beside("link.csv"));
    ASSERT_EQ(mkfifo(_place.beside("pipe.csv").c_str(), 0600), 0);
    for (const std::string& file : {_place.outside("hands.csv"),
                                    std::string("../hands.csv"),
                                    std::string("link.csv"),
                                    std::string("pipe.csv"),
                                    std::string("/dev/zero")})
    {
        const auto scene = fromFile([&](HapticScene& s) { s.setHands("recorded:" + file); });
        const auto viewer = view(*scene);
        EXPECT_TRUE(says(*scene, "asks for the hands \"recorded:" + file)) << messages(*scene);
    }
    const auto scene = fromFile([&](HapticScene& s) { s.setHands("recorded:hands.csv?loop"); });
    HeadlessViewer viewer(scene);
    EXPECT_TRUE(viewer.framesUntil([&] { return scene->getStatistics().hands == 1; }))
        << messages(*scene);
}

// What it says of a file that is none of the scene's would tell what is in it.
TEST_P(Hostile, ThermometersAreReadFromBesideTheSceneAlone)
{
    Workplace::write(_place.outside("room.txt"), kPrecious);
    Workplace::write(_place.beside("room.txt"), "20.1\n");
    std::filesystem::create_symlink(_place.outside("room.txt"), _place.beside("link.txt"));
    ASSERT_EQ(mkfifo(_place.beside("pipe").c_str(), 0600), 0);
    for (const char* trust : {"", "scene"})
        for (const std::string& file : {_place.outside("room.txt"),
                                        std::string("../room.txt"),
                                        std::string("link.txt"),
                                        std::string("pipe"),
                                        std::string("/dev/zero")})
        {
            const Variable trusted("OSG_MIDAIR_TRUST", trust);
            const auto scene = fromFile([&](HapticScene& s) { s.setTemperatureSource(file); });
            const auto viewer = view(*scene);
            EXPECT_TRUE(says(*scene, "asks for the thermometer \"" + file)) << messages(*scene);
            EXPECT_FALSE(says(*scene, "thesis")) << messages(*scene);
        }
    const auto scene = fromFile([&](HapticScene& s) { s.setTemperatureSource("room.txt"); });
    HeadlessViewer viewer(scene);
    EXPECT_TRUE(viewer.framesUntil([&] { return scene->getStatistics().temperature_C > 20.05; }))
        << messages(*scene);
}

TEST_P(Hostile, AnEndlessFileOfTheUsersHoldsNoFrameUp)
{
    for (const char* variable : {"OSG_MIDAIR_ARRAY", "OSG_MIDAIR_HANDS"})
    {
        const Variable user(variable,
                            std::string(variable) == "OSG_MIDAIR_ARRAY" ? "/dev/zero"
                                                                        : "recorded:/dev/zero");
        const auto scene = fromFile([](HapticScene&) {});
        const auto viewer = view(*scene);
        EXPECT_TRUE(says(*scene, "should be a regular file")) << messages(*scene);
    }
}

TEST_P(Hostile, ATerminalIsNotSpokenTo)
{
    const auto scene = fromFile(
        [](HapticScene& s)
        {
            s.setName("\x1B[2J\x1B]0;owned\a");
            s.setDevice("usb:\x1B]52;c;aGk=\a" + std::string(5000, 'x'));
        });
    const auto viewer = view(*scene);
    EXPECT_TRUE(says(*scene, "asks for the device"));
    for (const char c : messages(*scene))
        EXPECT_TRUE(c == '\n' || static_cast<unsigned char>(c) >= 0x20) << int(c);
    EXPECT_LT(messages(*scene).size(), 3000u);
}

INSTANTIATE_TEST_SUITE_P(Formats, Hostile, testing::Values("osgt", "osgb", "osgx"));
