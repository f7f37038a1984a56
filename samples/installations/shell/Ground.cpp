#include "samples/installations/shell/Ground.h"

#include "samples/shared/views/ShownObject.h"

#include <osgMidair/HandsOverlay>

#include <osg/ComputeBoundsVisitor>
#include <osg/Geometry>
#include <osg/Program>
#include <osg/Texture2D>
#include <osgUtil/CullVisitor>

#include <algorithm>
#include <array>
#include <cmath>

namespace midair::samples
{

namespace
{

/// mask of nodes that cast a shadow: all but the overlays
constexpr unsigned int kCasts = 1U << 31U;
constexpr int kShadowPixels = 512;
constexpr double kGap_m = 1e-3;          ///< below the objects on it
constexpr double kFar_m = 5.0;           ///< distance of the lamp
constexpr double kSmallest_m = 0.2;      ///< smallest radius of the lit area
constexpr int kRim = 64;                 ///< corners of the disc
const osg::Vec3d kLamp(-0.5, -0.7, 0.9); ///< direction of the brighter light of lit()

const char* const kGroundVertex = R"(#version 120
varying vec2 at;
varying vec2 shadow;
void main()
{
    at = gl_MultiTexCoord0.xy;
    shadow = gl_MultiTexCoord1.xy;
    gl_Position = gl_ModelViewProjectionMatrix * gl_Vertex;
}
)";

// Fades to the background colour away from the centre.
const char* const kGroundFragment = R"(#version 120
uniform sampler2D casters;
uniform vec3 background;
varying vec2 at;
varying vec2 shadow;
void main()
{
    float shade = 0.0;
    for (int x = -2; x <= 2; ++x)
        for (int y = -2; y <= 2; ++y)
            shade += texture2D(casters, shadow + vec2(x, y) * 0.0045).a / 25.0;
    vec3 lit = vec3(0.150, 0.162, 0.185) * (1.0 - 0.62 * shade);
    gl_FragColor = vec4(mix(lit, background, smoothstep(0.15, 1.0, length(at))), 1.0);
}
)";

/// Draws the shadow casters for the lamp's camera only; other visitors draw them elsewhere.
class Casters : public osg::Node
{
public:
    Casters(osg::Group& lit, osgMidair::HapticOverlays& overlays) :
        _lit(&lit),
        _hands(overlays.get<osgMidair::HandsOverlay>())
    {
        setCullingActive(false);
    }
    void traverse(osg::NodeVisitor& visitor) override
    {
        osgUtil::CullVisitor* cull = visitor.asCullVisitor();
        osg::ref_ptr<osg::Group> lit;
        if (!cull || !_lit.lock(lit)) return;
        lit->accept(visitor);
        osg::ref_ptr<osgMidair::HandsOverlay> hands;
        if (!_hands.lock(hands)) return;
        const osg::MatrixList worlds = hands->getWorldMatrices();
        if (worlds.empty()) return;
        cull->pushModelViewMatrix(new osg::RefMatrix(worlds.front() * *cull->getModelViewMatrix()),
                                  osg::Transform::RELATIVE_RF);
        hands->accept(visitor);
        cull->popModelViewMatrix();
    }

private:
    const osg::observer_ptr<osg::Group> _lit;
    const osg::observer_ptr<osgMidair::HandsOverlay> _hands;
};

osg::ref_ptr<osg::Texture2D> shadowTexture()
{
    osg::ref_ptr<osg::Texture2D> texture = new osg::Texture2D;
    texture->setTextureSize(kShadowPixels, kShadowPixels);
    texture->setInternalFormat(GL_RGBA);
    texture->setFilter(osg::Texture::MIN_FILTER, osg::Texture::LINEAR);
    texture->setFilter(osg::Texture::MAG_FILTER, osg::Texture::LINEAR);
    texture->setWrap(osg::Texture::WRAP_S, osg::Texture::CLAMP_TO_BORDER);
    texture->setWrap(osg::Texture::WRAP_T, osg::Texture::CLAMP_TO_BORDER);
    texture->setBorderColor(osg::Vec4d(0.0, 0.0, 0.0, 0.0));
    return texture;
}

