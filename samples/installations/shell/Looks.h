#pragma once

#include <osgMidair/HandSource>

#include <osg/Camera>
#include <osg/Node>
#include <osg/Shape>
#include <osg/ShapeDrawable>
#include <osg/Vec3d>
#include <osg/Vec4>
#include <osgText/Text>

#include <array>
#include <string>

namespace midair::samples
{

/// Colours that stay apart for people who see red and green alike, too (Okabe, Ito 2008).
inline const std::array<osg::Vec4, 6> kShownColors = {osg::Vec4(0.34F, 0.71F, 0.91F, 1.0F),
                                                      osg::Vec4(0.90F, 0.62F, 0.00F, 1.0F),
                                                      osg::Vec4(0.00F, 0.62F, 0.45F, 1.0F),
                                                      osg::Vec4(0.84F, 0.37F, 0.00F, 1.0F),
                                                      osg::Vec4(0.80F, 0.47F, 0.65F, 1.0F),
                                                      osg::Vec4(0.94F, 0.89F, 0.26F, 1.0F)};

/// Gives \a node a matt surface of that colour, with a little gloss.
void paint(osg::Node& node, const osg::Vec4& color);

/// Returns \a shape, painted. \a detail: of its curves; 1 is OSG's own.
osg::ref_ptr<osg::ShapeDrawable>
solid(osg::Shape* shape, const osg::Vec4& color, float detail = 0.8F);

/// Returns a box that is only seen: a translucent floor and the edges. It is centred at \a centre.
osg::ref_ptr<osg::Node> glassBox(const osg::Vec3d& centre, const osg::Vec3d& size);

/// Returns the flat hand of a visitor who stands at the screen's side, -y, with the tip of its
/// index finger at \a tip; it is inclined by \a down_rad, fingers down. Positions in m.
osgMidair::Hand reachingHand(const osg::Vec3d& tip, double down_rad = 0.0);

/// The same with the index finger alone stretched: of the other fingers the tracker sees nothing
/// beyond the knuckles.
osgMidair::Hand pointingHand(const osg::Vec3d& tip, double down_rad = 0.0);

/// Returns \a hand as it points: with the index finger alone.
osgMidair::Hand pointing(osgMidair::Hand hand);

/// Goes from 0 to 1 while \a t goes from \a from to \a to, at rest at both ends.
double eased(double t, double from, double to);

/// What is always written on the screen, over all else: at its upper left the invitation and what
/// the installation says, at its upper right the mute key and whether the array is muted.
class VisitorSign
{
public:
    VisitorSign();

    osg::Node* node() const { return _camera; }
    /// To be called in each frame. \a width, \a height: of the viewport, pixels.
    void update(double width, double height);
    /// It is to be read in a mirror.
    void turnForMirror() { _side = -1.0; }

    void setInvitation(const std::string& text) { set(*_invitation, text); }
    void setCaption(const std::string& text) { set(*_caption, text); }
    /// \a trouble: what is wrong with the array, or why it is muted; empty: nothing.
    void setState(bool isMuted, const std::string& trouble);

private:
    static void set(osgText::Text& text, const std::string& content);

    double _side = 1.0; ///< of x
    osg::ref_ptr<osg::Camera> _camera;
    osg::ref_ptr<osgText::Text> _invitation;
    osg::ref_ptr<osgText::Text> _caption;
    osg::ref_ptr<osgText::Text> _mute;
    osg::ref_ptr<osgText::Text> _trouble;
};

} // namespace midair::samples
