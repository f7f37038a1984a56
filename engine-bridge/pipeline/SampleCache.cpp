#include "engine-bridge/pipeline/SampleCache.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Limits.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/sequence/CycleEqualizer.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include <fmt/format.h>

namespace midair::bridge
{

Eigen::Matrix<double, 3, 8> boxCorners(const Eigen::Matrix3Xd& points)
{
    Eigen::Matrix<double, 3, 8> corners = Eigen::Matrix<double, 3, 8>::Zero();
    if (points.cols() == 0) return corners;
    const Eigen::AlignedBox3d box(points.rowwise().minCoeff(), points.rowwise().maxCoeff());
    for (int i = 0; i < 8; ++i)
        corners.col(i) = box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i));
    return corners;
}

namespace
{

/// True if an edge of a sampled triangle changed its length by more than the factor \a limit.
bool stretched(const haptics::SurfaceSamples& samples,
               const haptics::TriangleMesh& before,
               const haptics::TriangleMesh& now,
               double limit)
{
    for (const int t : samples.triangle)
        for (int k = 0; k < 3; ++k)
        {
            const int a = before.triangles(k, t);
            const int b = before.triangles((k + 1) % 3, t);
            const double was = (before.vertices.col(b) - before.vertices.col(a)).squaredNorm();
            const double is = (now.vertices.col(b) - now.vertices.col(a)).squaredNorm();
            // NaN counts as stretched.
            if (!(is <= limit * limit * was && was <= limit * limit * is)) return true;
        }
    return false;
}

template<class Matrix>
void mix(std::uint64_t& hash, const Matrix& matrix)
{
    const auto* bytes = reinterpret_cast<const unsigned char*>(matrix.data());
    const std::size_t size =
        static_cast<std::size_t>(matrix.size()) * sizeof(typename Matrix::Scalar);
    for (std::size_t at = 0; at < size; at += sizeof hash)
    {
        std::uint64_t word = 0;
        std::memcpy(&word, bytes + at, std::min(sizeof word, size - at));
        hash = (hash ^ word) * 0x9E3779B97F4A7C15ull;
        hash ^= hash >> 29;
    }
}

/// Hash of the sampled data of \a mesh, never 0.
std::uint64_t contentOf(const haptics::TriangleMesh& mesh)
{
    std::uint64_t hash = 1;
    mix(hash, mesh.vertices);
    mix(hash, mesh.triangles);
    mix(hash, mesh.intensity);
    return std::max<std::uint64_t>(hash, 1);
}

// Bit by bit, so that NaN works, too.
template<class Matrix>
bool isSameMatrix(const Matrix& a, const Matrix& b)
{
    return a.size() == b.size() &&
           (a.size() == 0 ||
            std::memcmp(a.data(),
                        b.data(),
                        static_cast<std::size_t>(a.size()) * sizeof(typename Matrix::Scalar)) == 0);
}

bool isSamePaint(const haptics::SurfacePaint* a, const haptics::SurfacePaint* b)
{
    if (!a || !b) return a == b;
    return isSameMatrix(a->coordinates, b->coordinates) && a->images == b->images &&
           a->image == b->image;
}

haptics::ControlPoints ownPoints(const haptics::ControlPoints& points, std::size_t object)
{
    std::vector<int> own;
    for (std::size_t l = 0; l < points.object.size(); ++l)
        if (points.object[l] == static_cast<int>(object)) own.push_back(static_cast<int>(l));
    return haptics::pick(points, own);
}

/// Returns the widest gap beside place \a at: the middle of it and two of its neighbours.
Eigen::Vector3d gapAt(const Eigen::Matrix3Xd& places, Eigen::Index at)
{
    constexpr Eigen::Index kNear = 6; // of a triangular lattice
    const Eigen::Index count = std::min(kNear, places.cols() - 1);
    Eigen::VectorXd distance2 = (places.colwise() - places.col(at)).colwise().squaredNorm();
    Eigen::Matrix3Xd near(3, count + 1);
    for (Eigen::Index k = 0; k <= count; ++k) // itself first
    {
        Eigen::Index nearest = 0;
        distance2.minCoeff(&nearest);
        near.col(k) = places.col(nearest);
        distance2[nearest] = std::numeric_limits<double>::infinity();
    }
    Eigen::Vector3d best = near.col(0);
    double widest2 = 0.0;
    for (Eigen::Index a = 1; a <= count; ++a)
        for (Eigen::Index b = 1; b < a; ++b)
        {
            const Eigen::Vector3d gap = (near.col(0) + near.col(a) + near.col(b)) / 3.0;
            const double width2 = (near.colwise() - gap).colwise().squaredNorm().minCoeff();
            if (width2 <= widest2) continue;
            widest2 = width2;
            best = gap;
        }
    return best;
}

/// Returns gaps between \a places, at most kGaps. That is quicker than haptics::sampleBetween(),
/// for which a new snapshot would have to wait.
Eigen::Matrix3Xd gapsOf(const Eigen::Matrix3Xd& places, const base::StopToken& stop)
{
    constexpr Eigen::Index kGaps = 1500; // enough for a first percentile
    const Eigen::Index step = 1 + places.cols() / kGaps;
    Eigen::Matrix3Xd gaps(3, (places.cols() + step - 1) / step);
    base::StopLook look(stop, 16);
    for (Eigen::Index k = 0; k < gaps.cols(); ++k)
    {
        look.turn();
        gaps.col(k) = gapAt(places, k * step);
    }
    return gaps;
}

/// Returns the \a places (mesh frame) that no plane clips, in the array frame.
Eigen::Matrix3Xd unclipped(const HapticObject& object, const Eigen::Matrix3Xd& places)
{
    Eigen::Matrix3Xd all = object.pose * places;
    Eigen::Index kept = 0;
    for (Eigen::Index i = 0; i < all.cols(); ++i)
        if (!isClipped(object.clips, all.col(i))) all.col(kept++) = all.col(i);
    all.conservativeResize(3, kept);
    return all;
}

} // namespace

