// Files of other formats of OSG's that hand over options and set variables: what they say is no
// more the user's than a scene is. And limits that something after them would undo.
#include "plugin/engine/SceneAccess.h"
#include "tests/hostile/Hostile.h"

#include <osgMidair/HapticDevice>

#include <array>
#include <cstdio>
#include <limits>
#include <memory>

using namespace osgMidair;

namespace
{

const std::string kPrecious = "my thesis\n";

std::string slides(const std::string& inside)
{
    return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<presentation>\n" + inside +
           "</presentation>\n";
}

/// Looks at \a file as a user does, in a program of its own; what that says.
std::string
watch(const std::string& before, const std::string& file, const std::string& options = {})
{
    const std::string runtime = MIDAIR_SANITIZER_RUNTIME;
    const std::string preload =
        runtime.empty() ? "" : "ASAN_OPTIONS=detect_leaks=0 LD_PRELOAD=" + runtime + " ";
    const std::string command =
        "env " + before + " OSG_RUN_FRAME_COUNT=100 OSG_LIBRARY_PATH=" MIDAIR_LIBRARY_FOLDER " " +
        preload + "timeout 120 xvfb-run -a osgviewer --window 0 0 320 240 " + file + " " + options +
        " 2>&1";
    std::string output;
    std::array<char, 4096> buffer{};
    const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
    while (pipe && std::fgets(buffer.data(), buffer.size(), pipe.get()))
        output += buffer.data();
    return output;
}

class HostileSlides : public testing::Test
{
protected:
    void SetUp() override
    {
        findPlugins();
        if (!osgDB::Registry::instance()->getReaderWriterForExtension("p3d"))
            GTEST_SKIP() << "OSG's reader of .p3d is not there";
        BoxScene box;
        ASSERT_TRUE(osgDB::writeNodeFile(*box.scene, _place.beside("box.osgt")));
        ASSERT_TRUE(osgDB::writeNodeFile(*BoxScene::box(), _place.beside("plain.osgt")));
    }

    const Workplace _place;
};

/// A scene with options of the command line, in this process.
osg::ref_ptr<HapticScene> withOptions(const std::string& file, const std::string& options)
{
    const CommandLine given(options);
    const osg::ref_ptr<osg::Node> node = osgDB::readRefNodeFile(file);
    return dynamic_cast<HapticScene*>(node.get());
}

} // namespace

TEST_F(HostileSlides, OptionsOfAFileAreNotTheUsers)
{
    const std::string victim = Workplace::write(_place.outside("victim"), kPrecious);
    for (const char* model : {"box.osgt", "plain.osgt.haptic"})
    {
        Workplace::write(_place.beside("evil.p3d"),
                         slides("<slide><layer><model options=\"device=record:" + victim +
                                "?overwrite=yes hands=openxr:?loader=" MIDAIR_EVIL_LOADER
                                " array=board\">" +
                                model + "</model></layer></slide>"));
        const std::string mark = _place.outside("mark");
        const std::string said = watch("MIDAIR_EVIL_MARK=" + mark, _place.beside("evil.p3d"));
        EXPECT_EQ(Workplace::read(victim), kPrecious) << said;
        EXPECT_FALSE(std::filesystem::exists(mark)) << said;
    }
}

TEST_F(HostileSlides, VariablesOfAFileAreNotTheUsers)
{
    const std::string victim = Workplace::write(_place.outside("victim"), kPrecious);
    const std::string report = Workplace::write(_place.outside("report"), kPrecious);
    Workplace::write(
        _place.beside("evil.p3d"),
        slides("<env>OSG_MIDAIR_DEVICE=record:" + victim +
               "?overwrite=yes</env><env>OSG_MIDAIR_HANDS=openxr:?loader=" MIDAIR_EVIL_LOADER
               "</env><env>OSG_MIDAIR_ENABLED=true</env><env>OSG_MIDAIR_TRUST=scene</env>"
               "<env>OSG_MIDAIR_REPORT=" +
               report + "</env><slide><layer><model>box.osgt</model></layer></slide>"));
    const std::string mark = _place.outside("mark");
    for (const std::string& user :
         {std::string(), std::string(" OSG_MIDAIR_ENABLED=false OSG_MIDAIR_HANDS=none")})
    {
        const std::string said =
            watch("MIDAIR_EVIL_MARK=" + mark + user, _place.beside("evil.p3d"));
        EXPECT_EQ(Workplace::read(victim), kPrecious) << said;
        EXPECT_EQ(Workplace::read(report), kPrecious) << said;
        EXPECT_FALSE(std::filesystem::exists(mark)) << said;
    }
}

TEST_F(HostileSlides, TheUsersOwnVariablesAndOptionsCount)
{
    const std::string fields = _place.outside("fields");
    std::string said = watch("OSG_MIDAIR_DEVICE=record:" + fields, _place.beside("box.osgt"));
    EXPECT_TRUE(std::filesystem::exists(fields)) << said;
    std::filesystem::remove(fields);
    said = watch("", _place.beside("box.osgt"), "-O \"device=record:" + fields + "\"");
    EXPECT_TRUE(std::filesystem::exists(fields)) << said;
}

