#pragma once

#include "Picture.h"

#include <osgMidair/HapticScene>

#include <osgUtil/UpdateVisitor>

#include <chrono>
#include <cstdio>
#include <functional>
#include <string>
#include <thread>

/// Runs frames without a viewer, for the samples: 60 per second, each with an update traversal for
/// animations and then the scene's update(), which a viewer would call by itself.
class Frames
{
public:
    explicit Frames(osgMidair::HapticScene& scene) : _scene(&scene), _picture(scene)
    {
        _traversal->setFrameStamp(_stamp);
    }

    ~Frames()
    {
        if (_picture.isWanted()) run(0.5); // the field is drawn some frames after it is played
    }

    /// Runs frames for \a seconds. Before each frame \a before is called with the simulation time,
    /// s.
    void run(double seconds, const std::function<void(double)>& before = {})
    {
        for (const double end_s = _time_s + seconds; _time_s < end_s;)
            frame(before);
    }

    /// Runs frames until a field plays and returns it. Prints the messages and returns null after
    /// 20 s.
    osg::ref_ptr<const osgMidair::HapticField>
    untilPlayed(const std::function<void(double)>& before = {})
    {
        for (int i = 0; i < 1200; ++i)
        {
            frame(before);
            osg::ref_ptr<const osgMidair::HapticField> field = _scene->getField();
            if (field && field->isPlaying()) return field;
        }
        for (const std::string& message : _scene->getStatistics().messages)
            std::fprintf(stderr, "%s\n", message.c_str());
        return nullptr;
    }

private:
    static constexpr double kFrame_s = 1.0 / 60.0;

    void frame(const std::function<void(double)>& before)
    {
        if (before) before(_time_s);
        _stamp->setFrameNumber(_stamp->getFrameNumber() + 1);
        _stamp->setSimulationTime(_time_s);
        _traversal->setTraversalNumber(_stamp->getFrameNumber());
        _scene->accept(*_traversal);
        _scene->update(_stamp);
        _picture.draw(*_stamp);
        std::this_thread::sleep_for(std::chrono::duration<double>(kFrame_s));
        _time_s += kFrame_s;
    }

    osg::ref_ptr<osgMidair::HapticScene> _scene;
    osg::ref_ptr<osg::FrameStamp> _stamp = new osg::FrameStamp;
    osg::ref_ptr<osgUtil::UpdateVisitor> _traversal = new osgUtil::UpdateVisitor;
    double _time_s = 0.0;
    Picture _picture;
};
