#pragma once

#include "engine-bridge/display/Display.h"
#include "engine-bridge/display/Picture.h"

#include <osg/Camera>
#include <osg/Geometry>
#include <osg/Group>
#include <osg/Vec3d>

#include <vector>

namespace osgMidair
{

/// What an eye sees of a display in a room: the lit screen, the optics' outlines, in the last one
/// the picture, and of a scene what is real, the array and the hands. The scene itself is drawn
/// into the picture on the screen alone.
class Rehearsal
{
public:
    explicit Rehearsal(const midair::bridge::Display& display);

    /// Has \a root drawn on the screen. Returns what a viewer shows in its place.
    osg::Group* show(osg::Node& root);
    /// The camera of the picture on the screen.
    osg::Camera& screen() { return *_screen; }
    /// Sets the picture as \a eye sees it, and \a camera up, which stands there and looks at it.
    /// \a up: of the head.
    void update(const midair::bridge::Picture& picture,
                const Eigen::Vector3d& eye,
                const Eigen::Vector3d& up,
                osg::Camera& camera);

private:
    osg::ref_ptr<osg::Node> makeScreen() const;
    osg::ref_ptr<osg::Node> makeOutlines() const;
    void drawSeen(const midair::bridge::Picture& picture, const Eigen::Vector3d& eye);

    const midair::bridge::Display _display;
    osg::ref_ptr<osg::Group> _root;
    osg::ref_ptr<osg::Camera> _screen;
    osg::ref_ptr<osg::Group> _real; ///< array and hands of the scene, drawn once more
    osg::ref_ptr<osg::Geometry> _seen;
};

} // namespace osgMidair
