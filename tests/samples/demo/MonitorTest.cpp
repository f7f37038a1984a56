// The operator's page of a program with a scene.
#include "samples/shared/monitor/Monitor.h"

#include "samples/shared/monitor/SceneMonitor.h"
#include "samples/shared/views/Offscreen.h"
#include "tests/Eventually.h"
#include "tests/samples/Shell.h"
#include "tests/samples/shared/monitor/Request.h"

#include <osgMidair/HapticScene>
#include <osgMidair/HapticSurface>

#include <osg/ShapeDrawable>
#include <osgDB/Registry>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

using namespace midair::samples;

namespace
{

/// A small scene that is drawn off screen, with its page.
class ScenePage : public testing::Test
{
protected:
    ScenePage()
    {
        _scene->setDevice("sim:");
        osg::ref_ptr<osg::Geometry> triangle = new osg::Geometry;
        osg::ref_ptr<osg::Vec3Array> corners = new osg::Vec3Array;
        for (const auto& [x, z] :
             {std::pair(-0.03F, -0.03F), std::pair(0.03F, -0.03F), std::pair(0.0F, 0.03F)})
            corners->push_back({x, 0.0F, z});
        triangle->setVertexArray(corners);
        osg::ref_ptr<osg::Vec4Array> red = new osg::Vec4Array;
        red->push_back({1.0F, 0.0F, 0.0F, 1.0F});
        triangle->setColorArray(red, osg::Array::BIND_OVERALL);
        triangle->addPrimitiveSet(new osg::DrawArrays(GL_TRIANGLES, 0, 3));
        _scene->addChild(new osgMidair::HapticSurface(triangle));
        std::string problem;
        _isDrawn = setUpOffscreen(_viewer, 640, 400, 30.0, &problem);
        _viewer.setLightingMode(osg::View::NO_LIGHT);
        _viewer.getCamera()->setViewMatrixAsLookAt({0.0, -0.2, 0.0}, {}, osg::Z_AXIS);
        _viewer.getCamera()->setClearColor({0.0F, 0.0F, 1.0F, 1.0F});
        _page.show(*_viewer.getCamera());
        _viewer.setSceneData(_scene);
    }

    void frame()
    {
        _viewer.advance();
        _viewer.eventTraversal();
        _viewer.updateTraversal();
        if (_isDrawn) _viewer.renderingTraversals();
    }
    std::string ask(const std::string& line, const std::string& lines = {}) const
    {
        const RawClient client(_page.getMonitor()->port());
        client.send(requestHead(line, lines));
        return client.receive();
    }
    /// Draws frames while \a ask is answered.
    std::string askWhileDrawing(const std::string& line)
    {
        std::string answer;
        std::atomic<bool> isDone{false};
        std::thread other(
            [&]
            {
                answer = ask(line);
                isDone = true;
            });
        while (!isDone)
            frame();
        other.join();
        return answer;
    }

    osg::ref_ptr<osgMidair::HapticScene> _scene = new osgMidair::HapticScene;
    osgViewer::Viewer _viewer;
    bool _isDrawn = false;
    MonitorOptions _options{":0", "", {}};
    SceneMonitor _page{_options, *_scene, "test"};
};

} // namespace

TEST_F(ScenePage, ShowsWhatIsDrawnAndPlayed)
{
    frame();
    while (_scene->getStatistics().state != osgMidair::ArrayState::PLAYING)
        frame();
    nlohmann::json status;
    ASSERT_TRUE(eventually(
        [&]
        {
            status = nlohmann::json::parse(bodyOf(askWhileDrawing("GET /status.json")));
            return !status.at("array").is_null() && status.at("array").at("state") == "playing" &&
                   !status.at("error").is_null();
        }));
    EXPECT_EQ(status.at("array").at("state"), "playing");
    EXPECT_GT(status.at("fields").at("sent").get<int>(), 0);
    EXPECT_GT(status.at("error").at("points").get<double>(), 0.0);
    EXPECT_EQ(status.at("picture").at("count"), 0) << "nobody has looked";
    if (!_isDrawn) GTEST_SKIP() << "no OpenGL";

    std::string answer;
    for (int i = 0; i < 50 && statusOf(answer) != 200; ++i)
        answer = askWhileDrawing("GET /picture");
    ASSERT_EQ(statusOf(answer), 200) << answer;
    std::istringstream bytes(bodyOf(answer));
    osgDB::ReaderWriter* const jpeg =
        osgDB::Registry::instance()->getReaderWriterForExtension("jpg");
    ASSERT_NE(jpeg, nullptr);
    const osg::ref_ptr<osg::Image> image = jpeg->readImage(bytes).getImage();
    ASSERT_TRUE(image.valid());
    ASSERT_EQ(image->s(), 640);
    ASSERT_EQ(image->t(), 400);
    // The triangle's tip is above, in the middle; the ground is blue.
    const osg::Vec4 middle = image->getColor(320, 190);
    EXPECT_GT(middle.r(), 0.8F);
    EXPECT_LT(middle.b(), 0.2F);
    EXPECT_GT(image->getColor(5, 5).b(), 0.8F);
    EXPECT_GT(image->getColor(240, 330).b(), 0.8F) << "left of the tip";
    EXPECT_GT(image->getColor(240, 130).r(), 0.8F) << "within the foot";
}

