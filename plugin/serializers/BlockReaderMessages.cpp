// What a BlockReader tells of a file, and where in it.

#include "haptics/base/text/Words.h"
#include "plugin/serializers/BlockReader.h"
#include "plugin/serializers/FileOfStream.h"
#include "plugin/settings/Grants.h"

#include <osgMidair/HapticPoints>
#include <osgMidair/HapticScene>
#include <osgMidair/HapticSurface>

#include <osg/Notify>
#include <osgDB/Registry>

#include <algorithm>
#include <cstddef>
#include <vector>

namespace osgMidair
{

namespace
{

/// Makes \a object silence its scene because of \a reason. Returns false if it is none that is
/// felt.
bool silence(osg::Object& object, const std::string& reason)
{
    if (auto* scene = dynamic_cast<HapticScene*>(&object))
    {
        HapticSettings settings = scene->getSettings();
        settings.isSilenced = true;
        settings.whySilenced.push_back(reason);
        scene->setSettings(settings);
        return true;
    }
    auto* surface = dynamic_cast<HapticSurface*>(&object);
    auto* points = dynamic_cast<HapticPoints*>(&object);
    if (!surface && !points) return false;
    HapticPropertyHolder& holder = surface ? static_cast<HapticPropertyHolder&>(*surface) : *points;
    HapticProperty property = holder.getProperty();
    property.whySilenced.push_back(reason);
    holder.setProperty(property);
    return true;
}

} // namespace

const std::string& BlockReader::text()
{
    if (_text.empty()) _text = wholeText(*getStream());
    return _text;
}

std::ptrdiff_t BlockReader::lineAt(std::streamoff place)
{
    const auto end = std::min<std::streamoff>(place, static_cast<std::streamoff>(text().size()));
    return 1 + std::count(text().begin(), text().begin() + end, '\n');
}

/// "star.osgt:12: ", or as much of it as is known.
std::string BlockReader::placeIn(std::ptrdiff_t line)
{
    std::string place;
    const osgDB::Options* options = _stream.getOptions();
    if (options && !options->getDatabasePathList().empty())
        place = openFile(options->getDatabasePathList().front(), text());
    if (line > 0) place += place.empty() ? "line " : ":";
    if (line > 0) place += std::to_string(line);
    return place.empty() ? place : place + ": ";
}

std::string BlockReader::place()
{
    if (_block && _block->element) return placeIn(_block->element->line);
    const bool isKnown = _block && !_isXml && _block->place >= 0;
    return placeIn(isKnown ? lineAt(_block->place) : 0);
}

void BlockReader::complain(const std::string& what, bool concernsSafety)
{
    std::string told = place();
    if (_block)
    {
        told += _block->object.className();
        if (!_block->object.getName().empty()) told += " '" + _block->object.getName() + "'";
        told += ": ";
    }
    tell(told + what, concernsSafety);
}

void BlockReader::tell(std::string told, bool concernsSafety)
{
    told = printable(told);
    if (concernsSafety && _block && silence(_block->object, told + "; nothing is played"))
        told += "; nothing is played until that is right";
    OSG_WARN << "osgMidair: " << told << std::endl;
}

// OSG asks for the words that name classes by a word alone; other texts are in quotes.
bool BlockReader::isUnknownClass(const std::string& word)
{
    const std::size_t colons = word.find("::");
    return colons != std::string::npos && colons > 0 && word[0] != '"' &&
           !osgDB::Registry::instance()->getObjectWrapperManager()->findWrapper(word);
}

void BlockReader::tellSkipped(const std::string& first,
                              std::streamoff place,
                              const std::string& unknownClass,
                              bool concernsSafety)
{
    std::string told = placeIn(place >= 0 ? lineAt(place) : 0);
    if (unknownClass.empty())
        told += "OSG passes over \"" + first +
                "\" and what follows it in this object: it reads the properties of its own nodes "
                "in the order in which it writes them, and others not at all";
    else
    {
        std::vector<std::string> known;
        for (const auto& [name, wrapper] :
             osgDB::Registry::instance()->getObjectWrapperManager()->getWrapperMap())
            known.push_back(name);
        told += "unknown class \"" + unknownClass + "\"" +
                midair::base::didYouMean(unknownClass, known) + "; what it holds isn't there";
    }
    tell(told, concernsSafety);
}

void BlockReader::tellUnknown(const std::string& name)
{
    if (name == "UniqueID" && _block->isMisplaced) return; // told
    const std::vector<std::string> nearest = midair::base::nearestWords(name, nameList());
    // What nothing is near to may be anything, a limit of a newer kit as well.
    const bool mayBeSafety =
        nearest.empty() || std::any_of(nearest.begin(),
                                       nearest.end(),
                                       [this](const std::string& one)
                                       { return _block->names.at(one).concernsSafety; });
    complain("unknown property \"" + name + "\"" + midair::base::didYouMean(name, nameList()),
             mayBeSafety);
}

} // namespace osgMidair
