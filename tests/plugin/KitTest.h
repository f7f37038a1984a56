#pragma once

#include "engine-bridge/pipeline/HologramResult.h"
#include "haptics/base/threads/SteadyClock.h"
#include "plugin/engine/SceneAccess.h"
#include "plugin/settings/UserOptions.h"
#include "tests/Eventually.h"
#include "tests/TrustedVariables.h"

#include <osgMidair/HapticScene>
#include <osgMidair/HapticSurface>

#include <osg/MatrixTransform>
#include <osg/Notify>
#include <osg/Shape>
#include <osg/ShapeDrawable>
#include <osgDB/Registry>
#include <osgViewer/Viewer>

#include <chrono>
#include <functional>
#include <string>
#include <thread>

#include <gtest/gtest.h>

/// Tests set variables as the user would before the program begins.
inline const bool kTrustsItself = (midair::base::trustVariablesOfProgram(), true);

/// OSG finds the kit's plugins in the build, wherever the tests run.
void findPlugins();

/// Whether one of the messages of \a scene contains \a words.
bool says(const osgMidair::HapticScene& scene, const std::string& words);

/// A viewer without a window: events and updates as osgViewer runs them, nothing drawn.
class HeadlessViewer
{
public:
    explicit HeadlessViewer(osg::Node* scene)
    {
        // A viewer without any window counts as closed; this one never draws.
        viewer.setUpViewerAsEmbeddedInWindow(0, 0, 64, 64);
        viewer.setSceneData(scene);
    }

    void frame()
    {
        viewer.advance();
        viewer.eventTraversal();
        viewer.updateTraversal();
    }

    void frames(int count)
    {
        for (int i = 0; i < count; ++i)
            frame();
    }

    /// Runs frames until \a done.
    bool framesUntil(const std::function<bool()>& done)
    {
        return eventually(
            [&]
            {
                frame();
                return done();
            });
    }
    /// Runs frames for a while, whatever comes of them.
    void framesFor(double seconds)
    {
        const double end_s = midair::base::steadySeconds() + seconds;
        framesUntil([&] { return midair::base::steadySeconds() >= end_s; });
    }

    osgViewer::Viewer viewer;
};

/// What OSG is told to say while this is there. No message puts quotes around quotes; an empty text
/// between them is none of that.
class Notices
{
public:
    Notices() : _before(osg::getNotifyHandler()) { osg::setNotifyHandler(_handler); }
    ~Notices()
    {
        osg::setNotifyHandler(_before);
        EXPECT_FALSE(hasDoubledQuotes(text())) << text();
    }
    Notices(const Notices&) = delete;
    Notices& operator=(const Notices&) = delete;

    const std::string& text() const { return _handler->text; }

private:
    static bool hasDoubledQuotes(const std::string& text)
    {
        const auto isWord = [&](std::size_t at)
        { return at < text.size() && std::isalnum(static_cast<unsigned char>(text[at])) != 0; };
        for (std::size_t at = text.find("\"\""); at != std::string::npos;
             at = text.find("\"\"", at + 1))
            if (isWord(at + 2) || (at > 0 && isWord(at - 1))) return true;
        return false;
    }

    struct Handler : osg::NotifyHandler
    {
        std::string text;
        void notify(osg::NotifySeverity, const char* message) override { text += message; }
    };
    osg::ref_ptr<Handler> _handler = new Handler;
    osg::ref_ptr<osg::NotifyHandler> _before;
};

/// A haptic box of 40 mm somewhere under a scene that drives one simulated board.
struct BoxScene
{
    osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
    osg::ref_ptr<osg::MatrixTransform> transform = new osg::MatrixTransform;
    osg::ref_ptr<osgMidair::HapticSurface> surface = new osgMidair::HapticSurface;

    explicit BoxScene(const osg::Vec3& position = osg::Vec3(0.0f, 0.0f, 0.15f))
    {
        scene->setArray("board");
        scene->setFeelThreshold(1e-6); // a board of simulated sound: no message on that
        surface->setName("box");
        surface->addChild(box());
        transform->addChild(surface);
        transform->setMatrix(osg::Matrixd::translate(position));
        scene->addChild(transform);
    }

    static osg::ref_ptr<osg::Node> box(float size_m = 0.04f)
    {
        return new osg::ShapeDrawable(new osg::Box(osg::Vec3(), size_m));
    }

    void move(double x_m) { transform->setMatrix(osg::Matrixd::translate(x_m, 0.0, 0.15)); }

    std::shared_ptr<const midair::bridge::HologramResult> result() const
    {
        return osgMidair::SceneAccess::latestResult(*scene);
    }
    int points() const { return result() ? result()->points.size() : -1; }
};
