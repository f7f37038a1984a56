#include "plugin/engine/SceneAccess.h"
#include "tests/plugin/KitTest.h"
#include "tests/plugin/serializers/UnusualScene.h"

#include <osg/Version>
#include <osgDB/ReadFile>
#include <osgDB/Registry>
#include <osgDB/WriteFile>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>
#include <unistd.h>

using namespace osgMidair;
using namespace osgMidair::test;

namespace
{

osgDB::ReaderWriter& readerWriter()
{
    findPlugins();
    return *osgDB::Registry::instance()->getReaderWriterForExtension("osgt");
}

osg::ref_ptr<osgDB::Options> formatOptions(const std::string& extension)
{
    const std::string type = extension == "osgt" ? "Ascii" : extension == "osgx" ? "XML" : "Binary";
    return new osgDB::Options("fileType=" + type);
}

osg::ref_ptr<osg::Node> throughStream(const osg::Node& node, const std::string& extension)
{
    std::stringstream stream(std::ios::in | std::ios::out | std::ios::binary);
    const auto options = formatOptions(extension);
    EXPECT_TRUE(readerWriter().writeNode(node, stream, options).success());
    return readerWriter().readNode(stream, options).takeNode();
}

std::string contents(const std::string& file)
{
    std::ifstream in(file, std::ios::binary);
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
}

class Serialization : public testing::TestWithParam<const char*>
{
};

} // namespace

TEST_P(Serialization, KeepsEveryProperty)
{
    expectUnusual(throughStream(*unusualScene(), GetParam()).get());
}

TEST_P(Serialization, ReadsTheStoredFilesOfVersion1)
{
    findPlugins();
    const std::string file = std::string(MIDAIR_TEST_DATA "/format-v1/scene.") + GetParam();
    // Without what came later.
    expectUnusual(osgDB::readRefNodeFile(file).get(), HapticProperty(), HapticSettings());
}

TEST_P(Serialization, ReadsTheStoredFilesOfVersion2)
{
    findPlugins();
    const std::string file = std::string(MIDAIR_TEST_DATA "/format-v2/scene.") + GetParam();
    // Without what came later.
    HapticSettings settings;
    settings.maxPressure = unusualSettings().maxPressure;
    expectUnusual(osgDB::readRefNodeFile(file).get(), beforeVersion7(), settings);
}

TEST_P(Serialization, ReadsTheStoredFilesOfVersion3)
{
    findPlugins();
    const std::string file = std::string(MIDAIR_TEST_DATA "/format-v3/scene.") + GetParam();
    // Without what came later.
    HapticSettings settings = unusualSettings();
    settings.maxAmplitude = HapticSettings().maxAmplitude;
    settings.even = HapticSettings().even;
    withoutVersion6(settings);
    expectUnusual(osgDB::readRefNodeFile(file).get(), beforeVersion7(), settings);
}

TEST_P(Serialization, ReadsTheStoredFilesOfVersion4)
{
    findPlugins();
    const std::string file = std::string(MIDAIR_TEST_DATA "/format-v4/scene.") + GetParam();
    HapticSettings settings = unusualSettings();
    settings.even = HapticSettings().even;
    withoutVersion6(settings);
    expectUnusual(osgDB::readRefNodeFile(file).get(), beforeVersion7(), settings);
}

TEST_P(Serialization, ReadsTheStoredFilesOfVersion5)
{
    findPlugins();
    const std::string file = std::string(MIDAIR_TEST_DATA "/format-v5/scene.") + GetParam();
    HapticSettings settings = unusualSettings();
    withoutVersion6(settings);
    expectUnusual(osgDB::readRefNodeFile(file).get(), beforeVersion7(), settings);
}

TEST_P(Serialization, ReadsTheStoredFilesOfVersion6)
{
    findPlugins();
    const std::string file = std::string(MIDAIR_TEST_DATA "/format-v6/scene.") + GetParam();
    HapticSettings settings = unusualSettings();
    withoutVersion7(settings);
    expectUnusual(osgDB::readRefNodeFile(file).get(), beforeVersion7(), settings);
}

