#pragma once

#include <osgMidair/HandSource>
#include <osgMidair/MouseHand>

#include <osg/observer_ptr>
#include <osgViewer/View>

#include <string>
#include <vector>

namespace osgMidair
{

/// The hand source "mouse:": a MouseHand in the view that shows the scene. Without a view there is
/// no hand, which is told once. For the update thread only.
class MouseSource : public HandSource
{
public:
    /// Follows the mouse in \a view from now on. \a depthPoint: as MouseHand's, at first; later
    /// calls for the same view and unit leave the hand where it is.
    void attach(osgViewer::View& view, double metresPerUnit, const osg::Vec3d& depthPoint);

    bool getHands(double time, std::vector<Hand>& hands) override;
    std::string getStatus() const override;
    std::vector<std::string> takeMessages() override;

    /// Hands an event of the view on. Returns true if it is handled.
    bool handle(const osgGA::GUIEventAdapter& event, osgGA::GUIActionAdapter& adapter);

private:
    static constexpr int kPatience = 120; ///< frames without a view before that is told

    osg::observer_ptr<osgViewer::View> _view;
    osg::ref_ptr<MouseHand> _mouse;
    double _metresPerUnit = 1.0;
    int _waited = 0;
};

} // namespace osgMidair
