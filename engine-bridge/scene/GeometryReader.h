#pragma once

#include "engine-bridge/scene/PaintReader.h"
#include "haptics/surface/SurfacePaint.h"

#include <osg/Drawable>
#include <osg/Matrixd>
#include <osg/ref_ptr>

#include <Eigen/Core>

#include <memory>
#include <string>
#include <vector>

namespace midair::bridge
{

/// One drawable's triangles and paint.
struct MeshPiece
{
    Eigen::Matrix3Xd vertices;
    std::vector<Eigen::Vector3i> triangles;
    std::vector<float> intensity; ///< one per vertex, or empty
    Eigen::Matrix2Xd coordinates; ///< texture coordinates, one per vertex, or empty
    std::shared_ptr<const haptics::PaintImage> image;
};

/// Reads the triangles and the paint of drawables. Adds what can't be felt to \a warnings, and the
/// objects that it read to \a sources, which keeps them alive.
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

    /// Reads \a drawable, in its own coordinates.
    MeshPiece read(const osg::Drawable& drawable, const PaintState& state);

private:
    void readGeometry(const osg::Geometry& geometry, const PaintState& state, MeshPiece& piece);
    void readPaint(const osg::Geometry& geometry, const PaintState& state, MeshPiece& piece);
    void readTexture(const osg::Geometry& geometry, const PaintState& state, MeshPiece& piece);
    void checkSkinning(const osg::Geometry& geometry);

    const PaintOptions& _paint;
    PaintImages& _images;
    std::vector<std::string>& _warnings;
    std::vector<osg::ref_ptr<const osg::Referenced>>& _sources;
};

/// "Geometry 'lid'", for messages.
std::string quoted(const osg::Object& object);

/// The object that moves the vertices of a skinned or morphing geometry; null if there is none, or
/// OSG has not chosen it yet.
const osg::Object* deformerOf(const osg::Geometry& geometry);

} // namespace midair::bridge
