#include "haptics/surface/FlatFaces.h"

#include "haptics/base/Units.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

constexpr double kFlat_rad = base::toRadians(0.1);
constexpr double kCurved_rad = base::toRadians(40.0);
constexpr double kFlat_m = 1e-4;
constexpr double kSamePlace_m = 1e-6;
constexpr double kSameArea = 0.01;
constexpr double kNarrowest_m = 0.01;

using Edge = std::pair<int, int>;

/// A triangle with an area, by its welded vertices.
struct Facet
{
    std::array<int, 3> corners{};
    Eigen::Vector3d normal; ///< unit length
    double area = 0.0;
    int face = -1; ///< its number; -1: none yet
};

class FaceFinder
{
public:
    explicit FaceFinder(const TriangleMesh& mesh)
    {
        weld(mesh);
        for (std::size_t t = 0; t < _facets.size(); ++t)
            for (int k = 0; k < 3; ++k)
                _sharing[edgeOf(_facets[t], k)].push_back(static_cast<int>(t));
        orient();
        group();
    }

    /// Returns the mesh without seams, if it is closed and has few triangles; null otherwise.
    std::shared_ptr<const TriangleMesh> body() const
    {
        const auto count = static_cast<Eigen::Index>(_facets.size());
        if (!_isClosed || !_problem.empty() || count > kMostOfBody) return nullptr;
        auto mesh = std::make_shared<TriangleMesh>();
        mesh->vertices.resize(3, static_cast<Eigen::Index>(_places.size()));
        for (std::size_t v = 0; v < _places.size(); ++v)
            mesh->vertices.col(static_cast<Eigen::Index>(v)) = _places[v];
        mesh->triangles.resize(3, count);
        for (Eigen::Index t = 0; t < count; ++t)
            for (int k = 0; k < 3; ++k)
                mesh->triangles(k, t) =
                    facet(static_cast<int>(t)).corners[static_cast<std::size_t>(k)];
        return mesh;
    }

    FlatFaces find() const
    {
        FlatFaces found;
        found.problem = _problem.empty() && isCurved() ? "is curved" : _problem;
        for (int face = 0; face < _count && found.problem.empty(); ++face)
            add(face, found);
        if (found.problem.empty() && found.faces.size() > kMostReflectors)
            found.problem =
                fmt::format("has {} flat faces, over {}", found.faces.size(), kMostReflectors);
        if (found.problem.empty() && found.faces.empty() && !_facets.empty())
            found.problem =
                fmt::format("has no face as wide as {:g} mm, a wavelength", 1e3 * kNarrowest_m);
        if (!found.problem.empty()) found.faces.clear();
        return found;
    }

private:
    static Edge edgeOf(const Facet& facet, int k)
    {
        const auto [low, high] = std::minmax(facet.corners[static_cast<std::size_t>(k)],
                                             facet.corners[static_cast<std::size_t>((k + 1) % 3)]);
        return {low, high};
    }

    // Vertices at seams are one.
    void weld(const TriangleMesh& mesh)
    {
        std::map<std::array<long long, 3>, int> known;
        std::vector<int> welded(static_cast<std::size_t>(mesh.vertices.cols()));
        for (Eigen::Index v = 0; v < mesh.vertices.cols(); ++v)
        {
            const Eigen::Vector3d place = mesh.vertices.col(v);
            std::array<long long, 3> key{};
            for (int i = 0; i < 3; ++i)
                key[static_cast<std::size_t>(i)] = std::llround(place[i] / kSamePlace_m);
            const auto [found, isNew] = known.emplace(key, static_cast<int>(_places.size()));
            if (isNew) _places.push_back(place);
            welded[static_cast<std::size_t>(v)] = found->second;
        }
        for (Eigen::Index t = 0; t < mesh.triangles.cols(); ++t)
        {
            Facet facet;
            for (int k = 0; k < 3; ++k)
                facet.corners[static_cast<std::size_t>(k)] =
                    welded[static_cast<std::size_t>(mesh.triangles(k, t))];
            const Eigen::Vector3d& a = at(facet.corners[0]);
            const Eigen::Vector3d twice =
                (at(facet.corners[1]) - a).cross(at(facet.corners[2]) - a);
            if (!(twice.norm() > kSamePlace_m * kSamePlace_m)) continue;
            facet.normal = twice.normalized();
            facet.area = 0.5 * twice.norm();
            _facets.push_back(facet);
        }
    }

    const Eigen::Vector3d& at(int place) const { return _places[static_cast<std::size_t>(place)]; }

    // A closed mesh has each edge twice, in opposite directions; its volume is positive if normals
    // point outwards.
    void orient()
    {
        _isClosed = !_facets.empty() &&
                    std::all_of(_sharing.begin(),
                                _sharing.end(),
                                [](const auto& edge) { return edge.second.size() == 2; });
        if (!_isClosed) return;
        std::map<Edge, int> directions;
        double volume = 0.0;
        for (const Facet& facet : _facets)
        {
            volume += at(facet.corners[0]).dot(at(facet.corners[1]).cross(at(facet.corners[2])));
            for (std::size_t k = 0; k < 3; ++k)
                directions[edgeOf(facet, static_cast<int>(k))] +=
                    facet.corners[k] < facet.corners[(k + 1) % 3] ? 1 : -1;
        }
        if (std::any_of(directions.begin(),
                        directions.end(),
                        [](const auto& edge) { return edge.second != 0; }))
            _problem = "has triangles that face inwards and outwards";
        for (Facet& facet : _facets)
            if (volume < 0.0) facet.normal *= -1.0;
    }

