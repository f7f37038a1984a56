#pragma once

#include "engine-bridge/HapticObject.h"
#include "engine-bridge/hands/Hand.h"
#include "engine-bridge/pipeline/PointAssembler.h"
#include "engine-bridge/scene/MeshCache.h"
#include "engine-bridge/scene/PaintReader.h"
#include "haptics/base/text/MessageLog.h"
#include "haptics/surface/FlatFaces.h"
#include "plugin/scene/CollectHapticSurfacesVisitor.h"
#include "plugin/scene/PointMeshes.h"
#include "plugin/scene/SceneMarks.h"
#include "plugin/scene/TaggedShapes.h"

#include <osgMidair/FoundObject>
#include <osgMidair/HapticProperty>

#include <osg/Node>
#include <osg/observer_ptr>

#include <Eigen/Core>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

namespace osgMidair
{

/// Returns the part of \a property that goes to the hologram thread with each object.
midair::bridge::HapticProperties forBridge(const HapticProperty& property);

/// Returns what is wrong with the material of \a property, so that contacts are not played, or with
/// the user's file of materials; empty: nothing.
std::string problemOfMaterial(const HapticProperty& property);

/// Returns why the sensation of \a property isn't felt as meant; empty: it is, or there is none.
std::string problemOfSensation(const HapticProperty& property);

/// Returns the part of \a property that describes the paint of the mesh.
midair::bridge::PaintOptions paintOf(const HapticProperty& property);

/// HapticObject::origin of a SceneCollector's objects: the haptic node and its path, for receivers
/// of the field. Immutable; any thread may keep it.
struct FeltNode
{
    osg::observer_ptr<osg::Node> node;
    std::string path;
};

/// Collects the active haptic objects, obstacles and reflectors below its roots, in array
/// coordinates. Checks unchanged objects but doesn't rebuild them. Reads new objects, each
/// completely, in frames that have time for them (MeshCache::isFull()).
///
/// For the thread that updates the scene only.
class SceneCollector
{
public:
    using Log = std::function<midair::base::MessageLog&()>;

    /// \a owner: the HapticScene that it collects for; null: another kind of owner, for which all
    /// scenes are inner ones. \a log: gets each reason why an object can't be played, with the
    /// node's path, and its end.
    SceneCollector(const osg::Node* owner, Log log);

    /// Sets the property for the whole scene if nothing below the roots is tagged as haptic.
    void setUnmarkedProperty(const HapticProperty& property) { _unmarked = property; }

    /// \a toArray: affine transform from the world in scene units to the array. Obstacles are
    /// collected if \a shadows is true. Names of sensations' files are looked up in \a folder, that
    /// of the scene's file, first; empty: it is unknown.
    void configure(const Eigen::Matrix4d& toArray, bool shadows, const std::string& folder = {});

    /// Makes the next collect() look for tags, which otherwise happens every kTagFrames frames.
    void dirtyTags() { _frames.sinceTags = 0; }
    static constexpr unsigned int kTagFrames = 60;
    /// If more than kMostLooks objects have had unchanged meshes for this many frames, each frame
    /// checks kMostLooks of them in turn.
    static constexpr unsigned int kCalmFrames = 60;
    static constexpr unsigned int kMostLooks = 128;

    /// Collects one frame: stores the haptic objects below \a roots in \a objects, which may hold
    /// an older frame of this collector, or nothing. Returns false if they have not changed since.
    bool collect(const std::vector<SceneRoot>& roots,
                 std::vector<midair::bridge::HapticObject>& objects);

    /// Makes the next collect() rebuild all objects.
    void forget() { _frames.isKept = false; }

    /// Obstacles and faces of reflectors of this frame, in the array frame.
    const std::vector<midair::bridge::Capsule>& obstacles() const { return _real.props; }
    const std::vector<midair::haptics::FlatFace>& reflectors() const { return _real.faces; }
    const std::vector<midair::haptics::ReflectingBody>& bodies() const { return _real.bodies; }

    int instances() const { return _collected.felt; } ///< playable instances
    /// Returns true if the last collect() met an object whose properties silence the whole scene.
    bool isSilenced() const { return _collected.isSilenced; }
    /// Instances that wait for a later frame because they are new or their mesh is new and not read
    /// completely: they keep their previous shape, new ones aren't played yet.
    int beingRead() const { return _collected.beingRead; }
    std::uint64_t extractions() const { return _meshes.extractions(); }

    /// Returns the enabled inner scenes of the last collect().
    const std::vector<const HapticScene*>& innerScenes() const { return _visitor.innerScenes(); }

    /// Returns all instances of the last collect(), in no particular order, including those that
    /// can't be played but not those that wait.
    std::vector<FoundObject> found() const;

