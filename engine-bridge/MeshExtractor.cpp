#include "engine-bridge/MeshExtractor.h"

#include "engine-bridge/Convert.h"

#include <osg/AutoTransform>
#include <osg/Billboard>
#include <osg/Camera>
#include <osg/Geometry>
#include <osg/NodeVisitor>
#include <osg/Projection>
#include <osg/Transform>
#include <osg/TriangleFunctor>
#include <osg/TriangleIndexFunctor>

#include <algorithm>
#include <cstring>
#include <map>

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

/// Hands out each drawable of the active subtree with its matrix to the root of the walk.
class ActiveSubtreeVisitor : public osg::NodeVisitor
{
public:
    ActiveSubtreeVisitor() : osg::NodeVisitor(NODE_VISITOR, TRAVERSE_ACTIVE_CHILDREN) {}

    /// \a now has to outlive the walk.
    void setOptions(const ExtractOptions& now)
    {
        options = &now;
        setTraversalMask(now.traversalMask);
    }

    void walk(osg::Node& root)
    {
        this->root = &root;
        if (osg::Drawable* drawable = root.asDrawable())
            visit(*drawable);
        else
            traverse(root); // the root's own transform belongs to the pose
    }

    void apply(osg::Node& node) override
    {
        if (options->skip && options->skip(node)) return;
        enter(node);
        traverse(node);
    }

    void apply(osg::Transform& node) override
    {
        if (options->skip && options->skip(node)) return;
        enter(node);
        // An absolute frame hangs on the camera, not in the world.
        if (node.getReferenceFrame() != osg::Transform::RELATIVE_RF) return;
        const osg::Matrixd outer = matrix;
        const bool outerIdentity = identity;
        node.computeLocalToWorldMatrix(matrix, this);
        identity = false;
        transformed();
        traverse(node);
        matrix = outer;
        identity = outerIdentity;
    }

    void apply(osg::Camera&) override {}
    void apply(osg::Projection&) override {}

    void apply(osg::Drawable& drawable) override
    {
        if (options->skip && options->skip(drawable)) return;
        visit(drawable);
    }

protected:
    virtual void enter(osg::Node&) {}
    virtual void transformed() {}
    virtual void visit(osg::Drawable& drawable) = 0;

    const ExtractOptions* options = nullptr;
    osg::Node* root = nullptr;
    osg::Matrixd matrix;
    bool identity = true;
};

class FingerprintVisitor : public ActiveSubtreeVisitor
{
public:
    MeshFingerprint result;

    void begin(const ExtractOptions& now)
    {
        setOptions(now);
        result = {};
    }

protected:
    void enter(osg::Node& node) override { mix(result.topology, static_cast<const void*>(&node)); }
    void transformed() override { mix(result.vertices, matrix); }

    void visit(osg::Drawable& drawable) override
    {
        mix(result.topology, static_cast<const void*>(&drawable));
        const osg::Geometry* geometry = drawable.asGeometry();
        if (!geometry) return;
        const osg::Array* vertices = geometry->getVertexArray();
        mix(result.topology, static_cast<std::uint64_t>(vertices ? vertices->getNumElements() : 0));
        mix(result.vertices, static_cast<const osg::BufferData*>(vertices));
        if (options->intensityFromColors)
            mix(result.vertices, static_cast<const osg::BufferData*>(geometry->getColorArray()));
        for (const auto& primitives : geometry->getPrimitiveSetList())
            mix(result.topology, static_cast<const osg::BufferData*>(primitives.get()));
    }
};

/// Vertices of any of OSG's array types as doubles.
class VertexReader : public osg::ConstArrayVisitor
{
public:
    Eigen::Matrix3Xd vertices;
    bool understood = false;

    void apply(const osg::Vec2Array& a) override { read(a); }
    void apply(const osg::Vec3Array& a) override { read(a); }
    void apply(const osg::Vec4Array& a) override { read(a); }
    void apply(const osg::Vec2dArray& a) override { read(a); }
    void apply(const osg::Vec3dArray& a) override { read(a); }
    void apply(const osg::Vec4dArray& a) override { read(a); }

private:
    template<typename A>
    void read(const A& array)
    {
        constexpr int kSize = A::ElementDataType::num_components;
        vertices.resize(3, static_cast<Eigen::Index>(array.size()));
        for (std::size_t i = 0; i < array.size(); ++i)
        {
            const auto column = static_cast<Eigen::Index>(i);
            for (int k = 0; k < 3; ++k)
                vertices(k, column) = k < kSize ? static_cast<double>(array[i][k]) : 0.0;
        }
        understood = true;
    }
};

