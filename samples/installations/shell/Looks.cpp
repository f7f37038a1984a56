#include "samples/installations/shell/Looks.h"

#include "samples/shared/views/ShownObject.h"

#include <osgMidair/Overlay>

#include <osg/BlendFunc>
#include <osg/Depth>
#include <osg/Geometry>
#include <osg/Group>
#include <osg/LineWidth>
#include <osg/Material>

#include <algorithm>

namespace midair::samples
{

namespace
{

osg::ref_ptr<osg::Geometry>
plainGeometry(osg::Vec3Array* vertices, GLenum mode, const osg::Vec4& color)
{
    osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
    geometry->setVertexArray(vertices);
    geometry->setColorArray(new osg::Vec4Array(1, &color), osg::Array::BIND_OVERALL);
    geometry->addPrimitiveSet(new osg::DrawArrays(mode, 0, static_cast<GLsizei>(vertices->size())));
    osg::StateSet* state = geometry->getOrCreateStateSet();
    state->setMode(GL_LIGHTING, osg::StateAttribute::OFF);
    state->setMode(GL_CULL_FACE, osg::StateAttribute::OFF);
    state->setAttributeAndModes(new osg::BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA));
    state->setAttributeAndModes(new osg::Depth(osg::Depth::LEQUAL, 0.0, 1.0, false));
    state->setRenderingHint(osg::StateSet::TRANSPARENT_BIN);
    return geometry;
}

// Joints in the order of OpenXR, from the one behind the knuckle.
constexpr int kThumbProximal = 3;
constexpr int kThumbTip = 5;
constexpr int kMiddleIntermediate = 13;
constexpr int kLittleTip = 25;
constexpr int kFinger = 5; ///< joints per finger

// Lengths in units: thousandths of the screen's height, more of them on a small screen, which has
// larger letters than that.
constexpr double kSheet = 4.0 / 3.0; ///< aspect ratio of the sheet in a headset
constexpr double kHeight = 1000.0;   ///< units of a large screen
constexpr float kMargin = 30.0F;
constexpr float kSize = 34.0F;
constexpr float kSmall = 26.0F;
constexpr double kLeastSmall = 16.0; ///< pixels
constexpr float kBelowKeys = 45.0F;  ///< keeps clear of the mute
constexpr float kLine = 1.5F;        ///< distance of lines, in heights of their letters

const osg::Vec4 kSaid(0.90F, 0.92F, 0.96F, 1.0F);
const osg::Vec4 kQuiet(0.62F, 0.66F, 0.72F, 1.0F);
const osg::Vec4 kAlarm(1.0F, 0.42F, 0.30F, 1.0F);

osg::ref_ptr<osgText::Text>
signText(float size, osgText::TextBase::AlignmentType alignment, const osg::Vec4& color)
{
    osg::ref_ptr<osgText::Text> made = new osgText::Text;
    made->setDataVariance(osg::Object::DYNAMIC);
    made->setFont(labelFont());
    made->setFontResolution(48, 48);
    made->setCharacterSize(size);
    made->setAlignment(alignment);
    made->setColor(color);
    // Keeps the text readable in front of hands.
    made->setBackdropType(osgText::Text::OUTLINE);
    made->setBackdropColor({0.03F, 0.04F, 0.05F, 1.0F});
    return made;
}

} // namespace

void paint(osg::Node& node, const osg::Vec4& color)
{
    osg::ref_ptr<osg::Material> material = new osg::Material;
    material->setDiffuse(osg::Material::FRONT_AND_BACK, color);
    material->setAmbient(osg::Material::FRONT_AND_BACK, color);
    material->setSpecular(osg::Material::FRONT_AND_BACK, {0.25F, 0.25F, 0.25F, 1.0F});
    material->setShininess(osg::Material::FRONT_AND_BACK, 32.0F);
    node.getOrCreateStateSet()->setAttributeAndModes(
        material, osg::StateAttribute::ON | osg::StateAttribute::OVERRIDE);
}

osg::ref_ptr<osg::ShapeDrawable> solid(osg::Shape* shape, const osg::Vec4& color, float detail)
{
    osg::ref_ptr<osg::TessellationHints> hints = new osg::TessellationHints;
    hints->setDetailRatio(detail);
    osg::ref_ptr<osg::ShapeDrawable> drawable = new osg::ShapeDrawable(shape, hints);
    paint(*drawable, color);
    return drawable;
}

osg::ref_ptr<osg::Node> glassBox(const osg::Vec3d& centre, const osg::Vec3d& size)
{
    const osg::Vec3 low(centre - size * 0.5);
    const osg::Vec3 high(centre + size * 0.5);
    const auto corner = [&](int i)
    {
        return osg::Vec3(
            i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(), i & 4 ? high.z() : low.z());
    };
    osg::ref_ptr<osg::Vec3Array> edges = new osg::Vec3Array;
    for (int i = 0; i < 8; ++i)
        for (const int axis : {1, 2, 4})
            if (!(i & axis))
            {
                edges->push_back(corner(i));
                edges->push_back(corner(i | axis));
            }
    osg::ref_ptr<osg::Vec3Array> floor = new osg::Vec3Array;
    for (const int i : {0, 1, 3, 2})
        floor->push_back(corner(i));
    osg::ref_ptr<osg::Group> group = new osg::Group;
    group->addChild(plainGeometry(floor, GL_QUADS, {0.45F, 0.55F, 0.70F, 0.30F}));
    const osg::ref_ptr<osg::Geometry> lines =
        plainGeometry(edges, GL_LINES, {0.70F, 0.78F, 0.90F, 0.55F});
    lines->getOrCreateStateSet()->setAttributeAndModes(new osg::LineWidth(2.0F));
    group->addChild(lines);
    return group;
}