    // Of open meshes the winding of each triangle is arbitrary.
    double cosine(const Eigen::Vector3d& a, const Eigen::Vector3d& b) const
    {
        return _isClosed ? a.dot(b) : std::abs(a.dot(b));
    }

    // Joins neighbours that are parallel to the largest facet of a face.
    void group()
    {
        std::vector<int> order(_facets.size());
        std::iota(order.begin(), order.end(), 0);
        std::stable_sort(order.begin(),
                         order.end(),
                         [this](int a, int b) { return facet(a).area > facet(b).area; });
        for (const int first : order)
        {
            if (facet(first).face >= 0) continue;
            std::vector<int> open{first};
            _facets[static_cast<std::size_t>(first)].face = _count;
            while (!open.empty())
            {
                const Facet& from = facet(open.back());
                open.pop_back();
                for (int k = 0; k < 3; ++k)
                    for (const int next : _sharing.at(edgeOf(from, k)))
                        if (facet(next).face < 0 &&
                            cosine(facet(first).normal, facet(next).normal) > std::cos(kFlat_rad))
                        {
                            _facets[static_cast<std::size_t>(next)].face = _count;
                            open.push_back(next);
                        }
            }
            ++_count;
        }
    }

    const Facet& facet(int index) const { return _facets[static_cast<std::size_t>(index)]; }

    bool isCurved() const
    {
        for (const auto& [edge, sharing] : _sharing)
            for (const int other : sharing)
                if (facet(other).face != facet(sharing.front()).face &&
                    cosine(facet(other).normal, facet(sharing.front()).normal) >
                        std::cos(kCurved_rad))
                    return true;
        return false;
    }

    /// Returns the direction of the longest edge around \a face.
    Eigen::Vector3d sideOf(int face) const
    {
        Eigen::Vector3d longest = Eigen::Vector3d::Zero();
        for (const auto& [edge, sharing] : _sharing)
        {
            const auto inside = std::count_if(sharing.begin(),
                                              sharing.end(),
                                              [&](int index) { return facet(index).face == face; });
            const Eigen::Vector3d way = at(edge.second) - at(edge.first);
            if (inside == 1 && way.norm() > longest.norm()) longest = way;
        }
        return longest;
    }

    void add(int face, FlatFaces& found) const
    {
        Eigen::Vector3d normal = Eigen::Vector3d::Zero();
        double area = 0.0;
        for (const Facet& one : _facets)
        {
            if (one.face != face) continue;
            normal += (normal.dot(one.normal) < 0.0 ? -one.area : one.area) * one.normal;
            area += one.area;
        }
        FlatFace flat;
        Reflector& rectangle = flat.rectangle;
        rectangle.normal = normal.normalized();
        const Eigen::Vector3d side = sideOf(face);
        rectangle.along = (side - side.dot(rectangle.normal) * rectangle.normal).normalized();
        flat.isOfBody = _isClosed;
        Eigen::Matrix3d axes;
        axes << rectangle.along, rectangle.across(), rectangle.normal;
        Eigen::Vector3d low = Eigen::Vector3d::Constant(Reflector::kEndless);
        Eigen::Vector3d high = -low;
        for (const Facet& one : _facets)
            for (const int corner : one.corners)
            {
                if (one.face != face) continue;
                low = low.cwiseMin(axes.transpose() * at(corner));
                high = high.cwiseMax(axes.transpose() * at(corner));
            }
        rectangle.size_m = (high - low).head<2>();
        rectangle.position = axes * (0.5 * (low + high));
        if (!rectangle.along.allFinite() || !(high - low).allFinite() ||
            !(std::abs(area / rectangle.size_m.prod() - 1.0) < kSameArea))
            found.problem = "has a face that is no rectangle";
        else if (high.z() - low.z() > kFlat_m)
            found.problem = "has a face that is bent";
        else if (rectangle.size_m.minCoeff() >= kNarrowest_m)
            found.faces.push_back(flat);
    }

    std::vector<Eigen::Vector3d> _places; // welded vertices
    std::vector<Facet> _facets;
    std::map<Edge, std::vector<int>> _sharing; // facets at each edge
    bool _isClosed = false;
    int _count = 0; // faces
    std::string _problem;
};

} // namespace

FlatFace FlatFace::movedBy(const Eigen::Isometry3d& pose) const
{
    FlatFace moved = *this;
    moved.rectangle.position = pose * rectangle.position;
    moved.rectangle.normal = (pose.linear() * rectangle.normal).normalized();
    const Eigen::Vector3d along = pose.linear() * rectangle.along;
    moved.rectangle.along =
        (along - along.dot(moved.rectangle.normal) * moved.rectangle.normal).normalized();
    return moved;
}

FlatFaces flatFacesOf(const TriangleMesh& mesh)
{
    constexpr double kFarthest_m = 1e4; // beyond any place of a reflector
    if (!(mesh.vertices.size() == 0 || mesh.vertices.cwiseAbs().maxCoeff() <= kFarthest_m))
        return {{}, "is too large", nullptr};
    const FaceFinder finder(mesh);
    FlatFaces found = finder.find();
    found.body = finder.body();
    return found;
}

} // namespace midair::haptics
