#include "plugin/overlays/hud/HudRoom.h"

#include "engine-bridge/pipeline/HologramResult.h"
#include "plugin/overlays/OverlayPart.h"
#include "samples/shared/views/Offscreen.h"

#include <osgMidair/HapticOverlays>
#include <osgMidair/Hud>

#include <osgViewer/Viewer>
#include <osgViewer/ViewerEventHandlers>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <numeric>

#include <gtest/gtest.h>

using namespace osgMidair;
namespace bridge = midair::bridge;
namespace samples = midair::samples;

namespace
{

const osg::Vec4 kWhite(1.0F, 1.0F, 1.0F, 1.0F);
const osg::Vec4 kDark(0.05F, 0.06F, 0.08F, 1.0F);

/// A field with all that there is to say of it, and \a messages.
std::shared_ptr<bridge::HologramResult> field(int messages, ArrayState state)
{
    auto result = std::make_shared<bridge::HologramResult>();
    result->frame = 1;
    result->state = state;
    result->deviceStatus = "sim: 3984 transducers, 25 sent, 25 played";
    result->sequence.report.level_Pa = 5294.0;
    result->counters.outOfWorkspace = 12;
    result->counters.skippedUnmoved = 7;
    for (int i = 0; i < messages; ++i)
    {
        const std::string text =
            std::string(1, static_cast<char>('a' + i)) +
            " message that is far too long for one line of a small picture, and has to go on in a "
            "second one at least, or be cut off";
        result->told.emplace_back(midair::base::MessageCode::DEVICE_SLOW, text);
    }
    return result;
}

/// A viewer of the figures alone, off screen.
class FiguresView
{
public:
    FiguresView(int width, int height, const osg::Vec4& background) :
        overlays(new HapticOverlays),
        statistics(new osgViewer::StatsHandler),
        _grabber(new samples::FrameGrabber),
        _last(new samples::FrameGrabber)
    {
        overlays->setShowAll(false);
        overlays->setShown("figures", true);
        overlays->get<Hud>()->setUpdateInterval(0.0);
        able = samples::setUpOffscreen(viewer, width, height, 30.0, &problem);
        if (!able) return;
        viewer.getCamera()->setClearColor(background);
        viewer.getCamera()->setFinalDrawCallback(_grabber);
        viewer.addEventHandler(statistics);
        viewer.setSceneData(overlays);
    }

    void show(const std::shared_ptr<bridge::HologramResult>& result)
    {
        OverlayFeed::of(*overlays).show(result);
        viewer.frame();
    }

    /// A picture without the statistics.
    osg::ref_ptr<osg::Image> picture()
    {
        viewer.frame();
        _grabber->request();
        viewer.frame();
        return _grabber->image();
    }

    /// A picture with the statistics.
    osg::ref_ptr<osg::Image> whole()
    {
        statistics->getCamera()->setFinalDrawCallback(_last);
        viewer.frame();
        _last->request();
        viewer.frame();
        return _last->image();
    }

    osgViewer::Viewer viewer;
    osg::ref_ptr<HapticOverlays> overlays;
    osg::ref_ptr<osgViewer::StatsHandler> statistics;
    bool able = false;
    std::string problem;

private:
    osg::ref_ptr<samples::FrameGrabber> _grabber;
    osg::ref_ptr<samples::FrameGrabber> _last;
};

/// Which pixels of \a image are other than in \a before.
std::vector<bool> changed(const osg::Image& image, const osg::Image& before)
{
    std::vector<bool> found;
    for (int y = 0; y < image.t(); ++y)
        for (int x = 0; x < image.s(); ++x)
        {
            bool differs = false;
            for (int channel = 0; channel < 3; ++channel)
                differs =
                    differs || std::abs(image.data(x, y)[channel] - before.data(x, y)[channel]) > 3;
            found.push_back(differs);
        }
    return found;
}

double share(const std::vector<bool>& pixels)
{
    return static_cast<double>(std::count(pixels.begin(), pixels.end(), true)) /
           static_cast<double>(pixels.size());
}

} // namespace

TEST(HudRoom, UnitsFollowTheSize)
{
    EXPECT_EQ(hudScale(400, 300), 1.0);
    EXPECT_EQ(hudScale(1200, 800), 1.0);
    EXPECT_EQ(hudScale(1920, 1080), 1.5);
    EXPECT_EQ(hudScale(3840, 2160), 3.0);
    EXPECT_EQ(hudScale(1080, 1920), 1.0) << "upright";
    EXPECT_EQ(labelScale(640, 480), 1.0);
    EXPECT_NEAR(labelScale(1200, 800), 800.0 / 560.0, 1e-9);
    EXPECT_NEAR(labelScale(1920, 1080), 1080.0 / 560.0, 1e-9);
    EXPECT_NEAR(labelScale(1080, 1920), 0.75 * 1080.0 / 560.0, 1e-9) << "upright";
}

