#include "plugin/serializers/BlockReader.h"

#include "engine-bridge/scene/GeometryReader.h"
#include "haptics/base/text/Words.h"
#include "plugin/serializers/ObjectNumbers.h"
#include "plugin/settings/Grants.h"

#include <osgMidair/HapticPoints>
#include <osgMidair/HapticScene>
#include <osgMidair/HapticSurface>

#include <osg/Notify>
#include <osgDB/Registry>

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <istream>
#include <system_error>
#include <utility>

namespace osgMidair
{

namespace
{

/// Returns the first \a size bytes of \a stream's buffer without moving its position; empty if it
/// can't be read again.
std::string beginning(std::istream& stream, std::size_t size)
{
    std::streambuf* buffer = stream.rdbuf();
    const auto before = buffer->pubseekoff(0, std::ios::cur, std::ios::in);
    const std::streampos none(std::streamoff(-1));
    if (before == none || buffer->pubseekpos(0, std::ios::in) == none) return {};
    std::string text(size, '\0');
    text.resize(static_cast<std::size_t>(
        buffer->sgetn(text.data(), static_cast<std::streamsize>(text.size()))));
    buffer->pubseekpos(before, std::ios::in);
    return text;
}

/// The same for the whole buffer.
std::string wholeText(std::istream& stream)
{
    std::streambuf* buffer = stream.rdbuf();
    const auto before = buffer->pubseekoff(0, std::ios::cur, std::ios::in);
    const auto size = buffer->pubseekoff(0, std::ios::end, std::ios::in);
    const std::streampos none(std::streamoff(-1));
    if (before == none || size == none) return {};
    buffer->pubseekpos(before, std::ios::in);
    return beginning(stream, static_cast<std::size_t>(std::streamoff(size)));
}

// Returns the name of the file in \a folder that is being read and has the content \a text; empty
// if there is none. OSG passes serializers only an open stream and the folder, so the open files
// are taken from Linux.
std::string openFile(const std::string& folder, const std::string& text)
{
    namespace fs = std::filesystem;
    std::error_code error;
    const fs::path wanted = fs::weakly_canonical(folder.empty() ? "." : folder, error);
    for (const auto& entry : fs::directory_iterator("/proc/self/fd", error))
    {
        std::error_code none;
        const fs::path file = fs::read_symlink(entry.path(), none);
        if (none || !fs::is_regular_file(file, none)) continue;
        if (fs::weakly_canonical(file.parent_path(), none) != wanted ||
            fs::file_size(file, none) != text.size())
            continue;
        std::ifstream in(file, std::ios::binary);
        if (wholeText(in) == text) return file.filename().string();
    }
    return {};
}

/// Gives access to the iterator and the object numbers of OSG's stream.
struct StreamParts : osgDB::InputStream
{
    static osg::ref_ptr<osgDB::InputIterator>& iterator(osgDB::InputStream& in)
    {
        return in.*(&StreamParts::_in);
    }
    static const IdentifierMap& identifiers(osgDB::InputStream& in)
    {
        return in.*(&StreamParts::_identifierMap);
    }
};

// Messages of a BlockReader about a file, with positions.

/// Makes \a object silence its scene for \a reason. Returns false if it isn't haptic.
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

BlockReader& BlockReader::of(osgDB::InputStream& in)
{
    osgDB::InputIterator* current = StreamParts::iterator(in).get();
    if (auto* known = dynamic_cast<BlockReader*>(current)) return *known;
    auto* reader = new BlockReader(in, *current);
    in.setInputIterator(reader);
    return *reader;
}

BlockReader::BlockReader(osgDB::InputStream& in, osgDB::InputIterator& inner) :
    _stream(in),
    _inner(&inner)
{
    setStream(inner.getStream());
    setInputStream(&in);
    _isXml = beginning(*getStream(), 5) == "<?xml";
    const std::string wrong = _isXml ? repeatedXmlNumber(text()) : repeatedNumber(text());
    if (!wrong.empty()) in.throwException("osgMidair: " + wrong);
}

void BlockReader::readString(std::string& s)
{
    if (_next.empty())
        counted().readString(s);
    else
        s = std::exchange(_next, {});
    if (!_isXml && isUnknownClass(s)) _unknownClass = s;
}

bool BlockReader::matchString(const std::string& str)
{
    if (_ended) return false;
    if (_next.empty())
    {
        if (_isXml && _block && _words >= _lastWord) return false;
        const bool isNext = _inner->matchString(str);
        if (isNext) ++_words;
        return isNext;
    }
    if (_next != str) return false;
    _next.clear();
    return true;
}

void BlockReader::readWrappedString(std::string& str)
{
    _inner->readWrappedString(str);
    _words += std::max(1, countWords(str));
}

void BlockReader::advanceToCurrentEndBracket()
{
    // The end may have been read ahead, after the last value of an object without a block.
    const bool isThere = _ended || _next == "}";
    _ended = false;
    _next.clear();
    if (isThere) return;
    if (_isXml)
        _inner->advanceToCurrentEndBracket();
    else
        skipRest();
}

// Skips what OSG's reader leaves of one of its objects: an unknown class or property, or one out of
// order, and everything after it.
void BlockReader::skipRest()
{
    const std::string unknownClass = std::exchange(_unknownClass, {});
    std::string first;
    std::streamoff place = 0;
    bool concernsSafety = false;
    int depth = 0;
    for (std::string next = word(); !next.empty() && !_stream.getException(); next = word())
    {
        if (next == "}" && depth-- == 0) break;
        if (next == "{") ++depth;
        if (next[0] == '"') quoted(next);
        // These hide objects that must not be played, or hold the tags.
        if (next == "NodeMask" || next == "UserDataContainer") concernsSafety = true;
        if (!first.empty()) continue;
        first = next;
        place = getStream()->rdbuf()->pubseekoff(0, std::ios::cur, std::ios::in);
    }
    if (!first.empty()) tellSkipped(first, place, unknownClass, concernsSafety);
}

// A class has the serializers of all its associates.
BlockReader::Names BlockReader::namesOf(const osg::Object& object)
{
    Names all;
    osgDB::ObjectWrapperManager& manager = *osgDB::Registry::instance()->getObjectWrapperManager();
    osgDB::ObjectWrapper* wrapper =
        manager.findWrapper(std::string(object.libraryName()) + "::" + object.className());
    if (!wrapper) return all;
    for (const osgDB::ObjectWrapperAssociate& associate : wrapper->getAssociates())
    {
        osgDB::ObjectWrapper* part = manager.findWrapper(associate._name);
        if (!part) continue;
        for (const auto& serializer : part->getSerializerList())
        {
            if (!serializer->supportsReadWrite()) continue;
            const auto* own = dynamic_cast<const NamedSerializer*>(serializer.get());
            // A node mask hides objects that must not be played.
            const bool isSafety = own ? own->concernsSafety() : serializer->getName() == "NodeMask";
            const std::vector<std::string> names =
                own ? own->names() : std::vector<std::string>{serializer->getName()};
            for (const std::string& name : names)
                all.insert_or_assign(name, Known{serializer.get(), isSafety});
        }
    }
    return all;
}

std::vector<std::string> BlockReader::nameList() const
{
    std::vector<std::string> names;
    for (const auto& [name, known] : _block->names)
        names.push_back(name);
    return names;
}

void BlockReader::readBlock(osg::Object& object)
{
    Block block{object, namesOf(object), {}};
    Block* outer = std::exchange(_block, &block);
    const int outerLast = _lastWord;
    block.place = getStream()->rdbuf()->pubseekoff(0, std::ios::cur, std::ios::in);
    block.isMisplaced = _stream.PROPERTY._name != "UniqueID";
    if (block.isMisplaced)
        complain("\"" + _stream.PROPERTY._name +
                     "\" precedes UniqueID, which must come first; it was not read",
                 true);
    if (!_isXml)
        readPlain();
    else
    {
        if (!_objects) _objects = xmlObjects(text());
        const auto& all = StreamParts::identifiers(_stream);
        const auto id = std::find_if(
            all.begin(), all.end(), [&](const auto& known) { return known.second == &object; });
        const auto elements = id == all.end() ? _objects->end() : _objects->find(id->first);
        if (elements != _objects->end())
            readXml(elements->second);
        else
            complain("the file's elements are malformed", true);
    }
    _block = outer;
    _lastWord = outerLast;
    _ended = true;
}

void BlockReader::readPlain()
{
    std::string name = word();
    while (!name.empty() && name != "}" && !_stream.getException())
    {
        _block->place = getStream()->rdbuf()->pubseekoff(0, std::ios::cur, std::ios::in);
        if (_block->names.count(name) > 0)
        {
            readNamed(name);
            name = word();
            continue;
        }
        if (name[0] != '"')
        {
            tellUnknown(name);
            name = skipValue(name);
            continue;
        }
        complain("the text \"" + quoted(name) +
                     "\" is in the place of a property's name; only blanks may separate a name "
                     "from its value",
                 true);
        name = skipValue("text");
    }
}

// OSG's iterator delivers the outline's XML word by word; both advance together.
void BlockReader::readXml(const std::vector<XmlElement>& elements)
{
    for (const XmlElement& element : elements)
    {
        _block->element = &element;
        _block->isAttributeRead = false;
        std::string name = word();
        // Skips the rest of the previous property that its serializer didn't read.
        while (name != element.name && !name.empty() && !_stream.getException())
            name = word();
        if (name.empty()) break;
        _lastWord = _words + element.words;
        const auto known = _block->names.find(name);
        if (known != _block->names.end() && element.words == 0)
            complain(name + " has no value", known->second.concernsSafety);
        else if (known != _block->names.end())
            readNamed(name);
        else
            tellUnknown(name);
        if (known != _block->names.end()) continue;
        for (int i = 0; i < element.words; ++i)
            word();
    }
    _block->element = nullptr;
}

void BlockReader::readNamed(const std::string& name)
{
    const Known known = _block->names.at(name);
    if (!_block->seen.insert(name).second) complain(name + " occurs twice", known.concernsSafety);
    _next = name;
    if (!known.serializer->read(_stream, _block->object))
        complain(name + " can't be read", known.concernsSafety);
}

// Skips the value after the unknown \a name: the next word, and brackets, quotes or numbers.
// Returns the word after that, a name or the object's end.
std::string BlockReader::skipValue(const std::string& name)
{
    const auto isNext = [this](const std::string& word, bool isFirst)
    {
        if (word == "}" || _block->names.count(word) > 0) return true;
        return !isFirst && std::isalpha(static_cast<unsigned char>(word[0])) != 0;
    };
    int depth = name == "{" ? 1 : 0;
    bool isFirst = true;
    for (std::string next = word(); !next.empty(); next = word())
    {
        if (_stream.getException()) break;
        if (depth == 0 && isNext(next, isFirst)) return next;
        if (next[0] == '"') quoted(next);
        if (next == "{") ++depth;
        if (next == "}") --depth;
        isFirst = false;
    }
    return {};
}

// In XML an attribute that ends with a blank is followed by an empty word.
std::string BlockReader::word()
{
    if (!_next.empty()) return std::exchange(_next, {});
    std::string read;
    for (int i = 0; i < 3 && read.empty(); ++i)
        _inner->readString(read);
    if (!read.empty()) ++_words;
    return read;
}

// Reads until the quotes that \a first opens are closed, and returns the text between them.
std::string BlockReader::quoted(std::string first)
{
    const auto isClosed = [&first]
    {
        const std::size_t size = first.size();
        return size > 1 && first.back() == '"' && first[size - 2] != '\\';
    };
    while (!isClosed())
    {
        const std::string more = word();
        if (more.empty()) break;
        first += " " + more;
    }
    return isClosed() ? first.substr(1, first.size() - 2) : first.substr(1);
}

std::string BlockReader::readValue(const std::function<bool(const std::string&)>& continues)
{
    if (_block && _block->element)
    {
        if (countWords(_block->element->attribute) == 0) return {};
        _block->isAttributeRead = true;
        std::string all;
        for (int i = 0; i < countWords(_block->element->attribute); ++i)
            all += (i > 0 ? " " : "") + word();
        return all[0] == '"' && all.size() > 1 ? all.substr(1, all.size() - 2) : all;
    }
    std::string value = word();
    if (value.empty()) return {};
    if (value[0] == '"') return quoted(value);
    if (value == "{" || value == "}" || (_block && _block->names.count(value) > 0))
    {
        _next = value;
        return {};
    }
    if (value.back() == '}')
    {
        _next = "}";
        value.pop_back();
        return value;
    }
    if (!continues) return value;
    std::string further = word();
    const bool isGlued = further.size() > 1 && further.back() == '}';
    if (isGlued) further.pop_back();
    if (continues(value + " " + further))
    {
        if (isGlued) _next = "}";
        return value + " " + further;
    }
    _next = isGlued ? further + "}" : further;
    return value;
}

std::string BlockReader::readText()
{
    if (_block && _block->element && countWords(_block->element->attribute) == 0) return {};
    std::string text;
    readWrappedString(text);
    return text;
}

std::vector<std::string> BlockReader::readWords()
{
    std::vector<std::string> words;
    if (_block && _block->element)
    {
        const XmlElement& element = *_block->element;
        const int count = countWords(element.text) +
                          (_block->isAttributeRead ? 0 : countWords(element.attribute));
        for (int i = 0; i < count; ++i)
            words.push_back(word());
        return words;
    }
    std::string next = word();
    if (next != "{")
    {
        _next = next;
        return words;
    }
    while (!(next = word()).empty() && next != "}" && !_stream.getException())
        words.push_back(next);
    return words;
}

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

/// Returns "star.osgt:12: ", or the known part of it.
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
    if (_block) told += midair::bridge::quoted(_block->object) + ": ";
    tell(told + what, concernsSafety);
}

void BlockReader::tell(std::string told, bool concernsSafety)
{
    told = printable(told);
    if (concernsSafety && _block && silence(_block->object, told + "; nothing is played"))
        told += "; nothing is played until that is right";
    OSG_WARN << "osgMidair: " << told << std::endl;
}

// OSG reads the words that name classes without quotes; other texts are in quotes.
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
        told += "OSG skips \"" + first +
                "\" and the rest of this object: it reads only properties of its own nodes, "
                "in the order in which it writes them";
    else
    {
        std::vector<std::string> known;
        for (const auto& [name, wrapper] :
             osgDB::Registry::instance()->getObjectWrapperManager()->getWrapperMap())
            known.push_back(name);
        told += "unknown class \"" + unknownClass + "\"" +
                midair::base::didYouMean(unknownClass, known) + "; its content is lost";
    }
    tell(told, concernsSafety);
}

void BlockReader::tellUnknown(const std::string& name)
{
    if (name == "UniqueID" && _block->isMisplaced) return; // already reported
    const std::vector<std::string> nearest = midair::base::nearestWords(name, nameList());
    // A name that resembles nothing may be anything, even a limit of a newer kit.
    const bool mayBeSafety =
        nearest.empty() || std::any_of(nearest.begin(),
                                       nearest.end(),
                                       [this](const std::string& one)
                                       { return _block->names.at(one).concernsSafety; });
    complain("unknown property \"" + name + "\"" + midair::base::didYouMean(name, nameList()),
             mayBeSafety);
}

} // namespace osgMidair
