#include "haptics/base/Units.h"
#include "haptics/probe/Feeling.h"
#include "plugin/overlays/OverlayPart.h"
#include "plugin/overlays/drawing/DiscGeometry.h"
#include "plugin/overlays/drawing/HandGeometry.h"
#include "plugin/overlays/drawing/PixelDrawing.h"
#include "plugin/overlays/hud/HudRoom.h"

#include <osgMidair/HandsOverlay>

#include <osg/Camera>
#include <osg/Geometry>
#include <osgGA/GUIEventAdapter>
#include <osgText/Text>
#include <osgUtil/CullVisitor>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <utility>

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
/// Height of a label in units of labelScale(), whatever the hand's distance.
constexpr float kLabel = 26.0F;
/// Radius of a ring around a finger, in radii of the finger.
constexpr float kRingRadii = 1.15F;
constexpr std::array<const char*, midair::bridge::HAND_FINGERS> kFingers = {
    "thumb", "index", "middle", "ring", "little", "palm"};
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
    /// A current touch, or one that has ended and fades.
    struct Mark
    {
        midair::bridge::HandContact contact; ///< its last state
        double seen_s = 0.0;
        double felt_s = -std::numeric_limits<double>::infinity(); ///< last force; at first never
        osg::Vec3 place;     ///< of the ring: within the touching bone, at the object
        float bone_m = 0.0F; ///< radius of the bone
        osg::ref_ptr<osgText::Text> label;
        std::string text; ///< of the label, preceded by empty lines

        /// The ring is drawn this far before its place, so that the finger doesn't hide it.
        float radius_m() const
        {
            const double radius_m = std::sqrt(contact.overlap_m2 / midair::base::kPi);
            return std::max(kRingRadii * bone_m,
                            static_cast<float>(std::clamp(radius_m, 3e-3, 15e-3)));
        }

        void placeAt(const std::vector<midair::bridge::HandCapsule>& hands)
        {
            place = osgVec(contact.position);
            bone_m = 0.0F;
            const auto bone =
                std::find_if(hands.begin(),
                             hands.end(),
                             [this](const midair::bridge::HandCapsule& one)
                             { return one.hand == contact.hand && one.bone == contact.bone; });
            if (bone == hands.end()) return;
            const auto& [a, b, radius_m] = bone->shape;
            const Eigen::Vector3d along = b - a;
            const double share =
                (contact.position - a).dot(along) / std::max(1e-12, along.squaredNorm());
            place = osgVec((a + std::clamp(share, 0.0, 1.0) * along).eval());
            bone_m = static_cast<float>(radius_m);
        }
    };

    explicit Part(HandsOverlay& owner) :
        capsules(makeCapsules()),
        rings(makeDiscs()),
        hides(new osg::Uniform(kHandsHide, 0.0F)),
        _owner(owner)
    {
        setOcclude(false);
        pixels::paintInOrder(*labels, HUD_BIN - 1); // over the hand, whose depth would hide them
        rings->setCullingActive(false);
        rings->getOrCreateStateSet()->setAttributeAndModes(
            makeProgram("osgMidair touches", kRingVertex, kRingFragment));
        drawTranslucent(*rings, POINT_BIN);
    }

    /// Capsules are translucent over the skin, which may hide what is behind it; the hiding skins
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

    void setResult(const std::shared_ptr<const midair::bridge::HologramResult>& result) override
    {
        most_N = result->fingertip.force_N;
    }

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
                mark->label = pixels::label(
                    "", {}, kLabel, osg::Vec4(kTouching, 1.0F), osgText::TextBase::LEFT_BASE_LINE);
                labels->addChild(mark->label);
            }
            mark->contact = contact;
            mark->seen_s = time_s;
            mark->placeAt(hands);
            if (contact.force_N > 0.0) mark->felt_s = time_s;
        }
        if (!areCapsules) handMesh(); // made now rather than for the first hand
        _owner._bones = static_cast<int>(hands.size());
        drawBones(asSkins(hands));
        drawMarks(time_s);
        drawLabels(hands, time_s);
    }

    void setHandNote(const std::string& note) override { _note = note; }

    /// labelScale() of the last culled view, perhaps on another thread
    std::atomic<float> unit_pixels{1.4F}; ///< at first that of 1200 x 800
    std::vector<Mark> marks;
    double most_N = std::numeric_limits<double>::infinity(); ///< force at the strongest place
    osg::ref_ptr<osg::Geometry> capsules;
    osg::ref_ptr<osg::Geometry> rings;
    osg::ref_ptr<osg::Uniform> hides; ///< 1: yes
    osg::ref_ptr<osg::Group> labels = new osg::Group;
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

    /// Returns an unused skin of that side.
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
            labels->removeChild(mark->label);
            mark = marks.erase(mark);
        }
        // What isn't felt, as nothing is played, has no ring.
        std::vector<std::pair<const Mark*, float>> felt;
        for (const Mark& mark : marks)
            if (const float opacity = opacityAfter(mark.felt_s, time_s); opacity > 0.0F)
                felt.emplace_back(&mark, opacity);
        if (marks.empty() && verticesOf(*rings).empty()) return;
        resizeDiscs(*rings, static_cast<int>(felt.size()));
        for (std::size_t i = 0; i < felt.size(); ++i)
            setDisc(*rings,
                    static_cast<int>(i),
                    felt[i].first->place,
                    bytes(kTouching, felt[i].second),
                    osg::Vec3(0.0F, 0.0F, felt[i].first->radius_m()));
        showChanges(*rings);
    }

    static float opacityAfter(double last_s, double time_s)
    {
        return static_cast<float>(std::clamp(1.0 - (time_s - last_s) / kFade_s, 0.0, 1.0));
    }

    /// Draws a label for each touching finger, those of a hand below each other beside it: they
    /// share one origin, so they never overlap from any viewpoint. The note of the first hand is
    /// the last.
    void drawLabels(const std::vector<midair::bridge::HandCapsule>& hands, double time_s)
    {
        std::map<std::pair<int, int>, std::vector<Mark*>> fingers; // by hand and finger
        std::map<int, osg::Vec3> corners; // by hand: right of the rings, above
        for (Mark& mark : marks)
        {
            fingers[{mark.contact.hand, mark.contact.finger}].push_back(&mark);
            const float radius = mark.radius_m();
            const osg::Vec3 corner = mark.place + osg::Vec3(radius + 2e-3F, 0.0F, radius);
            osg::Vec3& all = corners.emplace(mark.contact.hand, corner).first->second;
            all.x() = std::max(all.x(), corner.x());
            all.z() = std::max(all.z(), corner.z());
        }
        std::map<int, std::size_t> lines; // by hand
        for (const auto& [who, touches] : fingers)
        {
            double force_N = 0.0;
            for (Mark* mark : touches)
            {
                force_N += mark->contact.force_N;
                mark->text.clear();
                setText(*mark->label, {}, 0);
            }
            std::string text = kFingers.at(static_cast<std::size_t>(who.second));
            // That of a touch is an upper estimate; nowhere does a fingertip get more than the
            // most.
            force_N = std::min(force_N, most_N);
            if (force_N > 0.0) text += " " + midair::haptics::forceText(force_N);
            Mark& first = *touches.front();
            first.text = text;
            setText(*first.label, text, lines[who.first]++);
            first.label->setPosition(corners[who.first]);
            first.label->setColor(osg::Vec4(kTouching, opacityAfter(first.seen_s, time_s)));
        }
        drawNote(hands, corners, lines);
    }

    void setText(osgText::Text& label, const std::string& text, std::size_t line) const
    {
        const std::string shown = text.empty() ? text : std::string(line, '\n') + text;
        if (label.getText().createUTF8EncodedString() != shown)
            label.setText(shown, osgText::String::ENCODING_UTF8);
        const float height = kLabel * unit_pixels;
        if (label.getCharacterHeight() != height) label.setCharacterSize(height);
    }

    /// \a corners, \a lines: of the labels of touches, by hand.
    void drawNote(const std::vector<midair::bridge::HandCapsule>& hands,
                  const std::map<int, osg::Vec3>& corners,
                  std::map<int, std::size_t>& lines)
    {
        const auto tip =
            std::find_if(hands.rbegin(),
                         hands.rend(),
                         [&hands](const midair::bridge::HandCapsule& one)
                         {
                             return one.hand == hands.front().hand &&
                                    midair::bridge::fingerOf(one.bone) == midair::bridge::INDEX;
                         });
        if (_note.empty() || tip == hands.rend())
        {
            if (_noteLabel) setText(*_noteLabel, {}, 0);
            return;
        }
        if (!_noteLabel)
        {
            _noteLabel = pixels::label(
                "", {}, kLabel, osg::Vec4(kSkin, 1.0F), osgText::TextBase::LEFT_BASE_LINE);
            labels->addChild(_noteLabel);
        }
        const auto corner = corners.find(tip->hand);
        const auto radius = static_cast<float>(tip->shape.radius_m);
        _noteLabel->setPosition(corner != corners.end()
                                    ? corner->second
                                    : osgVec(tip->shape.b) + osg::Vec3(radius, 0.0F, radius));
        setText(*_noteLabel, _note, lines[tip->hand]);
    }

    HandsOverlay& _owner;                   ///< parent of the hands
    std::string _note;                      ///< of the first hand
    osg::ref_ptr<osgText::Text> _noteLabel; ///< null: there was none yet
    std::vector<std::unique_ptr<HandGeometry>> _skins;
};

HandsOverlay::HandsOverlay() :
    Overlay(std::make_unique<Part>(*this)),
    _part(static_cast<Part&>(OverlayPart::of(*this)))
{
    addChild(_part.capsules);
    addChild(_part.rings);
    addChild(_part.labels);
    getOrCreateStateSet()->addUniform(_part.hides); // the part is constructed before the node
}

HandsOverlay::~HandsOverlay() = default;

void HandsOverlay::traverse(osg::NodeVisitor& visitor)
{
    osgUtil::CullVisitor* cull = visitor.asCullVisitor();
    const osg::Viewport* viewport = cull ? cull->getViewport() : nullptr;
    const osg::Camera* camera = cull ? cull->getCurrentCamera() : nullptr;
    // Not the size of a shadow's or a mirror's picture.
    const bool isSeen = camera && camera->getRenderOrder() != osg::Camera::PRE_RENDER;
    if (viewport && isSeen)
        _part.unit_pixels = static_cast<float>(labelScale(viewport->width(), viewport->height()));
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
    return _part.marks.at(static_cast<std::size_t>(touch)).text;
}

} // namespace osgMidair
