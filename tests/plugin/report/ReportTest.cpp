#include "plugin/report/Report.h"

#include "tests/plugin/KitTest.h"

#include <osgMidair/HapticStatistics>

#include <osgDB/ReadFile>
#include <osgDB/WriteFile>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

using namespace osgMidair;

namespace
{

/// The file of the environment's report while this is there.
struct ReportOfTest
{
    const std::string path =
        testing::TempDir() + "midair-report-" + std::to_string(::getpid()) + ".json";
    ReportOfTest() { ::setenv("OSG_MIDAIR_REPORT", path.c_str(), 1); }
    ~ReportOfTest()
    {
        ::unsetenv("OSG_MIDAIR_REPORT");
        std::filesystem::remove(path);
    }
    /// Of the last scene that ended.
    nlohmann::json last() const
    {
        std::ifstream in(path);
        const nlohmann::json json = nlohmann::json::parse(in, nullptr, false);
        return json.is_object() && !json["scenes"].empty() ? json["scenes"].back()
                                                           : nlohmann::json();
    }
};

/// Reads a scene of a box, with \a from of its text replaced by \a to.
osg::ref_ptr<HapticScene> fromFile(const std::string& from, const std::string& to)
{
    findPlugins();
    const std::string file =
        testing::TempDir() + "midair-reported-" + std::to_string(::getpid()) + ".osgt";
    BoxScene box;
    box.scene->setMaxPressure(800.0);
    EXPECT_TRUE(osgDB::writeNodeFile(*box.scene, file));
    std::ifstream in(file);
    std::string text{std::istreambuf_iterator<char>(in), {}};
    const std::size_t place = text.find(from);
    if (!from.empty() && place != std::string::npos) text.replace(place, from.size(), to);
    std::ofstream(file) << text;
    osg::ref_ptr<osg::Node> node = osgDB::readRefNodeFile(file);
    std::filesystem::remove(file);
    return dynamic_cast<HapticScene*>(node.get());
}

/// Scenes that something keeps silent, by name.
struct Silenced
{
    const char* name;
    std::function<osg::ref_ptr<HapticScene>()> make;
    const char* reason;
};

std::vector<Silenced> silencedScenes()
{
    const auto plain = [] { return fromFile("", ""); };
    return {
        {"a word in the file",
         [] { return fromFile("MaxPressure 800", "MaxPressure eight"); },
         "eight"},
        {"a name in the file",
         [] { return fromFile("MaxPressure 800", "MaxPresure 800"); },
         "MaxPresure"},
        {"-O",
         [=]
         {
             osgDB::Registry::instance()->setOptions(new osgDB::Options("maxPressure=loud"));
             auto scene = plain();
             osgDB::Registry::instance()->setOptions(nullptr);
             return scene;
         },
         "loud"},
        {"the environment",
         [=]
         {
             ::setenv("OSG_MIDAIR_MAX_PRESSURE", "quiet", 1);
             return plain();
         },
         "quiet"},
        {"the program",
         [=]
         {
             auto scene = plain();
             scene->setMaxPressure(std::numeric_limits<double>::quiet_NaN());
             return scene;
         },
         "nan"},
        {"a calibration that isn't rigid",
         [=]
         {
             auto scene = plain();
             scene->setCalibration(osg::Matrixd::scale(2.0, 1.0, 1.0));
             return scene;
         },
         "calibration is not rigid"},
    };
}

} // namespace

// However it came about, who looks for the reason finds it in the file.
TEST(Report, IsWrittenOfASceneThatIsSilencedWithTheReason)
{
    const ReportOfTest report;
    for (const Silenced& one : silencedScenes())
    {
        std::filesystem::remove(report.path);
        {
            const osg::ref_ptr<HapticScene> scene = one.make();
            ASSERT_NE(scene, nullptr) << one.name;
            HeadlessViewer viewer(scene);
            viewer.frames(3);
        }
        ::unsetenv("OSG_MIDAIR_MAX_PRESSURE");
        const nlohmann::json last = report.last();
        ASSERT_FALSE(last.is_null()) << one.name << ": no report";
        EXPECT_EQ(last["state"], "closed") << one.name;
        EXPECT_EQ(last["counters"]["frames"], 3) << one.name;
        EXPECT_NE(last["messages"].dump().find(one.reason), std::string::npos)
            << one.name << last["messages"];
    }
}

TEST(Report, HoldsControlPointsAndFiguresOfEachObject)
{
    BoxScene box;
    box.surface->setPressure(300.0);
    box.surface->setPressureUnit(HapticProperty::PASCAL);
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    const osg::ref_ptr<const HapticField> field = box.scene->getField();
    const nlohmann::json json = nlohmann::json::parse(
        reportJson(box.scene->getStatistics(), box.scene->getSettings(), field));
    ASSERT_EQ(json["objects"].size(), 1u);
    const nlohmann::json& object = json["objects"][0];
    EXPECT_EQ(object["path"], "HapticScene/MatrixTransform/HapticSurface 'box'");
    ASSERT_EQ(object["points"], field->getPoints().size());
    ASSERT_EQ(object["controlPoints"]["rows"].size(), field->getPoints().size());
    const HapticField::ControlPoint& first = field->getPoints().front();
    const nlohmann::json& row = object["controlPoints"]["rows"][0];
    ASSERT_EQ(object["controlPoints"]["columns"].size(), row.size());
    EXPECT_DOUBLE_EQ(row[2], first.position.z());
    EXPECT_DOUBLE_EQ(row[3], first.wanted_Pa);
    EXPECT_DOUBLE_EQ(row[4], first.achieved_Pa);
    EXPECT_LE(object["lowest_Pa"], object["mean_Pa"]);
    EXPECT_LE(object["mean_Pa"], object["highest_Pa"]);
    EXPECT_GT(object["lowest_Pa"], 0.0);
    EXPECT_TRUE(nlohmann::json::parse(
                    reportJson(box.scene->getStatistics(), box.scene->getSettings()))["objects"]
                    .empty());
}
