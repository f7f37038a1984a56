#include "engine-bridge/HologramResult.h"
#include "plugin/overlays/Quads.h"

#include <osgMidair/ColorMap>
#include <osgMidair/ControlPointOverlay>

namespace osgMidair
{

namespace
{

// Each quad turns to the eye and is shaded as the ball that it stands for; lifted by its radius towards the eye, so that a
// ball in a surface isn't cut by it.
const char* const kVertexSource = R"(#version 120
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

const char* const kFragmentSource = R"(#version 120
varying vec2 corner;
varying vec4 color;
void main()
{
    float r2 = dot(corner, corner);
    float edge = 2.0 * fwidth(r2) + 1e-4;
    float inside = 1.0 - smoothstep(1.0 - edge, 1.0, r2);
    if(inside <= 0.0) discard;
    vec3 normal = vec3(corner, sqrt(max(0.0, 1.0 - r2)));
    float light = 0.62 + 0.38 * max(0.0, dot(normal, normalize(vec3(-0.3, 0.55, 0.8))));
    float rim = smoothstep(0.62, 0.86, r2); // dark: legible on bright and on dark alike
    gl_FragColor = vec4(mix(color.rgb * light, vec3(0.06), rim), color.a * inside);
}
)";

const osg::Vec3f kLeftOut(0.45F, 0.45F, 0.47F);

} // namespace

ControlPointOverlay::ControlPointOverlay() :
    _balls(makeQuads()),
    _radius(new osg::Uniform("radius_m", 2.2e-3F))
{
    _balls->setCullingActive(false);
    osg::StateSet* state = _balls->getOrCreateStateSet();
    state->setAttributeAndModes(
        makeProgram("osgMidair control points", kVertexSource, kFragmentSource));
    state->addUniform(_radius);
    drawTranslucent(*_balls, POINT_BIN);
    addChild(_balls);
}

ControlPointOverlay::~ControlPointOverlay() = default;

void ControlPointOverlay::setRadius(float radius_m)
{
    _radius->set(radius_m);
}

float ControlPointOverlay::getRadius() const
{
    float radius = 0.0F;
    _radius->get(radius);
    return radius;
}

void ControlPointOverlay::setResult(
    const std::shared_ptr<const midair::bridge::HologramResult>& result)
{
    const midair::haptics::ControlPoints& points = result->points;
    resizeQuads(*_balls, points.size());
    osg::Vec3Array& vertices = quadVertices(*_balls);
    osg::Vec4ubArray& colors = quadColors(*_balls);
    const double largest = points.size() > 0 ? points.targets.maxCoeff() : 1.0;
    for (int l = 0; l < points.size(); ++l)
    {
        const osg::Vec3 position(
            osg::Vec3d(points.positions(0, l), points.positions(1, l), points.positions(2, l)));
        const float achieved = l < result->achieved_Pa.size() ? result->achieved_Pa[l] : 0.0F;
        const auto wanted =
            static_cast<float>(result->report.level_Pa * points.targets[l] / largest);
        const osg::Vec4ub color = bytes(
            achieved > 0.0F ? ColorMap::diverging().color(ColorMap::ratioPosition(achieved, wanted))
                            : kLeftOut,
            1.0F);
        for (int k = 0; k < 4; ++k)
        {
            vertices[4 * l + k] = position;
            colors[4 * l + k] = color;
        }
    }
    vertices.dirty();
    colors.dirty();
    _balls->dirtyBound();
}

} // namespace osgMidair
