#pragma once

#include "engine-bridge/HapticObject.h"
#include "engine-bridge/c/inside/Calls.h"
#include "engine-bridge/display/Display.h"
#include "engine-bridge/hands/HandSource.h"
#include "engine-bridge/heads/HeadSource.h"
#include "engine-bridge/player/SceneOptions.h"
#include "engine-bridge/player/ScenePlayer.h"
#include "engine-bridge/playing/EarBound.h"
#include "engine-bridge/settings/SceneTable.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/settings/Setting.h"
#include "haptics/base/threads/Forks.h"
#include "haptics/base/threads/Mutex.h"
#include "haptics/base/threads/StopToken.h"
#include "haptics/surface/FlatFaces.h"

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace midair::capi
{

using bridge::ObjectSettings;
using bridge::objectTable;
using bridge::readPlaces;
using bridge::SceneSettings;
using bridge::sceneTable;

/// An array as read, and as used by a solve without a device.
struct ArrayPair
{
    explicit ArrayPair(haptics::TransducerArray array, std::string itsFile = {});

    haptics::TransducerArray given;
    haptics::TransducerArray solvable; ///< its levels are those of a drive signal
    std::string file;                  ///< name or path, see TransducerArray::load(); empty: none
};

/// Problems of values that concern safety: while there is one, nothing is played.
class Misunderstood
{
public:
    /// \a names: the settings that may have been meant.
    void note(std::vector<std::string> names, std::string why);
    /// The setting \a name is valid now.
    void settle(const std::string& name);
    /// Returns why nothing is played; empty: no problem.
    const std::string& why() const;

private:
    struct Wrong
    {
        std::vector<std::string> names;
        std::string why;
    };
    std::vector<Wrong> _all;
};

/// An object of a scene.
struct SceneObject
{
    std::shared_ptr<const midair_object> number; ///< its own, for results
    bridge::SharedMesh mesh;
    std::uint64_t meshId = 0;
    std::uint64_t topologyId = 0;
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    bridge::ObjectSettings properties;
    bridge::HapticProperties felt; ///< from the properties
    bool isPoints = false;
    int plays = 0; ///< how often midair_sensation_play() has begun its sensation
    Misunderstood misunderstood;
};

/// Returns the part of \a properties that the pipeline gets with each object. Fails for an unknown
/// material, listing the known names, and for one with inconsistent numbers.
bridge::HapticProperties forPipeline(const ObjectSettings& properties);

/// Hands set by the application; they disappear 0.2 s after the last call.
class SetHands : public bridge::InjectedHandSource
{
public:
    bool frameAt(double time_s, bridge::HandFrame& frame) override;
};

/// A head set by the application; it is lost 0.2 s after the last call.
class SetHead : public bridge::InjectedHeadSource
{
public:
    bool headAt(double time_s, bridge::Head& head) override;
};

/// Arguments of midair_on_message().
struct MessageListener
{
    midair_message_callback call = nullptr;
    void* user = nullptr;
    std::uint64_t seen = 0; ///< newest change that it has received
};

/// Converts \a message for programs.
midair_message toPublic(const base::Message& message);

/// The object behind a midair_scene.
struct Scene
{
    explicit Scene(std::shared_ptr<const ArrayPair> itsArray);

    const base::MadeHere isOurs; ///< otherwise it is the parent's, and this is the child of a fork
    /// It replaces a scene that the parent of this process plays.
    bool isHeir = false;
    const std::shared_ptr<const ArrayPair> array;
    const std::shared_ptr<SetHands> hands = std::make_shared<SetHands>();
    const std::shared_ptr<SetHead> head = std::make_shared<SetHead>();

    mutable base::Mutex mutex;
    SceneSettings settings MIDAIR_GUARDED_BY(mutex); ///< as set
    Misunderstood misunderstood MIDAIR_GUARDED_BY(mutex);
    std::map<midair_object, SceneObject> objects MIDAIR_GUARDED_BY(mutex);
    Eigen::Matrix3Xd ears MIDAIR_GUARDED_BY(mutex) = Eigen::Matrix3Xd(3, 0); ///< as set
    std::vector<haptics::FlatFace> reflectors MIDAIR_GUARDED_BY(mutex);      ///< as set
    bool isClosed MIDAIR_GUARDED_BY(mutex) = false;
    /// of midair_set_display(); null: none
    std::shared_ptr<const bridge::Display> display MIDAIR_GUARDED_BY(mutex);
    /// of midair_play(); empty: not playing
    std::string device MIDAIR_GUARDED_BY(mutex);
    /// the array is a file, which is read again when it changes
    bool followsFile MIDAIR_GUARDED_BY(mutex) = false;
    std::uint64_t frame MIDAIR_GUARDED_BY(mutex) = 0;
    double time_s MIDAIR_GUARDED_BY(mutex) = 0.0;  ///< of the last update
    bool isTimed MIDAIR_GUARDED_BY(mutex) = false; ///< there was one since midair_play()
    bridge::ScenePlayer player MIDAIR_GUARDED_BY(mutex);
    MessageListener listener MIDAIR_GUARDED_BY(mutex);

    base::Mutex solveMutex;
    /// of running solves
    std::shared_ptr<base::StopSource>
        stop MIDAIR_GUARDED_BY(solveMutex) = std::make_shared<base::StopSource>();

    /// \{ Calls of the player for any thread: a callback that hangs within the mutex neither
    /// keeps the array sounding nor unmutes it.
    void setMuted(bool muted) MIDAIR_NO_THREAD_ANALYSIS { player.setMuted(muted); }
    void silenceNow() MIDAIR_NO_THREAD_ANALYSIS { player.silenceNow(); }
    /// The mutex isn't held while waiting for a field.
    std::string awaitField(double timeout_s) MIDAIR_NO_THREAD_ANALYSIS
    {
        return player.awaitField(timeout_s);
    }
    /// \}
    /// Returns the problems for which nothing is played.
    std::vector<base::Message> faults() const MIDAIR_REQUIRES(mutex);
    /// Returns why nothing is played, or an empty text.
    std::string whySilenced() const MIDAIR_REQUIRES(mutex) { return whySilenced(faults()); }
    /// The same if \a all are known already.
    std::string whySilenced(const std::vector<base::Message>& all) const MIDAIR_REQUIRES(mutex);
    /// Returns the array, as last read from its file, with the transducers that the settings mark
    /// dead or weak. Throws InputError.
    std::shared_ptr<const ArrayPair> markedArray() const MIDAIR_REQUIRES(mutex);
    /// Passes changed settings to the player.
    void configure() MIDAIR_REQUIRES(mutex);
    /// Copies the present scene into the player's snapshot, without hands, with the ears of the
    /// present head.
    bridge::SceneSnapshot& fillSnapshot() MIDAIR_REQUIRES(mutex);
    /// Ends playing; destroy the result without the mutex.
    std::shared_ptr<void> endPlaying() MIDAIR_REQUIRES(mutex);

private:
    /// by the player, last
    mutable std::shared_ptr<const haptics::TransducerArray> _read MIDAIR_GUARDED_BY(mutex);
    /// as it was read last
    mutable std::shared_ptr<const ArrayPair> _current MIDAIR_GUARDED_BY(mutex);
    /// of that, as _marks say
    mutable std::shared_ptr<const ArrayPair> _marked MIDAIR_GUARDED_BY(mutex);
    mutable std::string _marks MIDAIR_GUARDED_BY(mutex);
};

Handles<midair_array, const ArrayPair>& arrays();
Handles<midair_scene, Scene>& scenes();

/// Returns what a scene's handle stands for; fails inside a callback.
std::shared_ptr<Scene> sceneOf(midair_scene* handle);
/// Fails for a setting of the field, such as a cap, that isn't its default although \a isUsed(row)
/// is false. \a who: "a midair_solver ... and", begin of the sentence.
void refuseUnused(const SceneSettings& settings,
                  const char* who,
                  const std::function<bool(const base::SettingFacts& row)>& isUsed);
/// Fails if there is none of that number.
SceneObject& objectOf(Scene& scene, midair_object object) MIDAIR_REQUIRES(scene.mutex);

} // namespace midair::capi
