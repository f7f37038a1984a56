// What is told, with its code, and that what an application throws stays out of a frame.
#include "tests/plugin/KitTest.h"

#include <osgMidair/HandBodies>
#include <osgMidair/HapticCallback>
#include <osgMidair/HapticDevice>

#include <limits>
#include <stdexcept>

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>
#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

/// Codes and texts of what was told.
std::vector<std::string> toldBy(const HapticStatistics& statistics)
{
    std::vector<std::string> all;
    for (const HapticMessage& message : statistics.told)
        all.push_back(message.code + " | " + message.text);
    return all;
}

/// Runs some frames of \a scene, and returns what was told.
std::vector<std::string> toldIn(HapticScene& scene)
{
    HeadlessViewer viewer(&scene);
    viewer.frames(5);
    EXPECT_EQ(scene.getStatistics().state, ArrayState::CLOSED) << "nothing is played";
    return toldBy(scene.getStatistics());
}

struct ThrowingHands : HandSource
{
    bool getHands(double, std::vector<Hand>&) override { throw 7; }
    std::string getStatus() const override { return "broken"; }
};

struct ThrowingDeviceCallback : DeviceCallback
{
    void changed(const DeviceChange& change) override
    {
        last = change.now;
        throw std::runtime_error("no lamp");
    }
    ArrayState last = ArrayState::CLOSED;
};

struct ThrowingTouch : TouchCallback
{
    void enter(const Touch&) override { throw std::runtime_error("no piano"); }
    void leave(const Touch&) override {}
};

/// A scene's root under a HapticCallback or a HapticDevice.
osg::ref_ptr<osg::Group> plainScene()
{
    osg::ref_ptr<HapticSurface> surface = new HapticSurface(BoxScene::box());
    osg::ref_ptr<osg::MatrixTransform> place =
        new osg::MatrixTransform(osg::Matrixd::translate(0.0, 0.0, 0.15));
    place->addChild(surface);
    osg::ref_ptr<osg::Group> root = new osg::Group;
    root->addChild(place);
    return root;
}

HapticSettings boardSettings()
{
    HapticSettings settings;
    settings.array = "board";
    return settings;
}

} // namespace

TEST(Messages, AWrongUnitOfLengthSilencesAndSaysWhy)
{
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const double infinity = std::numeric_limits<double>::infinity();
    for (const auto& [wrong, text] : {std::pair{nan, "nan"},
                                      std::pair{0.0, "0"},
                                      std::pair{-1.0, "-1"},
                                      std::pair{infinity, "inf"}})
    {
        BoxScene box;
        box.scene->setMetresPerUnit(wrong);
        EXPECT_EQ(toldIn(*box.scene),
                  std::vector<std::string>{std::string("settings.silenced | metresPerUnit is ") +
                                           text + ", should be 1e-09 .. 1e+09; nothing is played"});
    }
    BoxScene box;
    HapticSettings settings = boardSettings();
    std::string error;
    EXPECT_FALSE(settings.set("metresPerUnit", "abc", error));
    box.scene->setSettings(settings);
    const auto told = toldIn(*box.scene);
    ASSERT_EQ(told.size(), 1u);
    EXPECT_EQ(told[0], "settings.silenced | " + error);
    EXPECT_NE(error.find("metresPerUnit is \"abc\""), std::string::npos) << error;
}

TEST(Messages, AWrongCapIsOneSentenceThatDoesNotContradictItself)
{
    BoxScene box;
    box.scene->setMaxAmplitude(1.0000001);
    EXPECT_EQ(toldIn(*box.scene),
              std::vector<std::string>{"settings.silenced | maxAmplitude is 1.0000001, should be "
                                       "0 .. 1; nothing is played"});
}

TEST(Messages, AnArrayThatIsNotGrantedIsOneMessage)
{
    BoxScene box;
    HapticSettings settings;
    settings.array = "/etc/array.json";
    settings.wishes.asked["array"] = settings.array;
    box.scene->setSettings(settings);
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.result() != nullptr; }));
    viewer.frames(2);
    const auto told = box.scene->getStatistics().told;
    ASSERT_EQ(told.size(), 1u) << told[1].text;
    EXPECT_EQ(told[0].code, "array.refused");
    EXPECT_EQ(told[0].severity, HapticMessage::FAULT);
    EXPECT_NE(told[0].text.find("/etc/array.json"), std::string::npos) << "the user's remedy stays";
}

