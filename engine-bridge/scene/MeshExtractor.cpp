#include "engine-bridge/scene/MeshExtractor.h"

#include "engine-bridge/scene/CameraFreeTransform.h"
#include "engine-bridge/scene/Convert.h"
#include "engine-bridge/scene/GeometryReader.h"

#include <osg/Geometry>

#include <algorithm>
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
        if (!geometry) return;
        const osg::Array* vertices = geometry->getVertexArray();
        mix(print().topology,
            static_cast<std::uint64_t>(vertices ? vertices->getNumElements() : 0));
        mix(print().topology, static_cast<const void*>(deformerOf(*geometry)));
        mix(print().vertices, static_cast<const osg::BufferData*>(vertices));
        for (const auto& primitives : geometry->getPrimitiveSetList())
            mix(print().topology, static_cast<const osg::BufferData*>(primitives.get()));
        if (options->paint.source == PaintOptions::VERTEX_COLORS)
            mix(print().vertices, static_cast<const osg::BufferData*>(geometry->getColorArray()));
        if (options->paint.source == PaintOptions::TEXTURE) mixTexture(*geometry);
    }

private:
    void mixTexture(const osg::Geometry& geometry)
    {
        std::uint64_t& hash = print().vertices;
        mix(hash, static_cast<const osg::BufferData*>(geometry.getTexCoordArray(0)));
        if (paint.matrix) mix(hash, paint.matrix->getMatrix());
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

haptics::TriangleMesh joined(const std::vector<MeshPiece>& pieces)
{
    Eigen::Index v = 0;
    Eigen::Index t = 0;
    bool colored = false;
    bool pictured = false;
    for (const MeshPiece& piece : pieces)
    {
        v += piece.vertices.cols();
        t += static_cast<Eigen::Index>(piece.triangles.size());
        colored = colored || !piece.intensity.empty();
        pictured = pictured || piece.image;
    }
    haptics::TriangleMesh mesh;
    mesh.vertices.resize(3, v);
    mesh.triangles.resize(3, t);
    if (colored) mesh.intensity.setOnes(v);
    const auto paint = std::make_shared<haptics::SurfacePaint>();
    if (pictured) paint->coordinates.setZero(2, v);
    v = t = 0;
    for (const MeshPiece& piece : pieces)
    {
        const Eigen::Index count = piece.vertices.cols();
        mesh.vertices.middleCols(v, count) = piece.vertices;
        for (std::size_t i = 0; i < piece.intensity.size(); ++i)
            mesh.intensity[v + static_cast<Eigen::Index>(i)] = piece.intensity[i];
        for (const Eigen::Vector3i& triangle : piece.triangles)
            mesh.triangles.col(t++) = triangle.array() + static_cast<int>(v);
        if (pictured)
        {
            const int image = piece.image ? static_cast<int>(paint->images.size()) : -1;
            if (piece.image) paint->images.push_back(piece.image);
            if (piece.image) paint->coordinates.middleCols(v, count) = piece.coordinates;
            paint->image.insert(paint->image.end(), piece.triangles.size(), image);
        }
        v += count;
    }
    if (pictured) mesh.paint = paint;
    return mesh;
}

/// Reads the meshes of a subtree, part by part.
class ExtractWalk : public SubtreeWalk
{
public:
    ExtractWalk(const ExtractOptions& now, PaintImages& images, ExtractedMesh& out) :
        _out(out),
        _reader(now.paint, images, out.warnings, out.sources)
    {
    }

    void finish()
    {
        for (const auto& pieces : _pieces)
            _out.parts.push_back(joined(pieces));
    }

protected:
    void open(std::uint64_t, const osg::Matrixd&) override { _pieces.emplace_back(); }

    void enter(osg::Node& node) override
    {
        _out.sources.emplace_back(&node);
        const osg::Transform* transform = node.asTransform();
        if (transform && transform->getReferenceFrame() != osg::Transform::RELATIVE_RF)
            _out.warnings.push_back(quoted(node) +
                                    " has an absolute reference frame; it can't be felt");
        if (dynamic_cast<osg::Billboard*>(&node) || (transform && followsCamera(*transform)))
            _out.warnings.push_back(quoted(node) +
                                    " turns with the camera on screen; it is felt unturned");
    }

    void visit(osg::Drawable& drawable) override
    {
        _out.sources.emplace_back(&drawable);
        MeshPiece piece = _reader.read(drawable, paint);
        if (piece.triangles.empty()) return;
        if (!identity)
        {
            const Eigen::Matrix4d m = toEigen(matrix);
            piece.vertices = (m.topLeftCorner<3, 3>() * piece.vertices).colwise() +
                             m.topRightCorner<3, 1>().eval();
        }
        _pieces[part].push_back(std::move(piece));
    }

private:
    ExtractedMesh& _out;
    GeometryReader _reader;
    std::vector<std::vector<MeshPiece>> _pieces; ///< by part
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
    // Kept from call to call to reuse the memory of its node path: this runs for every object in
    // every frame.
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

ExtractedMesh extractMesh(osg::Node& root, const ExtractOptions& options)
{
    ExtractedMesh out;
    inspect(root, options, out.state);
    PaintImages ownImages;
    ExtractWalk walk(options, options.images ? *options.images : ownImages, out);
    walk.walk(root, options);
    walk.finish();
    return out;
}

} // namespace midair::bridge
