#include "haptics/base/Units.h"
#include "plugin/overlays/OverlayPart.h"
#include "plugin/overlays/drawing/DiscGeometry.h"
#include "plugin/overlays/drawing/HandGeometry.h"
#include "plugin/overlays/drawing/PixelDrawing.h"
#include "plugin/overlays/hud/HudRoom.h"

#include <osgMidair/HandsOverlay>

#include <osg/Geometry>
#include <osgGA/GUIEventAdapter>
#include <osgText/Text>
#include <osgUtil/CullVisitor>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <iterator>
#include <map>
#include <memory>

#include <fmt/format.h>

namespace osgMidair
{

namespace
{

const OverlayNumber kCapsules =
    overlayNumber<HandsOverlay, &HandsOverlay::setCapsules, &HandsOverlay::getCapsules>(
        "handCapsules",
        "1: hands are drawn as the capsules that touches are computed with",
        {1.0, 1.0, true});
const OverlayNumber kOcclude =
    overlayNumber<HandsOverlay, &HandsOverlay::setOcclude, &HandsOverlay::getOcclude>(
        "handsOcclude",
        "1: hands are black, with alpha 0, and hide what is behind them",
        {1.0, 1.0, true});
const OverlayRegistration kHandsRegistration({7,
                                              "Hands",
                                              "hands",
                                              "hands and touches",
                                              "hands, touches with their force in mN",
                                              osgGA::GUIEventAdapter::KEY_F10,
                                              50,
                                              makeOverlay<HandsOverlay>,
                                              {kCapsules, kOcclude}});

constexpr double kFade_s = 0.5; ///< time in which a ring fades after its touch has ended
/// Height of a label in units of hudScale(), however near the hand is: ten fingers have one each.
constexpr float kLabel = 11.0F;
const osg::Vec3f kSkin(0.86F, 0.82F, 0.78F);
const osg::Vec3f kTouching(1.00F, 0.62F, 0.22F);

// A capsule is drawn as a rectangle that turns around the axis to face the eye. It has the
// projected length of the axis plus a radius at each end. gl_Vertex is this end of the axis,
// gl_Normal the other one; the texture coordinates give end, side and radius.
const char* const kCapsuleVertex = R"(#version 120
uniform float before;
varying float along; // in radii, from this capsule's first end on
varying float across;
varying float span;
varying vec4 color;
void main()
{
    float end = gl_MultiTexCoord0.x;
    float r = gl_MultiTexCoord0.z * length(gl_ModelViewMatrix[0].xyz);
    color = gl_Color;
    vec4 here = gl_ModelViewMatrix * gl_Vertex;
    vec4 there = gl_ModelViewMatrix * vec4(gl_Normal, 1.0);
    float shrink = gl_ProjectionMatrix[3][3] == 0.0 ? here.z / there.z : 1.0;
    vec2 way = there.xy * shrink - here.xy;
    float far = length(way);
    way = far > 1e-6 ? way / far : vec2(1.0 - 2.0 * end, 0.0);
    across = gl_MultiTexCoord0.y;
    span = far / r;
    along = end < 0.5 ? -1.0 : span + 1.0;
    float side = end < 0.5 ? across : -across;
    here.xy += r * (side * vec2(-way.y, way.x) - way);
    gl_Position = gl_ProjectionMatrix * here;
    vec4 front = gl_ProjectionMatrix * vec4(here.xy, min(here.z + before * r, 0.5 * here.z), 1.0);
    gl_Position.z = front.z / front.w * gl_Position.w;
}
)";

const char* const kCapsuleFragment = R"(#version 120
uniform float osgMidairHides;
varying float along;
varying float across;
varying float span;
varying vec4 color;
void main()
{
    float beyond = along < 0.0 ? along : max(0.0, along - span);
    float d2 = beyond * beyond + across * across;
    if (d2 > 1.0) discard;
    float towardsEye = sqrt(1.0 - d2);
    float seen = osgMidairHides > 0.5 ? 0.0 : 1.0;
    gl_FragColor = seen * vec4(color.rgb * (0.45 + 0.55 * towardsEye), color.a * mix(0.75, 0.40, towardsEye));
}
)";