/// Brightness (mean of red, green and blue, times alpha) of a colour array, 0 .. 1.
class BrightnessReader : public osg::ConstArrayVisitor
{
public:
    std::vector<float> brightness;

    void apply(const osg::Vec4Array& a) override { read(a, 1.0f, true); }
    void apply(const osg::Vec3Array& a) override { read(a, 1.0f, false); }
    void apply(const osg::Vec4ubArray& a) override { read(a, 1.0f / 255.0f, true); }
    void apply(const osg::Vec3ubArray& a) override { read(a, 1.0f / 255.0f, false); }

private:
    template<typename A>
    void read(const A& array, float scale, bool alpha)
    {
        for (const auto& c : array)
        {
            const float sum =
                static_cast<float>(c[0]) + static_cast<float>(c[1]) + static_cast<float>(c[2]);
            const float opacity = alpha ? static_cast<float>(c[3]) * scale : 1.0f;
            brightness.push_back(std::clamp(sum * scale / 3.0f * opacity, 0.0f, 1.0f));
        }
    }
};

struct TriangleIndices
{
    std::vector<Eigen::Vector3i> triangles;
    void operator()(unsigned int a, unsigned int b, unsigned int c)
    {
        triangles.emplace_back(static_cast<int>(a), static_cast<int>(b), static_cast<int>(c));
    }
};

struct TriangleSoup
{
    std::vector<osg::Vec3> corners;
    void operator()(const osg::Vec3& a, const osg::Vec3& b, const osg::Vec3& c, bool = false)
    {
        corners.insert(corners.end(), {a, b, c});
    }
};

std::string quoted(const osg::Object& object)
{
    return std::string(object.className()) +
           (object.getName().empty() ? std::string() : " '" + object.getName() + "'");
}

class ExtractVisitor : public ActiveSubtreeVisitor
{
public:
    ExtractVisitor(const ExtractOptions& now, ExtractedMesh& out) : _out(out) { setOptions(now); }

    /// One mesh out of the pieces.
    void finish()
    {
        Eigen::Index v = 0;
        Eigen::Index t = 0;
        bool painted = false;
        for (const Piece& piece : _pieces)
        {
            v += piece.vertices.cols();
            t += static_cast<Eigen::Index>(piece.triangles.size());
            painted = painted || !piece.intensity.empty();
        }
        haptics::TriangleMesh& mesh = _out.mesh;
        mesh.vertices.resize(3, v);
        mesh.triangles.resize(3, t);
        if (painted) mesh.intensity.setOnes(v);
        v = t = 0;
        for (const Piece& piece : _pieces)
        {
            mesh.vertices.middleCols(v, piece.vertices.cols()) = piece.vertices;
            for (std::size_t i = 0; i < piece.intensity.size(); ++i)
                mesh.intensity[v + static_cast<Eigen::Index>(i)] = piece.intensity[i];
            for (const Eigen::Vector3i& triangle : piece.triangles)
                mesh.triangles.col(t++) = triangle.array() + static_cast<int>(v);
            v += piece.vertices.cols();
        }
    }

protected:
    struct Piece
    {
        Eigen::Matrix3Xd vertices;
        std::vector<Eigen::Vector3i> triangles;
        std::vector<float> intensity; ///< one a vertex, or empty
    };

    void enter(osg::Node& node) override
    {
        // Whatever of the skeleton of nodes stands in the fingerprint stays alive.
        _out.sources.emplace_back(&node);
        const osg::Transform* transform = node.asTransform();
        if (transform && transform->getReferenceFrame() != osg::Transform::RELATIVE_RF)
            _out.warnings.push_back(quoted(node) +
                                    " has an absolute reference frame; it can't be felt");
        if (dynamic_cast<osg::Billboard*>(&node) || dynamic_cast<osg::AutoTransform*>(&node))
            _out.warnings.push_back(quoted(node) +
                                    " turns with the camera on screen; it is felt unturned");
    }

