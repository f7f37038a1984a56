#pragma once

#include "engine-bridge/hands/Hand.h"
#include "engine-bridge/hands/HandProximity.h"
#include "engine-bridge/pipeline/HologramResult.h"
#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/settings/Setting.h"

#include <osgMidair/Overlay>

#include <osg/Node>

#include <atomic>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace osgUtil
{
class CullVisitor;
}

namespace osgMidair
{

/// A number that controls an overlay's look: in files ("SliceRadius"), on command lines
/// ("sliceRadius") and in copies.
struct OverlayNumber : midair::base::SettingFacts
{
    void (*set)(Overlay&, double) = nullptr;
    double (*get)(const Overlay&) = nullptr;
};

/// Makes an OverlayNumber from a setter and a getter of the overlay \a O.
template<class O, auto Set, auto Get>
OverlayNumber overlayNumber(const char* name,
                            const char* help,
                            const midair::base::Range& range,
                            const char* unit = "")
{
    using Value = decltype((std::declval<const O&>().*Get)());
    OverlayNumber number;
    number.name = name;
    number.help = help;
    number.range = range;
    number.unit = unit;
    number.set = [](Overlay& overlay, double value)
    { (static_cast<O&>(overlay).*Set)(static_cast<Value>(value)); };
    number.get = [](const Overlay& overlay)
    { return static_cast<double>((static_cast<const O&>(overlay).*Get)()); };
    return number;
}

/// A kind of overlay; every HapticOverlays has one overlay of each kind.
struct OverlayKind
{
    int place = 0;    ///< order in lists, and of its key
    std::string name; ///< name of its switch in files, after "Show": "FieldSlice"
    std::string word; ///< word on command lines: "slice"
    std::string what; ///< text in a viewer's help, after "show or hide": "the slice of the field"
    std::string seen; ///< what is seen, in the documents' words
    int key = 0;      ///< key that shows and hides it, of osgGA::GUIEventAdapter; 0: none
    /// Overlays in the array's frame are drawn in this order; 0: drawn in the window instead.
    int layer = 0;
    osg::ref_ptr<Overlay> (*make)() = nullptr;
    std::vector<OverlayNumber> numbers = {};
    bool isHidden = false; ///< until it is switched on

    bool isNamed(const std::string& text) const { return text == name || text == word; }
    std::string keyName() const; ///< "F3"; empty without a key
};

/// Returns all kinds in order. Keys, files, options and documents take their names from here.
const std::map<int, OverlayKind>& overlayKinds();

/// Returns the kind by its name in files or word on command lines; null, with \a error and the
/// nearest name, if there is none.
const OverlayKind* findOverlayKind(const std::string& name, std::string& error);

/// Registers a kind of overlay: define a static object of this class in the overlay's source. A
/// kind whose place, name, word or key is taken, or whose key is F1 (list of keys), F7 (all) or F8
/// (mute), is refused with a message.
class OverlayRegistration
{
public:
    explicit OverlayRegistration(const OverlayKind& kind);
};

/// Makes an overlay of class \a O, for OverlayKind::make.
template<class O>
osg::ref_ptr<Overlay> makeOverlay()
{
    return new O;
}

class HapticEngine;
class HapticOverlays;
class Overlay;

/// Implementation of an Overlay: receives the array, its fields and the hands, in types that no
/// installed header names. All functions are called on the update thread; the default
/// implementations do nothing.
class OverlayPart
{
public:
    OverlayPart() = default;
    virtual ~OverlayPart() = default;
    OverlayPart(const OverlayPart&) = delete;
    OverlayPart& operator=(const OverlayPart&) = delete;

    static OverlayPart& of(Overlay& overlay);

    /// Called with the array and the air, first and after each change. \a array is never null.
    virtual void setArray(const std::shared_ptr<const midair::haptics::TransducerArray>& /*array*/,
                          const midair::haptics::Medium& /*medium*/)
    {
    }

    /// Called with the newest field; never null.
    virtual void setResult(const std::shared_ptr<const midair::bridge::HologramResult>& /*result*/)
    {
    }

    /// True: setHands() is called while the overlay is shown.
    virtual bool followsHands() const { return false; }

    /// Called before setHands() with what is said beside the first hand; may be empty.
    virtual void setHandNote(const std::string& /*note*/) {}

    /// Called with hands and contacts (array frame) at \a time_s, the frame's simulation time, one
    /// frame after they were tracked.
    virtual void setHands(const std::vector<midair::bridge::HandCapsule>& /*capsules*/,
                          const std::vector<midair::bridge::HandContact>& /*contacts*/,
                          double /*time_s*/)
    {
    }

    /// For a Hud: called in every frame of \a overlays, even if the Hud is hidden. \a engine plays
    /// the scene; null: none. \a time_s: the frame's simulation time; below 0: unknown.
    virtual void
    update(const HapticOverlays& /*overlays*/, const HapticEngine* /*engine*/, double /*time_s*/)
    {
    }

    /// For a Hud: called when \a key of the overlays was pressed.
    virtual void noteKey(int /*key*/) {}
};

/// Implementation of HapticOverlays: passes the field of the outermost owner above it (HapticScene,
/// HapticCallback or HapticDevice) to its overlays. All functions are called on the update thread.
class OverlayFeed
{
public:
    explicit OverlayFeed(HapticOverlays& overlays);

    static OverlayFeed& of(const HapticOverlays& overlays);

    /// Passes array and air to all overlays, including hidden ones.
    void setArray(const std::shared_ptr<const midair::haptics::TransducerArray>& array,
                  const midair::haptics::Medium& medium);

    /// Passes \a result to the visible overlays. update() calls it in each frame. Null: does
    /// nothing.
    void show(const std::shared_ptr<const midair::bridge::HologramResult>& result);

    /// Updates the HapticOverlays at the end of \a path; once per frame. \a time_s: the frame's
    /// simulation time; below 0: unknown.
    void update(const osg::NodePath& path, double time_s);

    /// Notes which of the overlays that are shown \a visitor's view has in sight. Any thread that
    /// culls.
    void noteSight(osgUtil::CullVisitor& visitor);

    /// Returns false if the overlay number \a place was shown and no view had it in sight in the
    /// last frame that was drawn.
    bool isInSight(std::size_t place) const { return (_inSight >> place & 1U) != 0; }

private:
    /// Takes array, air, place and hands from \a engine, which plays the end of \a path. Returns
    /// its field.
    std::shared_ptr<const midair::bridge::HologramResult> follow(const HapticEngine& engine,
                                                                 const osg::NodePath& path);

    HapticOverlays& _overlays;
    std::shared_ptr<const midair::bridge::HologramResult> _shown;
    unsigned int _shownMask = 0; ///< bits of the overlays that have received _shown
    std::shared_ptr<const midair::haptics::TransducerArray> _array;
    std::optional<midair::haptics::Medium> _medium;
    std::atomic<unsigned int> _seen{0}; ///< bits of overlays that views have in sight in this frame
    unsigned int _inSight = ~0U;        ///< in the last frame
};

} // namespace osgMidair
