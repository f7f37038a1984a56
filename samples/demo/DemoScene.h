#pragma once

#include "samples/demo/DemoOptions.h"

#include <osgMidair/HapticOverlays>
#include <osgMidair/HapticScene>

#include <osg/MatrixTransform>

#include <string>

namespace midair::samples
{

/// Returns the pose of the moving object at \a time_s: within 30 mm of the middle, turning about
/// the prism's axis and tilting. Deterministic.
osg::Matrix demoPose(double time_s);

/// Scene of the main sample: the object in its array, with all overlays of the kit.
class DemoScene
{
public:
    /// Throws std::runtime_error if the model can't be read.
    explicit DemoScene(const DemoOptions& options);

    osg::Group* root() { return _root; }
    osgMidair::HapticScene& haptics() { return *_haptics; }
    osgMidair::HapticOverlays& overlays() { return *_overlays; }
    const std::string& name() const { return _name; }

    /// Moves the object to its pose at \a time_s. A scene file with haptic nodes is left unchanged.
    void moveTo(double time_s);

    /// Draws the object opaque, unlit and in \a color, without its edges, so that tests find it in
    /// a picture.
    void paintPlain(const osg::Vec4& color);

    /// View from the open end of the prism, a little off its axis.
    static void lookAt(osg::Vec3d& eye, osg::Vec3d& centre, osg::Vec3d& up);
    static constexpr double kFovy_deg = 25.6;

private:
    void wrap(const DemoOptions& options);
    void applySettings(const DemoOptions& options);

    std::string _name;
    bool _still = false;
    osg::ref_ptr<osg::Group> _root;
    osg::ref_ptr<osgMidair::HapticScene> _haptics;
    osg::ref_ptr<osg::MatrixTransform> _moved;
    osg::ref_ptr<osg::Node> _edges;
    osg::ref_ptr<osgMidair::HapticOverlays> _overlays;
};

} // namespace midair::samples
