#include "engine-bridge/scene/SubtreeReading.h"

#include "engine-bridge/scene/CameraFreeTransform.h"
#include "engine-bridge/scene/Convert.h"
#include "engine-bridge/scene/drawn/DrawnState.h"
#include "engine-bridge/scene/drawn/TextOutlines.h"

#include <osg/ClipNode>

#include <utility>

namespace midair::bridge
{

namespace
{

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
                std::swap(corners[1], corners[2]); // so that faces look outwards still
        read.push_back(std::move(piece));
    }
    return joined(read);
}

/// Finds the drawables of a subtree, part by part.
class SubtreeReading::Walk : public SubtreeWalk
{
public:
    Walk(const ExtractOptions& now,
         PaintImages& images,
         const std::shared_ptr<SpareMemory>& spares,
         SubtreeReading& out) :
        _out(out),
        _reader(now.paint, images, spares, out._warnings, out._sources)
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
                                     " clips within the haptic object, which is felt whole; above "
                                     "it it clips what is felt, too");
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
        if (!textOf(drawable)) tellState(drawable); // a text has a shader of its own
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

SubtreeReading::SubtreeReading(osg::Node& root,
                               const ExtractOptions& options,
                               PaintImages& images,
                               const std::shared_ptr<SpareMemory>& spares)
{
    inspect(root, options, _state);
    Walk(options, images, spares, *this).walk(root, options);
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
