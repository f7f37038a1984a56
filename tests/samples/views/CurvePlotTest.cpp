#include "samples/views/CurvePlot.h"

#include <osg/Image>
#include <osgDB/ReadFile>

#include <cmath>
#include <filesystem>

#include <gtest/gtest.h>
#include <unistd.h>

using namespace midair::samples;

namespace
{

std::string temporaryPlot(const std::string& name)
{
    return (std::filesystem::temp_directory_path() /
            ("midair_" + std::to_string(::getpid()) + "_" + name))
        .string();
}

CurvePlot sine()
{
    CurvePlot plot;
    plot.title = "A sine";
    plot.caption = "of three periods";
    for (const bool logarithmic : {false, true})
    {
        CurvePanel& panel = plot.panels.emplace_back();
        panel.xName = "time (ms)";
        panel.yName = "radiation pressure (Pa)";
        panel.logarithmic = logarithmic;
        Curve& curve = panel.curves.emplace_back();
        curve.name = "point 0";
        curve.x = Eigen::VectorXd::LinSpaced(30000, 0.0, 300.0);
        curve.y = 40.0 + 30.0 * (curve.x.array() * 0.06).sin();
    }
    return plot;
}

int blue(const osg::Image& image, int column)
{
    int found = 0;
    for (int y = 0; y < image.t(); ++y)
    {
        const osg::Vec4 pixel = image.getColor(column, y);
        found += pixel.b() > pixel.r() + 0.3F ? 1 : 0;
    }
    return found;
}

TEST(CurvePlot, DrawsEachPanelsCurve)
{
    const std::string path = temporaryPlot("curves.png");
    std::string message;
    if (!writeCurvePlot(path, sine(), &message) && message.find("isn't drawn") != std::string::npos)
        GTEST_SKIP() << message;
    EXPECT_EQ(message, "");
    const osg::ref_ptr<osg::Image> image = osgDB::readRefImageFile(path);
    ASSERT_TRUE(image);
    EXPECT_EQ(image->s(), 1040);
    EXPECT_EQ(image->t(), 825);
    int drawn = 0;
    for (int column = 300; column < 1000; column += 10)
        drawn += blue(*image, column) >= 2 ? 1 : 0;
    EXPECT_GT(drawn, 60) << "of 70 columns right of the legend";
    std::filesystem::remove(path);
}

TEST(CurvePlot, WhatCannotBeDrawnIsNamed)
{
    std::string message;
    EXPECT_FALSE(writeCurvePlot(temporaryPlot("none.png"), {}, &message));
    EXPECT_EQ(message, "there are no panels to draw");
    CurvePlot plot = sine();
    plot.panels[0].curves[0].y[7] = NAN;
    EXPECT_FALSE(writeCurvePlot(temporaryPlot("nan.png"), plot, &message));
    EXPECT_EQ(message, "a curve has no points, not as many x as y, or numbers that are not finite");
}

TEST(CurvePlot, TicksAreRoundNumbers)
{
    EXPECT_DOUBLE_EQ(tickStep(1000.0, 10), 100.0);
    EXPECT_DOUBLE_EQ(tickStep(73.0, 6), 20.0);
    EXPECT_DOUBLE_EQ(tickStep(0.5, 10), 0.05);
}

} // namespace
