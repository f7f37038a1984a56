#include "plugin/engine/SceneAccess.h"
#include "tests/plugin/KitTest.h"

#include <osg/Version>
#include <osgDB/ReadFile>
#include <osgDB/Registry>
#include <osgDB/WriteFile>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>
#include <unistd.h>

using namespace osgMidair;

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

HapticProperty unusualProperty()
{
    HapticProperty p;
    p.enabled = false;
    p.pressure = 812.5;
    p.pressureUnit = HapticProperty::PASCAL;
    p.spacing = 0.0125;
    p.sampling = HapticProperty::EDGES;
    p.side = HapticProperty::BACK;
    p.priority = -7;
    p.modulationFrequency = 200.5;
    p.modulationDepth = 0.25;
    p.intensity = HapticProperty::TEXTURE;
    p.touchEvents = true;
    p.intensityChannel = HapticProperty::BLUE;
    p.intensityLow = 0.125;
    p.intensityHigh = 0.875;
    p.render = HapticProperty::AUTO;
    p.material = "cloth";
    p.stiffness = 37.5;
    p.contactForce = 0.015625;
    p.softness = 0.25;
    p.roughness = 0.375;
    p.texturePeriod = 0.0078125;
    p.lowVibration = 0.125;
    p.highVibration = 0.0625;
    return p;
}

HapticSettings unusualSettings()
{
    HapticSettings s;
    s.enabled = false;
    s.array = "my arrays/board \"two\".json";
    s.device = "record:out.bin";
    s.calibration = osg::Matrixd::rotate(0.5, osg::Vec3d(1.0, 0.0, 0.0)) *
                    osg::Matrixd::translate(0.125, -0.25, 1.0 / 3.0);
    s.metresPerUnit = 0.001;
    s.temperature = 14.5;
    s.humidity = 0.25;
    s.airPressure = 95000.0;
    s.solver = "gs";
    s.maxIterations = 17;
    s.rmsTolerance = 0.0078125;
    s.deadline_ms = 2.5;
    s.lambda = 0.5;
    s.loudness = 0.75;
    s.phaseOnly = false;
    s.threads = 2;
    s.motionTolerance = 0.0625;
    s.maxPoints = 321;
    s.hands = "recorded:hand.csv?loop";
    s.reach = 0.0625;
    s.shadows = true;
    s.maxPressure = 1250.5;
    s.maxAmplitude = 0.375;
    s.cycle = 8;
    s.cycleSteps = 3;
    s.subsets = 2;
    s.fieldRate = 500.0;
    s.denseOutlines = false;
    s.monitorInterval = 0.25;
    s.even = 40;
    s.earLimit = 117.5;
    s.earPoints = "0 0 0.5; -0.25 0.125 0.5";
    s.earCamera = true;
    s.prediction = HapticSettings::KALMAN;
    s.trackerDelay = 0.03125;
    s.render = HapticSettings::CONTACT;
    s.contactRate = 7.5;
    s.contactStep = 0.00025;
    s.contactFoci = 3;
    s.contactMask = true;
    s.trackerError = 0.0078125;
    return s;
}

osg::ref_ptr<HapticScene> unusualScene()
{
    osg::ref_ptr<HapticScene> scene = new HapticScene;
    scene->setSettings(unusualSettings());
    scene->setName("unusual");
    osg::ref_ptr<HapticSurface> surface = new HapticSurface(BoxScene::box().get());
    surface->setProperty(unusualProperty());
    scene->addChild(surface);
    osg::ref_ptr<HapticSurface> ordinary = new HapticSurface;
    scene->addChild(ordinary);
    return scene;
}

/// Text formats write six digits.
void expectNear(double a, double b)
{
    EXPECT_NEAR(a, b, 2e-6 * std::max(1.0, std::abs(b)));
}

void expectUnusual(const HapticProperty& p)
{
    const HapticProperty wanted = unusualProperty();
    EXPECT_EQ(p.enabled, wanted.enabled);
    expectNear(p.pressure, wanted.pressure);
    EXPECT_EQ(p.pressureUnit, wanted.pressureUnit);
    expectNear(p.spacing, wanted.spacing);
    EXPECT_EQ(p.sampling, wanted.sampling);
    EXPECT_EQ(p.side, wanted.side);
    EXPECT_EQ(p.priority, wanted.priority);
    expectNear(p.modulationFrequency, wanted.modulationFrequency);
    expectNear(p.modulationDepth, wanted.modulationDepth);
    EXPECT_EQ(p.intensity, wanted.intensity);
    EXPECT_EQ(p.touchEvents, wanted.touchEvents);
}

/// What versions 2 and 7 of HapticSurface brought.
void expectUnusualPaint(const HapticProperty& p, const HapticProperty& wanted)
{
    EXPECT_EQ(p.intensityChannel, wanted.intensityChannel);
    expectNear(p.intensityLow, wanted.intensityLow);
    expectNear(p.intensityHigh, wanted.intensityHigh);
    EXPECT_EQ(p.render, wanted.render);
    EXPECT_EQ(p.material, wanted.material);
    expectNear(p.stiffness, wanted.stiffness);
    expectNear(p.contactForce, wanted.contactForce);
    expectNear(p.softness, wanted.softness);
    expectNear(p.roughness, wanted.roughness);
    expectNear(p.texturePeriod, wanted.texturePeriod);
    expectNear(p.lowVibration, wanted.lowVibration);
    expectNear(p.highVibration, wanted.highVibration);
}

