#pragma once

#include "engine-bridge/HapticObject.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/surface/SurfaceSampler.h"

#include <Eigen/Core>

#include <cstdint>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace midair::bridge
{

/// The corners of the bounding box of \a points; all zero for none.
Eigen::Matrix<double, 3, 8> boxCorners(const Eigen::Matrix3Xd& points);

/// Samples of one mesh; SampleCache keeps them while the mesh is in use.
struct CachedSamples
{
    /// Sets of points, each spread over the whole mesh, in the gaps of earlier ones; vertices have
    /// one set.
    std::vector<haptics::SurfaceSamples> sets;
    /// Corners of the samples' bounding box, to measure how far a pose change moves them.
    Eigen::Matrix<double, 3, 8> corners;
    /// Number of the sampling; samples that follow moved vertices keep it.
    std::uint64_t sampling = 0;
    std::string error; ///< why the mesh can't be sampled (sets is empty then)
};

/// Samples each mesh once per spacing and kind of sampling; meshes with equal content, such as
/// surfaces that share a drawable, share their samples. If only vertices moved (morphing, skinning,
/// scaling), the samples follow by their barycentric coordinates; the mesh is sampled again once an
/// edge of a sampled triangle is kStretched times longer or shorter.
class SampleCache
{
public:
    /// The samples of \a object's mesh, valid until endSnapshot(). \a spacing_m > 0. \a sets >= 1
    /// is the number of shifted sets of points; vertices have one only.
    const CachedSamples& get(const HapticObject& object, double spacing_m, int sets = 1);

    /// Once \a stop is requested, get() throws base::Stopped if it has to sample.
    void setStop(const base::StopToken& stop) { _stop = stop; }

    /// Drops meshes that weren't requested for kKeptSnapshots snapshots, and shapes of a deformed
    /// mesh not requested for kKeptShapes.
    void endSnapshot();

    std::uint64_t sampled() const { return _sampled; }
    std::uint64_t followed() const { return _followed; }

    static constexpr int kKeptSnapshots = 10000; ///< minutes: for objects that are shown in turn
    static constexpr int kKeptShapes = 2;        ///< each frame of a deformed mesh is a new shape
    /// With more entries, those unused by the current snapshot are dropped at once.
    static constexpr std::size_t kMostEntries = 64;
    static constexpr double kStretched = 1.25;

private:
    /// The samples of one mesh with one spacing and one kind of sampling.
    struct Entry
    {
        std::uint64_t meshId = 0;
        std::uint64_t topologyId = 0;
        double spacing_m = 0.0;
        int sets = 1;
        haptics::Sampling sampling = haptics::Sampling::SURFACE;
        std::shared_ptr<CachedSamples> cached; ///< entries of equal meshes share it
        std::shared_ptr<const haptics::TriangleMesh> sampledMesh; ///< the sampled mesh
        std::uint64_t content =
            0;                ///< hash of that mesh; 0: that of an older shape, which it follows
        bool isShape = false; ///< a newer entry has the same triangles
        int unused = 0;       ///< snapshots since the last get()
    };

    static bool hasEqualMesh(const Entry& entry, const Entry& wanted);
    bool share(const HapticObject& object, Entry& entry) const;
    bool follow(const Entry& from, const HapticObject& object, Entry& to);
    void sample(const HapticObject& object, Entry& entry);
    bool makeRoom(const Entry& entry);

    base::StopToken _stop;
    std::list<Entry> _entries; ///< newest first; about one per mesh
    std::uint64_t _sampled = 0;
    std::uint64_t _followed = 0;
};

/// Places on surfaces over which a field is evened out.
struct PlacesToEven
{
    haptics::ControlPoints places;
    /// 3 x k, array frame: others in their gaps, where a held field is measured
    Eigen::Matrix3Xd between;
};

/// Finds the places on a scene's surfaces over which fields are evened out.
class FeltSurface
{
public:
    /// \a wavelength_m: > 0; also the spacing of objects that set none.
    explicit FeltSurface(double wavelength_m) : _wavelength_m(wavelength_m) {}

    /// Once \a stop is requested, places() throws base::Stopped.
    void setStop(const base::StopToken& stop);

    /// Returns the places of \a objects near \a points, the played control points, with the targets
    /// of the nearest: at the first of haptics::placeSpacings() that gives at most
    /// haptics::kMostPlaces; none if none does. \a fields (>= 1) in turn; a single one with the
    /// places between.
    std::optional<PlacesToEven> places(const std::vector<HapticObject>& objects,
                                       const haptics::ControlPoints& points,
                                       int fields);

private:
    std::optional<PlacesToEven> placesOf(const std::vector<HapticObject>& objects,
                                         const haptics::ControlPoints& points,
                                         double spacing_m);

    double _wavelength_m;
    base::StopToken _stop;
    SampleCache _samples;
};

} // namespace midair::bridge