// The length of the normal is the radius of the ring.
const char* const kRingVertex = R"(#version 120
varying vec2 corner;
varying vec4 color;
void main()
{
    corner = gl_MultiTexCoord0.xy;
    color = gl_Color;
    float r = length(gl_Normal) * length(gl_ModelViewMatrix[0].xyz);
    vec4 eye = gl_ModelViewMatrix * gl_Vertex;
    eye.xyz += r * vec3(corner, 0.0) - r * normalize(eye.xyz);
    gl_Position = gl_ProjectionMatrix * eye;
}
)";

const char* const kRingFragment = R"(#version 120
varying vec2 corner;
varying vec4 color;
void main()
{
    float r = length(corner);
    float edge = min(0.25, 1.5 * fwidth(r)) + 1e-4;
    float ring = smoothstep(0.70 - edge, 0.70, r) * (1.0 - smoothstep(1.0 - edge, 1.0, r));
    gl_FragColor = vec4(color.rgb, color.a * ring);
}
)";

osg::ref_ptr<osg::Geometry> makeCapsules()
{
    osg::ref_ptr<osg::Geometry> geometry = makeChanging(new osg::DrawArrays(GL_QUADS, 0, 0));
    geometry->setCullingActive(false);
    geometry->setNormalArray(new osg::Vec3Array, osg::Array::BIND_PER_VERTEX);
    geometry->setTexCoordArray(0, new osg::Vec3Array, osg::Array::BIND_PER_VERTEX);
    return geometry;
}

} // namespace

class HandsOverlay::Part : public OverlayPart
{
public:
    /// A touch that goes on, or has ended and fades.
    struct Mark
    {
        midair::bridge::HandContact contact; ///< as it was last
        double seen_s = 0.0;
        osg::ref_ptr<osgText::Text> label;
    };

    explicit Part(HandsOverlay& owner) :
        capsules(makeCapsules()),
        rings(makeDiscs()),
        hides(new osg::Uniform(kHandsHide, 0.0F)),
        _owner(owner)
    {
        setOcclude(false);
        rings->setCullingActive(false);
        rings->getOrCreateStateSet()->setAttributeAndModes(
            makeProgram("osgMidair touches", kRingVertex, kRingFragment));
        drawTranslucent(*rings, POINT_BIN);
    }

    /// Capsules are drawn translucent, at the skin that may hide what is behind it; those that hide
    /// are drawn first.
    void setOcclude(bool occlude)
    {
        hides->set(occlude ? 1.0F : 0.0F);
        osg::ref_ptr<osg::StateSet> state = new osg::StateSet;
        capsules->setStateSet(state);
        state->setAttributeAndModes(
            makeProgram("osgMidair hands", kCapsuleVertex, kCapsuleFragment));
        state->addUniform(new osg::Uniform("before", occlude ? 1.0F : 1.5F)); // radii
        if (occlude)
            drawHands(*state);
        else
            drawTranslucent(*capsules, HAND_BIN);
    }

    bool followsHands() const override { return true; }

    void setHands(const std::vector<midair::bridge::HandCapsule>& hands,
                  const std::vector<midair::bridge::HandContact>& contacts,
                  double time_s) override
    {
        for (const midair::bridge::HandContact& contact : contacts)
        {
            if (!contact.touching) continue;
            auto mark = std::find_if(marks.begin(),
                                     marks.end(),
                                     [&](const Mark& m)
                                     {
                                         return m.contact.object == contact.object &&
                                                m.contact.hand == contact.hand &&
                                                m.contact.finger == contact.finger;
                                     });
            if (mark == marks.end())
            {
                mark = marks.emplace(marks.end());
                mark->label = pixels::label("",
                                            {},
                                            kLabel,
                                            osg::Vec4(kTouching, 1.0F),
                                            osgText::TextBase::LEFT_BASE_LINE,
                                            true);
                drawTranslucent(*mark->label, POINT_BIN);
                _owner.addChild(mark->label);
            }
            mark->contact = contact;
            mark->seen_s = time_s;
        }
        if (!areCapsules) handMesh(); // made now rather than when the first hand comes
        _owner._bones = static_cast<int>(hands.size());
        drawBones(asSkins(hands));
        drawMarks(time_s);
    }

