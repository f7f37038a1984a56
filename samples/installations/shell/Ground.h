#pragma once

#include <osgMidair/HapticOverlays>

#include <osg/Camera>
#include <osg/Group>

namespace midair::samples
{

/// The ground below an installation: a dim disc with soft shadows of the lit objects and the hands.
class Ground
{
public:
    /// Places the ground below the current content of \a lit, no higher than \a atMost_m.
    /// \a overlays, which are below \a lit, cast no shadow except for the hands.
    Ground(osg::Group& lit, osgMidair::HapticOverlays& overlays, double atMost_m);

    osg::Node* node() const { return _group; }
    double height_m() const { return _height_m; }

private:
    osg::ref_ptr<osg::Group> _group;
    double _height_m = 0.0;
};

} // namespace midair::samples
