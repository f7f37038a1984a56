#include "engine-bridge/contact/ContactPatch.h"
#include "engine-bridge/rendering/ContactView.h"
#include "haptics/base/Units.h"
#include "plugin/overlays/OverlayPart.h"
#include "plugin/overlays/drawing/DiscGeometry.h"

#include <osgMidair/ContactOverlay>

#include <osg/Geometry>
#include <osg/LineWidth>
#include <osgGA/GUIEventAdapter>

#include <algorithm>
#include <cmath>
#include <utility>

namespace osgMidair
{

namespace
{

using midair::bridge::ContactScene;
using midair::bridge::ContactView;
using midair::bridge::SensationView;
using midair::bridge::TrailPoint;

const OverlayRegistration kContactRegistration(
    {9,
     "Contacts",
     "contacts",
     "what is played where hands touch",
     "where hands touch: the patch of the object, the path of the foci on the skin, the foci; and "
     "the trails of sensations",
     osgGA::GUIEventAdapter::KEY_F12,
     70,
     makeOverlay<ContactOverlay>});

constexpr int kCorners = 48; ///< of an ellipse
constexpr float kLineWidth = 3.0F;
constexpr double kLeastDot_m = 0.6e-3;
constexpr double kMostDot_m = 1.2e-3;
constexpr double kJump_m = 0.06; // a step of the path, not a stroke
const osg::Vec3f kPatch(0.95F, 0.97F, 1.00F);
const osg::Vec3f kPath(1.00F, 0.62F, 0.22F);
const osg::Vec3f kFocus(1.00F, 0.30F, 0.20F);

// The length of the normal is the radius of the dot, which faces the eye.
const char* const kDotVertex = R"(#version 120
varying vec2 corner;
varying vec4 color;
void main()
{
    corner = gl_MultiTexCoord0.xy;
    color = gl_Color;
    float r = length(gl_Normal) * length(gl_ModelViewMatrix[0].xyz);
    vec4 eye = gl_ModelViewMatrix * gl_Vertex;
    eye.xyz += r * vec3(corner, 0.0);
    gl_Position = gl_ProjectionMatrix * eye;
}
)";

// With a dark rim, to be visible on any background.
const char* const kDotFragment = R"(#version 120
varying vec2 corner;
varying vec4 color;
void main()
{
    float r = length(corner);
    float edge = min(0.25, 1.5 * fwidth(r)) + 1e-4;
    float disc = 1.0 - smoothstep(1.0 - edge, 1.0, r);
    if (disc <= 0.0) discard;
    float rim = smoothstep(0.78 - edge, 0.78, r);
    gl_FragColor = vec4(mix(color.rgb, vec3(0.04), rim), color.a * disc);
}
)";

osg::ref_ptr<osg::Geometry> makeLines()
{
    osg::ref_ptr<osg::Geometry> lines = makeChanging(new osg::DrawArrays(GL_LINES, 0, 0));
    lines->setCullingActive(false);
    osg::StateSet* state = lines->getOrCreateStateSet();
    state->setAttributeAndModes(new osg::LineWidth(kLineWidth));
    state->setMode(GL_LIGHTING, osg::StateAttribute::OFF | osg::StateAttribute::PROTECTED);
    return lines;
}

/// Foci are on the skin inside the object, so a depth test would hide them.
void drawThrough(osg::Geometry& geometry)
{
    drawTranslucent(geometry, POINT_BIN);
    geometry.getOrCreateStateSet()->setMode(
        GL_DEPTH_TEST, osg::StateAttribute::OFF | osg::StateAttribute::PROTECTED);
}

Eigen::Vector3d onEllipse(const ContactView& contact, int corner, double major_m, double minor_m)
{
    const double turn = midair::base::kTwoPi * corner / kCorners;
    return contact.patch.centre + major_m * std::cos(turn) * contact.patch.major +
           minor_m * std::sin(turn) * contact.patch.minor;
}

} // namespace

class ContactOverlay::Part : public OverlayPart
{
public:
    explicit Part(ContactOverlay& owner) : lines(makeLines()), dots(makeDiscs()), _owner(owner)
    {
        drawThrough(*lines);
        dots->setCullingActive(false);
        dots->getOrCreateStateSet()->setAttributeAndModes(
            makeProgram("osgMidair foci", kDotVertex, kDotFragment));
        drawThrough(*dots);
    }

    // Contacts without foci are not drawn.
    void setResult(const std::shared_ptr<const midair::bridge::HologramResult>& result) override
    {
        ContactScene scene;
        if (result->touched && result->state == midair::bridge::ArrayState::PLAYING)
            for (const ContactView& contact : result->touched->contacts)
                if (contact.foci.cols() > 0) scene.contacts.push_back(contact);
        if (result->touched && result->state == midair::bridge::ArrayState::PLAYING)
            for (const SensationView& sensation : result->touched->sensations)
                if (sensation.isPlaying) scene.sensations.push_back(sensation);
        _owner._contacts = static_cast<int>(scene.contacts.size());
        drawLines(scene);
        drawDots(scene);
    }