TEST_F(ScenePage, PicturesAreTakenAtALowRateAndWhileSomebodyLooksAlone)
{
    if (!_isDrawn) GTEST_SKIP() << "no OpenGL";
    const auto count = [&]
    {
        return nlohmann::json::parse(bodyOf(ask("GET /status.json")))
            .at("picture")
            .at("count")
            .get<int>();
    };
    for (int i = 0; i < 30; ++i)
        frame();
    EXPECT_EQ(count(), 0);
    const auto begin = std::chrono::steady_clock::now();
    for (int i = 0; i < 6; ++i)
        askWhileDrawing("GET /picture");
    const double spent_s =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    EXPECT_GE(count(), 1);
    EXPECT_LE(count(), 2 + static_cast<int>(2.0 * spent_s));
}

TEST_F(ScenePage, AMuteReachesTheArray)
{
    while (_scene->getStatistics().state != osgMidair::ArrayState::PLAYING)
        frame();
    const std::string own = "Authorization: Bearer " + _page.getMonitor()->token() + "\r\n";
    std::vector<double> times_ms;
    for (int i = 0; i < 20; ++i)
    {
        const auto begin = std::chrono::steady_clock::now();
        const std::string answer = ask("POST /mute", own);
        times_ms.push_back(
            std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin)
                .count());
        ASSERT_EQ(statusOf(answer), 200) << answer;
        EXPECT_EQ(nlohmann::json::parse(bodyOf(answer)).at("isConfirmed"), true) << answer;
        EXPECT_EQ(_scene->getStatistics().state, osgMidair::ArrayState::MUTED);
        EXPECT_TRUE(_scene->getMuted());
        EXPECT_EQ(statusOf(ask("POST /unmute", own)), 200);
        EXPECT_FALSE(_scene->getMuted());
    }
    std::sort(times_ms.begin(), times_ms.end());
    // A figure to read; no clock is judged here.
    std::printf("mute over HTTP until the array says that it is muted: median %.2f ms, longest of "
                "20 %.2f ms\n",
                times_ms[10],
                times_ms.back());
}

// It may wait for somebody who is being served, and no frame comes meanwhile.
TEST_F(ScenePage, ItsEndSilencesTheArray)
{
    while (_scene->getStatistics().state != osgMidair::ArrayState::PLAYING)
        frame();
    {
        const SceneMonitor other(_options, *_scene, "other");
    }
    EXPECT_TRUE(
        eventually([&] { return _scene->getStatistics().state == osgMidair::ArrayState::SILENT; }));
}

TEST(Monitor, IsOffUnlessAskedFor)
{
    const osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
    const SceneMonitor monitor(MonitorOptions(), *scene, "test");
    EXPECT_EQ(monitor.getMonitor(), nullptr);
}

TEST(Monitor, AProgramWithoutItsPageEnds)
{
    const osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
    const SceneMonitor monitor({":0", "", {}}, *scene, "test");
    const std::string port = std::to_string(monitor.getMonitor()->port());
    const Outcome taken =
        shell("'" MIDAIR_BIN "/midair-demo' --headless --frames 1 --monitor :" + port);
    EXPECT_EQ(taken.code, 1);
    EXPECT_EQ(taken.output,
              "midair-demo: can't listen on 127.0.0.1:" + port + ": Address already in use\n");
    const Outcome wrong = shell("'" MIDAIR_BIN "/midair-demo' --monitor 2");
    EXPECT_NE(wrong.code, 0);
    EXPECT_NE(wrong.output.find("--monitor: is \"2\", should be ADDRESS:PORT"), std::string::npos)
        << wrong.output;
    const Outcome open = shell("'" MIDAIR_BIN "/midair-demo' --headless --frames 1 --monitor :0 "
                               "--monitor-token-file /etc/passwd");
    EXPECT_EQ(open.code, 1);
    EXPECT_NE(open.output.find("chmod 600 /etc/passwd"), std::string::npos) << open.output;
}