bool SampleCache::hasEqualMesh(const Entry& entry, const Entry& wanted)
{
    if (entry.content != wanted.content || !entry.cached->error.empty()) return false;
    const haptics::TriangleMesh& a = *entry.sampledMesh;
    const haptics::TriangleMesh& b = *wanted.sampledMesh;
    return isSameMatrix(a.vertices, b.vertices) && isSameMatrix(a.triangles, b.triangles) &&
           isSameMatrix(a.intensity, b.intensity) && isSamePaint(a.paint.get(), b.paint.get());
}

bool SampleCache::follow(const Entry& from, const HapticObject& object, Entry& to)
{
    const haptics::TriangleMesh& before = *from.sampledMesh;
    const haptics::TriangleMesh& now = *object.mesh;
    if (before.triangles.cols() != now.triangles.cols() ||
        before.vertices.cols() != now.vertices.cols() || !from.cached->error.empty() ||
        stretched(from.cached->sets.front(), before, now, kStretched))
        return false;
    to.cached->sets = from.cached->sets;
    to.cached->sampling = from.cached->sampling;
    to.sampledMesh = from.sampledMesh;
    for (haptics::SurfaceSamples& samples : to.cached->sets)
        haptics::updateSamples(now, samples);
    ++_followed;
    return true;
}

// Takes the samples of an equal mesh, if there is one.
bool SampleCache::share(const HapticObject& object, Entry& entry) const
{
    entry.sampledMesh = object.mesh.get();
    entry.content = contentOf(*entry.sampledMesh);
    const auto equal = std::find_if(_entries.begin(),
                                    _entries.end(),
                                    [&entry](const Entry& one)
                                    {
                                        return one.spacing_m == entry.spacing_m &&
                                               one.sampling == entry.sampling &&
                                               one.sets == entry.sets && hasEqualMesh(one, entry);
                                    });
    if (equal == _entries.end()) return false;
    entry.cached = equal->cached;
    return true;
}

void SampleCache::sample(const HapticObject& object, Entry& entry)
{
    haptics::SamplerOptions options;
    options.spacing_m = entry.spacing_m;
    options.sampling = entry.sampling;
    options.stop = _stop;
    entry.cached->sampling = ++_sampled;
    try
    {
        const bool one = options.sampling == haptics::Sampling::VERTICES ||
                         options.sampling == haptics::Sampling::POINTS;
        entry.cached->sets =
            haptics::sampleSurfaceSets(*object.mesh, options, one ? 1 : entry.sets);
        if (!makeRoom(entry))
            throw base::InputError(fmt::format(
                "with it the scene's meshes have more than {} samples in the sets of their points",
                base::kMostCachedSamples));
    }
    catch (const base::InputError& error)
    {
        entry.cached->sets.clear();
        entry.cached->error = error.what();
    }
}