osg::ref_ptr<osg::Camera>
lampCamera(const osg::Vec3d& middle, double radius_m, osg::Texture& texture)
{
    osg::ref_ptr<osg::Camera> camera = new osg::Camera;
    camera->setName("shadow on the ground");
    camera->setReferenceFrame(osg::Transform::ABSOLUTE_RF);
    camera->setRenderOrder(osg::Camera::PRE_RENDER);
    camera->setRenderTargetImplementation(osg::Camera::FRAME_BUFFER_OBJECT);
    camera->setComputeNearFarMode(osg::CullSettings::DO_NOT_COMPUTE_NEAR_FAR);
    camera->setCullMask(kCasts);
    camera->setViewport(0, 0, kShadowPixels, kShadowPixels);
    camera->attach(osg::Camera::COLOR_BUFFER, &texture);
    camera->setClearColor(osg::Vec4(0.0F, 0.0F, 0.0F, 0.0F));
    osg::Vec3d way = kLamp;
    way.normalize();
    camera->setViewMatrixAsLookAt(middle + way * kFar_m, middle, osg::Y_AXIS);
    camera->setProjectionMatrixAsOrtho(-radius_m, radius_m, -radius_m, radius_m, 0.1, 2.0 * kFar_m);
    return camera;
}

osg::ref_ptr<osg::Geometry>
disc(const osg::Vec3d& middle, double radius_m, const osg::Camera& lamp, osg::Texture& texture)
{
    osg::ref_ptr<osg::Geometry> made = new osg::Geometry;
    osg::ref_ptr<osg::Vec3Array> vertices = new osg::Vec3Array;
    osg::ref_ptr<osg::Vec2Array> places = new osg::Vec2Array;
    osg::ref_ptr<osg::Vec2Array> shadows = new osg::Vec2Array;
    const osg::Matrixd toLamp = lamp.getViewMatrix() * lamp.getProjectionMatrix();
    for (int i = -1; i <= kRim; ++i)
    {
        const double angle = 2.0 * osg::PI * i / kRim;
        const osg::Vec2d at = i < 0 ? osg::Vec2d() : osg::Vec2d(std::cos(angle), std::sin(angle));
        const osg::Vec3d place = middle + osg::Vec3d(at.x(), at.y(), 0.0) * radius_m;
        const osg::Vec3d seen = place * toLamp;
        vertices->push_back(osg::Vec3(place));
        places->push_back(osg::Vec2(at));
        shadows->push_back(osg::Vec2(osg::Vec2d(0.5 * (seen.x() + 1.0), 0.5 * (seen.y() + 1.0))));
    }
    made->setVertexArray(vertices);
    made->setTexCoordArray(0, places);
    made->setTexCoordArray(1, shadows);
    made->addPrimitiveSet(
        new osg::DrawArrays(GL_TRIANGLE_FAN, 0, static_cast<GLsizei>(vertices->size())));
    osg::StateSet* state = made->getOrCreateStateSet();
    osg::ref_ptr<osg::Program> program = new osg::Program;
    program->addShader(new osg::Shader(osg::Shader::VERTEX, kGroundVertex));
    program->addShader(new osg::Shader(osg::Shader::FRAGMENT, kGroundFragment));
    state->setAttributeAndModes(program);
    state->setTextureAttributeAndModes(0, &texture);
    state->addUniform(new osg::Uniform("casters", 0));
    state->addUniform(new osg::Uniform(
        "background", osg::Vec3(kShownBackground.x(), kShownBackground.y(), kShownBackground.z())));
    state->setMode(GL_CULL_FACE, osg::StateAttribute::OFF);
    return made;
}

} // namespace

Ground::Ground(osg::Group& lit, osgMidair::HapticOverlays& overlays, double atMost_m) :
    _group(new osg::Group)
{
    overlays.setNodeMask(overlays.getNodeMask() & ~kCasts);
    osg::ComputeBoundsVisitor bounds(osg::NodeVisitor::TRAVERSE_ACTIVE_CHILDREN);
    bounds.setTraversalMask(kCasts);
    lit.accept(bounds);
    const osg::BoundingBox& box = bounds.getBoundingBox();
    if (!box.valid()) return;
    _height_m = std::min(static_cast<double>(box.zMin()) - kGap_m, atMost_m);
    const osg::Vec3d middle(box.center().x(), box.center().y(), _height_m);
    const double radius_m = std::max(kSmallest_m, 3.0 * static_cast<double>(box.radius()));
    const osg::ref_ptr<osg::Texture2D> texture = shadowTexture();
    const osg::ref_ptr<osg::Camera> lamp = lampCamera(middle, radius_m, *texture);
    lamp->addChild(new Casters(lit, overlays));
    _group->addChild(lamp);
    _group->addChild(disc(middle, radius_m, *lamp, *texture));
}

} // namespace midair::samples
