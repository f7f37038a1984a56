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

/// The view that an eye has of a display in a room: the lit screen, the outlines of the optics, in
/// the last one the picture, and the scene's real objects, the array and the hands. The scene
/// itself is drawn only into the picture on the screen.
class Rehearsal
{
public:
    explicit Rehearsal(const midair::bridge::Display& display);

    /// Draws \a root on the screen. Returns the node that a viewer shows instead.
    osg::Group* show(osg::Node& root);
    /// The camera of the picture on the screen.
    osg::Camera& screen() { return *_screen; }
    /// Sets the picture as seen by \a eye, and sets \a camera up at the eye, looking at the
    /// picture. \a up: of the head.
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
    osg::ref_ptr<osg::Group> _real; ///< array and hands of the scene, drawn a second time
    osg::ref_ptr<osg::Geometry> _seen;
};

} // namespace osgMidair
