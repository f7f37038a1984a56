#pragma once

#include <osgMidair/HapticScene>

#include <osgUtil/UpdateVisitor>

#include <chrono>
#include <cstdio>
#include <functional>
#include <string>
#include <thread>

/// Frames without a viewer, for the samples: 60 a second, each with an update traversal, which is
/// what animations wait for, and the scene's update() behind it, which a viewer's scene calls by
/// itself.
class Frames
{
public:
    explicit Frames(osgMidair::HapticScene& scene) : _scene(&scene)
    {
        _traversal->setFrameStamp(_stamp);
    }

    /// Runs frames for \a seconds. \a before is called before each with its simulation time in s.
    void run(double seconds, const std::function<void(double)>& before = {})
    {
        for (const double end_s = _time_s + seconds; _time_s < end_s;)
            frame(before);
    }

    /// Runs frames until a field is played; returns it, null after 20 s, with the messages printed.
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
        std::this_thread::sleep_for(std::chrono::duration<double>(kFrame_s));
        _time_s += kFrame_s;
    }

    osg::ref_ptr<osgMidair::HapticScene> _scene;
    osg::ref_ptr<osg::FrameStamp> _stamp = new osg::FrameStamp;
    osg::ref_ptr<osgUtil::UpdateVisitor> _traversal = new osgUtil::UpdateVisitor;
    double _time_s = 0.0;
};
