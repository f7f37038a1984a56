#include "plugin/overlays/drawing/HandGeometry.h"

#include "plugin/overlays/drawing/DiscGeometry.h"

#include <osg/BlendFunc>
#include <osg/CullFace>
#include <osg/Depth>

#include <algorithm>
#include <cmath>
#include <utility>

namespace osgMidair
{

namespace
{

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr int kHandBin = -10; ///< before objects that they may hide
const osg::Vec3f kSkinColor(0.80F, 0.60F, 0.49F);
const osg::Vec3f kWarm(0.80F, 0.49F, 0.41F); ///< of fingertips and knuckles
const osg::Vec3f kTouchingSkin(1.00F, 0.58F, 0.20F);

// The texture coordinates of a nail are along and across it, 1 at its edge, and how far it is up.
const char* const kHandVertex = R"(#version 120
varying vec3 eye;
varying vec3 normal;
varying vec3 nail;
varying vec3 color;
void main()
{
    vec4 at = gl_ModelViewMatrix * gl_Vertex;
    eye = at.xyz;
    normal = gl_NormalMatrix * gl_Normal;
    nail = gl_MultiTexCoord0.xyz;
    color = gl_Color.rgb;
    gl_Position = gl_ProjectionMatrix * at;
}
)";

const char* const kHandFragment = R"(#version 120
uniform float osgMidairHides;
varying vec3 eye;
varying vec3 normal;
varying vec3 nail;
varying vec3 color;
void main()
{
    vec3 n = normalize(normal);
    vec3 away = -normalize(eye);
    float onNail = nail.z > 0.0 ? 1.0 - smoothstep(0.82, 1.0, length(nail.xy)) : 0.0;
    vec3 skin = mix(color, vec3(0.90, 0.72, 0.66), 0.75 * onNail);
    // Light goes a little way through skin: around edges, and there it is red.
    vec3 light = mix(vec3(0.21, 0.17, 0.16), vec3(0.30, 0.30, 0.32), 0.5 + 0.5 * n.y);
    float gloss = 0.0;
    for (int i = 0; i < 2; ++i)
    {
        vec4 from = gl_LightSource[i].position;
        vec3 way = normalize(from.w == 0.0 ? from.xyz : from.xyz - eye);
        float facing = dot(n, way);
        vec3 reached = clamp((facing + vec3(0.30, 0.16, 0.12)) / vec3(1.30, 1.16, 1.12), 0.0, 1.0);
        light += gl_LightSource[i].diffuse.rgb * reached;
        float shine = max(dot(n, normalize(way + away)), 0.0);
        gloss += gl_LightSource[i].diffuse.g * mix(0.09 * pow(shine, 16.0), 0.40 * pow(shine, 60.0), onNail);
    }
    float rim = pow(1.0 - max(dot(n, away), 0.0), 3.0);
    vec3 seen = skin * light + gloss + 0.10 * rim * vec3(1.0, 0.75, 0.65);
    gl_FragColor = osgMidairHides > 0.5 ? vec4(0.0) : vec4(min(seen, 1.0), 1.0);
}
)";

/// The bone at a fingertip, and how closely a vertex follows it.
osg::Vec3 nailOf(const HandMesh& mesh, std::size_t vertex)
{
    constexpr double kHalfLength_m = 6.5e-3;
    constexpr double kHalfWidth_m = 5.2e-3;
    constexpr double kBehind_m = 0.5e-3; ///< the middle of the tip's ball
    const HandMesh::Skin& skin = mesh.skin[vertex];
    for (int finger = 0; finger < kHandChains; ++finger)
    {
        if (skin.frames[0] != jointFrame(finger, kChainBones - 1) + 1) continue;
        const auto last = static_cast<std::size_t>(chainJoint(finger, kChainBones));
        const Vector3d way = (mesh.joints[last] - mesh.joints[last - 1]).normalized();
        // A thumb's nail faces sideways.
        const Vector3d aside(finger == midair::bridge::THUMB ? -0.5 : 0.0, 1.0, 0.0);
        const Vector3d up = (aside - aside.dot(way) * way).normalized();
        const Vector3d from = mesh.vertices[vertex].cast<double>() - mesh.joints[last];
        const double width_m = kHalfWidth_m * mesh.radii_m[last] / 7e-3;
        return {static_cast<float>((from.dot(way) + kBehind_m) / kHalfLength_m),
                static_cast<float>(from.dot(way.cross(up)) / width_m),
                static_cast<float>(from.dot(up))};
    }
    return {9.0F, 9.0F, -1.0F};
}

