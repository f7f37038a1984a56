#include "engine-bridge/scene/SubtreeReading.h"

#include "engine-bridge/scene/Convert.h"
#include "engine-bridge/scene/drawn/DrawnState.h"
#include "engine-bridge/scene/drawn/TextOutlines.h"

#include <osg/ClipNode>

#include <utility>

namespace midair::bridge
{

namespace
{

/// Copies vertices from the places that the mesh was read from.
class CopyWalk : public SubtreeWalk
{
public:
    CopyWalk(const std::vector<bool>& wanted, std::vector<PartSources>& parts) :
        _wanted(wanted),
        _parts(parts),
        _next(parts.size(), 0)
    {
    }

    bool isWhole() const
    {
        for (std::size_t i = 0; i < _parts.size(); ++i)
            if (_next[i] != _parts[i].geometries.size()) return false;
        return _isAlike;
    }

protected:
    void visit(osg::Drawable& drawable) override
    {
        _isAlike = _isAlike && part < _parts.size();
        if (!_isAlike) return;
        std::vector<VertexSource>& geometries = _parts[part].geometries;
        std::size_t& next = _next[part];
        // Skips drawables that are not in the mesh (text, an empty geometry).
        if (next == geometries.size() || geometries[next].geometry != &drawable) return;
        VertexSource& source = geometries[next++];
        if (!_wanted[part]) return;
        const osg::Array* array = source.geometry->getVertexArray();
        const Eigen::Index before = source.placed.copy->size();
        source.array = array;
        _isAlike = array != nullptr;
        if (!array) return;
        const auto copy = std::make_shared<VertexCopy>(*array);
        copy->copyMore(*array, copy->bytes());
        source.placed = {copy, matrix, !identity};
        _isAlike = source.placed.copy->size() == before;
    }

private:
    const std::vector<bool>& _wanted;
    std::vector<PartSources>& _parts;
    std::vector<std::size_t> _next; ///< for each part: number of geometries met
    bool _isAlike = true;
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

bool isMirror(const osg::Matrixd& matrix)
{
    return toEigen(matrix).topLeftCorner<3, 3>().determinant() < 0.0;
}

} // namespace

Eigen::Matrix3Xd transformed(const Eigen::Matrix3Xd& vertices, const osg::Matrixd& matrix)
{
    const Eigen::Matrix4d m = toEigen(matrix);
    return (m.topLeftCorner<3, 3>() * vertices).colwise() + m.topRightCorner<3, 1>().eval();
}

Eigen::Matrix3Xd joinedVertices(const std::vector<PlacedCopy>& copies)
{
    Eigen::Index count = 0;
    for (const PlacedCopy& placed : copies)
        count += placed.copy->size();
    Eigen::Matrix3Xd all(3, count);
    count = 0;
    for (const PlacedCopy& placed : copies)
    {
        const Eigen::Matrix3Xd own = placed.copy->vertices();
        all.middleCols(count, own.cols()) = placed.isMoved ? transformed(own, placed.matrix) : own;
        count += own.cols();
    }
    return all;
}

bool VertexSource::hasMovedUnsaid(std::uint64_t turn) const
{
    // The fingerprint detects another array, or another number of vertices.
    if (!array || geometry->getVertexArray() != array.get() ||
        static_cast<Eigen::Index>(array->getNumElements()) != placed.copy->size())
        return false;
    return !placed.copy->isStill(*array, turn);
}

std::vector<PlacedCopy> PartSources::copies() const
{
    std::vector<PlacedCopy> all;
    for (const VertexSource& source : geometries)
        all.push_back(source.placed);
    return all;
}

bool copyVertices(osg::Node& root,
                  const ExtractOptions& options,
                  const std::vector<bool>& wanted,
                  std::vector<PartSources>& parts)
{
    for (const PartSources& part : parts)
        if (!part.isComplete) return false;
    CopyWalk walk(wanted, parts);
    walk.walk(root, options);
    return walk.isWhole();
}

haptics::TriangleMesh meshOf(const std::vector<PlacedPiece>& pieces,
                             std::vector<std::string>& warnings)
{
    std::vector<MeshPiece> read;
    for (const PlacedPiece& placed : pieces)
    {
        MeshPiece piece = placed.copy.vertices ? pieceOf(placed.copy, warnings) : placed.read;
        if (placed.isMoved) piece.vertices = transformed(piece.vertices, placed.matrix);
        if (placed.isMoved && isMirror(placed.matrix))
            for (Eigen::Vector3i& corners : piece.triangles)
                std::swap(corners[1], corners[2]); // so that faces still point outwards
        read.push_back(std::move(piece));
    }
    return joined(read);
}

/// Finds the drawables of a subtree, part by part.
class SubtreeReading::Walk : public SubtreeWalk
{
public:
    Walk(const ExtractOptions& now, PaintImages& images, SubtreeReading& out) :
        _out(out),
        _reader(now.paint, images, out._warnings, out._sources)
    {
    }

protected:
    void open(std::uint64_t, const osg::Matrixd&) override
    {
        _out._pieces.emplace_back();
        _out._geometries.emplace_back();
    }