    /// hudScale() of the view that was culled last, perhaps in another thread
    std::atomic<float> unit_pixels{1.0F};
    std::vector<Mark> marks;
    osg::ref_ptr<osg::Geometry> capsules;
    osg::ref_ptr<osg::Geometry> rings;
    osg::ref_ptr<osg::Uniform> hides; ///< 1: yes
    bool areCapsules = false;

private:
    bool isTouching(const midair::bridge::HandCapsule& capsule) const
    {
        return std::any_of(marks.begin(),
                           marks.end(),
                           [&](const Mark& m) {
                               return m.contact.hand == capsule.hand &&
                                      m.contact.bone == capsule.bone;
                           });
    }

    /// A hand that is hidden, of that side.
    HandGeometry& freeSkin(bool isLeft, std::vector<HandGeometry*>& used)
    {
        for (const auto& skin : _skins)
            if (skin->isLeft() == isLeft && std::count(used.begin(), used.end(), skin.get()) == 0)
                return *used.emplace_back(skin.get());
        _skins.push_back(std::make_unique<HandGeometry>(isLeft));
        _owner.insertChild(0, &_skins.back()->geometry());
        return *used.emplace_back(_skins.back().get());
    }

    /// Draws hands with a skin, and returns the others.
    std::vector<midair::bridge::HandCapsule>
    asSkins(const std::vector<midair::bridge::HandCapsule>& hands)
    {
        std::map<int, TouchingBones> touching; // by hand
        if (!areCapsules)
            for (const midair::bridge::HandCapsule& capsule : hands)
                touching[capsule.hand][static_cast<std::size_t>(capsule.bone)] =
                    isTouching(capsule);
        std::vector<HandGeometry*> used;
        std::vector<int> shown;
        for (const auto& [hand, bones] : touching)
            if (freeSkin(HandSkin::isLeft(hand), used).show(hands, hand, bones))
                shown.push_back(hand);
        for (const auto& skin : _skins)
            if (std::count(used.begin(), used.end(), skin.get()) == 0) skin->hide();
        std::vector<midair::bridge::HandCapsule> others;
        std::copy_if(hands.begin(),
                     hands.end(),
                     std::back_inserter(others),
                     [&shown](const midair::bridge::HandCapsule& capsule)
                     { return std::count(shown.begin(), shown.end(), capsule.hand) == 0; });
        return others;
    }

    void drawBones(const std::vector<midair::bridge::HandCapsule>& hands)
    {
        osg::Vec3Array& vertices = verticesOf(*capsules);
        osg::Vec3Array& others = normalsOf(*capsules);
        osg::Vec4ubArray& colors = colorsOf(*capsules);
        auto& coordinates = static_cast<osg::Vec3Array&>(*capsules->getTexCoordArray(0));
        if (hands.empty() && vertices.empty()) return;
        vertices.clear();
        others.clear();
        colors.clear();
        coordinates.clear();
        for (const midair::bridge::HandCapsule& capsule : hands)
        {
            const bool touches = isTouching(capsule);
            const osg::Vec3 a = osgVec(capsule.shape.a);
            const osg::Vec3 b = osgVec(capsule.shape.b);
            const auto radius = static_cast<float>(capsule.shape.radius_m);
            for (const auto& [end, side] : {std::pair{0, -1}, {1, -1}, {1, 1}, {0, 1}})
            {
                vertices.push_back(end ? b : a);
                others.push_back(end ? a : b);
                colors.push_back(bytes(touches ? kTouching : kSkin, 1.0F));
                coordinates.push_back(
                    osg::Vec3(static_cast<float>(end), static_cast<float>(side), radius));
            }
        }
        showChanges(*capsules);
    }

