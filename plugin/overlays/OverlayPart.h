#pragma once

#include "engine-bridge/hands/Hand.h"
#include "engine-bridge/hands/HandProximity.h"
#include "engine-bridge/pipeline/HologramResult.h"
#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"

#include <osg/Node>

#include <memory>
#include <optional>
#include <vector>

namespace osgMidair
{

class HapticEngine;
class HapticOverlays;
class Overlay;

/// Implementation of an Overlay: receives the array, its fields and the hands, in types that no
/// installed header names. All functions are called on the thread of the update traversal; the
/// default implementations do nothing.
class OverlayPart
{
public:
    OverlayPart() = default;
    virtual ~OverlayPart();
    OverlayPart(const OverlayPart&) = delete;
    OverlayPart& operator=(const OverlayPart&) = delete;

    static OverlayPart& of(Overlay& overlay);

    /// Called with the array and the air, first and whenever they change. \a array is never null.
    virtual void setArray(const std::shared_ptr<const midair::haptics::TransducerArray>& array,
                          const midair::haptics::Medium& medium);

    /// Called with the newest field; never null.
    virtual void setResult(const std::shared_ptr<const midair::bridge::HologramResult>& result);

    /// True: setHands() is called while the overlay is shown.
    virtual bool followsHands() const { return false; }

    /// Called with hands and contacts (array frame) at \a time_s, the frame's simulation time, one
    /// frame after they were tracked.
    virtual void setHands(const std::vector<midair::bridge::HandCapsule>& capsules,
                          const std::vector<midair::bridge::HandContact>& contacts,
                          double time_s);
};

/// Implementation of HapticOverlays: passes what the outermost owner above it (HapticScene,
/// HapticCallback or HapticDevice) plays to its overlays. All functions are called on the thread of
/// the update traversal.
class OverlayFeed
{
public:
    explicit OverlayFeed(HapticOverlays& overlays);

    static OverlayFeed& of(HapticOverlays& overlays);

    /// Passes array and air to all overlays, shown or not.
    void setArray(const std::shared_ptr<const midair::haptics::TransducerArray>& array,
                  const midair::haptics::Medium& medium);

    /// Passes \a result to the overlays that are shown. update() calls it in each frame. Null: does
    /// nothing.
    void show(const std::shared_ptr<const midair::bridge::HologramResult>& result);

    /// Updates the HapticOverlays at the end of \a path; once per frame. \a time_s: the frame's
    /// simulation time; below 0: unknown.
    void update(const osg::NodePath& path, double time_s);

private:
    /// Takes array, air, place and hands from \a engine, which plays what is at the end of \a path.
    /// Returns its field.
    std::shared_ptr<const midair::bridge::HologramResult> follow(const HapticEngine& engine,
                                                                 const osg::NodePath& path);

    HapticOverlays& _overlays;
    std::shared_ptr<const midair::bridge::HologramResult> _shown;
    unsigned int _shownMask = 0; ///< which overlays have been given _shown
    std::shared_ptr<const midair::haptics::TransducerArray> _array;
    std::optional<midair::haptics::Medium> _medium;
};

} // namespace osgMidair
