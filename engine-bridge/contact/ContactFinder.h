#pragma once

#include "engine-bridge/HapticObject.h"
#include "engine-bridge/contact/ContactPatch.h"
#include "engine-bridge/hands/Hand.h"
#include "engine-bridge/hands/TouchMeshes.h"
#include "haptics/surface/TriangleMesh.h"

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

namespace midair::bridge
{

/// Returns on which side of its triangles a mesh has its outside: 1 where their normals (q - p) x
/// (r - p) point out, -1 where they point in, 0 if unknown because it is open or its windings
/// contradict each other. Vertices at equal places (to a nanometre) count as one; triangles without
/// area or with places that aren't finite are ignored.
int windingOf(const haptics::TriangleMesh& mesh);

/// Why there is no contact, or why one started again.
enum class ContactReason
{
    NONE,
    TIME_NOT_FINITE,     ///< the time isn't a number or runs backwards
    JOINT_NOT_FINITE,    ///< a joint that counts as tracked has a position that isn't finite
    RADIUS_OUT_OF_RANGE, ///< a joint's radius isn't a number above 0 and up to kMostRadius_m
    POSE_NOT_FINITE,     ///< an object's pose isn't a number
    MESH_NOT_READY,      ///< its mesh is still being prepared
    NO_AREA,             ///< the touched part has no area: lines, points, triangles without area
    MATERIAL_INVALID,    ///< a number of the object's material is out of range
    HAND_JUMPED          ///< the contact moved farther at once than a hand can; it starts again
};

/// Returns a sentence for messages; "" for NONE.
const char* contactReasonText(ContactReason reason);

/// Subject of a reason.
struct ContactNote
{
    ContactReason reason = ContactReason::NONE;
    int hand = 0;             ///< Hand::id
    int bone = -1;            ///< 0 .. kHandBones - 1, -1: none in particular
    std::uint64_t object = 0; ///< HapticObject::touchId(), 0: none in particular
};

/// Largest radius of a joint, m: about five times that of a palm's.
constexpr double kMostRadius_m = 0.1;

/// Options for finding contacts; isValid() names the first setting that is out of its range.
struct ContactFinderOptions
{
    /// 0.1e-3 .. 10e-3; length of the straight pieces of a patch's outline
    double resolution_m = 0.5e-3;
    /// 0 .. 0.1; patches of one hand on one object with centres nearer than this are joined,
    /// because they feel like one (two foci under 15 mm apart do: Howard et al., "Gap detection in
    /// a pair of ultrasound mid-air vibrotactile stimuli")
    double join_m = 15e-3;
    /// >= join_m, up to 0.1; joined patches stay joined up to this distance, so that tremor doesn't
    /// switch
    double part_m = 19e-3;
    /// 0 .. 0.1; nearby() returns bones nearer to an object than this that don't touch it
    double leave_m = 4e-3;

    bool isValid(std::string* error = nullptr) const;
};

/// A bone near an object, but not touching it.
struct NearBone
{
    std::uint64_t object = 0; ///< HapticObject::touchId()
    int hand = 0;             ///< Hand::id
    int bone = 0;             ///< 0 .. kHandBones - 1
    double gap_m = 0.0;       ///< skin to surface, 0 .. leave_m
};

/// Finds the patches where hands touch objects, and reports problems of the input.
///
/// A bone has one patch per object. Where the triangles' normals contradict each other (the length
/// of their mean is under 0.5: a thin plate, a sharp edge), the patch is split. The outside of a
/// closed mesh with consistent winding follows from the winding; of any other mesh it is the side
/// of the bone's axis, and for a continuing contact the side that it had before. A bone that pushes
/// an object (HandFrame::presses) touches it as deep as its force flattens it (PressedSkin.h), if
/// it isn't deeper.
class ContactFinder
{
public:
    /// Throws InputError for options that are not valid.
    explicit ContactFinder(const ContactFinderOptions& options = {});

    /// Only objects with a mesh are touched. \a objects and \a hands are in the array frame.
    void update(const std::vector<HapticObject>& objects, const HandFrame& hands);

    const std::vector<ContactPatch>& patches() const { return _patches; }
    const std::vector<NearBone>& nearby() const { return _nearby; }
    const std::vector<ContactNote>& notes() const { return _notes; }

private:
    /// A patch of one bone with its sums.
    struct Part
    {
        ContactPatch patch;
        PatchMoments moments;
        bool isSplit = false;
        int side = 0;             ///< 0; 1: second part of a split patch
        double windingSide = 1.0; ///< -1: the patch's normal is opposite to its triangles'
        std::shared_ptr<const MeshDistance> mesh;
        const HapticObject* piece = nullptr;
        int winding = 0;
    };
    struct Winding
    {
        int sign = 0;
        std::uint64_t lastUse = 0;
    };
    /// Identifies a part of a bone at a piece of an object between updates.
    using Key = std::array<std::uint64_t, 3>;

    std::vector<HandCapsule> usableCapsules(const HandFrame& hands);
    void touch(const HapticObject& object,
               const std::shared_ptr<const MeshDistance>& mesh,
               HandCapsule capsule);
    void addParts(Part part, const PatchMoments& all, const std::vector<PatchMoments>& sides);
    /// Sums over the surface inside \a capsules; for a split part only over its own side.
    void addSurface(const Part& part,
                    const std::vector<const Capsule*>& capsules,
                    PatchMoments& all,
                    std::vector<PatchMoments>* ofTriangles) const;
    static Key keyOf(const Part& part);
    Eigen::Vector3d orient(const Part& part, const Eigen::Vector3d& normal) const;
    void join();
    ContactPatch joined(const std::vector<const Part*>& members) const;
    int windingOfMesh(const HapticObject& object, const haptics::TriangleMesh& mesh);

    ContactFinderOptions _options;
    TouchMeshes _meshes;
    std::unordered_map<std::uint64_t, Winding> _windings; ///< by topologyId, else meshId
    std::uint64_t _updates = 0;
    std::vector<HandPress> _presses; ///< of the hands being looked at
    std::vector<Part> _parts;
    std::vector<std::pair<Key, Eigen::Vector3d>> _normals; ///< of the last update
    std::vector<std::pair<Key, Key>> _joined;              ///< in the last update
    std::vector<ContactPatch> _patches;
    std::vector<NearBone> _nearby;
    std::vector<ContactNote> _notes;
};

} // namespace midair::bridge