    void drawMarks(double time_s)
    {
        for (auto mark = marks.begin(); mark != marks.end();)
        {
            // If time goes back, a clock was reset.
            if (time_s - mark->seen_s <= kFade_s && time_s >= mark->seen_s)
            {
                ++mark;
                continue;
            }
            _owner.removeChild(mark->label);
            mark = marks.erase(mark);
        }
        const int count = static_cast<int>(marks.size());
        if (count == 0 && verticesOf(*rings).empty()) return;
        resizeDiscs(*rings, count);
        for (int i = 0; i < count; ++i)
        {
            const Mark& mark = marks[i];
            const float opacity = 1.0F - static_cast<float>((time_s - mark.seen_s) / kFade_s);
            const osg::Vec3 place = osgVec(mark.contact.position);
            const auto radius = static_cast<float>(
                std::clamp(std::sqrt(mark.contact.overlap_m2 / midair::base::kPi), 3e-3, 15e-3));
            setDisc(*rings, i, place, bytes(kTouching, opacity), osg::Vec3(0.0F, 0.0F, radius));
            std::string force;
            if (mark.contact.force_N > 0.0)
                force = fmt::format("  {:.2f} mN", 1e3 * mark.contact.force_N);
            const std::string label = midair::bridge::boneName(mark.contact.bone) + force;
            if (mark.label->getText().createUTF8EncodedString() != label)
                mark.label->setText(label, osgText::String::ENCODING_UTF8);
            mark.label->setPosition(place + osg::Vec3(radius + 2e-3F, 0.0F, radius));
            mark.label->setColor(osg::Vec4(kTouching, opacity));
            const float height = kLabel * unit_pixels;
            if (mark.label->getCharacterHeight() != height) mark.label->setCharacterSize(height);
        }
        showChanges(*rings);
    }

    HandsOverlay& _owner; ///< parent of the labels
    std::vector<std::unique_ptr<HandGeometry>> _skins;
};

HandsOverlay::HandsOverlay() :
    Overlay(std::make_unique<Part>(*this)),
    _part(static_cast<Part&>(OverlayPart::of(*this)))
{
    addChild(_part.capsules);
    addChild(_part.rings);
    getOrCreateStateSet()->addUniform(_part.hides); // the part is made before the node is
}

HandsOverlay::~HandsOverlay() = default;

void HandsOverlay::traverse(osg::NodeVisitor& visitor)
{
    osgUtil::CullVisitor* cull = visitor.asCullVisitor();
    const osg::Viewport* viewport = cull ? cull->getViewport() : nullptr;
    if (viewport)
        _part.unit_pixels = static_cast<float>(hudScale(viewport->width(), viewport->height()));
    Overlay::traverse(visitor);
}

void HandsOverlay::setCapsules(bool capsules)
{
    _part.areCapsules = capsules;
}

bool HandsOverlay::getCapsules() const
{
    return _part.areCapsules;
}

void HandsOverlay::setOcclude(bool occlude)
{
    if (occlude != getOcclude()) _part.setOcclude(occlude);
}

bool HandsOverlay::getOcclude() const
{
    float hides = 0.0F;
    _part.hides->get(hides);
    return hides > 0.5F;
}

int HandsOverlay::getNumTouches() const
{
    return static_cast<int>(_part.marks.size());
}

std::string HandsOverlay::getLabel(int touch) const
{
    const Part::Mark& mark = _part.marks.at(static_cast<std::size_t>(touch));
    return mark.label->getText().createUTF8EncodedString();
}

} // namespace osgMidair