    void visit(osg::Drawable& drawable) override
    {
        _out.sources.emplace_back(&drawable);
        Piece piece;
        const osg::Geometry* geometry = drawable.asGeometry();
        if (geometry)
            readGeometry(*geometry, piece);
        else if (std::strcmp(drawable.libraryName(), "osgText") != 0)
            readSoup(drawable, piece);
        if (piece.triangles.empty()) return;
        if (!identity)
        {
            const Eigen::Matrix4d m = toEigen(matrix);
            piece.vertices = (m.topLeftCorner<3, 3>() * piece.vertices).colwise() +
                             m.topRightCorner<3, 1>().eval();
        }
        _pieces.push_back(std::move(piece));
    }

private:
    void readGeometry(const osg::Geometry& geometry, Piece& piece)
    {
        if (std::strcmp(geometry.className(), "RigGeometry") == 0 && !geometry.getVertexArray())
            _out.warnings.push_back(quoted(geometry) + " has no vertices before its first update");
        const osg::Array* array = geometry.getVertexArray();
        if (!array) return;
        VertexReader reader;
        array->accept(reader);
        if (!reader.understood)
        {
            _out.warnings.push_back(quoted(geometry) + " has vertices of an unknown type (" +
                                    array->className() + "); it can't be felt");
            return;
        }
        piece.vertices = std::move(reader.vertices);
        osg::TriangleIndexFunctor<TriangleIndices> functor;
        geometry.accept(functor);
        piece.triangles = std::move(functor.triangles);
        const auto count = static_cast<int>(piece.vertices.cols());
        const auto last = std::remove_if(piece.triangles.begin(),
                                         piece.triangles.end(),
                                         [count](const Eigen::Vector3i& t)
                                         { return t.minCoeff() < 0 || t.maxCoeff() >= count; });
        if (last != piece.triangles.end())
        {
            _out.warnings.push_back(quoted(geometry) + " has indices beyond its " +
                                    std::to_string(count) +
                                    " vertices; those triangles are left out");
            piece.triangles.erase(last, piece.triangles.end());
        }
        if (options->intensityFromColors) readColors(geometry, piece);
        _out.sources.emplace_back(array);
        for (const auto& primitives : geometry.getPrimitiveSetList())
            _out.sources.emplace_back(primitives.get());
    }

    void readColors(const osg::Geometry& geometry, Piece& piece)
    {
        const osg::Array* colors = geometry.getColorArray();
        if (!colors) return;
        _out.sources.emplace_back(colors);
        BrightnessReader reader;
        colors->accept(reader);
        const auto count = static_cast<std::size_t>(piece.vertices.cols());
        if (colors->getBinding() == osg::Array::BIND_PER_VERTEX &&
            reader.brightness.size() >= count)
            piece.intensity.assign(reader.brightness.begin(),
                                   reader.brightness.begin() + static_cast<std::ptrdiff_t>(count));
        else if (colors->getBinding() == osg::Array::BIND_OVERALL && !reader.brightness.empty())
            piece.intensity.assign(count, reader.brightness.front());
    }

    static void readSoup(const osg::Drawable& drawable, Piece& piece)
    {
        osg::TriangleFunctor<TriangleSoup> functor;
        if (!drawable.supports(functor)) return;
        drawable.accept(functor);
        const auto& corners = functor.corners;
        piece.vertices.resize(3, static_cast<Eigen::Index>(corners.size()));
        for (std::size_t i = 0; i < corners.size(); ++i)
            piece.vertices.col(static_cast<Eigen::Index>(i)) = toEigen(osg::Vec3d(corners[i]));
        for (int i = 0; i + 2 < static_cast<int>(corners.size()); i += 3)
            piece.triangles.emplace_back(i, i + 1, i + 2);
    }

    ExtractedMesh& _out;
    std::vector<Piece> _pieces;
};

} // namespace

MeshFingerprint fingerprint(osg::Node& root, const ExtractOptions& options)
{
    // Kept from call to call for its node path's memory: this is done for every object in every frame.
    thread_local FingerprintVisitor visitor;
    visitor.begin(options);
    visitor.walk(root);
    return visitor.result;
}

ExtractedMesh extractMesh(osg::Node& root, const ExtractOptions& options)
{
    ExtractedMesh out;
    out.fingerprint = fingerprint(root, options);
    ExtractVisitor visitor(options, out);
    visitor.walk(root);
    visitor.finish();
    return out;
}

} // namespace midair::bridge
