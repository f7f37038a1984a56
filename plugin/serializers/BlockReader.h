#pragma once

#include "plugin/serializers/XmlOutline.h"

#include <osgDB/InputStream>
#include <osgDB/ObjectWrapper>
#include <osgDB/StreamOperator>

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace osgMidair
{

/// A serializer of the kit, with information on the properties that it reads from text.
class NamedSerializer : public osgDB::BaseSerializer
{
public:
    explicit NamedSerializer(std::string name) :
        osgDB::BaseSerializer(READ_WRITE_PROPERTY),
        _name(std::move(name))
    {
    }

    const std::string& getName() const override { return _name; }
    bool write(osgDB::OutputStream& /*out*/, const osg::Object& /*object*/) override
    {
        return true;
    }
    /// Names of the properties; none if it reads nothing by name.
    virtual std::vector<std::string> names() const { return {}; }
    /// True: if its value is missing, more may be played than was asked for.
    virtual bool concernsSafety() const { return false; }

protected:
    const std::string _name;
};

/// Reads the properties of the kit's objects from text (.osgt, .osgx) in any order, and reports
/// unknown ones. OSG asks each serializer once, in order, whether its name comes next, and skips
/// the rest of the object; this reader takes the next name from the file and finds the serializer.
/// If safety may depend on an invalid name or value, the object silences its scene.
///
/// It replaces the stream's iterator and forwards all reading to it. It belongs to its stream, and
/// so to one thread.
class BlockReader : public osgDB::InputIterator
{
public:
    /// Returns the reader of \a in; creates it if necessary.
    static BlockReader& of(osgDB::InputStream& in);

    /// Reads all properties of \a object after its UniqueID.
    void readBlock(osg::Object& object);

    /// Reads the value of the property whose name was just read, without quotes, and a second word
    /// if \a continues says that it belongs to the value ("500", "Pa"). Returns an empty text if
    /// there is none.
    std::string readValue(const std::function<bool(const std::string&)>& continues = nullptr);
    /// Reads a text, with the escapes that OSG writes; empty if there is none.
    std::string readText();
    /// Reads the words in the following brackets; none if there are no brackets.
    std::vector<std::string> readWords();

    /// Reports \a what about the present property, with file and line. \a concernsSafety: the
    /// object silences its scene.
    void complain(const std::string& what, bool concernsSafety);

    bool isBinary() const override { return false; }
    void readBool(bool& b) override { counted().readBool(b); }
    void readChar(char& c) override { counted().readChar(c); }
    void readSChar(signed char& c) override { counted().readSChar(c); }
    void readUChar(unsigned char& c) override { counted().readUChar(c); }
    void readShort(short& s) override { counted().readShort(s); }
    void readUShort(unsigned short& s) override { counted().readUShort(s); }
    void readInt(int& i) override { counted().readInt(i); }
    void readUInt(unsigned int& i) override { counted().readUInt(i); }
    void readLong(long& l) override { counted().readLong(l); }
    void readULong(unsigned long& l) override { counted().readULong(l); }
    void readFloat(float& f) override { counted().readFloat(f); }
    void readDouble(double& d) override { counted().readDouble(d); }
    void readString(std::string& s) override;
    void readStream(std::istream& (*fn)(std::istream&)) override { _inner->readStream(fn); }
    void readBase(std::ios_base& (*fn)(std::ios_base&)) override { _inner->readBase(fn); }
    void readGLenum(osgDB::ObjectGLenum& value) override { counted().readGLenum(value); }
    void readProperty(osgDB::ObjectProperty& property) override
    {
        counted().readProperty(property);
    }
    void readMark(osgDB::ObjectMark& mark) override { _inner->readMark(mark); }
    void readCharArray(char* s, unsigned int size) override { _inner->readCharArray(s, size); }
    void readWrappedString(std::string& str) override;
    bool matchString(const std::string& str) override;
    void advanceToCurrentEndBracket() override;

private:
    struct Known
    {
        osgDB::BaseSerializer* serializer;
        bool concernsSafety;
    };
    using Names = std::map<std::string, Known>;

    /// The object being read, and its present property.
    struct Block
    {
        osg::Object& object;
        Names names;
        std::set<std::string> seen;
        std::streamoff place = 0;            ///< of the property in the stream, bytes
        const XmlElement* element = nullptr; ///< the property in XML
        bool isAttributeRead = false;        ///< in XML: what follows is its text
        bool isMisplaced = false;            ///< the UniqueID isn't its first property
    };

    BlockReader(osgDB::InputStream& in, osgDB::InputIterator& inner);
    ~BlockReader() override = default;

    static Names namesOf(const osg::Object& object);
    std::vector<std::string> nameList() const;
    void readPlain();
    void readXml(const std::vector<XmlElement>& elements);
    void readNamed(const std::string& name);
    void tellUnknown(const std::string& name);
    std::string skipValue(const std::string& name);
    std::string word();
    osgDB::InputIterator& counted()
    {
        ++_words;
        return *_inner;
    }
    std::string quoted(std::string first);
    void skipRest();
    void tellSkipped(const std::string& first,
                     std::streamoff place,
                     const std::string& unknownClass,
                     bool concernsSafety);
    static bool isUnknownClass(const std::string& word);
    const std::string& text();
    std::string place();
    std::string placeIn(std::ptrdiff_t line);
    std::ptrdiff_t lineAt(std::streamoff place);
    void tell(std::string told, bool concernsSafety);

    osgDB::InputStream& _stream;
    const osg::ref_ptr<osgDB::InputIterator> _inner;
    Block* _block = nullptr;
    std::string _next;         ///< word read ahead; empty: none
    bool _ended = false;       ///< the object's end was read ahead of OSG
    std::string _unknownClass; ///< class name of an unknown object; empty: known
    std::string _text;         ///< of the file, once needed
    bool _isXml = false;
    int _words = 0; ///< read so far
    /// In XML, the word count at which the present property ends; beyond it OSG would take words of
    /// the next one, because it doesn't see where an object ends.
    int _lastWord = 0;
    /// of an XML file, once needed
    std::optional<std::map<unsigned int, std::vector<XmlElement>>> _objects;
};

} // namespace osgMidair
