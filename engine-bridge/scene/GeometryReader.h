#pragma once

#include "engine-bridge/scene/GeometryCopy.h"
#include "engine-bridge/scene/PaintReader.h"
#include "haptics/surface/SurfacePaint.h"

#include <osg/Drawable>
#include <osg/ref_ptr>

#include <Eigen/Core>

#include <memory>
#include <string>
#include <vector>

namespace osgText
{
class TextBase;
}

namespace midair::bridge
{

/// One drawable's triangles (lines and points as triangles without area, see haptics::TriangleMesh)
/// and paint.
struct MeshPiece
{
    Eigen::Matrix3Xd vertices;
    std::vector<Eigen::Vector3i> triangles;
    std::vector<float> intensity; ///< one per vertex, or empty
    Eigen::Matrix2Xd coordinates; ///< texture coordinates, one per vertex, or empty
    std::shared_ptr<const haptics::PaintImage> image;
};

/// Makes the piece of a complete copy, in its own coordinates. Adds parts that can't be rendered to
/// \a warnings. Any thread.
MeshPiece pieceOf(const GeometryCopy& copy, std::vector<std::string>& warnings);

/// Reads drawables: geometries into copies to be filled later, others at once. Adds parts that
/// can't be rendered to \a warnings, and the objects read to \a sources, which keeps them alive.
class GeometryReader
{
public:
    GeometryReader(const PaintOptions& paint,
                   PaintImages& images,
                   std::vector<std::string>& warnings,
                   std::vector<osg::ref_ptr<const osg::Referenced>>& sources) :
        _paint(paint),
        _images(images),
        _warnings(warnings),
        _sources(sources)
    {
    }

    /// Returns an empty copy of \a geometry; without vertices if nothing of it can be rendered.
    GeometryCopy begin(const osg::Geometry& geometry, const PaintState& state);
    /// Reads a drawable other than a geometry, in its own coordinates.
    MeshPiece readOther(const osg::Drawable& drawable);

private:
    void beginPaint(const osg::Geometry& geometry, const PaintState& state, SurfaceCopy& surface);
    void readText(const osgText::TextBase& text, MeshPiece& piece);
    void checkSkinning(const osg::Geometry& geometry);

    const PaintOptions& _paint;
    PaintImages& _images;
    std::vector<std::string>& _warnings;
    std::vector<osg::ref_ptr<const osg::Referenced>>& _sources;
};

/// "Geometry 'lid'", for messages.
std::string quoted(const osg::Object& object);

/// Returns the object that moves the vertices of a skinned or morphing geometry; null if there is
/// none, or OSG has not chosen it yet.
const osg::Object* deformerOf(const osg::Geometry& geometry);

} // namespace midair::bridge
