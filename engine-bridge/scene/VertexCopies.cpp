#include "engine-bridge/scene/VertexCopies.h"

#include "engine-bridge/scene/Convert.h"

namespace midair::bridge
{

namespace
{

/// Copies vertices where the mesh was read from.
class CopyWalk : public SubtreeWalk
{
public:
    CopyWalk(const std::vector<bool>& wanted,
             const std::shared_ptr<SpareMemory>& spares,
             std::vector<PartSources>& parts) :
        _wanted(wanted),
        _spares(spares),
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
        // What is not in the mesh (text, an empty geometry) is passed over.
        if (next == geometries.size() || geometries[next].geometry != &drawable) return;
        VertexSource& source = geometries[next++];
        if (!_wanted[part]) return;
        const osg::Array* array = source.geometry->getVertexArray();
        const Eigen::Index before = source.placed.copy->size();
        source.array = array;
        _isAlike = array != nullptr;
        if (!array) return;
        const auto copy = std::make_shared<VertexCopy>(*array, _spares);
        copy->copyMore(*array, copy->bytes());
        source.placed = {copy, matrix, !identity};
        _isAlike = source.placed.copy->size() == before;
    }

private:
    const std::vector<bool>& _wanted;
    const std::shared_ptr<SpareMemory>& _spares;
    std::vector<PartSources>& _parts;
    std::vector<std::size_t> _next; ///< for each part: number of geometries met
    bool _isAlike = true;
};

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
    // Another array, or another number of vertices, shows in the fingerprint.
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
                  const std::shared_ptr<SpareMemory>& spares,
                  std::vector<PartSources>& parts)
{
    for (const PartSources& part : parts)
        if (!part.isComplete) return false;
    CopyWalk walk(wanted, spares, parts);
    walk.walk(root, options);
    return walk.isWhole();
}

} // namespace midair::bridge
