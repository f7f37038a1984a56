#include "samples/shared/views/CurvePlot.h"

#include <osg/Image>
#include <osgDB/ReadFile>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

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
    EXPECT_EQ(drawCurves(path, sine()), "");
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

TEST(CurvePlot, WhatIsThinnedKeepsItsPeaks)
{
    CurvePlot plot = sine();
    plot.panels.pop_back();
    Curve& curve = plot.panels[0].curves[0];
    curve.x = Eigen::VectorXd::LinSpaced(2000000, 0.0, 300.0);
    curve.y = Eigen::VectorXd::Constant(curve.x.size(), 1.0);
    curve.y[1000007] = 40.0;
    const std::string path = temporaryPlot("peak.png");
    EXPECT_EQ(drawCurves(path, plot), "");
    const osg::ref_ptr<osg::Image> image = osgDB::readRefImageFile(path);
    ASSERT_TRUE(image);
    int columns = 0;
    for (int column = 300; column < 1000; ++column)
        columns += blue(*image, column) > 200 ? 1 : 0;
    EXPECT_GE(columns, 1);
    EXPECT_LE(columns, 4);
    std::filesystem::remove(path);
}

TEST(CurvePlot, SaysAllThatItIsToldAsItIs)
{
    CurvePlot plot = sine();
    plot.title = "50 $ & <more> $ of\x01 it";
    plot.panels[0].bands = {{2.0, 3.0, 2.5, "the paper's", false, 1}};
    plot.panels[1].xTicks = {{100.0, "first of all"}};
    plot.panels[1].curves[0].mark = CurveMark::RING;
    const std::string path = temporaryPlot("curves.svg");
    EXPECT_EQ(drawCurves(path, plot), "");
    std::ifstream file(path);
    const std::string text(std::istreambuf_iterator<char>(file), {});
    for (const char* said : {"50 $ &amp; &lt;more&gt; $ of it",
                             "of three periods",
                             "time (ms)",
                             "radiation pressure (Pa)",
                             "point 0",
                             "the paper's",
                             "first of all"})
        EXPECT_NE(text.find(said), std::string::npos) << said;
    std::filesystem::remove(path);
}

TEST(CurvePlot, WhatCannotBeDrawnIsNamed)
{
    EXPECT_EQ(drawCurves("none.png", {}), "none.png isn't drawn: there are no panels to draw");
    CurvePlot plot = sine();
    plot.panels[0].curves[0].y[7] = NAN;
    EXPECT_EQ(drawCurves("nan.png", plot),
              "nan.png isn't drawn: a curve has no points, not as many x as y, or numbers that are "
              "not finite");
    EXPECT_EQ(drawCurves("/nonexistent/sine.png", sine()),
              "/nonexistent/sine.png isn't drawn: No such file or directory");
    const std::string unknown = drawCurves(temporaryPlot("sine.bmp"), sine());
    EXPECT_NE(unknown.find("Format 'bmp' is not supported"), std::string::npos) << unknown;
}

} // namespace
