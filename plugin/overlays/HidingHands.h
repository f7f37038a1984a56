#pragma once

#include <osgMidair/HandsOverlay>

#include <osg/Camera>
#include <osg/MatrixTransform>
#include <osg/observer_ptr>

#include <utility>
#include <vector>

namespace osgMidair
{

/// Hands of haptic scenes that hide what is behind them, for cameras whose picture is added to the
/// user's view: they are black with alpha 0 there, so that the user's own hands are seen. Overlays
/// that show hands are black there, too, except capsules. Call all functions on the update thread.
class HidingHands
{
public:
    HidingHands();

    /// Makes \a camera draw them, if it doesn't yet.
    void drawIn(osg::Camera& camera) const;

    /// Follows the hands of the scenes below \a root, which are searched again after kLookAgain_s.
    /// Call it once a frame, after its update, at \a now_s of any clock.
    void update(osg::Node& root, double now_s);
    static constexpr double kLookAgain_s = 1.0;

private:
    void follow(const osg::observer_ptr<osg::Node>& node);

    osg::ref_ptr<osg::Group> _group;
    osg::observer_ptr<osg::Node> _root;
    double _looked_s = 0.0; ///< time of the last search for scenes
    /// The played node of each scene, and its hands.
    std::vector<std::pair<osg::observer_ptr<osg::Node>, osg::ref_ptr<osg::MatrixTransform>>>
        _scenes;
};

} // namespace osgMidair
