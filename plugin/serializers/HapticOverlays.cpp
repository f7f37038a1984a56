#include <osgMidair/HapticOverlays>

#include <osgDB/InputStream>
#include <osgDB/ObjectWrapper>
#include <osgDB/OutputStream>

#include <array>

namespace
{

using osgMidair::HapticOverlays;

/// A switch that came after the format was frozen.
struct Later
{
    const char* name;
    bool (HapticOverlays::*get)() const;
    void (HapticOverlays::*set)(bool);
};

constexpr std::array<Later, 2> kLater = {
    {{"ShowFieldVolume", &HapticOverlays::getShowFieldVolume, &HapticOverlays::setShowFieldVolume},
     {"ShowHands", &HapticOverlays::getShowHands, &HapticOverlays::setShowHands}}};

/// ShowFigures and what came later. .osgb is positional and read ShowFigures as a byte, 0 or 1: its other bits say what of
/// the later ones is off, so that old files are read as before. In text each has its name and may be missing.
class FiguresAndLater : public osgDB::BaseSerializer
{
public:
    FiguresAndLater() : osgDB::BaseSerializer(READ_WRITE_PROPERTY) {}

    const std::string& getName() const override
    {
        static const std::string name = "ShowFigures";
        return name;
    }

    bool read(osgDB::InputStream& is, osg::Object& object) override
    {
        auto& overlays = static_cast<HapticOverlays&>(object);
        if (is.isBinary())
        {
            unsigned char bits = 1;
            is >> bits;
            overlays.setShowFigures((bits & 1U) != 0);
            for (std::size_t i = 0; i < kLater.size(); ++i)
                (overlays.*kLater[i].set)((bits & (2U << i)) == 0);
            return true;
        }
        bool shown = true;
        if (is.matchString("ShowFigures"))
        {
            is >> shown;
            overlays.setShowFigures(shown);
        }
        for (const Later& later : kLater)
            if (is.matchString(later.name))
            {
                is >> shown;
                (overlays.*later.set)(shown);
            }
        return true;
    }

    bool write(osgDB::OutputStream& os, const osg::Object& object) override
    {
        const auto& overlays = static_cast<const HapticOverlays&>(object);
        if (os.isBinary())
        {
            unsigned char bits = overlays.getShowFigures() ? 1 : 0;
            for (std::size_t i = 0; i < kLater.size(); ++i)
                if (!(overlays.*kLater[i].get)()) bits |= static_cast<unsigned char>(2U << i);
            os << bits;
            return true;
        }
        if (!overlays.getShowFigures()) os << os.PROPERTY("ShowFigures") << false << std::endl;
        for (const Later& later : kLater)
            if (!(overlays.*later.get)()) os << os.PROPERTY(later.name) << false << std::endl;
        return true;
    }
};

} // namespace

// Not written as a Group: its children are its own affair. .osgb is positional: this order is frozen.
REGISTER_CUSTOM_OBJECT_WRAPPER(osgMidair,
                               osgMidair_HapticOverlays,
                               new osgMidair::HapticOverlays,
                               osgMidair::HapticOverlays,
                               "osg::Object osg::Node osgMidair::HapticOverlays")
{
    ADD_BOOL_SERIALIZER(ShowControlPoints, true);
    ADD_BOOL_SERIALIZER(ShowFieldSlice, true);
    ADD_BOOL_SERIALIZER(ShowArray, true);
    ADD_BOOL_SERIALIZER(ShowWorkspace, true);
    wrapper->addSerializer(new FiguresAndLater, osgDB::BaseSerializer::RW_BOOL);
}
