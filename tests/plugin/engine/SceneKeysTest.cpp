#include "plugin/engine/SceneKeys.h"

#include "plugin/engine/HapticEngine.h"
#include "tests/plugin/KitTest.h"

#include <osgMidair/FieldSliceOverlay>
#include <osgMidair/HapticCallback>
#include <osgMidair/HapticDevice>
#include <osgMidair/HapticOverlays>

#include <osgDB/ReadFile>

#include <filesystem>
#include <sstream>

#include <gtest/gtest.h>

using namespace osgMidair;
using Keys = osgGA::GUIEventAdapter;

namespace
{

HapticSettings onBoard(const std::string& device = "sim:")
{
    HapticSettings settings;
    settings.array = "board";
    settings.device = device;
    return settings;
}

osg::ref_ptr<osg::Group> boxOverBoard()
{
    osg::ref_ptr<osg::MatrixTransform> at =
        new osg::MatrixTransform(osg::Matrixd::translate(0.0, 0.0, 0.15));
    at->addChild(BoxScene::box());
    osg::ref_ptr<osg::Group> root = new osg::Group;
    root->addChild(at);
    return root;
}

HapticOverlays* overlaysBelow(const osg::Group& root)
{
    for (unsigned int i = 0; i < root.getNumChildren(); ++i)
        if (auto* found = dynamic_cast<HapticOverlays*>(const_cast<osg::Node*>(root.getChild(i))))
            return found;
    return nullptr;
}

void press(HeadlessViewer& viewer, int key)
{
    viewer.viewer.getEventQueue()->keyPress(key);
    viewer.frame();
}

int shown(const HapticOverlays& overlays)
{
    int count = 0;
    for (const char* word : {"points", "slice", "array", "workspace", "figures", "volume", "hands"})
        count += overlays.getOverlay(word)->isShown() ? 1 : 0;
    return count;
}

} // namespace

TEST(SceneKeys, MuteADevice)
{
    const osg::ref_ptr<osg::Group> root = boxOverBoard();
    HeadlessViewer viewer(root);
    const osg::ref_ptr<HapticDevice> device = new HapticDevice(onBoard());
    viewer.viewer.addDevice(device);
    const auto state = [&] { return device->getStatistics().state; };
    ASSERT_TRUE(viewer.framesUntil([&] { return state() == ArrayState::PLAYING; }));
    press(viewer, Keys::KEY_F8);
    EXPECT_TRUE(device->getMuted());
    EXPECT_TRUE(viewer.framesUntil([&] { return state() == ArrayState::MUTED; }));
    ASSERT_NE(overlaysBelow(*root), nullptr) << "which say so";
    EXPECT_EQ(shown(*overlaysBelow(*root)), 0);
    const int points = device->getStatistics().points;
    press(viewer, Keys::KEY_F8);
    EXPECT_FALSE(device->getMuted());
    EXPECT_TRUE(viewer.framesUntil([&] { return state() == ArrayState::PLAYING; }));
    EXPECT_EQ(device->getStatistics().points, points) << "overlays are not felt";
    viewer.viewer.setSceneData(boxOverBoard()); // another scene, so another engine
    device->setMuted(true);
    EXPECT_TRUE(viewer.framesUntil([&] { return state() == ArrayState::MUTED; }));
    press(viewer, Keys::KEY_F8);
    EXPECT_FALSE(device->getMuted()) << "one of the handlers is that of the new engine";
}

TEST(SceneKeys, MuteACallback)
{
    const osg::ref_ptr<osg::Group> root = new osg::Group;
    root->addChild(new HapticSurface(boxOverBoard()));
    const osg::ref_ptr<HapticCallback> callback = new HapticCallback(onBoard());
    root->addEventCallback(callback);
    HeadlessViewer viewer(root);
    const auto state = [&] { return callback->getStatistics().state; };
    ASSERT_TRUE(viewer.framesUntil([&] { return state() == ArrayState::PLAYING; }));
    press(viewer, Keys::KEY_F8);
    EXPECT_TRUE(callback->getMuted());
    EXPECT_TRUE(viewer.framesUntil([&] { return state() == ArrayState::MUTED; }));
}

/// Both have handlers; only the owner that plays the scene takes part.
TEST(SceneKeys, ADeviceThatPlaysAHapticSceneIsMutedOnce)
{
    BoxScene box;
    HeadlessViewer viewer(box.scene);
    const osg::ref_ptr<HapticDevice> device = new HapticDevice(onBoard());
    viewer.viewer.addDevice(device);
    const auto state = [&] { return device->getStatistics().state; };
    ASSERT_TRUE(viewer.framesUntil([&] { return state() == ArrayState::PLAYING; }));
    press(viewer, Keys::KEY_F8);
    EXPECT_TRUE(device->getMuted());
    EXPECT_FALSE(box.scene->getMuted());
    press(viewer, Keys::KEY_F3);
    HapticOverlays* overlays = overlaysBelow(*box.scene);
    ASSERT_NE(overlays, nullptr);
    EXPECT_TRUE(overlays->isShown("slice"));
    EXPECT_EQ(shown(*overlays), 1);
    // The array that is shown is the device's, as the scene's own engine has none.
    EXPECT_TRUE(viewer.framesUntil(
        [&] { return overlays->get<FieldSliceOverlay>()->getNumChildren() > 0; }));
}