TEST(Messages, ADeviceCallbackThatThrowsIsAMessage)
{
    BoxScene box;
    const osg::ref_ptr<ThrowingDeviceCallback> callback = new ThrowingDeviceCallback;
    box.scene->setDeviceCallback(callback);
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return callback->last == ArrayState::PLAYING; }));
    EXPECT_EQ(
        toldBy(box.scene->getStatistics()),
        std::vector<std::string>{"callback.threw | the device callback has thrown \"no lamp\""});
}

TEST(Messages, ATouchCallbackThatThrowsIsAMessageAtItsNode)
{
    BoxScene box;
    box.surface->setTouchEvents(true);
    box.surface->setTouchCallback(new ThrowingTouch);
    const osg::ref_ptr<InjectedHands> hands = new InjectedHands;
    hands->setHands({openHand(0, osg::Vec3d(0.0, 0.0, 0.16), osg::Quat())});
    box.scene->setHandSource(hands);
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return !box.scene->getStatistics().told.empty(); }));
    const HapticMessage told = box.scene->getStatistics().told[0];
    EXPECT_EQ(told.code, "callback.threw");
    EXPECT_NE(told.path.find("box"), std::string::npos) << told.path;
    EXPECT_EQ(told.text, told.path + ": its touch callback has thrown \"no piano\"");
    viewer.frames(3);
}

TEST(Messages, AnUnknownSolverHasOneCode)
{
    for (const bool isRunning : {false, true})
    {
        BoxScene box;
        HeadlessViewer viewer(box.scene);
        ASSERT_TRUE(!isRunning || viewer.framesUntil([&] { return box.points() > 0; }));
        box.scene->setSolver("nonsense");
        ASSERT_TRUE(viewer.framesUntil([&] { return !box.scene->getStatistics().told.empty(); }));
        const auto told = box.scene->getStatistics().told;
        ASSERT_EQ(told.size(), 1u) << told[1].text;
        EXPECT_EQ(told[0].code, "solver.unknown") << isRunning;
        EXPECT_NE(told[0].text.find("nonsense"), std::string::npos) << told[0].text;
        EXPECT_FALSE(box.result()->playing);
    }
}

TEST(Messages, HandsThatThrowLeaveNoUpdateOfBodies)
{
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
    const osg::ref_ptr<HandSource> source = new ThrowingHands;
    Notices notices;
    const osg::ref_ptr<HandBodies> alone = new HandBodies(world, source.get());
    alone->update(0.0);
    alone->update(0.1);
    EXPECT_EQ(notices.text().find("osgMidair: the hand source of a HandBodies has thrown "), 0U);
    EXPECT_EQ(notices.text().find('\n'), notices.text().size() - 1) << "once";
    BoxScene box;
    box.scene->setHandSource(source);
    const osg::ref_ptr<HandBodies> bodies = new HandBodies(world, box.scene.get());
    bodies->update(0.0);
    ASSERT_EQ(box.scene->getStatistics().told.size(), 1u);
    EXPECT_EQ(box.scene->getStatistics().told[0].code, "hands.threw");
    EXPECT_EQ(bodies->getNumBodies(), 0);
}

TEST(Messages, ACallbacksAndADevicesChangesComeToo)
{
    const osg::ref_ptr<ThrowingDeviceCallback> changes = new ThrowingDeviceCallback;
    {
        const osg::ref_ptr<osg::Group> root = plainScene();
        const osg::ref_ptr<HapticCallback> callback = new HapticCallback(boardSettings());
        callback->setDeviceCallback(changes);
        EXPECT_EQ(callback->getDeviceCallback(), changes.get());
        root->addEventCallback(callback);
        HeadlessViewer viewer(root);
        EXPECT_TRUE(viewer.framesUntil([&] { return changes->last == ArrayState::PLAYING; }));
    }
    changes->last = ArrayState::CLOSED;
    const osg::ref_ptr<HapticDevice> device = new HapticDevice(boardSettings());
    EXPECT_EQ(device->getDeviceCallback(), nullptr);
    HeadlessViewer viewer(plainScene());
    viewer.viewer.addDevice(device);
    viewer.frames(2);
    device->setDeviceCallback(changes); // while it is followed
    EXPECT_TRUE(viewer.framesUntil([&] { return changes->last == ArrayState::PLAYING; }));
    device->setMuted(true);
    EXPECT_TRUE(viewer.framesUntil([&] { return changes->last == ArrayState::MUTED; }));
}

