#include "tests/plugin/KitTest.h"

#include <osgMidair/HapticCallback>
#include <osgMidair/HapticDevice>

#include <osg/GraphicsContext>
#include <osgViewer/Viewer>

#include <algorithm>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

/// A buffer off the screen that draws nothing.
class Buffer : public osg::GraphicsContext
{
public:
    Buffer()
    {
        _traits = new Traits;
        _traits->width = _traits->height = 64;
    }
    bool valid() const override { return true; }
    bool realizeImplementation() override { return true; }
    bool isRealizedImplementation() const override { return true; }
    void closeImplementation() override {}
    bool makeCurrentImplementation() override { return true; }
    bool makeContextCurrentImplementation(osg::GraphicsContext*) override { return true; }
    bool releaseContextImplementation() override { return true; }
    void bindPBufferToTextureImplementation(GLenum) override {}
    void swapBuffersImplementation() override {}
};

HapticSettings settingsOfBoard()
{
    HapticSettings settings;
    settings.array = "board";
    return settings;
}

osg::ref_ptr<osg::Node> boxAboveBoard()
{
    osg::ref_ptr<osg::MatrixTransform> at =
        new osg::MatrixTransform(osg::Matrixd::translate(0.0, 0.0, 0.15));
    at->addChild(BoxScene::box());
    return at;
}

/// Runs \a frame until \a done.
bool until(const std::function<void()>& frame, const std::function<bool()>& done)
{
    return eventually(
        [&]
        {
            frame();
            return done();
        });
}

bool says(const HapticDevice& device, const std::string& words)
{
    const auto messages = device.getStatistics().messages;
    return std::find(messages.begin(), messages.end(), words) != messages.end();
}

} // namespace

TEST(Follow, ASceneInALoopWithoutEventTraversalPlays)
{
    BoxScene box;
    HeadlessViewer loop(box.scene);
    const auto frame = [&]
    {
        loop.viewer.advance();
        loop.viewer.updateTraversal();
    };
    EXPECT_TRUE(until(frame, [&] { return box.points() > 0; }));
    loop.viewer.setSceneData(nullptr);
    EXPECT_TRUE(until(frame, [&] { return box.points() == 0; })) << "and is silent when taken out";
}

TEST(Follow, ACallbackAmongUpdateCallbacksPlays)
{
    osg::ref_ptr<HapticCallback> callback = new HapticCallback(settingsOfBoard());
    osg::ref_ptr<osg::Node> root = boxAboveBoard();
    osg::ref_ptr<osg::Group> group = new osg::Group;
    osg::ref_ptr<HapticSurface> surface = new HapticSurface(root);
    group->addChild(surface);
    group->addUpdateCallback(callback);
    HeadlessViewer loop(group);
    EXPECT_TRUE(until(
        [&]
        {
            loop.viewer.advance();
            loop.viewer.updateTraversal();
        },
        [&] { return callback->getStatistics().points > 0; }));
}

TEST(Follow, ADeviceOfAnOffscreenViewerPlays)
{
    osgViewer::Viewer viewer;
    osg::ref_ptr<Buffer> buffer = new Buffer;
    viewer.getCamera()->setGraphicsContext(buffer);
    viewer.getCamera()->setViewport(0, 0, 64, 64);
    viewer.setSceneData(boxAboveBoard());
    osg::ref_ptr<HapticDevice> device = new HapticDevice(settingsOfBoard());
    viewer.addDevice(device);
    EXPECT_TRUE(until(
        [&]
        {
            viewer.advance();
            viewer.eventTraversal();
            viewer.updateTraversal();
        },
        [&] { return device->getStatistics().points > 0; }));
    viewer.getCamera()->setGraphicsContext(nullptr);
}

TEST(Follow, ADeviceThatIsNotAskedSaysWhyItPlaysNothing)
{
    const std::string why =
        "the HapticDevice plays nothing: it is in no view, or the viewer's eventTraversal() is not "
        "called";
    osg::ref_ptr<HapticDevice> device = new HapticDevice(settingsOfBoard());
    HeadlessViewer loop(boxAboveBoard());
    loop.viewer.addDevice(device);
    loop.viewer.advance();
    loop.viewer.updateTraversal();
    EXPECT_TRUE(says(*device, why));
    loop.frame();
    EXPECT_FALSE(says(*device, why));
    const Notices notices;
    device = new HapticDevice(settingsOfBoard());
    device = nullptr;
    EXPECT_NE(notices.text().find("a HapticDevice has played nothing: it is in no view"),
              std::string::npos);
}