/// The properties that files before version 7 have.
HapticProperty beforeVersion7()
{
    HapticProperty p = unusualProperty();
    const HapticProperty plain;
    p.render = plain.render;
    p.material = plain.material;
    p.stiffness = p.contactForce = p.softness = p.roughness = p.texturePeriod = 0.0;
    p.lowVibration = p.highVibration = 0.0;
    return p;
}

void expectUnusual(const HapticSettings& s)
{
    const HapticSettings wanted = unusualSettings();
    EXPECT_EQ(s.enabled, wanted.enabled);
    EXPECT_EQ(s.array, wanted.array);
    EXPECT_EQ(s.device, wanted.device);
    for (int i = 0; i < 16; ++i)
        expectNear(s.calibration.ptr()[i], wanted.calibration.ptr()[i]);
    expectNear(s.metresPerUnit, wanted.metresPerUnit);
    expectNear(s.temperature, wanted.temperature);
    expectNear(s.humidity, wanted.humidity);
    expectNear(s.airPressure, wanted.airPressure);
    EXPECT_EQ(s.solver, wanted.solver);
    EXPECT_EQ(s.maxIterations, wanted.maxIterations);
    expectNear(s.rmsTolerance, wanted.rmsTolerance);
    expectNear(s.deadline_ms, wanted.deadline_ms);
    expectNear(s.lambda, wanted.lambda);
    expectNear(s.loudness, wanted.loudness);
    EXPECT_EQ(s.phaseOnly, wanted.phaseOnly);
    EXPECT_EQ(s.threads, wanted.threads);
    expectNear(s.motionTolerance, wanted.motionTolerance);
    EXPECT_EQ(s.maxPoints, wanted.maxPoints);
    EXPECT_EQ(s.hands, wanted.hands);
    expectNear(s.reach, wanted.reach);
    EXPECT_EQ(s.shadows, wanted.shadows);
}

/// What version 7 of HapticScene brought.
void withoutVersion7(HapticSettings& s)
{
    const HapticSettings plain;
    s.render = plain.render;
    s.contactRate = plain.contactRate;
    s.contactStep = plain.contactStep;
    s.contactFoci = plain.contactFoci;
    s.contactMask = plain.contactMask;
    s.trackerError = plain.trackerError;
}

/// What versions 6 and 7 of HapticScene brought.
void withoutVersion6(HapticSettings& s)
{
    withoutVersion7(s);
    s.earLimit = HapticSettings().earLimit;
    s.earPoints.clear();
    s.earCamera = false;
    s.prediction = HapticSettings().prediction;
    s.trackerDelay = HapticSettings().trackerDelay;
}

/// What versions 2 to 7 of HapticScene brought.
void expectUnusualTurns(const HapticSettings& s, const HapticSettings& wanted)
{
    expectNear(s.maxPressure, wanted.maxPressure);
    EXPECT_EQ(s.cycle, wanted.cycle);
    EXPECT_EQ(s.cycleSteps, wanted.cycleSteps);
    EXPECT_EQ(s.subsets, wanted.subsets);
    expectNear(s.fieldRate, wanted.fieldRate);
    EXPECT_EQ(s.denseOutlines, wanted.denseOutlines);
    expectNear(s.monitorInterval, wanted.monitorInterval);
    expectNear(s.maxAmplitude, wanted.maxAmplitude);
    EXPECT_EQ(s.even, wanted.even);
    expectNear(s.earLimit, wanted.earLimit);
    EXPECT_EQ(s.earPoints, wanted.earPoints);
    EXPECT_EQ(s.earCamera, wanted.earCamera);
    EXPECT_EQ(s.prediction, wanted.prediction);
    expectNear(s.trackerDelay, wanted.trackerDelay);
    EXPECT_EQ(s.render, wanted.render);
    expectNear(s.contactRate, wanted.contactRate);
    expectNear(s.contactStep, wanted.contactStep);
    EXPECT_EQ(s.contactFoci, wanted.contactFoci);
    EXPECT_EQ(s.contactMask, wanted.contactMask);
    expectNear(s.trackerError, wanted.trackerError);
}

void expectUnusual(osg::Node* node,
                   const HapticProperty& paint = unusualProperty(),
                   const HapticSettings& later = unusualSettings())
{
    auto* scene = dynamic_cast<HapticScene*>(node);
    ASSERT_NE(scene, nullptr);
    EXPECT_EQ(scene->getName(), "unusual");
    expectUnusual(scene->getSettings());
    expectUnusualTurns(scene->getSettings(), later);
    ASSERT_EQ(scene->getNumChildren(), 2u);
    auto* surface = dynamic_cast<HapticSurface*>(scene->getChild(0));
    ASSERT_NE(surface, nullptr);
    expectUnusual(surface->getProperty());
    expectUnusualPaint(surface->getProperty(), paint);
    EXPECT_EQ(surface->getNumChildren(), 1u);
    auto* ordinary = dynamic_cast<HapticSurface*>(scene->getChild(1));
    ASSERT_NE(ordinary, nullptr);
    EXPECT_TRUE(ordinary->getProperty() == HapticProperty());
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
    expectUnusual(
        osgDB::readRefNodeFile(std::string(MIDAIR_TEST_DATA "/format-v7/scene.") + GetParam())
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