/// Warmth of the skin's colour, 0 .. 1: at fingertips, and around joints.
float warmth(const HandMesh& mesh, std::size_t vertex)
{
    double most = 0.0;
    for (int finger = 0; finger < kHandChains; ++finger)
        for (int k = 0; k <= kChainBones; ++k)
        {
            const auto joint = static_cast<std::size_t>(chainJoint(finger, k));
            const double away = (mesh.vertices[vertex].cast<double>() - mesh.joints[joint]).norm() /
                                mesh.radii_m[joint];
            most = std::max(most, (k == kChainBones ? 0.8 : 0.45) * (2.0 - away));
        }
    return static_cast<float>(std::clamp(most, 0.0, 1.0));
}

/// The constant data of a hand, for the graphics card.
struct Painted
{
    std::vector<osg::Vec3> nails;
    std::vector<osg::Vec4ub> colors;
    std::vector<osg::Vec4ub> touching;
};

const Painted& painted()
{
    static const Painted all = []
    {
        Painted made;
        const HandMesh& mesh = handMesh();
        for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
        {
            made.nails.push_back(nailOf(mesh, i));
            const float warm = warmth(mesh, i);
            const osg::Vec3f color = kSkinColor * (1.0F - warm) + kWarm * warm;
            made.colors.push_back(bytes(color, 1.0F));
            made.touching.push_back(bytes(kTouchingSkin * 0.8F + color * 0.2F, 1.0F));
        }
        return made;
    }();
    return all;
}

osg::ref_ptr<osg::DrawElementsUInt> trianglesOf(bool isLeft)
{
    const std::vector<unsigned int>& corners = handMesh().triangles;
    osg::ref_ptr<osg::DrawElementsUInt> made =
        new osg::DrawElementsUInt(GL_TRIANGLES, corners.begin(), corners.end());
    if (isLeft) // mirrored, so that they turn the other way
        for (std::size_t i = 0; i + 2 < made->size(); i += 3)
            std::swap((*made)[i + 1], (*made)[i + 2]);
    return made;
}

} // namespace

void drawHands(osg::StateSet& state)
{
    state.setMode(GL_BLEND, osg::StateAttribute::OFF);
    state.setAttributeAndModes(new osg::Depth(osg::Depth::LESS, 0.0, 1.0, true));
    state.setRenderBinDetails(kHandBin, "RenderBin");
}

HandGeometry::HandGeometry(bool isLeft) :
    _isLeft(isLeft),
    _geometry(makeChanging(trianglesOf(isLeft)))
{
    const Painted& look = painted();
    verticesOf(*_geometry).resize(look.colors.size());
    osg::ref_ptr<osg::Vec3Array> normals = new osg::Vec3Array(look.colors.size());
    _geometry->setNormalArray(normals, osg::Array::BIND_PER_VERTEX);
    const osg::ref_ptr<osg::Vec3Array> nails =
        new osg::Vec3Array(look.nails.begin(), look.nails.end());
    _geometry->setTexCoordArray(0, nails);
    _geometry->setCullingActive(false);
    osg::StateSet& state = *_geometry->getOrCreateStateSet();
    state.setAttributeAndModes(makeProgram("osgMidair hand", kHandVertex, kHandFragment));
    state.setAttributeAndModes(new osg::CullFace(osg::CullFace::BACK));
    drawHands(state);
    colorsOf(*_geometry).assign(look.colors.begin(), look.colors.end());
    hide();
}

void HandGeometry::paint(const TouchingBones& touching)
{
    if (touching == _painted) return;
    _painted = touching;
    const Painted& look = painted();
    const HandMesh& mesh = handMesh();
    osg::Vec4ubArray& colors = colorsOf(*_geometry);
    for (std::size_t i = 0; i < colors.size(); ++i)
        colors[i] = touching[mesh.skin[i].bone] ? look.touching[i] : look.colors[i];
    colors.dirty();
}

bool HandGeometry::show(const std::vector<midair::bridge::HandCapsule>& capsules,
                        int hand,
                        const TouchingBones& touching)
{
    if (!_skin.move(capsules, hand, verticesOf(*_geometry), normalsOf(*_geometry)))
    {
        hide();
        return false;
    }
    paint(touching);
    verticesOf(*_geometry).dirty();
    normalsOf(*_geometry).dirty();
    _geometry->dirtyBound();
    _geometry->setNodeMask(~0U);
    return true;
}

} // namespace osgMidair
