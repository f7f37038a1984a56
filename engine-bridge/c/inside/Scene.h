#pragma once

#include "engine-bridge/HapticObject.h"
#include "engine-bridge/c/inside/Handles.h"
#include "engine-bridge/c/inside/ObjectProperties.h"
#include "engine-bridge/c/inside/SceneSettings.h"
#include "engine-bridge/hands/HandProximity.h"
#include "engine-bridge/hands/HandSource.h"
#include "engine-bridge/pipeline/HologramThread.h"
#include "engine-bridge/pipeline/SceneSnapshot.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/text/MessageLog.h"
#include "haptics/base/threads/StopToken.h"

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace midair::capi
{

/// An array as it was read, and as a solve without a device takes it.
struct ArrayPair
{
    haptics::TransducerArray given;
    haptics::TransducerArray solvable; ///< its levels are those of a drive signal
};

/// What is wrong with values that concern safety: while there is one, nothing is played.
class Misunderstood
{
public:
    /// \a names: the settings that it may have been meant for.
    void note(std::vector<std::string> names, std::string why);
    /// The setting \a name is right now.
    void settle(const std::string& name);
    /// Why nothing is played; empty: nothing keeps it.
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
    ObjectProperties properties;
    bridge::HapticProperties felt; ///< of the properties
    bool isPoints = false;
    Misunderstood misunderstood;
};

/// What a midair_scene stands for. Members are used under its mutex, but for those that say
/// otherwise.
struct Scene
{
    std::mutex mutex;
    std::shared_ptr<const ArrayPair> array; ///< never changes
    SceneSettings settings;
    Misunderstood misunderstood;
    std::map<midair_object, SceneObject> objects;
    base::MessageLog messages; ///< of solves and hands
    bool isClosed = false;

    /// \{ Solves under way; guarded by a mutex of their own.
    std::mutex solveMutex;
    std::shared_ptr<base::StopSource> stop = std::make_shared<base::StopSource>();
    /// \}

    std::unique_ptr<bridge::HologramThread> thread; ///< null: nothing is played
    std::string device;
    SceneSettings applied;        ///< what the thread has
    device::UserCaps appliedCaps; ///< the same of the user's environment
    bool isMuted = false;
    std::uint64_t frame = 0;
    double time_s = 0.0;  ///< of the last update
    bool isTimed = false; ///< there was one since midair_play()

    bridge::InjectedHandSource injected;
    std::unique_ptr<bridge::HandSource> source; ///< null: the injected hands
    std::unique_ptr<bridge::HandProximity> proximity = std::make_unique<bridge::HandProximity>();

    /// Why nothing is played, or an empty text.
    std::string whySilenced() const;
    /// Silences what is played until the next update.
    void silence();
    /// The array with the transducers that the settings name dead or weak. Throws InputError.
    std::shared_ptr<const ArrayPair> markedArray() const;
    /// The scene as it is, without hands.
    bridge::SceneSnapshot snapshot() const;
    /// Ends playing; returns the thread, to be destroyed without the mutex.
    std::unique_ptr<bridge::HologramThread> endPlaying();

private:
    mutable std::shared_ptr<const ArrayPair> _marked; ///< as _marks say
    mutable std::string _marks;
};

Handles<midair_array, const ArrayPair>& arrays();
Handles<midair_scene, Scene>& scenes();

/// Returns what a scene's handle stands for; fails inside a callback.
std::shared_ptr<Scene> sceneOf(midair_scene* handle);
/// Fails if there is none of that number.
SceneObject& objectOf(Scene& scene, midair_object object);

/// Puts the hands at \a time_s into \a snapshot, and finds what they touch.
void locateHands(Scene& scene, double time_s, bridge::SceneSnapshot& snapshot);

} // namespace midair::capi