TEST(SceneKeys, EachKeyBringsInItsOwnPart)
{
    const std::pair<int, const char*> keys[] = {{Keys::KEY_F2, "points"},
                                                {Keys::KEY_F3, "slice"},
                                                {Keys::KEY_F6, "figures"},
                                                {Keys::KEY_F10, "hands"}};
    for (const auto& [key, word] : keys)
    {
        BoxScene box;
        HeadlessViewer viewer(box.scene);
        viewer.frames(2);
        press(viewer, key);
        HapticOverlays* overlays = overlaysBelow(*box.scene);
        ASSERT_NE(overlays, nullptr);
        EXPECT_TRUE(overlays->getOverlay(word)->isShown()) << word;
        EXPECT_EQ(shown(*overlays), 1) << word;
        press(viewer, key);
        EXPECT_EQ(shown(*overlays), 0) << word;
        press(viewer, Keys::KEY_F7);
        EXPECT_EQ(shown(*overlays), 7);
        EXPECT_EQ(overlaysBelow(*box.scene), overlays) << "there is one";
    }
}

/// Takes frames for itself, as osgviewer's recorder of camera paths does.
class TakesFrames : public osgGA::GUIEventHandler
{
public:
    using osgGA::GUIEventHandler::handle;
    bool handle(const osgGA::GUIEventAdapter& event, osgGA::GUIActionAdapter& /*action*/) override
    {
        return event.getEventType() == osgGA::GUIEventAdapter::FRAME;
    }
};

TEST(SceneKeys, AHandThatFollowsTheMouseIsShownFromTheFirstFramesOn)
{
    ::setenv("OSG_MIDAIR_HANDS", "mouse:", 1);
    BoxScene box;
    HeadlessViewer viewer(box.scene);
    viewer.viewer.addEventHandler(new TakesFrames);
    viewer.frames(3);
    ::unsetenv("OSG_MIDAIR_HANDS");
    HapticOverlays* overlays = overlaysBelow(*box.scene);
    ASSERT_NE(overlays, nullptr);
    EXPECT_TRUE(overlays->isShown("hands"));
    EXPECT_TRUE(overlays->isShown("contacts"));
}

TEST(SceneKeys, MutingWhileADeviceRecordsKeepsTheRecording)
{
    const std::string file = ::testing::TempDir() + "/muted.rec";
    {
        BoxScene box;
        box.scene->setDevice("record:" + file);
        HeadlessViewer viewer(box.scene);
        const auto state = [&] { return box.scene->getStatistics().state; };
        ASSERT_TRUE(viewer.framesUntil([&] { return state() == ArrayState::PLAYING; }));
        press(viewer, Keys::KEY_F8);
        ASSERT_TRUE(viewer.framesUntil([&] { return state() == ArrayState::MUTED; }));
        const auto sent = box.scene->getStatistics().fields.sent;
        EXPECT_GT(sent, 0U);
        press(viewer, Keys::KEY_F8);
        ASSERT_TRUE(viewer.framesUntil([&] { return state() == ArrayState::PLAYING; }));
        EXPECT_GE(box.scene->getStatistics().fields.sent, sent) << "the same device is open";
    }
    EXPECT_GT(std::filesystem::file_size(file), 200U);
}

/// OSG saves event callbacks. A handler that only knows its own overlays must not be among them.
TEST(SceneKeys, WorkAfterASceneWasSavedAndReadAgain)
{
    findPlugins();
    for (const char* type : {"Ascii", "XML", "Binary"})
    {
        osgDB::ReaderWriter* format =
            osgDB::Registry::instance()->getReaderWriterForExtension("osgt");
        const osg::ref_ptr<osgDB::Options> options =
            new osgDB::Options(std::string("fileType=") + type);
        BoxScene box;
        box.scene->addChild(new HapticOverlays);
        std::stringstream stream(std::ios::in | std::ios::out | std::ios::binary);
        {
            HeadlessViewer before(box.scene);
            before.frames(2);
            ASSERT_TRUE(format->writeNode(*box.scene, stream, options).success());
        }
        EXPECT_EQ(stream.str().find("GUIEventHandler"), std::string::npos) << type;
        const osg::ref_ptr<osg::Node> read = format->readNode(stream, options).takeNode();
        const auto scene = dynamic_cast<HapticScene*>(read.get());
        ASSERT_NE(scene, nullptr);
        HeadlessViewer viewer(scene);
        viewer.frames(2);
        press(viewer, Keys::KEY_F3);
        HapticOverlays* overlays = overlaysBelow(*scene);
        ASSERT_NE(overlays, nullptr);
        EXPECT_FALSE(overlays->isShown("slice")) << type;
        EXPECT_TRUE(overlays->isShown("array"));
    }
}
