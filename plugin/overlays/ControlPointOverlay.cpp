#include "plugin/overlays/OverlayPart.h"
#include "plugin/overlays/drawing/DiscGeometry.h"

#include <osgMidair/ColorMap>
#include <osgMidair/ControlPointOverlay>

#include <osg/Geometry>
#include <osgGA/GUIEventAdapter>

namespace osgMidair
{

namespace
{

const OverlayNumber kControlPointRadius = overlayNumber<ControlPointOverlay,
                                                        &ControlPointOverlay::setRadius,
                                                        &ControlPointOverlay::getRadius>(
    "pointRadius", "outer radius of the control points' rings", {1e-5, 1.0}, "m");
const OverlayRegistration kControlPointRegistration(
    {1,
     "ControlPoints",
     "points",
     "the control points",
     "a ring a point, by achieved over wanted pressure; left out ones grey",
     osgGA::GUIEventAdapter::KEY_F2,
     60,
     makeOverlay<ControlPointOverlay>,
     {kControlPointRadius}});

// Each disc faces the eye and is moved towards it by its radius, so that a surface through the
// point doesn't cut the ring.
const char* const kControlPointVertexSource = R"(#version 120
uniform float radius_m;
varying vec2 corner;
varying vec4 color;
void main()
{
    corner = gl_MultiTexCoord0.xy;
    color = gl_Color;
    float r = radius_m * length(gl_ModelViewMatrix[0].xyz);
    vec4 eye = gl_ModelViewMatrix * gl_Vertex;
    eye.xyz += r * vec3(corner, 0.0) - r * normalize(eye.xyz);
    gl_Position = gl_ProjectionMatrix * eye;
}
)";

// A ring, so that the field in its middle stays visible, with dark rims to be visible on bright and
// on dark ground.
const char* const kControlPointFragmentSource = R"(#version 120
varying vec2 corner;
varying vec4 color;
void main()
{
    float r = length(corner);
    float edge = min(0.25, 1.5 * fwidth(r)) + 1e-4;
    float ring = smoothstep(0.40 - edge, 0.40, r) * (1.0 - smoothstep(1.0 - edge, 1.0, r));
    if(ring <= 0.0) discard;
    float band = smoothstep(0.52 - edge, 0.52, r) * (1.0 - smoothstep(0.84 - edge, 0.84, r));
    float light = 0.85 + 0.15 * corner.y;
    gl_FragColor = vec4(mix(vec3(0.04), color.rgb * light, band), color.a * ring);
}
)";

const osg::Vec3f kLeftOut(0.45F, 0.45F, 0.47F);

} // namespace

class ControlPointOverlay::Part : public OverlayPart
{
public:
    Part() : rings(makeDiscs()), radius(new osg::Uniform("radius_m", 2.4e-3F))
    {
        rings->setCullingActive(false);
        osg::StateSet* state = rings->getOrCreateStateSet();
        state->setAttributeAndModes(makeProgram(
            "osgMidair control points", kControlPointVertexSource, kControlPointFragmentSource));
        state->addUniform(radius);
        drawTranslucent(*rings, POINT_BIN);
    }

    void setResult(const std::shared_ptr<const midair::bridge::HologramResult>& result) override
    {
        const midair::haptics::ControlPoints& points = result->points;
        const int skipped = static_cast<int>(result->skipped.cols());
        resizeDiscs(*rings, points.size() + skipped);
        const double largest = points.size() > 0 ? points.targets.maxCoeff() : 1.0;
        for (int l = 0; l < points.size(); ++l)
        {
            const float achieved = l < result->achieved_Pa.size() ? result->achieved_Pa[l] : 0.0F;
            const auto wanted = static_cast<float>(
                result->points.absolute ? points.targets[l]
                                        : result->report().level_Pa * points.targets[l] / largest);
            setDisc(*rings,
                    l,
                    osgVec(points.positions.col(l)),
                    bytes(achieved > 0.0F ? ColorMap::diverging().color(
                                                ColorMap::ratioPosition(achieved, wanted))
                                          : kLeftOut,
                          1.0F));
        }
        for (int l = 0; l < skipped; ++l)
            setDisc(
                *rings, points.size() + l, osgVec(result->skipped.col(l)), bytes(kLeftOut, 1.0F));
        showChanges(*rings);
    }

    osg::ref_ptr<osg::Geometry> rings;
    osg::ref_ptr<osg::Uniform> radius;
};

ControlPointOverlay::ControlPointOverlay() :
    Overlay(std::make_unique<Part>()),
    _part(static_cast<Part&>(OverlayPart::of(*this)))
{
    addChild(_part.rings);
}

ControlPointOverlay::~ControlPointOverlay() = default;

void ControlPointOverlay::setRadius(float radius_m)
{
    _radius_m = radius_m;
    _part.radius->set(radius_m);
}

} // namespace osgMidair
