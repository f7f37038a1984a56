#pragma once

#include <osgMidair/HapticOverlays>

#include <osg/Camera>
#include <osg/Group>

namespace midair::samples
{

/// What an installation stands on: a dim disc under it with the soft shadow of all that is lit, and
/// of the hands.
class Ground
{
public:
    /// It lies under what \a lit shows now, and no higher than \a atMost_m, without \a overlays,
    /// which are below \a lit and cast no shadow but for the hands.
    Ground(osg::Group& lit, osgMidair::HapticOverlays& overlays, double atMost_m);

    osg::Node* node() const { return _group; }
    double height_m() const { return _height_m; }

private:
    osg::ref_ptr<osg::Group> _group;
    double _height_m = 0.0;
};

} // namespace midair::samples