TEST_P(Serialization, ReadsTheStoredFilesOfVersion7)
{
    findPlugins();
    const std::string file = std::string(MIDAIR_TEST_DATA "/format-v7/scene.") + GetParam();
    HapticSettings settings = unusualSettings();
    withoutVersion8(settings);
    expectUnusual(osgDB::readRefNodeFile(file).get(), unusualProperty(), settings);
}

TEST_P(Serialization, ReadsTheStoredFilesOfVersion8)
{
    findPlugins();
    expectUnusual(
        osgDB::readRefNodeFile(std::string(MIDAIR_TEST_DATA "/format-v8/scene.") + GetParam())
            .get());
}

TEST_P(Serialization, WritesTheStoredFilesOfThisVersionByteForByte)
{
    if (std::string(osgGetVersion()) != "3.6.5")
        GTEST_SKIP() << "they were written by OSG 3.6.5, this is " << osgGetVersion();
    findPlugins();
    const std::filesystem::path folder =
        std::filesystem::temp_directory_path() / ("midair_format" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder);
    const std::string name = std::string("scene.") + GetParam();
    ASSERT_TRUE(osgDB::writeNodeFile(*unusualScene(), (folder / name).string()));
    const std::string written = contents((folder / name).string());
    std::filesystem::remove_all(folder);
    EXPECT_EQ(written,
              contents(MIDAIR_TEST_DATA "/format-v" + std::to_string(HapticScene::formatVersion()) +
                       "/" + name));
}

TEST_P(Serialization, ATagIsKeptOnAnOrdinaryGroup)
{
    osg::ref_ptr<osg::Group> group = new osg::Group;
    group->setUserValue("haptic", std::string("pressure=2; sampling=edges"));
    const auto read = throughStream(*group, GetParam());
    ASSERT_NE(read, nullptr);
    std::string tag;
    EXPECT_TRUE(read->getUserValue("haptic", tag));
    EXPECT_EQ(tag, "pressure=2; sampling=edges");
}

INSTANTIATE_TEST_SUITE_P(Formats,
                         Serialization,
                         testing::Values("osgt", "osgb", "osgx"),
                         [](const auto& info) { return std::string(info.param); });

/// Writes the stored files anew; only for a new format version, into a folder of its own.
TEST(Serialization, WriteStoredFiles)
{
    const char* folder = std::getenv("MIDAIR_WRITE_FORMAT_FILES");
    if (!folder) GTEST_SKIP() << "only with MIDAIR_WRITE_FORMAT_FILES=FOLDER";
    findPlugins();
    for (const char* extension : {"osgt", "osgb", "osgx"})
        EXPECT_TRUE(
            osgDB::writeNodeFile(*unusualScene(), std::string(folder) + "/scene." + extension));
}

TEST(Serialization, AFileOfANewerKitIsReadWithAWarning)
{
    std::stringstream stream("#Ascii Scene\n#Version 161\n#Generator OpenSceneGraph 3.6.5\n"
                             "osgMidair::HapticSurface {\n UniqueID 1\n FormatVersion 99\n"
                             " Pressure 3\n Smell 4\n}\n");
    const Notices notices;
    const osg::ref_ptr<osg::Node> node =
        readerWriter().readNode(stream, formatOptions("osgt")).takeNode();
    auto* surface = dynamic_cast<HapticSurface*>(node.get());
    ASSERT_NE(surface, nullptr);
    EXPECT_EQ(surface->getPressure(), 3.0);
    EXPECT_NE(notices.text().find(
                  "a HapticSurface of format version 99 was written by a newer kit; this one "
                  "knows version 7 and may lose properties"),
              std::string::npos)
        << notices.text();
}

TEST(Serialization, ACopyIsASceneOfItsOwn)
{
    osg::ref_ptr<HapticScene> scene = unusualScene();
    osg::ref_ptr<HapticScene> copy = osg::clone(scene.get(), osg::CopyOp::DEEP_COPY_ALL);
    expectUnusual(copy.get());
    EXPECT_EQ(copy->getNumChildrenRequiringEventTraversal(), 3u) << "itself and two surfaces";
    EXPECT_NE(&SceneAccess::engine(*copy), &SceneAccess::engine(*scene));
}
