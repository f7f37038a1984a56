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

TEST_P(Serialization, ReadsTheStoredFiles)
{
    findPlugins();
    expectUnusual(
        osgDB::readRefNodeFile(std::string(MIDAIR_TEST_DATA "/format-v1/scene.") + GetParam())
            .get());
}

TEST_P(Serialization, WritesTheStoredFilesByteForByte)
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
    EXPECT_EQ(written, contents(MIDAIR_TEST_DATA "/format-v1/" + name));
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

/// Writes the stored files anew, into a folder of its own; see CONTRIBUTING.md for when.
TEST(Serialization, WriteStoredFiles)
{
    const char* folder = std::getenv("MIDAIR_WRITE_FORMAT_FILES");
    if (!folder) GTEST_SKIP() << "only with MIDAIR_WRITE_FORMAT_FILES=FOLDER";
    findPlugins();
    for (const char* extension : {"osgt", "osgb", "osgx"})
        EXPECT_TRUE(
            osgDB::writeNodeFile(*unusualScene(), std::string(folder) + "/scene." + extension));
}

namespace
{

bool playsNothing(const osg::Node& node)
{
    if (const auto* scene = dynamic_cast<const HapticScene*>(&node))
        return scene->getSettings().isSilenced && !scene->getSettings().whySilenced.empty();
    if (const auto* holder = dynamic_cast<const HapticPropertyHolder*>(&node))
        return !holder->getProperty().whySilenced.empty();
    return dynamic_cast<const HapticOverlays*>(&node) != nullptr; // which play nothing
}

/// What \a node is in a file, with \a version in place of 1.
std::string ofVersion(osg::Node& node, const std::string& extension, int version)
{
    std::stringstream stream(std::ios::in | std::ios::out | std::ios::binary);
    EXPECT_TRUE(readerWriter().writeNode(node, stream, formatOptions(extension)).success());
    std::string text = stream.str();
    const auto replace = [&text](const std::string& old, const std::string& now)
    {
        const std::size_t at = text.find(old);
        ASSERT_NE(at, std::string::npos);
        text.replace(at, old.size(), now);
    };
    const std::string number = std::to_string(version);
    if (extension == "osgt")
        replace("FormatVersion 1 ", "FormatVersion " + number + " ");
    else if (extension == "osgx")
        replace("FormatVersion attribute=\"1\"", "FormatVersion attribute=\"" + number + "\"");
    else if (version >= 0)
        replace(std::string("\1\0MH", 4), {static_cast<char>(version), 0, 'M', 'H'});
    else // as before there was one: other bytes are there
    {
        replace(std::string("\1\0MH", 4), {});
        text += "\1\1\1\1";
    }
    return text;
}

} // namespace

TEST_P(Serialization, NoOtherVersionIsRead)
{
    const std::string extension = GetParam();
    const osg::ref_ptr<osg::Node> nodes[] = {
        new HapticScene, new HapticSurface, new HapticPoints, new HapticOverlays};
    for (const osg::ref_ptr<osg::Node>& node : nodes)
        node->setName("x"); // whose length stands first where there is no version
    for (const osg::ref_ptr<osg::Node>& node : nodes)
        for (const int version : {1, -1, 0, 2, 8, 99})
        {
            std::stringstream stream(ofVersion(*node, extension, version));
            const Notices notices;
            auto result = readerWriter().readNode(stream, formatOptions(extension));
            const std::string told = notices.text() + result.message();
            const std::string said =
                version < 0 && extension == "osgb" ? "none" : std::to_string(version);
            const std::string what = node->className() + (" of version " + said);
            if (version == 1)
            {
                EXPECT_TRUE(result.success()) << what;
                EXPECT_EQ(told, "") << what;
                continue;
            }
            EXPECT_NE(told.find("FormatVersion is \"" + said +
                                "\", should be 1, the only one that this kit reads"),
                      std::string::npos)
                << what << ": " << told;
            if (extension == "osgb")
                EXPECT_FALSE(result.success()) << what;
            else
                EXPECT_TRUE(result.success() && playsNothing(*result.getNode())) << what;
        }
}

TEST(Serialization, ATextWithoutItsVersionIsOfThisOne)
{
    std::stringstream stream("#Ascii Scene\n#Version 161\n#Generator OpenSceneGraph 3.6.5\n"
                             "osgMidair::HapticSurface {\n UniqueID 1\n Pressure 3\n}\n");
    const Notices notices;
    const osg::ref_ptr<osg::Node> node =
        readerWriter().readNode(stream, formatOptions("osgt")).takeNode();
    const auto* surface = dynamic_cast<const HapticSurface*>(node.get());
    ASSERT_NE(surface, nullptr);
    EXPECT_EQ(surface->getPressure(), 3.0);
    EXPECT_FALSE(playsNothing(*surface));
    EXPECT_EQ(notices.text(), "");
}

TEST(Serialization, ACopyIsASceneOfItsOwn)
{
    osg::ref_ptr<HapticScene> scene = unusualScene();
    osg::ref_ptr<HapticScene> copy = osg::clone(scene.get(), osg::CopyOp::DEEP_COPY_ALL);
    expectUnusual(copy.get());
    EXPECT_EQ(copy->getNumChildrenRequiringEventTraversal(), 5u) << "itself and its children";
    EXPECT_NE(&SceneAccess::engine(*copy), &SceneAccess::engine(*scene));
}
