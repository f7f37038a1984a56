#include "haptics/base/Units.h"
#include "plugin/overlays/OverlayPart.h"
#include "plugin/overlays/drawing/DiscGeometry.h"

#include <osgMidair/ArrayGhost>
#include <osgMidair/ColorMap>

#include <osg/Geometry>
#include <osg/Math>
#include <osgGA/GUIEventAdapter>

#include <Eigen/Geometry>

#include <cmath>

namespace osgMidair
{

namespace
{

const OverlayNumber kArrayGhostOpacity =
    overlayNumber<ArrayGhost, &ArrayGhost::setOpacity, &ArrayGhost::getOpacity>(
        "arrayOpacity", "opacity of transducers that face the eye", {0.0, 1.0});
const OverlayRegistration
    kArrayGhostRegistration({3,
                             "Array",
                             "array",
                             "the array",
                             "the transducers: hue is phase, strength amplitude",
                             osgGA::GUIEventAdapter::KEY_F4,
                             10,
                             makeOverlay<ArrayGhost>,
                             {kArrayGhostOpacity}});

using midair::haptics::TransducerArray;

const char* const kArrayGhostVertexSource = R"(#version 120
varying vec2 corner;
varying vec4 color;
varying float facing; // cosine between the normal and the way to the eye
void main()
{
    corner = gl_MultiTexCoord0.xy;
    color = gl_Color;
    vec4 eye = gl_ModelViewMatrix * gl_Vertex;
    facing = dot(normalize(gl_NormalMatrix * gl_Normal), -normalize(eye.xyz));
    // Seen from behind: out of the picture.
    gl_Position = facing < -0.02 ? vec4(2.0, 2.0, 2.0, 1.0) : gl_ProjectionMatrix * eye;
}
)";

const char* const kArrayGhostFragmentSource = R"(#version 120
uniform float opacity;
varying vec2 corner;
varying vec4 color;
varying float facing;
void main()
{
    float r2 = dot(corner, corner);
    float edge = min(0.8, 2.0 * fwidth(r2) + 1e-4);
    float inside = 1.0 - smoothstep(1.0 - edge, 1.0, r2);
    float seen = smoothstep(-0.02, 0.14, facing);
    float drive = color.a;
    vec3 idle = vec3(0.16, 0.17, 0.20);
    gl_FragColor = vec4(mix(idle, color.rgb, drive) * mix(0.35, 1.0, r2 < 0.5 ? 1.0 : 0.75), opacity * seen * inside);
}
)";

/// Returns the radius of the drawn discs: 0.44 times the distance from the first transducer to its
/// nearest neighbour.
double discRadius(const TransducerArray& array)
{
    double nearest = 0.010;
    if (array.size() > 1)
        nearest = std::sqrt(
            (array.positions.rightCols(array.size() - 1).colwise() - array.positions.col(0))
                .colwise()
                .squaredNorm()
                .minCoeff());
    return 0.44 * nearest;
}

/// Adds the outline of transducers \a first to \a last - 1 as four lines, if they lie in one plane.
void addBoard(const TransducerArray& array, int first, int last, osg::Vec3Array& lines)
{
    if (last - first < 4) return;
    const Eigen::Matrix3Xd d =
        array.positions.middleCols(first, last - first).colwise() - array.positions.col(first);
    const Eigen::Vector3d normal = array.normals.col(first);
    if ((normal.transpose() * d).cwiseAbs().maxCoeff() > 1e-3) return;
    Eigen::Index nearest = 0;
    d.rightCols(d.cols() - 1).colwise().squaredNorm().minCoeff(&nearest);
    const Eigen::Vector3d step = d.col(nearest + 1);
    const Eigen::Vector3d u = step.normalized();
    const Eigen::Vector3d v = normal.cross(u).normalized();
    const double margin = 0.5 * step.norm();
    const Eigen::RowVectorXd along = u.transpose() * d;
    const Eigen::RowVectorXd across = v.transpose() * d;
    const auto corner = [&](double a, double b)
    { return osgVec(array.positions.col(first) + a * u + b * v); };
    const double a0 = along.minCoeff() - margin;
    const double a1 = along.maxCoeff() + margin;
    const double b0 = across.minCoeff() - margin;
    const double b1 = across.maxCoeff() + margin;
    const osg::Vec3 corners[] = {corner(a0, b0), corner(a1, b0), corner(a1, b1), corner(a0, b1)};
    for (int k = 0; k < 4; ++k)
    {
        lines.push_back(corners[k]);
        lines.push_back(corners[(k + 1) % 4]);
    }
}

} // namespace

