#pragma once

#include <osgMidair/HandSource>
#include <osgMidair/MouseHand>

#include <osg/observer_ptr>
#include <osgViewer/View>

#include <string>
#include <vector>

namespace osgMidair
{

/// The hand source "mouse:": a MouseHand in the view that shows the scene. Before the mouse moves
/// the hand waits at the lower right. Without a view there is no hand, which is told once. For the
/// update thread only.
class MouseSource : public HandSource
{
public:
    /// Follows the mouse in \a view from now on. \a depthPoint: initial value, as for MouseHand;
    /// later calls for the same view and unit don't move the hand.
    void attach(osgViewer::View& view, double metresPerUnit, const osg::Vec3d& depthPoint);

    bool getHands(double time, std::vector<Hand>& hands) override;
    std::string getStatus() const override;
    std::vector<std::string> takeMessages() override;

    /// Returns how far the wheel has moved the hand from its depth point, in the direction of view:
    /// "24 mm behind the middle"; empty: it hasn't.
    std::string depthText() const;

    /// Passes on an event of the view. Returns true if it is handled.
    bool handle(const osgGA::GUIEventAdapter& event, osgGA::GUIActionAdapter& adapter);

private:
    static constexpr int kPatience = 120; ///< frames without a view before a warning

    void waitAside();

    osg::observer_ptr<osgViewer::View> _view;
    osg::ref_ptr<MouseHand> _mouse;
    double _metresPerUnit = 1.0;
    int _waited = 0;
    double _depth_m = 0.0;        ///< by the wheel; > 0: farther from the eye
    bool _isMovedInDepth = false; ///< by the wheel
    bool _isMoved = false;        ///< the mouse, since the source is attached
};

} // namespace osgMidair
