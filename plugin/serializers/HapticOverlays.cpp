#include "haptics/base/text/Quantity.h"
#include "plugin/overlays/OverlayKinds.h"
#include "plugin/serializers/BlockReader.h"
#include "plugin/serializers/Wrappers.h"

#include <osgMidair/HapticOverlays>

#include <osg/Notify>
#include <osgDB/InputStream>
#include <osgDB/ObjectWrapper>
#include <osgDB/OutputStream>

#include <algorithm>
#include <string>
#include <vector>

namespace
{

using osgMidair::HapticOverlays;
using osgMidair::OverlayKind;
using osgMidair::overlayKinds;
using osgMidair::OverlayNumber;

bool isShown(const osg::Object& overlays, const OverlayKind& kind)
{
    return static_cast<const HapticOverlays&>(overlays).getOverlay(kind.name)->isShown();
}

void setShown(osg::Object& overlays, const OverlayKind& kind, bool shown)
{
    static_cast<HapticOverlays&>(overlays).getOverlay(kind.name)->setShown(shown);
}

/// A number of an overlay, and its default.
struct Stored
{
    const OverlayKind* kind;
    const OverlayNumber* number;
    double initial;
};

const std::vector<Stored>& storedNumbers()
{
    static const std::vector<Stored> all = []
    {
        std::vector<Stored> found;
        for (const auto& [place, kind] : overlayKinds())
            for (const OverlayNumber& number : kind.numbers)
                found.push_back({&kind, &number, number.get(*kind.make())});
        return found;
    }();
    return all;
}

double valueOf(const osg::Object& overlays, const Stored& one)
{
    return one.number->get(
        *static_cast<const HapticOverlays&>(overlays).getOverlay(one.kind->name));
}

void setNumber(osg::Object& overlays, const Stored& one, double value)
{
    if (!static_cast<HapticOverlays&>(overlays).setNumber(one.number->name, value))
        OSG_WARN << "osgMidair: " << one.number->name << " is " << value << ", should be "
                 << one.number->numbers() << "; " << one.initial << " is used" << std::endl;
}

/// Serializer of the overlays' numbers that aren't the default: by name, also in .osgb, so that an
/// overlay can have more of them.
class Numbers
{
public:
    static std::vector<Stored> changed(const osg::Object& overlays)
    {
        std::vector<Stored> found;
        for (const Stored& one : storedNumbers())
            if (valueOf(overlays, one) != one.initial) found.push_back(one);
        return found;
    }

    static void readBinary(osgDB::InputStream& is, osg::Object& overlays)
    {
        unsigned char count = 0;
        is >> count;
        for (unsigned char i = 0; i < count && !is.getException(); ++i)
        {
            std::string name;
            double value = 0.0;
            is >> name >> value;
            const auto known =
                std::find_if(storedNumbers().begin(),
                             storedNumbers().end(),
                             [&](const Stored& one) { return one.number->storedName() == name; });
            if (known != storedNumbers().end())
                setNumber(overlays, *known, value);
            else if (!is.getException())
                OSG_WARN << "osgMidair: overlays have no number of the name that a file gives"
                         << std::endl;
        }
    }

    static void writeBinary(osgDB::OutputStream& os, const osg::Object& overlays)
    {
        const std::vector<Stored> numbers = changed(overlays);
        os << static_cast<unsigned char>(numbers.size());
        for (const Stored& one : numbers)
            os << one.number->storedName() << valueOf(overlays, one);
    }

    static void readText(osgDB::InputStream& is, osg::Object& overlays)
    {
        for (const Stored& one : storedNumbers())
            if (is.matchString(one.number->storedName()))
            {
                const std::string& unit = one.number->unit;
                double value = 0.0;
                const auto isNumber = [&](const std::string& text)
                { return midair::base::parseQuantity(text, unit, value); };
                osgMidair::BlockReader& reader = osgMidair::BlockReader::of(is);
                const std::string text = reader.readValue(isNumber);
                const bool isIn = isNumber(text) && one.number->range.holds(value);
                if (isIn)
                    setNumber(overlays, one, value);
                else
                    reader.complain(one.number->storedName() + " can't be \"" + text +
                                        "\", should be " + one.number->numbers(),
                                    false);
            }
    }

