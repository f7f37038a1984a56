#pragma once

#include <osgMidair/Overlay>

#include <map>
#include <string>

namespace osgMidair
{

/// A kind of overlay, of which every HapticOverlays has one.
struct OverlayKind
{
    /// Place in files, from 1; what is stored keeps its own. Those up to kFirstKinds have a byte
    /// each in .osgb, later ones a bit in the last of these; kMostKinds is the end.
    int place = 0;
    std::string name; ///< of its switch in files behind "Show": "FieldSlice"
    std::string word; ///< on command lines: "slice"
    std::string what; ///< in a viewer's help, behind "show or hide": "the slice of the field"
    int key = 0;      ///< of osgGA::GUIEventAdapter; shows and hides it
    /// Drawn in the array's frame in this order; 0: in the window's own.
    int layer = 0;
    osg::ref_ptr<Overlay> (*make)() = nullptr;

    static constexpr int kFirstKinds = 5;
    static constexpr int kMostKinds = kFirstKinds + 7;

    std::string keyName() const; ///< "F3"
};

/// All kinds by their place.
const std::map<int, OverlayKind>& overlayKinds();

/// Makes a kind known: a static one of these in its source is all that an overlay needs. What
/// another kind has already (place, name, word, key), or the keys F7 (all) and F8 (mute), is
/// refused with a message, and the kind is left out.
class OverlayRegistration
{
public:
    explicit OverlayRegistration(const OverlayKind& kind);
};

/// Makes an \a O, for OverlayKind::make.
template<class O>
osg::ref_ptr<Overlay> makeOverlay()
{
    return new O;
}

} // namespace osgMidair