// Drops entries that this snapshot doesn't use if the samples exceed the limit; returns false if
// they still do.
bool SampleCache::makeRoom(const Entry& entry)
{
    const auto samplesOf = [](const Entry& one)
    {
        Eigen::Index count = 0;
        for (const haptics::SurfaceSamples& set : one.cached->sets)
            count += set.size();
        // Entries that share samples count a part each.
        return static_cast<double>(count) / static_cast<double>(one.cached.use_count());
    };
    const auto all = [&]
    {
        double count = samplesOf(entry);
        for (const Entry& one : _entries)
            count += samplesOf(one);
        return count;
    };
    if (all() <= base::kMostCachedSamples) return true;
    _entries.remove_if([](const Entry& one) { return one.unused > 0; });
    return all() <= base::kMostCachedSamples;
}

const CachedSamples& SampleCache::get(const HapticObject& object, double spacing_m, int sets)
{
    const haptics::Sampling sampling = object.properties.sampling;
    const Entry* alike = nullptr;
    for (Entry& entry : _entries)
    {
        if (entry.spacing_m != spacing_m || entry.sampling != sampling || entry.sets != sets)
            continue;
        if (entry.meshId == object.meshId)
        {
            entry.unused = 0;
            return *entry.cached;
        }
        // the first match is the newest
        if (!alike && object.topologyId != 0 && entry.topologyId == object.topologyId)
            alike = &entry;
    }
    Entry entry;
    entry.meshId = object.meshId;
    entry.topologyId = object.topologyId;
    entry.spacing_m = spacing_m;
    entry.sampling = sampling;
    entry.sets = sets;
    entry.cached = std::make_shared<CachedSamples>();
    const bool isKnown = (alike && follow(*alike, object, entry)) || share(object, entry);
    if (!isKnown) sample(object, entry);
    for (Entry& one : _entries)
        one.isShape |= object.topologyId != 0 && one.topologyId == object.topologyId;
    entry.cached->corners = entry.cached->sets.empty()
                                ? boxCorners(Eigen::Matrix3Xd(3, 0))
                                : boxCorners(entry.cached->sets.front().positions);
    _entries.push_front(std::move(entry));
    return *_entries.front().cached;
}

void SampleCache::endSnapshot()
{
    const bool isFull = _entries.size() > kMostEntries;
    _entries.remove_if(
        [isFull](Entry& entry)
        {
            const int kept = entry.isShape ? kKeptShapes : kKeptSnapshots;
            return entry.unused++ > (isFull ? 0 : kept);
        });
}

void FeltSurface::setStop(const base::StopToken& stop)
{
    _stop = stop;
    _samples.setStop(stop);
}

std::optional<PlacesToEven> FeltSurface::places(const std::vector<HapticObject>& objects,
                                                const haptics::ControlPoints& points,
                                                int fields)
{
    std::optional<PlacesToEven> found;
    for (const double spacing : haptics::placeSpacings(fields))
    {
        found = placesOf(objects, points, spacing * _wavelength_m);
        if (found) break;
    }
    _samples.endSnapshot();
    if (found && fields == 1) found->between = gapsOf(found->places.positions, _stop);
    return found;
}

std::optional<PlacesToEven> FeltSurface::placesOf(const std::vector<HapticObject>& objects,
                                                  const haptics::ControlPoints& points,
                                                  double spacing_m)
{
    PlacesToEven all;
    for (std::size_t i = 0; i < objects.size(); ++i)
    {
        const HapticObject& object = objects[i];
        const haptics::ControlPoints own = ownPoints(points, i);
        if (own.size() == 0 || !object.mesh) continue;
        const CachedSamples& cached = _samples.get(object, spacing_m);
        // It could be sampled for its points, so these samples are too many.
        if (cached.sets.empty()) return std::nullopt;
        const double pointSpacing_m =
            object.properties.spacing_m > 0.0 ? object.properties.spacing_m : _wavelength_m;
        const double reach_m = haptics::kFeltReach * std::max(pointSpacing_m, spacing_m);
        const haptics::ControlPoints places = haptics::feltPlaces(
            unclipped(object, cached.sets.front().positions), own, reach_m, _stop);
        if (all.places.size() + places.size() > haptics::kMostPlaces) return std::nullopt;
        if (all.places.size() == 0)
            all.places = places;
        else
            append(all.places, places);
    }
    return all;
}

} // namespace midair::bridge
