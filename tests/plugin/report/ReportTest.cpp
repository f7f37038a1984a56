#include "plugin/report/Report.h"

#include "tests/plugin/KitTest.h"

#include <osgMidair/HapticStatistics>

#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

using namespace osgMidair;

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
