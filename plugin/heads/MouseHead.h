#pragma once

#include <osgMidair/HeadSource>

#include <osg/Matrixd>
#include <osg/observer_ptr>
#include <osgGA/GUIEventAdapter>
#include <osgViewer/View>

#include <string>
#include <vector>

namespace osgMidair
{

/// The head source "mouse:", for rehearsals: a head that starts at the camera of the view that
/// shows the scene, and follows the mouse. With the mouse in the window's middle it is at the
/// camera's initial position; at an edge it is kAside_m to that side. Alt with the wheel moves it
/// forward and back. Without a view there is no head, which is logged once. For the update thread
/// only.
class MouseHead : public HeadSource
{
public:
    static constexpr double kAside_m = 0.2;
    static constexpr double kWheelStep_m = 0.01;

    /// Follows the mouse in \a view from now on; later calls for the same view change nothing.
    void attach(osgViewer::View& view, double metresPerUnit);

    bool getHead(double time, Head& head) override;
    bool setHorizon(double /*ahead*/) override { return true; } ///< a mouse is as fast as it gets
    std::string getStatus() const override;
    std::vector<std::string> takeMessages() override;

    /// Handles an event of the view. Returns true if it is handled.
    bool handle(const osgGA::GUIEventAdapter& event);

private:
    static constexpr int kPatience = 120; ///< frames without a view before a warning

    osg::observer_ptr<osgViewer::View> _view;
    osg::Vec3d _begin;      ///< m, world
    osg::Quat _orientation; ///< of the camera at the start
    osg::Vec3d _moved;      ///< m, in the frame of _orientation
    bool _isKnown = false;  ///< a view was found
    int _waited = 0;
};

} // namespace osgMidair
