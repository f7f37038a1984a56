#pragma once

#include "haptics/surface/SurfacePaint.h"

#include <osg/Geometry>
#include <osg/Image>
#include <osg/StateSet>
#include <osg/TexMat>
#include <osg/Texture>
#include <osg/ref_ptr>

#include <Eigen/Core>

#include <cstdint>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

namespace midair::bridge
{

/// What an object's intensities are painted from, and how.
struct PaintOptions
{
    enum Source
    {
        NONE,
        VERTEX_COLORS,
        TEXTURE ///< of unit 0
    };
    enum Channel
    {
        BRIGHTNESS, ///< mean of red, green and blue, times alpha
        RED,
        GREEN,
        BLUE,
        ALPHA
    };

    Source source = NONE;
    Channel channel = BRIGHTNESS;
    double low = 0.0;  ///< 0 .. 1; intensity where the channel is 0
    double high = 1.0; ///< 0 .. 1; intensity where it is 1

    float intensity(const osg::Vec4& color) const;

    bool operator==(const PaintOptions& other) const
    {
        return source == other.source && channel == other.channel && low == other.low &&
               high == other.high;
    }
};

/// The parts of the state on the path down to a drawable that decide how it is painted.
struct PaintState
{
    const osg::Texture* texture = nullptr;
    const osg::TexMat* matrix = nullptr;

    void apply(const osg::StateSet* state);
};

/// Pictures of textures, kept: OSG lets go of a texture's image once it is drawn, when the
/// Optimizer (osgviewer's too) has been at the scene.
class PaintImages
{
public:
    /// Equal while the texture shows the same picture; 0: there never was one. Allocates only for
    /// what is new.
    std::uint64_t version(const osg::Texture& texture);

    /// The picture of a texture; null, with the reason in \a warning, where it cannot be read.
    std::shared_ptr<const haptics::PaintImage>
    get(const osg::Texture& texture, const PaintOptions& options, std::string& warning);

    /// Forgets textures that nobody else holds any more.
    void forgetUnused();

private:
    struct Known
    {
        osg::ref_ptr<const osg::Texture> texture; ///< alive, so that its address stays its own
        osg::ref_ptr<const osg::Image> image;
        unsigned int modified = 0;
        std::uint64_t version = 0;
    };

    Known& look(const osg::Texture& texture);

    std::unordered_map<const osg::Texture*, Known> _known;
    std::uint64_t _nextVersion = 1;
};

/// One intensity a vertex by the colours of \a geometry; empty where it has none that can be used.
std::vector<float>
vertexIntensities(const osg::Geometry& geometry, std::size_t vertices, const PaintOptions& options);

/// Texture coordinates of unit 0 through \a matrix (may be null), 2 x v; empty where there are none
/// for every vertex.
Eigen::Matrix2Xd
textureCoordinates(const osg::Geometry& geometry, std::size_t vertices, const osg::TexMat* matrix);

} // namespace midair::bridge