    osg::ref_ptr<osg::Geometry> lines;
    osg::ref_ptr<osg::Geometry> dots;

private:
    void drawLines(const ContactScene& scene)
    {
        osg::Vec3Array& vertices = verticesOf(*lines);
        osg::Vec4ubArray& colors = colorsOf(*lines);
        if (vertices.empty() && scene.contacts.empty() && scene.sensations.empty()) return;
        vertices.clear();
        colors.clear();
        const auto line = [&](const osg::Vec3& from, const osg::Vec3& to, const osg::Vec4ub& color)
        {
            vertices.push_back(from);
            vertices.push_back(to);
            colors.push_back(color);
            colors.push_back(color);
        };
        for (const ContactView& contact : scene.contacts)
        {
            const auto opacity = static_cast<float>(std::clamp(contact.share, 0.0, 1.0));
            const auto patchAt = [&](int k)
            { return onEllipse(contact, k, contact.patch.semiMajor_m, contact.patch.semiMinor_m); };
            const auto pathAt = [&](int k)
            {
                const Eigen::Vector3d place =
                    onEllipse(contact, k, contact.pathMajor_m, contact.pathMinor_m);
                return contact.patch.own.empty() ? place
                                                 : midair::bridge::skinUnder(contact.patch, place);
            };
            for (int k = 0; k < kCorners; ++k)
            {
                line(osgVec(patchAt(k)), osgVec(patchAt(k + 1)), bytes(kPatch, 0.9F * opacity));
                line(osgVec(pathAt(k)), osgVec(pathAt(k + 1)), bytes(kPath, opacity));
            }
        }
        // Where a sensation's focus was in its last turn, brighter where it was stronger.
        for (const SensationView& sensation : scene.sensations)
            for (std::size_t k = 1; k < sensation.trail.size(); ++k)
            {
                const TrailPoint& from = sensation.trail[k - 1];
                const TrailPoint& to = sensation.trail[k];
                const bool isJump = (to.place - from.place).norm() > kJump_m;
                if (!(from.intensity > 0.0) || !(to.intensity > 0.0) || isJump) continue;
                const auto strength = static_cast<float>(0.25 + 0.75 * to.intensity);
                line(osgVec(from.place), osgVec(to.place), bytes(kPath, strength));
            }
        showChanges(*lines);
    }

    void drawDots(const ContactScene& scene)
    {
        int& foci = _owner._foci;
        const int before = std::exchange(foci, 0);
        double most_Pa = 0.0;
        for (const ContactView& contact : scene.contacts)
        {
            foci += static_cast<int>(contact.foci.cols());
            most_Pa = std::max(most_Pa, contact.pressure_Pa.maxCoeff());
        }
        const auto sounds = [](const SensationView& sensation)
        { return sensation.intensity > 0.0; };
        foci += static_cast<int>(
            std::count_if(scene.sensations.begin(), scene.sensations.end(), sounds));
        if (before == 0 && foci == 0) return;
        resizeDiscs(*dots, foci);
        int next = 0;
        for (const ContactView& contact : scene.contacts)
            for (Eigen::Index l = 0; l < contact.foci.cols(); ++l)
            {
                const double share = most_Pa > 0.0 ? contact.pressure_Pa[l] / most_Pa : 0.0;
                const double radius_m = kLeastDot_m + (kMostDot_m - kLeastDot_m) * share;
                const auto opacity = static_cast<float>(std::clamp(contact.share, 0.0, 1.0));
                setDisc(*dots,
                        next++,
                        osgVec(contact.foci.col(l)),
                        bytes(kFocus, opacity),
                        osg::Vec3(0.0F, 0.0F, static_cast<float>(radius_m)));
            }
        for (const SensationView& sensation : scene.sensations)
            if (sounds(sensation))
                setDisc(*dots,
                        next++,
                        osgVec(sensation.place),
                        bytes(kFocus, 1.0F),
                        osg::Vec3(0.0F,
                                  0.0F,
                                  static_cast<float>(kLeastDot_m + (kMostDot_m - kLeastDot_m) *
                                                                       sensation.intensity)));
        showChanges(*dots);
    }

    ContactOverlay& _owner;
};

ContactOverlay::ContactOverlay() :
    Overlay(std::make_unique<Part>(*this)),
    _part(static_cast<Part&>(OverlayPart::of(*this)))
{
    addChild(_part.lines);
    addChild(_part.dots);
}

ContactOverlay::~ContactOverlay() = default;

} // namespace osgMidair
