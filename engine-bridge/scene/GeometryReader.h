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

/// One drawable's triangles.
struct MeshPiece
{
    Eigen::Matrix3Xd vertices;
    std::vector<Eigen::Vector3i> triangles;
    std::vector<float> intensity; ///< one a vertex, or empty
    Eigen::Matrix2Xd coordinates; ///< one a vertex, or empty
    std::shared_ptr<const haptics::PaintImage> image;
};

/// Reads drawables. What cannot be felt of them goes to \a warnings, and what was read from is kept
/// alive in \a sources.
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

    /// In the drawable's own coordinates.
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

/// The object that moves the vertices of a skinned or morphing geometry; null where nothing does,
/// or where it is not chosen yet.
const osg::Object* deformerOf(const osg::Geometry& geometry);

} // namespace midair::bridge
