#pragma once

#include "engine-bridge/HapticObject.h"
#include "engine-bridge/hands/Obstacles.h"
#include "engine-bridge/pipeline/SampleCache.h"
#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/text/MessageLog.h"
#include "haptics/points/ControlPointSelector.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/surface/FlatFaces.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace midair::bridge
{

/// Objects, hands and props of one frame for the hologram thread; immutable once submitted.
struct SceneSnapshot
{
    std::uint64_t frame = 0; ///< frame number; copied into HologramResult::frame
    double time_s = 0.0;     ///< steady clock; when it was collected
    /// of the frame; copied into HologramResult::simulationTime_s
    double simulationTime_s = 0.0;
    std::optional<double> lightAfter_s; ///< s after time_s when its light is seen; none: unknown
    /// extrapolate moving objects to where they are seen when the sound arrives, if that is known
    bool carriesOn = false;
    /// affine, from the scene's world, in its units, to the array; copied into the result
    Eigen::Matrix4d worldToArray = Eigen::Matrix4d::Identity();
    std::vector<HapticObject> objects;
    HandsAndObstacles around;
    /// array frame; beside those of the array, see reflectorsBeside()
    std::vector<haptics::FlatFace> reflectors;
    /// array frame; those of an accuracy of haptics::kMostCorrectedAccuracy_mm or better
    std::vector<haptics::ReflectingBody> bodies;
    HandFrame hands;          ///< array frame; for contacts
    double handsLate_s = 0.0; ///< from these positions to the sound; 0: they are predicted
    /// 3 x k, m, array frame: ears of a tracked head
    Eigen::Matrix3Xd ears = Eigen::Matrix3Xd(3, 0);
    double metresPerUnit = 1.0; ///< of the scene, for messages; the objects are in metres
};

/// Counts for the samples of one snapshot object.
struct ObjectPoints
{
    haptics::LeftOutPoints leftOut;
    int outOfReach = 0;         ///< points left out because no hand was near them
    bool isUnreachable = false; ///< the whole object is out of the array's reach
};

/// Control points of one snapshot, and the omissions.
struct AssembledPoints
{
    haptics::ControlPoints points; ///< array frame; object indexes the snapshot's objects
    Eigen::Matrix3Xd skipped;      ///< array frame; samples left out (workspace, spacing, budget)
    std::uint64_t outOfWorkspace = 0;  ///< points, plus objects completely out of reach
    std::uint64_t overBudget = 0;      ///< points beyond maxPoints
    std::uint64_t crowded = 0;         ///< points too near another one
    std::uint64_t unpainted = 0;       ///< points of intensity 0
    std::vector<ObjectPoints> objects; ///< of the snapshot's objects, in their order
};

/// Converts a snapshot's objects to control points, and detects their later motion.
class PointAssembler
{
public:
    /// Options of a PointAssembler.
    struct Options
    {
        double wavelength_m = 8.5e-3;   ///< > 0; also the spacing of objects that don't set one
        double motionTolerance_m = 0.0; ///< >= 0; objects that moved no farther count as unmoved
        int maxPoints = 0;              ///< >= 0; 0: the selector's default
        int sets = 1;                   ///< 1 .. 1024; number of shifted sets of points per surface
        double loudness = 1.0;          ///< >= 0; up to 1 that of objects that are one focus
        haptics::Medium medium;         ///< for the loudness of such a focus
        Render render = Render::OBJECT; ///< meaning of INHERIT, for messages

        bool operator==(const Options& b) const
        {
            return wavelength_m == b.wavelength_m && motionTolerance_m == b.motionTolerance_m &&
                   maxPoints == b.maxPoints && sets == b.sets && loudness == b.loudness &&
                   medium == b.medium && render == b.render;
        }
    };

    /// Throws base::InputError for an array without transducers.
    PointAssembler(const haptics::TransducerArray& array,
                   const Options& options,
                   base::MessageLog& messages);

    /// Replaces the options; samples that still fit are kept, also if the wavelength changed by
    /// less than a hundredth. The next unmoved() returns false.
    void setOptions(const haptics::TransducerArray& array, const Options& options);

    /// Once \a stop is requested, assemble() throws base::Stopped.
    void setStop(const base::StopToken& stop);

    /// Returns true if \a snapshot has the objects of the last assemble(), none moved beyond the
    /// tolerance.
    bool unmoved(const SceneSnapshot& snapshot);

    /// Samples each mesh once, poses the samples and selects control points. Objects that can't be
    /// rendered are left out with a message. \a set, 0 .. sets - 1, is the set of points taken from
    /// each surface; objects sampled at their vertices have only one set.
    AssembledPoints assemble(const SceneSnapshot& snapshot, int set = 0);

    /// True if an object of the last assemble() is a single focus, limited to its share.
    bool hasSmall() const { return !_oneFocus.now.empty(); }

    /// Places that the array reaches.
    const haptics::Workspace& workspace() const { return _workspace; }

    /// Counts since the start, see HologramCounters.
    std::uint64_t sampled() const { return _samples.sampled(); }
    std::uint64_t followed() const { return _samples.followed(); }

private:
    /// State of an object when last assembled.
    struct Placed
    {
        std::uint64_t id = 0;
        std::uint64_t meshId = 0;
        HapticProperties properties;
        double share = 1.0;
        std::vector<Eigen::Vector4d> clips;
        Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
        Eigen::Matrix<double, 3, 8> corners = Eigen::Matrix<double, 3, 8>::Zero();
    };

    /// State of whole objects, by touchId(), in the present snapshot.
    struct Wholes
    {
        std::set<std::uint64_t> large; ///< larger than the workspace
        std::set<std::uint64_t> felt;  ///< with a control point
    };
    /// For objects that are one focus, by id: the number of points they would have at a size that
    /// fits.
    struct OneFocus
    {
        std::map<std::uint64_t, int> now;
        std::map<std::uint64_t, int> before; ///< in the last snapshot
    };

    bool usable(const HapticObject& object);
    void tellUnused(const HapticObject& object);
    void tellOnce(base::MessageCode code, const HapticObject& object, const std::string& what);
    void tellIfLarge(const HapticObject& object, double metresPerUnit);
    double fittingSize_m(const HapticObject& object, double width_m, bool mayGrow = false) const;
    haptics::SamplerOptions samplerOptions(const HapticObject& object) const;
    void tellIfSmall(const SceneSnapshot& snapshot, const HapticObject& object);
    void holdSmall(const SceneSnapshot& snapshot, haptics::ControlPoints& points) const;
    void tellUnreachable(const SceneSnapshot& snapshot, const AssembledPoints& out);
    bool isAround(const HapticObject& object) const;
    void tellLarge(const HapticObject& object);
    std::string alsoLarge(const HapticObject& object) const;
    void tellLeftOut(const SceneSnapshot& snapshot, const haptics::SelectionReport& report);
    void tellUnfelt(const SceneSnapshot& snapshot, const haptics::SelectionReport& report);
    bool withinReach(const HapticObject& object) const;
    void add(const HapticObject& object, int index, double unit_Pa, int set, Placed& placed);
    void keepSide(const HapticObject& object, haptics::PosedObject& posed);
    void select(const SceneSnapshot& snapshot, AssembledPoints& out);

    Options _options;
    double _spacing_m; ///< for objects without their own spacing, about a wavelength
    haptics::SelectorOptions _selector;
    haptics::Workspace _workspace;
    haptics::TransducerArray _array;
    base::MessageLog& _messages;
    SampleCache _samples;
    std::vector<Placed> _placed;
    std::vector<haptics::PosedObject> _posed;
    Eigen::Index _candidates = 0; ///< samples of all in _posed
    Wholes _wholes;
    OneFocus _oneFocus;
    bool _assembled = false;
};

} // namespace midair::bridge
