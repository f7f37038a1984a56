#pragma once

#include "engine-bridge/hands/Hand.h"
#include "engine-bridge/hands/HandProximity.h"
#include "engine-bridge/pipeline/HologramResult.h"
#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"

#include <osgMidair/Export>

#include <osg/Node>

#include <memory>
#include <optional>
#include <vector>

namespace osgMidair
{

class HapticOverlays;
class Overlay;

/// What stands behind an Overlay: follows the array, its fields and the hands in it, which no
/// installed header names. All in the update traversal's thread; what isn't overridden does
/// nothing.
class OSGMIDAIR_EXPORT OverlayPart
{
public:
    OverlayPart() = default;
    virtual ~OverlayPart();
    OverlayPart(const OverlayPart&) = delete;
    OverlayPart& operator=(const OverlayPart&) = delete;

    static OverlayPart& of(Overlay& overlay);

    /// The array and its air; again whenever they change. \a array is never null.
    virtual void setArray(const std::shared_ptr<const midair::haptics::TransducerArray>& array,
                          const midair::haptics::Medium& medium);

    /// The newest field; never null.
    virtual void setResult(const std::shared_ptr<const midair::bridge::HologramResult>& result);

    /// Hands and contacts (array frame) at \a time_s, the frame's simulation time; a frame after
    /// they were tracked.
    virtual void setHands(const std::vector<midair::bridge::HandCapsule>& capsules,
                          const std::vector<midair::bridge::HandContact>& contacts,
                          double time_s);
};

/// What stands behind a HapticOverlays: gives its overlays what the outermost HapticScene above it
/// plays. All in the update traversal's thread.
class OSGMIDAIR_EXPORT OverlayFeed
{
public:
    explicit OverlayFeed(HapticOverlays& overlays);

    static OverlayFeed& of(HapticOverlays& overlays);

    /// Array and air for all overlays, shown or not.
    void setArray(const std::shared_ptr<const midair::haptics::TransducerArray>& array,
                  const midair::haptics::Medium& medium);

    /// Hands \a result to what is shown, now; otherwise this comes by itself once a frame. Null:
    /// nothing happens.
    void show(const std::shared_ptr<const midair::bridge::HologramResult>& result);

    /// One frame of the HapticOverlays at the end of \a path.
    void update(const osg::NodePath& path);

private:
    /// Takes array, air, place and hands from the HapticScene on \a path; its field, or the last
    /// one where there is no scene.
    std::shared_ptr<const midair::bridge::HologramResult> follow(const osg::NodePath& path);

    HapticOverlays& _overlays;
    std::shared_ptr<const midair::bridge::HologramResult> _shown;
    unsigned int _shownMask = 0; ///< which overlays have been given _shown
    std::shared_ptr<const midair::haptics::TransducerArray> _array;
    std::optional<midair::haptics::Medium> _medium;
};

} // namespace osgMidair