    /// Returns the node of an instance; null if it is gone.
    osg::Node* nodeOf(std::uint64_t instance) const;

private:
    /// State of an instance, kept from frame to frame.
    struct Known
    {
        std::uint64_t id = 0; ///< of the instance
        osg::observer_ptr<osg::Node> node;
        std::string path;
        std::shared_ptr<const FeltNode> origin; ///< the same two, for results
        std::string tag;
        HapticProperty raw;                    ///< as the node has it
        HapticProperty property;               ///< raw, with values out of range repaired
        midair::bridge::HapticProperties felt; ///< the same, as objects have it
        unsigned int seen = 0;                 ///< frame
        unsigned int calm = 0;                 ///< frames since its mesh has changed
        std::uint64_t shape = 0;               ///< version from the mesh cache
        osg::Matrixd world;
        std::vector<osg::Vec4d> clips;
        std::size_t first = 0;                             ///< index of its first object
        std::vector<midair::bridge::HapticObject> objects; ///< none: not playable
        std::string cause; ///< the logged reason why it is not playable; empty: it is
        std::vector<midair::base::Message> geometry; ///< unplayable parts of its shape
        bool isUnderstood = true;                    ///< its property is valid
    };

    /// What was logged about the scene.
    struct Told
    {
        std::optional<SceneMarks::State> marks;
        int known = 0; ///< objects in the last frame
        /// frame in which each obstacle and reflector was last met
        std::map<std::uint64_t, unsigned int> realThings;
    };
    /// Arguments of configure().
    struct Places
    {
        Eigen::Matrix4d toArray = Eigen::Matrix4d::Identity();
        bool shadows = false;
        std::string folder;
    };
    /// What sound meets besides the objects; props, faces and bodies are those of the newest frame,
    /// in the array frame.
    struct RealThings
    {
        TaggedShapes<std::vector<midair::bridge::Capsule>> obstacles;
        TaggedShapes<midair::haptics::FlatFaces> reflectors;
        std::vector<midair::bridge::Capsule> props;
        std::vector<midair::haptics::FlatFace> faces;
        std::vector<midair::haptics::ReflectingBody> bodies;
    };
    /// The newest frame.
    struct Collected
    {
        std::vector<midair::bridge::HapticObject>* objects = nullptr; ///< during collect()
        std::size_t count = 0;                                        ///< objects added
        int felt = 0;
        int beingRead = 0;
        int known = 0;          ///< objects met
        bool isAnyBack = false; ///< one was missing in the frame before
        unsigned int calm = 0;  ///< objects that may be checked in turn
        bool isChanged = false;
        bool isSilenced = false;
    };
    struct Frames
    {
        unsigned int now = 0;
        unsigned int sinceTags = 0; ///< tags are looked for at 0
        bool isKept = false;        ///< the known state is valid
        std::size_t objects = 0;    ///< of the last frame
        unsigned int calm = 0;      ///< Collected::calm of the last frame
        /// waiting ones, and whether each silences all
        std::unordered_map<std::uint64_t, bool> waiting;
        std::size_t instances = 0; ///< met in the last frame
        unsigned int changes = 0;  ///< propertyChanges() of the last frame
        bool isAnySet = true;      ///< a setter has changed a property since
    };

    void lookForMarks(const std::vector<SceneRoot>& roots);
    void noteMarks();
    void tellMarks(const osg::Node& root);
    void tellHidden(const std::vector<SceneRoot>& roots);
    Known& know(const HapticInstance& instance, bool& fresh, bool& changed);
    void repair(Known& known, std::vector<std::string> wrong);
    bool mustWait(const HapticInstance& instance);
    static bool silences(const HapticInstance& instance);
    osg::Node& contentOf(osg::Node& node) const;
    bool mayRest(Known& known, bool isChanged);
    std::uint64_t lookAt(Known& known, osg::Node& node, bool isBack);
    static void renew(Known& known);
    void put(const Known& known);
    void fill(const HapticInstance& instance);
    void tellStates(const HapticInstance& instance, const Known& known);
    void fillParts(const HapticInstance& instance, Known& known);
    bool findParts(const HapticInstance& instance, Known& known, double& pressure);
    void tell(const Known& known, midair::base::MessageCode code, const std::string& what);
    void tellLeftOut(const Known& known, const std::vector<std::string>& leftOut);
    void tellCause(Known& known, midair::base::MessageCode code, const std::string& cause);
    void tellGeometry(Known& known, bool isBack);
    void fillObstacle(const HapticInstance& instance);
    void fillReflector(const HapticInstance& instance);
    void tellReal(const HapticInstance& instance, midair::base::MessageCode code);
    void endGone();
    void forgetUnseen();

    const Log _log;
    std::optional<HapticProperty> _unmarked; ///< of the root, if nothing is tagged
    SceneMarks _marks;
    Told _told;
    Places _places;
    CollectHapticSurfacesVisitor _visitor;
    midair::bridge::MeshCache _meshes;
    PointMeshes _points;
    midair::bridge::ExtractOptions _extract;
    RealThings _real;
    std::unordered_map<std::uint64_t, Known> _known;
    std::vector<std::string> _warnings;
    std::vector<midair::bridge::CachedMesh> _parts; ///< of the instance being filled in
    Collected _collected;
    Frames _frames;
};

} // namespace osgMidair
