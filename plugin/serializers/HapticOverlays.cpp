#include "plugin/overlays/OverlayKinds.h"

#include <osgMidair/HapticOverlays>

#include <osgDB/InputStream>
#include <osgDB/ObjectWrapper>
#include <osgDB/OutputStream>

#include <string>
#include <vector>

namespace
{

using osgMidair::HapticOverlays;
using osgMidair::OverlayKind;
using osgMidair::overlayKinds;

bool isShown(const osg::Object& overlays, const OverlayKind& kind)
{
    return static_cast<const HapticOverlays&>(overlays).getOverlay(kind.name)->isShown();
}

void setShown(osg::Object& overlays, const OverlayKind& kind, bool shown)
{
    static_cast<HapticOverlays&>(overlays).getOverlay(kind.name)->setShown(shown);
}

/// Serializer of the switches of overlays that share a byte in .osgb. The lowest bit is set if the
/// first one is shown. Further bits are set if a later one is hidden, so that files from before it
/// existed show it. In text each has a name and is only written when hidden.
class Switches : public osgDB::BaseSerializer
{
public:
    explicit Switches(std::vector<const OverlayKind*> kinds) :
        osgDB::BaseSerializer(READ_WRITE_PROPERTY),
        _kinds(std::move(kinds)),
        _name("Show" + _kinds.front()->name)
    {
    }

    const std::string& getName() const override { return _name; }

    bool read(osgDB::InputStream& is, osg::Object& object) override
    {
        if (is.isBinary())
        {
            unsigned char bits = 1;
            is >> bits;
            for (const OverlayKind* kind : _kinds)
                setShown(object, *kind, ((bits & bitOf(*kind)) != 0) == isFirst(*kind));
            return true;
        }
        for (const OverlayKind* kind : _kinds)
            if (is.matchString("Show" + kind->name))
            {
                bool shown = true;
                is >> shown;
                setShown(object, *kind, shown);
            }
        return true;
    }

    bool write(osgDB::OutputStream& os, const osg::Object& object) override
    {
        unsigned char bits = 0;
        for (const OverlayKind* kind : _kinds)
        {
            const bool shown = isShown(object, *kind);
            if (shown == isFirst(*kind)) bits |= bitOf(*kind);
            if (!os.isBinary() && !shown)
                os << os.PROPERTY(("Show" + kind->name).c_str()) << false << std::endl;
        }
        if (os.isBinary()) os << bits;
        return true;
    }

private:
    bool isFirst(const OverlayKind& kind) const { return &kind == _kinds.front(); }
    unsigned char bitOf(const OverlayKind& kind) const
    {
        return static_cast<unsigned char>(1U << (kind.place - _kinds.front()->place));
    }

    const std::vector<const OverlayKind*> _kinds;
    const std::string _name;
};

} // namespace

// Not written as a Group, since it makes its own children.
REGISTER_CUSTOM_OBJECT_WRAPPER(osgMidair,
                               osgMidair_HapticOverlays,
                               new osgMidair::HapticOverlays,
                               osgMidair::HapticOverlays,
                               "osg::Object osg::Node osgMidair::HapticOverlays")
{
    (void)domain; // unused parameter of the macro
    std::vector<const OverlayKind*> together;
    for (const auto& [place, kind] : overlayKinds())
        if (place < OverlayKind::kFirstKinds)
            wrapper->addSerializer(new Switches({&kind}), osgDB::BaseSerializer::RW_BOOL);
        else
            together.push_back(&kind);
    wrapper->addSerializer(new Switches(together), osgDB::BaseSerializer::RW_BOOL);
}