// As in an installation after F1, whose sign is at the top.
TEST(HudRoom, KeysAndFiguresStandBelowTheProgramsOwnSigns)
{
    const std::pair<int, int> sizes[] = {{400, 300}, {640, 480}, {1200, 800}, {1920, 1080}};
    for (const auto& [width, height] : sizes)
    {
        FiguresView view(width, height, kWhite);
        if (!view.able) GTEST_SKIP() << view.problem;
        constexpr float kSign = 0.2F;
        view.overlays->get<Hud>()->setKeyTime(0.0);
        view.overlays->get<Hud>()->setTopMargin(kSign);
        const osg::ref_ptr<osg::Image> empty = view.picture();
        view.show(field(1, ArrayState::PLAYING));
        view.viewer.getEventQueue()->keyPress(osgGA::GUIEventAdapter::KEY_F1);
        const std::vector<bool> covered = changed(*view.picture(), *empty);
        std::vector<int> rows(static_cast<std::size_t>(height), 0); // from the bottom
        for (std::size_t i = 0; i < covered.size(); ++i)
            rows[i / static_cast<std::size_t>(width)] += covered[i] ? 1 : 0;
        const auto sign = static_cast<std::size_t>(std::lround((1.0F - kSign) * height));
        EXPECT_EQ(std::accumulate(rows.begin() + static_cast<std::ptrdiff_t>(sign), rows.end(), 0),
                  0)
            << width;
        // The keys are at the top of what is left, the figures at the bottom, and nothing between.
        EXPECT_GT(*std::max_element(rows.begin() + static_cast<std::ptrdiff_t>(sign) - 40,
                                    rows.begin() + static_cast<std::ptrdiff_t>(sign)),
                  150)
            << width;
        if (width >= 640)
        {
            EXPECT_GT(rows[30], 150) << width;
            EXPECT_GT(
                std::count(rows.begin() + 30, rows.begin() + static_cast<std::ptrdiff_t>(sign), 0),
                0)
                << width << ": they don't touch";
            EXPECT_LT(share(covered), 1.0 / 3.0) << width;
        }
    }
}

TEST(HudRoom, FiguresLeaveMostOfThePictureAndCanBeReadOnAnyBackground)
{
    const std::pair<int, int> sizes[] = {
        {400, 300}, {420, 300}, {640, 480}, {800, 600}, {1920, 1080}, {3840, 2160}};
    for (const auto& [width, height] : sizes)
        for (const osg::Vec4& background : {kWhite, kDark})
        {
            if (width > 2000 && background == kDark) continue; // takes its time
            FiguresView view(width, height, background);
            if (!view.able) GTEST_SKIP() << view.problem;
            view.overlays->get<Hud>()->setKeyTime(0.0);
            const osg::ref_ptr<osg::Image> empty = view.picture();
            if (width >= 640) view.overlays->get<Hud>()->setKeyTime(1e3);
            view.show(field(6, ArrayState::LOST));
            const osg::ref_ptr<osg::Image> shown = view.picture();
            const std::vector<bool> covered = changed(*shown, *empty);
            const std::string where = std::to_string(width) + " x " + std::to_string(height);
            EXPECT_LT(share(covered), width < 640 ? 0.5 : 1.0 / 3.0) << where;
            EXPECT_GT(share(covered), 0.08) << where;
            int letters = 0;
            int panel = 0;
            for (int y = 0; y < height; ++y)
                for (int x = 0; x < width; ++x)
                {
                    if (!covered[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                                 static_cast<std::size_t>(x)])
                        continue;
                    const unsigned char green = shown->data(x, y)[1];
                    letters += green > 150 ? 1 : 0;
                    panel += green < 75 ? 1 : 0;
                }
            EXPECT_GT(letters, 700) << where;
            EXPECT_GT(panel, 5 * letters) << where << ": letters stand on something dark";
        }
}

TEST(HudRoom, NothingIsDrawnUnderTheViewersStatistics)
{
    const std::pair<int, int> sizes[] = {{400, 300}, {800, 600}, {1280, 720}};
    for (const auto& [width, height] : sizes)
    {
        FiguresView view(width, height, {0.5F, 0.5F, 0.5F, 1.0F});
        if (!view.able) GTEST_SKIP() << view.problem;
        view.overlays->get<Hud>()->setKeyTime(1e3);
        view.show(field(3, ArrayState::LOST));
        view.overlays->setNodeMask(0);
        const osg::ref_ptr<osg::Image> empty = view.picture();
        for (int kind = 1; kind <= 4; ++kind)
        {
            view.viewer.getEventQueue()->keyPress('s');
            view.overlays->setNodeMask(0);
            const std::vector<bool> statistics = changed(*view.whole(), *empty);
            EXPECT_GT(share(statistics), 3e-4) << "the statistics are there";
            view.overlays->setNodeMask(~0U);
            const std::vector<bool> figures = changed(*view.picture(), *empty);
            int both = 0;
            for (std::size_t i = 0; i < figures.size(); ++i)
                both += figures[i] && statistics[i] ? 1 : 0;
            // The large letters stay, even where there is no room for them.
            const bool hasRoom = height > 400 || kind < 3;
            EXPECT_EQ(hasRoom ? both : 0, 0)
                << width << " x " << height << ", s pressed " << kind << " times";
            EXPECT_GT(share(figures), 0.01);
        }
    }
}