/// Draws a disc for each transducer and the outlines of their boards.
class ArrayGhost::Part : public OverlayPart
{
public:
    Part() :
        discs(makeDiscs()),
        boards(new osg::Geometry),
        opacity(new osg::Uniform("opacity", 0.6F))
    {
        osg::StateSet* state = discs->getOrCreateStateSet();
        state->setAttributeAndModes(
            makeProgram("osgMidair array", kArrayGhostVertexSource, kArrayGhostFragmentSource));
        state->addUniform(opacity);
        drawTranslucent(*discs, GHOST_BIN);
        const osg::Vec4 lineColor(0.55F, 0.60F, 0.68F, 0.45F);
        boards->setColorArray(new osg::Vec4Array(1, &lineColor), osg::Array::BIND_OVERALL);
        drawTranslucent(*boards, GHOST_BIN);
    }

    void setArray(const std::shared_ptr<const TransducerArray>& array,
                  const midair::haptics::Medium& /*medium*/) override
    {
        resizeDiscs(*discs, array->size());
        osg::Vec3Array& vertices = verticesOf(*discs);
        osg::Vec3Array& normals = normalsOf(*discs);
        osg::Vec4ubArray& colors = colorsOf(*discs);
        const double radius = discRadius(*array);
        for (int i = 0; i < array->size(); ++i)
        {
            const Eigen::Vector3d normal = array->normals.col(i);
            const Eigen::Vector3d u = normal.unitOrthogonal() * radius;
            const Eigen::Vector3d v = normal.cross(u);
            const Eigen::Vector3d position = array->positions.col(i);
            for (int k = 0; k < 3; ++k)
            {
                vertices[3 * i + k] =
                    osgVec(position + kDiscCorners[k][0] * u + kDiscCorners[k][1] * v);
                normals[3 * i + k] = osgVec(normal);
                colors[3 * i + k] = osg::Vec4ub(0, 0, 0, 0);
            }
        }
        showChanges(*discs);

        osg::ref_ptr<osg::Vec3Array> lines = new osg::Vec3Array;
        for (int first = 0; first < array->size();)
        {
            int last = first + 1;
            const bool several = static_cast<int>(array->board.size()) == array->size();
            while (last < array->size() && (!several || array->board[last] == array->board[first]))
                ++last;
            addBoard(*array, first, last, *lines);
            first = last;
        }
        boards->setVertexArray(lines);
        boards->removePrimitiveSet(0, boards->getNumPrimitiveSets());
        boards->addPrimitiveSet(
            new osg::DrawArrays(GL_LINES, 0, static_cast<GLsizei>(lines->size())));
        boards->dirtyBound();
    }

    void setResult(const std::shared_ptr<const midair::bridge::HologramResult>& result) override
    {
        osg::Vec4ubArray& colors = colorsOf(*discs);
        if (static_cast<Eigen::Index>(colors.size()) != 3 * result->played().size())
            return; // a result for another array; its setArray() follows
        for (Eigen::Index i = 0; i < result->played().size(); ++i)
        {
            const std::complex<float> q = result->played()[i];
            const float turn = std::arg(q) / static_cast<float>(midair::base::kTwoPi);
            const osg::Vec4ub color =
                bytes(ColorMap::phase().color(turn - std::floor(turn)), std::abs(q));
            for (int k = 0; k < 3; ++k)
                colors[3 * i + k] = color;
        }
        colors.dirty();
    }

    osg::ref_ptr<osg::Geometry> discs;
    osg::ref_ptr<osg::Geometry> boards;
    osg::ref_ptr<osg::Uniform> opacity;
};

ArrayGhost::ArrayGhost() :
    Overlay(std::make_unique<Part>()),
    _part(static_cast<Part&>(OverlayPart::of(*this)))
{
    addChild(_part.boards);
    addChild(_part.discs);
}

ArrayGhost::~ArrayGhost() = default;

void ArrayGhost::setOpacity(float opacity)
{
    _opacity = opacity;
    _part.opacity->set(opacity);
}

} // namespace osgMidair
