#include "engine-bridge/scene/MeshExtractor.h"

#include "engine-bridge/scene/GeometryReader.h"
#include "engine-bridge/scene/SubtreeReading.h"
#include "engine-bridge/scene/drawn/TextOutlines.h"

#include <osg/Geometry>

#include <cstring>

namespace midair::bridge
{

namespace
{

void mix(std::uint64_t& hash, std::uint64_t value)
{
    hash = (hash ^ value) * 0x9E3779B97F4A7C15ull;
    hash ^= hash >> 29;
}

void mix(std::uint64_t& hash, const void* pointer)
{
    mix(hash, static_cast<std::uint64_t>(reinterpret_cast<std::uintptr_t>(pointer)));
}

void mix(std::uint64_t& hash, const osg::Matrixd& matrix)
{
    for (int i = 0; i < 16; ++i)
    {
        std::uint64_t bits = 0;
        std::memcpy(&bits, matrix.ptr() + i, sizeof bits);
        mix(hash, bits);
    }
}

void mix(std::uint64_t& hash, const osg::BufferData* data)
{
    mix(hash, static_cast<const void*>(data));
    if (data) mix(hash, static_cast<std::uint64_t>(data->getModifiedCount()));
}

/// Computes the state and the fingerprints of a subtree.
class InspectWalk : public SubtreeWalk
{
public:
    void begin(SubtreeState& state)
    {
        _state = &state;
        state.parts.clear();
        state.still.clear();
    }

protected:
    MeshFingerprint& print() { return _state->parts[part].fingerprint; }

    void open(std::uint64_t key, const osg::Matrixd& toRoot) override
    {
        _state->parts.push_back({key, {}, toRoot});
    }

    void enter(osg::Node& node) override { mix(print().topology, static_cast<const void*>(&node)); }

    void still(osg::Transform& node, const osg::Matrixd& local) override
    {
        _state->still.emplace_back(&node, local);
        mix(print().vertices, local);
    }

    void visit(osg::Drawable& drawable) override
    {
        mix(print().topology, static_cast<const void*>(&drawable));
        const osg::Geometry* geometry = drawable.asGeometry();
        if (!geometry) return mixText(drawable);
        const osg::Array* vertices = geometry->getVertexArray();
        mix(print().topology,
            static_cast<std::uint64_t>(vertices ? vertices->getNumElements() : 0));
        mix(print().topology, static_cast<const void*>(deformerOf(*geometry)));
        mix(print().vertices, static_cast<const osg::BufferData*>(vertices));
        for (const auto& primitives : geometry->getPrimitiveSetList())
            mix(print().topology, static_cast<const osg::BufferData*>(primitives.get()));
        if (options->paint.source == PaintOptions::VERTEX_COLORS)
            mix(print().paint, static_cast<const osg::BufferData*>(geometry->getColorArray()));
        if (options->paint.source == PaintOptions::TEXTURE) mixTexture(*geometry);
    }

private:
    void mixText(const osg::Drawable& drawable)
    {
        const osgText::TextBase* text = textOf(drawable);
        if (!text) return;
        // Other characters mean other lines.
        mix(print().topology, static_cast<const osg::BufferData*>(text->getCoords().get()));
        mix(print().topology, static_cast<std::uint64_t>(followsScreen(*text)));
        mix(print().vertices, text->getMatrix());
    }

    void mixTexture(const osg::Geometry& geometry)
    {
        std::uint64_t& hash = print().paint;
        mix(hash, static_cast<const osg::BufferData*>(geometry.getTexCoordArray(0)));
        if (paint.matrix) mix(hash, paint.matrix->getMatrix());
        mix(hash, static_cast<std::uint64_t>(paint.isGenerated.value_or(false)));
        const osg::Texture* texture = paint.texture;
        mix(hash, static_cast<const void*>(texture));
        if (!texture) return;
        mix(hash, static_cast<std::uint64_t>(texture->getWrap(osg::Texture::WRAP_S)));
        mix(hash, static_cast<std::uint64_t>(texture->getWrap(osg::Texture::WRAP_T)));
        if (options->images)
            mix(hash, options->images->version(*texture));
        else
            mix(hash, static_cast<const osg::BufferData*>(texture->getImage(0)));
    }

    SubtreeState* _state = nullptr;
};

} // namespace

MeshFingerprint SubtreeState::fingerprint() const
{
    MeshFingerprint all;
    for (const SubtreePart& part : parts)
    {
        mix(all.topology, part.key);
        mix(all.topology, part.fingerprint.topology);
        mix(all.vertices, part.fingerprint.vertices);
        mix(all.paint, part.fingerprint.paint);
    }
    return all;
}

std::uint64_t SubtreeState::poses() const
{
    std::uint64_t hash = 0;
    for (std::size_t i = 1; i < parts.size(); ++i)
        mix(hash, parts[i].toRoot);
    return hash;
}

void inspect(osg::Node& root, const ExtractOptions& options, SubtreeState& state)
{
    // Reused from call to call for the memory of its node path: this runs for every object in every
    // frame.
    thread_local InspectWalk walk;
    walk.begin(state);
    walk.walk(root, options);
}

MeshFingerprint fingerprint(osg::Node& root, const ExtractOptions& options)
{
    SubtreeState state;
    inspect(root, options, state);
    return state.fingerprint();
}

} // namespace midair::bridge