    void enter(osg::Node& node) override
    {
        _out._sources.emplace_back(&node);
        tellState(node);
        if (dynamic_cast<osg::ClipNode*>(&node))
            _out._warnings.push_back(quoted(node) +
                                     " is inside the haptic object, where it clips only the "
                                     "picture; above the object it clips the haptics, too");
        const osg::Transform* transform = node.asTransform();
        if (transform && transform->getReferenceFrame() != osg::Transform::RELATIVE_RF)
            _out._warnings.push_back(quoted(node) +
                                     " has an absolute reference frame; it can't be felt");
        if (dynamic_cast<osg::Billboard*>(&node) || (transform && followsCamera(*transform)))
            _out._warnings.push_back(quoted(node) +
                                     " turns with the camera on screen; it is felt unturned");
    }

    void visit(osg::Drawable& drawable) override
    {
        _out._sources.emplace_back(&drawable);
        if (!textOf(drawable)) tellState(drawable); // a text has its own shader
        PlacedPiece piece;
        piece.matrix = matrix;
        piece.isMoved = !identity;
        const osg::Geometry* geometry = drawable.asGeometry();
        if (geometry)
            piece.copy = _reader.begin(*geometry, paint);
        else
            piece.read = _reader.readOther(drawable);
        if (!piece.copy.vertices && piece.read.triangles.empty()) return;
        if (geometry)
        {
            _out._bytes += piece.copy.bytes(*geometry);
            for (const PrimitiveCopy& one : piece.copy.surface->primitives)
                _out._isPlain = _out._isPlain && one.isPlain();
        }
        _out._pieces[part].push_back(std::move(piece));
        _out._geometries[part].emplace_back(geometry);
    }

private:
    void tellState(const osg::Node& node)
    {
        const std::string what = notFeltOf(node);
        if (!what.empty()) _out._warnings.push_back(quoted(node) + " " + what);
    }

    SubtreeReading& _out;
    GeometryReader _reader;
};

SubtreeReading::SubtreeReading(osg::Node& root, const ExtractOptions& options, PaintImages& images)
{
    inspect(root, options, _state);
    Walk(options, images, *this).walk(root, options);
}

bool SubtreeReading::isStale() const
{
    for (std::size_t part = _part, piece = _piece; part < _pieces.size(); ++part, piece = 0)
        for (; piece < _pieces[part].size(); ++piece)
            if (_geometries[part][piece] &&
                !_pieces[part][piece].copy.fits(*_geometries[part][piece]))
                return true;
    return false;
}

bool SubtreeReading::copyMore(std::size_t& budget)
{
    for (; _part < _pieces.size(); ++_part, _piece = 0)
        for (; _piece < _pieces[_part].size(); ++_piece)
        {
            const osg::Geometry* geometry = _geometries[_part][_piece];
            if (geometry && !_pieces[_part][_piece].copy.copyMore(*geometry, budget)) return false;
        }
    return true;
}

std::vector<PartSources> SubtreeReading::takeVertices()
{
    std::vector<PartSources> all(_pieces.size());
    for (std::size_t part = 0; part < _pieces.size(); ++part)
        for (std::size_t i = 0; i < _pieces[part].size(); ++i)
        {
            const PlacedPiece& piece = _pieces[part][i];
            const auto& geometry = _geometries[part][i];
            if (geometry)
                all[part].geometries.push_back({geometry,
                                                geometry->getVertexArray(),
                                                {piece.copy.vertices, piece.matrix, piece.isMoved},
                                                piece.copy.surface});
            else
                all[part].isComplete = false;
        }
    return all;
}

} // namespace midair::bridge