osgMidair::Hand reachingHand(const osg::Vec3d& tip, double down_rad)
{
    return osgMidair::openHand(1, tip, osg::Quat(osg::PI_2 - down_rad, osg::X_AXIS));
}

osgMidair::Hand pointingHand(const osg::Vec3d& tip, double down_rad)
{
    return pointing(reachingHand(tip, down_rad));
}

osgMidair::Hand pointing(osgMidair::Hand hand)
{
    const auto hide = [&](int joint)
    { hand.joints[static_cast<std::size_t>(joint)].positionValid = false; };
    for (int joint = kThumbProximal; joint <= kThumbTip; ++joint)
        hide(joint);
    for (int first = kMiddleIntermediate; first <= kLittleTip; first += kFinger)
        for (int joint = first; joint < first + 3; ++joint)
            hide(joint);
    return hand;
}

double eased(double t, double from, double to)
{
    const double s = std::clamp((t - from) / (to - from), 0.0, 1.0);
    return s * s * (3.0 - 2.0 * s);
}

VisitorSign::VisitorSign() :
    _camera(new osg::Camera),
    _invitation(signText(kSize, osgText::TextBase::LEFT_TOP, kSaid)),
    _caption(signText(kSmall, osgText::TextBase::LEFT_TOP, kQuiet)),
    _mute(signText(kSmall, osgText::TextBase::RIGHT_TOP, kQuiet)),
    _trouble(signText(kSmall, osgText::TextBase::RIGHT_TOP, kAlarm))
{
    _camera->setReferenceFrame(osg::Transform::ABSOLUTE_RF);
    _camera->setRenderOrder(osg::Camera::POST_RENDER);
    _camera->setClearMask(0);
    _camera->setAllowEventFocus(false);
    _camera->setViewMatrix(osg::Matrix::identity());
    osg::StateSet* state = _camera->getOrCreateStateSet();
    state->setMode(GL_LIGHTING, osg::StateAttribute::OFF);
    state->setMode(GL_DEPTH_TEST, osg::StateAttribute::OFF);
    state->setRenderBinDetails(osgMidair::HUD_BIN + 1, "RenderBin");
    for (const auto& text : {_invitation, _caption, _mute, _trouble})
    {
        _camera->addChild(text);
        _standing->addChild(text);
    }
    _standing->setStateSet(state);
    _standing->setCullingActive(false);
    _standing->setNodeMask(0U);
    _root->addChild(_camera);
    _root->addChild(_standing);
    setState(false, {});
    update(1.5, 1.0);
}

void VisitorSign::standAt(const std::optional<osg::Matrixd>& sheet)
{
    _camera->setNodeMask(sheet ? 0U : ~0U);
    _standing->setNodeMask(sheet ? ~0U : 0U);
    if (!sheet) return;
    update(kSheet, 1.0);
    _standing->setMatrix(osg::Matrix::scale(1.0 / (kSheet * _units), 1.0 / _units, 1.0) * *sheet);
}

void VisitorSign::update(double width, double height)
{
    if (!(width > 0.0) || !(height > 0.0)) return;
    const bool isStanding = _standing->getNodeMask() != 0U;
    if (isStanding) width = kSheet * height;
    _units = isStanding ? kHeight : std::min(kHeight, height * kSmall / kLeastSmall);
    // No line is wider than the screen.
    for (const osgText::Text* text : {_invitation.get(), _caption.get(), _trouble.get()})
        if (const osg::BoundingBox& box = text->getBoundingBox(); box.valid())
            _units = std::max(_units, (box.xMax() - box.xMin() + 2.0 * kMargin) * height / width);
    const double across = _units * width / height;
    _camera->setProjectionMatrix(osg::Matrix::ortho2D(0.0, across, 0.0, _units) *
                                 osg::Matrix::scale(_side, 1.0, 1.0));
    const auto top = static_cast<float>(_units) - kMargin;
    const auto right = static_cast<float>(across) - kMargin;
    _invitation->setPosition({kMargin, top - kBelowKeys, 0.0F});
    _caption->setPosition({kMargin, top - kBelowKeys - kLine * kSize, 0.0F});
    _mute->setPosition({right, top, 0.0F});
    _trouble->setPosition({right, top - kLine * kSmall, 0.0F});
}

float VisitorSign::height() const
{
    const bool hasCaption = !_caption->getText().empty();
    const float left = kMargin + kBelowKeys + kLine * (kSize + (hasCaption ? kSmall : 0.0F));
    const float right = kMargin + kLine * kSmall * (_trouble->getText().empty() ? 1.0F : 2.0F);
    return std::max(left, right) / static_cast<float>(_units);
}

void VisitorSign::setState(bool isMuted, const std::string& trouble)
{
    set(*_mute, isMuted ? "MUTED  -  F8 unmutes" : "F8 mutes");
    _mute->setColor(isMuted ? kAlarm : kQuiet);
    set(*_trouble, trouble);
}

// Laying out text costs more than comparing it.
void VisitorSign::set(osgText::Text& text, const std::string& content)
{
    if (text.getText().createUTF8EncodedString() != content)
        text.setText(content, osgText::String::ENCODING_UTF8);
}

} // namespace midair::samples
