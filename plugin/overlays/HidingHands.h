#pragma once

#include <osgMidair/HandsOverlay>

#include <osg/Camera>
#include <osg/MatrixTransform>
#include <osg/observer_ptr>

#include <utility>
#include <vector>

namespace osgMidair
{

/// Hands of haptic scenes that hide what is behind them, for cameras whose picture is added to what
/// the eye sees: there they are black, with alpha 0, so that one's own are seen. Overlays that show
/// hands are black there, too, but for capsules. All functions belong to the update thread.
class HidingHands
{
public:
    HidingHands();

    /// Has \a camera draw them, if it doesn't yet.
    void drawIn(osg::Camera& camera) const;

    /// Follows the hands of the scenes below \a root; to be called once a frame, after its update.
    void update(osg::Node& root);

private:
    osg::ref_ptr<osg::Group> _group;
    osg::observer_ptr<osg::Node> _root;
    /// What plays each, and its hands.
    std::vector<std::pair<osg::observer_ptr<osg::Node>, osg::ref_ptr<osg::MatrixTransform>>>
        _scenes;
};

} // namespace osgMidair
