#include "haptics/base/text/Quantity.h"
#include "plugin/overlays/OverlayPart.h"
#include "plugin/serializers/BlockReader.h"
#include "plugin/serializers/Wrappers.h"

#include <osgMidair/HapticOverlays>

#include <osg/Notify>
#include <osgDB/InputStream>
#include <osgDB/ObjectWrapper>
#include <osgDB/OutputStream>

#include <algorithm>

namespace
{

using osgMidair::HapticOverlays;
using osgMidair::Overlay;
using osgMidair::OverlayKind;
using osgMidair::overlayKinds;
using osgMidair::OverlayNumber;

/// A stored value of an overlay: its visibility, or a number.
struct Kept
{
    const OverlayKind* kind;
    const OverlayNumber* number; ///< null: the visibility
    std::string name;            ///< in files
    double initial;              ///< the default
};

const std::vector<Kept>& allKept()
{
    static const std::vector<Kept> all = []
    {
        std::vector<Kept> found;
        for (const auto& [place, kind] : overlayKinds())
            found.push_back({&kind, nullptr, "Show" + kind.name, kind.isHidden ? 0.0 : 1.0});
        for (const auto& [place, kind] : overlayKinds())
            for (const OverlayNumber& number : kind.numbers)
                found.push_back({&kind, &number, number.storedName(), number.get(*kind.make())});
        return found;
    }();
    return all;
}

Overlay& overlayOf(const osg::Object& overlays, const Kept& one)
{
    return *static_cast<const HapticOverlays&>(overlays).getOverlay(one.kind->name);
}

double valueOf(const osg::Object& overlays, const Kept& one)
{
    const Overlay& overlay = overlayOf(overlays, one);
    return one.number ? one.number->get(overlay) : static_cast<double>(overlay.isShown());
}

void setValue(osg::Object& overlays, const Kept& one, double value)
{
    if (!one.number)
        overlayOf(overlays, one).setShown(value != 0.0);
    else if (!static_cast<HapticOverlays&>(overlays).setNumber(one.number->name, value))
        OSG_WARN << "osgMidair: " << one.number->name << " is " << value << ", should be "
                 << one.number->numbers() << "; " << one.initial << " is used" << std::endl;
}

/// Serializer of values that differ from the defaults: by name, also in .osgb, so that overlays and
/// numbers can be added.
class Looks : public osgMidair::NamedSerializer
{
public:
    Looks() : NamedSerializer("Overlays") {}

    std::vector<std::string> names() const override
    {
        std::vector<std::string> all;
        for (const Kept& one : allKept())
            all.push_back(one.name);
        return all;
    }

    bool read(osgDB::InputStream& is, osg::Object& object) override
    {
        if (is.isBinary())
            readBinary(is, object);
        else
            for (const Kept& one : allKept())
                if (is.matchString(one.name)) readText(is, object, one);
        return true;
    }

    bool write(osgDB::OutputStream& os, const osg::Object& object) override
    {
        std::vector<const Kept*> changed;
        for (const Kept& one : allKept())
            if (valueOf(object, one) != one.initial) changed.push_back(&one);
        if (os.isBinary()) os << static_cast<unsigned char>(changed.size());
        for (const Kept* one : changed)
        {
            const double value = valueOf(object, *one);
            if (os.isBinary())
                os << one->name << value;
            else if (one->number)
                os << os.PROPERTY(one->name.c_str()) << value << std::endl;
            else
                os << os.PROPERTY(one->name.c_str()) << (value != 0.0) << std::endl;
        }
        return true;
    }

private:
    static void readBinary(osgDB::InputStream& is, osg::Object& overlays)
    {
        unsigned char count = 0;
        is >> count;
        for (unsigned char i = 0; i < count && !is.getException(); ++i)
        {
            std::string name;
            double value = 0.0;
            is >> name >> value;
            const auto known = std::find_if(allKept().begin(),
                                            allKept().end(),
                                            [&](const Kept& one) { return one.name == name; });
            if (known != allKept().end())
                setValue(overlays, *known, value);
            else if (!is.getException())
                OSG_WARN << "osgMidair: a file names an unknown number of an overlay" << std::endl;
        }
    }

    static void readText(osgDB::InputStream& is, osg::Object& overlays, const Kept& one)
    {
        osgMidair::BlockReader& reader = osgMidair::BlockReader::of(is);
        double value = 0.0;
        bool shown = false;
        const auto isNumber = [&](const std::string& text)
        { return midair::base::parseQuantity(text, one.number->unit, value); };
        const std::string text = one.number ? reader.readValue(isNumber) : reader.readValue();
        const bool isRead = one.number ? isNumber(text) && one.number->range.holds(value)
                                       : midair::base::parseYesNo(text, shown);
        if (isRead)
            setValue(overlays, one, one.number ? value : static_cast<double>(shown));
        else
            reader.complain(one.name + " can't be \"" + text + "\", should be " +
                                (one.number ? one.number->numbers() : "TRUE or FALSE"),
                            false);
    }
};

} // namespace

// Not written as a Group, because it creates its own children.
void osgMidair::registerHapticOverlays()
{
    static const osgDB::RegisterCustomWrapperProxy proxy(
        []() -> osg::Object* { return new HapticOverlays; },
        "osgMidair",
        "osgMidair::HapticOverlays",
        "osgMidair::Properties osg::Object osg::Node osgMidair::HapticOverlays",
        [](const char*, osgDB::ObjectWrapper* wrapper)
        {
            addFormatVersion(*wrapper);
            wrapper->addSerializer(new Looks, osgDB::BaseSerializer::RW_USER);
        });
}
