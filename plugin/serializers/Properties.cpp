// The beginning of each of the kit's objects in files.
#include "haptics/base/text/Number.h"
#include "plugin/serializers/BlockReader.h"
#include "plugin/serializers/Wrappers.h"

#include <osgDB/InputStream>
#include <osgDB/ObjectWrapper>
#include <osgDB/OutputStream>

#include <algorithm>
#include <ios>
#include <streambuf>
#include <string>
#include <vector>

namespace osgMidair
{

namespace
{

constexpr int kVersion = 1;
/// Added to the version in .osgb, "MH" in the file: files from before 0.1.0 have no such number
/// there.
constexpr int kMark = 0x484D0000;

/// Endless zeros, which OSG's reader takes for empty texts and lists. Stateless, so that all
/// threads share one.
class Zeros : public std::streambuf
{
protected:
    int_type underflow() override { return 0; }
    int_type uflow() override { return 0; }
    std::streamsize xsgetn(char* to, std::streamsize count) override
    {
        std::fill_n(to, count, '\0');
        return count;
    }
    pos_type seekoff(off_type, std::ios::seekdir, std::ios::openmode) override { return {0}; }
    pos_type seekpos(pos_type, std::ios::openmode) override { return {0}; }
};

/// Ends the stream after an exception: OSG's reader would go on, take any bytes for lengths of
/// texts, and report the last error.
struct EndedStream : osgDB::InputStream
{
    static void end(osgDB::InputStream& in)
    {
        static auto* const zeros = new Zeros;
        (in.*(&EndedStream::_in))->getStream()->rdbuf(zeros);
    }
};

/// Serializer without a property of its own: it reads all properties from text.
class Properties : public NamedSerializer
{
public:
    Properties() : NamedSerializer("Properties") {}

    bool read(osgDB::InputStream& in, osg::Object& object) override
    {
        if (!in.isBinary()) BlockReader::of(in).readBlock(object);
        return true;
    }
};

/// Serializer of the file format's version. In .osgb properties are found by position, so nothing
/// of another version is read. A text with another version silences its scene; one without a
/// version has this one.
class FormatVersion : public NamedSerializer
{
public:
    FormatVersion() : NamedSerializer("FormatVersion") {}

    std::vector<std::string> names() const override { return {getName()}; }
    bool concernsSafety() const override { return true; }

    bool read(osgDB::InputStream& in, osg::Object& object) override
    {
        int version = 0;
        if (in.isBinary())
        {
            in >> version;
            const bool isMarked = (version & ~0xFFFF) == kMark;
            if (version == kMark + kVersion) return true;
            const std::string told =
                "osgMidair: " + std::string(object.className()) + ": " +
                problemOf(isMarked ? std::to_string(version - kMark) : "none") +
                "; the file is not read";
            EndedStream::end(in);
            in.throwException(told);
            return false;
        }
        if (!in.matchString(getName())) return true;
        BlockReader& reader = BlockReader::of(in);
        const std::string text = reader.readValue();
        if (!midair::base::parseWhole(text, version) || version != kVersion)
            reader.complain(problemOf(text), true);
        return true;
    }

    bool write(osgDB::OutputStream& out, const osg::Object&) override
    {
        if (out.isBinary())
            out << kMark + kVersion;
        else
            out << out.PROPERTY(getName().c_str()) << kVersion << std::endl;
        return true;
    }

private:
    std::string problemOf(const std::string& version) const
    {
        return getName() + " is \"" + version + "\", should be " + std::to_string(kVersion) +
               ", the only one that this kit reads";
    }
};

} // namespace

// It precedes all other classes in the associates of the kit's classes, so that it is read first.
void registerProperties()
{
    static const osgDB::RegisterWrapperProxy proxy(
        []() -> osg::Object* { return nullptr; },
        "osgMidair::Properties",
        "osgMidair::Properties",
        [](osgDB::ObjectWrapper* wrapper)
        { wrapper->addSerializer(new Properties, osgDB::BaseSerializer::RW_USER); });
}

void addFormatVersion(osgDB::ObjectWrapper& wrapper)
{
    wrapper.addSerializer(new FormatVersion, osgDB::BaseSerializer::RW_INT);
}

} // namespace osgMidair
