#pragma once

#include <osgMidair/HandSource>

#include <osg/Camera>
#include <osg/MatrixTransform>
#include <osg/Node>
#include <osg/Shape>
#include <osg/ShapeDrawable>
#include <osg/Vec3d>
#include <osg/Vec4>
#include <osgText/Text>

#include <array>
#include <optional>
#include <string>

namespace midair::samples
{

/// Colours that colour-blind people can distinguish (Okabe, Ito 2008).
inline const std::array<osg::Vec4, 6> kShownColors = {osg::Vec4(0.34F, 0.71F, 0.91F, 1.0F),
                                                      osg::Vec4(0.90F, 0.62F, 0.00F, 1.0F),
                                                      osg::Vec4(0.00F, 0.62F, 0.45F, 1.0F),
                                                      osg::Vec4(0.84F, 0.37F, 0.00F, 1.0F),
                                                      osg::Vec4(0.80F, 0.47F, 0.65F, 1.0F),
                                                      osg::Vec4(0.94F, 0.89F, 0.26F, 1.0F)};

/// Gives \a node a matt, slightly glossy surface of that colour.
void paint(osg::Node& node, const osg::Vec4& color);

/// Returns \a shape, painted. \a detail: tessellation of curves; 1 is OSG's default.
osg::ref_ptr<osg::ShapeDrawable>
solid(osg::Shape* shape, const osg::Vec4& color, float detail = 0.8F);

/// Returns a visible, non-haptic box around \a centre: a translucent floor and edges.
osg::ref_ptr<osg::Node> glassBox(const osg::Vec3d& centre, const osg::Vec3d& size);

/// Returns the flat hand of a visitor on the screen's side, -y, with the tip of its index finger at
/// \a tip, inclined by \a down_rad with the fingers down. Positions in m.
osgMidair::Hand reachingHand(const osg::Vec3d& tip, double down_rad = 0.0);

/// Like reachingHand(), but only the index finger is stretched; the other fingers are not tracked
/// beyond the knuckles.
osgMidair::Hand pointingHand(const osg::Vec3d& tip, double down_rad = 0.0);

/// Returns \a hand with only the index finger stretched.
osgMidair::Hand pointing(osgMidair::Hand hand);

/// Eases from 0 to 1 while \a t goes from \a from to \a to.
double eased(double t, double from, double to);

/// The sign on top of the screen: invitation and caption at the upper left, mute key and mute state
/// at the upper right.
class VisitorSign
{
public:
    VisitorSign();

    osg::Node* node() const { return _root; }
    /// Call it in each frame. \a width, \a height: size of the viewport, pixels. The letters follow
    /// the height, but are at least 16 pixels high, and a line is never wider than the viewport.
    void update(double width, double height);
    /// Returns the fraction of the height that the sign takes at the top, since the last update().
    float height() const;
    /// Places the sign in the world: \a sheet maps its area, 0 .. 1 to the right and up, to the
    /// world. None: in the viewport. In a headset a sign at the same viewport position for both
    /// eyes would be seen double.
    void standAt(const std::optional<osg::Matrixd>& sheet);
    /// Mirrors the sign, for use with a mirror.
    void turnForMirror() { _side = -1.0; }

    void setInvitation(const std::string& text) { set(*_invitation, text); }
    void setCaption(const std::string& text) { set(*_caption, text); }
    /// \a trouble: what is wrong with the array or why it is muted; may be empty.
    void setState(bool isMuted, const std::string& trouble);

private:
    static void set(osgText::Text& text, const std::string& content);

    double _side = 1.0;     ///< sign of x
    double _units = 1000.0; ///< over the height
    osg::ref_ptr<osg::Group> _root = new osg::Group;
    osg::ref_ptr<osg::Camera> _camera;
    osg::ref_ptr<osg::MatrixTransform> _standing = new osg::MatrixTransform;
    osg::ref_ptr<osgText::Text> _invitation;
    osg::ref_ptr<osgText::Text> _caption;
    osg::ref_ptr<osgText::Text> _mute;
    osg::ref_ptr<osgText::Text> _trouble;
};

} // namespace midair::samples
