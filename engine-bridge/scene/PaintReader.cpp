#include "engine-bridge/scene/PaintReader.h"

#include <osg/TexGen>

#include <algorithm>

namespace midair::bridge
{

namespace
{

using haptics::PaintImage;

/// Reads colours from any of OSG's usual array types, each 0 .. 1.
class ColorReader : public osg::ConstArrayVisitor
{
public:
    std::vector<osg::Vec4> colors;

    void apply(const osg::Vec4Array& a) override { read(a, 1.0f, true); }
    void apply(const osg::Vec3Array& a) override { read(a, 1.0f, false); }
    void apply(const osg::Vec4dArray& a) override { read(a, 1.0f, true); }
    void apply(const osg::Vec3dArray& a) override { read(a, 1.0f, false); }
    void apply(const osg::Vec4ubArray& a) override { read(a, 1.0f / 255.0f, true); }
    void apply(const osg::Vec3ubArray& a) override { read(a, 1.0f / 255.0f, false); }

private:
    template<typename A>
    void read(const A& array, float scale, bool alpha)
    {
        colors.reserve(array.size());
        for (const auto& c : array)
            colors.emplace_back(static_cast<float>(c[0]) * scale,
                                static_cast<float>(c[1]) * scale,
                                static_cast<float>(c[2]) * scale,
                                alpha ? static_cast<float>(c[3]) * scale : 1.0f);
    }
};

/// Reads texture coordinates from OSG's usual array types.
class CoordinateReader : public osg::ConstArrayVisitor
{
public:
    Eigen::Matrix2Xd coordinates;

    void apply(const osg::Vec2Array& a) override { read(a); }
    void apply(const osg::Vec3Array& a) override { read(a); }
    void apply(const osg::Vec4Array& a) override { read(a); }
    void apply(const osg::Vec2dArray& a) override { read(a); }
    void apply(const osg::Vec3dArray& a) override { read(a); }

private:
    template<typename A>
    void read(const A& array)
    {
        coordinates.resize(2, static_cast<Eigen::Index>(array.size()));
        for (std::size_t i = 0; i < array.size(); ++i)
            coordinates.col(static_cast<Eigen::Index>(i)) << static_cast<double>(array[i][0]),
                static_cast<double>(array[i][1]);
    }
};

PaintImage::Wrap wrapOf(osg::Texture::WrapMode mode)
{
    switch (mode)
    {
    case osg::Texture::REPEAT:
        return PaintImage::Wrap::REPEAT;
    case osg::Texture::MIRROR:
        return PaintImage::Wrap::MIRROR;
    default:
        return PaintImage::Wrap::CLAMP;
    }
}

std::string quoted(const osg::Texture& texture)
{
    std::string name = texture.getName();
    if (name.empty() && texture.getImage(0)) name = texture.getImage(0)->getFileName();
    return std::string(texture.className()) + (name.empty() ? std::string() : " '" + name + "'");
}

} // namespace

float PaintOptions::intensity(const osg::Vec4& color) const
{
    const float value = channel == BRIGHTNESS
                            ? (color.r() + color.g() + color.b()) / 3.0f * color.a()
                            : color[channel - RED];
    const double share = std::clamp(static_cast<double>(value), 0.0, 1.0);
    return static_cast<float>(std::clamp(low + (high - low) * share, 0.0, 1.0));
}

void PaintState::apply(const osg::StateSet* state)
{
    if (!state) return;
    const auto* found = state->getTextureAttribute(0, osg::StateAttribute::TEXTURE);
    if (found) texture = static_cast<const osg::Texture*>(found);
    const auto* turned = state->getTextureAttribute(0, osg::StateAttribute::TEXMAT);
    if (turned) matrix = static_cast<const osg::TexMat*>(turned);
    const osg::StateAttribute::GLModeValue generated = state->getTextureMode(0, GL_TEXTURE_GEN_S);
    if (!(generated & osg::StateAttribute::INHERIT))
        isGenerated = (generated & osg::StateAttribute::ON) != 0;
}

PaintImages::Known& PaintImages::look(const osg::Texture& texture)
{
    Known& known = _known[&texture];
    known.texture = &texture;
    const osg::Image* image = texture.getImage(0);
    if (!image) image = known.image.get(); // OSG has released it
    if (!image || (image == known.image && image->getModifiedCount() == known.modified))
        return known;
    known.image = image;
    known.modified = image->getModifiedCount();
    known.version = _nextVersion++;
    return known;
}

std::uint64_t PaintImages::version(const osg::Texture& texture)
{
    return look(texture).version;
}

std::shared_ptr<const PaintImage>
PaintImages::get(const osg::Texture& texture, const PaintOptions& options, std::string& warning)
{
    const osg::Image* image = look(texture).image.get();
    if (!image || !image->data() || image->s() <= 0 || image->t() <= 0)
    {
        warning =
            quoted(texture) +
            " has no image in memory (not loaded, or released after drawing); it is felt unpainted";
        return nullptr;
    }
    if (image->isCompressed() || image->r() > 1)
    {
        warning = quoted(texture) + (image->r() > 1 ? " is not a 2D image" : " is compressed") +
                  "; it is felt unpainted";
        return nullptr;
    }
    auto paint = std::make_shared<PaintImage>();
    paint->width = image->s();
    paint->height = image->t();
    paint->wrapU = wrapOf(texture.getWrap(osg::Texture::WRAP_S));
    paint->wrapV = wrapOf(texture.getWrap(osg::Texture::WRAP_T));
    paint->values.reserve(static_cast<std::size_t>(paint->width) *
                          static_cast<std::size_t>(paint->height));
    // OSG draws row 0 at v = 0, regardless of the image's origin.
    for (int t = 0; t < paint->height; ++t)
        for (int s = 0; s < paint->width; ++s)
            paint->values.push_back(options.intensity(
                image->getColor(static_cast<unsigned int>(s), static_cast<unsigned int>(t))));
    return paint;
}

void PaintImages::forgetUnused()
{
    for (auto it = _known.begin(); it != _known.end();)
        it = it->second.texture->referenceCount() == 1 ? _known.erase(it) : std::next(it);
}

std::vector<float>
vertexIntensities(const osg::Array& colors, std::size_t vertices, const PaintOptions& options)
{
    std::vector<float> intensities;
    ColorReader reader;
    colors.accept(reader);
    const bool each = colors.getBinding() == osg::Array::BIND_PER_VERTEX;
    if (reader.colors.size() < (each ? vertices : 1)) return intensities;
    if (!each && colors.getBinding() != osg::Array::BIND_OVERALL) return intensities;
    intensities.reserve(vertices);
    for (std::size_t i = 0; i < vertices; ++i)
        intensities.push_back(options.intensity(reader.colors[each ? i : 0]));
    return intensities;
}

Eigen::Matrix2Xd
textureCoordinates(const osg::Array& array, std::size_t vertices, const osg::Matrixd* matrix)
{
    CoordinateReader reader;
    array.accept(reader);
    if (reader.coordinates.cols() < static_cast<Eigen::Index>(vertices)) return {};
    Eigen::Matrix2Xd uv = reader.coordinates.leftCols(static_cast<Eigen::Index>(vertices));
    for (Eigen::Index i = 0; matrix && i < uv.cols(); ++i)
    {
        const osg::Vec3d turned = osg::Vec3d(uv(0, i), uv(1, i), 0.0) * *matrix;
        uv.col(i) << turned.x(), turned.y();
    }
    return uv;
}

} // namespace midair::bridge