TEST(Messages, ASilentDeviceSaysWhyInBothLists)
{
    const osg::ref_ptr<HapticDevice> device = new HapticDevice;
    const HapticStatistics statistics = device->getStatistics();
    ASSERT_EQ(statistics.told.size(), 1u);
    EXPECT_EQ(statistics.told[0].code, "viewer.silent");
    EXPECT_EQ(statistics.told[0].severity, HapticMessage::FAULT);
    EXPECT_EQ(statistics.messages, std::vector<std::string>{statistics.told[0].text});
}

TEST(Messages, NoAmplitudeIsNoPressureThatIsTooLow)
{
    BoxScene box;
    box.scene->setMaxAmplitude(0.0);
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return !toldBy(box.scene->getStatistics()).empty(); }));
    EXPECT_EQ(toldBy(box.scene->getStatistics()),
              std::vector<std::string>{"field.silenced | silent: the cap of the amplitude is below "
                                       "the array's lowest level: raise MaxAmplitude, which is 0"});
    EXPECT_EQ(box.scene->getStatistics().state, ArrayState::SILENT);
    box.scene->setMaxAmplitude(1.0);
    EXPECT_TRUE(viewer.framesUntil(
        [&] { return box.scene->getStatistics().state == ArrayState::PLAYING; }));
}

TEST(Messages, AnArrayWhoseTransducersAreAllDeadIsToldAndDoesNotPlay)
{
    BoxScene box;
    ArrayDescription dead;
    std::string error;
    ASSERT_TRUE(ArrayDescription::load("board", dead, error)) << error;
    for (unsigned int i = 0; i < dead.transducers.size(); ++i)
        dead.dead.push_back(i);
    box.scene->setArrayDescription(dead);
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.result() != nullptr; }));
    viewer.frames(20);
    const auto told = toldBy(box.scene->getStatistics());
    ASSERT_FALSE(told.empty());
    EXPECT_EQ(told[0],
              "array.dead | all 249 transducers of the array are dead or have the gain 0; it is "
              "silent");
    EXPECT_EQ(box.scene->getStatistics().state, ArrayState::SILENT);
    EXPECT_FALSE(box.scene->getField()->isPlaying());
}

TEST(Messages, ACallbackThatIsNeverCalledSaysSo)
{
    const osg::ref_ptr<HapticCallback> callback = new HapticCallback(boardSettings());
    const osg::ref_ptr<osg::Group> root = plainScene();
    root->addEventCallback(callback);
    osgViewer::Viewer viewer;
    viewer.setUpViewerAsEmbeddedInWindow(0, 0, 64, 64);
    viewer.setSceneData(root);
    for (int frame = 0; frame < 5; ++frame)
    {
        viewer.advance();
        viewer.updateTraversal(); // no events
    }
    ASSERT_EQ(toldBy(callback->getStatistics()).size(), 1U);
    EXPECT_EQ(toldBy(callback->getStatistics()).front().find("viewer.silent | "), 0U);
    viewer.eventTraversal();
    EXPECT_TRUE(toldBy(callback->getStatistics()).empty());
}

TEST(Messages, AGeometryOfAnUnknownKindIsOneMessage)
{
    BoxScene box;
    osg::ref_ptr<osg::Geometry> lines = new osg::Geometry;
    osg::ref_ptr<osg::Vec3Array> corners = new osg::Vec3Array(4);
    lines->setVertexArray(corners);
    lines->addPrimitiveSet(new osg::DrawArrays(GL_LINES_ADJACENCY, 0, 4));
    box.surface->removeChild(0, 1);
    box.surface->addChild(lines);
    HeadlessViewer viewer(box.scene);
    for (int frame = 0; frame < 5; ++frame)
    {
        box.move(1e-3 * frame);
        viewer.frame();
    }
    const auto told = toldBy(box.scene->getStatistics());
    ASSERT_EQ(told.size(), 1u) << told.back();
    EXPECT_NE(told[0].find("primitives of mode 0xa"), std::string::npos) << told[0];
}

TEST(Messages, AStepThatIsNoneIsToldAndNotTaken)
{
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
    BoxScene box;
    const osg::ref_ptr<HandBodies> bodies = new HandBodies(world, box.scene.get(), -1.0);
    HeadlessViewer viewer(box.scene);
    viewer.frames(2);
    ASSERT_EQ(toldBy(box.scene->getStatistics()).size(), 1U);
    const std::string told = toldBy(box.scene->getStatistics()).front();
    EXPECT_EQ(told.find("settings.invalid | "), 0U) << told;
    EXPECT_NE(told.find(" HandBodies is -1 s"), std::string::npos) << told;
}