TEST_F(HostileSlides, WhatWasNotUnderstoodIsNotUndoneByWhatFollows)
{
    for (const char* options : {"maxAmplitude=lots enabled=true",
                                "maxPressure=eight enabled=true",
                                "enabled=perhaps enabled=true",
                                "maxAmplitude=30"})
    {
        const auto scene = withOptions(_place.beside("box.osgt"), options);
        ASSERT_TRUE(scene);
        HeadlessViewer viewer(scene);
        viewer.frames(20);
        EXPECT_EQ(SceneAccess::latestResult(*scene), nullptr) << options;
    }
    for (const char* amplitude : {"30", "1.5", "1e9"})
    {
        const Variable enabled("OSG_MIDAIR_ENABLED", "true");
        const Variable cap("OSG_MIDAIR_MAX_AMPLITUDE", amplitude);
        const auto scene = withOptions(_place.beside("box.osgt"), "");
        HeadlessViewer viewer(scene);
        viewer.frames(20);
        EXPECT_EQ(SceneAccess::latestResult(*scene), nullptr) << amplitude;
    }
}

TEST_F(HostileSlides, TheStricterCapOfPressureCounts)
{
    BoxScene box;
    box.scene->setMaxPressure(100.0);
    ASSERT_TRUE(osgDB::writeNodeFile(*box.scene, _place.beside("capped.osgt")));
    for (const char* user : {"500", "0"})
    {
        const Variable cap("OSG_MIDAIR_MAX_PRESSURE", user);
        const auto scene = withOptions(_place.beside("capped.osgt"), "");
        HeadlessViewer viewer(scene);
        EXPECT_TRUE(
            viewer.framesUntil([&] { return SceneAccess::latestResult(*scene) != nullptr; }));
        EXPECT_EQ(SceneAccess::latestResult(*scene)->maxPressure_Pa, 100.0) << user;
    }
}

TEST_F(HostileSlides, AnInnerCapThatIsNoNumberSilences)
{
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const double cap : {nan, 7.0, -1.0})
    {
        const BoxScene inner;
        inner.scene->setMaxAmplitude(cap);
        const osg::ref_ptr<HapticScene> outer = new HapticScene;
        outer->setArray("board");
        outer->addChild(inner.scene);
        HeadlessViewer viewer(outer);
        EXPECT_TRUE(viewer.framesUntil(
            [&]
            {
                return SceneAccess::latestResult(*outer) &&
                       SceneAccess::latestResult(*outer)->points.size() > 0;
            }));
        EXPECT_EQ(SceneAccess::latestResult(*outer)->played().cwiseAbs().maxCoeff(), 0.0f) << cap;
    }
}

// Where the array stands is a matter of safety, as the caps are.
TEST_F(HostileSlides, AUnitOfLengthThatIsNoNumberSilences)
{
    for (const double metres : {std::numeric_limits<double>::quiet_NaN(), 0.0, -1.0, 1e300})
    {
        const BoxScene box;
        HeadlessViewer viewer(box.scene);
        ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
        box.scene->setMetresPerUnit(metres);
        ASSERT_TRUE(viewer.framesUntil([&] { return box.points() == 0; })) << metres;
        EXPECT_EQ(box.scene->getStatistics().state, ArrayState::SILENT) << metres;
        box.scene->setMetresPerUnit(1.0);
        EXPECT_TRUE(viewer.framesUntil([&] { return box.points() > 0; })) << metres;
    }
}

// Without a reach all points would be played, wherever the hand is; without a loudness all of it.
TEST_F(HostileSlides, AReachOrALoudnessThatIsNoNumberSilences)
{
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const bool isReach : {false, true})
    {
        const BoxScene box;
        HeadlessViewer viewer(box.scene);
        ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
        isReach ? box.scene->setReach(nan) : box.scene->setLoudness(nan);
        ASSERT_TRUE(viewer.framesUntil([&] { return box.points() == 0; })) << isReach;
        EXPECT_EQ(box.scene->getStatistics().state, ArrayState::SILENT) << isReach;
    }
}

TEST_F(HostileSlides, NumbersThatAreNoneOpenTheDeviceOnce)
{
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const BoxScene box;
    box.scene->setTemperature(nan);
    box.scene->setLambda(nan);
    box.scene->setDeadline(nan);
    box.scene->setHumidity(nan);
    box.surface->setSpacing(nan);
    HeadlessViewer viewer(box.scene);
    EXPECT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    const auto array = SceneAccess::engine(*box.scene).array();
    const auto snapshots = box.scene->getStatistics().snapshots;
    viewer.frames(50);
    EXPECT_EQ(SceneAccess::engine(*box.scene).array(), array) << "the same pipeline";
    EXPECT_LE(box.scene->getStatistics().snapshots, snapshots + 1);
}