    static void writeText(osgDB::OutputStream& os, const osg::Object& overlays)
    {
        for (const Stored& one : changed(overlays))
            os << os.PROPERTY(one.number->storedName().c_str()) << valueOf(overlays, one)
               << std::endl;
    }
};

constexpr unsigned char kNumbersFollow = 0x80;

/// Serializer of the switches of overlays that share a byte in .osgb. The lowest bit is set if the
/// first one is shown. Further bits are set if a later one isn't as it is by default, hidden for
/// most, so that it is that in files from before it existed. In text each has a name and is only
/// written when it isn't as by default. The last byte's
/// highest bit says that numbers of overlays follow; in text they follow by their names.
class Switches : public osgDB::BaseSerializer, public osgMidair::NamedProperties
{
public:
    Switches(std::vector<const OverlayKind*> kinds, bool isLast) :
        osgDB::BaseSerializer(READ_WRITE_PROPERTY),
        _kinds(std::move(kinds)),
        _name("Show" + _kinds.front()->name),
        _isLast(isLast)
    {
    }

    const std::string& getName() const override { return _name; }

    std::vector<std::string> names() const override
    {
        std::vector<std::string> all;
        for (const OverlayKind* kind : _kinds)
            all.push_back("Show" + kind->name);
        if (_isLast)
            for (const Stored& one : storedNumbers())
                all.push_back(one.number->storedName());
        return all;
    }

    bool read(osgDB::InputStream& is, osg::Object& object) override
    {
        if (is.isBinary())
        {
            unsigned char bits = 1;
            is >> bits;
            for (const OverlayKind* kind : _kinds)
                setShown(object, *kind, ((bits & bitOf(*kind)) != 0) == isSet(*kind, true));
            if (_isLast && (bits & kNumbersFollow) != 0) Numbers::readBinary(is, object);
            return true;
        }
        for (const OverlayKind* kind : _kinds)
            if (is.matchString("Show" + kind->name))
            {
                osgMidair::BlockReader& reader = osgMidair::BlockReader::of(is);
                const std::string text = reader.readValue();
                bool shown = true;
                if (!midair::base::parseYesNo(text, shown))
                    reader.complain("Show" + kind->name + " can't be \"" + text +
                                        "\", should be TRUE or FALSE",
                                    false);
                setShown(object, *kind, shown);
            }
        if (_isLast) Numbers::readText(is, object);
        return true;
    }

    bool write(osgDB::OutputStream& os, const osg::Object& object) override
    {
        unsigned char bits = 0;
        for (const OverlayKind* kind : _kinds)
        {
            const bool shown = isShown(object, *kind);
            if (isSet(*kind, shown)) bits |= bitOf(*kind);
            if (!os.isBinary() && shown == kind->isHidden)
                os << os.PROPERTY(("Show" + kind->name).c_str()) << shown << std::endl;
        }
        const bool numbersFollow = _isLast && !Numbers::changed(object).empty();
        if (numbersFollow) bits |= kNumbersFollow;
        if (os.isBinary()) os << bits;
        if (numbersFollow && os.isBinary()) Numbers::writeBinary(os, object);
        if (numbersFollow && !os.isBinary()) Numbers::writeText(os, object);
        return true;
    }

private:
    /// Returns the bit of \a kind for \a shown.
    bool isSet(const OverlayKind& kind, bool shown) const
    {
        return &kind == _kinds.front() ? shown : shown == kind.isHidden;
    }
    unsigned char bitOf(const OverlayKind& kind) const
    {
        return static_cast<unsigned char>(1U << (kind.place - _kinds.front()->place));
    }

    const std::vector<const OverlayKind*> _kinds;
    const std::string _name;
    const bool _isLast;
};

} // namespace

// Not written as a Group, since it makes its own children.
void osgMidair::registerHapticOverlays()
{
    static const osgDB::RegisterCustomWrapperProxy proxy(
        []() -> osg::Object* { return new HapticOverlays; },
        "osgMidair",
        "osgMidair::HapticOverlays",
        "osgMidair::Properties osg::Object osg::Node osgMidair::HapticOverlays",
        [](const char*, osgDB::ObjectWrapper* wrapper)
        {
            std::vector<const OverlayKind*> together;
            for (const auto& [place, kind] : overlayKinds())
                if (place < OverlayKind::kFirstKinds)
                    wrapper->addSerializer(new Switches({&kind}, false),
                                           osgDB::BaseSerializer::RW_BOOL);
                else
                    together.push_back(&kind);
            wrapper->addSerializer(new Switches(together, true), osgDB::BaseSerializer::RW_BOOL);
        });
}
