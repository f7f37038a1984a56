#pragma once

#include "haptics/surface/SurfacePaint.h"

#include <osg/Array>
#include <osg/Image>
#include <osg/Matrixd>
#include <osg/StateSet>
#include <osg/TexMat>
#include <osg/Texture>
#include <osg/ref_ptr>

#include <Eigen/Core>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

namespace midair::bridge
{

/// Source of an object's intensities, and the conversion from colours.
struct PaintOptions
{
    /// Source of intensities.
    enum Source
    {
        NONE,
        VERTEX_COLORS,
        TEXTURE ///< of unit 0
    };
    /// The part of a colour that becomes the intensity.
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
    double high = 1.0; ///< 0 .. 1; intensity where the channel is 1

    /// The intensity of \a color, 0 .. 1.
    float intensity(const osg::Vec4& color) const;

    bool operator==(const PaintOptions& other) const
    {
        return source == other.source && channel == other.channel && low == other.low &&
               high == other.high;
    }
};

/// The texture and texture matrix of unit 0 on the path to a drawable.
struct PaintState
{
    const osg::Texture* texture = nullptr;
    const osg::TexMat* matrix = nullptr;
    /// the graphics card makes the coordinates (TexGen); none: not specified
    std::optional<bool> isGenerated;

    /// Applies the texture and matrix of \a state, which may be null.
    void apply(const osg::StateSet* state);
};

/// Keeps the images of textures: OSG releases a texture's image after drawing if the Optimizer (as
/// in osgviewer) has processed the scene.
class PaintImages
{
public:
    /// Returns a number that is constant while the texture has the same image; 0: it never had one.
    /// Allocates only for a new texture.
    std::uint64_t version(const osg::Texture& texture);

    /// Returns the intensities of a texture's image; null, with the reason in \a warning, if it
    /// can't be read.
    std::shared_ptr<const haptics::PaintImage>
    get(const osg::Texture& texture, const PaintOptions& options, std::string& warning);

    /// Drops textures that nothing else refers to.
    void forgetUnused();

private:
    /// A texture and its last image.
    struct Known
    {
        osg::ref_ptr<const osg::Texture> texture; ///< kept alive, so that its address isn't reused
        osg::ref_ptr<const osg::Image> image;
        unsigned int modified = 0;
        std::uint64_t version = 0;
    };

    Known& look(const osg::Texture& texture);

    std::unordered_map<const osg::Texture*, Known> _known;
    std::uint64_t _nextVersion = 1;
};

/// One intensity per vertex from \a colors; empty if they can't be used.
std::vector<float>
vertexIntensities(const osg::Array& colors, std::size_t vertices, const PaintOptions& options);

/// Texture coordinates, transformed by \a matrix (may be null), 2 x v; empty if not every vertex
/// has one.
Eigen::Matrix2Xd
textureCoordinates(const osg::Array& array, std::size_t vertices, const osg::Matrixd* matrix);

} // namespace midair::bridge
